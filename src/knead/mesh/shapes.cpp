#include "knead/mesh/shapes.h"

#include <array>
#include <cmath>
#include <string>

#include "knead/math/error.h"
#include "knead/mesh/polygonise.h"
#include "knead/mesh/shapes_grids.h"
#include "knead/mesh/shapes_solids.h"

namespace knead {
namespace {

constexpr std::array<std::string_view, 9> kNames{"sphere", "box",  "cylinder", "torus", "hand",
                                                 "crater", "knot", "letter-y", "figure"};
constexpr std::size_t kMost = 20'000'000;
constexpr std::array<ShapeCounts, 9> kCounts{{{12, 10'242, kMost},
                                              {28, 10'000, kMost},
                                              {100, 10'000, kMost},
                                              {60, 10'000, kMost},
                                              {4'000, 36'000, kMost},
                                              {100, 40'000, kMost},
                                              {600, 20'000, kMost},
                                              {1'000, 20'000, kMost},
                                              {4'000, 30'000, kMost}}};

// Searches for the cell size that gives this number of vertices, by counting the vertices of unrelaxed surfaces; then
// makes the surface.
Mesh make_solid(const shapes_detail::Solid& solid, std::size_t vertices) {
  const double wish = static_cast<double>(vertices);
  PolygoniseOptions options{std::sqrt(1.39 * solid.area / wish), 1, 0};
  for (int i = 0; i < 8; ++i) {
    const double count = static_cast<double>(polygonise(solid.distance, solid.box, options).vertex_count());
    if (std::abs(count / wish - 1) < 0.04) break;
    options.cell *= std::sqrt(count / wish);
  }
  options.relaxations = 8;
  return polygonise(solid.distance, solid.box, options);
}

Mesh make(ShapeKind kind, std::size_t vertices) {
  switch (kind) {
    case ShapeKind::sphere:
      return shapes_detail::make_sphere(vertices);
    case ShapeKind::box:
      return shapes_detail::make_box(vertices);
    case ShapeKind::cylinder:
      return shapes_detail::make_cylinder(vertices);
    case ShapeKind::torus:
      return shapes_detail::make_torus(vertices);
    case ShapeKind::hand:
      return make_solid(shapes_detail::hand_solid(), vertices);
    case ShapeKind::crater:
      return shapes_detail::make_crater(vertices);
    case ShapeKind::knot:
      return shapes_detail::make_knot(vertices);
    case ShapeKind::figure:
      return make_solid(shapes_detail::figure_solid(), vertices);
    case ShapeKind::letter_y:
      break;
  }
  return make_solid(shapes_detail::letter_y_solid(), vertices);
}

}  // namespace

std::span<const std::string_view> shape_names() { return kNames; }

ShapeKind shape_kind(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name) return static_cast<ShapeKind>(i);
    known += (i == 0 ? "" : ", ") + std::string(kNames[i]);
  }
  throw InvalidInput("there is no shape '" + std::string(name) + "'; choose one of " + known);
}

ShapeCounts shape_counts(ShapeKind kind) { return kCounts[static_cast<std::size_t>(kind)]; }

Mesh make_shape(ShapeKind kind, std::size_t vertices) {
  const ShapeCounts counts = shape_counts(kind);
  if (vertices == 0) vertices = counts.standard;
  if (vertices < counts.minimum || vertices > counts.maximum) {
    throw InvalidInput("a " + std::string(kNames[static_cast<std::size_t>(kind)]) + " of " + std::to_string(vertices) +
                       " vertices cannot be made; ask for " + std::to_string(counts.minimum) + " to " +
                       std::to_string(counts.maximum));
  }
  return make(kind, vertices);
}

}  // namespace knead
