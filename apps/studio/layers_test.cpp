// The history as layers, the view after a crash, and turntables, driven by the events of a pointer and by scripts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "document/layers.h"
#include "studio_fixture.h"

namespace knead::studio::layers_test {
namespace {

class StudioLayers : public StudioTest {
 protected:
  // A ball pulled, painted and turned: three entries.
  static void begin(Studio& studio) {
    run(studio, ball());
    for (const int tool : {0, 5, 11}) run(studio, kTools[tool].script);
    ASSERT_EQ(errors(studio), "");
    ASSERT_EQ(studio.document().shown().history.size(), 3u);
  }

  static std::vector<std::string> names(const Studio& studio) {
    std::vector<std::string> result;
    for (const auto& entry : studio.document().shown().history) result.push_back(name_of(entry->strokes));
    return result;
  }

  static std::vector<SessionStroke> strokes(const Studio& studio, std::size_t entry) {
    return studio.document().shown().history[entry]->strokes;
  }

  static std::string at(const Vec3d& p) { return fmt_of(p.x) + ", " + fmt_of(p.y) + ", " + fmt_of(p.z); }

  // Drags a handle of the selected entry, by its place in the scene.
  static void drag_handle(Studio& studio, std::size_t handle, const Vec3d& by, bool is_kept) {
    const Vec3d from = place_of(studio.history().editor().paths, {0, handle});
    run(studio, R"({"move": [)" + at(from) + R"(]}
{"press": [)" + at(from) +
                    R"(]}
{"move": [)" + at(from + by * 0.5) +
                    R"(]}
{"move": [)" + at(from + by) +
                    "]}\n" + (is_kept ? R"({"release": [)" + at(from + by) + "]}" : R"({"key": "Escape"})"));
  }

 private:
  static std::string fmt_of(double x) { return std::to_string(x); }
};

TEST(LayerWords, AnEntrySaysWhatItDoes) {
  const auto words = [](Stroke stroke, const char* unit = "") {
    const SessionStroke line{std::move(stroke)};
    return words_of({&line, 1}, unit);
  };
  EXPECT_EQ(words(ImplicitStroke{.path = {{0, 0, 0}, {0, 1, 0}, {0.1, 0.1, 0}}, .inner = 0.1, .outer = 1}),
            "Pull 0.14");
  EXPECT_EQ(words(ImplicitStroke{.path = {{0, 0, 0}, {12.3, 0, 0}}, .inner = 0.1, .outer = 1}, "mm"), "Pull 12 mm");
  for (const auto& [brush, expected] : {std::pair{"move", "Move 1"}, {"snakehook", "Snakehook 1"}}) {
    ImplicitStroke pull = std::get<ImplicitStroke>(stroke_of(brush_named(brush), 1, 0));
    pull.path = {{0, 0, 0}, {1, 0, 0}};
    EXPECT_EQ(words(pull), expected);
  }
  EXPECT_EQ(words(PaintStroke{1, -0.1, {{}, {}, {}}}), "Paint, 3 dabs");
  EXPECT_EQ(words(PaintStroke{1, 0.1, {{}}}), "Press in, 1 dab");
  EXPECT_EQ(words(RotateStroke{{}, {0, 0, 1}, 45}), "Rotate 45\u00b0");
  EXPECT_EQ(words(BendStroke{{}, {0, 0, 1}, {0, 1, 0}, -30, BendWidth{1}}), "Bend -30\u00b0");
  EXPECT_EQ(words(StretchStroke{{}, {0, 0, 1}, 1.5}), "Stretch +50.0%");
  EXPECT_EQ(words(TwistStroke{.center = {}, .axis = {0, 0, 1}, .rate_deg = -45, .inner = -1, .outer = 1}),
            "Twist 90\u00b0");
  EXPECT_EQ(
      words(PointsStroke{.points = {{0, 0, 0}}, .curves = {}, .outer = 1, .displacements = {{0.1, 0, 0}, {0.1, 0, 0}}}),
      "Move points 0.2");
  EXPECT_EQ(words(PinsStroke{{{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0.5}, {1, 0, 0}}}), "Pose 0.5");
  EXPECT_EQ(words(RelaxStroke{.points = {{0, 0, 0}}}), "Smooth, 1 dab");
  EXPECT_EQ(words(GridStroke{}), "Pose");
}

TEST(LayerWords, AnEntryHasTheIconOfItsToolAndIsFoundByWords) {
  SessionStroke line{ImplicitStroke{.path = {{0, 0, 0}, {0.1, 0, 0}}, .inner = 0.1, .outer = 1}};
  EXPECT_EQ(tool_of({&line, 1}), studio_tool("ball"));
  std::get<ImplicitStroke>(line.stroke).region = ImplicitRegion::capsule;
  EXPECT_EQ(tool_of({&line, 1}), studio_tool("capsule"));
  line.name = "left ear";
  for (const char* text : {"", "ear", "LEFT", "ear pull", "0.1"}) EXPECT_TRUE(is_found({&line, 1}, text)) << text;
  for (const char* text : {"nose", "ear nose"}) EXPECT_FALSE(is_found({&line, 1}, text)) << text;
  line.stroke = PinsStroke{{{0, 0, 0}}, {{0, 0, 0.5}}};
  EXPECT_EQ(tool_of({&line, 1}), studio_tool("pose"));
  line.stroke = RelaxStroke{.points = {{0, 0, 0}}};
  EXPECT_EQ(tool_of({&line, 1}), studio_tool("smooth"));
}

TEST_F(StudioLayers, EntriesAreNamedAsTheToolsAre) {
  for (const auto& [script, name] : std::map<int, std::string>{
           {0, "Ball"}, {4, "Capsule"}, {5, "Paint"}, {8, "Points"}, {9, "Curve"}, {10, "Stamp"}, {14, "Bend"}}) {
    Studio studio(options());
    run(studio, ball());
    run(studio, kTools[script].script);
    ASSERT_EQ(studio.document().shown().history.size(), 1u) << name;
    EXPECT_EQ(names(studio)[0], name);
    studio.document().close();
  }
}

TEST_F(StudioLayers, ARenamedEntryKeepsItsNameInTheFile) {
  Studio studio(options());
  begin(studio);
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"layer": 1, "name": "left ear"})");
  EXPECT_EQ(names(studio), (std::vector<std::string>{"Ball", "left ear", "Rotate"}));
  EXPECT_TRUE(positions(studio) == before);
  EXPECT_TRUE(studio.document().shown().is_changed);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == before);
  Studio other(options());
  run(other, R"({"open": ")" + (folder_ / "work.knead").string() + "\"}");
  EXPECT_EQ(names(other), names(studio));
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_EQ(names(studio)[1], "Paint");
}

TEST_F(StudioLayers, AnEntryThatIsOffIsAbsent) {
  for (const bool has_worker : {false, true}) {
    Studio studio(options(has_worker));
    begin(studio);
    const std::vector<Vec3d> before = positions(studio);
    run(studio, R"({"layer": 1, "off": true})");
    EXPECT_TRUE(is_off(strokes(studio, 1)));
    EXPECT_FALSE(positions(studio) == before);
    Session without = parse_session("{\"knead\": 1}\n", "s");
    for (const std::size_t i : {0U, 2U}) {
      for (const SessionStroke& stroke : strokes(studio, i)) without.strokes.push_back(stroke);
    }
    const ReplayResult expected = replay(*studio.document().shown().state.mesh, without);
    EXPECT_TRUE(positions(studio) == expected.shape.positions());
    EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
    run(studio, R"({"layer": 1, "off": false})");
    EXPECT_TRUE(positions(studio) == before);
    studio.document().close();
  }
}

TEST_F(StudioLayers, EntriesAreMovedJoinedSplitAndRemoved) {
  Studio studio(options());
  begin(studio);
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"layer": 2, "move_to": 0})");
  EXPECT_EQ(names(studio), (std::vector<std::string>{"Rotate", "Ball", "Paint"}));
  EXPECT_FALSE(positions(studio) == before);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
  run(studio, R"({"key": "Ctrl+Z"}
{"layer": 1, "name": "face"}
{"layer": 2, "join": true})");
  EXPECT_EQ(names(studio), (std::vector<std::string>{"Ball", "face"}));
  EXPECT_TRUE(positions(studio) == before) << "joining moves nothing";
  EXPECT_EQ(strokes(studio, 1).size(), 2u);
  saved_and_replayed(studio);
  Studio other(options());
  run(other, R"({"open": ")" + (folder_ / "work.knead").string() + "\"}");
  EXPECT_EQ(names(other), names(studio)) << "a group is a group in the file";
  run(studio, R"({"layer": 1, "split": true})");
  EXPECT_EQ(names(studio), (std::vector<std::string>{"Ball", "face 1", "face 2"}));
  EXPECT_TRUE(positions(studio) == before);
  run(studio, R"({"layer": 0, "remove": true})");
  EXPECT_EQ(names(studio), (std::vector<std::string>{"face 1", "face 2"}));
  for (int i = 0; i < 4; ++i) run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_TRUE(positions(studio) == before);
  EXPECT_EQ(names(studio), (std::vector<std::string>{"Ball", "Paint", "Rotate"}));
}

