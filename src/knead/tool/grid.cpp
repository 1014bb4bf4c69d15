#include <fmt/format.h>

#include <optional>

#include "knead/field/grid_nodes.h"
#include "knead/math/error.h"
#include "knead/tool/describe.h"

namespace knead {

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(GridStroke& s) {
  return {{"origin", Quantity::finite, &s.grid.origin},
          {"spacing", Quantity::positive, &s.grid.spacing},
          {"counts", Quantity::other, &s.grid.counts},
          {"coefficients", Quantity::other, &s.grid.coefficients},
          {"end_coefficients", Quantity::other, &s.grid.end_coefficients, Presence::optional}};
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
}

Flow flow_of(const GridStroke& stroke) {
  Segment segment;
  segment.grid = stroke.grid;
  return {{std::move(segment)}};
}

void multiply(SharedVectors& coefficients, double factor) {
  if (coefficients.empty()) return;
  std::vector<Vec3d> list(coefficients.begin(), coefficients.end());
  for (Vec3d& coefficient : list) coefficient *= factor;
  coefficients = SharedVectors(std::move(list));
}

// The flow of v over the time `strength` is that of strength v over the unit of time.
void prolong(GridStroke& stroke, double strength) {
  multiply(stroke.grid.coefficients, strength);
  multiply(stroke.grid.end_coefficients, strength);
}

}  // namespace

const Tool& GridStroke::tool() {
  static const Tool kTool = describe<GridStroke>("grid", {keys, validate, flow_of, nullptr, nullptr, nullptr, prolong});
  return kTool;
}

}  // namespace knead
