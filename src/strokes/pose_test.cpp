// The tool "pose" on surfaces: rigid limbs, exact ends, drags, bits and refusals.
#include "strokes/pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/body_points.h"
#include "support/surface.h"

namespace knead::pose_test {
namespace {

struct Posed : test::MovedSurface {
  using MovedSurface::MovedSurface;

  PoseResult pose(const PoseStroke& stroke, int threads = 0) { return pose_on(stroke, live(threads), threads); }
};

std::vector<VertexRange> vertices_where(const Mesh& mesh, const std::function<bool(const Vec3d&)>& is_wanted) {
  std::vector<VertexRange> ranges;
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    if (is_wanted(mesh.positions[i])) ranges.push_back({i, i});
  }
  return ranges;
}

// The upper end of a cylinder bends by an angle, the lower one holds.
PoseStroke bent_cylinder(const Mesh& mesh, double angle_deg) {
  PosePart hold;
  hold.hold = true;
  hold.vertices = vertices_where(mesh, [](const Vec3d& p) { return p.z < -1.5; });
  PosePart part;
  part.vertices = vertices_where(mesh, [](const Vec3d& p) { return p.z > 1.5; });
  part.rotation = HandlesRotation{{1, 0, 0}, {0, 0, 0}, angle_deg};
  PoseStroke stroke;
  stroke.detail = 0.075;
  stroke.parts = {hold, part};
  return stroke;
}

double volume_of(const Mesh& mesh) { return measure(mesh).volume; }

// Of all triangles: the least and the greatest singular value, by their greatest and the area.
double greatest_stretch_of(const Mesh& before, const Mesh& after) {
  double greatest = 0;
  for (const Triangle& t : triangulate(before)) {
    const auto corners = [&](const Mesh& mesh) {
      return std::array{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
    };
    greatest = std::max(greatest, triangle_stretch(corners(before), corners(after)).value_or(1));
  }
  return greatest;
}

TEST(Pose, ACylinderBendsAsNearlyRigidAsCanBe) {
  const Mesh before = make_shape(ShapeKind::cylinder, 6000);
  Posed shape(before);
  const PoseResult result = shape.pose(bent_cylinder(before, 70));
  EXPECT_NEAR(volume_of(shape.mesh) / volume_of(before), 1, 1e-4);
  EXPECT_EQ(self_intersections(shape.triangles, shape.mesh.positions).count, 0u);
  // Half-thickness 0.5, bent by 1.22 over an arc of 2.6 that was 3 long: 0.67 to 1.07 at least.
  EXPECT_LT(greatest_stretch_of(before, shape.mesh), 1.5);
  EXPECT_LT(result.part_distance, 1e-3);
  EXPECT_LT(result.greatest_stretch, 1.5);
  EXPECT_GT(result.least_stretch, 0.6);
  EXPECT_EQ(shape.applied.size(), result.segments);
  for (const Stroke& part : shape.applied) EXPECT_TRUE(std::holds_alternative<GridStroke>(part));
}

// The pointer goes there, farther, and back; the drag ends about where the whole stroke does.
TEST(PoseDrag, EndsAboutWhereTheStrokeDoes) {
  const Mesh before = make_shape(ShapeKind::cylinder, 3000);
  Posed whole(before);
  whole.pose(bent_cylinder(before, 40));
  Posed dragged(before);
  PoseDrag drag(bent_cylinder(before, 5), dragged.live());
  for (const double angle : {5, 12, 25, 50, 70, 55, 40, 40, 40}) {
    const PoseStroke stroke = bent_cylinder(before, angle);
    ASSERT_TRUE(drag.takes(stroke));
    dragged.applied.clear();
    EXPECT_TRUE(drag.advance(stroke, 3, dragged.live().apply));
    EXPECT_LE(dragged.applied.size(), 4U);
  }
  double apart = 0;
  for (std::size_t i = 0; i < before.vertex_count(); ++i) {
    apart = std::max(apart, norm(whole.mesh.positions[i] - dragged.mesh.positions[i]));
  }
  EXPECT_LT(apart, 0.02) << "of a cylinder 4 long";
  EXPECT_EQ(self_intersections(dragged.triangles, dragged.mesh.positions).count, 0U);
}

TEST(PoseDrag, FollowsAPinAndKnowsItsOwnPose) {
  const Mesh before = make_shape(ShapeKind::cylinder, 3000);
  PosePin pin;
  pin.point = Vec3d{0, 0.5, 1.9};
  PosePin held;
  held.point = Vec3d{0, 0, -2};
  held.hold = true;
  PoseStroke stroke;
  const auto to = [&](const Vec3d& place) {
    pin.path = {place};
    stroke.parts = {pin, held};
    return stroke;
  };
  Posed shape(before);
  PoseDrag drag(to({0.1, 0.5, 1.9}), shape.live());
  for (const Vec3d& place : {Vec3d{0.1, 0.5, 1.9}, Vec3d{0.3, 0.5, 1.8}, Vec3d{0.5, 0.5, 1.7}, Vec3d{0.5, 0.5, 1.7}}) {
    EXPECT_TRUE(drag.takes(to(place)));
    EXPECT_TRUE(drag.advance(to(place), 3, shape.live().apply));
  }
  const auto nearest = [](const Mesh& mesh, const Vec3d& p) {
    double least = 1e9;
    for (const Vec3d& q : mesh.positions) least = std::min(least, norm(q - p));
    return least;
  };
  EXPECT_LT(nearest(shape.mesh, {0.5, 0.5, 1.7}), nearest(before, *pin.point) + 0.01);
  EXPECT_LT(nearest(shape.mesh, {0, 0, -2}), nearest(before, {0, 0, -2}) + 0.01);

  PoseStroke finer = to({0.5, 0.5, 1.7});
  finer.detail = 0.05;
  EXPECT_FALSE(drag.takes(finer));
  PoseStroke other = to({0.5, 0.5, 1.7});
  other.parts.pop_back();
  EXPECT_FALSE(drag.takes(other));
}

TEST(Pose, TheBitsDependNeitherOnThreadsNorOnTheOrderOfVertices) {
  const Mesh before = make_shape(ShapeKind::hand, 4000);
  const auto moves = [](const Vec3d& p) { return p.y > 0.6; };
  const auto holds = [](const Vec3d& p) { return p.y < -0.6; };
  const auto stroke_on = [&](const Mesh& mesh) {
    PosePart hold;
    hold.hold = true;
    hold.vertices = vertices_where(mesh, holds);
    PosePart part;
    part.vertices = vertices_where(mesh, moves);
    part.rotation = HandlesRotation{{1, 0, 0}, {0, 0.4, 0}, 25};
    part.translation = Vec3d{0.02, 0, 0.01};
    PoseStroke stroke;
    stroke.parts = {hold, part};
    return stroke;
  };
  Posed one(before);
  one.pose(stroke_on(before), 1);
  Posed two(before);
  two.pose(stroke_on(before), 2);
  EXPECT_EQ(one.mesh.positions, two.mesh.positions);

  std::vector<std::uint32_t> order(before.vertex_count());
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end(), std::mt19937(4));
  Mesh permuted;
  permuted.positions.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) permuted.positions[order[i]] = before.positions[i];
  for (const Triangle& t : triangulate(before)) {
    const Triangle moved{order[t[0]], order[t[1]], order[t[2]]};
    permuted.add_face(moved);
  }
  Posed three(permuted);
  three.pose(stroke_on(permuted), 0);
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(three.mesh.positions[order[i]], one.mesh.positions[i]) << i;
}

