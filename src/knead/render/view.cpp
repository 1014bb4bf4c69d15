#include "knead/render/view.h"

#include <algorithm>
#include <cmath>

#include "knead/math/error.h"

namespace knead::render {
namespace {

void check(const Camera& camera) {
  const bool finite = is_finite(camera.eye) && is_finite(camera.target) && is_finite(camera.up);
  if (!finite || !(norm(camera.target - camera.eye) > 0) || !(norm(camera.up) > 0)) {
    throw InvalidInput("render: the camera has no direction; give different points for eye and target, and an up");
  }
  if (!(camera.height > 0) || !std::isfinite(camera.height)) {
    throw InvalidInput("render: the camera's height is not positive; give the height that the picture shows");
  }
}

Mat4f clip_matrix(const View& view) {
  // Rows of the matrix on (p - eye): x and y by the frame, z and w by the depth range.
  const double depth = view.far - view.near;
  const Vec3d rows[4] = {view.frame.right * (1 / norm(view.side)), view.frame.up * (1 / norm(view.top)),
                         view.frame.forward * (view.perspective ? (view.far + view.near) / depth : 2 / depth),
                         view.perspective ? view.frame.forward : Vec3d{}};
  const double constants[4] = {0, 0,
                               view.perspective ? -2 * view.far * view.near / depth : -(view.far + view.near) / depth,
                               view.perspective ? 0.0 : 1.0};
  Mat4f matrix{};
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 3; ++column) matrix[4 * column + row] = static_cast<float>(rows[row][column]);
    matrix[12 + row] = static_cast<float>(constants[row] - dot(rows[row], view.eye));
  }
  return matrix;
}

}  // namespace

Placement make_placement(const Box& box) {
  const double radius = 0.5 * box.diagonal();
  return {box.empty() ? Vec3d{} : box.center(), radius > 0 && std::isfinite(radius) ? 1 / radius : 1};
}

View make_view(const Camera& camera, const Placement& placement, const BoundingBall& shown, double aspect,
               int samples_high) {
  check(camera);
  View view;
  view.placement = placement;
  view.frame = camera_frame(camera);
  view.ground_up = normalized(camera.up);
  view.eye = view.placement.apply(camera.eye);
  view.perspective = camera.projection == Projection::perspective;
  const double distance = norm(camera.target - camera.eye) * view.placement.scale;
  const double half_height = 0.5 * camera.height * view.placement.scale / (view.perspective ? distance : 1);
  view.top = view.frame.up * half_height;
  view.side = view.frame.right * (half_height * aspect);
  view.pixel = 2 * half_height / samples_high;
  const double middle = dot(shown.center - view.eye, view.frame.forward);
  view.near = middle - shown.radius;
  view.far = middle + shown.radius;
  if (view.perspective) {
    view.near = std::max(view.near, 1e-3 * distance);
    view.far = std::max(view.far, 2 * view.near);
  }
  view.matrix = clip_matrix(view);
  return view;
}

View make_view(const Scene& scene, double aspect, int samples_high) {
  // Rods have a thickness beyond the box that was measured.
  constexpr double reach = 1.1;
  return make_view(scene.camera, make_placement(scene_box(scene)), {{}, reach}, aspect, samples_high);
}

}  // namespace knead::render
