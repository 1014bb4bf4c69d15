// The distance of a stroke's result from the exact image of the surface before it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "certify/stroke_certificate.h"
#include "flow/segment_mover.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/box_tree.h"

namespace knead::detail {

namespace {

// The tolerance of carrying points back, relative to the length: far below any distance that matters.
constexpr double kBackTolerance = 1e-7;
// The step of finite differences, far below the size at which a flow bends, and the tolerance of carrying these points
// back. The error of an integration step is a small part of the tolerance (kErrorShare in step_rule.h).
constexpr double kDifferenceStep = 1e-5;
constexpr double kNeighbourTolerance = 1e-6;
// The centre of a face gets the mean gradient of the corners if their distance is at most this fraction of the flow's
// smallest feature, and each gradient differs from the mean by at most this fraction. The error is about its square.
constexpr double kMaxFaceFraction = 0.05;
constexpr double kMaxGradientDifference = 0.05;

constexpr std::size_t kProbeGrain = 1024;
constexpr std::size_t kProbeGroup = 64;
constexpr std::uint32_t kNoProbe = std::numeric_limits<std::uint32_t>::max();

bool has_limit_cylinder(const Flow& flow) {
  return std::any_of(flow.segments.begin(), flow.segments.end(), [](const Segment& segment) {
    return segment.limit_cylinder || detail::has_limit_cylinders(segment);
  });
}

// The inputs of the distance of a stroke.
struct Work {
  const AppliedStroke& stroke;
  const ReplayOptions& options;
  double length;
  std::size_t max_points;

  const DeformedShape& before() const { return stroke.before; }
  const DeformedShape& after() const { return stroke.after; }
  std::size_t vertex_count() const { return stroke.after.positions().size(); }

  // Calls visit(begin, end) for parts of a range.
  template <class Visit>
  void in_parts(std::size_t count, const Visit& visit) const {
    parallel_for(count, kProbeGrain, options.motion.threads, [&](std::size_t begin, std::size_t end) {
      stop_if_cancelled(options.progress);
      visit(begin, end);
    });
  }
  template <class Visit>
  void for_each(std::size_t count, const Visit& visit) const {
    in_parts(count, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) visit(i);
    });
  }
};

// Moves points by the inverse of the stroke's flow.
void carry_back(const Work& work, double tolerance, std::span<Vec3d> points) {
  AdvectOptions back;
  back.tolerance = tolerance * work.length;
  back.precision = Precision::float64;
  back.threads = work.options.motion.threads;
  back.progress = work.options.progress;
  const AdvectStatus status = advect(inverse(for_members(work.stroke.flow)), points, back).status;
  if (status == AdvectStatus::cancelled) throw Cancelled();
  if (status != AdvectStatus::done) {
    throw InvalidInput(
        "the certificate cannot be made because a path line runs to infinity backwards; leave --check out");
  }
}

// A vertex after the stroke, or the centre of a face.
struct Probe {
  std::uint32_t number = 0;  // of the vertex; or the number of vertices and that of the face
  bool is_moved = false;     // known to have moved
  Vec3d there;               // its position
  Vec3d back;                // its inverse image
};

std::span<const std::uint32_t> corners_of(const Work& work, const Probe& probe) {
  return work.after().mesh().face(probe.number - work.vertex_count());
}

Probe probe_of(const Work& work, const std::vector<bool>& moved, std::size_t number) {
  const std::vector<Vec3d>& positions = work.after().positions();
  Probe probe{static_cast<std::uint32_t>(number), false, {}, {}};
  if (number < positions.size()) {
    probe.is_moved = moved[number];
    probe.there = positions[number];
    return probe;
  }
  const std::span<const std::uint32_t> face = corners_of(work, probe);
  for (const std::uint32_t v : face) {
    probe.there += positions[v];
    probe.is_moved = probe.is_moved || moved[v];
  }
  probe.there = probe.there / static_cast<double>(face.size());
  return probe;
}

