// Moving points along the path lines of a flow on a GPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/flow/backend.h"
#include "knead/gl/context.h"

namespace knead::gpu {

struct GpuOptions {
  std::size_t most_points = 0;  // to a buffer; more go in several. 0: as many as the driver takes
  // Whether the stages of a step are written out in the shaders. Nothing: on GPUs, where they then stay in registers,
  // but not on the CPU, where the compiler takes longest.
  std::optional<bool> unrolled{};
  // In the OpenGL context that is current where the GPU is made, instead of one of its own: what draws there then
  // has the GPU's buffers. It must be current at every call, and when GPU and points are destroyed.
  bool in_current_context = false;
};

// What went to and from the GPU's memory since it was opened; buffers without data and copies there not counted.
struct Transfers {
  std::uint64_t sent = 0;  // times
  std::uint64_t bytes_sent = 0;
  std::uint64_t read = 0;  // back from the GPU, which waits for it each time
  std::uint64_t bytes_read = 0;
};

// A part of the GPU's points: an OpenGL buffer with three doubles for each.
struct GpuBuffer {
  unsigned int name = 0;
  std::size_t begin = 0;  // the first point
  std::size_t count = 0;
};

// Points in a GPU's memory, where flows move them. Must not outlive its GPU. Movable.
class GpuPoints {
 public:
  ~GpuPoints();
  GpuPoints(const GpuPoints&) = delete;
  GpuPoints& operator=(const GpuPoints&) = delete;
  GpuPoints(GpuPoints&&) noexcept;
  GpuPoints& operator=(GpuPoints&&) noexcept;

  std::size_t size() const;

  struct State;  // internal to the gpu room

 private:
  friend class Gpu;
  friend class GpuSurface;
  explicit GpuPoints(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// A GPU with OpenGL 4.3, or Mesa's stand-in for one. Positions are double and fields are evaluated about the
// tool's centre in options.precision, as on the CPU; every path line begins when a tool reaches it, and its steps are
// bounded and chosen in the same way, by the same integrators. So a point is moved as advect moves it up to the
// tolerance; on one GPU and driver its bits depend on that point alone, but from one GPU to another, and between
// GPU and CPU, they differ: drivers round divisions and roots, and contract products with sums, as they like (where
// it matters the shaders forbid it, which most drivers heed). Points that no tool touches keep their bits everywhere.
//
// Calls may come from any thread, one at a time. All throw GpuError where the GPU fails; the points given are
// then as they were. Shaders are compiled as segments need them, which takes some tenths of a second for each kind.
class Gpu {
 public:
  explicit Gpu(const GpuOptions& options = {});  // throws GpuError where there is none
  ~Gpu();
  Gpu(const Gpu&) = delete;
  Gpu& operator=(const Gpu&) = delete;

  // Of the GPU and its driver, and whether it is the CPU in truth.
  const std::string& description() const;
  bool is_software() const;

  Transfers transfers() const;

  GpuPoints upload(std::span<const Vec3d> points);

  // As knead::advect, of which options.threads is not looked at. Throws InvalidInput for what that throws it for, and
  // for fields with functions of the caller's own. options.progress is asked between calls of shaders; on `cancelled`
  // and `step_limit` the points are left part-way.
  AdvectResult advect(const Flow& flow, GpuPoints& points, const AdvectOptions& options);

  void download(const GpuPoints& points, std::span<Vec3d> result);

  // As advect, without waiting: what is done with the points next on the GPU finds them moved. Neither steps nor
  // progress of the options are looked at.
  void enqueue(const Flow& flow, GpuPoints& points, const AdvectOptions& options);

  // What became of all that was enqueued since this was last asked. Waits.
  AdvectResult collect(GpuPoints& points);

  // Other places for points [first, first + positions.size()): whole groups of kGroup, or up to the last point. Throws
  // InvalidInput for others.
  static constexpr std::size_t kGroup = 64;
  void write(GpuPoints& points, std::size_t first, std::span<const Vec3d> positions);

  // A copy on the GPU, of as many points.
  void assign(GpuPoints& to, const GpuPoints& from) const;

  // Where the points are, for what else is done with them in the GPU's context.
  static std::vector<GpuBuffer> buffers(const GpuPoints& points);

  // Multiply-adds of single precision a second times two, in units of 1e9, that the GPU reaches with nothing else to
  // do. Takes some tenths of a second.
  double multiply_add_gflops();

  // Upload, advect and download. Where the status is not `done` the points are as they were.
  AdvectResult advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options);

  struct State;  // internal to the gpu room

 private:
  friend class GpuSurface;
  std::unique_ptr<State> state_;
};

// Moves points by the GPU that is opened at the first call. From the first failure of the GPU on the CPU moves
// them, after `on_failure` was told why: the points are never lost. So are flows with functions of the caller's own.
Backend backend_or_cpu(std::function<void(const std::string& why)> on_failure, const GpuOptions& options = {});

}  // namespace knead::gpu
