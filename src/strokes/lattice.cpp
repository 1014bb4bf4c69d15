// The tool "lattice": a box of control points whose displacements move what is in the box.
#include "strokes/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "flow/lattice_map.h"
#include "knead/error.h"
#include "knead/vec.h"

namespace knead {

namespace {

using namespace detail;

constexpr double kMaxCosine = 1e-6;  // of the angle between two axes
constexpr double kOnFace = 1e-9;     // of an edge: nearer points lie on the face
constexpr std::size_t kUsualSegments = 8;
constexpr double kBeyondShape = 0.02;  // of an edge of the shape's box, by which the lattice reaches beyond it
constexpr double kThinnest = 0.02;     // of the box's diagonal: an edge of the lattice
constexpr int kUsualDegree = 3;        // of the lattice about a shape

std::vector<StrokeKey> keys(LatticeStroke& s) {
  return {{"file", Quantity::other, &s.file, Presence::optional},
          {"origin", Quantity::finite, &s.origin, Presence::optional},
          {"axes", Quantity::other, &s.axes, Presence::optional},
          {"lengths", Quantity::displacement, &s.lengths, Presence::optional},
          {"counts", Quantity::other, &s.counts, Presence::optional},
          {"displacements", Quantity::displacement, &s.displacements, Presence::optional},
          {"mode", Quantity::other, choice(s.mode, {"volume", "rigid", "spline"}), Presence::optional},
          {"degree", Quantity::other, &s.degree, Presence::optional}};
}

void validate_box(const LatticeStroke& stroke) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = stroke.lengths[axis];
    if (!(length > 0 && std::isfinite(length))) {
      throw InvalidInput(fmt::format("\"lengths\" must be three lengths above 0, got [{:g}, {:g}, {:g}]",
                                     stroke.lengths.x, stroke.lengths.y, stroke.lengths.z));
    }
  }
  const std::array<Vec3d, 3> axes{stroke.axes.row0, stroke.axes.row1, stroke.axes.row2};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require_direction("axes", axes[axis]);
    if (std::abs(dot(unit(axes[axis]), unit(axes[(axis + 1) % 3]))) > kMaxCosine) {
      throw InvalidInput("\"axes\" must be three directions at right angles to each other");
    }
  }
}

void validate(const LatticeStroke& stroke) {
  if (!stroke.file.empty()) {
    const LatticeStroke only_file{.file = stroke.file, .displacements = {}, .mode = stroke.mode};
    if (stroke != only_file) {
      throw InvalidInput("\"file\" gives the box, the displacements and the degree; leave them out, or \"file\"");
    }
    return;
  }
  const auto [nx, ny, nz] = stroke.counts;
  const auto is_count = [](int n) { return n >= 2 && n <= LatticeMotion::kMaxCount; };
  if (!(is_count(nx) && is_count(ny) && is_count(nz))) {
    throw InvalidInput(fmt::format("\"counts\" must be three whole numbers from 2 to {}, got [{}, {}, {}]",
                                   LatticeMotion::kMaxCount, nx, ny, nz));
  }
  if (stroke.degree < 0 || stroke.degree > LatticeMotion::kMaxDegree) {
    throw InvalidInput(fmt::format("\"degree\" must be from 1 to {}, or 0 for the greatest, got {}",
                                   LatticeMotion::kMaxDegree, stroke.degree));
  }
  if (stroke.degree == 0 && std::max({nx, ny, nz}) > LatticeMotion::kMaxDegree + 1) {
    throw InvalidInput(
        fmt::format("\"degree\" is missing; more than {} control points along an edge need one, such as 3",
                    LatticeMotion::kMaxDegree + 1));
  }
  validate_box(stroke);
  const std::size_t points = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz);
  if (stroke.displacements.size() != points) {
    throw InvalidInput(fmt::format(
        "\"displacements\" must hold a vector for each of the {} control points that \"counts\" gives, got {}", points,
        stroke.displacements.size()));
  }
}

bool reads_surface(const LatticeStroke& stroke) { return !stroke.file.empty() || stroke.mode != LatticeMode::spline; }

