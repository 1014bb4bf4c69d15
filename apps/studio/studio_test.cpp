// Studio without its window, driven by the events of a pointer.
#include "studio.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "knead/mesh.h"
#include "studio_fixture.h"
#include "support/test_meshes.h"

namespace knead::studio::studio_test {
namespace {

class EveryTool : public StudioTest, public testing::WithParamInterface<ToolCase> {};

TEST_P(EveryTool, LeavesOnTheScreenWhatTheSavedSessionGivesToTheBit) {
  for (const bool has_worker : {false, true}) {
    Studio studio(options(has_worker));
    run(studio, ball());
    const std::vector<Vec3d> before = positions(studio);
    run(studio, GetParam().script);
    EXPECT_EQ(errors(studio), "");
    const std::vector<Vec3d> after = positions(studio);
    EXPECT_NE(after, before);
    EXPECT_GE(studio.document().shown().history.size(), 1u);
    const ReplayResult replayed = saved_and_replayed(studio);
    EXPECT_TRUE(replayed.shape.positions() == after);
    EXPECT_GE(replayed.resolved.size(), GetParam().strokes);
    while (!studio.document().shown().history.empty()) run(studio, R"({"key": "Ctrl+Z"})");
    EXPECT_TRUE(positions(studio) == before);
    for (std::size_t i = studio.document().shown().redoable.size(); i-- > 0;) run(studio, R"({"key": "Ctrl+Shift+Z"})");
    EXPECT_TRUE(positions(studio) == after);
    studio.document().close();
  }
}

INSTANTIATE_TEST_SUITE_P(Studio, EveryTool, testing::ValuesIn(kTools),
                         [](const auto& test) { return std::string(test.param.name); });

// Where the whole shape is seen, a drag beside it turns the view about its middle.
TEST_F(StudioTest, ACloseViewTurnsAboutTheLastStroke) {
  for (const bool is_close : {true, false}) {
    Studio studio(options());
    run(studio, ball());
    run(studio, fmt::format(R"({{"view": {{"target": [0.4, 0.9, 0], "height": {}}}}}
{{"set": {{"radius": 0.1}}}}
{{"drag": [[0.4, 0.8, 0.44], [0.45, 0.95, 0.44]]}})",
                            is_close ? 1.2 : 3));
    ASSERT_EQ(studio.document().shown().history.size(), 1u);
    const SessionStroke& stroke = studio.document().shown().history.back()->strokes.front();
    const Vec3d end = std::get<ImplicitStroke>(stroke.stroke).path.back();
    const Pixel before = pixel_of(studio.view().screen(), end).value();
    const double yaw = studio.view().navigation().view.yaw;
    run(studio, R"({"drag": [[0.9, 1.1, 0], [0.8, 1.1, 0]]})");
    EXPECT_NE(studio.view().navigation().view.yaw, yaw);
    EXPECT_EQ(studio.document().shown().history.size(), 1u);
    const Pixel after = pixel_of(studio.view().screen(), end).value();
    const double moved = std::hypot(after.x - before.x, after.y - before.y);
    EXPECT_EQ(moved < 1, is_close) << moved << " pixels";
    studio.document().close();
  }
}

TEST_F(StudioTest, ExportsTheBytesThatTheCommandWouldWrite) {
  Studio studio(options());
  run(studio, ball());
  run(studio, kTools[0].script);
  const ReplayResult replayed = saved_and_replayed(studio);
  run(studio, R"({"export": ")" + (folder_ / "out.ply").string() + "\"}");
  const ShapeFile source = read_shape(folder_ / "work_shape.ply");
  EXPECT_EQ(read_shape(folder_ / "out.ply").bytes,
            serialize_shape("ply", source, replayed.shape.positions(), {true, {}}));
}

