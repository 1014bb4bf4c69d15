// Cameras that fit shapes, views, the extent of scenes, and colours as text.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

#include "knead/editor/render.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "render/surface.h"

namespace knead::render {

CameraFrame camera_frame(const Camera& camera) {
  const Vec3d forward = normalized(camera.target - camera.eye);
  Vec3d right = cross(forward, camera.up);
  if (!(norm(right) > 1e-9 * norm(camera.up))) right = any_orthogonal(forward);
  right = normalized(right);
  return {right, cross(right, forward), forward};
}

namespace {

// The eight corners of the box relative to its centre, along the frame's axes.
template <class F>
void for_each_corner(const Box& box, const CameraFrame& frame, F&& visit) {
  const Vec3d half = (box.max - box.min) * 0.5;
  for (int i = 0; i < 8; ++i) {
    const Vec3d corner{(i & 1) != 0 ? half.x : -half.x, (i & 2) != 0 ? half.y : -half.y,
                       (i & 4) != 0 ? half.z : -half.z};
    visit(Vec3d{dot(corner, frame.right), dot(corner, frame.up), dot(corner, frame.forward)});
  }
}

// The range of a number over all points.
struct Range {
  double least = kInfinity;
  double greatest = -kInfinity;

  void extend(double x) {
    least = std::min(least, x);
    greatest = std::max(greatest, x);
  }
  double middle() const { return 0.5 * (least + greatest); }
  double extent() const { return greatest - least; }
};

// Returns the camera's displacement to the right, up and back from the box's centre. slope_x, slope_y: half the
// picture's sides at distance 1. From distance d behind the centre, a point is within the picture's right side if x -
// aside <= (d + z) slope_x, and so on: each side requires a distance, and opposite sides share it evenly.
Vec3d perspective_place(std::span<const Vec3d> points, const Vec3d& center, const CameraFrame& frame, double slope_x,
                        double slope_y) {
  double right = -kInfinity;
  double left = -kInfinity;
  double above = -kInfinity;
  double below = -kInfinity;
  double nearest = kInfinity;
  for (const Vec3d& p : points) {
    const Vec3d q = p - center;
    const double x = dot(q, frame.right) / slope_x;
    const double y = dot(q, frame.up) / slope_y;
    const double z = dot(q, frame.forward);
    right = std::max(right, x - z);
    left = std::max(left, -x - z);
    above = std::max(above, y - z);
    below = std::max(below, -y - z);
    nearest = std::min(nearest, z);
  }
  const double distance = std::max({0.5 * (right + left), 0.5 * (above + below), -nearest});
  return {0.5 * (right - left) * slope_x, 0.5 * (above - below) * slope_y, distance};
}

void check(const Camera& camera) {
  const bool finite = is_finite(camera.eye) && is_finite(camera.target) && is_finite(camera.up);
  if (!finite || !(norm(camera.target - camera.eye) > 0) || !(norm(camera.up) > 0)) {
    throw InvalidInput("render: the camera has no direction; give different points for eye and target, and an up");
  }
  if (!(camera.height > 0) || !std::isfinite(camera.height)) {
    throw InvalidInput("render: the camera's height is not positive; give the height that the picture shows");
  }
  if (!std::isfinite(camera.shift_x) || !std::isfinite(camera.shift_y)) {
    throw InvalidInput("render: the camera's shift is not finite; give a part of the picture");
  }
}

Mat4f clip_matrix(const View& view) {
  // Rows of the matrix on (p - eye): x and y by the frame, z and w by the depth range.
  const double depth = view.far - view.near;
  const Vec3d shift = view.perspective ? view.frame.forward : Vec3d{};
  const Vec3d rows[4] = {view.frame.right * (1 / norm(view.side)) + shift * view.shift_x,
                         view.frame.up * (1 / norm(view.top)) + shift * view.shift_y,
                         view.frame.forward * (view.perspective ? (view.far + view.near) / depth : 2 / depth),
                         view.perspective ? view.frame.forward : Vec3d{}};
  const double constants[4] = {view.perspective ? 0 : view.shift_x, view.perspective ? 0 : view.shift_y,
                               view.perspective ? -2 * view.far * view.near / depth : -(view.far + view.near) / depth,
                               view.perspective ? 0.0 : 1.0};
  Mat4f matrix{};
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 3; ++column) matrix[4 * column + row] = static_cast<float>(rows[row][column]);
    matrix[12 + row] = static_cast<float>(constants[row] - dot(rows[row], view.eye));
  }
  return matrix;
}

