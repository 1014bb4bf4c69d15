// From a pointer to strokes: what it touches, where a part begins, dabs of paint, images in mirrors.
#include <fmt/format.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "arrays.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/session.h"
#include "knead/vec.h"
#include "module.h"

namespace knead::python {
namespace {

using Vector = std::array<double, 3>;

Vec3d vec(const Vector& v, const char* name) {
  for (const double x : v) {
    if (!std::isfinite(x)) throw InvalidInput(fmt::format("{} has a coordinate that is not finite", name));
  }
  return {v[0], v[1], v[2]};
}

Vec3d direction_of(const Vector& v, const char* name) {
  const Vec3d direction = vec(v, name);
  if (!(norm(direction) > 0)) throw InvalidInput(fmt::format("{} must not be zero", name));
  return normalized(direction);
}

Vector list(const Vec3d& v) { return {v.x, v.y, v.z}; }

// A surface that a pointer touches.
class Surface {
 public:
  Surface(const py::object& vertices, const py::object& faces) {
    mesh_ = mesh_from(points_from(vertices, "vertices"), faces);
    const py::gil_scoped_release released;
    validate(mesh_);
    triangles_ = triangulate(WeldedMesh(mesh_).mesh());
    link();
    tree_.emplace(triangles_, mesh_.positions);
  }

  void move(const py::object& vertices) {
    const Points points = points_from(vertices, "vertices");
    if (points.span().size() != mesh_.positions.size()) {
      throw InvalidInput(
          fmt::format("vertices must be {} points, as before, got {}", mesh_.positions.size(), points.span().size()));
    }
    const py::gil_scoped_release released;
    mesh_.positions.assign(points.span().begin(), points.span().end());
    tree_->refit(mesh_.positions);
    profile_ = {};
  }

  DoubleArray vertices() const { return array_of(mesh_.positions); }
  py::object faces() const { return faces_of(mesh_); }

  std::optional<std::array<Vector, 2>> hit(const Vector& origin, const Vector& direction) const {
    const Vec3d from = vec(origin, "origin");
    const Vec3d along = direction_of(direction, "direction");
    const std::optional<RayHit> found = tree_->first_hit(from, along);
    if (!found) return std::nullopt;
    const Vec3d point = from + along * found->t;
    return std::array{list(point), list(normal_at(point))};
  }

  std::optional<Vector> middle(const Vector& origin, const Vector& direction) const {
    const Vec3d from = vec(origin, "origin");
    const Vec3d along = direction_of(direction, "direction");
    const std::optional<RayHit> front = tree_->first_hit(from, along);
    if (!front) return std::nullopt;
    for (const RayHit& hit : tree_->hits(from, along)) {
      if (hit.leaves) return list(from + along * (0.5 * (front->t + hit.t)));
    }
    return list(from + along * front->t);
  }

  std::optional<double> thickness(const Vector& point, const Vector& normal) const {
    const Vec3d inwards = -direction_of(normal, "normal");
    const double nearest = kOnSurface * shape_box(mesh_).diagonal();
    for (const RayHit& hit : tree_->hits(vec(point, "point"), inwards)) {
      if (hit.leaves && hit.t > nearest) return hit.t;
    }
    return std::nullopt;
  }

  // From each place of a flat ring to the nearest place of the surface, if that is near.
  py::object ring(const Vector& point, const Vector& normal, double radius, int count) const {
    const Vec3d center = vec(point, "point");
    const Vec3d up = direction_of(normal, "normal");
    const Vec3d u = any_orthogonal(up);
    const Vec3d v = cross(up, u);
    if (!(radius > 0 && std::isfinite(radius))) throw InvalidInput("radius must be above 0");
    if (count < 3 || count > kMaxPlaces) {
      throw InvalidInput(fmt::format("count must be from 3 to {}, got {}", kMaxPlaces, count));
    }
    std::vector<Vec3d> places;
    for (int i = 0; i < count; ++i) {
      const SinCos<double> turn = sincos(2 * std::numbers::pi * i / count);
      const Vec3d flat = center + (u * turn.cos + v * turn.sin) * radius;
      const auto found = tree_->closest(flat, kMaxLift * radius);
      places.push_back(found ? found->point : flat);
    }
    return array_of(places);
  }

  py::dict part(const Vector& point, const Vector& direction, const Vector& axis, double angle_deg) const {
    const CylinderQuery query{vec(point, "point"), direction_of(direction, "direction"), vec(axis, "axis"), angle_deg};
    CylinderPlacement place;
    {
      const py::gil_scoped_release released;
      place = place_limit_cylinder(query, mesh_.positions, triangles_);
    }
    if (!place.problem.empty()) throw InvalidInput(place.problem);
    py::dict keys;
    keys["center"] = list(place.center);
    keys["normal"] = list(place.normal);
    keys["inner"] = place.inner;
    keys["outer"] = place.outer;
    keys["radius"] = place.radius;
    return keys;
  }

  PaintSample plane(const PaintSample& at, double radius) const {
    return mean_plane(
        triangles_, [this](std::uint32_t vertex) { return mesh_.positions[vertex]; }, at, radius);
  }

  // While a stroke is dragged, only its angle changes: the profile stays.
  SessionStroke with_safe_zone(SessionStroke stroke) {
    if (!check_zone(stroke.stroke, profile_)) {
      profile_ = zone_profile(stroke.stroke, mesh_.positions, triangles_);
    }
    stroke.stroke = knead::with_safe_zone(stroke.stroke, profile_);
    return stroke;
  }

 private:
  static constexpr int kMaxPlaces = 10'000;   // of a ring
  static constexpr double kMaxLift = 0.4;     // of a ring's radius
  static constexpr double kOnSurface = 1e-6;  // of the diagonal: a ray from a place of the surface meets it there

