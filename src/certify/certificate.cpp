// Certificates of results, and the parts of sessions that spoil no cell.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "cells/cells.h"
#include "certify/stroke_certificate.h"
#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/elementary.h"
#include "mesh/edges.h"

namespace knead {

namespace {

Vec3d as_written(const Vec3d& p, bool as_float) { return as_float ? Vec3d(Vec3<float>(p)) : p; }

// Finds the least angle of triangles.
class SmallestAngle {
 public:
  void add(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    if (is_degenerate(a, b, c)) return;
    const double area = norm(cross(b - a, c - a));
    const double widest = std::max({dot(b - a, c - a), dot(a - b, c - b), dot(a - c, b - c)});
    if (area > widest * largest_tangent_) return;
    const double angle = elementary::atan2(area, widest) * 180 / std::numbers::pi;
    angle_ = std::min(angle, angle_.value_or(angle));
    largest_tangent_ = std::min(largest_tangent_, area / widest * (1 + 1e-12));
  }

  // Returns nothing if no triangle has an area.
  std::optional<double> degrees() const { return angle_; }

 private:
  std::optional<double> angle_;
  double largest_tangent_ = kInfinity;  // triangles with a larger one need no arc tangent
};

// Returns the smallest angle of the chosen faces.
std::optional<double> smallest_angle_of(const Mesh& mesh, const std::vector<bool>& faces) {
  SmallestAngle smallest;
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (!faces[f] || mesh.face(f).size() < 3) continue;
    triangles.clear();
    triangulate_polygon(mesh.positions, mesh.face(f), triangles);
    for (const Triangle& t : triangles) {
      smallest.add(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    }
  }
  return smallest.degrees();
}

std::vector<bool> faces_at(const Mesh& mesh, const std::vector<bool>& vertices) {
  std::vector<bool> faces(mesh.face_count());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    faces[f] = std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return vertices[v]; });
  }
  return faces;
}

// The result as a mesh with its positions as they are written, and a flag for each moved vertex.
struct WrittenShape {
  Mesh mesh;
  std::vector<bool> touched;
  std::vector<std::uint32_t> face_source;  // empty: the faces are those of the input
};

WrittenShape written_shape(const DeformedShape& result, bool as_float) {
  WrittenShape shape{result.to_mesh(), result.touched(), {}};
  if (result.is_remeshed()) shape.face_source = result.provenance()->face_source;
  for (Vec3d& p : shape.mesh.positions) p = as_written(p, as_float);
  return shape;
}

void add_angles(const Mesh& before, const WrittenShape& after, Certificate& certificate) {
  const std::vector<bool> touched = faces_at(after.mesh, after.touched);
  std::vector<bool> sources = touched;
  if (!after.face_source.empty()) {
    sources.assign(before.face_count(), false);
    for (std::size_t f = 0; f < touched.size(); ++f) {
      if (touched[f]) sources[after.face_source[f]] = true;
    }
  }
  certificate.touched_angle_before = smallest_angle_of(before, sources);
  certificate.touched_angle_after = smallest_angle_of(after.mesh, touched);
}

// A flag for each face of both meshes: it differs from all faces of the other mesh in its vertices or their positions.
struct ChangedFaces {
  std::vector<bool> before;
  std::vector<bool> after;
};

ChangedFaces changed_faces(const Mesh& before, const WrittenShape& written, const Provenance* provenance) {
  const Mesh& after = written.mesh;
  ChangedFaces changed{std::vector<bool>(before.face_count(), true), std::vector<bool>(after.face_count(), true)};
  const auto is_kept = [&](std::uint32_t v, std::uint32_t source) {
    const bool is_same = provenance == nullptr ? v == source : provenance->vertex_source[v] == source;
    return is_same && same_bits(after.positions[v], before.positions[source]);
  };
  for (std::size_t f = 0; f < after.face_count(); ++f) {
    const std::size_t source = provenance == nullptr ? f : provenance->face_source[f];
    const std::span<const std::uint32_t> now = after.face(f);
    const std::span<const std::uint32_t> then = before.face(source);
    if (!changed.before[source] || !std::equal(now.begin(), now.end(), then.begin(), then.end(), is_kept)) continue;
    changed.before[source] = false;
    changed.after[f] = false;
  }
  return changed;
}

