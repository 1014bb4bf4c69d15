// Poses of scans: a finger turns, one of eight pins is dragged. `./dev test -R PoseOnScans -V` prints the figures.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/vec.h"
#include "support/test_meshes.h"

namespace knead::pose_test {
namespace {

// What a deformation does to the triangles of a mesh.
struct TriangleStretch {
  double least = 1;
  double greatest = 1;
  double rms_log = 0;  // of both singular values, weighted by area
};

TriangleStretch stretch_of(const std::vector<Triangle>& triangles, const std::vector<Vec3d>& before,
                           const std::vector<Vec3d>& after) {
  TriangleStretch result;
  double sum = 0;
  double all = 0;
  for (const Triangle& t : triangles) {
    const Vec3d a = before[t[1]] - before[t[0]];
    const Vec3d b = before[t[2]] - before[t[0]];
    const double area = norm(cross(a, b));
    if (is_degenerate(before[t[0]], before[t[1]], before[t[2]])) continue;
    // The columns of the linear map, in an orthonormal basis of the triangle's plane.
    const Vec3d x = (after[t[1]] - after[t[0]]) / norm(a);
    const Vec3d y = (after[t[2]] - after[t[0]] - x * (dot(a, b) / norm(a))) * (norm(a) / area);
    const double mean = 0.5 * (norm2(x) + norm2(y));
    const double half = std::hypot(0.5 * (norm2(x) - norm2(y)), dot(x, y));
    const double greatest = std::sqrt(mean + half);
    const double least = norm(cross(x, y)) / greatest;
    result.greatest = std::max(result.greatest, greatest);
    result.least = std::min(result.least, least);
    sum += area * 0.5 * (std::pow(std::log(greatest), 2) + std::pow(std::log(least), 2));
    all += area;
  }
  result.rms_log = std::sqrt(sum / all);
  return result;
}

struct PosedShape {
  Mesh before;
  std::vector<Vec3d> after;
  double diagonal = 0;

  PosedShape(const Mesh& mesh, const Stroke& stroke) : before(mesh), diagonal(bounding_box(mesh.positions).diagonal()) {
    Session session;
    session.strokes.push_back({stroke});
    after = replay(mesh, session).shape.positions();
  }

