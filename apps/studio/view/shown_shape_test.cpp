// The picture while the GPU moves the shape agrees with the CPU, and ends with the bits of the CPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "knead/editor/gl.h"
#include "studio_fixture.h"
#include "support/splat_scenes.h"
#include "view/shown_shape.h"

namespace knead::studio::shown_shape_test {

namespace {

constexpr double kAgree = 2e-5;  // of the diagonal: what both are apart from the truth

class GpuPreviewTest : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    try {
      context_ = std::make_unique<gl::OffscreenContext>();
    } catch (const std::runtime_error& error) {
      GTEST_SKIP() << error.what();
    }
    view_.emplace(1);
    try {
      preview_.emplace();
    } catch (const GpuError& error) {
      const std::string reason = error.what();
      if (reason.find("has no OpenGL 4.3") != std::string::npos) GTEST_SKIP() << reason;
      FAIL() << reason;
    }
  }
  void TearDown() override {
    preview_.reset();
    view_.reset();
    context_.reset();
    StudioTest::TearDown();
  }

  bool follow(const Studio& studio) {
    const DocumentState& shown = studio.document().shown();
    return preview_->follow(shown.state, studio.pending(), shown.diagonal, *view_);
  }

  // Greatest distance between what is seen and the CPU's shape, of the diagonal.
  double distance(const Studio& studio) {
    const std::vector<Vec3d> seen = preview_->positions();
    const std::vector<Vec3d> expected = positions(studio);
    if (seen.size() != expected.size()) return 1;
    double most = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) most = std::max(most, norm(seen[i] - expected[i]));
    return most / studio.document().shown().diagonal;
  }

  std::unique_ptr<gl::OffscreenContext> context_;
  std::optional<render::LiveView> view_;
  std::optional<GpuPreview> preview_;
};

class EveryToolOnTheGpu : public GpuPreviewTest, public testing::WithParamInterface<ToolCase> {};

// After every event the worker has done its part here, so that both can be compared.
TEST_P(EveryToolOnTheGpu, IsSeenAsTheCpuDoesItAndEndsWithItsBits) {
  Studio studio(options());
  run(studio, ball());
  double most = 0;
  std::uint64_t read_by_test = 0;
  ScriptHost host;
  host.after_event = [&] {
    const std::uint64_t before = preview_->transfers().read;
    follow(studio);
    // Nothing is read back for a picture; once, when a gesture ends.
    EXPECT_LE(preview_->transfers().read, before + (studio.pending() == nullptr ? 1 : 0));
    most = std::max(most, distance(studio));
    ++read_by_test;
    if (studio.pending() == nullptr) {
      EXPECT_TRUE(preview_->positions() == positions(studio));
    }
  };
  std::istringstream lines(GetParam().script);
  run_script(lines, "script", studio, host);
  EXPECT_GE(read_by_test, 3u);
  EXPECT_LT(most, kAgree);
  EXPECT_FALSE(preview_->is_ahead());
  EXPECT_EQ(errors(studio), "");
}

INSTANTIATE_TEST_SUITE_P(GpuPreview, EveryToolOnTheGpu, testing::ValuesIn(kTools),
                         [](const auto& test) { return std::string(test.param.name); });

// What a script does is looked at while the button is held, too.
constexpr const char* kHeld = R"({"tool": "ball"}
{"press": [0, 0, 1]}
{"move": [0.2, 0.2, 1]}
{"move": [0.4, 0.2, 1]})";

