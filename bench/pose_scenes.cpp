// Makes the scenes of pose_bench: beams and limbs of shapes.
#include "pose_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/polygonise.h"

namespace knead {

namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;
constexpr std::size_t kEnds = 8;
constexpr double kDragDegrees = 50;
constexpr double kTurnDegrees = 70;
constexpr int kPlaces = 10;  // of a pin's path

Vec3d turned(const Vec3d& p, const HandlesRotation& turn, double part = 1) {
  const Vec3d axis = normalized(turn.axis);
  const Vec3d r = p - turn.center;
  const double angle = turn.angle_deg * part * kRadiansPerDegree;
  return turn.center + r * std::cos(angle) + cross(axis, r) * std::sin(angle) +
         axis * (dot(axis, r) * (1 - std::cos(angle)));
}

template <class Chosen>
std::vector<std::uint32_t> vertices_where(const Mesh& mesh, const Chosen& chosen) {
  std::vector<std::uint32_t> result;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (chosen(mesh.positions[v])) result.push_back(v);
  }
  return result;
}

// --- beams ---------------------------------------------------------------------------------------------------------

constexpr double kHalfZone = 1;  // free length of a beam: 2
constexpr double kBeamDegrees = 60;
constexpr double kHalfThickness = 0.5;

// A beam along an axis, whose free middle becomes an arc of its own length.
PoseScene beam(const std::string& name, ShapeKind kind, std::size_t along) {
  PoseScene scene{name + ", turn", make_shape(kind, 8000)};
  const std::size_t across = (along + 1) % 3;
  scene.moving = vertices_where(scene.mesh, [&](const Vec3d& p) { return p[along] > kHalfZone; });
  scene.fixed = vertices_where(scene.mesh, [&](const Vec3d& p) { return p[along] < -kHalfZone; });
  const double phi = kBeamDegrees * kRadiansPerDegree;
  const double radius = 2 * kHalfZone / phi;
  const double by_x = -2 * kHalfZone + radius * std::sin(phi);  // how the end of the zone moves
  const double by_y = radius * (1 - std::cos(phi));
  const double side = 0.5 / std::tan(phi / 2);
  Vec3d center{0, 0, 0};
  center[along] = kHalfZone + 0.5 * by_x - side * by_y;
  center[across] = 0.5 * by_y + side * by_x;
  Vec3d axis{0, 0, 0};
  axis[(along + 2) % 3] = 1;
  scene.turn = HandlesRotation{axis, center, kBeamDegrees};
  BendStroke bend;
  bend.axis = axis;
  bend.normal[along] = -1;
  bend.angle_deg = kBeamDegrees;
  bend.extent = BendWidth{2 * kHalfZone};
  scene.bend = bend;
  scene.least_strain = phi * kHalfThickness / (2 * kHalfZone);
  return scene;
}

// --- limbs ---------------------------------------------------------------------------------------------------------

// Returns vertices that are far from the middle and from each other: the ends of limbs.
std::vector<std::uint32_t> ends_of(const Mesh& mesh) {
  Vec3d middle{0, 0, 0};
  for (const Vec3d& p : mesh.positions) middle += p / static_cast<double>(mesh.positions.size());
  std::vector<double> distance(mesh.positions.size(), std::numeric_limits<double>::infinity());
  std::vector<std::uint32_t> ends;
  while (ends.size() < kEnds) {
    std::uint32_t farthest = 0;
    double most = -1;
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      const double d = ends.empty() ? norm(mesh.positions[v] - middle) : distance[v];
      if (d > most) std::tie(most, farthest) = std::pair(d, v);
    }
    ends.push_back(farthest);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      distance[v] = std::min(distance[v], norm(mesh.positions[v] - mesh.positions[farthest]));
    }
  }
  return ends;
}

// The lengths of the shortest paths along edges from a vertex.
std::vector<double> edge_distances(const Mesh& mesh, std::uint32_t from) {
  std::vector<std::vector<std::uint32_t>> neighbors(mesh.positions.size());
  for (const Triangle& t : triangulate(mesh)) {
    for (std::size_t i = 0; i < 3; ++i) {
      neighbors[t[i]].push_back(t[(i + 1) % 3]);
      neighbors[t[(i + 1) % 3]].push_back(t[i]);
    }
  }
  std::vector<double> distance(mesh.positions.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.emplace(distance[from] = 0, from);
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    for (const std::uint32_t w : neighbors[v]) {
      const double through = d + norm(mesh.positions[w] - mesh.positions[v]);
      if (through < distance[w]) queue.emplace(distance[w] = through, w);
    }
  }
  return distance;
}

