// The tool "relax": smooths the surface. It is no flow (remesh/relax.h).
#include <fmt/format.h>

#include <algorithm>

#include "knead/error.h"
#include "strokes/describe.h"
#include "strokes/suffix.h"

namespace knead {

namespace {

using namespace detail;

constexpr int kMaxIterations = 100;

std::vector<StrokeKey> keys(RelaxStroke& s) {
  return {{"points", Quantity::finite, &s.points},
          {"radius", Quantity::positive, &s.radius, Presence::required, "everything farther from each point stays"},
          {"amount", Quantity::other, &s.amount, Presence::optional, "how far vertices move towards the smooth shape"},
          {"surface", Quantity::other, &s.surface, Presence::optional,
           "of the amount, across the surface; 0 moves the vertices in the surface only"},
          {"iterations", Quantity::other, &s.iterations, Presence::optional, "at each point"}};
}

void validate(const RelaxStroke& stroke) {
  require_count("points", stroke.points.size(), 1, "points");
  if (!(stroke.amount > 0 && stroke.amount <= 1)) {
    throw InvalidInput(fmt::format("\"amount\" must be greater than 0 and at most 1, got {}", stroke.amount));
  }
  if (!(stroke.surface >= 0 && stroke.surface <= 1)) {
    throw InvalidInput(fmt::format("\"surface\" must be from 0 to 1, got {}", stroke.surface));
  }
  if (stroke.iterations < 1 || stroke.iterations > kMaxIterations) {
    throw InvalidInput(fmt::format("\"iterations\" must be from 1 to {}, got {}", kMaxIterations, stroke.iterations));
  }
}

// More than all of the distance is not smoother.
void prolong(RelaxStroke& stroke, double strength) { stroke.amount = std::min(stroke.amount * strength, 1.0); }

std::string words(const RelaxStroke& stroke, const std::string& /*unit*/) {
  return stroke.points.size() == 1 ? "Smooth, 1 dab" : fmt::format("Smooth, {} dabs", stroke.points.size());
}

using RelaxedPlaces = Growing<RelaxStroke, &RelaxStroke::points>;

// Near one of the last points; with mirror images these are several.
bool continues(const RelaxStroke& last, const RelaxStroke& next) {
  constexpr std::size_t kMaxImages = 256;
  if (next.points.empty() || !RelaxedPlaces::is_alike(last, next)) return false;
  const std::size_t first = last.points.size() - std::min(last.points.size(), kMaxImages);
  return std::any_of(RelaxedPlaces::at(last, first), last.points.end(),
                     [&](const Vec3d& p) { return norm(p - next.points.front()) <= last.radius; });
}

}  // namespace

int relax_iterations(std::size_t vertices_within) {
  constexpr double kPerVertex = 1.5e-3;  // measured on grids with 2,000 to 80,000 vertices within the radius
  return std::clamp(
      static_cast<int>(kPerVertex * static_cast<double>(std::min<std::size_t>(vertices_within, 1'000'000))), 2,
      kMaxIterations);
}

constinit const detail::ToolRow<RelaxStroke> RelaxStroke::tool{.name = "relax",
                                                               .is_flow = false,
                                                               .is_event = true,
                                                               .keys = keys,
                                                               .validate = validate,
                                                               .segments = RelaxedPlaces::segments,
                                                               .words = words,
                                                               .prolong = prolong,
                                                               .grows = RelaxedPlaces::grows,
                                                               .rest = RelaxedPlaces::rest,
                                                               .continues = continues,
                                                               .join = RelaxedPlaces::join,
                                                               .interleaved = RelaxedPlaces::interleaved};

}  // namespace knead
