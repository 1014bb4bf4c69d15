// Moves points along the path lines of a flow on a GPU, and measures surfaces whose points are there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/editor/gl.h"
#include "knead/flow.h"

namespace knead::gpu {

// Options of Gpu.
struct GpuOptions {
  // The largest number of points in one buffer; more points use several buffers. 0: as many as the driver allows.
  std::size_t most_points = 0;
  // True: works in the OpenGL context that is current when the Gpu is made, so that the buffers can be drawn there.
  // That context must be current at every call, and when the Gpu and its points are destroyed. False: makes its own
  // context.
  bool in_current_context = false;
};

// The data sent to and read from the GPU's memory since it was opened. Empty buffers and copies on the GPU do not
// count.
struct Transfers {
  std::uint64_t sent = 0;  // times
  std::uint64_t bytes_sent = 0;
  std::uint64_t read = 0;  // times; each waits for the GPU
  std::uint64_t bytes_read = 0;
};

// An OpenGL buffer that holds a part of the points: three doubles for each.
struct GpuBuffer {
  unsigned int name = 0;
  std::size_t begin = 0;  // the first point
  std::size_t count = 0;
};

// Points in a GPU's memory, where flows move them. Must not outlive their Gpu.
class GpuPoints {
 public:
  ~GpuPoints();
  GpuPoints(const GpuPoints&) = delete;
  GpuPoints& operator=(const GpuPoints&) = delete;
  GpuPoints(GpuPoints&&) noexcept;
  GpuPoints& operator=(GpuPoints&&) noexcept;

  // Returns the number of points.
  std::size_t size() const;

  struct State;  // internal

 private:
  friend class Gpu;
  friend class GpuSurface;
  explicit GpuPoints(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// A GPU with OpenGL 4.3, or Mesa's driver that runs on the CPU. Opened by the constructor; needs no display.
//
// Accuracy: the same integrators and the same step control as `advect` on the CPU move each point, so that its error
// stays within the tolerance. Positions are double; fields are evaluated relative to the tool's centre in
// options.precision. Points that no tool touches keep their bits.
//
// Bits: on one GPU and driver the result for a point depends on that point alone. Results differ between GPUs, and from
// the CPU, because drivers round divisions and roots differently and contract products with sums. The shaders forbid
// contraction where it matters, which most drivers respect.
//
// Errors: every function throws GpuError if the GPU fails, and leaves the caller's points as they were.
// Threads: calls may come from any thread, one at a time.
// Cost: a shader is compiled for each new kind of segment, which takes some tenths of a second.
class Gpu {
 public:
  explicit Gpu(const GpuOptions& options = {});  // throws GpuError if there is no GPU
  ~Gpu();
  Gpu(const Gpu&) = delete;
  Gpu& operator=(const Gpu&) = delete;

  // Returns the names of the GPU and its driver.
  const std::string& description() const;
  // Returns true if the CPU does the work of a GPU.
  bool is_software() const;

  // Returns what has been sent and read back so far.
  Transfers transfers() const;

  // Copies the points to the GPU.
  GpuPoints upload(std::span<const Vec3d> points);

  // Moves the points, as knead::advect does; ignores options.threads. Checks options.progress between calls of
  // shaders, and while the equations of pins are solved. With the status `cancelled` or `step_limit` the points stop on
  // their path lines. Throws InvalidInput where knead::advect does, for fields that are functions of the caller, and
  // for handles, segments with a mask and sums. Where pins come too near each other for their equations, the segments
  // before have moved the points.
  AdvectResult advect(const Flow& flow, GpuPoints& points, const AdvectOptions& options);

  // Copies the points to `result`, which has as many elements.
  void download(const GpuPoints& points, std::span<Vec3d> result);

  // Starts to move the points, and does not wait: later operations on the GPU find them moved. The equations of pins
  // are solved at once, on the CPU. Ignores options.steps and options.progress. Throws as advect.
  void enqueue(const Flow& flow, GpuPoints& points, const AdvectOptions& options);

  // Waits for all enqueued flows, and returns their result since the last call.
  AdvectResult collect(GpuPoints& points);

  // Replaces the points [first, first + positions.size()), in whole groups of kGroup or up to the last point. Throws
  // InvalidInput for other ranges.
  static constexpr std::size_t kGroup = 64;
  // Replaces points; see kGroup for the ranges that are allowed.
  void write(GpuPoints& points, std::size_t first, std::span<const Vec3d> positions);

  // Copies `from` to `to` on the GPU. Throws InvalidInput if they differ in size.
  void assign(GpuPoints& to, const GpuPoints& from) const;

  // Returns the buffers that hold the points, to use them in the Gpu's context.
  static std::vector<GpuBuffer> buffers(const GpuPoints& points);

  // Returns the greatest rate of multiply-adds in single precision, in 1e9 operations a second; a multiply-add counts
  // as two. Takes some tenths of a second.
  double multiply_add_gflops();

  // Uploads, moves and downloads the points. They stay as they were unless the status is `done`.
  AdvectResult advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options);

  struct State;  // internal

 private:
  friend class GpuSurface;
  std::unique_ptr<State> state_;
};

// Returns a backend that opens a Gpu at its first call and moves points there. If the GPU fails, the backend calls
// `on_failure` with the reason once, and moves these points and all later ones on the CPU. It also moves flows with
// functions of the caller or with a mask on the CPU.
Backend backend_or_cpu(std::function<void(const std::string& why)> on_failure, const GpuOptions& options = {});

// The first triangle that a ray hits.
struct GpuHit {
  std::uint32_t triangle = 0;
  double t = 0;                    // at origin + t direction
  std::array<Vec3d, 3> corners{};  // as they are on the GPU
  // The smallest t at which the ray leaves the shape, on the side of a triangle's normal; t itself if the ray began
  // inside. Empty if it does not leave.
  std::optional<double> leaves_at{};
};

// Triangles in a GPU's memory. Their indices refer to the points given to each call. Must not outlive its Gpu.
//
// Every function throws GpuError if the GPU fails or if the points fill more than four buffers, and InvalidInput if a
// triangle refers to a point that does not exist.
class GpuSurface {
 public:
  GpuSurface(Gpu& gpu, std::span<const std::array<std::uint32_t, 3>> triangles);
  ~GpuSurface();
  GpuSurface(const GpuSurface&) = delete;
  GpuSurface& operator=(const GpuSurface&) = delete;
  GpuSurface(GpuSurface&&) noexcept;
  GpuSurface& operator=(GpuSurface&&) noexcept;

  // Returns the signed volume: a sixth of the sum of (a - origin) . ((b - origin) x (c - origin)), positive if
  // triangles are counter-clockwise seen from outside. For a closed surface the origin matters only for rounding, which
  // is smallest if the origin is near. The sum is in double, and its order depends only on the number of triangles: one
  // GPU and driver always return the same bits. Reads 8 bytes.
  double volume(const GpuPoints& points, const Vec3d& origin) const;

  // Returns the first triangle that the ray hits at t >= 0, of several at the same t the one with the lowest number;
  // empty if there is none. The direction is not zero; it need not be a unit vector. The GPU selects the triangles that
  // the ray may hit, and the CPU decides among them with the formulas and exact signs of SurfaceTree
  // (knead/mesh.h); so both return the same bit for bit. Time: linear in the number of triangles. Reads about
  // 1 KB, and a second time if the ray may hit more than 16 triangles.
  std::optional<GpuHit> first_hit(const GpuPoints& points, const Vec3d& origin, const Vec3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace knead::gpu
