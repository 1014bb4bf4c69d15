// The images of strokes in mirrors and about an axis.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/vec.h"
#include "strokes/describe.h"

namespace knead {

namespace {

// Calls `with` for every member of a key's value that a motion of the stroke may change.
template <class With>
struct EachPart {
  With with;
  Quantity quantity = Quantity::other;

  void add(Vec3d& v) const {
    const bool is_place = quantity != Quantity::direction && quantity != Quantity::displacement;
    is_place ? with.place(v) : with.direction(v);
  }
  void operator()(Vec3d* v) const { add(*v); }
  void operator()(std::optional<Vec3d>* v) const {
    if (*v) add(**v);
  }
  void operator()(std::vector<Vec3d>* list) const {
    for (Vec3d& v : *list) add(v);
  }
  void operator()(std::vector<std::vector<Vec3d>>* curves) const {
    for (std::vector<Vec3d>& curve : *curves) (*this)(&curve);
  }
  void operator()(std::vector<PaintSample>* samples) const {
    for (PaintSample& sample : *samples) {
      with.place(sample.point);
      with.direction(sample.normal);
    }
  }
  void operator()(std::vector<std::optional<PinRotation>>* rotations) const {
    for (std::optional<PinRotation>& rotation : *rotations) {
      if (rotation) with.turn(*rotation);
    }
  }
  void operator()(double* number) const {
    if (quantity == Quantity::angle || quantity == Quantity::rate) with.angle(*number);
  }
  void operator()(std::optional<double>* number) const {
    if (*number) (*this)(&**number);
  }
  void operator()(Mat3d* pose) const { with.pose(*pose); }
  void operator()(HandlesMotion* motion) const {
    if (auto* translation = std::get_if<HandlesTranslation>(motion)) with.direction(translation->by);
    if (auto* rotation = std::get_if<HandlesRotation>(motion)) with.turn(*rotation);
  }
  void operator()(std::vector<PoseItem>* parts) const {
    for (PoseItem& item : *parts) std::visit([this](auto& of_kind) { this->add(of_kind); }, item);
  }
  void add(PosePart& part) const {
    for (Vec3d& p : part.points) with.place(p);
    if (part.rotation) with.turn(*part.rotation);
    if (part.translation) with.direction(*part.translation);
  }
  void add(PosePin& pin) const {
    if (pin.point) with.place(*pin.point);
    for (Vec3d& p : pin.path) with.place(p);
    if (pin.rotation) with.turn(*pin.rotation);
  }
  void operator()(SharedVectors* vectors) const { with.coefficients(*vectors); }
  template <class T>
  void operator()(const T& /*as it is*/) const {}
};

// Appends them to a list.
struct Numbers {
  std::vector<double>& list;

  void place(const Vec3d& v) const { list.insert(list.end(), {v.x, v.y, v.z}); }
  void direction(const Vec3d& v) const { place(v); }
  void angle(double angle) const { list.push_back(angle); }
  void pose(const Mat3d& m) const {
    for (const Vec3d& row : {m.row0, m.row1, m.row2}) place(row);
  }
  void turn(const HandlesRotation& rotation) const {
    place(rotation.axis);
    place(rotation.center);
    angle(rotation.angle_deg);
  }
  void turn(const PinRotation& rotation) const { place(normalized(rotation.axis) * rotation.angle_deg); }
  void coefficients(const SharedVectors& vectors) const {
    for (const Vec3d& v : vectors) place(v);
  }
};

// Chooses one of the two forms of the same turn or stretch (axis and its opposite). For a twist the regions differ.
void choose_sense(Stroke& stroke) {
  Vec3d* axis = nullptr;
  double* angle = nullptr;
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    if (key.quantity == Quantity::rate) return;
    if (key.quantity == Quantity::angle) angle = std::get<double*>(key.value);
    if (key.name == "axis") axis = std::get<Vec3d*>(key.value);
  }
  if (axis == nullptr) return;
  const bool is_turned =
      angle != nullptr ? *angle < 0 : std::array{axis->x, axis->y, axis->z} < std::array{-axis->x, -axis->y, -axis->z};
  if (!is_turned) return;
  *axis = -*axis;
  if (angle != nullptr) *angle = -*angle;
}

std::vector<double> numbers_of(const Stroke& stroke) {
  std::vector<double> list;
  Stroke copy = stroke;
  choose_sense(copy);
  for (const StrokeKey& key : tool_of(copy).keys(copy)) {
    if (applies(key)) std::visit(EachPart<Numbers>{{list}, key.quantity}, key.value);
  }
  return list;
}

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
  // The sign of each axis in the mirror image.
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
  // Returns nothing if an axis is not mapped to itself or its opposite.
  std::optional<Vec3d> flips() const {
    const Vec3d signs{motion.turn.row0.x, motion.turn.row1.y, motion.turn.row2.z};
    const bool is_flip = motion.turn == Mat3d{{signs.x, 0, 0}, {0, signs.y, 0}, {0, 0, signs.z}};
    return is_flip ? std::optional(signs) : std::nullopt;
  }
};