// Splats look as the offline renderer draws those of a replay, once the gesture has ended and the work is done.
TEST_F(GpuPreviewTest, SplatsAreSeenAsAReplayDeformsThem) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 4000);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const Mesh capture = render::cover(mesh, triangles, render::samples_of(mesh, triangles, 5000));
  write_mesh(folder_ / "capture.ply", capture);
  for (const bool on_gpu : {false, true}) {
    Studio studio(options());
    run(studio, R"({"open": ")" + (folder_ / "capture.ply").string() + "\"}\n{\"tool\": \"ball\"}");
    ShownShape shape;
    if (on_gpu) shape.use_gpu();
    const auto follow = [&] {
      const DocumentState& shown = studio.document().shown();
      shape.show(shown.objects);
      return shape.follow(shown.state, studio.pending(), shown.diagonal, *view_);
    };
    render::LiveScene scene;
    scene.background_bottom = scene.background_top;
    scene.camera = render::fit_points(capture.positions, {-0.3, -0.2, -1}, {0, 1, 0}, 1);
    render::Options offline;
    offline.width = offline.height = 200;
    offline.background = scene.background_top;
    const auto likeness = [&](const Mesh& splats) {
      const render::Image image = view_->picture(scene, offline.width, offline.height);
      return render::psnr(render::error_of(image, render::render_splats(splats, scene.camera, offline)));
    };
    EXPECT_TRUE(follow());
    EXPECT_FALSE(follow());
    EXPECT_GT(likeness(capture), 40) << on_gpu;
    ScriptHost host;
    host.after_event = [&] { follow(); };
    std::istringstream lines(R"({"drag": [[0.95, 0, 0], [1.4, 0.3, 0]], "modifiers": ["ctrl"], "steps": 3})");
    run_script(lines, "script", studio, host);
    run(studio, "");
    follow();
    EXPECT_EQ(studio.document().shown().history.size(), 1U);
    const ReplayResult replayed = saved_and_replayed(studio);
    EXPECT_TRUE(replayed.shape.positions() == positions(studio));
    EXPECT_GT(likeness(replayed.shape.to_mesh()), 40) << on_gpu;
    EXPECT_LT(likeness(capture), 30);
    EXPECT_EQ(errors(studio), "");
  }
}

TEST_F(GpuPreviewTest, TheGpuIsAheadWhileAGestureIsMade) {
  Studio studio(options());
  run(studio, ball());
  follow(studio);
  const std::vector<Vec3d> before = preview_->positions();
  run(studio, kHeld);
  EXPECT_TRUE(follow(studio));
  EXPECT_TRUE(preview_->is_ahead());
  EXPECT_FALSE(follow(studio));
  EXPECT_NE(preview_->positions(), before);
  EXPECT_NE(preview_->positions(), positions(studio));  // other bits: of the GPU
  EXPECT_LT(distance(studio), kAgree);
  run(studio, R"({"press": [0.4, 0.2, 1], "button": "right"})");
  EXPECT_TRUE(follow(studio));
  EXPECT_FALSE(preview_->is_ahead());
  EXPECT_EQ(preview_->positions(), before);
}

// The worker is slow or quick; in the end the GPU has the bits of the CPU.
TEST_F(GpuPreviewTest, AWorkerThatIsBehindCatchesUp) {
  Studio studio(options(true));
  run(studio, ball(40962));
  ScriptHost host;
  host.after_event = [&] {
    studio.refresh();
    follow(studio);
  };
  std::istringstream lines(R"({"tool": "ball"}
{"drag": [[0, 0, 1], [0.3, 0.3, 1], [0.6, 0.2, 1]], "steps": 30}
{"drag": [[-0.3, 0, 0.95], [-0.3, -0.3, 0.95]], "steps": 30}
{"key": "Ctrl+Z"}
{"tool": "rotate"}
{"wait": true}
{"click": [0.5, 0.5, 0.7]}
{"drag": [[-0.9, -0.9, 0], [-0.2, -0.9, 0]]}
{"wait": true})");
  run_script(lines, "script", studio, host);
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(studio.pending(), nullptr);
  EXPECT_EQ(studio.document().shown().history.size(), 2u);
  EXPECT_TRUE(preview_->positions() == positions(studio));
}

TEST_F(GpuPreviewTest, UndoRedoAndThePastAreTheCpusToTheBit) {
  Studio studio(options());
  run(studio, ball());
  for (const int i : {0, 4, 11}) run(studio, kTools[i].script);
  for (const char* line : {R"({"key": "Ctrl+Z"})", R"({"key": "Ctrl+Z"})", R"({"key": "Ctrl+Shift+Z"})",
                           R"({"look_at": 1})", R"({"look_at": null})", R"({"new": "box", "vertices": 600})"}) {
    SCOPED_TRACE(line);
    run(studio, line);
    EXPECT_TRUE(follow(studio));
    EXPECT_TRUE(preview_->positions() == positions(studio));
  }
}

