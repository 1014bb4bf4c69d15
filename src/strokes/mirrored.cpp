// The images of strokes in mirrors and about an axis.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "knead/error.h"
#include "knead/tools.h"
#include "knead/vec.h"

namespace knead {

namespace {

// All numbers of a stroke, in the order of its keys. (Pointers to const would lose against the template below.)
struct Numbers {
  std::vector<double>& list;

  void add(const Vec3d& v) const { list.insert(list.end(), {v.x, v.y, v.z}); }
  void add(const HandlesRotation& rotation) const {
    add(rotation.axis);
    add(rotation.center);
    list.push_back(rotation.angle_deg);
  }
  void operator()(double* number) const { list.push_back(*number); }
  void operator()(std::optional<double>* number) const { list.push_back(number->value_or(0)); }
  void operator()(const AutoNumber& number) const { list.push_back(number.value->value_or(0)); }
  void operator()(Vec3d* v) const { add(*v); }
  void operator()(std::optional<Vec3d>* v) const { add(v->value_or(Vec3d{})); }
  void operator()(std::vector<Vec3d>* points) const {
    for (const Vec3d& p : *points) add(p);
  }
  void operator()(std::vector<std::vector<Vec3d>>* curves) const {
    for (std::vector<Vec3d>& curve : *curves) (*this)(&curve);
  }
  void operator()(std::vector<PaintSample>* samples) const {
    for (const PaintSample& sample : *samples) {
      add(sample.point);
      add(sample.normal);
    }
  }
  void operator()(std::vector<std::optional<PinRotation>>* rotations) const {
    for (const std::optional<PinRotation>& rotation : *rotations) {
      add(rotation ? normalized(rotation->axis) * rotation->angle_deg : Vec3d{});
    }
  }
  void operator()(std::vector<PoseItem>* parts) const {
    for (PoseItem& item : *parts) {
      if (auto* part = std::get_if<PosePart>(&item)) {
        (*this)(&part->points);
        add(part->translation.value_or(Vec3d{}));
        if (part->rotation) add(*part->rotation);
      } else {
        auto& pin = std::get<PosePin>(item);
        add(pin.point.value_or(Vec3d{}));
        (*this)(&pin.path);
        if (pin.rotation) add(normalized(pin.rotation->axis) * pin.rotation->angle_deg);
      }
    }
  }
  void operator()(SharedVectors* vectors) const {
    for (const Vec3d& v : *vectors) add(v);
  }
  void operator()(SharedNumbers* numbers) const { list.insert(list.end(), numbers->begin(), numbers->end()); }
  void operator()(Mat3d* m) const {
    for (const Vec3d& row : {m->row0, m->row1, m->row2}) add(row);
  }
  void operator()(HandlesMotion* motion) const {
    if (const auto* translation = std::get_if<HandlesTranslation>(motion)) add(translation->by);
    if (const auto* rotation = std::get_if<HandlesRotation>(motion)) add(*rotation);
  }
  template <class T>
  void operator()(const T& /*no image changes it*/) const {}
};

// Of two ways to write the same turn or stretch always the same one.
struct OneSense {
  template <class S>
  static void turn(S& stroke) {
    if (stroke.angle_deg >= 0) return;
    stroke.angle_deg = -stroke.angle_deg;
    stroke.axis = -stroke.axis;
  }
  void operator()(RotateStroke& stroke) const { turn(stroke); }
  void operator()(BendStroke& stroke) const { turn(stroke); }
  void operator()(StretchStroke& stroke) const {
    const Vec3d& axis = stroke.axis;
    if (std::array{axis.x, axis.y, axis.z} < std::array{-axis.x, -axis.y, -axis.z}) stroke.axis = -axis;
  }
  template <class S>
  void operator()(S& /*has one*/) const {}
};

std::vector<double> numbers_of(const Stroke& stroke) {
  std::vector<double> list;
  Stroke copy = stroke;
  std::visit(OneSense{}, copy);
  for (const StrokeKey& key : tool_of(copy).keys(copy)) {
    if (applies(key)) std::visit(Numbers{list}, key.value);
  }
  return list;
}

// The pieces of a stroke that may take turns with those of its images.
template <class S>
std::vector<Stroke> along_path(const S& stroke) {
  std::vector<Stroke> pieces;
  for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) {
    S piece = stroke;
    piece.path = {stroke.path[i], stroke.path[i + 1]};
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

std::vector<Stroke> displaced(const PointsStroke& stroke) {
  std::vector<Stroke> pieces;
  PointsStroke piece = stroke;
  for (const Vec3d& displacement : stroke.displacements) {
    piece.displacements = {displacement};
    pieces.emplace_back(piece);
    for (Vec3d& p : piece.points) p += displacement;
    for (auto& curve : piece.curves) {
      for (Vec3d& p : curve) p += displacement;
    }
  }
  return pieces;
}

// Each sample has its images after it, so that all sides grow together.
PaintStroke with_images(const PaintStroke& stroke, std::span<const SymmetryImage> images) {
  PaintStroke result = stroke;
  result.samples.clear();
  for (const PaintSample& sample : stroke.samples) {
    PaintStroke one = stroke;
    one.samples = {sample};
    result.samples.push_back(sample);
    for (const SymmetryImage& image : images) {
      result.samples.push_back(std::get<PaintStroke>(image_of(one, image, {})).samples.front());
    }
  }
  return result;
}

// Places that are relaxed have their images after them, so that all sides become smooth together.
RelaxStroke with_images(const RelaxStroke& stroke, std::span<const SymmetryImage> images) {
  RelaxStroke result = stroke;
  result.points.clear();
  for (const Vec3d& point : stroke.points) {
    result.points.push_back(point);
    for (const SymmetryImage& image : images) {
      RelaxStroke one = stroke;
      one.points = {point};
      result.points.push_back(std::get<RelaxStroke>(image_of(one, image, {})).points.front());
    }
  }
  return result;
}

}  // namespace

std::vector<SymmetryImage> mirror_images(unsigned planes) {
  std::vector<SymmetryImage> images;
  for (unsigned mask = 1; mask < 8; ++mask) {
    if ((mask & ~planes) != 0) continue;
    SymmetryImage image{{}, mask};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((mask >> axis & 1U) == 0) continue;
      Vec3d normal{0, 0, 0};
      normal[axis] = 1;
      image.motion = image.motion * reflection_in({0, 0, 0}, normal);
    }
    images.push_back(image);
  }
  return images;
}

Stroke image_of(const Stroke& stroke, const SymmetryImage& image, const ImageFile& image_file) {
  Stroke result = stroke;
  for (int axis = 0; axis < 3; ++axis) {
    if ((image.planes >> axis & 1U) != 0) result = mirrored(result, axis);
  }
  if (image.planes == 0) result = transformed(stroke, image.motion);
  const unsigned of_tool = image.planes != 0 ? image.planes : is_reflection(image.motion) ? 1U : 0U;
  auto* const stamp = std::get_if<StampStroke>(&result);
  if (stamp != nullptr && of_tool != 0) stamp->mesh = image_file(stamp->mesh, of_tool);
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
  if (const auto* implicit = std::get_if<ImplicitStroke>(&stroke)) return along_path(*implicit);
  if (const auto* points = std::get_if<PointsStroke>(&stroke)) return displaced(*points);
  if (const auto* stamp = std::get_if<StampStroke>(&stroke)) return along_path(*stamp);
  return {stroke};
}

std::vector<Stroke> symmetric_strokes(std::span<const Stroke> strokes, std::span<const SymmetryImage> images,
                                      double tolerance, const ImageFile& image_file) {
  std::vector<Stroke> result(strokes.begin(), strokes.end());
  if (images.empty()) return result;
  result.clear();
  std::size_t count = 0;
  for (const Stroke& stroke : strokes) {
    for (const Stroke& piece : pieces_of(stroke)) {
      if (const auto* paint = std::get_if<PaintStroke>(&piece); paint != nullptr && paint->path.empty()) {
        result.emplace_back(with_images(*paint, images));
      } else if (const auto* relax = std::get_if<RelaxStroke>(&piece)) {
        result.emplace_back(with_images(*relax, images));
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

// The coefficients of the mirror image, changed by `image`, in the order of its nodes.
template <class T, class OfImage>
SharedList<T> flipped(const SharedList<T>& coefficients, const std::array<int, 3>& counts, const Vec3d& signs,
                      const OfImage& image) {
  if (coefficients.empty()) return {};
  const auto at = [&](std::size_t axis, int i) {
    return static_cast<std::size_t>(signs[axis] < 0 ? counts[axis] - 1 - i : i);
  };
  const auto [nx, ny, nz] = counts;
  std::vector<T> list;
  list.reserve(coefficients.size());
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const std::size_t row = at(1, y) + static_cast<std::size_t>(ny) * at(2, z);
        list.push_back(image(coefficients[at(0, x) + static_cast<std::size_t>(nx) * row]));
      }
    }
  }
  return SharedList<T>(std::move(list));
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
  const Vec3d by = *signs * (signs->x * signs->y * signs->z);  // of a pseudovector
  const auto vector = [&](const Vec3d& a) { return Vec3d{a.x * by.x, a.y * by.y, a.z * by.z}; };
  grid.coefficients = flipped(grid.coefficients, grid.counts, *signs, vector);
  grid.end_coefficients = flipped(grid.end_coefficients, grid.counts, *signs, vector);
  grid.growth = flipped(grid.growth, grid.counts, *signs, [](double g) { return g; });
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
