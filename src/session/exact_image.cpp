// Samples of the longest faces are moved exactly and compared with the faces of the result.
#include "session/replay_detail.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "knead/vec.h"
#include "mesh/box_tree.h"
#include "mesh/edges.h"
#include "session/deformed_shape_detail.h"

namespace knead::detail {

namespace {

// Fractions of the smallest feature of the flow: an edge shorter than the first misses a negligible part of a bend; a
// face with an edge longer than the second may contain a feature although its vertices rest; pieces of faces are not
// cut below the third.
constexpr double kLong = 0.05;
constexpr double kHoldsFeature = 0.5;
constexpr double kPiece = 0.25;

constexpr std::size_t kFewestSamples = 1024;
constexpr std::size_t kVerticesPerSample = 64;
constexpr std::size_t kFacesPerSample = 2;  // of the faces that are checked whatever their size
constexpr std::size_t kFacesAtOnce = 4096;

constexpr double kFarFromFace =
    1e-3;  // of the reference length: at this distance from its own face, the nearest face is sought
// Bounds of the distance of the faces from the image (root mean square, relative to the size), and of the relative
// change of the volume: without remeshing, and with it.
constexpr double kFarFromImage = 1e-2;
constexpr double kFarOfOpen = 5e-2;  // the bound of the distance for an open surface, which bounds no solid
constexpr double kFarOfRemeshed = 1e-3;
constexpr double kChordsOfRemeshed = 4;  // a bound with remeshing is at least this multiple of max_chord
constexpr double kFarPlace = 10;         // factor of the bound for a single place, with remeshing
constexpr double kWorthAWord = 0.5;      // of these bounds: a note begins there

constexpr double kVolume = 1e-3;  // a change that asks whether the shape is closed

// The part of a triangle that a sample stands for.
struct SampledPart {
  double length2 = 0;  // of its longest edge
  std::uint32_t triangle = 0;
  std::array<Vec3d, 3> corners;

  friend bool operator<(const SampledPart& a, const SampledPart& b) { return a.length2 < b.length2; }
};

struct Samples {
  std::vector<Vec3d> points;
  std::vector<Triangle> faces;  // the face of the shape before in which each lies
  std::vector<double> areas;    // of the pieces that they represent
};

struct SampledError {
  double greatest = 0;  // distance of a sample, relative to the reference length
  double motion = 0;    // the greatest of a sample, relative to the reference length
  Samples samples;      // moved
  std::vector<double> distances;
};

struct ImageError {
  double greatest = 0;      // distance of a sample, relative to the reference length
  double rms = 0;           // of the whole surface, if that is more than kFarFromFace
  double volume = 0;        // after / before - 1; 0 of what has none, and after strokes that change volumes on purpose
  bool is_at_rest = false;  // no vertex has moved
  bool is_closed = false;   // the surface before; only where it matters
};

double square(double x) { return x * x; }

double length2_of(const std::array<Vec3d, 3>& c, std::size_t i) { return norm2(c[(i + 1) % 3] - c[i]); }

double area_of(const std::array<Vec3d, 3>& c) { return 0.5 * norm(cross(c[1] - c[0], c[2] - c[0])); }

std::size_t longest_of(const std::array<Vec3d, 3>& c) {
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (length2_of(c, i) > length2_of(c, longest)) longest = i;
  }
  return longest;
}

std::array<Vec3d, 3> triangle_at(const Triangle& t, std::span<const Vec3d> positions) {
  return {positions[t[0]], positions[t[1]], positions[t[2]]};
}

SampledPart piece_of(std::uint32_t triangle, const std::array<Vec3d, 3>& corners) {
  return {length2_of(corners, longest_of(corners)), triangle, corners};
}

bool may_move(const FlowSupport& support, std::span<const Vec3d> corners) {
  const Box box = bounding_box(corners);
  return support.may_move(box.center(), 0.5 * box.diagonal() * (1 + 1e-9));
}

// Distances between a shape's exact image and its result.
struct Compared {
  const Mesh& before;
  const DeformedShape& now;
  bool same_faces = false;
  FlowSupport support;
  double feature = 0;