// Of splats the command writes more than places: sizes, turns, and pieces of long ones. Frames have the same.
TEST_F(StudioTest, ExportsSplatsAsTheCommandWritesThem) {
  Mesh mesh;
  mesh.positions = make_shape(ShapeKind::sphere, 600).positions;
  const std::size_t count = mesh.vertex_count();
  const auto add = [&](const std::string& name, double value) {
    mesh.attributes.push_back({name, Domain::vertex, NumberType::float32, 1, std::vector<double>(count, value)});
  };
  for (int i = 0; i < 3; ++i) add(fmt::format("scale_{}", i), i == 0 ? -1.5 : -4);
  for (int i = 0; i < 4; ++i) add(fmt::format("rot_{}", i), i == 0 ? 1 : 0);
  add("opacity", 2);
  write_mesh(folder_ / "capture.ply", mesh);
  write_file_atomically(folder_ / "bend.knead", R"({"knead": 1}
{"tool": "bend", "center": [0, 0, 0], "axis": [0, 1, 0], "normal": [0, 0, 1], "width": 1, "angle_deg": 70}
)");
  Studio studio(options());
  for (const char* name : {"capture.ply", "bend.knead"}) {
    run(studio, R"({"open": ")" + (folder_ / name).string() + "\"}");
  }
  run(studio, R"({"export": ")" + (folder_ / "out.ply").string() + "\"}");
  FrameExport how;
  how.frames = 3;
  studio.document().export_frames(folder_ / "frame.ply", how);
  run(studio, "");
  EXPECT_EQ(errors(studio), "");
  ShapeFile source = read_shape(folder_ / "capture.ply");
  const Session session = read_session(folder_ / "bend.knead");
  ASSERT_TRUE(split_splats(source, session, {}));
  const ReplayResult replayed = replay(borrow(source.mesh), session, {});
  const std::string expected = serialize_deformed("ply", source, replayed.shape, {.double_coordinates = true});
  EXPECT_EQ(read_shape(folder_ / "out.ply").bytes, expected);
  EXPECT_EQ(read_shape(folder_ / "frame_0002.ply").bytes, serialize_deformed("ply", source, replayed.shape));
}

TEST_F(StudioTest, AScriptWithoutAShapeSavesNothingAndSaysSo) {
  Studio studio(options());
  for (const char* what : {"save", "export"}) {
    const std::string line = fmt::format(R"({{"{}": "{}"}})", what, (folder_ / "none.ply").string());
    EXPECT_THROW(run(studio, line), InvalidInput) << what;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.ply"));
}

TEST_F(StudioTest, ExportsTheMotionAsOneFileOrSeveral) {
  Studio studio(options());
  run(studio, ball());
  run(studio, kTools[0].script);
  const ReplayResult replayed = saved_and_replayed(studio);
  FrameExport how;
  how.frames = 4;
  how.hold = 1;
  studio.document().export_frames(folder_ / "motion.pc2", how);
  run(studio, "");
  const std::string bytes = file_bytes(folder_ / "motion.pc2");
  const std::vector<Vec3d> end = replayed.shape.positions();
  ASSERT_EQ(bytes.size(), 32 + 6 * end.size() * 3 * sizeof(float));
  float last = 0;
  std::memcpy(&last, bytes.data() + bytes.size() - sizeof last, sizeof last);
  EXPECT_EQ(last, static_cast<float>(end.back().z));
  studio.document().export_frames(folder_ / "motion.ply", how);
  run(studio, "");
  EXPECT_EQ(read_shape(folder_ / "motion_0005.ply").mesh.vertex_count(), end.size());
}

TEST_F(StudioTest, LooksAtTheFramesThatItWouldExport) {
  for (const bool has_worker : {false, true}) {
    Studio studio(options(has_worker));
    run(studio, ball());
    run(studio, kTools[0].script);
    run(studio, kTools[10].script);
    const std::vector<Vec3d> present = positions(studio);
    saved_and_replayed(studio);
    const Session session = read_session(folder_ / "work.knead");
    FrameExport how;
    how.frames = 5;
    how.is_smooth = true;
    ReplayOptions replayed;
    replayed.frames.count = how.frames;
    replayed.frames.ease = Ease::smooth;
    std::vector<std::vector<Vec3d>> frames;
    replayed.frames.deliver = [&](const ReplayFrame& frame) { frames.push_back(frame.shape.positions()); };
    replay(read_shape(folder_ / "work_shape.ply").mesh, session, replayed);
    for (const int k : {3, 0, 4, 1}) {
      studio.history().look_at_frame(how, k);
      run(studio, "");
      EXPECT_TRUE(positions(studio) == frames[static_cast<std::size_t>(k)]) << k;
      EXPECT_TRUE(studio.document().shown().looked_at);
    }
    studio.history().look_at(std::nullopt);
    run(studio, "");
    EXPECT_TRUE(positions(studio) == present);
    EXPECT_FALSE(studio.document().shown().looked_at);
    studio.history().look_at_frame(how, 2);
    run(studio, R"({"key": "Ctrl+Z"})");  // what is changed afterwards has other frames
    studio.history().look_at_frame(how, how.frames - 1);
    run(studio, "");
    EXPECT_FALSE(positions(studio) == present);
    EXPECT_EQ(errors(studio), "");
    studio.document().close();
  }
}

TEST_F(StudioTest, ASavedSessionIsOpenedAgainWithItsStampsAndGestures) {
  Studio studio(options());
  run(studio, ball());
  for (const int i : {0, 10, 15}) run(studio, kTools[i].script);
  EXPECT_EQ(errors(studio), "");
  saved_and_replayed(studio);
  Studio other(options());
  run(other, R"({"open": ")" + (folder_ / "work.knead").string() + "\"}");
  EXPECT_EQ(errors(other), "");
  EXPECT_TRUE(positions(other) == positions(studio));
  EXPECT_EQ(other.document().shown().history.size(), studio.document().shown().history.size());
  EXPECT_FALSE(other.document().shown().is_changed);
  EXPECT_TRUE(saved_and_replayed(other, "again.knead").shape.positions() == positions(studio));
}

