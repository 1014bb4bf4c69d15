// The limits of a refinement on vertices and work.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "knead/remesh/refine.h"

namespace knead::remesh_detail {

namespace {

constexpr double kEstimateSlack = 4;    // the estimate may be so many times too high where edges bend at one place only
constexpr double kFigureShare = 0.2;    // of the room: what the estimate may fill with the settings of a message
constexpr double kFigureFactor = 4;     // the estimate grows while edges are split
constexpr double kPointsPerVertex = 4;  // a split makes so many edges, whose middles are then carried
constexpr double kFigureStep = 2;
constexpr int kMostSteps = 60;

}  // namespace

double Refinement::points_left() const {
  return deformation_.points_left ? deformation_.points_left() : std::numeric_limits<double>::infinity();
}

// Returns how many vertices the surface may have.
double Refinement::room() const {
  const double by_cap = static_cast<double>(targets_.max_vertices) - outside_;
  return std::min(by_cap, static_cast<double>(s_.vertex_count()) + points_left() / kPointsPerVertex);
}

// Returns about how many pieces the edge needs: by the length of its image, and because the deviation of a piece falls
// with the square of their number.
double Refinement::pieces(std::uint32_t e, const Slack& slack) const {
  const std::uint32_t h = s_.halfedge[e];
  const Vec3d half = (s_.after[s_.target(h)] - s_.after[s_.origin(h)]) * 0.5;
  const double length = norm(half + deviation_[e]) + norm(half - deviation_[e]);
  const double by_length = length / (targets_.max_edge * slack.edge);
  const double by_chord = std::sqrt(norm(deviation_[e]) / (targets_.max_chord * slack.chord));
  const double most = std::min(length, std::sqrt(length2(e, s_.before))) / shortest_;
  return std::max(1.0, std::min(std::max(by_length, by_chord), most));
}

// Returns about how many vertices the surface has when these edges, and the faces at them, are in pieces.
double Refinement::estimate(std::span<const std::uint32_t> edges, const Slack& slack) const {
  std::vector<double> count(s_.halfedge.size(), 1);
  double vertices = static_cast<double>(s_.vertex_count());
  for (const std::uint32_t e : edges) {
    count[e] = pieces(e, slack);
    vertices += count[e] - 1;
  }
  for (std::size_t f = 0; f < s_.face_count(); ++f) {
    std::array<double, 3> at{count[s_.edge[3 * f]], count[s_.edge[3 * f + 1]], count[s_.edge[3 * f + 2]]};
    std::sort(at.begin(), at.end());
    vertices += (at[0] - 1) * (at[1] - 1) / 2;
  }
  return vertices;
}

// Returns false, or throws RemeshLimit, if the next round or all of them would exceed the limits.
bool Refinement::has_room(std::span<const std::uint32_t> marked) {
  const double next = static_cast<double>(s_.vertex_count() + marked.size());
  const double all = estimate(marked, {});
  if (next <= room() && all <= kEstimateSlack * room()) return true;
  if (may_refuse_) refuse(marked, std::max(next, all));
  return false;
}

// Returns the settings with which the estimate is at most `most`, as words.
std::string Refinement::remedy(std::span<const std::uint32_t> edges, double most) const {
  double slack = 1;
  for (int step = 0; step < kMostSteps; ++step) {
    slack *= kFigureStep;
    std::string edge = fmt::format("\"max_edge\" of {:.2g} or more", slack * targets_.max_edge);
    const double longer = slack * slack * targets_.max_chord / targets_.diagonal;
    std::string chord = fmt::format("\"max_chord\" of {:.2g} or more", longer);
    if (estimate(edges, {slack, 1}) <= most) return edge;
    if (longer < 1 && estimate(edges, {1, slack * slack}) <= most) return chord;
    if (longer < 1 && estimate(edges, {slack, slack * slack}) <= most) return fmt::format("{} with {}", edge, chord);
  }
  return {};
}

void Refinement::refuse(std::span<const std::uint32_t> edges, double needed) const {
  const double now = static_cast<double>(s_.vertex_count());
  const bool is_work = static_cast<double>(targets_.max_vertices) - outside_ > room();
  const std::string settings = remedy(edges, std::max(kFigureShare * room(), now + 1));
  double figure = std::max(needed, now + static_cast<double>(edges.size()));
  std::string text = fmt::format("the mesh needs about {:.2g} vertices", outside_ + figure);
  if (!whole_) text += " to follow this stroke";
  if (is_work) {
    const double left = std::max(0.0, points_left());
    figure = static_cast<double>(targets_.max_vertices) * (carried_ + kPointsPerVertex * figure) /
             std::max(1.0, carried_ + left);
    text += fmt::format(", more work than \"max_vertices\" ({}) allows", targets_.max_vertices);
  } else {
    figure += outside_;
    text += fmt::format(", more than \"max_vertices\" ({}) allows", targets_.max_vertices);
  }
  text += settings.empty() ? "; deform less" : "; use a " + settings;
  if (kFigureFactor * figure <= static_cast<double>(kMostVertices)) {
    text += fmt::format(", or \"max_vertices\": {:.0f}", std::ceil(kFigureFactor * figure));
  }
  throw RemeshLimit(text);
}

}  // namespace knead::remesh_detail