Vec3d across(const Vec3d& limb) { return normalized(cross(limb, {0.3, 0.5, 0.8})); }

// One of eight pins at ends goes round by 50 degrees about a point half-way to the middle.
PoseScene drag(const std::string& name, const Mesh& mesh) {
  PoseScene scene{name + ", drag", mesh};
  std::vector<std::uint32_t> ends = ends_of(mesh);
  scene.moving = {ends[1]};
  ends.erase(ends.begin() + 1);
  scene.fixed = std::move(ends);
  Vec3d middle{0, 0, 0};
  for (const Vec3d& p : mesh.positions) middle += p / static_cast<double>(mesh.positions.size());
  const Vec3d tip = mesh.positions[scene.moving.front()];
  const Vec3d hinge = tip + (middle - tip) * 0.5;
  const HandlesRotation turn{across(tip - hinge), hinge, kDragDegrees};
  for (int i = 1; i <= kPlaces; ++i) scene.path.push_back(turned(tip, turn, static_cast<double>(i) / kPlaces));
  return scene;
}

// Of the axes across a limb, the one that takes its tip farthest from what stays.
HandlesRotation freest_turn(const PoseScene& scene, const Vec3d& tip, const Vec3d& hinge) {
  constexpr int kAxes = 16;
  const HandlesRotation about{tip - hinge, hinge, 360.0 / kAxes};
  HandlesRotation best;
  double most = -1;
  for (int k = 0; k < kAxes; ++k) {
    const Vec3d axis = turned(hinge + across(tip - hinge), about, k) - hinge;
    const HandlesRotation turn{axis, hinge, kTurnDegrees};
    const Vec3d place = turned(tip, turn);
    double least = HUGE_VAL;
    for (const std::uint32_t v : scene.fixed) least = std::min(least, norm(scene.mesh.positions[v] - place));
    if (least > most) std::tie(most, best) = std::pair(least, turn);
  }
  return best;
}

// An end of a shape, and the ring around its limb.
struct Limb {
  std::uint32_t tip = 0;
  std::vector<double> distance;  // of each vertex along the surface, of the diagonal
  Vec3d hinge{0, 0, 0};          // the middle of the ring
  double radius = HUGE_VAL;      // of the ring
};

Limb limb_at(const Mesh& mesh, std::uint32_t tip, double diagonal) {
  constexpr double kHinge = 0.24;
  constexpr double kHalfRing = 0.01;
  Limb limb;
  limb.tip = tip;
  limb.distance = edge_distances(mesh, tip);
  std::vector<Vec3d> ring;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    limb.distance[v] /= diagonal;
    if (std::abs(limb.distance[v] - kHinge) < kHalfRing) ring.push_back(mesh.positions[v]);
  }
  const auto count = static_cast<double>(ring.size());
  for (const Vec3d& p : ring) limb.hinge += p / count;
  if (ring.empty()) return limb;
  limb.radius = 0;
  for (const Vec3d& p : ring) limb.radius += norm(p - limb.hinge) / count;
  return limb;
}

// A pin takes the tip of a limb to where the turn takes it, and pins at the other ends hold.
PoseScene drag_of_tip(const std::string& name, const Mesh& mesh, const Limb& limb, const HandlesRotation& turn) {
  constexpr double kApart = 0.1;  // of the diagonal: ends of the same limb
  PoseScene scene{name + ", tip", mesh};
  scene.moving = {limb.tip};
  for (const std::uint32_t end : ends_of(mesh)) {
    if (limb.distance[end] > kApart) scene.fixed.push_back(end);
  }
  for (int i = 1; i <= kPlaces; ++i) {
    scene.path.push_back(turned(mesh.positions[limb.tip], turn, static_cast<double>(i) / kPlaces));
  }
  return scene;
}

// The end of the thinnest limb turns, and everything far away stays; or a pin takes its tip there.
std::vector<PoseScene> scenes_of_limb(const std::string& name, const Mesh& mesh) {
  constexpr double kPart = 0.17;  // of the diagonal, along the surface from the tip
  constexpr double kStays = 0.5;  // and farther than this from the tip in space: not its neighbours
  PoseScene scene{name + ", turn", mesh};
  const double diagonal = bounding_box(mesh.positions).diagonal();
  Limb thinnest;
  for (const std::uint32_t end : ends_of(mesh)) {
    Limb limb = limb_at(mesh, end, diagonal);
    if (limb.radius < thinnest.radius) thinnest = std::move(limb);
  }
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const double d = thinnest.distance[v];
    if (d < kPart) scene.moving.push_back(v);
    const bool is_far = norm(mesh.positions[v] - mesh.positions[thinnest.tip]) > kStays * diagonal;
    if (is_far && d > kStays && d < HUGE_VAL) scene.fixed.push_back(v);
  }
  scene.turn = freest_turn(scene, mesh.positions[thinnest.tip], thinnest.hinge);
  return {scene, drag_of_tip(name, mesh, thinnest, *scene.turn)};
}