  // Returns whether to check the k-th face.
  bool is_chosen(std::size_t f, std::size_t stride, std::vector<Vec3d>& corners) const {
    const std::span<const std::uint32_t> face = before.face(f);
    corners.clear();
    for (const std::uint32_t v : face) corners.push_back(before.positions[v]);
    double length2 = 0;
    for (std::size_t i = 0; i < face.size(); ++i) {
      length2 = std::max(length2, norm2(corners[(i + 1) % face.size()] - corners[i]));
    }
    if (face.size() < 3 || (length2 <= square(kLong * feature) && f % stride != 0)) return false;
    const auto has_moved = [&](std::uint32_t v) { return now.positions()[v] != before.positions[v]; };
    if (same_faces && std::any_of(face.begin(), face.end(), has_moved)) return true;
    return (!same_faces || length2 > square(kHoldsFeature * feature)) && may_move(support, corners);
  }
};

// The triangles of faces that the flow may bend, the longest ones of them.
std::vector<SampledPart> pieces_of(const Compared& work, std::size_t most, std::vector<Triangle>& triangles) {
  const Mesh& before = work.before;
  const std::size_t stride = kFacesPerSample * before.face_count() / most + 1;
  std::vector<std::vector<std::uint32_t>> of_parts((before.face_count() + kFacesAtOnce - 1) / kFacesAtOnce);
  parallel_for(before.face_count(), kFacesAtOnce, work.now.motion().threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3d> corners;
    for (std::size_t f = begin; f < end; ++f) {
      if (work.is_chosen(f, stride, corners)) of_parts[begin / kFacesAtOnce].push_back(static_cast<std::uint32_t>(f));
    }
  });
  for (const std::vector<std::uint32_t>& part : of_parts) {
    for (const std::uint32_t f : part) triangulate_polygon(before.positions, before.face(f), triangles);
  }
  std::vector<SampledPart> pieces;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    pieces.push_back(piece_of(t, triangle_at(triangles[t], before.positions)));
  if (pieces.size() > most) {
    const auto end = pieces.begin() + static_cast<std::ptrdiff_t>(most);
    std::nth_element(pieces.begin(), end, pieces.end(),
                     [](const SampledPart& a, const SampledPart& b) { return b < a; });
    pieces.erase(end, pieces.end());
  }
  return pieces;
}

// The middles of longest edges, of pieces that are halved there, the longest one first.
Samples samples_of(const Compared& work) {
  const std::size_t most = kFewestSamples + work.before.vertex_count() / kVerticesPerSample;
  std::vector<Triangle> triangles;
  std::priority_queue<SampledPart> queue({}, pieces_of(work, most, triangles));
  Samples samples;
  while (!queue.empty() && samples.points.size() < most) {
    const SampledPart piece = queue.top();
    queue.pop();
    if (!may_move(work.support, piece.corners)) continue;
    const std::size_t i = longest_of(piece.corners);
    const Vec3d middle = (piece.corners[i] + piece.corners[(i + 1) % 3]) * 0.5;
    samples.points.push_back(middle);
    samples.faces.push_back(triangles[piece.triangle]);
    samples.areas.push_back(area_of(piece.corners));
    if (piece.length2 <= square(kPiece * work.feature)) continue;
    for (const std::size_t k : {i, (i + 1) % 3}) {
      std::array<Vec3d, 3> half = piece.corners;
      half[k] = middle;
      queue.push(piece_of(piece.triangle, half));
    }
  }
  return samples;
}

// The distances of the points, moved, from the shape.
std::vector<double> distances_of(const Samples& samples, const Compared& work, const Progress* progress) {
  const DeformedShape& now = work.now;
  const double far = kFarFromFace * now.reference_length();
  std::vector<double> distances(samples.points.size(), kInfinity);
  std::vector<std::size_t> others;  // not near to their own faces
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    if (work.same_faces) {
      const std::array<Vec3d, 3> corners = triangle_at(samples.faces[i], now.positions());
      distances[i] = std::sqrt(nearest_on_triangle(corners, samples.points[i]).distance2);
    }
    if (distances[i] > far) others.push_back(i);
  }
  if (others.empty()) return distances;
  const SurfaceTree tree(now.triangles(), now.positions());
  parallel_for(others.size(), 64, now.motion().threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress);
    for (std::size_t i = begin; i < end; ++i) {
      distances[others[i]] = tree.closest(samples.points[others[i]])->distance;
    }
  });
  return distances;
}

// Returns the root mean square over the surface before. Parts without samples count as 0; pieces of pieces count again.
double rms_of(const std::vector<double>& distances, const Samples& samples, const Mesh& before) {
  double sum = 0;
  double area = 0;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    sum += samples.areas[i] * square(distances[i]);
    area += samples.areas[i];
  }
  area = std::max(area, measure_volume_and_area(before, before.positions).area);
  return area > 0 ? std::sqrt(sum / area) : 0;
}

double volume_change(const Mesh& before, const Flow& flow, const DeformedShape& now) {
  if (std::any_of(flow.segments.begin(), flow.segments.end(), changes_volume)) return 0;
  const VolumeAndArea first = measure_volume_and_area(before, before.positions);
  const double change =
      knead::volume_change(first, measure_volume_and_area(now.mesh(), now.positions()).volume).value_or(0);
  if (std::abs(change) <= kVolume) return 0;
  const Measures measures = measure(WeldedMesh(before).mesh(), now.motion().threads);
  return measures.closed() && measures.oriented() ? change : 0;
}