// Throws InvalidInput if the lattice folds its box, with a part of the displacements that does not.
void require_no_fold(const LatticeMotion& lattice) {
  const std::optional<detail::LatticeFold> fold = detail::find_fold(lattice);
  if (!fold) return;
  const std::string part = fmt::format("{:.2f}", std::floor(100 * detail::time_without_fold(lattice, *fold)) / 100);
  const Vec3d& p = fold->place;
  throw InvalidInput(
      fold->determinant > 0
          ? fmt::format("\"displacements\" come so near to a fold at [{:.4g}, {:.4g}, {:.4g}] (det J is about {:.2g}) "
                        "that none can be excluded; {} of them do not",
                        p.x, p.y, p.z, fold->determinant, part)
          : fmt::format(
                "\"displacements\" fold the box at [{:.4g}, {:.4g}, {:.4g}], where det J is {:.2g} at {:.2g} of "
                "them; {} of them do not",
                p.x, p.y, p.z, fold->determinant, fold->time, part));
}

Flow flow_of(const LatticeStroke& stroke) {
  Segment segment;
  segment.lattice = motion_of(stroke);
  require_no_fold(segment.lattice);
  return {{std::move(segment)}};
}

void resolve(const LatticeStroke& stroke, SurfaceRun& run) {
  check_faces(motion_of(stroke), run.surface);
  flow_on(stroke, run);
}

void check(const LatticeStroke& stroke, const LiveSurface& surface) { check_faces(motion_of(stroke), surface); }

std::size_t segments(const LatticeStroke& stroke, const Mesh* /*mesh*/) {
  return stroke.mode == LatticeMode::spline ? 1 : kUsualSegments;
}

void prolong(LatticeStroke& stroke, double strength) {
  for (Vec3d& d : stroke.displacements) d *= strength;
}

// The image of the stroke's numbers; `place` is a rigid motion.
void move(LatticeStroke& stroke, const std::optional<Vec3d>& /*signs*/, const PlaceMap& place) {
  if (!stroke.file.empty()) {
    throw InvalidInput("\"file\": the lattice of a file cannot be mirrored or moved; give its numbers instead");
  }
  const Vec3d zero = place({0, 0, 0});
  const auto turned = [&](const Vec3d& v) { return place(v) - zero; };
  stroke.origin = place(stroke.origin);
  stroke.axes = {turned(stroke.axes.row0), turned(stroke.axes.row1), turned(stroke.axes.row2)};
  for (Vec3d& d : stroke.displacements) d = turned(d);
}

std::string words(const LatticeStroke& stroke, const std::string& unit) {
  double most = 0;
  for (const Vec3d& d : stroke.displacements) most = std::max(most, norm(d));
  return most > 0 ? "Lattice " + length_text(most, unit) : "Lattice";
}

// The part of a triangle in a box from 0 to 1, and through which faces the rest of it leaves.
class ClippedTriangle {
 public:
  explicit ClippedTriangle(std::vector<Vec3d> corners) : polygon_(std::move(corners)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const bool is_high : {false, true}) cut(axis, is_high);
    }
  }

  bool passes(std::size_t axis, bool is_high) const {
    if (polygon_.empty() || !is_cut_[axis][is_high ? 1 : 0]) return false;
    const double face = is_high ? 1 : 0;
    return std::any_of(polygon_.begin(), polygon_.end(), [&](const Vec3d& p) { return p[axis] == face; });
  }

 private:
  void cut(std::size_t axis, bool is_high) {
    const double face = is_high ? 1 : 0;
    const auto beyond = [&](const Vec3d& p) { return is_high ? p[axis] - face : face - p[axis]; };
    std::vector<Vec3d> rest;
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
      const Vec3d& a = polygon_[i];
      const Vec3d& b = polygon_[(i + 1) % polygon_.size()];
      if (!(beyond(a) > kOnFace)) rest.push_back(a);
      if ((beyond(a) > kOnFace) == (beyond(b) > kOnFace)) continue;
      is_cut_[axis][is_high ? 1 : 0] = true;
      Vec3d between = a + (b - a) * (beyond(a) / (beyond(a) - beyond(b)));
      between[axis] = face;
      rest.push_back(between);
    }
    polygon_ = std::move(rest);
  }

  std::vector<Vec3d> polygon_;
  std::array<std::array<bool, 2>, 3> is_cut_{};
};

}  // namespace