TEST_F(StudioTest, AfterACrashSavedWorkIsKnownAsSaved) {
  for (const bool goes_on : {false, true}) {
    {
      Studio studio(options());
      run(studio, ball());
      run(studio, kTools[10].script);
      saved_and_replayed(studio);
      if (goes_on) run(studio, kTools[0].script);
    }  // without close(): killed
    Studio next(options());
    ASSERT_EQ(next.document().abandoned().size(), 1U);
    EXPECT_EQ(next.document().abandoned()[0].is_saved, !goes_on);
    next.document().discard(std::filesystem::path(next.document().abandoned()[0].folder));
  }
}

TEST_F(StudioTest, WhatWasLeftBehindIsOfferedAndComesBackToTheBit) {
  std::vector<Vec3d> left;
  {
    Studio studio(options());
    run(studio, ball());
    run(studio, kTools[10].script);
    run(studio, R"({"set": {"mask_mode": "box", "widens_zone": false}}
{"set": {"mirror_plane": {"point": [0, 0, -9], "normal": [0, 0, 2]}}}
{"view": {"field_of_view_deg": 40}}
{"tool": "ball"}
{"set": {"drag": "view", "falloff": 6, "mirror_plane": null}}
{"move": [0, 0, 1]}
{"press": [0, 0, 1]}
{"move": [0.2, 0.2, 1]}
{"move": [0.4, 0.2, 1]})");
    EXPECT_TRUE(studio.gesture().has_value());
    left = positions(studio);
  }
  Studio next(options());
  ASSERT_EQ(next.document().abandoned().size(), 1u);
  run(next, R"({"recover": "newest"})");
  EXPECT_EQ(errors(next), "");
  EXPECT_TRUE(positions(next) == left);
  ASSERT_EQ(next.document().shown().history.size(), 2u);
  EXPECT_EQ(falloff_of(next.document().shown().history[1]->strokes.front().stroke), 6);
  EXPECT_EQ(next.tools().settings().mask_mode, MaskMode::box);
  EXPECT_FALSE(next.tools().settings().widens_zone);
  EXPECT_FALSE(next.tools().settings().symmetry.plane);
  EXPECT_EQ(next.view().navigation().view.field_of_view_deg, 40);
  EXPECT_TRUE(next.document().shown().is_changed);
  next.document().close();
  EXPECT_TRUE(Studio(options()).document().abandoned().empty());
}