// Calls visit(p) for the finite positions of a mesh without outliers (see shape_box).
template <class Visit>
void visit_seen(const Mesh& mesh, const Visit& visit) {
  const bool all_finite = std::all_of(mesh.positions.begin(), mesh.positions.end(), is_finite);
  std::optional<Box> box;
  if (all_finite) box = shape_box(mesh);
  for (const Vec3d& p : mesh.positions) {
    if (is_finite(p) && (!box || contains(*box, p))) visit(p);
  }
}

// Calls visit(p) for the finite points of all that a scene shows.
template <class Visit>
void visit_seen(const Scene& scene, const Visit& visit) {
  const auto visit_finite = [&](const Vec3d& p) {
    if (is_finite(p)) visit(p);
  };
  for (const Shape& shape : scene.shapes) {
    if (shape.mesh != nullptr) visit_seen(*shape.mesh, visit);
  }
  for (const TranslucentSurface& surface : scene.surfaces) {
    std::for_each(surface.mesh.positions.begin(), surface.mesh.positions.end(), visit_finite);
  }
  for (const Line& line : scene.lines) std::for_each(line.points.begin(), line.points.end(), visit_finite);
  for (const Arrow& arrow : scene.arrows) {
    visit_finite(arrow.from);
    visit_finite(arrow.to);
  }
}

}  // namespace

Camera fit_camera(const Box& box, const Vec3d& direction, const Vec3d& up, double aspect, const FitOptions& options) {
  const Box fitted = box.empty() ? Box{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}} : box;
  const double usable = std::max(0.05, 1 - 2 * options.margin);
  Camera camera;
  camera.projection = options.projection;
  camera.target = fitted.center();
  camera.up = up;
  camera.eye = camera.target - direction;
  const CameraFrame frame = camera_frame(camera);
  // A single point has no size; far from the origin, the eye must still differ from it.
  const double least = 1e-9 * norm(camera.target);
  const double size = fitted.diagonal() > least ? fitted.diagonal() : std::max(least, 1.0);
  double half_height = 0;
  double distance = size;
  if (options.projection == Projection::orthographic) {
    for_each_corner(fitted, frame, [&](const Vec3d& c) {
      half_height = std::max({half_height, std::abs(c.y) / usable, std::abs(c.x) / (usable * aspect)});
    });
  } else {
    // |y| <= (distance + z) tan(half angle) for every corner, and the same for x.
    const double slope = std::tan(0.5 * std::clamp(options.field_of_view_deg, 1.0, 150.0) * std::numbers::pi / 180);
    for_each_corner(fitted, frame, [&](const Vec3d& c) {
      const double reach = std::max(std::abs(c.y), std::abs(c.x) / aspect) / (usable * slope);
      distance = std::max(distance, reach - c.z);
    });
    half_height = distance * slope;
  }
  camera.height = half_height > 0 ? 2 * half_height : 2 * size;
  camera.eye = camera.target - frame.forward * distance;
  return camera;
}

Camera fit_points(std::span<const Vec3d> points, const Vec3d& direction, const Vec3d& up, double aspect,
                  const FitOptions& options) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  // The camera for the box shows every shape; what follows only comes closer.
  Camera camera = fit_camera(box, direction, up, aspect, options);
  if (box.empty() || !(box.diagonal() > 1e-9 * norm(camera.target))) return camera;
  const CameraFrame frame = camera_frame(camera);
  const double usable = std::max(0.05, 1 - 2 * options.margin);
  const double distance = norm(camera.eye - camera.target);
  const Vec3d center = camera.target;
  if (options.projection == Projection::orthographic) {
    Range x;
    Range y;
    for (const Vec3d& p : points) {
      x.extend(dot(p - center, frame.right));
      y.extend(dot(p - center, frame.up));
    }
    const double height = std::max(y.extent(), x.extent() / aspect) / usable;
    if (!(height > 0)) return camera;
    camera.height = height;
    camera.target = center + frame.right * x.middle() + frame.up * y.middle();
    camera.eye = camera.target - frame.forward * distance;
    return camera;
  }
  const double slope = 0.5 * camera.height / distance;
  const Vec3d place = perspective_place(points, center, frame, usable * slope * aspect, usable * slope);
  if (!(place.z > 0)) return camera;
  camera.target = center + frame.right * place.x + frame.up * place.y;
  camera.eye = camera.target - frame.forward * place.z;
  camera.height = 2 * place.z * slope;
  return camera;
}

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
  view.shift_x = camera.shift_x;
  view.shift_y = camera.shift_y;
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
  constexpr double radius = 1.1;  // rods are thicker than the box
  return make_view(scene.camera, make_placement(scene_box(scene)), {{}, radius}, aspect, samples_high);
}

