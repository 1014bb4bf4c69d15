// What a GPU and its points are made of. Internal to the gpu room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "knead/gpu/context.h"
#include "knead/gpu/gl_buffers.h"
#include "knead/gpu/gpu.h"
#include "knead/gpu/gpu_error.h"
#include "knead/gpu/packed_flow.h"

namespace knead::gpu {

// Points in buffers of their own, and the balls about groups of them.
struct Range {
  std::size_t begin = 0;
  std::size_t count = 0;
  Buffer points;
  Buffer steps;
  Buffer bounds;
  Buffer radii;

  void forget() {
    for (Buffer* buffer : {&points, &steps, &bounds, &radii}) buffer->forget();
  }
};

struct GpuPoints::State {
  const Context& context;
  std::vector<Range> ranges{};
  std::size_t size = 0;
  Buffer counts{};  // of the path lines since they were last asked for

  explicit State(const Context& of) : context(of) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    try {
      const CurrentContext current(context);
      ranges.clear();
      counts = {};
    } catch (const GpuError&) {  // of a lost GPU nothing is left to be freed
      for (Range& range : ranges) range.forget();
      counts.forget();
    }
  }
};

struct Gpu::State {
  Context context;
  std::size_t most_points = 0;  // to a range
  std::size_t most_bytes = 0;   // to a buffer
  bool unrolled = true;
  Transfers transfers;
  std::vector<std::pair<ShaderKind, Program>> programs;

  explicit State(const GpuOptions& options);
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State();

  const Program& program_of(const ShaderKind& kind);

  void count_sent(std::size_t bytes) {
    ++transfers.sent;
    transfers.bytes_sent += bytes;
  }
  void read(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, void* to) {
    ++transfers.read;
    transfers.bytes_read += bytes;
    read_buffer(buffer, first_byte, bytes, to);
  }
};

}  // namespace knead::gpu
