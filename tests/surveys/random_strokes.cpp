#include "random_strokes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "knead/editor/tools.h"
#include "knead/vec.h"

namespace knead::surveys {

namespace {

// What a generator draws from: the shape and the dice.
struct Draw {
  const Mesh& mesh;
  const std::vector<Vec3d>& normals;
  const std::string& stamp_mesh;
  std::mt19937_64& random;
  double size;  // the box's diagonal

  double uniform(double low, double high) const { return std::uniform_real_distribution<double>(low, high)(random); }
  double sign() const { return uniform(-1, 1) < 0 ? -1 : 1; }
  Vec3d direction() const {
    for (;;) {
      const Vec3d v{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      if (norm(v) > 0.1 && norm(v) < 1) return normalized(v);
    }
  }
  std::size_t vertex() const {
    return std::uniform_int_distribution<std::size_t>(0, mesh.positions.size() - 1)(random);
  }
  Vec3d near(std::size_t v) const { return mesh.positions[v] + normals[v] * (uniform(-0.02, 0.02) * size); }

  // Vertices whose distance from p lies in a range, at most `count`, evenly thinned.
  std::vector<std::size_t> vertices_between(const Vec3d& p, double low, double high, std::size_t count) const {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const double distance = norm(mesh.positions[i] - p);
      if (low <= distance && distance < high) all.push_back(i);
    }
    std::vector<std::size_t> result;
    const std::size_t stride = std::max<std::size_t>(1, all.size() / count);
    for (std::size_t i = 0; i < all.size(); i += stride) result.push_back(all[i]);
    return result;
  }
};

Stroke implicit(const Draw& draw) {
  ImplicitStroke stroke;
  const std::size_t v = draw.vertex();
  stroke.outer = draw.uniform(0.05, 0.25) * draw.size;
  stroke.inner = draw.uniform(0.1, 0.7) * stroke.outer;
  stroke.path = {draw.near(v)};
  const int pieces = 1 + static_cast<int>(draw.uniform(0, 3));
  const double length = draw.uniform(0.02, 0.2) * draw.size / pieces;
  Vec3d way = draw.direction();
  for (int i = 0; i < pieces; ++i) {
    stroke.path.push_back(stroke.path.back() + way * length);
    way = normalized(way + draw.direction() * 0.5);
  }
  if (draw.uniform(0, 1) < 0.4) {
    stroke.region = ImplicitRegion::capsule;
    stroke.half_axis = draw.direction() * (draw.uniform(0.02, 0.15) * draw.size);
  } else if (draw.uniform(0, 1) < 0.5) {
    stroke.falloff = kWideFalloff;
    stroke.bump = 0.5 * stroke.outer;
    stroke.outer = draw.uniform(2, 4) * stroke.bump;
    if (draw.uniform(0, 1) < 0.3) stroke.core = draw.uniform(0.1, 0.8);
    stroke.inner = 0;
  }
  if (draw.uniform(0, 1) < 0.3) stroke.taper = draw.uniform(0.1, 1);
  return stroke;
}

Stroke paint(const Draw& draw) {
  PaintStroke stroke;
  stroke.outer = draw.uniform(0.03, 0.12) * draw.size;
  stroke.depth = draw.sign() * draw.uniform(0.1, 0.5) * stroke.outer;
  Vec3d p = draw.mesh.positions[draw.vertex()];
  Vec3d way = draw.direction();
  const int points = 1 + static_cast<int>(draw.uniform(0, 6));
  for (int i = 0; i < points; ++i) {
    stroke.path.push_back(p);
    p += way * stroke.outer;
    way = normalized(way + draw.direction() * 0.4);
  }
  if (draw.uniform(0, 1) < 0.5) {
    stroke.falloff = kWideFalloff;
    stroke.bump = std::exchange(stroke.outer, 0);
    if (draw.uniform(0, 1) < 0.5) stroke.pinch = draw.uniform(-1.5, 1.5);
    if (stroke.pinch != 0) stroke.depth = draw.uniform(-0.3, 0.3) * std::abs(stroke.pinch) * stroke.bump;
  }
  return stroke;
}

Stroke points(const Draw& draw) {
  PointsStroke stroke;
  const Vec3d p = draw.mesh.positions[draw.vertex()];
  stroke.outer = draw.uniform(0.05, 0.2) * draw.size;
  const std::vector<std::size_t> around = draw.vertices_between(p, 0, 0.7 * stroke.outer, 6);
  for (const std::size_t v : around) stroke.points.push_back(draw.mesh.positions[v]);
  if (draw.uniform(0, 1) < 0.5) stroke.curves.push_back({p, p + draw.direction() * stroke.outer});
  const int moves = 1 + static_cast<int>(draw.uniform(0, 3));
  for (int i = 0; i < moves; ++i) {
    stroke.displacements.push_back(draw.direction() * (draw.uniform(0.1, 0.5) * stroke.outer));
  }
  return stroke;
}

Stroke handles(const Draw& draw) {
  HandlesStroke stroke;
  const Vec3d p = draw.mesh.positions[draw.vertex()];
  const double inner = draw.uniform(0.03, 0.1) * draw.size;
  const double outer = inner + draw.uniform(0.1, 0.25) * draw.size;
  for (const std::size_t v : draw.vertices_between(p, 0, inner, 40)) stroke.full.push_back(draw.mesh.positions[v]);
  for (const std::size_t v : draw.vertices_between(p, outer, 10 * draw.size, 150)) {
    stroke.zero.push_back(draw.mesh.positions[v]);
  }
  stroke.motion = HandlesTranslation{draw.direction() * (draw.uniform(0.1, 0.5) * (outer - inner))};
  if (draw.uniform(0, 1) < 0.5) stroke.motion = HandlesRotation{draw.direction(), p, draw.uniform(-45, 45)};
  return stroke;
}

Stroke stamp(const Draw& draw) {
  StampStroke stroke;
  stroke.mesh = draw.stamp_mesh;
  const std::size_t v = draw.vertex();
  const Vec3d p = draw.mesh.positions[v];
  const double scale = draw.uniform(0.05, 0.12) * draw.size;
  const Vec3d z = draw.normals[v];
  const Vec3d x = any_orthogonal(z);
  const Vec3d y = cross(z, x);
  stroke.pose = {Vec3d{x.x, y.x, z.x} * scale, Vec3d{x.y, y.y, z.y} * scale, Vec3d{x.z, y.z, z.z} * scale};
  const double depth = draw.uniform(0.1, 0.5) * scale;
  stroke.path = {p + z * (1.1 * scale), p + z * (scale - depth)};
  return stroke;
}

Stroke turn(const Draw& draw) {
  const std::size_t v = draw.vertex();
  const double outer = draw.uniform(0.05, 0.3) * draw.size;
  return RotateStroke{draw.near(v), draw.direction(), draw.sign() * draw.uniform(10, 120), draw.uniform(0, 0.6) * outer,
                      outer};
}

Stroke stretch(const Draw& draw) {
  const std::size_t v = draw.vertex();
  const double outer = draw.uniform(0.05, 0.3) * draw.size;
  return StretchStroke{draw.near(v), draw.direction(), std::exp(draw.uniform(-0.7, 0.7)), draw.uniform(0, 0.6) * outer,
                       outer};
}

Stroke twist(const Draw& draw) {
  const Box box = bounding_box(draw.mesh.positions);
  const double width = draw.uniform(0.2, 0.8) * draw.size;
  TwistStroke stroke{box.center() + draw.direction() * (0.1 * draw.size), draw.direction(),
                     draw.sign() * draw.uniform(10, 90) / width, -draw.uniform(0, 0.5) * width, 0};
  stroke.outer = stroke.inner + width;
  return stroke;
}

Stroke bend(const Draw& draw) {
  const Box box = bounding_box(draw.mesh.positions);
  const Vec3d axis = draw.direction();
  BendStroke stroke{box.center() + draw.direction() * (0.1 * draw.size), axis,
                    normalized(cross(axis, draw.direction())), draw.sign() * draw.uniform(10, 70),
                    BendWidth{draw.uniform(0.3, 0.8) * draw.size}};
  return stroke;
}

// Some of a few vertices go their own ways, the others are held; none comes near the others' ways.
Stroke pins(const Draw& draw) {
  PinsStroke stroke;
  stroke.radius = draw.uniform(0.1, 0.4) * draw.size;
  const double room = 0.6 * *stroke.radius;
  const int count = 1 + static_cast<int>(draw.uniform(0, 8));
  for (int tries = 0; tries < 40 * count && static_cast<int>(stroke.points.size()) < count; ++tries) {
    const Vec3d p = draw.mesh.positions[draw.vertex()];
    const bool is_near = std::any_of(stroke.points.begin(), stroke.points.end(),
                                     [&](const Vec3d& other) { return norm(other - p) < room; });
    if (is_near) continue;
    const double way = draw.uniform(0, 1) < 0.6 ? draw.uniform(0.1, 0.4) * room : 0;
    stroke.points.push_back(p);
    stroke.to.push_back(p + draw.direction() * way);
  }
  if (draw.uniform(0, 1) < 0.6) return stroke;
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    const PinRotation rotation{draw.direction(), draw.uniform(-40, 40)};
    stroke.turn.push_back(draw.uniform(0, 1) < 0.5 ? std::optional(rotation) : std::nullopt);
  }
  return stroke;
}

// The line is longer than the shape is wide, and bends little, so that no part reaches its centre.
Stroke curve(const Draw& draw) {
  CurveStroke stroke;
  const Vec3d along = draw.direction() * (0.5 * draw.size);
  const Vec3d center = draw.mesh.positions[draw.vertex()];
  stroke.from = {center - along, center + along};
  stroke.angle_deg = draw.sign() * draw.uniform(3, 8);
  stroke.axis = any_orthogonal(along);
  stroke.twist_deg = draw.sign() * draw.uniform(0, 10);
  stroke.fixed = static_cast<CurveFixed>(draw.uniform(0, 2.99));
  return stroke;
}

// A box about a place, whose inner control points move.
Stroke lattice(const Draw& draw) {
  LatticeStroke stroke;
  const Vec3d x = draw.direction();
  const Vec3d y = any_orthogonal(x);
  stroke.axes = {x, y, cross(x, y)};
  const double half = draw.uniform(0.15, 0.4) * draw.size;
  stroke.origin = draw.near(draw.vertex()) - (x + y + cross(x, y)) * half;
  stroke.lengths = Vec3d{2, 2, 2} * half;
  stroke.counts = {5, 6, 5};
  stroke.displacements.resize(150);
  for (const std::size_t inner : {72U, 77U})
    stroke.displacements[inner] = draw.direction() * (draw.uniform(0, 0.4) * half);
  stroke.mode = static_cast<LatticeMode>(draw.uniform(0, 2.99));
  return stroke;
}

// A cap turns, or a pin goes its way; pins far from there hold.
Stroke pose(const Draw& draw) {
  PoseStroke stroke;
  stroke.detail = draw.uniform(0.1, 0.15);
  const Vec3d p = draw.mesh.positions[draw.vertex()];
  if (draw.uniform(0, 1) < 0.5) {
    PosePart part;
    for (const std::size_t v : draw.vertices_between(p, 0, 0.12 * draw.size, 100)) {
      part.points.push_back(draw.mesh.positions[v]);
    }
    part.rotation = HandlesRotation{draw.direction(), p, draw.sign() * draw.uniform(5, 15)};
    if (draw.uniform(0, 1) < 0.5) part.translation = draw.direction() * (0.03 * draw.size);
    stroke.parts.emplace_back(part);
  } else {
    PosePin pin;
    pin.point = p;
    pin.path = {p + draw.direction() * (0.03 * draw.size), p + draw.direction() * (0.06 * draw.size)};
    pin.size = draw.uniform(0.02, 0.04);
    pin.turns_freely = draw.uniform(0, 1) < 0.5;
    if (!pin.turns_freely && draw.uniform(0, 1) < 0.5) pin.rotation = PinRotation{draw.direction(), 20};
    stroke.parts.emplace_back(pin);
  }
  for (const std::size_t v : draw.vertices_between(p, 0.4 * draw.size, draw.size, 4)) {
    PosePin pin;
    pin.point = draw.mesh.positions[v];
    pin.hold = true;
    stroke.parts.emplace_back(pin);
  }
  return stroke;
}

// Lengths without rounding, so that the mirror image of the mirror image is the stroke itself.
Stroke grid(const Draw& draw) {
  const double unit = std::ldexp(1, std::ilogb(draw.size) - 20);
  const auto rounded = [&](double length) { return std::round(length / unit) * unit; };
  const Vec3d place = draw.mesh.positions[draw.vertex()];
  GridStroke stroke;
  PotentialGrid& grid = stroke.grid;
  grid.spacing = rounded(draw.uniform(0.1, 0.2) * draw.size);
  std::size_t nodes = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.counts[axis] = 1 + static_cast<int>(draw.uniform(0, 5));
    grid.origin[axis] = rounded(place[axis] - 0.5 * (grid.counts[axis] - 1) * grid.spacing);
    nodes *= static_cast<std::size_t>(grid.counts[axis]);
  }
  const auto coefficients = [&] {
    std::vector<Vec3d> list(nodes);
    for (Vec3d& a : list) a = draw.direction() * (draw.uniform(0, 0.15) * grid.spacing * grid.spacing);
    return SharedVectors(std::move(list));
  };
  grid.coefficients = coefficients();
  if (draw.uniform(0, 1) < 0.3) grid.end_coefficients = coefficients();
  return stroke;
}