// Returns the probes that are known to have moved or that the inverse flow may move. Decides for groups of neighbours
// in the list, which are mostly neighbours in space. With a limit cylinder, returns only those known to have moved: the
// inverse flow does not show which others may have.
std::vector<Probe> find_probes(const Work& work, const std::vector<bool>& moved) {
  const FlowSupport support(inverse(work.stroke.flow));
  const bool only_moved = has_limit_cylinder(work.stroke.flow);
  const Mesh& mesh = work.after().mesh();
  const std::size_t vertices = work.vertex_count();
  const std::size_t count = vertices + mesh.face_count();
  std::vector<std::vector<Probe>> of_parts((count + kProbeGrain - 1) / kProbeGrain);
  work.in_parts(count, [&](std::size_t begin, std::size_t end) {
    std::vector<Probe>& found = of_parts[begin / kProbeGrain];
    for (std::size_t first = begin; first < end; first += kProbeGroup) {
      const std::size_t size = found.size();
      Box box;
      for (std::size_t i = first; i < std::min(first + kProbeGroup, end); ++i) {
        if (i >= vertices && mesh.face(i - vertices).empty()) continue;
        found.push_back(probe_of(work, moved, i));
        box.extend(found.back().there);
      }
      if (!only_moved && !box.empty() && support.may_move(box.center(), 0.5 * box.diagonal() * (1 + 1e-9))) continue;
      const auto is_not_moved = [](const Probe& probe) { return !probe.is_moved; };
      found.erase(std::remove_if(found.begin() + static_cast<std::ptrdiff_t>(size), found.end(), is_not_moved),
                  found.end());
    }
  });
  std::vector<Probe> probes;
  for (std::vector<Probe>& part : of_parts) {
    probes.insert(probes.end(), part.begin(), part.end());
    part = {};
  }
  if (probes.size() <= work.max_points) return probes;
  std::vector<Probe> chosen;
  for (std::size_t i = 0; i < work.max_points; ++i) chosen.push_back(probes[i * probes.size() / work.max_points]);
  return chosen;
}

// Returns the probes that moved, with their inverse images.
std::vector<Probe> inverse_image(const Work& work, const std::vector<bool>& moved) {
  std::vector<Probe> probes = find_probes(work, moved);
  std::vector<Vec3d> points(probes.size());
  for (std::size_t i = 0; i < probes.size(); ++i) points[i] = probes[i].there;
  carry_back(work, kBackTolerance, points);
  for (std::size_t i = 0; i < probes.size(); ++i) probes[i].back = points[i];
  std::erase_if(probes, [](const Probe& probe) { return !probe.is_moved && probe.back == probe.there; });
  return probes;
}

// Returns for each probe a triangle of the shape before that is near its inverse image.
std::vector<std::uint32_t> source_triangles(const Work& work, const std::vector<Probe>& probes) {
  const Mesh& before = work.before().mesh();
  std::vector<std::uint32_t> first(before.face_count());  // a face without triangles gets that of another face
  std::size_t next = 0;
  for (std::size_t f = 0; f < first.size(); ++f) {
    first[f] = static_cast<std::uint32_t>(std::min(next, work.before().triangles().size() - 1));
    next += std::max<std::size_t>(before.face(f).size(), 2) - 2;
  }
  const Remeshed* const remeshed = work.stroke.remeshed;
  const auto source = [&](std::size_t face) { return first[remeshed == nullptr ? face : remeshed->face_source[face]]; };
  std::vector<std::uint32_t> of_vertex(work.vertex_count());
  for (const Probe& probe : probes) {
    if (probe.number < of_vertex.size()) continue;
    for (const std::uint32_t v : corners_of(work, probe)) of_vertex[v] = source(probe.number - of_vertex.size());
  }
  std::vector<std::uint32_t> triangles(probes.size());
  std::transform(probes.begin(), probes.end(), triangles.begin(), [&](const Probe& probe) {
    return probe.number < of_vertex.size() ? of_vertex[probe.number] : source(probe.number - of_vertex.size());
  });
  return triangles;
}

// Returns the vector from each inverse image to the nearest point of the surface before.
std::vector<Vec3d> offsets_to_surface(const Work& work, const std::vector<Probe>& probes) {
  std::vector<Vec3d> points(probes.size());
  for (std::size_t i = 0; i < probes.size(); ++i) points[i] = probes[i].back;
  std::vector<Vec3d> offsets =
      nearest_points(work.before().triangles(), work.before().positions(), points, source_triangles(work, probes),
                     work.options.motion.threads, work.options.progress);
  for (std::size_t i = 0; i < probes.size(); ++i) offsets[i] -= points[i];
  return offsets;
}

// The derivatives of an inverse image by the coordinates of the point.
using Derivatives = std::array<Vec3d, 3>;

