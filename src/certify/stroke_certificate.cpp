#include "certify/stroke_certificate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "flow/path_jacobian.h"
#include "flow/segment_mover.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/box_tree.h"

namespace knead::session_detail {

namespace {

// Relative to the length: the error of carrying points back, far below any distance that matters, and the distance up
// to which only the triangles around a point are looked at.
constexpr double kBackTolerance = 1e-8;
constexpr double kNear = 1e-3;
// Distance between places whose origins give a gradient: far above the error, far below what bends a flow.
constexpr double kNeighbour = 1e-5;

// Path lines whose drift is looked at, of a stroke with few segments and with many.
constexpr std::size_t kMaxDrifts = 256;
constexpr std::size_t kFewestDrifts = 32;
constexpr std::size_t kDriftSegments = 8192;  // path lines times segments

constexpr std::size_t kGrain = 256;

bool has_limit_cylinder(const Flow& flow) {
  return std::any_of(flow.segments.begin(), flow.segments.end(), [](const Segment& segment) {
    return segment.limit_cylinder || detail::has_limit_cylinders(segment);
  });
}

// Of a point that is known to move, the flow without its limit cylinder is the same. The limit cylinders of a sum stay:
// they say which of its parts move a point.
Flow for_members(Flow flow) {
  for (Segment& segment : flow.segments) segment.limit_cylinder.reset();
  return flow;
}

// Where a vertex of the shape after was before; null: it is new.
const Vec3d* source_of(const AppliedStroke& stroke, std::size_t vertex) {
  if (stroke.remeshed == nullptr) return &stroke.before.positions()[vertex];
  const std::uint32_t source = stroke.remeshed->vertex_source[vertex];
  return source == kNewVertex ? nullptr : &stroke.before.positions()[source];
}

// For each vertex of the shape after: whether the flow moves the surface there.
std::vector<bool> moved_vertices(const AppliedStroke& stroke) {
  if (stroke.remeshed != nullptr) return stroke.remeshed->moved;
  std::vector<bool> moved(stroke.after.positions().size());
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = stroke.after.positions()[i] != stroke.before.positions()[i];
  return moved;
}

// The length of the longest edge at each of these vertices.
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

// Backwards a limit cylinder says nothing of where its points are: it is about where they came from.
double motion_outside(const AppliedStroke& stroke, bool inverse) {
  const FlowReach reach(inverse ? for_members(detail::each_part(stroke.flow)) : stroke.flow);
  const std::vector<Vec3d>& before = stroke.before.positions();
  std::vector<std::pair<std::size_t, double>> moved;  // vertices before, and how far
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
    if (!reach.may_move(before[vertex], longest[vertex])) greatest = std::max(greatest, distance);
  }
  return greatest;
}

// det J - 1 at vertices that the stroke moves.
std::vector<double> drifts_of(const AppliedStroke& stroke, const std::vector<bool>& moved, const ReplayOptions& options,
                              double length) {
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Vec3d* const source = moved[i] ? source_of(stroke, i) : nullptr;
    if (source != nullptr) points.push_back(*source);
  }
  const std::size_t most =
      std::clamp(kDriftSegments / std::max<std::size_t>(stroke.flow.segments.size(), 1), kFewestDrifts, kMaxDrifts);
  const std::size_t count = std::min(points.size(), most);
  AdvectOptions integration;
  integration.tolerance = advect_options(options.motion, length).tolerance;
  integration.integrator = options.motion.integrator;
  const Flow flow = for_members(stroke.flow);
  integration.threads = options.motion.threads;
  integration.progress = options.progress;
  std::vector<Vec3d> sample;
  for (std::size_t i = 0; i < count; ++i) sample.push_back(points[i * points.size() / count]);
  std::vector<double> drifts = volume_drifts(flow, sample, integration);
  std::erase_if(drifts, [](double drift) { return !std::isfinite(drift); });
  return drifts;
}

