// Work that takes time: it has a name, it stops, what it leaves is done later; and the surface is relaxed with Shift.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include "document/layers.h"
#include "knead/mesh.h"
#include "platform/worker.h"
#include "studio.h"
#include "studio_fixture.h"

namespace knead::studio::studio_work_test {

namespace {

using Clock = std::chrono::steady_clock;

// Waits for something that happens within a second on a busy machine, and fails after a minute.
::testing::AssertionResult comes_true(const std::function<bool()>& condition) {
  const Clock::time_point end = Clock::now() + std::chrono::minutes(1);
  while (Clock::now() < end) {
    if (condition()) return ::testing::AssertionSuccess();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return ::testing::AssertionFailure() << "not within a minute";
}

void press_escape(Studio& studio) { studio.perform(Action::cancel); }

class StudioWorkTest : public StudioTest {
 protected:
  static void do_lines(Studio& studio, const std::string& script) {
    std::istringstream lines(script);
    run_script(lines, "script", studio, {});
  }
};

// --- what each tool keeps ---

using OwnSettingsTest = StudioTest;

TEST_F(OwnSettingsTest, AToolHasItsRadiusInnerRatioFalloffAndDrag) {
  Studio studio(options());
  run(studio, ball() + R"({"tool": "twist"}
{"set": {"radius": 2, "inner_ratio": 0.7, "falloff": 6, "drag": "axis"}}
{"tool": "ball"})");
  const ToolSettings& settings = studio.tools().settings();
  EXPECT_EQ(settings.radius, 0.5) << "as ball() has set it";
  EXPECT_EQ(settings.falloff, kDefaultFalloff);
  run(studio, R"({"tool": "stamp"})");
  EXPECT_EQ(settings.radius, settings.first_radius);
  EXPECT_EQ(settings.drag, DragMode::normal);
  run(studio, R"({"set": {"radius": 0.9}}
{"tool": "twist"})");
  EXPECT_EQ(settings.radius, 2);
  EXPECT_EQ(settings.inner_ratio, 0.7);
  EXPECT_EQ(settings.falloff, 6);
  EXPECT_EQ(settings.drag, DragMode::axis);
  run(studio, R"({"tool": "crease"}
{"set": {"pinch": 1.5, "paint_in": true}}
{"tool": "flatten"})");
  EXPECT_EQ(settings.pinch, OwnSettings{}.pinch);
  EXPECT_FALSE(settings.paint_in);
  run(studio, R"({"tool": "crease"})");
  EXPECT_EQ(settings.pinch, 1.5);
  EXPECT_TRUE(settings.paint_in);
  run(studio, ball());
  run(studio, R"({"tool": "stamp"})");
  EXPECT_EQ(settings.radius, settings.first_radius) << "another document has another size";
}

// --- the first stroke ---

using FirstStrokeTest = StudioTest;

TEST_F(FirstStrokeTest, APullOutwardsLeavesNoCraterAtTheDefaults) {
  Studio studio(options());
  run(studio, R"({"size": [800, 600]}
{"new": "sphere", "vertices": 10242}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 4}}
{"drag": [[0, 0.95, 0.31], [0, 1.4, 0.31], [0.25, 1.9, 0.31]]})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(studio.tools().settings().tool, studio_tool("move"));
  ASSERT_EQ(studio.document().shown().history.size(), 1U);
  EXPECT_EQ(tool_of(studio.document().shown().history.front()->strokes), studio_tool("move"));
  double deepest = 1;
  double highest = 0;
  for (const Vec3d& p : positions(studio)) {
    deepest = std::min(deepest, norm(p));
    highest = std::max(highest, norm(p));
  }
  EXPECT_GT(highest, 1.85);
  EXPECT_GT(deepest, 1 - norm(Vec3d{0.25, 0.95, 0}) / 40);
}

TEST_F(FirstStrokeTest, WhatStudioMadeIsRemeshedAndWhatWasReadIsNot) {
  Studio studio(options());
  studio.document().open_made(ShapeKind::sphere, 10242);
  run(studio, R"({"wait": true})");
  EXPECT_TRUE(studio.tools().settings().remesh);
  run(studio, R"({"size": [800, 600]}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 4}}
{"drag": [[0, 0.95, 0.31], [0, 1.4, 0.31], [0.25, 1.9, 0.31]]}
{"wait": true})");
  EXPECT_EQ(errors(studio), "");
  const std::string file = (folder_ / "pulled.ply").string();
  run(studio, R"({"export": ")" + file + "\"}");
  const Mesh pulled = read_shape(file).mesh;
  EXPECT_GT(pulled.positions.size(), 10'300U) << "the horn got vertices";
  EXPECT_GT(measure(pulled).smallest_angle_deg.value(), 5);
  run(studio, R"({"open": ")" + file + "\"}");
  EXPECT_FALSE(studio.tools().settings().remesh);
}