TEST(Pose, ExactTakesPinsToTheirPlaces) {
  const Mesh before = make_shape(ShapeKind::cylinder, 3000);
  PoseStroke stroke;
  PosePin moving;
  PosePin held;
  for (std::uint32_t i = 0; i < before.vertex_count(); ++i) {
    if (!moving.vertex || before.positions[i].z > before.positions[*moving.vertex].z) moving.vertex = i;
    if (!held.vertex || before.positions[i].z < before.positions[*held.vertex].z) held.vertex = i;
  }
  const Vec3d place = before.positions[*moving.vertex] + Vec3d{0.8, 0.1, -0.2};
  moving.path = {before.positions[*moving.vertex] + Vec3d{0.5, 0, 0}, place};
  held.hold = true;
  stroke.parts = {moving, held};
  for (const bool exact : {false, true}) {
    Posed shape(before);
    stroke.exact = exact;
    shape.pose(stroke);
    EXPECT_LT(norm(shape.mesh.positions[*moving.vertex] - place), exact ? 3e-5 : 6e-3);
    EXPECT_LT(norm(shape.mesh.positions[*held.vertex] - before.positions[*held.vertex]), exact ? 3e-5 : 6e-3);
  }
}

TEST(Pose, StiffRegionsStretchLess) {
  const Mesh before = make_shape(ShapeKind::cylinder, 3000);
  PoseStroke stroke = bent_cylinder(before, 40);
  const auto in_middle = [](const Vec3d& p) { return std::abs(p.z) < 0.4; };
  const auto stretch_of_middle = [&] {
    Posed shape(before);
    shape.pose(stroke);
    const std::vector<float> stretches = vertex_stretches(shape.triangles, before.positions, shape.mesh.positions);
    double sum = 0;
    for (std::size_t i = 0; i < before.vertex_count(); ++i) {
      if (in_middle(before.positions[i])) sum += stretches[i] - 1;
    }
    return sum;
  };
  const double plain = stretch_of_middle();
  stroke.stiffness = {{vertices_where(before, in_middle), 20}};
  EXPECT_LT(stretch_of_middle(), 0.6 * plain);
}