void add_drift(const AppliedStroke& stroke, const std::vector<double>& drifts, StrokeCertificate& certificate) {
  if (drifts.empty()) return;
  const std::vector<Segment>& segments = stroke.flow.segments;
  if (std::any_of(segments.begin(), segments.end(), changes_volume)) {
    const auto [least, greatest] = std::minmax_element(drifts.begin(), drifts.end());
    certificate.det_least = 1 + *least;
    certificate.det_greatest = 1 + *greatest;
    return;
  }
  certificate.drift = std::accumulate(drifts.begin(), drifts.end(), 0.0) / static_cast<double>(drifts.size());
}

std::array<Vec3d, 3> corners_of(const Triangle& t, std::span<const Vec3d> positions) {
  return {positions[t[0]], positions[t[1]], positions[t[2]]};
}

// A box with all that is as near to it as this, whatever the rounding.
Box widened(Box box, double distance) {
  const double margin = distance + 1e-9 * (distance + box.diagonal() + norm(box.min));
  box.min -= Vec3d{margin, margin, margin};
  box.max += Vec3d{margin, margin, margin};
  return box;
}

// Of each face the number of its first triangle; of a face without triangles that of any other.
std::vector<std::uint32_t> first_triangles(const DeformedShape& shape) {
  std::vector<std::uint32_t> first(shape.mesh().face_count());
  std::size_t next = 0;
  for (std::size_t f = 0; f < first.size(); ++f) {
    first[f] = static_cast<std::uint32_t>(std::min(next, shape.triangles().size() - 1));
    next += std::max<std::size_t>(shape.mesh().face(f).size(), 2) - 2;
  }
  return first;
}

// Vertices and then centres of faces, which of them are known to have moved, and for each a triangle of the shape
// before that is near where it came from.
struct Probes {
  std::vector<Vec3d> points;
  std::vector<bool> moved;
  std::vector<std::uint32_t> triangles;
};

Probes probes_of(const AppliedStroke& stroke, const std::vector<bool>& moved) {
  const DeformedShape& after = stroke.after;
  Probes probes{after.positions(), moved, std::vector<std::uint32_t>(moved.size())};
  const std::vector<std::uint32_t> first = first_triangles(stroke.before);
  for (std::uint32_t f = 0; f < after.mesh().face_count(); ++f) {
    const std::span<const std::uint32_t> face = after.mesh().face(f);
    if (face.empty()) continue;
    const std::uint32_t source = first[stroke.remeshed == nullptr ? f : stroke.remeshed->face_source[f]];
    for (const std::uint32_t v : face) probes.triangles[v] = source;
    Vec3d sum{};
    bool any_moved = false;
    for (const std::uint32_t v : face) {
      sum += after.positions()[v];
      any_moved = any_moved || moved[v];
    }
    probes.points.push_back(sum / static_cast<double>(face.size()));
    probes.moved.push_back(any_moved);
    probes.triangles.push_back(source);
  }
  return probes;
}

// Points after a stroke, where they came from, and a triangle of the shape before near that.
struct InverseImage {
  std::vector<Vec3d> there;
  std::vector<Vec3d> back;
  std::vector<std::uint32_t> triangles;
};

void carry_back(const AppliedStroke& stroke, const ReplayOptions& options, double length, std::vector<Vec3d>& points) {
  AdvectOptions back;
  back.tolerance = kBackTolerance * length;
  back.precision = Precision::float64;
  back.threads = options.motion.threads;
  back.progress = options.progress;
  const AdvectStatus status = advect(inverse(for_members(stroke.flow)), points, back).status;
  if (status == AdvectStatus::cancelled) throw Cancelled();
  if (status != AdvectStatus::done) {
    throw InvalidInput(
        "the certificate cannot be made because a path line runs to infinity backwards; leave --check out");
  }
}