// Returns the flag of the face for each triangle of triangulate(mesh).
std::vector<bool> of_triangles(const Mesh& mesh, const std::vector<bool>& faces) {
  std::vector<bool> flags;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::size_t corners = mesh.face(f).size();
    if (corners > 2) flags.insert(flags.end(), corners - 2, faces[f]);
  }
  return flags;
}

// Triangles of unchanged faces cross after exactly if they cross before. So only pairs with a triangle of a changed
// face are searched after.
void add_crossings(const Mesh& before, const WrittenShape& after, const Provenance* provenance,
                   const ReplayOptions& replay, Certificate& certificate) {
  SelfIntersectionOptions options{.threads = replay.motion.threads, .progress = replay.progress};
  const SelfIntersections first = self_intersections(triangulate(WeldedMesh(before).mesh()), before.positions, options);
  const ChangedFaces changed = changed_faces(before, after, provenance);
  const std::vector<bool> gone = of_triangles(before, changed.before);
  const std::vector<bool> made = of_triangles(after.mesh, changed.after);
  std::size_t kept = 0;
  if (first.complete) {
    options.chosen = &made;
    kept = static_cast<std::size_t>(std::count_if(first.pairs.begin(), first.pairs.end(),
                                                  [&](const auto& pair) { return !gone[pair[0]] && !gone[pair[1]]; }));
  }
  const std::vector<Triangle> triangles = triangulate(WeldedMesh(after.mesh).mesh());
  const SelfIntersections last = self_intersections(triangles, after.mesh.positions, options);
  certificate.crossings_before = first.count;
  certificate.crossings_after = std::min(kept + last.count, options.limit);
}

void add_measures(const Mesh& before, const Mesh& after, bool same_faces, int threads, Certificate& certificate) {
  const Measures first = measure(before, threads);
  const Measures last = same_faces ? measure(after, first, threads) : measure(after, threads);
  certificate.degenerate_before = first.degenerate_triangles;
  certificate.degenerate_after = last.degenerate_triangles;
  certificate.closed_before = first.closed();
  certificate.closed_after = last.closed();
  certificate.euler_before = first.euler;
  certificate.euler_after = last.euler;
  certificate.smallest_angle_before = first.smallest_angle_deg;
  certificate.smallest_angle_after = last.smallest_angle_deg;
  const bool has_volume = first.closed() && first.oriented() && last.closed() && last.oriented();
  if (has_volume) certificate.volume_error = volume_change({first.volume, first.area}, last.volume);
  if (certificate.det_least || !certificate.volume_error) return;
  certificate.volume_error_sampling = *certificate.volume_error - certificate.volume_error_integration;
}

std::size_t inverted_count(const VolumeCells& cells, std::span<const Vec3d> points) {
  const std::vector<std::uint8_t> inverted = inverted_cells(cells, points);
  return static_cast<std::size_t>(std::count(inverted.begin(), inverted.end(), 1));
}

void add_distances(const std::vector<StrokeDistance>& strokes, Certificate& certificate) {
  double squares = 0;
  double back_squares = 0;
  double points = 0;
  for (const StrokeDistance& stroke : strokes) {
    const auto count = static_cast<double>(stroke.points);
    squares += stroke.rms * stroke.rms * count;
    back_squares += stroke.back_rms * stroke.back_rms * count;
    points += count;
    certificate.distance_max = std::max(certificate.distance_max, stroke.max);
    certificate.carried_back_max = std::max(certificate.carried_back_max, stroke.back_max);
  }
  if (points == 0) return;
  certificate.distance_rms = std::sqrt(squares / points);
  certificate.carried_back_rms = std::sqrt(back_squares / points);
}

void require_positions(const Mesh& before, std::span<const Vec3d> after, const Session& session,
                       const ReplayOptions& options) {
  if (after.size() != before.vertex_count()) {
    throw InvalidInput(fmt::format("there are {} positions to certify, but {} vertices; give one for each vertex",
                                   after.size(), before.vertex_count()));
  }
  require_finite(after);
  if (Replay(borrow(before), session, options).remeshes()) {
    throw InvalidInput("the session remeshes, so its result has other vertices; remove its remesh events");
  }
}

