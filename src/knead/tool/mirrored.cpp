#include <array>
#include <optional>
#include <vector>

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
  // Where each axis goes to the other side.
  std::optional<Vec3d> flips() const { return direction({1, 1, 1}); }
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
  // Nothing where an axis goes anywhere else.
  std::optional<Vec3d> flips() const {
    const Vec3d signs{motion.turn.row0.x, motion.turn.row1.y, motion.turn.row2.z};
    const bool is_flip = motion.turn == Mat3d{{signs.x, 0, 0}, {0, signs.y, 0}, {0, 0, signs.z}};
    return is_flip ? std::optional(signs) : std::nullopt;
  }
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
      if (rotation) turn(*rotation);
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
  void turn(HandlesRotation& rotation) const {
    rotation.axis = map.direction(rotation.axis);
    rotation.center = map.place(rotation.center);
    if (map.turns_round()) rotation.angle_deg = -rotation.angle_deg;
  }
  void turn(PinRotation& rotation) const {
    rotation.axis = map.direction(rotation.axis);
    if (map.turns_round()) rotation.angle_deg = -rotation.angle_deg;
  }
  void operator()(HandlesMotion* motion) const {
    if (auto* translation = std::get_if<HandlesTranslation>(motion)) translation->by = map.direction(translation->by);
    if (auto* rotation = std::get_if<HandlesRotation>(motion)) turn(*rotation);
  }
  void operator()(std::vector<PoseItem>* parts) const {
    for (PoseItem& item : *parts) std::visit([this](auto& of_kind) { this->move_item(of_kind); }, item);
  }
  void operator()(std::vector<PoseStiffness>* regions) const {
    if (!regions->empty()) throw InvalidInput("\"stiffness\" of vertices cannot be mirrored or moved");
  }
  void move_item(PosePart& part) const {
    if (!part.vertices.empty()) {
      throw InvalidInput("a part of \"vertices\" cannot be mirrored or moved; name points instead, with \"points\"");
    }
    for (Vec3d& p : part.points) p = map.place(p);
    if (part.rotation) turn(*part.rotation);
    if (part.translation) part.translation = map.direction(*part.translation);
  }
  void move_item(PosePin& pin) const {
    if (pin.vertex) {
      throw InvalidInput("a \"pin\" that is a vertex cannot be mirrored or moved; give its place, \"pin_point\"");
    }
    pin.point = map.place(*pin.point);
    for (Vec3d& p : pin.path) p = map.place(p);
    if (pin.rotation) turn(*pin.rotation);
  }
  template <class T>
  void operator()(const T& /*as it is*/) const {}
};

// The coefficients of the mirror image, a pseudovector's, in the order of the nodes of the mirror image.
SharedVectors flipped(const SharedVectors& coefficients, const std::array<int, 3>& counts, const Vec3d& signs) {
  const Vec3d by = signs * (signs.x * signs.y * signs.z);
  const auto at = [&](std::size_t axis, int i) {
    return static_cast<std::size_t>(signs[axis] < 0 ? counts[axis] - 1 - i : i);
  };
  const auto [nx, ny, nz] = counts;
  std::vector<Vec3d> list;
  list.reserve(coefficients.size());
  for (int z = 0; z < nz && !coefficients.empty(); ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const std::size_t row = at(1, y) + static_cast<std::size_t>(ny) * at(2, z);
        const Vec3d& a = coefficients[at(0, x) + static_cast<std::size_t>(nx) * row];
        list.push_back({a.x * by.x, a.y * by.y, a.z * by.z});
      }
    }
  }
  return SharedVectors(std::move(list));
}

template <class Map>
void move(PotentialGrid& grid, const Map& map) {
  const std::optional<Vec3d> signs = map.flips();
  if (!signs) throw InvalidInput("a grid cannot be turned, only moved and mirrored along its axes");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if ((*signs)[axis] < 0) grid.origin[axis] += (grid.counts[axis] - 1) * grid.spacing;
  }
  grid.origin = map.place(grid.origin);
  if (*signs == Vec3d{1, 1, 1}) return;
  grid.coefficients = flipped(grid.coefficients, grid.counts, *signs);
  if (!grid.end_coefficients.empty()) {
    grid.end_coefficients = flipped(grid.end_coefficients, grid.counts, *signs);
  }
}

template <class Map>
Stroke image_of(const Stroke& stroke, const Map& map) {
  Stroke image = stroke;
  if (auto* const grid = std::get_if<GridStroke>(&image)) {
    move(grid->grid, map);
    return image;
  }
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