// For each probe, whether it is known to have moved or the flow backwards might move it; by groups of neighbours in the
// list, which mostly are neighbours in space. With a limit cylinder only those known to have moved: which others might
// have, the inverse does not tell.
std::vector<bool> worth_carrying(const AppliedStroke& stroke, const Probes& probes) {
  std::vector<bool> worth = probes.moved;
  if (has_limit_cylinder(stroke.flow)) return worth;
  const FlowReach reach(inverse(stroke.flow));
  constexpr std::size_t kGroup = 64;
  for (std::size_t begin = 0; begin < worth.size(); begin += kGroup) {
    const std::size_t end = std::min(begin + kGroup, worth.size());
    const Box box = bounding_box(std::span(probes.points).subspan(begin, end - begin));
    if (reach.may_move(box.center(), 0.5 * box.diagonal() * (1 + 1e-9))) {
      std::fill(worth.begin() + static_cast<std::ptrdiff_t>(begin), worth.begin() + static_cast<std::ptrdiff_t>(end),
                true);
    }
  }
  return worth;
}

// The probes that moved.
InverseImage carried_back(const AppliedStroke& stroke, const Probes& probes, const ReplayOptions& options,
                          double length) {
  const std::vector<bool> worth = worth_carrying(stroke, probes);
  InverseImage all;
  std::vector<bool> moved;
  for (std::size_t i = 0; i < probes.points.size(); ++i) {
    if (!worth[i]) continue;
    all.there.push_back(probes.points[i]);
    all.triangles.push_back(probes.triangles[i]);
    moved.push_back(probes.moved[i]);
  }
  all.back = all.there;
  carry_back(stroke, options, length, all.back);
  InverseImage result;
  for (std::size_t i = 0; i < all.back.size(); ++i) {
    if (!moved[i] && all.back[i] == all.there[i]) continue;
    result.there.push_back(all.there[i]);
    result.back.push_back(all.back[i]);
    result.triangles.push_back(all.triangles[i]);
  }
  return result;
}

// The numbers of the triangles that come as near to the points as this, or nearer, and of some more.
std::vector<std::uint32_t> triangles_near(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                          const std::vector<Vec3d>& points, double distance) {
  const Box box = widened(bounding_box(points), distance);
  std::vector<std::uint32_t> near;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (overlap(bounding_box(corners_of(triangles[t], positions)), box)) near.push_back(t);
  }
  return near;
}

// From each point carried back to the nearest of the surface before. Most are so near to the triangle that is known
// that few others can be nearer; for the rest all of the surface is searched.
std::vector<Vec3d> offsets_to_surface(const AppliedStroke& stroke, const InverseImage& points,
                                      const ReplayOptions& options, double length) {
  const std::span<const Triangle> triangles = stroke.before.triangles();
  const std::vector<Vec3d>& positions = stroke.before.positions();
  const double near = kNear * length;
  const BoxTree tree(triangles, positions, triangles_near(triangles, positions, points.back, near),
                     options.motion.threads);
  std::vector<Vec3d> offsets(points.back.size());
  std::vector<std::uint8_t> is_far(points.back.size());
  const auto for_each_point = [&](const auto& visit) {
    parallel_for(offsets.size(), kGrain, options.motion.threads, [&](std::size_t begin, std::size_t end) {
      stop_if_cancelled(options.progress);
      for (std::size_t i = begin; i < end; ++i) visit(i, points.back[i]);
    });
  };
  for_each_point([&](std::size_t i, const Vec3d& p) {
    NearTriangle best = nearest_on_triangle(corners_of(triangles[points.triangles[i]], positions), p);
    std::uint32_t number = points.triangles[i];
    is_far[i] = best.distance2 > near * near ? 1 : 0;
    if (is_far[i] != 0) return;
    const Box box = widened(bounding_box(std::array{p}), std::sqrt(best.distance2));
    tree.for_each_overlap_with(tree.box_of({box.min, box.max, box.max}), [&](std::uint32_t t) {
      const NearTriangle found = nearest_on_triangle(corners_of(triangles[t], positions), p);
      if (std::pair(std::sqrt(found.distance2), t) < std::pair(std::sqrt(best.distance2), number)) {
        best = found;
        number = t;
      }
      return true;
    });
    offsets[i] = best.point - p;
  });
  if (std::find(is_far.begin(), is_far.end(), 1) == is_far.end()) return offsets;
  const SurfaceTree whole(triangles, positions);
  for_each_point([&](std::size_t i, const Vec3d& p) {
    if (is_far[i] != 0) offsets[i] = whole.closest(p)->point - p;
  });
  return offsets;
}