  TriangleStretch stretch() const { return stretch_of(triangulate(before), before.positions, after); }
  double volume_error() const { return measure_volume_and_area(before, after).volume / measure(before).volume - 1; }
  std::size_t crossings() const { return self_intersections(triangulate(before), after).count; }
};

std::vector<VertexRange> vertices_where(const Mesh& mesh, const std::function<bool(const Vec3d&)>& is_wanted) {
  std::vector<VertexRange> ranges;
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    if (!is_wanted(mesh.positions[i])) continue;
    if (!ranges.empty() && ranges.back().last + 1 == i) {
      ranges.back().last = i;
    } else {
      ranges.push_back({i, i});
    }
  }
  return ranges;
}

// The finger turns by 70 degrees towards the palm, the wrist holds.
void expect_finger_turns(const Mesh& mesh, const Vec3d& base, const Vec3d& along, const Vec3d& axis,
                         const std::function<bool(const Vec3d&)>& is_finger,
                         const std::function<bool(const Vec3d&)>& is_wrist) {
  PosePart finger;
  finger.vertices = vertices_where(mesh, is_finger);
  finger.rotation = HandlesRotation{axis, base - along, 70};
  PosePart wrist;
  wrist.vertices = vertices_where(mesh, is_wrist);
  wrist.hold = true;
  PoseStroke stroke;
  stroke.parts = {finger, wrist};
  const PosedShape posed(mesh, stroke);
  const TriangleStretch stretch = posed.stretch();
  fmt::print("stretch {:.3f} to {:.3f}, rms of its logarithm {:.4f}, volume {:+.1e}\n", stretch.least, stretch.greatest,
             stretch.rms_log, posed.volume_error());
  EXPECT_LT(std::abs(posed.volume_error()), 1e-4);
  EXPECT_EQ(posed.crossings(), 0u);
  EXPECT_GT(stretch.least, 0.5);
  EXPECT_LT(stretch.greatest, 1.5);
  EXPECT_LT(stretch.rms_log, 0.08);
  double farthest = 0;
  const double angle = 70 * std::numbers::pi / 180;
  for (const VertexRange& range : finger.vertices) {
    for (std::uint32_t v = range.first; v <= range.last; ++v) {
      const Vec3d d = mesh.positions[v] - finger.rotation->center;
      const Vec3d place = finger.rotation->center + d * std::cos(angle) + cross(axis, d) * std::sin(angle) +
                          axis * (dot(axis, d) * (1 - std::cos(angle)));
      farthest = std::max(farthest, norm(posed.after[v] - place));
    }
  }
  EXPECT_LT(farthest, 2e-3 * posed.diagonal);
}

TEST(PoseOnScans, AFingerOfTheProceduralHandTurns) {
  const Mesh mesh = make_shape(ShapeKind::hand, 12000);
  const Finger index = hand_fingers()[1];
  const Vec3d axis = normalized(cross(index.axis, Vec3d{0, 0, 1}));
  const auto is_finger = [&](const Vec3d& p) {
    const double s = dot(p - index.base, index.axis);
    return s > 0.45 * index.length && norm(p - index.base - index.axis * s) < index.radius;
  };
  expect_finger_turns(mesh, index.base + index.axis * (0.25 * index.length), Vec3d{0, 0, 0}, axis, is_finger,
                      [](const Vec3d& p) { return p.y < -0.4; });
}

std::vector<VertexRange> ranges_of(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
  std::vector<bool> is_wanted(mesh.vertex_count(), false);
  for (const std::uint32_t v : vertices) is_wanted[v] = true;
  std::uint32_t next = 0;
  return vertices_where(mesh, [&](const Vec3d&) { return is_wanted[next++]; });
}

// The limb at a place turns by 70 degrees, and all else holds but for what bends about its joint: limbs beside it, too.
void expect_limb_turns(const Mesh& mesh, const Vec3d& place, const Vec3d& axis) {
  const std::vector<Triangle> triangles = triangulate(mesh);
  const auto nearer = [&](const Vec3d& a, const Vec3d& b) { return norm2(a - place) < norm2(b - place); };
  const auto nearest = std::min_element(mesh.positions.begin(), mesh.positions.end(), nearer);
  const Limb limb = find_limb(mesh.positions, triangles, static_cast<std::uint32_t>(nearest - mesh.positions.begin()));
  PosePart finger;
  finger.vertices = ranges_of(mesh, limb.vertices);
  finger.rotation = HandlesRotation{axis, limb.joint + limb.direction * (0.75 * limb.girth / std::numbers::pi), 70};
  PosePart rest;
  rest.vertices = ranges_of(mesh, limb.body);
  rest.hold = true;
  PoseStroke stroke;
  stroke.parts = {finger, rest};
  const PosedShape posed(mesh, stroke);
  double square = 0;
  double greatest = 0;
  for (const std::uint32_t v : limb.body) {
    const double off = norm(posed.after[v] - mesh.positions[v]) / posed.diagonal;
    square += off * off / static_cast<double>(limb.body.size());
    greatest = std::max(greatest, off);
  }
  const TriangleStretch stretch = posed.stretch();
  fmt::print("stretch {:.3f} to {:.3f}, rms of its logarithm {:.4f}, volume {:+.1e}, held {:.1e} rms, {:.1e} at most\n",
             stretch.least, stretch.greatest, stretch.rms_log, posed.volume_error(), std::sqrt(square), greatest);
  EXPECT_LT(std::abs(posed.volume_error()), 1e-4);
  EXPECT_EQ(posed.crossings(), 0u);
  EXPECT_GT(stretch.least, 0.25);
  EXPECT_LT(stretch.greatest, 2.5);
  EXPECT_LT(stretch.rms_log, 0.075);
  EXPECT_LT(std::sqrt(square), 1e-3);
  EXPECT_LT(greatest, 8e-3);
}

TEST(PoseOnScans, AFingerTurnsBetweenOthersThatHold) {
  const Mesh mesh = make_shape(ShapeKind::hand, 12000);
  for (const int number : {1, 2, 4}) {
    const Finger finger = hand_fingers()[static_cast<std::size_t>(number)];
    expect_limb_turns(mesh, finger.base + finger.axis * (0.7 * finger.length),
                      normalized(cross(finger.axis, Vec3d{0, 0, 1})));
  }
}

TEST(PoseOnScans, AFingerOfTheScannedHandTurnsBetweenOthersThatHold) {
  KNEAD_NEEDS_TEST_MESH("hand_50k.ply");
  expect_limb_turns(read_shape(test_mesh("hand_50k.ply")).mesh, {-2.6, 0.4, 1.5}, normalized(Vec3d{0.18, 0.24, 0.95}));
}

// Eight pins at the ends of the limbs; one goes along an arc of 50 degrees.
TEST(PoseOnScans, OneOfEightPinsIsDraggedAlongAnArc) {
  KNEAD_NEEDS_TEST_MESH("armadillo_43k.ply");
  const Mesh mesh = read_shape(test_mesh("armadillo_43k.ply")).mesh;
  const double diagonal = bounding_box(mesh.positions).diagonal();
  Vec3d middle{0, 0, 0};
  for (const Vec3d& p : mesh.positions) middle += p / static_cast<double>(mesh.vertex_count());
  std::vector<double> distance;
  for (const Vec3d& p : mesh.positions) distance.push_back(norm(p - middle));
  std::vector<std::uint32_t> ends;
  while (ends.size() < 8) {
    ends.push_back(static_cast<std::uint32_t>(std::max_element(distance.begin(), distance.end()) - distance.begin()));
    for (std::size_t i = 0; i < distance.size(); ++i) {
      const double own = norm(mesh.positions[i] - mesh.positions[ends.back()]);
      distance[i] = ends.size() == 1 ? own : std::min(distance[i], own);
    }
  }
  const Vec3d tip = mesh.positions[ends[1]];
  const Vec3d hinge = (tip + middle) * 0.5;
  const Vec3d axis = normalized(cross(tip - hinge, Vec3d{0.3, 0.5, 0.8}));
  PoseStroke pose;
  PinsStroke pins;
  pins.radius_auto = true;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    PosePin pin;
    pin.vertex = ends[k];
    pin.hold = k != 1;
    for (int i = 1; i <= 10 && !pin.hold; ++i) {
      const double angle = 5 * i * std::numbers::pi / 180;
      const Vec3d d = tip - hinge;
      pin.path.push_back(hinge + d * std::cos(angle) + cross(axis, d) * std::sin(angle));
    }
    pins.points.push_back(mesh.positions[ends[k]]);
    pins.to.push_back(pin.hold ? pins.points.back() : pin.path.back());
    pose.parts.emplace_back(pin);
  }
  const PosedShape posed(mesh, pose);
  const TriangleStretch by_pose = posed.stretch();
  const TriangleStretch by_pins = PosedShape(mesh, pins).stretch();
  fmt::print("rms of log stretch {:.4f}, with pins {:.4f}; stretch {:.2f} to {:.2f}; volume {:+.1e}\n", by_pose.rms_log,
             by_pins.rms_log, by_pose.least, by_pose.greatest, posed.volume_error());
  EXPECT_EQ(posed.crossings(), 0u);
  EXPECT_LT(std::abs(posed.volume_error()), 2e-4);
  EXPECT_LT(norm(posed.after[ends[1]] - pins.to[1]), 2e-3 * diagonal);
  EXPECT_LT(by_pose.rms_log, by_pins.rms_log / 3);
}

}  // namespace
}  // namespace knead::pose_test