Stroke inflate(const Draw& draw) {
  const Vec3d p = draw.mesh.positions[draw.vertex()];
  const double radius = draw.uniform(0.08, 0.2) * draw.size;
  return InflateStroke{{p, p + draw.direction() * (0.3 * radius)},
                       radius,
                       draw.sign() * draw.uniform(0.001, 0.006) * radius * radius * radius};
}

Stroke print(const Draw& draw) {
  PrintStroke stroke;
  stroke.file = draw.stamp_mesh;
  stroke.point = draw.near(draw.vertex());
  stroke.up = draw.direction();
  stroke.height = draw.uniform(0.1, 0.2) * draw.size;
  stroke.depth = draw.sign() * draw.uniform(0.05, 0.2) * stroke.height;
  if (draw.uniform(0, 1) < 0.3) stroke.outer = draw.uniform(0.6, 3) * stroke.height;
  stroke.flip = draw.uniform(0, 1) < 0.3;
  return stroke;
}

Stroke relax(const Draw& draw) {
  const std::size_t v = draw.vertex();
  RelaxStroke stroke{{draw.near(v), draw.near(v)}, draw.uniform(0.05, 0.3) * draw.size};
  stroke.amount = draw.uniform(0.1, 1);
  stroke.surface = draw.uniform(0, 1);
  stroke.iterations = 1 + static_cast<int>(draw.uniform(0, 4));
  return stroke;
}