// A gesture may begin on what the GPU shows while the worker is behind.
TEST_F(GpuPreviewTest, HitsAndVolumeAreOfWhatIsSeen) {
  Studio studio(options());
  run(studio, ball());
  follow(studio);
  const Ray ray{{0.35, 0.25, 5}, {0, 0, -1}};
  const std::optional<SurfaceHit> before = preview_->hit(ray);
  const std::optional<SurfaceHit> by_picker =
      studio.document().shown().picker->pick(ray, studio.document().shown().state);
  ASSERT_TRUE(before && by_picker);
  EXPECT_EQ(before->triangle, by_picker->triangle);
  EXPECT_LT(norm(before->point - by_picker->point), 1e-12);
  EXPECT_GT(dot(before->normal, by_picker->normal), 0.99);
  EXPECT_FALSE(preview_->hit({{5, 5, 5}, {0, 0, -1}}));
  const double volume = preview_->volume();
  EXPECT_NEAR(volume, *studio.document().shown().volume, 1e-12);
  run(studio, kHeld);
  follow(studio);
  const std::optional<SurfaceHit> after = preview_->hit(ray);
  ASSERT_TRUE(after);
  EXPECT_GT(norm(after->point - before->point), 0.01);
  const Picker picker(studio.document().shown().state);
  EXPECT_LT(norm(after->point - picker.pick(ray, studio.document().shown().state)->point),
            4 * kAgree * studio.document().shown().diagonal);
  EXPECT_NE(preview_->volume(), volume);
  EXPECT_NEAR(preview_->volume(), *studio.document().shown().volume, 1e-4);
}

// Where the picker is behind, a drag begins where the hit test says, and otherwise where the picker does.
TEST_F(GpuPreviewTest, ADragBeginsWhereTheHitTestSaysWhileThePickerIsBehind) {
  Studio studio(options(true));
  run(studio, ball(40962));
  int asked = 0;
  studio.set_hit_test([&](const Ray& ray) {
    ++asked;
    follow(studio);
    return preview_->hit(ray);
  });
  std::size_t gestures = 0;
  for (; asked == 0 && gestures < 40; gestures += 2) {  // until the second press came before the first drag was done
    std::istringstream lines(R"({"tool": "ball"}
{"press": [0, 0, 1]}
{"move": [0.1, 0.1, 1]}
{"release": [0.2, 0.1, 1]}
{"press": [-0.3, 0, 0.95]}
{"move": [-0.3, -0.1, 0.95]}
{"release": [-0.3, -0.2, 0.95]})");
    run_script(lines, "script", studio, {});
    studio.document().worker().wait();
    studio.refresh();
  }
  EXPECT_EQ(studio.document().shown().history.size(), gestures);
  follow(studio);
  EXPECT_TRUE(preview_->positions() == positions(studio));
  const int asked_meanwhile = asked;
  EXPECT_GE(asked_meanwhile, 1);
  run(studio, kHeld);
  EXPECT_EQ(asked, asked_meanwhile);
  EXPECT_EQ(errors(studio), "");
}

// As where the driver takes no buffers for all vertices.
TEST_F(GpuPreviewTest, InSeveralBuffers) {
  preview_.reset();
  preview_.emplace(gpu::GpuOptions{.most_points = 1024});
  Studio studio(options());
  run(studio, ball());
  follow(studio);
  run(studio, kHeld);
  follow(studio);
  EXPECT_LT(distance(studio), kAgree);
  EXPECT_NEAR(preview_->volume(), *studio.document().shown().volume, 1e-4);
  EXPECT_TRUE(preview_->hit({{0.35, 0.25, 5}, {0, 0, -1}}));
  run(studio, R"({"release": [0.4, 0.2, 1]})");
  follow(studio);
  EXPECT_TRUE(preview_->positions() == positions(studio));
}