TEST_F(StudioLayers, ADragOfTheStrengthIsOneChange) {
  for (const bool has_worker : {false, true}) {
    Studio studio(options(has_worker));
    begin(studio);
    const std::vector<Vec3d> before = positions(studio);
    run(studio, R"({"layer": 2, "drag_strength": [0.9, 0.7, 0.5]})");
    EXPECT_EQ(strength_of(strokes(studio, 2)), 0.5);
    EXPECT_FALSE(positions(studio) == before);
    EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
    run(studio, R"({"key": "Ctrl+Z"})");
    EXPECT_TRUE(positions(studio) == before) << "one undo takes the whole drag back";
    EXPECT_EQ(strength_of(strokes(studio, 2)), 1);
    run(studio, R"({"key": "Ctrl+Shift+Z"}
{"layer": 2, "strength": 1.5})");
    EXPECT_EQ(strength_of(strokes(studio, 2)), 1.5);
    studio.document().close();
  }
}

// The history editor showed the old number after an undo.
TEST_F(StudioLayers, TheEditorFollowsUndo) {
  Studio studio(options());
  begin(studio);
  run(studio, R"({"layer": 2, "select": true})");
  const std::vector<SessionStroke> old = studio.history().editor().strokes;
  std::vector<SessionStroke> changed = old;
  std::get<RotateStroke>(changed[0].stroke).angle_deg = 77;
  set_strokes(studio.history().editor(), changed);
  studio.history().change(replaced(2, changed));
  EXPECT_EQ(strokes(studio, 2), changed);
  EXPECT_EQ(studio.history().editor().strokes, changed);
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_EQ(studio.history().editor().strokes, old);
  EXPECT_EQ(studio.history().editor().text.find("\"angle_deg\": 77"), std::string::npos);
  run(studio, R"({"key": "Ctrl+Shift+Z"})");
  EXPECT_EQ(studio.history().editor().strokes, changed);
  run(studio, R"({"layer": 2, "move_to": 0})");
  EXPECT_EQ(studio.history().editor().entry, 0u) << "the selection goes along";
  run(studio, R"({"layer": 0, "remove": true}
{"layer": 1, "remove": true}
{"layer": 0, "remove": true})");
  EXPECT_FALSE(studio.history().editor().entry);
}