constexpr double kSamplesPerStroke = 16;
constexpr double kMaxSamples = 256;
constexpr int kBisections = 10;

double sample_count(double strokes) {
  return std::max(1.0, std::min(kMaxSamples, std::ceil(kSamplesPerStroke * strokes)));
}

// The points of a mesh after any part of a session.
class MovedPoints {
 public:
  MovedPoints(const Session& session, std::span<const Vec3d> points, const SafeCellsOptions& options)
      : session_(session), points_(points), options_(options) {
    advection_ = advect_options(options.motion, options.motion.diagonal.value_or(reference_length(points)));
    advection_.progress = options.progress;
  }

  // Returns the points after `until` strokes; if the step limit ends the work, status() says so.
  std::vector<Vec3d> at(double until) {
    const Flow flow = flow_of(session_, {options_.part.direction, until}, options_.motion.threads);
    std::vector<Vec3d> moved(points_.begin(), points_.end());
    const AdvectStatus status = advect(flow, moved, advection_).status;
    stop_if_cancelled(options_.progress);
    if (status != AdvectStatus::done) status_ = status;
    return moved;
  }

  AdvectStatus status() const { return status_; }

 private:
  const Session& session_;
  std::span<const Vec3d> points_;
  const SafeCellsOptions& options_;
  AdvectOptions advection_;
  AdvectStatus status_ = AdvectStatus::done;
};

// Returns widest_outer() of the stroke that spoils a cell.
std::optional<double> outer_that_fits(const Session& session, const Cells& cells, MovedPoints& motion,
                                      const SafeUntil& range, const SafeCellsOptions& options) {
  const std::size_t number = strokes_before(range);
  const bool is_forwards = options.part.direction == Direction::forwards;
  const std::vector<Vec3d> points = motion.at(is_forwards ? static_cast<double>(number) : 0);
  std::vector<Vec3d> boundary;
  for (const std::uint32_t v : boundary_points(cells, points.size(), options.motion.threads)) {
    boundary.push_back(points[v]);
  }
  const SessionStroke& stroke = session.strokes[number];
  const double strength = std::max(1.0, stroke.strength);
  return widest_outer(strength > 1 ? prolonged(stroke.stroke, strength) : stroke.stroke, boundary,
                      options.motion.threads);
}

}  // namespace

CertificateBuilder::CertificateBuilder(const Mesh& mesh, const ReplayOptions& options, std::size_t max_points)
    : mesh_(mesh), options_(options), max_points_(max_points), length_(reference_length(mesh)) {
  advect_options(options.motion, length_);
}

void CertificateBuilder::add(const AppliedStroke& stroke) {
  const detail::StrokeCertificate certified = detail::certify(stroke, options_, length_, max_points_);
  drift_ += certified.drift;
  if (certified.det_least) {
    det_least_ = std::min(*certified.det_least, det_least_.value_or(*certified.det_least));
    det_greatest_ = std::max(*certified.det_greatest, det_greatest_.value_or(*certified.det_greatest));
  }
  motion_outside_ = std::max(motion_outside_, certified.motion_outside);
  strokes_.push_back(certified.distance);
}

Certificate CertificateBuilder::finish(const ReplayResult& result, bool as_float) const {
  const Mesh& before = mesh_;
  const WrittenShape after = written_shape(result.shape, as_float);
  const WeldedMesh welded(before);
  const WeldedMesh welded_after(after.mesh);
  Certificate certificate;
  certificate.volume_error_integration = drift_;
  certificate.det_least = det_least_;
  certificate.det_greatest = det_greatest_;
  const std::array<std::function<void()>, 3> works{
      [&] { add_crossings(before, after, result.shape.provenance(), options_, certificate); },
      [&] {
        add_measures(welded.mesh(), welded_after.mesh(), !result.shape.is_remeshed(), options_.motion.threads,
                     certificate);
      },
      [&] {
        certificate.flipped_triangles = result.shape.is_remeshed()
                                            ? detail::opposing_more(welded.mesh(), welded_after.mesh())
                                            : count_flipped(welded.mesh(), before.positions, after.mesh.positions);
        add_angles(before, after, certificate);
      }};
  parallel_for(works.size(), 1, options_.motion.threads, [&](std::size_t i, std::size_t) {
    stop_if_cancelled(options_.progress);
    works[i]();
  });
  if (result.cells) {
    certificate.inverted_cells_before = inverted_count(*result.cells, before.positions);
    certificate.inverted_cells_after = inverted_count(*result.cells, after.mesh.positions);
  }
  certificate.motion_outside = motion_outside_;
  certificate.strokes = strokes_;
  add_distances(strokes_, certificate);
  return certificate;
}