  Vec3d normal_at(const Vec3d& point) const {
    const std::optional<SurfacePoint> place = tree_->closest(point);
    const Triangle& t = triangles_[place->triangle];
    Vec3d sum{};
    for (std::size_t k = 0; k < 3; ++k) sum += vertex_normal(t[k]) * place->barycentric[k];
    if (norm(sum) > 0) return normalized(sum);
    const Vec3d flat = area_of(t);
    return norm(flat) > 0 ? normalized(flat) : Vec3d{0, 0, 1};
  }

  Vec3d area_of(const Triangle& t) const {
    const std::vector<Vec3d>& p = mesh_.positions;
    return cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
  }

  // A unit vector; zero where no triangle has an area.
  Vec3d vertex_normal(std::uint32_t vertex) const {
    Vec3d sum{};
    for (std::uint32_t i = first_[vertex]; i < first_[vertex + 1]; ++i) sum += area_of(triangles_[around_[i]]);
    return norm(sum) > 0 ? normalized(sum) : sum;
  }

  void link() {
    first_.assign(mesh_.positions.size() + 1, 0);
    for (const Triangle& t : triangles_) {
      for (const std::uint32_t v : t) ++first_[v + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    around_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      for (const std::uint32_t v : triangles_[t]) around_[next[v]++] = t;
    }
  }

  Mesh mesh_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> first_;   // of each vertex, in around_
  std::vector<std::uint32_t> around_;  // the triangles at each vertex
  std::optional<SurfaceTree> tree_;
  ZoneProfile profile_;
};

// The stroke of a brush along a path.
SessionStroke brush(const std::string& name, const std::vector<Vector>& path, double radius,
                    std::optional<double> amount) {
  const Brush& found = brush_named(name);
  SessionStroke result{stroke_of(found, radius, amount.value_or(found.amount))};
  std::vector<Vec3d> points(path.size());
  std::transform(path.begin(), path.end(), points.begin(), [](const Vector& p) { return vec(p, "path"); });
  found.pulls ? std::get<ImplicitStroke>(result.stroke).path = std::move(points)
              : std::get<PaintStroke>(result.stroke).path = std::move(points);
  validate(result.stroke);
  return result;
}

std::vector<SessionStroke> session_strokes(std::vector<Stroke> strokes) {
  std::vector<SessionStroke> result;
  for (Stroke& stroke : strokes) {
    validate(stroke);
    result.emplace_back().stroke = std::move(stroke);
  }
  return result;
}

// Painting that begins with the first touch.
class PaintPointer {
 public:
  // surface: outlives this; null: a pinch below 0 flattens to planes through the places that are touched.
  PaintPointer(double radius, double depth, int falloff, bool wide, double pinch, const Surface* surface)
      : stroke_{wide ? 0 : radius, depth, {}, {}, wide ? kWideFalloff : falloff, wide ? radius : 0, pinch},
        surface_(surface) {
    PaintStroke check = stroke_;
    check.samples = {{{0, 0, 0}, {0, 0, 1}}};
    validate(Stroke(check));
  }

  void touch(const Vector& point, const Vector& normal, std::optional<double> outer, double pressure) {
    const PaintTouch touch{{vec(point, "point"), direction_of(normal, "normal")}, outer.value_or(radius()), pressure};
    if (!(touch.radius > 0 && std::isfinite(touch.radius))) throw InvalidInput("outer must be above 0");
    if (!(pressure > 0 && pressure <= 1)) throw InvalidInput("pressure must be above 0 and at most 1");
    if (drag_) {
      drag_paint(*drag_, touch);
    } else {
      PaintPlane plane;
      if (surface_ != nullptr && stroke_.pinch < 0) {
        plane = [this](const PaintSample& at, double of) { return surface_->plane(at, of); };
      }
      drag_ = begin_paint(stroke_, touch, plane);
    }
  }
  void finish() {
    if (drag_) end_paint(*drag_);
  }
  std::vector<SessionStroke> strokes() const {
    return drag_ ? session_strokes(drag_->strokes()) : std::vector<SessionStroke>{};
  }
  double spacing() const { return drag_ ? drag_->spacing : dab_length(stroke_); }

 private:
  double radius() const { return stroke_.falloff == kWideFalloff ? stroke_.bump : stroke_.outer; }

  PaintStroke stroke_;
  const Surface* surface_;
  std::optional<PaintDrag> drag_;
};

std::vector<SessionStroke> symmetric(std::vector<SessionStroke> strokes, const std::string& planes) {
  return mirrored_in(std::move(strokes), planes.empty() ? Mirror{} : coordinate_mirror(planes));
}

}  // namespace

void add_gesture(py::module_& module) {
  py::class_<Surface>(module, "Surface")
      .def(py::init<const py::object&, const py::object&>())
      .def("move", &Surface::move)
      .def("vertices", &Surface::vertices)
      .def("faces", &Surface::faces)
      .def("hit", &Surface::hit)
      .def("middle", &Surface::middle)
      .def("thickness", &Surface::thickness)
      .def("ring", &Surface::ring)
      .def("part", &Surface::part)
      .def("with_safe_zone", &Surface::with_safe_zone);
  py::class_<PaintPointer>(module, "PaintDrag")
      .def(py::init<double, double, int, bool, double, const Surface*>(), py::keep_alive<1, 7>())
      .def("touch", &PaintPointer::touch)
      .def("finish", &PaintPointer::finish)
      .def("strokes", &PaintPointer::strokes)
      .def("spacing", &PaintPointer::spacing);
  module.def("symmetric", &symmetric);
  module.def("brush", &brush);
}

}  // namespace knead::python
