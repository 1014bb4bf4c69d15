#include "knead/math/error.h"
#include "knead/tool/tool.h"

namespace knead {

namespace {

// Places and directions are mirrored alike. An axis about which something turns is too, and the angle about it then has
// the other sign.
struct Mirror {
  std::size_t axis = 0;
  Quantity quantity = Quantity::other;

  void flip(Vec3d& v) const { v[axis] = -v[axis]; }

  void operator()(Vec3d* v) const { flip(*v); }
  void operator()(std::optional<Vec3d>* v) const {
    if (*v) flip(**v);
  }
  void operator()(std::vector<Vec3d>* list) const {
    for (Vec3d& v : *list) flip(v);
  }
  void operator()(std::vector<std::vector<Vec3d>>* curves) const {
    for (std::vector<Vec3d>& curve : *curves) (*this)(&curve);
  }
  void operator()(std::vector<PaintSample>* samples) const {
    for (PaintSample& sample : *samples) {
      flip(sample.point);
      flip(sample.normal);
    }
  }
  void operator()(double* number) const {
    if (quantity == Quantity::angle) *number = -*number;
  }
  void operator()(std::vector<std::uint32_t>* vertices) const {
    if (vertices->empty()) return;
    throw InvalidInput(
        "\"full_vertices\" and \"zero_vertices\" cannot be mirrored; name points instead, with \"full\" and "
        "\"zero\"");
  }
  void operator()(Mat3d* m) const {
    for (Vec3d* row : {&m->row0, &m->row1, &m->row2}) flip(*row);
    Vec3d& row = axis == 0 ? m->row0 : axis == 1 ? m->row1 : m->row2;
    row = -row;
  }
  void operator()(HandlesMotion* motion) const {
    if (auto* translation = std::get_if<HandlesTranslation>(motion)) flip(translation->by);
    if (auto* rotation = std::get_if<HandlesRotation>(motion)) {
      flip(rotation->axis);
      flip(rotation->center);
      rotation->angle_deg = -rotation->angle_deg;
    }
  }
  template <class T>
  void operator()(const T& /*as it is*/) const {}
};

}  // namespace

Stroke mirrored(const Stroke& stroke, int axis) {
  Stroke image = stroke;
  for (const StrokeKey& key : tool_of(image).keys(image)) {
    const Mirror mirror{static_cast<std::size_t>(axis), key.quantity};
    if (applies(key)) std::visit(mirror, key.value);
  }
  return image;
}

}  // namespace knead
