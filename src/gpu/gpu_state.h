// The internal state of Gpu and GpuPoints.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "gl/objects.h"
#include "gpu/packed.h"
#include "knead/editor/gl.h"
#include "knead/editor/gpu.h"

namespace knead::gpu {

// Points in one set of buffers, and the balls around groups of them.
struct Range {
  std::size_t begin = 0;
  std::size_t count = 0;
  gl::Buffer points;
  gl::Buffer steps;
  gl::Buffer bounds;
  gl::Buffer radii;

  void forget() {
    for (gl::Buffer* buffer : {&points, &steps, &bounds, &radii}) buffer->forget();
  }
};

struct GpuPoints::State {
  const gl::Context& context;
  std::vector<Range> ranges{};
  std::size_t size = 0;
  gl::Buffer counts{};  // of the path lines since they were last read

  explicit State(const gl::Context& of) : context(of) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    try {
      const gl::CurrentContext current(context);
      ranges.clear();
      counts = {};
    } catch (const GpuError&) {  // a lost GPU has freed everything
      for (Range& range : ranges) range.forget();
      counts.forget();
    }
  }
};

struct Gpu::State {
  gl::Context context;
  std::size_t max_points = 0;  // of a range
  std::size_t max_bytes = 0;   // of a buffer
  Transfers transfers;
  std::vector<std::pair<ShaderKind, gl::Program>> programs;

  explicit State(const GpuOptions& options);
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State();

  const gl::Program& program_of(const ShaderKind& kind);

  void count_sent(std::size_t bytes) {
    ++transfers.sent;
    transfers.bytes_sent += bytes;
  }
  void read(const gl::Buffer& buffer, std::size_t first_byte, std::size_t bytes, void* to) {
    ++transfers.read;
    transfers.bytes_read += bytes;
    gl::read_storage(buffer, first_byte, bytes, to);
  }
};

}  // namespace knead::gpu