TEST_F(StudioTest, AHalfDragComesBackAsOneStrokeThatIsRemeshed) {
  const std::string half = R"({"set": {"drag": "view", "remesh": true}}
{"tool": "ball"}
{"move": [0, 0, 1]}
{"press": [0, 0, 1]}
{"move": [0.2, 0.2, 1]}
{"move": [0.4, 0.2, 1]}
{"move": [0.5, 0.4, 1]})";
  Studio whole(options());
  run(whole, ball() + half + "\n" + R"({"release": [0.5, 0.4, 1]})");
  const std::vector<Vec3d> expected = positions(whole);
  const std::string line = stroke_line(whole.document().shown().history[0]->strokes.front());
  EXPECT_NE(expected.size(), 2562U);
  whole.document().close();
  {
    Studio studio(options());
    run(studio, ball() + half);
  }  // without close(): killed
  Studio next(options());
  run(next, R"({"recover": "newest"})");
  EXPECT_EQ(errors(next), "");
  ASSERT_EQ(next.document().shown().history.size(), 1U);
  ASSERT_EQ(next.document().shown().history[0]->strokes.size(), 1U);
  EXPECT_EQ(stroke_line(next.document().shown().history[0]->strokes.front()), line);
  EXPECT_TRUE(positions(next) == expected);
  next.document().close();
}

TEST_F(StudioTest, RecoveredWorkKeepsTheNameAndTheFilesOfItsSession) {
  {
    Studio studio(options());
    run(studio, ball());
    run(studio, kTools[10].script);
    saved_and_replayed(studio);
    run(studio, kTools[0].script);
  }  // without close(): killed
  for (int crash = 0; crash < 2; ++crash) {
    Studio next(options());
    ASSERT_EQ(next.document().abandoned().size(), 1U);
    EXPECT_FALSE(next.document().abandoned()[0].is_saved);
    run(next, R"({"recover": "newest"})");
    EXPECT_EQ(errors(next), "");
    EXPECT_EQ(next.document().shown().session_path, folder_ / "work.knead");
    EXPECT_EQ(next.document().shown().shape_path, folder_ / "work_shape.ply");
    EXPECT_TRUE(next.document().shown().is_changed);
  }
  Studio last(options());
  run(last, R"({"recover": "newest"}
{"key": "Ctrl+S"})");
  EXPECT_EQ(errors(last), "");
  EXPECT_FALSE(last.document().shown().is_changed);
  const Session session = read_session(folder_ / "work.knead");
  EXPECT_EQ(session.mesh, "work_shape.ply");
  EXPECT_TRUE(replay(read_shape(folder_ / "work_shape.ply").mesh, session).shape.positions() == positions(last));
  last.document().close();
}

TEST_F(StudioTest, AMirroredDragIsSymmetric) {
  Studio studio(options());
  run(studio, ball(10242));
  run(studio, R"({"tool": "ball"}
{"set": {"mirror": [true, false, false]}}
{"drag": [[0.3, 0, 0.95], [0.5, 0.3, 0.95]], "steps": 20})");
  // The icosahedral ball is symmetric: every vertex has an image.
  const std::vector<Vec3d> start = studio.document().shown().state.mesh->positions;
  const std::vector<Vec3d> now = positions(studio);
  double worst = 0;
  double most = 0;
  for (std::size_t i = 0; i < start.size(); ++i) {
    for (std::size_t j = 0; j < start.size(); ++j) {
      if (norm(start[j] - Vec3d{-start[i].x, start[i].y, start[i].z}) > 1e-9) continue;
      worst = std::max(worst, norm(now[j] - Vec3d{-now[i].x, now[i].y, now[i].z}));
    }
    most = std::max(most, norm(now[i] - start[i]));
  }
  EXPECT_GT(most, 0.2);
  EXPECT_LT(worst, 1e-5) << "the sides act at the same time";
}

TEST_F(StudioTest, PaintDoesNotDependOnHowFastTheHandIs) {
  const auto painted = [&](int steps) {
    Studio studio(options());
    run(studio, ball(10242));
    run(studio, R"({"tool": "paint"}
{"set": {"radius": 0.5}}
{"drag": [[-0.5, 0, 0.86], [0.5, 0, 0.86]], "steps": )" +
                    std::to_string(steps) + "}");
    return positions(studio);
  };
  const std::vector<Vec3d> slow = painted(100);
  const std::vector<Vec3d> fast = painted(3);
  double worst = 0;
  double most = 0;
  for (std::size_t i = 0; i < slow.size(); ++i) {
    worst = std::max(worst, norm(slow[i] - fast[i]));
    most = std::max(most, norm(slow[i]) - 1);
  }
  EXPECT_NEAR(most, 0.15 * 0.5, 0.15 * 0.5 * 0.15) << "the depth is that of the settings";
  EXPECT_LT(worst, 0.1 * most);
}

