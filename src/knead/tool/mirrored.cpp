#include "knead/math/error.h"
#include "knead/math/sincos.h"
#include "knead/tool/tool.h"

namespace knead {

namespace {

// The mirror image in a coordinate plane through the origin: exact.
struct CoordinateMirror {
  std::size_t axis = 0;

  Vec3d direction(Vec3d v) const {
    v[axis] = -v[axis];
    return v;
  }
  Vec3d place(const Vec3d& p) const { return direction(p); }
  // Fits the tool's mirror image in the same plane.
  Mat3d pose(Mat3d m) const {
    for (Vec3d* row : {&m.row0, &m.row1, &m.row2}) *row = direction(*row);
    Vec3d& row = axis == 0 ? m.row0 : axis == 1 ? m.row1 : m.row2;
    row = -row;
    return m;
  }
  bool turns_round() const { return true; }
};

// Any rigid motion.
struct AnyMotion {
  RigidMotion motion;

  Vec3d direction(const Vec3d& v) const { return motion.turn * v; }
  Vec3d place(const Vec3d& p) const { return motion(p); }
  // Fits the tool itself, or its mirror image in x = 0.
  Mat3d pose(const Mat3d& m) const {
    Mat3d result = motion.turn * m;
    if (!turns_round()) return result;
    for (Vec3d* row : {&result.row0, &result.row1, &result.row2}) row->x = -row->x;
    return result;
  }
  bool turns_round() const { return is_reflection(motion); }
};

// Moves one value of a stroke. An axis about which something turns moves like any direction; the angle about it changes
// its sign in a mirror.
template <class Map>
struct Image {
  Map map;
  Quantity quantity = Quantity::other;

  void move(Vec3d& v) const {
    const bool is_place = quantity != Quantity::direction && quantity != Quantity::displacement;
    v = is_place ? map.place(v) : map.direction(v);
  }

  void operator()(Vec3d* v) const { move(*v); }
  void operator()(std::optional<Vec3d>* v) const {
    if (*v) move(**v);
  }
  void operator()(std::vector<Vec3d>* list) const {
    for (Vec3d& v : *list) move(v);
  }
  void operator()(std::vector<std::vector<Vec3d>>* curves) const {
    for (std::vector<Vec3d>& curve : *curves) (*this)(&curve);
  }
  void operator()(std::vector<PaintSample>* samples) const {
    for (PaintSample& sample : *samples) {
      sample.point = map.place(sample.point);
      sample.normal = map.direction(sample.normal);
    }
  }
  void operator()(std::vector<std::optional<PinRotation>>* rotations) const {
    for (std::optional<PinRotation>& rotation : *rotations) {
      if (!rotation) continue;
      rotation->axis = map.direction(rotation->axis);
      if (map.turns_round()) rotation->angle_deg = -rotation->angle_deg;
    }
  }
  void operator()(double* number) const {
    if ((quantity == Quantity::angle || quantity == Quantity::rate) && map.turns_round()) *number = -*number;
  }
  void operator()(std::vector<std::uint32_t>* vertices) const {
    if (vertices->empty()) return;
    throw InvalidInput(
        "\"full_vertices\" and \"zero_vertices\" cannot be mirrored or moved; name points instead, with \"full\" and "
        "\"zero\"");
  }
  void operator()(std::vector<VertexRange>* vertices) const {
    if (vertices->empty()) return;
    throw InvalidInput("a mask of \"vertices\" cannot be mirrored or moved; name points instead, with \"points\"");
  }
  void operator()(Mat3d* m) const { *m = map.pose(*m); }
  void operator()(HandlesMotion* motion) const {
    if (auto* translation = std::get_if<HandlesTranslation>(motion)) translation->by = map.direction(translation->by);
    if (auto* rotation = std::get_if<HandlesRotation>(motion)) {
      rotation->axis = map.direction(rotation->axis);
      rotation->center = map.place(rotation->center);
      if (map.turns_round()) rotation->angle_deg = -rotation->angle_deg;
    }
  }
  template <class T>
  void operator()(const T& /*as it is*/) const {}
};

template <class Map>
Stroke image_of(const Stroke& stroke, const Map& map) {
  Stroke image = stroke;
  for (const StrokeKey& key : tool_of(image).keys(image)) {
    if (applies(key)) std::visit(Image<Map>{map, key.quantity}, key.value);
  }
  return image;
}

}  // namespace

bool is_reflection(const RigidMotion& motion) { return determinant(motion.turn) < 0; }

RigidMotion operator*(const RigidMotion& second, const RigidMotion& first) {
  return {second.turn * first.turn, second(first.shift)};
}

RigidMotion reflection_in(const Vec3d& point, const Vec3d& normal) {
  const Vec3d n = normalized(normal);
  return {Mat3d{} + outer_product(n, n) * -2.0, n * (2 * dot(n, point))};
}

RigidMotion rotation_about(const Vec3d& point, const Vec3d& axis, double angle_rad) {
  const Vec3d a = normalized(axis);
  const SinCos<double> turn = sincos(angle_rad);
  const auto turned = [&](const Vec3d& v) {
    return v * turn.cos + cross(a, v) * turn.sin + a * (dot(a, v) * (1 - turn.cos));
  };
  const Vec3d x = turned({1, 0, 0});
  const Vec3d y = turned({0, 1, 0});
  const Vec3d z = turned({0, 0, 1});
  const Mat3d matrix{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
  return {matrix, point - matrix * point};
}

Stroke mirrored(const Stroke& stroke, int axis) {
  return image_of(stroke, CoordinateMirror{static_cast<std::size_t>(axis)});
}

Stroke transformed(const Stroke& stroke, const RigidMotion& motion) { return image_of(stroke, AnyMotion{motion}); }

}  // namespace knead