// The index finger turns towards the palm, and the wrist holds.
PoseScene finger() {
  PoseScene scene{"hand, turn", make_shape(ShapeKind::hand, 8000)};
  const Finger& index = hand_fingers()[1];
  const auto is_finger = [&](const Vec3d& p) {
    const Vec3d r = p - index.base;
    return dot(r, index.axis) > 0.1 && norm(cross(r, index.axis)) < index.radius;
  };
  scene.moving = vertices_where(scene.mesh, is_finger);
  scene.fixed = vertices_where(scene.mesh, [](const Vec3d& p) { return p.y < -0.6; });
  scene.turn = HandlesRotation{{1, 0, 0}, index.base - index.axis * 0.05, kTurnDegrees};
  BendStroke bend;
  bend.center = scene.turn->center + index.axis * 0.05;
  bend.axis = scene.turn->axis;
  bend.normal = index.axis * -1.0;
  bend.angle_deg = kTurnDegrees;
  bend.extent = BendWidth{0.2};
  bend.radius_auto = true;
  scene.bend = bend;
  return scene;
}

// --- the animal ----------------------------------------------------------------------------------------------------

struct Bone {
  Vec3d a;
  Vec3d b;
  double radius = 0;
};

constexpr std::array<Bone, 12> kAnimal{{{{-0.9, 1.5, 0}, {0.8, 1.55, 0}, 0.62},
                                        {{1.2, 1.9, 0}, {1.5, 1.95, 0}, 0.45},
                                        {{1.8, 1.75, 0}, {2.2, 1.2, 0}, 0.2},
                                        {{2.2, 1.2, 0}, {2.3, 0.6, 0}, 0.16},
                                        {{2.3, 0.6, 0}, {2.55, 0.25, 0}, 0.13},
                                        {{0.75, 1.3, 0.35}, {0.75, 0.2, 0.4}, 0.24},
                                        {{0.75, 1.3, -0.35}, {0.75, 0.2, -0.4}, 0.24},
                                        {{-0.95, 1.3, 0.35}, {-0.95, 0.2, 0.4}, 0.24},
                                        {{-0.95, 1.3, -0.35}, {-0.95, 0.2, -0.4}, 0.24},
                                        {{1.2, 2.0, 0.4}, {0.95, 1.75, 1.0}, 0.13},
                                        {{1.2, 2.0, -0.4}, {0.95, 1.75, -1.0}, 0.13},
                                        {{-1.45, 1.6, 0}, {-1.95, 1.0, 0}, 0.09}}};

double distance_to(const Bone& bone, const Vec3d& p) {
  const Vec3d along = bone.b - bone.a;
  const double t = std::clamp(dot(p - bone.a, along) / norm2(along), 0.0, 1.0);
  return norm(p - bone.a - along * t) - bone.radius;
}

// Smooth where bones meet: -log of the sum of exp(-distance).
double animal(const Vec3d& p) {
  constexpr double kSharpness = 25;
  double sum = 0;
  for (const Bone& bone : kAnimal) sum += std::exp(-kSharpness * distance_to(bone, p));
  return -std::log(sum) / kSharpness;
}

}  // namespace

Vec3d PoseScene::place_of(std::uint32_t vertex, double part) const {
  if (turn) return turned(mesh.positions[vertex], *turn, part);
  const auto places = static_cast<double>(path.size());
  return path[static_cast<std::size_t>(std::max(0.0, std::round(part * places) - 1))];
}

std::vector<PoseScene> procedural_scenes() {
  std::vector<PoseScene> scenes{beam("bar", ShapeKind::box, 0), beam("cylinder", ShapeKind::cylinder, 2), finger(),
                                drag("hand", make_shape(ShapeKind::hand, 8000))};
  const Mesh mesh = polygonise(animal, {{-2.3, -0.3, -1.4}, {2.9, 2.7, 1.4}}, {.cell = 0.065});
  for (PoseScene& scene : scenes_of("animal", mesh)) scenes.push_back(std::move(scene));
  return scenes;
}

std::vector<PoseScene> scenes_of(const std::string& name, const Mesh& mesh) {
  std::vector<PoseScene> scenes = scenes_of_limb(name, mesh);
  scenes.push_back(drag(name, mesh));
  return scenes;
}

}  // namespace knead
