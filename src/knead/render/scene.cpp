#include "knead/render/scene.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>

#include "knead/mesh/measures.h"

namespace knead::render {
namespace {

// Returns the finite positions of a mesh but those that lie astray (see shape_box).
std::vector<Vec3d> seen_points(const Mesh& mesh) {
  const bool all_finite = std::all_of(mesh.positions.begin(), mesh.positions.end(), is_finite);
  std::optional<Box> box;
  if (all_finite) box = shape_box(mesh);
  std::vector<Vec3d> points;
  for (const Vec3d& p : mesh.positions) {
    if (is_finite(p) && (!box || contains(*box, p))) points.push_back(p);
  }
  return points;
}

}  // namespace

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
    if (shape.mesh == nullptr) continue;
    for (const Vec3d& p : seen_points(*shape.mesh)) box.extend(p);
  }
  return box;
}

Box scene_box(const Scene& scene) {
  Box box;
  for (const Vec3d& p : scene_points(scene)) box.extend(p);
  return box;
}

std::vector<Vec3d> scene_points(const Scene& scene) {
  std::vector<Vec3d> points;
  const auto add = [&](const std::vector<Vec3d>& some) {
    std::copy_if(some.begin(), some.end(), std::back_inserter(points), [](const Vec3d& p) { return is_finite(p); });
  };
  for (const Shape& shape : scene.shapes) {
    if (shape.mesh != nullptr) add(seen_points(*shape.mesh));
  }
  for (const TranslucentSurface& surface : scene.surfaces) add(surface.mesh.positions);
  for (const Line& line : scene.lines) add(line.points);
  for (const Arrow& arrow : scene.arrows) add({arrow.from, arrow.to});
  return points;
}

}  // namespace knead::render