// Moves them. An axis about which something turns moves like any direction; the angle about it changes its sign in a
// mirror.
template <class Map>
struct Moved {
  Map map;

  void place(Vec3d& v) const { v = map.place(v); }
  void direction(Vec3d& v) const { v = map.direction(v); }
  void angle(double& angle) const {
    if (map.turns_round()) angle = -angle;
  }
  void pose(Mat3d& m) const { m = map.pose(m); }
  void turn(HandlesRotation& rotation) const {
    direction(rotation.axis);
    place(rotation.center);
    angle(rotation.angle_deg);
  }
  void turn(PinRotation& rotation) const {
    direction(rotation.axis);
    angle(rotation.angle_deg);
  }
  void coefficients(SharedVectors& /*move() of the tool's row*/) const {}
};

template <class Map>
Stroke image_of(const Stroke& stroke, const Map& map) {
  Stroke image = stroke;
  const bool is_moved = detail::with_row(image, [&](const auto& row, auto& own) {
    if (row.move != nullptr) row.move(own, map.flips(), [&](const Vec3d& p) { return map.place(p); });
    return row.move != nullptr;
  });
  if (is_moved) return image;
  for (const StrokeKey& key : tool_of(image).keys(image)) {
    const std::string instead = detail::instead_of_vertices(key);
    if (!instead.empty()) {
      throw InvalidInput(
          fmt::format("\"{}\" names vertices, which cannot be mirrored or moved; {}", key.name, instead));
    }
    if (applies(key)) std::visit(EachPart<Moved<Map>>{{map}, key.quantity}, key.value);
  }
  return image;
}

}  // namespace

Stroke image_of(const Stroke& stroke, const SymmetryImage& image, const ImageFile& image_file) {
  Stroke result = stroke;
  for (int axis = 0; axis < 3; ++axis) {
    if ((image.planes >> axis & 1U) != 0) result = mirrored(result, axis);
  }
  if (image.planes == 0) result = transformed(stroke, image.motion);
  const unsigned of_tool = image.planes != 0 ? image.planes : is_reflection(image.motion) ? 1U : 0U;
  auto* const file = find_value<std::string>(result, "mesh");
  if (file != nullptr && of_tool != 0) *file = image_file(*file, of_tool);
  return result;
}

std::vector<Stroke> with_images(const Stroke& stroke, std::span<const SymmetryImage> images, double tolerance,
                                const ImageFile& image_file) {
  std::vector<Stroke> all{stroke};
  std::vector<std::vector<double>> numbers{numbers_of(stroke)};
  const auto same = [tolerance](const std::vector<double>& a, const std::vector<double>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [=](double x, double y) { return std::abs(x - y) <= tolerance; });
  };
  for (const SymmetryImage& image : images) {
    Stroke next = image_of(stroke, image, image_file);
    std::vector<double> list = numbers_of(next);
    const bool is_there =
        std::any_of(numbers.begin(), numbers.end(), [&](const auto& other) { return same(other, list); });
    if (is_there) continue;
    all.push_back(std::move(next));
    numbers.push_back(std::move(list));
  }
  return all;
}

std::vector<Stroke> pieces_of(const Stroke& stroke) {
  return detail::with_row(stroke, [](const auto& row, const auto& own) {
    return row.pieces != nullptr ? row.pieces(own) : std::vector<Stroke>{own};
  });
}

std::vector<Stroke> symmetric_strokes(std::span<const Stroke> strokes, std::span<const SymmetryImage> images,
                                      double tolerance, const ImageFile& image_file) {
  std::vector<Stroke> result(strokes.begin(), strokes.end());
  if (images.empty()) return result;
  result.clear();
  std::size_t count = 0;
  for (const Stroke& stroke : strokes) {
    for (const Stroke& piece : pieces_of(stroke)) {
      std::optional<Stroke> whole = detail::with_row(piece, [&](const auto& row, const auto& own) {
        return row.interleaved != nullptr ? row.interleaved(own, images) : std::nullopt;
      });
      if (whole) {
        result.push_back(std::move(*whole));
      } else {
        std::vector<Stroke> same = with_images(piece, images, tolerance, image_file);
        // The order turns round from piece to piece, so that no side is always first (Strang's splitting).
        if (count % 2 == 1) std::reverse(same.begin(), same.end());
        std::move(same.begin(), same.end(), std::back_inserter(result));
      }
      ++count;
    }
  }
  return result;
}

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
