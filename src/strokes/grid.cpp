// The tool "grid": the flow of a potential on a grid, as poses become it.
#include <fmt/format.h>

#include <optional>
#include <vector>

#include "field/grid.h"
#include "knead/error.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

std::vector<StrokeKey> keys(GridStroke& s) {
  return {{"origin", Quantity::finite, &s.grid.origin},
          {"spacing", Quantity::positive, &s.grid.spacing},
          {"counts", Quantity::other, &s.grid.counts},
          {"coefficients", Quantity::other, &s.grid.coefficients},
          {"end_coefficients", Quantity::other, &s.grid.end_coefficients, Presence::optional},
          {"growth", Quantity::other, &s.grid.growth, Presence::optional}};
}

void require_coefficients(std::string_view key, const SharedVectors& coefficients, std::size_t nodes) {
  if (coefficients.size() != nodes) {
    throw InvalidInput(
        fmt::format("\"{}\" must hold three numbers for each of the {} nodes that \"counts\" gives, got {}", key, nodes,
                    3 * coefficients.size()));
  }
  for (const Vec3d& coefficient : coefficients) require_finite(key, coefficient);
}

void validate(const GridStroke& stroke) {
  const auto& [nx, ny, nz] = stroke.grid.counts;
  const std::optional<std::size_t> nodes = detail::node_count(stroke.grid.counts);
  if (!nodes) {
    throw InvalidInput(fmt::format(
        "\"counts\" must be three whole numbers of at least 1, of at most 16 million nodes together, got [{}, {}, {}]",
        nx, ny, nz));
  }
  require_coefficients("coefficients", stroke.grid.coefficients, *nodes);
  if (!stroke.grid.end_coefficients.empty()) {
    require_coefficients("end_coefficients", stroke.grid.end_coefficients, *nodes);
  }
  const SharedNumbers& growth = stroke.grid.growth;
  if (!growth.empty() && growth.size() != *nodes) {
    throw InvalidInput(
        fmt::format("\"growth\" must hold one number for each of the {} nodes that \"counts\" gives, got {}", *nodes,
                    growth.size()));
  }
  for (const double g : growth) require_finite("growth", g);
}

Flow flow_of(const GridStroke& stroke) {
  Segment segment;
  segment.grid = stroke.grid;
  return {{std::move(segment)}};
}

// The flow of v over the time `strength` is that of strength v over the unit of time.
void prolong(GridStroke& stroke, double strength) { stroke.grid = multiplied(std::move(stroke.grid), strength); }

std::string words(const GridStroke& /*stroke*/, const std::string& /*unit*/) { return "Pose"; }

// The coefficients of the mirror image, changed by `image`, in the order of its nodes.
template <class T, class OfImage>
SharedList<T> flipped(const SharedList<T>& coefficients, const std::array<int, 3>& counts, const Vec3d& signs,
                      const OfImage& image) {
  if (coefficients.empty()) return {};
  const auto at = [&](std::size_t axis, int i) {
    return static_cast<std::size_t>(signs[axis] < 0 ? counts[axis] - 1 - i : i);
  };
  const auto [nx, ny, nz] = counts;
  std::vector<T> list;
  list.reserve(coefficients.size());
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const std::size_t row = at(1, y) + static_cast<std::size_t>(ny) * at(2, z);
        list.push_back(image(coefficients[at(0, x) + static_cast<std::size_t>(nx) * row]));
      }
    }
  }
  return SharedList<T>(std::move(list));
}

void move(GridStroke& stroke, const std::optional<Vec3d>& signs, const PlaceMap& place) {
  PotentialGrid& grid = stroke.grid;
  if (!signs) throw InvalidInput("a grid cannot be turned, only moved and mirrored along its axes");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if ((*signs)[axis] < 0) grid.origin[axis] += (grid.counts[axis] - 1) * grid.spacing;
  }
  grid.origin = place(grid.origin);
  if (*signs == Vec3d{1, 1, 1}) return;
  const Vec3d by = *signs * (signs->x * signs->y * signs->z);  // of a pseudovector
  const auto vector = [&](const Vec3d& a) { return Vec3d{a.x * by.x, a.y * by.y, a.z * by.z}; };
  grid.coefficients = flipped(grid.coefficients, grid.counts, *signs, vector);
  grid.end_coefficients = flipped(grid.end_coefficients, grid.counts, *signs, vector);
  grid.growth = flipped(grid.growth, grid.counts, *signs, [](double g) { return g; });
}

}  // namespace

constinit const detail::ToolRow<GridStroke> GridStroke::tool{.name = "grid",
                                                             .keys = keys,
                                                             .validate = validate,
                                                             .flow = flow_of,
                                                             .words = words,
                                                             .prolong = prolong,
                                                             .move = move};

}  // namespace knead