// --- Shift ---

using RelaxTest = StudioTest;

TEST_F(RelaxTest, ShiftRelaxesWithEveryToolAndKeepsTheVolume) {
  for (const char* tool : {"ball", "paint", "points", "stamp", "rotate"}) {
    Studio studio(options());
    run(studio, ball(10242) + R"({"tool": "paint"}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]]})");
    const Mesh before = studio.document().shown().state.to_mesh();
    run(studio, std::string(R"({"tool": ")") + tool + R"("}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]], "modifiers": ["shift"]})");
    EXPECT_EQ(errors(studio), "") << tool;
    ASSERT_EQ(studio.document().shown().history.size(), 2U) << tool;
    const auto* relax = std::get_if<RelaxStroke>(&studio.document().shown().history.back()->strokes.front().stroke);
    ASSERT_NE(relax, nullptr) << tool;
    EXPECT_EQ(relax->radius, studio.tools().settings().radius);
    EXPECT_EQ(relax->surface, 1);
    EXPECT_GT(relax->points.size(), 4U);
    const Mesh after = studio.document().shown().state.to_mesh();
    EXPECT_NE(after.positions, before.positions) << tool;
    EXPECT_NEAR(measure(after).volume / measure(before).volume, 1, 1e-6) << tool;
    EXPECT_EQ(self_intersections(triangulate(after), after.positions).count, 0U) << tool;
    EXPECT_EQ(after.corner_vertex, before.corner_vertex);
  }
}

TEST_F(RelaxTest, TheToolDoesSoByItsStrength) {
  Studio studio(options());
  run(studio, ball(10242) + R"({"tool": "smooth"}
{"set": {"radius": 0.3, "smoothing": 0.8}}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1U);
  const auto& relax = std::get<RelaxStroke>(studio.document().shown().history.front()->strokes.front().stroke);
  EXPECT_EQ(relax.radius, 0.3);
  EXPECT_EQ(relax.amount, 0.8);
  EXPECT_GT(relax.points.size(), 8U);
}

TEST_F(RelaxTest, CtrlAndShiftRelaxTheTrianglesOnly) {
  Studio studio(options());
  run(studio, ball() + R"({"drag": [[0, 0, 1], [0.3, 0.3, 1]], "modifiers": ["ctrl", "shift"]})");
  ASSERT_EQ(studio.document().shown().history.size(), 1U);
  EXPECT_EQ(std::get<RelaxStroke>(studio.document().shown().history.front()->strokes.front().stroke).surface, 0);
}

TEST_F(RelaxTest, BesideTheShapeAndOnAPointCloudNothingHappens) {
  Studio studio(options());
  run(studio, ball() + R"({"drag": [[-0.9, -0.9, 0], [-0.9, -0.5, 0]], "modifiers": ["shift"]})");
  EXPECT_TRUE(studio.document().shown().history.empty());
  Mesh cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  write_mesh(folder_ / "cloud.xyz", cloud);
  run(studio, R"({"open": ")" + (folder_ / "cloud.xyz").string() + R"("}
{"drag": [[0, 0, 0], [0.5, 0, 0]], "modifiers": ["shift"]})");
  EXPECT_EQ(errors(studio), "A point cloud has no surface to smooth.\n");
  EXPECT_TRUE(studio.document().shown().history.empty());
}

TEST_F(StudioWorkTest, ADragOnAPointCloudPullsItAndAClickPinsIt) {
  Mesh cloud;
  cloud.positions = make_shape(ShapeKind::sphere, 4000).positions;
  write_mesh(folder_ / "cloud.xyz", cloud);
  Studio studio(options());
  run(studio, R"({"open": ")" + (folder_ / "cloud.xyz").string() + R"("}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"tool": "move"}
{"drag": [[0, 0, 1], [0.3, 0.2, 1]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1U);
  const std::vector<Vec3d> moved = studio.document().shown().state.positions.copy();
  double front = 0;
  double back = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    double& most = cloud.positions[i].z > 0 ? front : back;
    most = std::max(most, norm(moved[i] - cloud.positions[i]));
  }
  EXPECT_NEAR(front, std::hypot(0.3, 0.2), 0.05);
  EXPECT_LT(back, 0.1 * front) << "the drag begins on the near side";
  run(studio, R"({"drag": [[1.4, 1.4, 0], [1.2, 1.4, 0]]})");
  EXPECT_EQ(studio.document().shown().history.size(), 1U) << "beside the cloud the view turns";
  run(studio, R"({"tool": "pose"}
{"click": [-0.6, 0, 0.8]})");
  ASSERT_EQ(studio.tools().placed().pins.size(), 1U);
  EXPECT_LT(norm(studio.tools().placed().pins[0].place - Vec3d{-0.6, 0, 0.8}), 0.1);
}

// --- remeshing later ---

TEST_F(StudioWorkTest, OneGoesOnSculptingWhileARemeshRuns) {
  Studio studio(options(true));
  run(studio, ball(40962) + R"({"tool": "ball"}
{"set": {"remesh": true, "max_edge": 0.01}})");
  do_lines(studio, R"({"drag": [[0, 0, 1], [0.3, 0.3, 1.2]]})");
  ASSERT_TRUE(comes_true([&] {
    const auto work = studio.document().worker().status();
    return work && work->what == "Remeshing";
  }));
  do_lines(studio, R"({"set": {"remesh": false}}
{"press": [0, 0.6, 0.8]}
{"move": [0, 0.7, 0.8]}
{"move": [0, 0.8, 0.8]})");
  ASSERT_TRUE(studio.gesture().has_value());
  // The drag is computed on the shape as it is shown, which is not remeshed yet.
  ASSERT_TRUE(comes_true([&] {
    studio.refresh();
    return studio.document().shown().history.size() == 1 && !studio.document().worker().is_busy();
  }));
  EXPECT_EQ(studio.document().shown().state.mesh->vertex_count(), 40962U);
  do_lines(studio, R"({"release": [0, 0.8, 0.8]})");
  studio.document().worker().wait();
  studio.refresh();
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 2U);
  EXPECT_GT(studio.document().shown().state.mesh->vertex_count(), 40962U);
  const std::vector<Vec3d> after = positions(studio);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == after);
}

