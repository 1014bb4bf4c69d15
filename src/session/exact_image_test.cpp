// Faces that are too coarse for a motion are refused, and others are not.
#include <gtest/gtest.h>

#include <string>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead::exact_image_test {
namespace {

// A bar of 12 triangles, 10 x 2 x 2, of any size.
Mesh bar(double scale = 1) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(Vec3d{i & 1 ? 5.0 : -5.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0} * scale);
  }
  for (const Triangle& t : {Triangle{0, 2, 3},
                            {0, 3, 1},
                            {4, 5, 7},
                            {4, 7, 6},
                            {0, 1, 5},
                            {0, 5, 4},
                            {2, 6, 7},
                            {2, 7, 3},
                            {0, 4, 6},
                            {0, 6, 2},
                            {1, 3, 7},
                            {1, 7, 5}}) {
    mesh.add_face(t);
  }
  return mesh;
}

SessionStroke stroke_of(const Stroke& stroke) {
  SessionStroke line;
  line.stroke = stroke;
  return line;
}

Session twist(double degrees, double scale = 1) {
  Session session;
  session.name = "twist.knead";
  session.strokes = {stroke_of(TwistStroke{{0, 0, 0}, {1, 0, 0}, degrees / (10 * scale), -5 * scale, 5 * scale})};
  return session;
}

ReplayOptions strict() {
  ReplayOptions options;
  options.must_follow = true;
  return options;
}

std::string refusal(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  try {
    replay(mesh, session, options);
    return {};
  } catch (const QualityLimit& limit) {
    return limit.what();
  }
}

TEST(ExactImage, FacesThatCannotFollowATwistAreRefusedAtAnySize) {
  for (const double scale : {1e-3, 1.0, 1e3}) {
    const std::string text = refusal(bar(scale), twist(180, scale), strict());
    EXPECT_NE(text.find("twist.knead: the faces cannot follow"), std::string::npos) << text;
    EXPECT_NE(text.find("--remesh"), std::string::npos) << text;
    EXPECT_NE(text.find("--keep-mesh"), std::string::npos) << text;
  }
}

TEST(ExactImage, WithoutTheOptionItIsAWarningAndLittleIsNone) {
  const ReplayResult result = replay(bar(), twist(180));
  EXPECT_NE(result.warnings.back().find("cannot follow"), std::string::npos);
  EXPECT_TRUE(replay(bar(), twist(0.5), strict()).warnings.empty());
  const Mesh fine = make_shape(ShapeKind::sphere, 10000);
  EXPECT_TRUE(replay(fine, twist(180, 0.2), strict()).warnings.empty());
}

// Ten strokes of 18 degrees are one of 180, each alone far less.
TEST(ExactImage, StrokesAddUp) {
  Session session = twist(18);
  for (int i = 0; i < 9; ++i) session.strokes.push_back(session.strokes.front());
  EXPECT_FALSE(refusal(bar(), session, strict()).empty());
}

TEST(ExactImage, AToolInsideALargeFaceIsFound) {
  Session session;
  session.strokes = {stroke_of(ImplicitStroke{{{1, 0, 1}, {1, 0, 2}}, 0.1, 0.3})};
  const Mesh mesh = bar();
  EXPECT_FALSE(refusal(mesh, session, strict()).empty());
  EXPECT_EQ(replay(mesh, session).shape.positions(), mesh.positions);
}

TEST(ExactImage, AMeshThatFollowsAndTheWayBackAreNotRefused) {
  ReplayOptions options = strict();
  options.remesh.settings = RemeshSettings{};
  const Mesh mesh = make_shape(ShapeKind::box, 600);
  EXPECT_EQ(refusal(mesh, twist(90, 0.2), options), "");
  options = strict();
  options.part.direction = Direction::backwards;
  EXPECT_EQ(refusal(replay(bar(), twist(180)).shape.to_mesh(), twist(180), options), "");
}

}  // namespace
}  // namespace knead::exact_image_test