// Nothing has moved after a refusal.
void expect_refused(const Mesh& before, const PoseStroke& stroke, const std::string& part_of_message) {
  Posed shape(before);
  try {
    shape.pose(stroke);
    ADD_FAILURE() << "not refused: " << part_of_message;
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find(part_of_message), std::string::npos) << error.what();
  }
  EXPECT_EQ(shape.mesh.positions, before.positions);
  EXPECT_TRUE(shape.applied.empty());
}

TEST(Pose, RefusesWhatCannotBe) {
  const Mesh mesh = make_shape(ShapeKind::cylinder, 1000);
  const PoseStroke good = bent_cylinder(mesh, 30);
  PoseStroke stroke = good;
  std::get<PosePart>(stroke.parts[1]).vertices.push_back(std::get<PosePart>(stroke.parts[0]).vertices.front());
  expect_refused(mesh, stroke, "is in part");
  stroke = good;
  std::get<PosePart>(stroke.parts[1]).vertices = {{0, 5'000}};
  std::get<PosePart>(stroke.parts[0]).vertices = {};
  expect_refused(mesh, stroke, "part 1: it has no vertices");
  stroke = good;
  std::get<PosePart>(stroke.parts[1]).vertices = {{5'000, 5'001}};
  expect_refused(mesh, stroke, "names vertex 5001, but the shape has");
  stroke = good;
  std::get<PosePart>(stroke.parts[1]).rotation->angle_deg = 0;
  expect_refused(mesh, stroke, "none of the parts and pins moves");
  stroke = good;
  stroke.detail = 0.001;
  expect_refused(mesh, stroke, "\"detail\" must be from");
  stroke = good;
  for (std::uint32_t i = 0; i < 1001; ++i) {
    PosePin pin;
    pin.point = Vec3d{0.1 * i, 0, 0};
    pin.hold = true;
    stroke.parts.push_back(pin);
  }
  expect_refused(mesh, stroke, "at most 1000 pins");
  PosePin pin;
  pin.point = Vec3d{0.5, 0, 0};
  pin.path = {{0.5, 0.3, 0}};
  PosePin other = pin;
  other.point = Vec3d{0.5, 0.01, 0};
  other.path = {{0.5, -0.3, 0}};
  stroke.parts = {pin, other};
  expect_refused(mesh, stroke, "go different ways");
  pin.path = {{1e9, 0, 0}};
  stroke.parts = {pin};
  expect_refused(mesh, stroke, "steps");
  pin.path = {{0.6, 0, 0}};
  other.point = Vec3d{1e30, 0, 0};
  other.path.clear();
  other.hold = true;
  stroke.parts = {pin, other};
  expect_refused(mesh, stroke, "is far from the shape");
  stroke.parts = {pin};
  expect_refused(Mesh{}, stroke, "has no vertices");
  Mesh point;
  point.positions = {{0, 0, 0}};
  expect_refused(point, stroke, "has no extent");
}

// The result is sound, and something is said if it is not all that was asked for.
PoseResult expect_sound(const Mesh& before, const PoseStroke& stroke) {
  Posed shape(before);
  const PoseResult result = shape.pose(stroke);
  EXPECT_EQ(self_intersections(shape.triangles, shape.mesh.positions).count, 0u);
  EXPECT_LT(surface_stretch(shape.triangles, before.positions, shape.mesh.positions).worst(), 6.1);
  EXPECT_EQ(result.shortfall.empty(), result.reached == 1 && result.part_distance <= stroke.tolerance);
  return result;
}

// A part that would have to pass through another one comes as far as it can.
TEST(Pose, ComesAsFarAsItIsSound) {
  const Mesh mesh = make_shape(ShapeKind::cylinder, 3000);
  PoseStroke stroke = bent_cylinder(mesh, 30);
  auto& part = std::get<PosePart>(stroke.parts[1]);
  part.rotation.reset();
  part.translation = Vec3d{0, 0, -4.5};
  for (const double detail : {0.075, 0.0}) {  // the usual one is tried twice
    stroke.detail = detail;
    const PoseResult result = expect_sound(mesh, stroke);
    EXPECT_GT(result.reached, 0.1);
    EXPECT_LT(result.reached, 0.9);
    EXPECT_NE(result.shortfall.find("% of its way"), std::string::npos) << result.shortfall;
  }
}

// A finger that slides along another one, which holds.
TEST(Pose, DoesNotDentWhatHolds) {
  Mesh mesh = make_shape(ShapeKind::cylinder, 3000);
  const auto count = static_cast<std::uint32_t>(mesh.positions.size());
  const Mesh one = mesh;
  for (const Vec3d& p : one.positions) mesh.positions.push_back(p + Vec3d{1.02, 0, 0});
  for (const Triangle& t : triangulate(one)) mesh.add_face(Triangle{t[0] + count, t[1] + count, t[2] + count});
  PoseStroke stroke;
  stroke.detail = 0.075;
  PosePart holds;
  holds.hold = true;
  holds.vertices = {{count, 2 * count - 1}};
  PosePart moves;
  moves.vertices = {{0, count - 1}};
  moves.translation = Vec3d{0, 0, 1};
  stroke.parts = {holds, moves};
  expect_sound(mesh, stroke);
}

// One stroke turns an end by 180 degrees, about an axis beside the cylinder.
TEST(Pose, TurnsByHalfACircleInOneStroke) {
  const Mesh mesh = make_shape(ShapeKind::cylinder, 3000);
  PoseStroke stroke = bent_cylinder(mesh, -180);
  std::get<PosePart>(stroke.parts[1]).rotation->center = {0, 0.955, 0};  // an arc as long as what bends
  const PoseResult result = expect_sound(mesh, stroke);
  EXPECT_EQ(result.reached, 1) << result.shortfall;
  EXPECT_EQ(result.shortfall, "");
}

// A quarter of the thickness, within bounds, as a fraction of the size.
TEST(Pose, TheUsualDetailIsThatOfTheThickness) {
  for (const double thickness : {0.3, 1.0, 20.0}) {
    Mesh mesh = make_shape(ShapeKind::cylinder, 3000);
    for (Vec3d& p : mesh.positions) p = {thickness * p.x, thickness * p.y, p.z};
    const Posed shape(mesh);
    LiveSurface surface;
    surface.positions = mesh.positions;
    surface.triangles = shape.triangles;
    const double size = norm(Vec3d{thickness, thickness, 6});
    const double expected = std::clamp(0.25 * thickness / size, 0.02, 0.075);
    EXPECT_NEAR(detail::usual_detail(bent_cylinder(mesh, 30), surface), expected, 0.05 * expected) << thickness;
  }
}

TEST(Pose, OpenSurfacesAndCloudsArePosedByTheirShell) {
  const Mesh closed = make_shape(ShapeKind::cylinder, 4000);
  Mesh open;
  open.positions = closed.positions;
  for (const Triangle& t : triangulate(closed)) {
    const bool is_cap = std::ranges::all_of(t, [&](std::uint32_t v) { return closed.positions[v].z < -2.99; });
    if (!is_cap) open.add_face(t);
  }
  Posed shape(open);
  const PoseResult result = shape.pose(bent_cylinder(open, 50));
  EXPECT_LT(result.part_distance, 2e-3);
  EXPECT_LT(result.greatest_stretch, 1.5);
  Mesh cloud;
  cloud.positions = closed.positions;
  Posed points(cloud);
  EXPECT_LT(points.pose(bent_cylinder(cloud, 50)).part_distance, 2e-3);
}

TEST(BodyPoints, AreInsideAndFillTheBody) {
  const Mesh ball = make_shape(ShapeKind::sphere, 2000);
  const std::vector<Triangle> triangles = triangulate(ball);
  const BodyPoints body = body_points(ball.positions, triangles, {.inside = 3000});
  EXPECT_TRUE(body.is_closed);
  EXPECT_NEAR(static_cast<double>(body.inside), 3000, 100);
  Vec3d sum{0, 0, 0};
  for (std::size_t i = 0; i < body.inside; ++i) {
    EXPECT_LT(norm(body.points[i]), 1);
    sum += body.points[i];
  }
  EXPECT_LT(norm(sum) / 3000, 0.01);
  for (std::size_t i = body.inside; i < body.points.size(); ++i) EXPECT_NEAR(norm(body.points[i]), 1, 0.02);
  // A surface that is inside out bounds the same body.
  std::vector<Triangle> turned = triangles;
  for (Triangle& t : turned) std::swap(t[0], t[1]);
  EXPECT_EQ(body_points(ball.positions, turned, {.inside = 3000}).inside, body.inside);
}

// What an open surface bounds does not depend on the triangle that comes first.
TEST(BodyPoints, TheOrderOfTrianglesDoesNotMatter) {
  const Mesh ball = make_shape(ShapeKind::sphere, 2000);
  std::vector<Triangle> triangles;
  for (const Triangle& t : triangulate(ball)) {
    if (ball.positions[t[0]].z > -0.3) triangles.push_back(t);
  }
  const BodyPoints body = body_points(ball.positions, triangles, {.inside = 3000});
  EXPECT_TRUE(body.is_closed);
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    std::shuffle(triangles.begin(), triangles.end(), std::mt19937(seed));
    const BodyPoints shuffled = body_points(ball.positions, triangles, {.inside = 3000});
    ASSERT_EQ(shuffled.inside, body.inside);
    for (std::size_t i = 0; i < body.inside; ++i) EXPECT_LT(norm(shuffled.points[i] - body.points[i]), 1e-9);
  }
}

TEST(BodyPoints, FacesWithoutAreaAreACloud) {
  const std::vector<Vec3d> positions{{0, 0, 0}, {1, 2, 3}, {-1, 0, 2}};
  const std::vector<Triangle> triangles{{0, 1, 1}, {1, 0, 0}};
  const BodyPoints body = body_points(positions, triangles, {.most_spacing = 0.1, .shell_depth = 0.1});
  EXPECT_FALSE(body.is_closed);
  EXPECT_EQ(body.points.size(), positions.size());
}

TEST(BodyPoints, SpreadPointsDoNotDependOnTheOrder) {
  const Mesh ball = make_shape(ShapeKind::sphere, 5000);
  std::vector<Vec3d> shuffled = ball.positions;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(7));
  const std::vector<std::uint32_t> a = spread_points(ball.positions, 150);
  const std::vector<std::uint32_t> b = spread_points(shuffled, 150);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_GT(a.size(), 90u);
  EXPECT_LE(a.size(), 150u);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(ball.positions[a[i]], shuffled[b[i]]);
}

}  // namespace
}  // namespace knead::pose_test