TEST_F(StudioLayers, APathIsDraggedByItsHandles) {
  for (const bool has_worker : {false, true}) {
    Studio studio(options(has_worker));
    begin(studio);
    const std::vector<Vec3d> before = positions(studio);
    run(studio, R"({"layer": 0, "select": true})");
    ASSERT_EQ(studio.history().editor().paths.size(), 1u);
    const std::size_t last = studio.history().editor().paths[0].handles.size() - 1;
    ASSERT_GE(last, 1u);
    const auto path = std::get<ImplicitStroke>(strokes(studio, 0)[0].stroke).path;
    drag_handle(studio, last, {0.3, 0.1, 0}, true);
    const auto moved = std::get<ImplicitStroke>(strokes(studio, 0)[0].stroke).path;
    ASSERT_EQ(moved.size(), path.size());
    EXPECT_EQ(moved.front(), path.front());
    EXPECT_NEAR(norm(moved.back() - path.back() - Vec3d{0.3, 0.1, 0}), 0, 0.01) << "a pixel";
    EXPECT_FALSE(positions(studio) == before);
    EXPECT_EQ(studio.document().shown().history.size(), 3u) << "the tool was not used";
    EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
    run(studio, R"({"key": "Ctrl+Z"})");
    EXPECT_TRUE(positions(studio) == before) << "the drag is one change";
    drag_handle(studio, last, {0.3, 0.1, 0}, false);
    EXPECT_TRUE(positions(studio) == before) << "Escape takes it back";
    EXPECT_EQ(std::get<ImplicitStroke>(strokes(studio, 0)[0].stroke).path, path);
    studio.document().close();
  }
}

