// The camera of a picture.
#pragma once

#include <span>

#include "knead/math/box.h"
#include "knead/math/vec3.h"

namespace knead::render {

// Whether far things look smaller.
enum class Projection { orthographic, perspective };

// Looks from eye to target. The picture shows `height` units from bottom to top in the plane through the target, in
// both projections, so that both show it at the same scale. Valid: eye != target, height > 0, up not zero. If `up` is
// parallel to the view, an orthogonal direction replaces it. `up` is also the normal of the ground.
struct Camera {
  Projection projection = Projection::perspective;
  Vec3d eye{0, 0, 5};
  Vec3d target{0, 0, 0};
  Vec3d up{0, 1, 0};
  double height = 2;
};

// The unit vectors of the picture: right, up, and forward (from the eye into the scene).
struct CameraFrame {
  Vec3d right;
  Vec3d up;
  Vec3d forward;
};

// Returns the unit vectors of a valid camera.
CameraFrame camera_frame(const Camera& camera);

// Projection and margin of fit_camera().
struct FitOptions {
  Projection projection = Projection::perspective;
  double field_of_view_deg = 25;  // vertical; perspective only
  double margin = 0.06;           // of the picture's height or width, whichever is tighter, on each side
};

// Returns the camera that looks along `direction` (not zero) and shows all points, which are finite, as large as
// possible in a picture of width / height = aspect: they reach the margins on two sides at least. Without points, as
// for an empty box.
Camera fit_points(std::span<const Vec3d> points, const Vec3d& direction, const Vec3d& up, double aspect,
                  const FitOptions& options = {});

// Returns the camera that looks along `direction` (not zero) at the centre of the box and shows the whole box in a
// picture of width / height = aspect. An empty box counts as the unit cube about the origin.
Camera fit_camera(const Box& box, const Vec3d& direction, const Vec3d& up, double aspect,
                  const FitOptions& options = {});

}  // namespace knead::render
