// Small meshes and strokes that bytes choose: non-manifold, degenerate, doubled and inverted ones among them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/session.h"

namespace knead::fuzz {

// Reads one choice after the other. After the last byte every choice is the first one.
class Choices {
 public:
  explicit Choices(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }
  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t result = bytes_[0];
    bytes_ = bytes_.subspan(1);
    return result;
  }
  std::size_t below(std::size_t count) { return (byte() | std::size_t{byte()} << 8) % count; }
  bool flag() { return byte() % 2 != 0; }

  // From -2 to 2 in steps of 1/32, often the same numbers; sometimes a little off, or extreme.
  double number() {
    const double value = (byte() - 128) / 64.0 * 2;
    const std::uint8_t kind = byte();
    if (kind < 200) return std::round(value * 8) / 8;
    if (kind < 240) return value;
    if (kind < 248) return value + std::ldexp(1.0, -20 - kind % 8 * 4);
    static constexpr std::array<double, 8> kExtreme{0, 1e-300, 1e-4, 1e-2, 5, 8, 16, 30};
    return kExtreme[kind % 8];
  }
  double positive() { return std::abs(number()); }
  Vec3d vector() {
    const double x = number();
    const double y = number();
    return {x, y, number()};
  }
  std::vector<Vec3d> vectors(std::size_t least, std::size_t most) {
    std::vector<Vec3d> result(least + below(most - least + 1));
    for (Vec3d& v : result) v = vector();
    return result;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

inline Mesh random_faces(Choices& choices) {
  Mesh mesh;
  mesh.positions = choices.vectors(3, 20);
  const std::size_t faces = 1 + choices.below(40);
  for (std::size_t f = 0; f < faces; ++f) {
    std::vector<std::uint32_t> face(choices.byte() < 200 ? 3 : 3 + choices.below(4));
    for (std::uint32_t& v : face) v = static_cast<std::uint32_t>(choices.below(mesh.vertex_count()));
    mesh.add_face(face);
  }
  return mesh;
}

// A shape with some faces repeated, turned over or joined to other vertices, and some vertices put elsewhere.
inline Mesh damaged_shape(Choices& choices, std::size_t most) {
  static constexpr std::array<ShapeKind, 3> kKinds{ShapeKind::sphere, ShapeKind::box, ShapeKind::torus};
  const ShapeKind kind = kKinds[choices.below(kKinds.size())];
  Mesh mesh = make_shape(kind, kind == ShapeKind::sphere ? 12 + choices.below(most - 11) : shape_counts(kind).minimum);
  for (std::size_t changes = choices.below(12); changes > 0; --changes) {
    const std::size_t f = choices.below(mesh.face_count());
    const std::size_t v = choices.below(mesh.vertex_count());
    const std::size_t corner = mesh.face_begin[f] + choices.below(3);
    switch (choices.below(5)) {
      case 0:
        mesh.add_face(std::vector<std::uint32_t>(mesh.face(f).begin(), mesh.face(f).end()));
        break;
      case 1:
        std::swap(mesh.corner_vertex[mesh.face_begin[f]], mesh.corner_vertex[mesh.face_begin[f] + 1]);
        break;
      case 2:
        mesh.corner_vertex[corner] = static_cast<std::uint32_t>(v);
        break;
      case 3:
        mesh.positions[v] = mesh.positions[mesh.corner_vertex[corner]];
        break;
      default:
        mesh.positions[v] = choices.vector();
        break;
    }
  }
  return mesh;
}

// `most`: vertices of a sphere.
inline Mesh mesh(Choices& choices, std::size_t most = 162) {
  Mesh mesh = choices.flag() ? damaged_shape(choices, most) : random_faces(choices);
  if (choices.flag()) {
    Attribute uv{"uv", Domain::corner, NumberType::float32, 2, std::vector<double>(2 * mesh.corner_vertex.size())};
    for (std::size_t i = 0; i < uv.values.size(); ++i) uv.values[i] = choices.empty() ? i % 3 : choices.byte() / 64;
    mesh.attributes.push_back(std::move(uv));
  }
  return mesh;
}

inline Stroke points_stroke(Choices& choices) {
  PointsStroke stroke;
  stroke.points = choices.vectors(1, 5);
  if (choices.flag()) stroke.curves.push_back(choices.vectors(2, 4));
  stroke.outer = choices.positive();
  stroke.displacements = choices.vectors(1, 3);
  return stroke;
}

inline Stroke handles_stroke(Choices& choices, std::size_t vertices) {
  HandlesStroke stroke;
  if (choices.flag()) {
    for (std::size_t n = 1 + choices.below(6); n > 0; --n) {
      stroke.full_vertices.push_back(static_cast<std::uint32_t>(choices.below(vertices)));
      stroke.zero_vertices.push_back(static_cast<std::uint32_t>(choices.below(vertices)));
    }
  } else {
    stroke.full = choices.vectors(1, 6);
    stroke.zero = choices.vectors(1, 6);
  }
  stroke.motion = HandlesTranslation{choices.vector()};
  if (choices.flag()) {
    HandlesRotation turn;
    turn.axis = choices.vector();
    turn.center = choices.vector();
    turn.angle_deg = 90 * choices.number();
    stroke.motion = turn;
  }
  return stroke;
}

inline Stroke limit_cylinder_stroke(Choices& choices) {
  const bool has_radius = choices.flag();
  const bool is_auto = choices.flag();
  if (choices.flag()) {
    TwistStroke stroke;
    stroke.center = choices.vector();
    stroke.axis = choices.vector();
    stroke.rate_deg = 90 * choices.number();
    stroke.inner = choices.number();
    stroke.outer = stroke.inner + choices.positive();
    stroke.radius_auto = has_radius && is_auto;
    if (has_radius && !is_auto) stroke.radius = choices.positive();
    return stroke;
  }
  BendStroke stroke;
  stroke.center = choices.vector();
  stroke.axis = choices.vector();
  stroke.normal = choices.vector();
  stroke.angle_deg = 60 * choices.number();
  stroke.extent = BendWidth{choices.positive()};
  stroke.radius_auto = has_radius && is_auto;
  if (has_radius && !is_auto) stroke.radius = choices.positive();
  return stroke;
}

inline Stroke ball_stroke(Choices& choices) {
  const Vec3d center = choices.vector();
  const Vec3d axis = choices.vector();
  const double outer = choices.positive();
  const double inner = outer * choices.byte() / 256;
  if (choices.flag()) return RotateStroke{center, axis, 90 * choices.number(), inner, outer};
  return StretchStroke{center, axis, std::exp(choices.number()), inner, outer};
}

inline Stroke implicit_stroke(Choices& choices) {
  ImplicitStroke stroke;
  stroke.path = choices.vectors(2, 4);
  stroke.outer = choices.positive();
  stroke.inner = stroke.outer * choices.byte() / 256;
  if (choices.flag()) {
    stroke.region = ImplicitRegion::capsule;
    stroke.half_axis = choices.vector();
  }
  return stroke;
}

inline Stroke paint_stroke(Choices& choices) {
  PaintStroke stroke;
  stroke.outer = choices.positive();
  stroke.depth = choices.number();
  if (choices.flag()) {
    stroke.path = choices.vectors(1, 4);
  } else {
    stroke.samples = {{choices.vector(), choices.vector()}};
  }
  return stroke;
}

inline Stroke pins_stroke(Choices& choices) {
  PinsStroke stroke;
  stroke.points = choices.vectors(1, 6);
  for (const Vec3d& p : stroke.points) stroke.to.push_back(choices.flag() ? p : p + choices.vector());
  stroke.radius_auto = choices.flag();
  if (!stroke.radius_auto) stroke.radius = choices.positive();
  return stroke;
}

inline Stroke grid_stroke(Choices& choices) {
  GridStroke stroke;
  stroke.grid.origin = choices.vector();
  stroke.grid.spacing = choices.positive();
  const std::vector<Vec3d> coefficients = choices.vectors(1, 4);
  stroke.grid.counts = {1, static_cast<int>(coefficients.size()), 1};
  stroke.grid.coefficients = SharedVectors(coefficients);
  return stroke;
}

inline Stroke relax_stroke(Choices& choices) {
  RelaxStroke stroke;
  stroke.points = choices.vectors(1, 3);
  stroke.radius = choices.positive();
  stroke.iterations = 1 + static_cast<int>(choices.below(4));
  return stroke;
}

inline Stroke mask_stroke(Choices& choices) {
  MaskStroke stroke;
  stroke.points = choices.vectors(0, 4);
  if (!stroke.points.empty()) stroke.width = choices.positive();
  return stroke;
}

// A stroke of any tool but the stamp, which needs a file. Some are invalid.
inline Stroke stroke(Choices& choices, std::size_t vertices) {
  Stroke result;
  switch (choices.below(10)) {
    case 0:
      result = paint_stroke(choices);
      break;
    case 1:
      result = points_stroke(choices);
      break;
    case 2:
      result = handles_stroke(choices, vertices);
      break;
    case 3:
      result = limit_cylinder_stroke(choices);
      break;
    case 4:
      result = ball_stroke(choices);
      break;
    case 5:
      result = relax_stroke(choices);
      break;
    case 6:
      result = mask_stroke(choices);
      break;
    case 7:
      result = pins_stroke(choices);
      break;
    case 8:
      result = grid_stroke(choices);
      break;
    default:
      result = implicit_stroke(choices);
      break;
  }
  if (falloff_of(result)) set_falloff(result, 3 + static_cast<int>(choices.below(5)));
  return result;
}

// A session of up to so many strokes, each with a strength.
inline std::vector<SessionStroke> strokes(Choices& choices, std::size_t most, std::size_t vertices) {
  std::vector<SessionStroke> result(1 + choices.below(most));
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].stroke = stroke(choices, vertices);
    result[i].line = i + 2;
    if (choices.byte() > 220) result[i].strength = choices.byte() / 255.0 * kMaxStrength;
  }
  return result;
}

}  // namespace knead::fuzz