Certificate certify(const Mesh& before, std::span<const Vec3d> after, const Session& session,
                    const ReplayOptions& options) {
  require_positions(before, after, session, options);
  Mesh moved = before;
  moved.positions.assign(after.begin(), after.end());
  const DeformedShape given(borrow(moved), options.motion);
  const std::vector<bool> all(after.size(), true);
  const auto with_given = [&](DeformedShape shape) {
    shape.take(all, given);
    return shape;
  };
  CertificateBuilder builder(before, options);
  ReplayOptions watched = options;
  const auto is_on = [](const SessionStroke& stroke) { return !stroke.off; };
  std::size_t left = static_cast<std::size_t>(std::count_if(session.strokes.begin(), session.strokes.end(), is_on));
  watched.on_stroke = [&](const AppliedStroke& stroke) {
    if (--left > 0) return builder.add(stroke);
    const DeformedShape last = with_given(stroke.after);
    builder.add({stroke.line, stroke.flow, stroke.before, last, stroke.remeshed, stroke.relax});
  };
  ReplayResult result = replay(borrow(before), session, watched);
  if (result.status == AdvectStatus::cancelled) throw Cancelled();
  if (result.status == AdvectStatus::step_limit) {
    throw InvalidInput(Place{session.name, result.failed_line}, kStepLimitAdvice);
  }
  result.shape = with_given(std::move(result.shape));
  return builder.finish(result, false);
}

SafeUntil safe_until(double strokes, const std::function<bool(double until)>& holds) {
  const double samples = sample_count(strokes);
  SafeUntil range{0, strokes};
  double sample = 1;
  for (; sample <= samples; ++sample) {
    const double until = strokes * (sample / samples);
    if (!holds(until)) {
      range.beyond = until;
      break;
    }
    range.until = until;
  }
  for (int i = 0; i < kBisections && sample <= samples; ++i) {
    const double middle = range.until + (range.beyond - range.until) / 2;
    (holds(middle) ? range.until : range.beyond) = middle;
  }
  return range;
}

std::size_t strokes_before(const SafeUntil& range) {
  return static_cast<std::size_t>(std::max(0.0, std::ceil(range.beyond) - 1));
}

SafeCells safe_until(const Session& session, const Cells& cells, std::span<const Vec3d> points,
                     const SafeCellsOptions& options) {
  const double bound = options.least_scaled_jacobian;
  if (!(bound >= 0 && bound < 1)) throw InvalidInput("the least scaled Jacobian must be 0 or more, and below 1");
  const Session applied = without_off(session);
  const double strokes = options.part.until.value_or(static_cast<double>(applied.strokes.size()));
  flow_of(applied, {options.part.direction, strokes});  // throws for strokes that are no flow, and a part out of range
  SafeCells result;
  if (points.empty()) {
    result.range = {strokes, strokes};
    return result;
  }
  if (options.progress != nullptr) {
    const auto calls = static_cast<std::uint64_t>(sample_count(strokes)) + kBisections;
    options.progress->total = calls * points.size() * std::max<std::uint64_t>(1, flow_of(applied).segments.size()) / 2;
  }
  MovedPoints motion(applied, points, options);
  const CellBaseline judged(cells, points, options.motion.threads, options.progress);
  const auto spoiled = [&](double until) { return judged.worst_spoiled(motion.at(until), bound); };
  result.range = safe_until(strokes, [&](double until) {
    const std::optional<WorstCell> worst = spoiled(until);
    if (!worst) return true;
    result.cell = worst->cell;
    result.scaled_jacobian = worst->scaled_jacobian;
    return false;
  });
  result.status = motion.status();
  if (result.cell && result.status == AdvectStatus::done)
    result.outer = outer_that_fits(applied, cells, motion, result.range, options);
  return result;
}

}  // namespace knead