TEST_F(StudioLayers, TheCentreOfAToolIsDragged) {
  Studio studio(options());
  begin(studio);
  run(studio, R"({"layer": 2, "select": true})");
  ASSERT_EQ(studio.history().editor().paths.size(), 1u);
  const Vec3d center = std::get<RotateStroke>(strokes(studio, 2)[0].stroke).center;
  drag_handle(studio, 0, {-0.2, 0, 0}, true);
  EXPECT_NEAR(norm(std::get<RotateStroke>(strokes(studio, 2)[0].stroke).center - center - Vec3d{-0.2, 0, 0}), 0, 0.01);
}

TEST_F(StudioLayers, BothSidesOfAMirroredDragFollowAHandle) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "ball"}
{"set": {"mirror": [true, false, false]}}
{"drag": [[0.3, 0, 0.95], [0.5, 0.3, 0.95], [0.8, 0.3, 0.95]], "steps": 6})");
  ASSERT_EQ(studio.document().shown().history.size(), 1u);
  run(studio, R"({"layer": 0, "select": true})");
  ASSERT_EQ(studio.history().editor().paths.size(), 1u) << "the images follow the stroke";
  drag_handle(studio, studio.history().editor().paths[0].handles.size() - 1, {0.1, 0.2, 0}, true);
  EXPECT_EQ(studio.document().shown().history.front()->strokes.front().mirror, coordinate_mirror("x"));
  double left = 0;
  double right = 0;
  for (const Vec3d& p : positions(studio)) (p.x < 0 ? left : right) = std::max(p.x < 0 ? left : right, norm(p));
  EXPECT_NEAR(left, right, 0.01);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
}

TEST_F(StudioLayers, EscapeStopsAReplayAndLeavesTheHistory) {
  Studio studio(options(true));
  run(studio, ball(40962));
  for (int i = 0; i < 4; ++i) run(studio, kTools[0].script);
  const std::vector<Vec3d> before = positions(studio);
  const std::size_t entries = studio.document().shown().history.size();
  studio.history().change(with_strength(0, 0.5));
  EXPECT_TRUE(positions(studio) == before || !studio.document().worker().is_busy())
      << "what is seen stays until the new one is there";
  studio.perform(Action::cancel);
  studio.document().worker().wait();
  studio.refresh();
  const double strength = strength_of(strokes(studio, 0));
  EXPECT_EQ(studio.document().shown().history.size(), entries);
  if (strength == 1) {
    EXPECT_TRUE(positions(studio) == before);
  } else {
    EXPECT_FALSE(positions(studio) == before) << "it was done before it could be stopped";
  }
  studio.document().close();
}