// Compares the shape with the image of `before` under the flow, at points of the longest faces that it moves. Large
// faces also get samples inside, down to the size of the flow's features.
SampledError sampled_error(const Mesh& before, const Flow& flow, const DeformedShape& now, bool same_faces,
                           Progress* progress) {
  const double feature = std::min(FlowSupport(flow).smallest_feature(), now.reference_length());
  const Compared work{before, now, same_faces, FlowSupport(flow), feature};
  Samples samples = samples_of(work);
  if (samples.points.empty()) return {};
  AdvectOptions options = advect_options(now.motion(), now.reference_length());
  const KeptCount kept(progress, true);
  options.progress = progress;
  const std::vector<Vec3d> start = samples.points;
  if (advect(flow, samples.points, options).status != AdvectStatus::done) return {};
  SampledError error;
  for (std::size_t i = 0; i < start.size(); ++i) {
    error.motion = std::max(error.motion, norm(samples.points[i] - start[i]) / now.reference_length());
  }
  error.distances = distances_of(samples, work, progress);
  error.greatest = *std::max_element(error.distances.begin(), error.distances.end()) / now.reference_length();
  error.samples = std::move(samples);
  return error;
}

// The same for the whole surface, where a sample lies far from the image.
ImageError image_error(const Mesh& before, const Flow& flow, const DeformedShape& now, bool same_faces,
                       Progress* progress) {
  const SampledError sampled = sampled_error(before, flow, now, same_faces, progress);
  ImageError error{sampled.greatest};
  if (error.greatest <= kFarFromFace) return error;
  error.rms = rms_of(sampled.distances, sampled.samples, before) / now.reference_length();
  error.volume = volume_change(before, flow, now);
  error.is_closed =
      error.rms > kWorthAWord * kFarFromImage && measure(WeldedMesh(before).mesh(), now.motion().threads).closed();
  error.is_at_rest = same_faces && std::equal(before.positions.begin(), before.positions.end(), now.positions().begin(),
                                              now.positions().end());
  return error;
}

}  // namespace

void ExactImage::add(const StrokeRun& run, const DeformedShape& shape) {
  if (shape.mesh().face_count() == 0) return;
  if (run.stroke().relax != nullptr) {
    surface_ = std::make_shared<const Mesh>(shape.to_mesh());
    provenance_ = shape.provenance();
    return;
  }
  Flow flow = run.flow();
  std::move(flow.segments.begin(), flow.segments.end(), std::back_inserter(flow_.segments));
  if (run.remeshed()) ++remeshes_;
}

double ExactImage::missed_motion(const DeformedShape& shape, Progress* progress) const {
  if (flow_.segments.empty()) return 0;
  const SampledError error = sampled_error(*surface_, flow_, shape, shape.provenance() == provenance_, progress);
  return error.greatest > kFarFromFace ? error.greatest / error.motion : 0;
}

std::optional<std::string> ExactImage::compare(const DeformedShape& shape, const ReplayOptions& options) {
  if (flow_.segments.empty()) return std::nullopt;
  const Flow flow = std::exchange(flow_, {});
  const bool same_faces = shape.provenance() == provenance_;
  const ImageError error = image_error(*surface_, flow, shape, same_faces, options.progress);
  const double chord = options.remesh.settings ? options.remesh.settings->max_chord.value_or(0) : 0;
  const double of_remesh = std::max(kFarOfRemeshed, kChordsOfRemeshed * chord);
  const bool follows = !same_faces && !shape.provenance()->counts.out_of_time;
  const double of_mesh = error.is_closed ? kFarFromImage : kFarOfOpen;
  const double far = follows ? of_remesh * static_cast<double>(std::max<std::size_t>(remeshes_, 1)) : of_mesh;
  const bool is_missed = error.is_at_rest && error.greatest > kFarFromImage;
  const double farthest = follows ? error.greatest / kFarPlace : 0;
  const double share = std::max({error.rms / far, farthest / far, std::abs(error.volume) / kFarFromImage});
  const bool is_far = share > 1 || is_missed;
  if (!is_far && share <= kWorthAWord) return std::nullopt;
  std::string text = fmt::format(
      "the faces {}follow these strokes: the exact image of the surface is {:.2g} of its size away from them (root "
      "mean square; {:.2g} at most){}; {}",
      is_far ? "cannot " : "do not quite ", error.rms, error.greatest,
      error.volume == 0 ? "" : fmt::format(", and the volume changes by a fraction of {:.2g}", error.volume),
      same_faces ? "add --remesh (or a remesh line), or use a finer mesh"
                 : "use a smaller \"max_chord\", or a finer mesh");
  if (is_far && options.must_follow) text += ", or keep it with --keep-mesh";
  if (is_far && options.must_follow) throw QualityLimit(text);
  return text;
}

}  // namespace knead::detail