std::vector<Derivatives> derivatives_at(const Work& work, const std::vector<Probe>& probes,
                                        std::span<const std::uint32_t> asked) {
  const double step = kDifferenceStep * work.length;
  std::vector<Vec3d> neighbours(3 * asked.size());
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    neighbours[i] = probes[asked[i / 3]].there;
    neighbours[i][i % 3] += step;
  }
  carry_back(work, kNeighbourTolerance, neighbours);
  std::vector<Derivatives> derivatives(asked.size());
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    derivatives[i / 3][i % 3] = (neighbours[i] - probes[asked[i / 3]].back) / step;
  }
  return derivatives;
}

// Returns grad g after the stroke for an offset in this direction before it.
Vec3d gradient(const Derivatives& derivatives, const Vec3d& direction) {
  return {dot(direction, derivatives[0]), dot(direction, derivatives[1]), dot(direction, derivatives[2])};
}

// Returns true if the face is small enough for its centre to get the mean gradient of the corners.
bool is_small(const Work& work, const Probe& centre, const std::vector<std::uint32_t>& places, double feature) {
  const std::span<const std::uint32_t> corners = corners_of(work, centre);
  return std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
    return places[v] != kNoProbe && norm(work.after().positions()[v] - centre.there) <= kMaxFaceFraction * feature;
  });
}

// Returns the mean of the gradients at the corners of a face; nothing if they differ too much.
std::optional<Vec3d> mean_gradient(std::span<const std::uint32_t> corners, const std::vector<std::uint32_t>& places,
                                   const std::vector<Derivatives>& of_places, const Vec3d& direction) {
  const auto at = [&](std::uint32_t v) { return gradient(of_places[places[v]], direction); };
  Vec3d sum{};
  for (const std::uint32_t v : corners) sum += at(v);
  const Vec3d mean = sum / static_cast<double>(corners.size());
  const double max_difference = kMaxGradientDifference * norm(mean);
  const bool is_alike = std::all_of(corners.begin(), corners.end(),
                                    [&](std::uint32_t v) { return norm(at(v) - mean) <= max_difference; });
  return is_alike ? std::optional(mean) : std::nullopt;
}

// Returns the distances after the stroke that follow from these offsets before it: g / |grad g|.
std::vector<double> distances_after(const Work& work, const std::vector<Probe>& probes,
                                    const std::vector<Vec3d>& offsets) {
  std::vector<std::uint32_t> asked;  // the vertices, which come first
  std::vector<std::uint32_t> places(work.vertex_count(), kNoProbe);
  for (std::uint32_t i = 0; i < probes.size() && probes[i].number < places.size(); ++i) {
    places[probes[i].number] = i;
    asked.push_back(i);
  }
  const std::vector<Derivatives> at_vertices = derivatives_at(work, probes, asked);
  std::vector<double> distances(probes.size());
  const auto set = [&](std::size_t i, const Vec3d& gradient) {
    const double g = norm(offsets[i]);
    distances[i] = norm(gradient) > 0 ? g / norm(gradient) : g;
  };
  const double feature = FlowSupport(work.stroke.flow).smallest_feature();
  std::vector<std::uint8_t> is_left(probes.size());
  work.for_each(probes.size(), [&](std::size_t i) {
    const double g = norm(offsets[i]);
    if (!(g > 0)) return;
    if (i < asked.size()) return set(i, gradient(at_vertices[i], offsets[i] / g));
    std::optional<Vec3d> mean;
    if (is_small(work, probes[i], places, feature)) {
      mean = mean_gradient(corners_of(work, probes[i]), places, at_vertices, offsets[i] / g);
    }
    if (mean) {
      set(i, *mean);
    } else {
      is_left[i] = 1;
    }
  });
  asked.clear();
  for (std::uint32_t i = 0; i < probes.size(); ++i) {
    if (is_left[i] != 0) asked.push_back(i);
  }
  const std::vector<Derivatives> at_rest = derivatives_at(work, probes, asked);
  for (std::size_t k = 0; k < asked.size(); ++k) {
    const Vec3d& offset = offsets[asked[k]];
    set(asked[k], gradient(at_rest[k], offset / norm(offset)));
  }
  return distances;
}

}  // namespace

StrokeDistance distance_of(const AppliedStroke& stroke, const std::vector<bool>& moved, const ReplayOptions& options,
                           double length, std::size_t max_points) {
  StrokeDistance result;
  result.line = stroke.line;
  if (stroke.before.triangles().empty()) return result;
  const Work work{stroke, options, length, max_points};
  const std::vector<Probe> probes = inverse_image(work, moved);
  result.points = probes.size();
  if (probes.empty()) return result;
  const std::vector<Vec3d> offsets = offsets_to_surface(work, probes);
  const std::vector<double> after = distances_after(work, probes, offsets);
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

}  // namespace knead::detail