// The distances after the stroke that follow from these offsets before it: g / |grad g|, the gradient by where
// neighbours came from.
std::vector<double> distances_after(const AppliedStroke& stroke, const InverseImage& points,
                                    const std::vector<Vec3d>& offsets, const ReplayOptions& options, double length) {
  const double reach = kNeighbour * length;
  std::vector<Vec3d> neighbours;
  for (const Vec3d& p : points.there) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      neighbours.push_back(p);
      neighbours.back()[axis] += reach;
    }
  }
  carry_back(stroke, options, length, neighbours);
  std::vector<double> distances(offsets.size());
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const double g = norm(offsets[i]);
    if (!(g > 0)) continue;
    Vec3d gradient;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gradient[axis] = dot(offsets[i], neighbours[3 * i + axis] - points.back[i]) / (g * reach);
    }
    distances[i] = norm(gradient) > 0 ? g / norm(gradient) : g;
  }
  return distances;
}

StrokeDistance distance_of(const AppliedStroke& stroke, const std::vector<bool>& moved, const ReplayOptions& options,
                           double length) {
  StrokeDistance result;
  result.line = stroke.line;
  if (stroke.before.triangles().empty()) return result;
  const InverseImage points = carried_back(stroke, probes_of(stroke, moved), options, length);
  result.points = points.back.size();
  if (points.back.empty()) return result;
  const std::vector<Vec3d> offsets = offsets_to_surface(stroke, points, options, length);
  const std::vector<double> after = distances_after(stroke, points, offsets, options, length);
  double squares = 0;
  double back_squares = 0;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    squares += after[i] * after[i];
    back_squares += norm2(offsets[i]);
    result.max = std::max(result.max, after[i] / length);
    result.back_max = std::max(result.back_max, norm(offsets[i]) / length);
  }
  const auto count = static_cast<double>(offsets.size());
  result.rms = std::sqrt(squares / count) / length;
  result.back_rms = std::sqrt(back_squares / count) / length;
  return result;
}

// A vertex that no dab holds at the beginning never moves.
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

}  // namespace

StrokeCertificate certify(const AppliedStroke& stroke, const ReplayOptions& options, double length) {
  if (stroke.relax != nullptr) {
    StrokeCertificate relaxed{0, moved_beside(stroke), {}};
    relaxed.distance.line = stroke.line;
    return relaxed;
  }
  const std::vector<bool> moved = moved_vertices(stroke);
  StrokeCertificate result{0, motion_outside(stroke, options.part.direction == Direction::backwards),
                           distance_of(stroke, moved, options, length)};
  add_drift(stroke, drifts_of(stroke, moved, options, length), result);
  return result;
}

std::size_t opposing_more(const Mesh& before, const Mesh& after) {
  // Triangles without area oppose nothing, so that with all vertices in one place every other one counts as turned.
  const std::vector<Vec3d> none_before(before.vertex_count());
  const std::vector<Vec3d> none_after(after.vertex_count());
  const std::size_t first = count_flipped(before, none_before, before.positions);
  const std::size_t last = count_flipped(after, none_after, after.positions);
  return last > first ? last - first : 0;
}

}  // namespace knead::session_detail
