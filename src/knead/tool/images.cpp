// The images of strokes in mirrors and about an axis.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "knead/tool/placement.h"
#include "knead/tool/tool.h"

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

}  // namespace knead