Stroke mask(const Draw& draw) {
  MaskStroke stroke;
  const Vec3d p = draw.mesh.positions[draw.vertex()];
  stroke.width = draw.uniform(0.03, 0.1) * draw.size;
  for (const std::size_t v : draw.vertices_between(p, 0, draw.uniform(0.1, 0.4) * draw.size, 400)) {
    stroke.points.push_back(draw.mesh.positions[v]);
    stroke.values.push_back(draw.uniform(0, 1) < 0.7 ? 1 : draw.uniform(0, 1));
  }
  return stroke;
}

const std::vector<std::pair<std::string, Stroke (*)(const Draw&)>> kTools{
    {"implicit", implicit}, {"paint", paint},     {"points", points},   {"handles", handles}, {"stamp", stamp},
    {"rotate", turn},       {"stretch", stretch}, {"twist", twist},     {"bend", bend},       {"pins", pins},
    {"pose", pose},         {"grid", grid},       {"inflate", inflate}, {"relax", relax},     {"mask", mask},
    {"curve", curve},       {"print", print},     {"lattice", lattice}};

}  // namespace

const std::vector<std::string>& tool_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const auto& tool : kTools) {
      if (!find_tool(tool.first)->is_event) names.push_back(tool.first);
    }
    return names;
  }();
  return kNames;
}

Stroke random_stroke(const std::string& tool, const Mesh& mesh, const std::vector<Vec3d>& normals,
                     const std::string& stamp_mesh, std::mt19937_64& random) {
  const Draw draw{mesh, normals, stamp_mesh, random, bounding_box(mesh.positions).diagonal()};
  for (const auto& [name, make] : kTools) {
    if (name == tool) return make(draw);
  }
  throw std::invalid_argument("no tool " + tool);
}

}  // namespace knead::surveys