TEST_F(GpuPreviewTest, ThePictureIsThatOfTheShapeSent) {
  Studio studio(options());
  run(studio, ball());
  follow(studio);
  render::LiveView other(1);
  ShownShape sent;
  sent.follow(studio.document().shown().state, nullptr, studio.document().shown().diagonal, other);
  run(studio, kHeld);
  follow(studio);
  sent.follow(studio.document().shown().state, nullptr, studio.document().shown().diagonal, other);
  render::LiveScene scene;
  scene.camera = studio.view().screen().camera;
  const render::Image on_gpu = view_->picture(scene, 200, 150);
  const render::Image expected = other.picture(scene, 200, 150);
  std::size_t different = 0;
  for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
    different += std::abs(expected.pixels[i] - on_gpu.pixels[i]) > 3 ? 1 : 0;
  }
  EXPECT_LE(different, 60u);  // of 120,000: rims by a pixel
  // The box may be larger, never smaller.
  const Box box = view_->box();
  for (const Vec3d& p : positions(studio)) {
    EXPECT_TRUE(p.x >= box.min.x - 1e-5 && p.x <= box.max.x + 1e-5 && p.y <= box.max.y + 1e-5);
  }
}

}  // namespace

namespace {

// A scene whose pictures take this long when coarse, four times as long with a sample for each pixel, and sixteen times
// when smooth.
void show(PictureQuality& quality, double seconds, int pictures, bool is_still = false) {
  for (int i = 0; i < pictures; ++i) {
    const Fineness fineness = quality.fineness(is_still);
    const double factor = fineness == Fineness::smooth ? 16 : fineness == Fineness::plain ? 4 : 1;
    quality.note(factor * seconds, fineness);
  }
}

TEST(PictureQuality, FastPicturesAreSmooth) {
  for (const bool in_software : {false, true}) {
    PictureQuality quality(in_software);
    EXPECT_EQ(quality.fineness(false), in_software ? Fineness::plain : Fineness::smooth);
    show(quality, 0.001, 100);
    EXPECT_EQ(quality.fineness(false), Fineness::smooth);
  }
}

TEST(PictureQuality, SlowOnesBecomeCoarserWhileTheyMoveOnly) {
  PictureQuality quality;
  show(quality, 0.05, 1);
  EXPECT_EQ(quality.fineness(false), Fineness::smooth);  // a slow one is no reason
  show(quality, 0.05, 1);
  EXPECT_EQ(quality.fineness(false), Fineness::plain);
  show(quality, 0.05, 2);
  EXPECT_EQ(quality.fineness(false), Fineness::coarse);
  EXPECT_EQ(quality.fineness(true), Fineness::smooth);
  show(quality, 0.05, 1, true);
  show(quality, 0.05, 100);
  EXPECT_EQ(quality.fineness(false), Fineness::coarse);
}

TEST(PictureQuality, TheyAreAsFineAsIsQuick) {
  PictureQuality quality;
  show(quality, 0.009, 200);
  EXPECT_EQ(quality.fineness(false), Fineness::plain);
}

TEST(PictureQuality, SmoothnessReturnsToMotionThatHasBecomeFast) {
  PictureQuality quality;
  show(quality, 0.05, 20);
  ASSERT_EQ(quality.fineness(false), Fineness::coarse);
  show(quality, 0.001, 200);
  EXPECT_EQ(quality.fineness(false), Fineness::smooth);
}

TEST(PictureQuality, AFinerPictureThatIsTooSlowIsTriedEverLessOften) {
  PictureQuality quality;
  int finer = 0;
  for (int i = 0; i < 1000; ++i) {
    show(quality, 0.015, 1);
    if (quality.fineness(false) != Fineness::coarse) ++finer;
  }
  EXPECT_GT(finer, 2);
  EXPECT_LT(finer, 60);
}

}  // namespace

}  // namespace knead::studio::shown_shape_test