// What a kill leaves: changes of layers that have ended, and of a drag what was before it.
TEST_F(StudioLayers, ChangesComeBackAfterACrash) {
  std::vector<Vec3d> before;
  std::vector<std::string> names_before;
  {
    Studio studio(options());
    begin(studio);
    run(studio, R"({"layer": 0, "name": "nose"}
{"layer": 1, "off": true}
{"layer": 2, "strength": 0.5}
{"layer": 2, "move_to": 1})");
    before = positions(studio);
    names_before = names(studio);
    studio.history().drag(with_strength(0, 0.3));
    EXPECT_FALSE(positions(studio) == before);
  }
  Studio next(options());
  ASSERT_EQ(next.document().abandoned().size(), 1u);
  EXPECT_EQ(next.document().abandoned()[0].entries, 3u);
  run(next, R"({"recover": "newest"})");
  EXPECT_EQ(errors(next), "");
  EXPECT_TRUE(positions(next) == before);
  EXPECT_EQ(names(next), names_before);
  next.document().close();
}

// The dialog counted lines of the session, the history entries.
TEST_F(StudioLayers, TheRecoveryCountsAsTheHistoryDoes) {
  std::size_t entries = 0;
  {
    Studio studio(options());
    run(studio, ball());
    for (const int tool : {15, 5, 0}) run(studio, kTools[tool].script);
    entries = studio.document().shown().history.size();
  }
  Studio next(options());
  ASSERT_EQ(next.document().abandoned().size(), 1u);
  EXPECT_GT(next.document().abandoned()[0].strokes, entries) << "the test needs a gesture of several lines";
  EXPECT_EQ(next.document().abandoned()[0].entries, entries);
  run(next, R"({"recover": "newest"})");
  EXPECT_EQ(next.document().shown().history.size(), entries);
  next.document().close();
}

TEST_F(StudioLayers, TheViewAndTheToolComeBackAfterACrash) {
  View view;
  {
    Studio studio(options());
    run(studio, ball());
    run(studio, R"({"tool": "bend"}
{"set": {"radius": 0.123, "mirror": [false, true, false], "drag": "axis", "axis": [0, 1, 0]}}
{"view": {"yaw_deg": 33, "pitch_deg": -12, "target": [0.1, 0.2, 0.3], "height": 1.7, "projection": "orthographic"}}
{"move": [400, 300]}
{"wheel": 2})");
    view = studio.view().navigation().view;
  }
  Studio next(options());
  run(next, R"({"size": [800, 600]}
{"recover": "newest"})");
  EXPECT_EQ(errors(next), "");
  const View& back = next.view().navigation().view;
  EXPECT_NEAR(back.yaw, view.yaw, 1e-12);
  EXPECT_NEAR(back.pitch, view.pitch, 1e-12);
  EXPECT_EQ(back.target, view.target);
  EXPECT_EQ(back.height, view.height);
  EXPECT_EQ(back.projection, render::Projection::orthographic);
  EXPECT_EQ(next.tools().settings().tool->name, "Bend");
  EXPECT_EQ(next.tools().settings().radius, 0.123);
  EXPECT_EQ(next.tools().settings().drag, DragMode::axis);
  EXPECT_EQ(next.tools().settings().axis, (Vec3d{0, 1, 0}));
  next.document().close();
}

