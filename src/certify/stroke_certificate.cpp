// Certifies one stroke: the drift of volume along path lines, motion outside of the flow, and triangles that turn over.
#include "certify/stroke_certificate.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "flow/path_jacobian.h"
#include "flow/segment_mover.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/edges.h"

namespace knead::detail {

namespace {

// The number of path lines whose drift is measured: kDriftSegments divided by the segments, within these bounds.
constexpr std::size_t kMaxDrifts = 256;
constexpr std::size_t kMinDrifts = 32;
constexpr std::size_t kDriftSegments = 8192;

// Returns the position before of a vertex of the shape after; null for a new vertex.
const Vec3d* source_of(const AppliedStroke& stroke, std::size_t vertex) {
  if (stroke.remeshed == nullptr) return &stroke.before.positions()[vertex];
  const std::uint32_t source = stroke.remeshed->vertex_source[vertex];
  return source == kNewVertex ? nullptr : &stroke.before.positions()[source];
}

// Returns a flag for each vertex of the shape after: the flow moves the surface there.
std::vector<bool> moved_vertices(const AppliedStroke& stroke) {
  if (stroke.remeshed != nullptr) return stroke.remeshed->moved;
  std::vector<bool> moved(stroke.after.positions().size());
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = stroke.after.positions()[i] != stroke.before.positions()[i];
  return moved;
}

// Returns the length of the longest edge at each of these vertices.
std::vector<double> longest_edges(const DeformedShape& shape, const std::vector<bool>& vertices) {
  std::vector<double> longest(shape.positions().size(), 0.0);
  for (std::size_t f = 0; f < shape.mesh().face_count(); ++f) {
    const std::span<const std::uint32_t> face = shape.mesh().face(f);
    if (std::none_of(face.begin(), face.end(), [&](std::uint32_t v) { return vertices[v]; })) continue;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::uint32_t a = face[i];
      const std::uint32_t b = face[(i + 1) % face.size()];
      const double length = norm(shape.positions()[a] - shape.positions()[b]);
      longest[a] = std::max(longest[a], length);
      longest[b] = std::max(longest[b], length);
    }
  }
  return longest;
}

// For an inverse stroke, limit cylinders are dropped: they limit the positions from which points came, not those where
// they are now.
double motion_outside(const AppliedStroke& stroke, bool inverse) {
  const FlowSupport support(inverse ? for_members(detail::each_part(stroke.flow)) : stroke.flow);
  const std::vector<Vec3d>& before = stroke.before.positions();
  std::vector<std::pair<std::size_t, double>> moved;  // vertices before, and their displacement
  std::vector<bool> is_moved(before.size());
  for (std::size_t i = 0; i < stroke.after.positions().size(); ++i) {
    const Vec3d* const source = source_of(stroke, i);
    if (source == nullptr || *source == stroke.after.positions()[i]) continue;
    moved.emplace_back(source - before.data(), norm(stroke.after.positions()[i] - *source));
    is_moved[moved.back().first] = true;
  }
  const std::vector<double> longest = longest_edges(stroke.before, is_moved);
  double greatest = 0;
  for (const auto& [vertex, distance] : moved) {
    if (!support.may_move(before[vertex], longest[vertex])) greatest = std::max(greatest, distance);
  }
  return greatest;
}

bool changes_volume_on_purpose(const AppliedStroke& stroke) {
  return std::any_of(stroke.flow.segments.begin(), stroke.flow.segments.end(),
                     [](const Segment& segment) { return changes_volume(segment); });
}

// Returns the inverse images of moved vertices that are new, of at most `count`, evenly chosen.
std::vector<Vec3d> sources_of_new(const AppliedStroke& stroke, const std::vector<bool>& moved, std::size_t count,
                                  const AdvectOptions& integration) {
  std::vector<Vec3d> places;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (moved[i] && source_of(stroke, i) == nullptr) places.push_back(stroke.after.positions()[i]);
  }
  const std::size_t all = places.size();
  for (std::size_t i = 0; i < std::min(count, all); ++i) places[i] = places[i * all / std::min(count, all)];
  places.resize(std::min(count, all));
  if (advect(inverse(for_members(stroke.flow)), places, integration).status != AdvectStatus::done) return {};
  return places;
}