std::vector<Vec3d> ring(const Vec3d& center, const Vec3d& axis, double radius, int points) {
  const Vec3d a = any_orthogonal(axis);
  const Vec3d b = cross(normalized(axis), a);
  std::vector<Vec3d> circle;
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * std::numbers::pi * i / points;
    circle.push_back(center + (a * std::cos(angle) + b * std::sin(angle)) * radius);
  }
  return circle;
}

std::optional<Color> color_from(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  std::array<float, 3> channels{};
  for (std::size_t i = 0; i < 3; ++i) {
    int value = 0;
    const char* const end = text.data() + 2 * i + 3;
    const auto parsed = std::from_chars(end - 2, end, value, 16);
    if (parsed.ec != std::errc{} || parsed.ptr != end || value < 0) return std::nullopt;
    channels[i] = static_cast<float>(value) / 255;
  }
  return Color{channels[0], channels[1], channels[2], 1};
}

std::string text_of(const Color& color) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text = "#";
  for (const float channel : {color.red, color.green, color.blue}) {
    const auto value = static_cast<std::size_t>(std::lround(255 * std::clamp(channel, 0.0f, 1.0f)));
    text += digits[value / 16];
    text += digits[value % 16];
  }
  return text;
}

std::optional<Background> background_named(std::string_view name) {
  if (name == "gradient") return Background{{0.86f, 0.87f, 0.89f, 1}, {0.66f, 0.68f, 0.71f, 1}};
  if (name == "light") return Background{{0.95f, 0.955f, 0.96f, 1}, {0.95f, 0.955f, 0.96f, 1}};
  if (name == "dark") return Background{{0.15f, 0.155f, 0.165f, 1}, {0.15f, 0.155f, 0.165f, 1}};
  const std::optional<Color> color = color_from(name);
  if (!color) return std::nullopt;
  return Background{*color, *color};
}

Box shapes_box(const Scene& scene) {
  Box box;
  for (const Shape& shape : scene.shapes) {
    if (shape.mesh != nullptr) visit_seen(*shape.mesh, [&](const Vec3d& p) { box.extend(p); });
  }
  return box;
}

Box scene_box(const Scene& scene) {
  Box box;
  visit_seen(scene, [&](const Vec3d& p) { box.extend(p); });
  return box;
}

std::vector<Vec3d> scene_points(const Scene& scene) {
  std::size_t count = 0;
  for (const Shape& shape : scene.shapes) count += shape.mesh != nullptr ? shape.mesh->vertex_count() : 0;
  std::vector<Vec3d> points;
  points.reserve(count);
  visit_seen(scene, [&](const Vec3d& p) { points.push_back(p); });
  return points;
}

std::vector<Vec3d> outermost_points(std::span<const Vec3d> positions) {
  constexpr int directions = 64;  // evenly over the sphere, on a spiral
  std::vector<Vec3d> points;
  for (int k = 0; k < directions && !positions.empty(); ++k) {
    const double z = 1 - (2 * k + 1.0) / directions;
    const double angle = 2.399963 * k;  // the golden angle
    const double r = std::sqrt(1 - z * z);
    const Vec3d direction{r * std::cos(angle), z, r * std::sin(angle)};
    points.push_back(*std::max_element(positions.begin(), positions.end(), [&](const Vec3d& a, const Vec3d& b) {
      return dot(a, direction) < dot(b, direction);
    }));
  }
  return points;
}

std::vector<Vec3d> turntable_points(std::span<const Vec3d> positions, const Vec3d& middle, int count, bool is_z_up) {
  std::vector<Vec3d> points;
  for (const Vec3d& p : outermost_points(positions)) {
    for (int k = 0; k < count; ++k) points.push_back(middle + turntable_turn(k, count, is_z_up) * (p - middle));
  }
  return points;
}

}  // namespace knead::render