TEST_F(StudioLayers, PartsOfAPoseComeBackAfterACrash) {
  PartMarks parts;
  {
    Studio studio(options());
    run(studio, ball());
    run(studio, R"({"tool": "pose"}
{"set": {"pose": "lasso"}}
{"drag": [[300, 200], [380, 200], [380, 400], [300, 400], [300, 210]], "steps": 4}
{"drag": [[420, 200], [500, 200], [500, 400], [420, 400], [420, 210]], "steps": 4}
{"move": [700, 500]})");
    ASSERT_EQ(studio.tools().placed().parts.holds.size(), 2u);
    studio.tools().placed().parts.holds[0] = false;
    studio.tools().placed().parts.stiffness[1] = 7.5;
    run(studio, R"({"move": [700, 510]})");
    parts = studio.tools().placed().parts;
  }
  Studio next(options());
  run(next, R"({"size": [800, 600]}
{"recover": "newest"})");
  EXPECT_EQ(errors(next), "");
  EXPECT_EQ(next.tools().placed().parts.of_vertex, parts.of_vertex);
  EXPECT_EQ(next.tools().placed().parts.holds, (std::vector<bool>{false, true}));
  EXPECT_EQ(next.tools().placed().parts.stiffness, (std::vector<double>{1, 7.5}));
  run(next, R"({"parts": [{"vertices": [[0, 5]]}], "of": 7})");
  EXPECT_EQ(next.tools().placed().parts.of_vertex, parts.of_vertex) << "of a shape with other vertices";
  EXPECT_THROW(
      run(next, R"({"parts": [{"vertices": [[0, 999999]]}], "of": )" + std::to_string(parts.of_vertex.size()) + "}"),
      InvalidInput);
  next.document().close();
}

TEST_F(StudioLayers, ATurntableShowsTheShapeFromAllAround) {
  Studio studio(options());
  run(studio, ball());
  const View start = studio.view().navigation().view;
  std::vector<std::string> files;
  std::vector<double> yaws;
  ScriptHost host;
  host.picture = [&](const std::filesystem::path& path) {
    files.push_back(path.string());
    yaws.push_back(studio.view().navigation().view.yaw);
    EXPECT_EQ(studio.view().navigation().view.pitch, start.pitch);
  };
  std::istringstream script(R"({"turntable": "turn_%04d.png", "pictures": 8})");
  run_script(script, "script", studio, host);
  ASSERT_EQ(files.size(), 8u);
  EXPECT_EQ(files.front(), "turn_0000.png");
  EXPECT_EQ(files.back(), "turn_0007.png");
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(yaws[i], start.yaw + static_cast<double>(i) * std::acos(-1.0) / 4, 1e-12);
  }
  EXPECT_EQ(studio.view().navigation().view, start);
  EXPECT_FALSE(studio.view().turntable());
}

TEST_F(StudioLayers, APosterThatIsStoppedOrCannotBeWrittenLeavesNothing) {
  Studio studio(options());
  begin(studio);
  const fs::path file = folder_ / "poster.png";
  studio.document().post([&](Document& document, Progress& progress) {
    progress.cancel = true;  // as Escape does
    document.write_poster(file, {render::view_direction(0, 0, false), false, {}, {}}, 1, progress);
  });
  studio.refresh();
  EXPECT_FALSE(fs::exists(file));
  EXPECT_EQ(errors(studio), "");
  studio.view().write_poster(folder_ / "poster.gif", {});
  studio.refresh();
  EXPECT_NE(errors(studio).find("poster.png"), std::string::npos) << "what to do";
}

TEST_F(StudioLayers, EscapeStopsATurntable) {
  Studio studio(options());
  run(studio, ball());
  const View start = studio.view().navigation().view;
  studio.view().record_turntable("turn_%04d.png", 36);
  int written = 0;
  const auto write = [&](const std::filesystem::path& /*path*/) { ++written; };
  EXPECT_TRUE(studio.view().step_turntable(write));
  EXPECT_TRUE(studio.view().step_turntable(write));
  studio.handle(KeyChanged{"Escape", true, {}});
  EXPECT_FALSE(studio.view().step_turntable(write));
  EXPECT_EQ(written, 2);
  EXPECT_EQ(studio.view().navigation().view, start);
  studio.view().record_turntable("turn.jpg", 36);
  EXPECT_FALSE(studio.view().turntable());
  EXPECT_NE(errors(studio).find("PNG"), std::string::npos);
  studio.view().record_turntable("50%/turn.png", 36);
  ASSERT_TRUE(studio.view().turntable());
  EXPECT_EQ(studio.view().turntable()->pattern, "50%/turn_%04d.png") << "a name without a number gets one";
}

}  // namespace
}  // namespace knead::studio::layers_test
