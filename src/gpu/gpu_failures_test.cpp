// A GPU that fails under way: no point is lost, and the CPU goes on.
#include <gtest/gtest.h>

#include <optional>

#include "gl/objects.h"
#include "knead/editor/gl.h"
#include "knead/editor/gpu.h"
#include "support/gpu_fixture.h"
#include "support/provoked_failures.h"
#include "support/random_segments.h"
#include "support/sanitized.h"

namespace knead::gpu::gpu_failures_test {
namespace {

using test::moved;
using test::Random;

// With GPUs of their own, which it loses.
class GpuFailuresTest : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      gpu_.emplace();
    } catch (const GpuError& error) {
      if (says_none(error.what())) GTEST_SKIP() << error.what();
      FAIL() << error.what();
    }
    provoke_nothing();
  }
  void TearDown() override { provoke_nothing(); }

  Gpu& gpu() { return *gpu_; }
  void close() { gpu_.reset(); }

  // Where a GPU has memory of its own, or a sanitizer much more than it uses, a limit says nothing.
  bool can_starve() const { return gpu_->is_software() && !test::kSanitized; }

 private:
  std::optional<Gpu> gpu_;
};

Flow two_moves() {
  return {{test::translating(Ball<double>{}, {0, 0, 0}, {0.3, 0.1, 0}, {0.2, 0.5}),
           test::resting(Rotation<double>{{0, 0, 1}, 0.7, 1}, Ball<double>{}, {0.1, 0, 0}, {0.2, 0.5})}};
}

EGLDisplay gpu_display() {
  const gl::OffscreenContext context(43);
  return eglGetCurrentDisplay();
}

template <class Call>
std::string failure_of(Call call) {
  try {
    call();
  } catch (const GpuError& error) {
    return error.what();
  }
  return "none";
}

const char* const kNoAnswer = "the GPU does not answer; start again, or use the CPU";
const char* const kReset = "the GPU was lost (its driver was reset); start again, or use the CPU";

// A backend, what it said, and how it is called.
struct WatchedBackend {
  std::vector<std::string> said{};
  Backend backend = backend_or_cpu([this](const std::string& why) {
    lift_memory_limit();  // which is the GPU's
    said.push_back(why);
  });

  std::vector<Vec3d> moved_by(const Flow& flow, std::vector<Vec3d> points, Progress* progress = nullptr) const {
    AdvectOptions options = default_options(1);
    options.progress = progress;
    EXPECT_EQ(backend(flow, points, options).status, AdvectStatus::done);
    return points;
  }
};

TEST_F(GpuFailuresTest, ALostDisplayIsSaidByEveryCall) {
  Random random(841);
  const auto places = test::random_points(random, 300);
  GpuPoints points = gpu().upload(places);
  GpuPoints copy = gpu().upload(places);
  const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}};
  const GpuSurface surface(gpu(), triangles);
  gpu().enqueue(two_moves(), points, default_options(1));
  ASSERT_EQ(eglTerminate(gpu_display()), EGL_TRUE);
  auto own = places;
  EXPECT_EQ(failure_of([&] { gpu().advect(two_moves(), own, default_options(1)); }), kNoAnswer);
  EXPECT_EQ(bits(own), bits(places));
  EXPECT_EQ(failure_of([&] { gpu().advect(two_moves(), points, default_options(1)); }), kNoAnswer);
  EXPECT_EQ(failure_of([&] { gpu().enqueue(two_moves(), points, default_options(1)); }), kNoAnswer);
  EXPECT_EQ(failure_of([&] { gpu().collect(points); }), kNoAnswer);
  EXPECT_EQ(failure_of([&] { gpu().upload(places); }), kNoAnswer);
  EXPECT_EQ(failure_of([&] { gpu().download(points, own); }), kNoAnswer);
  EXPECT_EQ(bits(own), bits(places));
  EXPECT_EQ(failure_of([&] { gpu().write(points, 0, places); }), kNoAnswer);
  EXPECT_EQ(failure_of([&] { gpu().assign(copy, points); }), kNoAnswer);
  EXPECT_EQ(failure_of([&] { surface.volume(points, {}); }), kNoAnswer);
  EXPECT_EQ(failure_of([&] { surface.first_hit(points, {}, {0, 0, 1}); }), kNoAnswer);
  EXPECT_EQ(failure_of([&] { const GpuSurface another(gpu(), triangles); }), kNoAnswer);
  Gpu next;  // there is still a GPU
  EXPECT_EQ(next.advect(two_moves(), own, default_options(1)).status, AdvectStatus::done);
  EXPECT_NE(bits(own), bits(places));
}