TEST_F(StudioWorkTest, EscapeStopsARemeshWhichIsDoneBeforeTheExport) {
  Studio studio(options(true));
  run(studio, ball(40962) + R"({"tool": "ball"}
{"set": {"remesh": true, "max_edge": 0.01}})");
  do_lines(studio, R"({"drag": [[0, 0, 1], [0.3, 0.3, 1.2]]})");
  ASSERT_TRUE(comes_true([&] {
    const auto work = studio.document().worker().status();
    return work && work->what == "Remeshing";
  }));
  press_escape(studio);
  ASSERT_TRUE(comes_true([&] { return !studio.document().worker().is_busy(); }));
  studio.refresh();
  EXPECT_EQ(studio.document().shown().state.mesh->vertex_count(), 40962U);
  ASSERT_EQ(studio.document().shown().history.size(), 1U);
  run(studio, R"({"export": ")" + (folder_ / "out.ply").string() + "\"}");
  EXPECT_EQ(errors(studio), "");
  const ReplayResult replayed = saved_and_replayed(studio);
  EXPECT_TRUE(positions(studio) == replayed.shape.positions());
  EXPECT_EQ(read_shape(folder_ / "out.ply").mesh.positions, replayed.shape.positions());
}

TEST_F(StudioWorkTest, EscapeStopsCountingCrossings) {
  Studio studio(options(true));
  run(studio, ball(163842));
  studio.document().take_notices();
  studio.document().count_crossings();
  ASSERT_TRUE(comes_true([&] {
    const auto work = studio.document().worker().status();
    return !studio.document().worker().is_busy() || (work && work->what == "Counting crossings");
  }));
  press_escape(studio);
  studio.document().worker().wait();
  const std::vector<Notice> notices = studio.document().take_notices();
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_TRUE(notices.front().text == "Stopped." || notices.front().text == "0 pairs of triangles cross.");
}