namespace detail {

LatticeMotion motion_of(const LatticeStroke& stroke) {
  LatticeMotion lattice;
  lattice.origin = stroke.origin;
  lattice.lengths = stroke.lengths;
  lattice.counts = stroke.counts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int greatest = stroke.counts[axis] - 1;
    lattice.degrees[axis] = stroke.degree == 0 ? greatest : std::min(stroke.degree, greatest);
  }
  const Vec3d x = unit(stroke.axes.row0);
  const Vec3d y = unit(unit(stroke.axes.row1) - x * dot(x, unit(stroke.axes.row1)));
  const Vec3d z = cross(x, y);
  lattice.axes = {x, y, dot(z, stroke.axes.row2) < 0 ? -z : z};
  lattice.displacements = SharedVectors(stroke.displacements);
  return lattice;
}

void check_faces(const LatticeMotion& lattice, const LiveSurface& surface) {
  const auto closed = detail::closed_faces(lattice);
  std::vector<Vec3d> places;  // from 0 to 1 in the box
  places.reserve(surface.positions.size());
  for (const Vec3d& p : surface.positions) {
    const Vec3d at = lattice.axes * (p - lattice.origin);
    places.push_back({at.x / lattice.lengths.x, at.y / lattice.lengths.y, at.z / lattice.lengths.z});
  }
  const auto is_within = [](double u) { return u >= -kOnFace && u <= 1 + kOnFace; };
  for (const Triangle& t : surface.triangles) {
    bool is_apart = false;
    bool is_inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::array<double, 3> u{places[t[0]][axis], places[t[1]][axis], places[t[2]][axis]};
      const auto [least, most] = std::minmax_element(u.begin(), u.end());
      is_apart = is_apart || *most < -kOnFace || *least > 1 + kOnFace;
      is_inside = is_inside && is_within(*least) && is_within(*most);
    }
    if (is_apart || is_inside) continue;
    const ClippedTriangle clipped({places[t[0]], places[t[1]], places[t[2]]});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const bool is_high : {false, true}) {
        if (closed[axis][is_high ? 1 : 0] || !clipped.passes(axis, is_high)) continue;
        const Vec3d& p = surface.positions[t[0]];
        throw InvalidInput(fmt::format(
            "\"displacements\" move the two outer layers of control points at the {} end of axis {}, and the shape "
            "reaches "
            "through that face of the box near [{:.4g}, {:.4g}, {:.4g}]; make the box larger, or let these layers rest",
            is_high ? "upper" : "lower", axis, p.x, p.y, p.z));
      }
    }
  }
}

}  // namespace detail

LatticeStroke lattice_about(const Box& box, const std::array<int, 3>& counts) {
  if (!(box.diagonal() > 0)) throw InvalidInput("a lattice cannot be laid about a shape without an extent");
  LatticeStroke stroke{.counts = counts, .displacements = {}, .degree = kUsualDegree};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double edge = box.max[axis] - box.min[axis];
    stroke.lengths[axis] = std::max((1 + 2 * kBeyondShape) * edge, kThinnest * box.diagonal());
  }
  stroke.origin = box.center() - stroke.lengths * 0.5;
  std::size_t points = 1;
  for (const int count : counts) points *= static_cast<std::size_t>(count);
  stroke.displacements.assign(points, {0, 0, 0});
  return stroke;
}

std::vector<Vec3d> control_points(const LatticeStroke& stroke) {
  const LatticeMotion lattice = motion_of(stroke);
  const std::array<detail::LatticeAxis, 3> along = detail::axes_of(lattice);
  std::vector<Vec3d> points;
  points.reserve(stroke.displacements.size());
  for (int i = 0; i < lattice.counts[0]; ++i) {
    for (int j = 0; j < lattice.counts[1]; ++j) {
      for (int k = 0; k < lattice.counts[2]; ++k) {
        const Vec3d place = lattice.origin + lattice.axes.row0 * (along[0].place(i) * lattice.lengths.x) +
                            lattice.axes.row1 * (along[1].place(j) * lattice.lengths.y) +
                            lattice.axes.row2 * (along[2].place(k) * lattice.lengths.z);
        points.push_back(place + stroke.displacements[points.size()]);
      }
    }
  }
  return points;
}

constinit const detail::ToolRow<LatticeStroke> LatticeStroke::tool{.name = "lattice",
                                                                   .keys = keys,
                                                                   .validate = validate,
                                                                   .reads_surface = reads_surface,
                                                                   .resolve = resolve,
                                                                   .check = check,
                                                                   .flow = flow_of,
                                                                   .segments = segments,
                                                                   .words = words,
                                                                   .prolong = prolong,
                                                                   .move = move};

}  // namespace knead
