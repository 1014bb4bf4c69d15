#include <algorithm>
#include <array>
#include <iterator>

#include "knead/flow/advect.h"
#include "knead/tool/paint.h"

namespace knead {

namespace {

constexpr int kDabs = 6;                  // that add up to the full depth
constexpr double kProbe = 1e-3;           // of the radius: how far apart the points are that tell a normal
constexpr double kProbeTolerance = 1e-7;  // of the radius

// The sample at a place of the surface as it was, where the dabs so far have brought it.
PaintSample carried(const PaintSample& at, const PaintDrag& drag) {
  const double outer = drag.stroke.outer;
  const Vec3d u = any_orthogonal(at.normal);
  const Vec3d v = cross(at.normal, u);
  std::array<Vec3d, 3> points{at.point, at.point + u * (kProbe * outer), at.point + v * (kProbe * outer)};
  AdvectOptions options;
  options.tolerance = kProbeTolerance * outer;
  options.precision = Precision::float64;
  options.threads = 1;
  advect(drag.done, points, options);
  const Vec3d normal = cross(points[1] - points[0], points[2] - points[0]);
  return {points[0], norm(normal) > 0 ? normalized(normal) : at.normal};
}

// Goes on with another radius: the depth of a dab is relative to it.
void set_radius(double radius, PaintDrag& drag) {
  PaintStroke& stroke = drag.stroke;
  if (stroke.outer == radius) return;
  if (!stroke.samples.empty()) drag.earlier.push_back(stroke);
  stroke.samples.clear();
  stroke.depth *= radius / stroke.outer;
  drag.spacing *= radius / stroke.outer;
  stroke.outer = radius;
}

void add_dab(const PaintTouch& touch, PaintDrag& drag) {
  set_radius(touch.radius, drag);
  PaintStroke dab = drag.stroke;
  dab.samples = {carried(touch.at, drag)};
  drag.stroke.samples.push_back(dab.samples.front());
  Flow flow = flow_of(dab);
  std::move(flow.segments.begin(), flow.segments.end(), std::back_inserter(drag.done.segments));
}

}  // namespace

std::vector<Stroke> PaintDrag::strokes() const {
  std::vector<Stroke> all(earlier.begin(), earlier.end());
  all.emplace_back(stroke);
  return all;
}

PaintDrag begin_paint(const PaintStroke& stroke, const PaintTouch& touch) {
  PaintDrag drag;
  drag.stroke = stroke;
  drag.stroke.depth = stroke.depth / kDabs;
  drag.spacing = dab_length(stroke.falloff) * stroke.outer / kDabs;
  drag.last = touch.at.point;
  add_dab(touch, drag);
  return drag;
}

void drag_paint(PaintDrag& drag, const PaintTouch& touch) {
  drag.travelled += norm(touch.at.point - drag.last) * touch.pressure;
  drag.last = touch.at.point;
  if (drag.travelled < drag.spacing) return;
  drag.travelled = std::min(drag.travelled - drag.spacing, drag.spacing);
  add_dab(touch, drag);
}

void end_paint(PaintDrag& drag) {
  if (drag.stroke.samples.size() + drag.earlier.size() > 1) return;
  drag.stroke.samples.resize(kDabs, drag.stroke.samples.front());
}

}  // namespace knead
