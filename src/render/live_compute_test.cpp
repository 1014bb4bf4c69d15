// Shapes whose vertices are on the GPU look as those that were sent.
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <span>
#include <vector>

#include "gl/objects.h"
#include "knead/error.h"
#include "support/live_view_fixture.h"

namespace knead::render::live_compute_test {
namespace {

class LiveComputeTest : public LiveViewTest {
 protected:
  void SetUp() override {
    LiveViewTest::SetUp();
    if (!IsSkipped() && epoxy_gl_version() < 43) GTEST_SKIP() << "no OpenGL 4.3";
  }

  // In buffers of so many vertices each.
  void move_on_gpu(const std::vector<Vec3d>& positions, std::size_t most = 1U << 20) {
    std::vector<gl::Buffer> buffers;
    std::vector<PointBuffer> parts;
    for (std::size_t begin = 0; begin < positions.size(); begin += most) {
      const auto own = std::span(positions).subspan(begin, std::min(most, positions.size() - begin));
      buffers.push_back(gl::make_buffer(GL_SHADER_STORAGE_BUFFER, own.data(), own.size_bytes()));
      const auto first = static_cast<std::uint32_t>(begin);
      parts.push_back({buffers.back().get(), {first, first + static_cast<std::uint32_t>(own.size())}});
    }
    view_->move_on_gpu(parts, bounding_box(positions));
  }

  // The shape moved from `before` to `positions` on the GPU, held against the same moved by the CPU.
  void expect_the_same(const Mesh& before, const std::vector<Vec3d>& positions, const LiveScene& scene,
                       std::size_t most = 1U << 20) {
    const VertexRange all = all_of(before);
    const Image start = picture_of(before, scene);
    view_->move(positions, {&all, 1});
    const Image sent = picture(scene);
    EXPECT_GT(different_pixels(start, sent), 100);
    view_->set_shape(before);
    move_on_gpu(positions, most);
    EXPECT_EQ(view_->counts().bytes, 0u);
    const Image on_gpu = picture(scene);
    EXPECT_LE(different_pixels(sent, on_gpu), 20);  // where rounding tips an edge over a pixel's centre
    EXPECT_LT(norm(view_->box().max - bounding_box(positions).max), 1e-5);
  }
};

TEST_F(LiveComputeTest, SmoothShapes) {
  const Mesh before = sphere({}, 1);
  Mesh after = before;
  dent(after, 0.8);
  LiveScene scene = scene_of(before);
  scene.camera.eye = normalized(before.positions.front()) * 5.0;
  expect_the_same(before, after.positions, scene);
  expect_the_same(before, after.positions, scene, 1000);  // in three buffers
}

TEST_F(LiveComputeTest, CreasesStay) {
  const Mesh before = cube();
  std::vector<Vec3d> after = before.positions;
  for (Vec3d& p : after) p = {0.8 * p.x + 0.3 * p.y, p.y, p.z + 0.4 * p.x};
  expect_the_same(before, after, scene_of(before, Projection::perspective));
}

TEST_F(LiveComputeTest, CloudsOfPoints) {
  Mesh before = sphere({}, 1);
  before.face_begin = {0};
  before.corner_vertex.clear();
  std::vector<Vec3d> after = before.positions;
  for (Vec3d& p : after) p = p * 0.6;
  expect_the_same(before, after, scene_of(before));
}

TEST_F(LiveComputeTest, FarFromTheOriginTooFineForFloat) {
  const Vec3d far{1e6, -2e6, 3e5};
  const Mesh before = sphere(far, 0.01);
  std::vector<Vec3d> after = before.positions;
  for (Vec3d& p : after) p.y = far.y + 0.7 * (p.y - far.y);
  view_->set_shape(before);
  expect_the_same(before, after, scene_of(before));
}

// Sending goes on as if all had been sent, also of a part.
TEST_F(LiveComputeTest, BackToSending) {
  const Mesh before = sphere({}, 1);
  Mesh after = before;
  const std::vector<VertexRange> ranges = dent(after, 0.8);
  LiveScene scene = scene_of(before);
  view_->set_shape(before);
  view_->move(after.positions, ranges);
  const Image expected = picture(scene);
  view_->set_shape(before);
  std::vector<Vec3d> elsewhere = before.positions;
  for (Vec3d& p : elsewhere) p.x *= 0.5;
  move_on_gpu(elsewhere);
  view_->move(after.positions, ranges);
  EXPECT_EQ(picture(scene), expected);
}

TEST_F(LiveComputeTest, RefusesBuffersOfAnotherShape) {
  const Mesh ball = sphere({}, 1, 642);
  view_->set_shape(ball);
  EXPECT_THROW(view_->move_on_gpu({}, {}), InvalidInput);
  const PointBuffer apart[] = {{0, {0, 100}}, {0, {200, 642}}};
  EXPECT_THROW(view_->move_on_gpu(apart, {}), InvalidInput);
}

}  // namespace
}  // namespace knead::render::live_compute_test