// Returns det J - 1 at vertices that the stroke moves.
std::vector<double> drifts_of(const AppliedStroke& stroke, const std::vector<bool>& moved, const ReplayOptions& options,
                              double length) {
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Vec3d* const source = moved[i] ? source_of(stroke, i) : nullptr;
    if (source != nullptr) points.push_back(*source);
  }
  const std::size_t wanted =
      std::clamp(kDriftSegments / std::max<std::size_t>(stroke.flow.segments.size(), 1), kMinDrifts, kMaxDrifts);
  AdvectOptions integration;
  integration.tolerance = advect_options(options.motion, length).tolerance;
  integration.integrator = options.motion.integrator;
  const Flow flow = for_members(stroke.flow);
  integration.threads = options.motion.threads;
  integration.progress = options.progress;
  // Of coarse faces the new vertices show what is between the corners.
  if (changes_volume_on_purpose(stroke) && points.size() < wanted) {
    const std::vector<Vec3d> more = sources_of_new(stroke, moved, wanted - points.size(), integration);
    points.insert(points.end(), more.begin(), more.end());
  }
  const std::size_t count = std::min(points.size(), wanted);
  std::vector<Vec3d> sample;
  for (std::size_t i = 0; i < count; ++i) sample.push_back(points[i * points.size() / count]);
  std::vector<double> drifts = volume_drifts(flow, sample, integration);
  std::erase_if(drifts, [](double drift) { return !std::isfinite(drift); });
  return drifts;
}

void add_drift(const AppliedStroke& stroke, const std::vector<double>& drifts, StrokeCertificate& certificate) {
  if (drifts.empty()) return;
  if (changes_volume_on_purpose(stroke)) {
    const auto [least, greatest] = std::minmax_element(drifts.begin(), drifts.end());
    certificate.det_least = 1 + *least;
    certificate.det_greatest = 1 + *greatest;
    return;
  }
  certificate.drift = std::accumulate(drifts.begin(), drifts.end(), 0.0) / static_cast<double>(drifts.size());
}

// Returns the greatest motion of a vertex of a relax stroke that no dab contains.
double moved_beside(const AppliedStroke& stroke) {
  double greatest = 0;
  for (std::size_t i = 0; i < stroke.after.positions().size(); ++i) {
    const Vec3d& source = stroke.before.positions()[i];
    if (source == stroke.after.positions()[i]) continue;
    const bool is_held = std::any_of(stroke.relax->points.begin(), stroke.relax->points.end(),
                                     [&](const Vec3d& p) { return norm(source - p) <= stroke.relax->radius; });
    if (!is_held) greatest = std::max(greatest, norm(stroke.after.positions()[i] - source));
  }
  return greatest;
}

// Returns how many triangles oppose the normals of their vertices.
std::size_t opposing(const Mesh& mesh) {
  // With all vertices at one point no triangle has an area or opposes its normals, so all that do now count as flipped.
  const std::vector<Vec3d> none(mesh.vertex_count());
  return count_flipped(mesh, none, mesh.positions);
}

// Returns the mesh without the faces at edges of more than two faces.
Mesh without_branches(const Mesh& mesh) {
  std::vector<bool> is_branch(mesh.vertex_count(), false);
  for_each_edge(mesh, [&](std::span<const EdgeUse> edge) {
    if (edge.size() > 2) is_branch[edge[0].low] = is_branch[edge[0].high] = true;
  });
  Mesh result;
  result.positions = mesh.positions;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    if (std::none_of(face.begin(), face.end(), [&](std::uint32_t v) { return is_branch[v]; })) result.add_face(face);
  }
  return result;
}

}  // namespace

Flow for_members(Flow flow) {
  for (Segment& segment : flow.segments) segment.limit_cylinder.reset();
  return flow;
}

StrokeCertificate certify(const AppliedStroke& stroke, const ReplayOptions& options, double length,
                          std::size_t max_points) {
  if (stroke.relax != nullptr) {
    StrokeCertificate relaxed{0, moved_beside(stroke), {}};
    relaxed.distance.line = stroke.line;
    return relaxed;
  }
  const std::vector<bool> moved = moved_vertices(stroke);
  StrokeCertificate result{0, motion_outside(stroke, options.part.direction == Direction::backwards),
                           distance_of(stroke, moved, options, length, max_points)};
  add_drift(stroke, drifts_of(stroke, moved, options, length), result);
  return result;
}

std::size_t opposing_more(const Mesh& before, const Mesh& after) {
  const auto more = [](const Mesh& first, const Mesh& last) {
    const std::size_t count = opposing(last);
    return count - (count > 0 ? std::min(count, opposing(first)) : 0);  // mostly there are none
  };
  return more(before, after) == 0 ? 0 : more(without_branches(before), without_branches(after));
}

}  // namespace knead::detail