TEST_F(StudioWorkTest, UndoWithoutMemoryHasTheBitsOfTheFirstTime) {
  fs::create_directories(folder_ / "config");
  std::ofstream(folder_ / "config" / "studio.json") << R"({"undo_memory_mb": 0})";
  Studio studio(options(true));
  EXPECT_EQ(studio.preferences().undo_memory_mb, 0);
  run(studio, ball());
  std::vector<std::vector<Vec3d>> states{positions(studio)};
  for (int i = 0; i < 6; ++i) {
    const std::string x = std::to_string(0.1 * i);
    run(studio, R"({"drag": [[)" + x + R"(, 0, 1], [0.3, 0.3, 1]]})");
    states.push_back(positions(studio));
  }
  for (std::size_t i = states.size() - 1; i-- > 0;) {
    run(studio, R"({"key": "Ctrl+Z"})");
    EXPECT_TRUE(positions(studio) == states[i]) << i;
  }
}

// --- the worker ---

TEST(Worker, AJobInterruptsWhatWasLeftForLaterWhichThenComesAgain) {
  std::atomic<int> begun{0};
  std::atomic<int> ended{0};
  Worker worker(true, [&](Progress& progress) {
    ++begun;
    while (begun == 1 && !progress.cancel) std::this_thread::yield();
    ++ended;
  });
  worker.post([](Progress&) {});
  ASSERT_TRUE(comes_true([&] { return begun == 1; }));
  bool was_cancelled = true;
  worker.post([&](Progress& progress) { was_cancelled = progress.cancel; });
  worker.wait();
  EXPECT_FALSE(was_cancelled);
  EXPECT_EQ(begun, 2);
  EXPECT_EQ(ended, 2);
}

TEST(Worker, SaysWhatItDoesAndHowMuchOfIt) {
  for (const bool is_latest : {false, true}) {
    Worker worker(true, [](Progress&) {});
    std::atomic<bool> goes_on{true};
    std::atomic<bool> is_half{false};
    const auto job = [&](Progress& progress) {
      progress.total = 10;
      progress.done = 5;
      is_half = true;
      while (goes_on) std::this_thread::yield();
    };
    if (is_latest) {
      worker.post_latest(job, "Counting");
    } else {
      worker.post(job, "Counting");
    }
    EXPECT_TRUE(comes_true([&] { return is_half.load(); }));
    const auto status = worker.status();
    EXPECT_TRUE(status.has_value());
    EXPECT_EQ(status.value_or(WorkStatus{}).what, "Counting");
    EXPECT_EQ(status.value_or(WorkStatus{}).fraction, 0.5);
    goes_on = false;
    worker.wait();
    EXPECT_FALSE(worker.status().has_value());
  }
}

}  // namespace

namespace {

// Begins a job that waits until it is cancelled, or for two seconds.
struct Waits {
  std::atomic<bool> has_begun = false;
  std::atomic<bool> was_cancelled = false;

  Worker::Job job() {
    return [this](Progress& progress) {
      has_begun = true;
      const auto begin = std::chrono::steady_clock::now();
      while (!progress.cancel && std::chrono::steady_clock::now() - begin < std::chrono::seconds(2)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      was_cancelled = progress.cancel.load();
    };
  }
  void wait_for_it() const {
    while (!has_begun) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
};

TEST(Worker, ALatestJobGivesWayToTheNextWhichIsNotCancelled) {
  Worker worker(true, [](Progress&) {});
  Waits first;
  worker.post_latest(first.job(), "first", true);
  first.wait_for_it();
  bool second_was_cancelled = true;
  worker.post_latest([&](Progress& progress) { second_was_cancelled = progress.cancel; });
  worker.wait();
  EXPECT_TRUE(first.was_cancelled);
  EXPECT_FALSE(second_was_cancelled);
}

TEST(Worker, AKeptJobDoesNotGiveWay) {
  for (const bool gives_way : {true, false}) {
    Worker worker(true, [](Progress&) {});
    Waits first;
    worker.post_latest(first.job(), "first", gives_way);
    first.wait_for_it();
    worker.keep_latest();
    worker.post_latest([](Progress&) {});
    worker.wait();
    EXPECT_FALSE(first.was_cancelled);
  }
}

}  // namespace

}  // namespace knead::studio::studio_work_test