// Names of buffers mean other ones in another context.
TEST_F(GpuFailuresTest, ALostGpuLeavesOtherContextsAlone) {
  std::optional<GpuPoints> points = gpu().upload(std::vector<Vec3d>(300));
  EGLDisplay lost = gpu_display();
  EGLDisplay other = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (other == lost || eglInitialize(other, nullptr, nullptr) == EGL_FALSE) GTEST_SKIP() << "there is but one display";
  EGLContext context = eglCreateContext(other, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, nullptr);
  ASSERT_EQ(eglMakeCurrent(other, EGL_NO_SURFACE, EGL_NO_SURFACE, context), EGL_TRUE);
  std::vector<gl::Buffer> own;
  constexpr std::size_t count = 20;
  own.reserve(count);
  for (std::size_t i = 0; i < count; ++i) own.push_back(gl::make_storage(nullptr, 64));
  ASSERT_EQ(eglTerminate(lost), EGL_TRUE);
  points.reset();
  close();
  EXPECT_EQ(eglGetCurrentContext(), context);
  for (const gl::Buffer& buffer : own) EXPECT_EQ(glIsBuffer(buffer.get()), GL_TRUE);
  own.clear();
  eglMakeCurrent(other, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(other, context);
}

TEST_F(GpuFailuresTest, TheCpuTakesOverFromALostDisplay) {
  Random random(842);
  const auto points = test::random_points(random, 300);
  const auto on_cpu = moved(two_moves(), points, default_options(1));
  auto on_gpu = points;
  gpu().advect(two_moves(), on_gpu, default_options(1));
  for (int lost_at = 1; lost_at <= 4; ++lost_at) {  // points go up, are moved, come down, are freed
    SCOPED_TRACE(lost_at);
    WatchedBackend watched;
    EXPECT_EQ(bits(watched.moved_by(two_moves(), points)), bits(on_gpu));
    Progress progress;
    lose_display_at_call(lost_at);
    const auto found = watched.moved_by(two_moves(), points, &progress);
    EXPECT_EQ(progress.done, 600U);
    if (lost_at < 4) {
      EXPECT_EQ(bits(found), bits(on_cpu));
      EXPECT_EQ(watched.said, std::vector<std::string>{kNoAnswer});
    } else {
      EXPECT_EQ(bits(found), bits(on_gpu));
      EXPECT_TRUE(watched.said.empty());
    }
    EXPECT_EQ(bits(watched.moved_by(two_moves(), points)), bits(on_cpu));
    EXPECT_EQ(watched.said, std::vector<std::string>{kNoAnswer});  // said once
  }
}

TEST_F(GpuFailuresTest, TheCpuTakesOverFromADriverThatWasReset) {
  Random random(843);
  const auto points = test::random_points(random, 300);
  const auto on_cpu = moved(two_moves(), points, default_options(1));
  auto untouched = points;
  int resets = 0;
  for (int call = 1; call <= 20; ++call) {
    SCOPED_TRACE(call);
    Gpu own;
    report_reset_at_call(call);
    const std::string failure = failure_of([&] { own.advect(two_moves(), untouched, default_options(1)); });
    if (failure == "none") break;
    EXPECT_EQ(failure, kReset);
    EXPECT_EQ(bits(untouched), bits(points));
    WatchedBackend watched;
    report_reset_at_call(call);
    EXPECT_EQ(bits(watched.moved_by(two_moves(), points)), bits(on_cpu));
    EXPECT_EQ(watched.said, std::vector<std::string>{kReset});
    ++resets;
  }
  EXPECT_GE(resets, 4);  // asked after going up, two calls of shaders, coming down
  EXPECT_LT(resets, 20);
}

// More than malloc keeps for itself: what is refused is a map of memory. Most are beyond any tool's reach.
std::vector<Vec3d> many_points() {
  Random random(844);
  std::vector<Vec3d> points = test::random_points(random, 1000);
  points.resize(2'000'000, Vec3d{10, 10, 10});
  return points;
}

TEST_F(GpuFailuresTest, TheCpuTakesOverWhereTheCardHasTooLittleMemory) {
  if (!can_starve()) GTEST_SKIP() << "the GPU's memory is its own";
  const auto points = many_points();
  WatchedBackend watched;
  const std::vector<Vec3d> few(points.begin(), points.begin() + 1000);
  watched.moved_by(two_moves(), few);
  EXPECT_TRUE(watched.said.empty());
  starve_buffers(1 << 25);
  const std::string expected =
      "the GPU has too little memory left for 48 MB more; close other programs that use it, or use the CPU";
  EXPECT_EQ(failure_of([&] { gpu().upload(points); }), expected);
  auto small = few;
  EXPECT_EQ(gpu().advect(two_moves(), small, default_options(1)).status, AdvectStatus::done);  // it is not lost
  Progress progress;
  const auto found = watched.moved_by(two_moves(), points, &progress);
  EXPECT_EQ(watched.said, std::vector<std::string>{expected});
  EXPECT_EQ(progress.done, 2 * points.size());
  EXPECT_TRUE(found == moved(two_moves(), points, default_options(1)));
}

// The copy that comes down finds no place.
TEST_F(GpuFailuresTest, TheCpuTakesOverWhereTheProcessHasTooLittleMemory) {
  if (!can_starve()) GTEST_SKIP() << "memory cannot be limited here";
  const auto points = many_points();
  WatchedBackend watched;
  // The driver compiles its shaders here: where they find no memory, it ends the process.
  watched.moved_by(two_moves(), {points.begin(), points.begin() + 1000});
  EXPECT_TRUE(watched.said.empty());
  static const auto real = reinterpret_cast<PFNGLGETBUFFERSUBDATAPROC>(eglGetProcAddress("glGetBufferSubData"));
  epoxy_glGetBufferSubData = [](GLenum target, GLintptr offset, GLsizeiptr size, void* data) {
    real(target, offset, size, data);
    limit_memory(1 << 20);
  };
  const auto found = watched.moved_by(two_moves(), points);
  epoxy_glGetBufferSubData = real;
  ASSERT_EQ(watched.said.size(), 1U);
  EXPECT_EQ(watched.said[0].find("there is too little memory"), 0U) << watched.said[0];
  EXPECT_TRUE(found == moved(two_moves(), points, default_options(1)));
}

}  // namespace
}  // namespace knead::gpu::gpu_failures_test