TEST_F(StudioTest, EscapeGivesUpADragAndLosesNothing) {
  Studio studio(options());
  run(studio, ball());
  run(studio, kTools[0].script);
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"press": [0, 0, 1]}
{"move": [0.4, 0.2, 1]}
{"key": "Escape"})");
  EXPECT_FALSE(studio.gesture().has_value());
  EXPECT_TRUE(positions(studio) == before);
  EXPECT_EQ(studio.document().shown().history.size(), 1u);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == before);
}

TEST_F(StudioTest, APastStrokeIsLookedAtAndChanged) {
  Studio studio(options());
  run(studio, ball());
  const std::vector<Vec3d> start = positions(studio);
  run(studio, kTools[0].script);
  run(studio, kTools[11].script);
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"look_at": 0})");
  EXPECT_TRUE(positions(studio) == start);
  run(studio, R"({"look_at": null})");
  EXPECT_TRUE(positions(studio) == before);
  run(studio,
      R"({"edit": 0, "strokes": [{"tool": "implicit", "inner": 0.1, "outer": 0.4, "path": [[1, 0, 0], [1.5, 0, 0]]}]})");
  EXPECT_FALSE(positions(studio) == before);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_TRUE(positions(studio) == before);
}

TEST_F(StudioTest, ErrorsAreToldAndChangeNothing) {
  Studio studio(options());
  run(studio, ball());
  run(studio, kTools[0].script);
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"open": "/nowhere/shape.ply"}
{"open": "/nowhere/work.knead"}
{"save": "/nowhere/work.knead"}
{"export": "/nowhere/out.ply"}
{"export": "/tmp/out.unknown"}
{"stamp": "/nowhere/tool.ply"})");
  const std::string told = errors(studio);
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 6) << told;
  EXPECT_TRUE(positions(studio) == before);
  EXPECT_EQ(studio.document().shown().history.size(), 1u);
}

TEST_F(StudioTest, AStampFromAFileIsInTheHandAtOnce) {
  Studio studio(options());
  run(studio, ball());
  const std::string file = (folder_ / "letter.ply").string();
  write_mesh(file, make_shape(ShapeKind::letter_y));
  run(studio, R"({"tool": "paint"}
{"stamp": ")" + file +
                  R"("}
{"wait": true})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(studio.tools().settings().tool->use, ToolUse::stamp);
  ASSERT_TRUE(studio.tools().placed().stamp);
  EXPECT_EQ(studio.tools().placed().stamp->name, "letter");
}

TEST_F(StudioTest, ATwistWithoutALimitCylinderIsExplained) {
  Studio studio(options());
  run(studio, R"({"size": [800, 600]}
{"new": "torus"}
{"view": {"yaw_deg": 90, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"tool": "twist"}
{"click": [1.3, 0, 0]})");
  ASSERT_TRUE(studio.tools().placed().placement && studio.tools().placed().placement->limit_cylinder);
  EXPECT_FALSE(studio.tools().placed().placement->limit_cylinder->problem.empty());
  run(studio, R"({"drag": [[100, 100], [160, 100]]})");
  EXPECT_TRUE(studio.document().shown().history.empty()) << "what was not asked for is twisted";
  run(studio, R"({"set": {"limit_cylinder": false}}
{"drag": [[100, 100], [160, 100]]})");
  EXPECT_EQ(studio.document().shown().history.size(), 1u);
}

// The next limit cylinder is placed before there was time to prepare picking on the new mesh.
TEST_F(StudioTest, AfterATwistThatRemeshesTheLimitCylinderIsThatOfTheNewMesh) {
  Studio studio(options(true));
  run(studio, R"({"size": [800, 600]}
{"new": "hand", "vertices": 5000}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"set": {"remesh": true, "max_edge": 0.03}}
{"tool": "twist"}
{"click": [0.1, 0.7, 0]}
{"wait": true}
{"drag": [[100, 100], [140, 100]], "steps": 2})");
  ASSERT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1u);
  ASSERT_NE(positions(studio).size(), 5000u);
  ASSERT_TRUE(studio.tools().placed().placement && studio.tools().placed().placement->limit_cylinder);
  const CylinderPlacement at_once = *studio.tools().placed().placement->limit_cylinder;
  run(studio, R"({"tool": "twist"})");
  ASSERT_TRUE(studio.tools().placed().placement && studio.tools().placed().placement->limit_cylinder);
  const CylinderPlacement later = *studio.tools().placed().placement->limit_cylinder;
  EXPECT_EQ(at_once.problem, later.problem);
  EXPECT_EQ(at_once.radius, later.radius);
  EXPECT_EQ(at_once.inner, later.inner);
}

