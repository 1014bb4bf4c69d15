#include "gestures/symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/tool/tool.h"

namespace knead::studio {

namespace {

constexpr double kOnPlane = 1e-9;  // of the radius: what counts as in a plane

double distance_to(const Symmetry::Plane& plane, const Vec3d& p) { return dot(p - plane.point, plane.normal); }

// Exact in the coordinate planes.
Vec3d in_plane(const Symmetry::Plane& plane, Vec3d p) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(plane.normal[axis]) == 1) {
      p[axis] = plane.point[axis];
      return p;
    }
  }
  return p - plane.normal * distance_to(plane, p);
}

Vec3d on_axis(const Symmetry& symmetry, const Vec3d& p) {
  const Vec3d axis = normalized(symmetry.axis);
  return symmetry.center + axis * dot(p - symmetry.center, axis);
}

// All numbers of a stroke, in the order of its keys. (Pointers to const would lose against the template below.)
struct Numbers {
  std::vector<double>& list;

  void add(const Vec3d& v) const { list.insert(list.end(), {v.x, v.y, v.z}); }
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
  void operator()(Mat3d* m) const {
    for (const Vec3d& row : {m->row0, m->row1, m->row2}) add(row);
  }
  void operator()(HandlesMotion* motion) const {
    if (const auto* translation = std::get_if<HandlesTranslation>(motion)) add(translation->by);
    if (const auto* rotation = std::get_if<HandlesRotation>(motion)) {
      add(rotation->axis);
      add(rotation->center);
      list.push_back(rotation->angle_deg);
    }
  }
  template <class T>
  void operator()(const T& /*no image changes it*/) const {}
};

std::vector<double> numbers_of(const Stroke& stroke) {
  std::vector<double> list;
  Stroke copy = stroke;
  for (const StrokeKey& key : tool_of(copy).keys(copy)) {
    if (applies(key)) std::visit(Numbers{list}, key.value);
  }
  return list;
}

}  // namespace

std::vector<Symmetry::Plane> mirror_planes(const ToolSettings& settings) {
  std::vector<Symmetry::Plane> planes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!settings.mirror[axis]) continue;
    Vec3d normal{0, 0, 0};
    normal[axis] = 1;
    planes.push_back({settings.symmetry.center, normal});
  }
  if (settings.symmetry.plane) planes.push_back(*settings.symmetry.plane);
  return planes;
}

std::vector<SymmetryImage> images_of(const ToolSettings& settings) {
  const Symmetry& symmetry = settings.symmetry;
  const std::vector<Symmetry::Plane> planes = mirror_planes(settings);
  const bool is_exact = symmetry.center == Vec3d{0, 0, 0} && !symmetry.plane;
  std::vector<SymmetryImage> images;
  for (int turn = 0; turn < std::clamp(symmetry.turns, 1, kMostTurns); ++turn) {
    const double angle = 2 * std::numbers::pi * turn / symmetry.turns;
    const RigidMotion turned = turn == 0 ? RigidMotion{} : rotation_about(symmetry.center, symmetry.axis, angle);
    for (unsigned mask = 0; mask < 1U << planes.size(); ++mask) {
      if (turn == 0 && mask == 0) continue;
      SymmetryImage image{turned};
      for (std::size_t i = 0; i < planes.size(); ++i) {
        if ((mask >> i & 1U) == 0) continue;
        image.motion = image.motion * reflection_in(planes[i].point, planes[i].normal);
        const Vec3d& n = planes[i].normal;
        if (turn == 0 && is_exact) image.planes |= n.x == 1 ? 1U : n.y == 1 ? 2U : 4U;
      }
      images.push_back(image);
    }
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

std::vector<Stroke> with_images(const Stroke& stroke, const std::vector<SymmetryImage>& images, double tolerance,
                                const ImageFile& image_file) {
  std::vector<Stroke> all{stroke};
  std::vector<std::vector<double>> numbers{numbers_of(stroke)};
  const auto same = [tolerance](const std::vector<double>& a, const std::vector<double>& b) {
    return std::ranges::equal(a, b, [=](double x, double y) { return std::abs(x - y) <= tolerance; });
  };
  for (const SymmetryImage& image : images) {
    Stroke next = image_of(stroke, image, image_file);
    std::vector<double> list = numbers_of(next);
    const bool is_there = std::ranges::any_of(numbers, [&](const auto& other) { return same(other, list); });
    if (is_there) continue;
    all.push_back(std::move(next));
    numbers.push_back(std::move(list));
  }
  return all;
}

PaintStroke with_images(const PaintStroke& stroke, const std::vector<SymmetryImage>& images) {
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

Vec3d snapped_to_symmetry(Vec3d p, const ToolSettings& settings) {
  const double near = 0.5 * settings.inner_ratio * settings.radius;
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    if (std::abs(distance_to(plane, p)) < near) p = in_plane(plane, p);
  }
  if (settings.symmetry.turns < 2) return p;
  const Vec3d axial = on_axis(settings.symmetry, p);
  return norm(p - axial) < near ? axial : p;
}

Vec3d kept_in_symmetry(Vec3d p, const Vec3d& first, const ToolSettings& settings) {
  const double near = kOnPlane * settings.radius;
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    if (std::abs(distance_to(plane, first)) <= near) p = in_plane(plane, p);
  }
  const bool is_on_axis = settings.symmetry.turns > 1 && norm(first - on_axis(settings.symmetry, first)) <= near;
  return is_on_axis ? on_axis(settings.symmetry, p) : p;
}

}  // namespace knead::studio
