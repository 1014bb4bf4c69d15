#include "knead/tool/mirrored.h"

#include "knead/math/error.h"

namespace knead {

namespace {

// Directions of motion and normals are mirrored as places are. An axis about which something turns is too, and the
// angle about it then has the other sign.
struct Mirror {
  int axis = 0;

  void flip(Vec3d& v) const { v[static_cast<std::size_t>(axis)] = -v[static_cast<std::size_t>(axis)]; }
  void flip(std::optional<Vec3d>& v) const {
    if (v) flip(*v);
  }
  void flip(std::vector<Vec3d>& list) const {
    for (Vec3d& v : list) flip(v);
  }

  Stroke operator()(ImplicitStroke s) const {
    flip(s.path);
    flip(s.half_axis);
    return s;
  }
  Stroke operator()(PaintStroke s) const {
    for (PaintSample& sample : s.samples) {
      flip(sample.point);
      flip(sample.normal);
    }
    flip(s.path);
    return s;
  }
  Stroke operator()(PointsStroke s) const {
    flip(s.points);
    for (std::vector<Vec3d>& curve : s.curves) flip(curve);
    flip(s.displacements);
    return s;
  }
  Stroke operator()(HandlesStroke s) const {
    if (!s.full_vertices.empty() || !s.zero_vertices.empty()) {
      throw InvalidInput(
          "\"full_vertices\" and \"zero_vertices\" cannot be mirrored; name points instead, with \"full\" and "
          "\"zero\"");
    }
    flip(s.full);
    flip(s.zero);
    if (auto* translation = std::get_if<HandlesTranslation>(&s.motion)) flip(translation->by);
    if (auto* rotation = std::get_if<HandlesRotation>(&s.motion)) {
      flip(rotation->axis);
      flip(rotation->center);
      rotation->angle_deg = -rotation->angle_deg;
    }
    return s;
  }
  Stroke operator()(StampStroke s) const {
    flip(s.path);
    for (Vec3d* row : {&s.pose.row0, &s.pose.row1, &s.pose.row2}) flip(*row);
    Vec3d& row = axis == 0 ? s.pose.row0 : axis == 1 ? s.pose.row1 : s.pose.row2;
    row = -row;
    return s;
  }
  Stroke operator()(RotateStroke s) const {
    flip(s.center);
    flip(s.axis);
    s.angle_deg = -s.angle_deg;
    return s;
  }
  Stroke operator()(StretchStroke s) const {
    flip(s.center);
    flip(s.axis);
    return s;
  }
  Stroke operator()(TwistStroke s) const {
    flip(s.center);
    flip(s.axis);
    flip(s.normal);
    s.rate_deg = -s.rate_deg;
    return s;
  }
  Stroke operator()(BendStroke s) const {
    flip(s.center);
    flip(s.axis);
    flip(s.normal);
    s.angle_deg = -s.angle_deg;
    return s;
  }
};

}  // namespace

Stroke mirrored(const Stroke& stroke, int axis) { return std::visit(Mirror{axis}, stroke); }

}  // namespace knead