TEST_F(StudioTest, ALimitCylinderIsFoundWhicheverWayThePartPoints) {
  for (const auto& [x, sign] : {std::pair{2.0, 1.0}, std::pair{-2.0, -1.0}}) {
    Studio studio(options());
    run(studio, R"({"size": [800, 600]}
{"new": "box"}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 6}}
{"tool": "bend"}
{"click": [)" + std::to_string(x) +
                    R"(, 0, 0.5]})");
    ASSERT_TRUE(studio.tools().placed().placement && studio.tools().placed().placement->limit_cylinder);
    const Placement& placement = *studio.tools().placed().placement;
    EXPECT_EQ(placement.limit_cylinder->problem, "");
    EXPECT_NEAR(placement.z.x, sign, 0.01) << "the tip is at the bar's nearer end";
  }
}

// The fingers of the hand, the oblique thumb among them, at their sides and tips as well as in the middle.
TEST_F(StudioTest, ABendLiesAlongTheLimbThatIsClicked) {
  Studio studio(options());
  run(studio, R"({"size": [800, 600]}
{"new": "hand", "vertices": 8000}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"tool": "bend"})");
  const std::vector<Vec3d> shape = positions(studio);
  const std::vector<Triangle> triangles = triangulate(*studio.document().shown().state.mesh);
  int clicks = 0;
  int along = 0;
  for (std::uint32_t v = 0; v < shape.size(); v += 97) {
    const Limb limb = find_limb(shape, triangles, v);
    const bool is_finger = limb.has_neck && limb.vertices.size() < shape.size() / 6;
    if (!is_finger || shape[v].z < 0.03) continue;  // what is seen
    studio.tools().clear_placed();
    run(studio, fmt::format(R"({{"click": [{}, {}, {}]}})", shape[v].x, shape[v].y, shape[v].z));
    const auto& placement = studio.tools().placed().placement;
    if (!placement) continue;  // beside the outline
    ASSERT_TRUE(placement->limit_cylinder);
    ++clicks;
    const bool is_along = dot(limb.direction, placement->z) > std::cos(15 * std::numbers::pi / 180);
    if (is_along && placement->limit_cylinder->problem.empty()) ++along;
  }
  EXPECT_GE(clicks, 20);
  EXPECT_GE(along, 0.8 * clicks) << "of " << clicks;
}

TEST_F(StudioTest, RadiusAndRatioFollowKeysAndWheel) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"move": [400, 300]}
{"key": "F"}
{"move": [500, 300]}
{"press": [500, 300]})");
  EXPECT_NEAR(studio.tools().settings().radius, 0.5 + 100 * 3.0 / 600, 1e-9);
  run(studio, R"({"key": "Shift+F"}
{"move": [550, 300]}
{"key": "Escape"}
{"wheel": 1, "modifiers": ["ctrl"]}
{"wheel": -2, "modifiers": ["shift"]})");
  EXPECT_NEAR(studio.tools().settings().radius, 1.1, 1e-9);
  EXPECT_NEAR(studio.tools().settings().inner_ratio, 0.3, 1e-9);
  EXPECT_TRUE(studio.document().shown().history.empty());
}

}  // namespace
}  // namespace knead::studio::studio_test
