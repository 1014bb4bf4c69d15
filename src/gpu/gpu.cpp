// Moves points on a GPU: buffers of points, calls of shaders, and the backend that falls back to the CPU.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "gpu/gpu_state.h"
#include "knead/editor/gpu.h"
#include "knead/error.h"
#include "knead/vec.h"

namespace knead::gpu {

namespace {

constexpr int kVersion = 43;  // of OpenGL, with compute shaders
constexpr std::size_t kGroup = layout::kGroup;
static_assert(kGroup == Gpu::kGroup);
constexpr std::size_t kCountWords = static_cast<std::size_t>(layout::kCountStripes) * layout::kCounters;

// The middles and radii of the balls around groups of points.
struct Balls {
  std::vector<double> bounds;
  std::vector<float> radii;

  explicit Balls(std::span<const Vec3d> points)
      : bounds((points.size() + kGroup - 1) / kGroup * 4), radii(bounds.size() / 4) {
    parallel_for(radii.size(), 4096, 0, [&](std::size_t begin, std::size_t end) {
      for (std::size_t group = begin; group < end; ++group) {
        const Box box = bounding_box(points.subspan(group * kGroup, std::min(kGroup, points.size() - group * kGroup)));
        const Vec3d center = box.center();
        const std::array<double, 4> ball{center.x, center.y, center.z, 0};
        std::copy(ball.begin(), ball.end(), bounds.begin() + static_cast<std::ptrdiff_t>(4 * group));
        const auto radius = static_cast<float>(0.5 * box.diagonal() * (1 + 1e-6));
        radii[group] = std::max(radius, std::numeric_limits<float>::min());
      }
    });
  }
};

Range make_range(std::span<const Vec3d> points, std::size_t begin) {
  const Balls balls(points);
  Range range;
  range.begin = begin;
  range.count = points.size();
  range.points = gl::make_storage(points.data(), points.size_bytes());
  range.steps = gl::make_storage(nullptr, points.size() * sizeof(std::uint32_t));
  range.bounds = gl::make_storage(balls.bounds.data(), balls.bounds.size() * sizeof(double));
  range.radii = gl::make_storage(balls.radii.data(), balls.radii.size() * sizeof(float));
  return range;
}

// The packed segments in buffers.
struct SegmentBuffers {
  gl::Buffer numbers;
  gl::Buffer places;
  gl::Buffer table;

  SegmentBuffers(const PackedSegments& packed, bool in_double, Transfers& transfers) {
    if (in_double) {
      numbers = gl::make_storage(packed.numbers.data(), packed.numbers.size() * sizeof(double));
    } else {
      std::vector<float> rounded;
      for (const double x : packed.numbers) rounded.push_back(static_cast<float>(x));
      numbers = gl::make_storage(rounded.data(), rounded.size() * sizeof(float));
    }
    places = gl::make_storage(packed.places.data(), packed.places.size() * sizeof(double));
    table = gl::make_storage(packed.table.data(), packed.table.size() * sizeof(std::int32_t));
    transfers.sent += 3;
    transfers.bytes_sent += packed.numbers.size() * (in_double ? sizeof(double) : sizeof(float)) +
                            packed.places.size() * sizeof(double) + packed.table.size() * sizeof(std::int32_t);
  }
};

AdvectResult result_of(std::span<const std::uint32_t> words) {
  AdvectResult result;
  for (std::size_t at = 0; at < words.size(); at += layout::kCounters) {
    const auto number = [&](std::size_t k) { return words[at + k] | std::uint64_t{words[at + k + 1]} << 32; };
    result.accepted_steps += number(0);
    result.rejected_steps += number(2);
    result.evaluations += number(4);
    if (words[at + 6] != 0) result.status = AdvectStatus::step_limit;
    if (words[at + 7] != 0) {
      throw GpuError(
          "the graphics driver stops loops as long as these path lines need (Mesa's does on the CPU); use the CPU");
    }
  }
  return result;
}

void check(const Flow& flow, const AdvectOptions& options, std::size_t points) {
  validate(flow);
  validate(options, points);
  for (std::size_t i = 0; i < flow.segments.size(); ++i) {
    try {
      kind_of(flow.segments[i], options);
    } catch (const InvalidInput& error) {
      throw InvalidInput("segment " + std::to_string(i + 1) + " of the flow: " + error.what());
    }
  }
}

// Calls shaders.
struct Calls {
  Gpu::State& gpu;
  const AdvectOptions& options;
  bool waits = true;  // for the end of each call, so that long ones do not block the driver and can be cancelled

  bool are_cancelled() const { return waits && options.progress != nullptr && options.progress->cancel; }

  // Moves all points through segments of one kind. Returns false if it was cancelled.
  bool send(std::span<const Segment> segments, GpuPoints::State& points) const {
    const ShaderKind kind = kind_of(segments.front(), options);
    for (const PackedSegments& packed : pack(segments, options)) {
      if (!send(packed, kind, points)) return false;
    }
    if (are_cancelled()) return false;
    if (waits && options.progress != nullptr) options.progress->done += points.size * segments.size();
    return true;
  }

 private:
  bool send(const PackedSegments& packed, const ShaderKind& kind, GpuPoints::State& points) const {
    if (packed.numbers.size() * sizeof(double) > gpu.max_bytes) {
      throw GpuError("the graphics driver takes no point set or grid as large as this flow's; use the CPU");
    }
    const SegmentBuffers buffers(packed, kind.in_double, gpu.transfers);
    const gl::Program& program = gpu.program_of(kind);
    glUseProgram(program.get());
    glUniform1i(uniform(program, "segment_count"), packed.count);
    glUniform1i(uniform(program, "counts_steps"), options.steps.empty() ? 0 : 1);
    glUniform1i(uniform(program, "four"), 4);
    gl::bind_storage(4, buffers.numbers);
    gl::bind_storage(5, buffers.places);
    gl::bind_storage(6, buffers.table);
    gl::bind_storage(7, points.counts);
    for (const Range& range : points.ranges) {
      if (are_cancelled()) return false;
      glUniform1ui(uniform(program, "point_count"), static_cast<GLuint>(range.count));
      gl::bind_storage(0, range.points);
      gl::bind_storage(1, range.steps);
      gl::bind_storage(2, range.bounds);
      gl::bind_storage(3, range.radii);
      glDispatchCompute(static_cast<GLuint>((range.count + kGroup - 1) / kGroup), 1, 1);
      glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
      if (waits) glFinish();
      gl::require_no_error();
    }
    return true;
  }
};

// Clears the counts, and the points' steps if they are requested.
void clear_counts(GpuPoints::State& points, const AdvectOptions& options = {}) {
  if (!options.steps.empty()) {
    for (const Range& range : points.ranges) gl::clear_storage(range.steps);
  }
  gl::clear_storage(points.counts);
}

AdvectResult read_counts(Gpu::State& gpu, const GpuPoints::State& points) {
  std::vector<std::uint32_t> words(kCountWords);
  gpu.read(points.counts, 0, words.size() * sizeof(std::uint32_t), words.data());
  return result_of(words);
}

// A GPU that is opened on demand, and abandoned when it fails.
struct GpuOrCpu {
  std::mutex mutex;
  std::unique_ptr<Gpu> gpu;
  bool has_failed = false;
};

bool runs_on_gpu(const Flow& flow, const AdvectOptions& options) {
  try {
    for (const Segment& segment : flow.segments) kind_of(segment, options);
  } catch (const InvalidInput&) {
    return false;
  }
  return true;
}

constexpr std::size_t kThreadsToAWorkGroup = 64;  // as in the shader
constexpr std::size_t kWorkGroups = 1024;
constexpr std::size_t kMultiplyAddsToARound = 64;
constexpr int kMaxRounds = 60'000;  // Mesa stops loops on the CPU after 65535
constexpr double kMinSeconds = 0.02;
constexpr double kMinShareOfCall = 0.8;  // of the rounds' time, because the overhead of a call varies
constexpr int kRepetitions = 4;

// Sixteen independent chains of multiply-adds, whose sum the compiler cannot predict.
constexpr const char* kMultiplyAddShader = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) restrict writeonly buffer Result { float result[]; };
uniform int rounds;
uniform float factor;
uniform float summand;

void main() {
  vec4 a = vec4(gl_LocalInvocationID.x) * vec4(1.0, 2.0, 3.0, 4.0);
  vec4 b = a + 5.0;
  vec4 c = a + 6.0;
  vec4 d = a + 7.0;
  vec4 f = vec4(factor);
  vec4 s = vec4(summand);
  for (int i = 0; i < rounds; ++i) {
    a = a * f + s; b = b * f + s; c = c * f + s; d = d * f + s;
    a = a * f + s; b = b * f + s; c = c * f + s; d = d * f + s;
    a = a * f + s; b = b * f + s; c = c * f + s; d = d * f + s;
    a = a * f + s; b = b * f + s; c = c * f + s; d = d * f + s;
  }
  vec4 sum = a + b + c + d;
  result[gl_GlobalInvocationID.x] = sum.x + sum.y + sum.z + sum.w;
}
)";

// Returns the shortest time of some calls.
double seconds_of(const gl::Program& program, int rounds) {
  glUniform1i(uniform(program, "rounds"), rounds);
  double least = kInfinity;
  for (int i = 0; i < kRepetitions; ++i) {
    glFinish();
    const auto begin = std::chrono::steady_clock::now();
    glDispatchCompute(static_cast<GLuint>(kWorkGroups), 1, 1);
    glFinish();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  gl::require_no_error();
  return least;
}

}  // namespace

GpuPoints::GpuPoints(std::unique_ptr<State> state) : state_(std::move(state)) {}
GpuPoints::~GpuPoints() = default;
GpuPoints::GpuPoints(GpuPoints&&) noexcept = default;
GpuPoints& GpuPoints::operator=(GpuPoints&&) noexcept = default;
std::size_t GpuPoints::size() const { return state_->size; }

Gpu::State::State(const GpuOptions& options)
    : context(options.in_current_context ? gl::Context::adopt_current(kVersion) : gl::Context::open(kVersion)) {
  const gl::CurrentContext current(context);
  GLint64 bytes = 0;
  GLint groups = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
  glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &groups);
  max_bytes = static_cast<std::size_t>(std::max<GLint64>(bytes, 1 << 24));
  max_points = std::min(max_bytes / sizeof(Vec3d), static_cast<std::size_t>(std::max(groups, 65535)) * kGroup);
  if (options.most_points > 0) max_points = std::min(max_points, options.most_points);
  max_points = std::max(max_points / kGroup * kGroup, kGroup);
}

Gpu::State::~State() {
  try {
    const gl::CurrentContext current(context);
    programs.clear();
  } catch (const GpuError&) {
    for (auto& [kind, program] : programs) program.forget();
  }
}

const gl::Program& Gpu::State::program_of(const ShaderKind& kind) {
  const auto found =
      std::find_if(programs.begin(), programs.end(), [&](const auto& known) { return known.first == kind; });
  if (found != programs.end()) return found->second;
  programs.emplace_back(kind, gl::make_compute_program(shader_source(kind)));
  return programs.back().second;
}

Gpu::Gpu(const GpuOptions& options) : state_(std::make_unique<State>(options)) {}
Gpu::~Gpu() = default;

const std::string& Gpu::description() const { return state_->context.description(); }
bool Gpu::is_software() const { return state_->context.is_software(); }
Transfers Gpu::transfers() const { return state_->transfers; }

GpuPoints Gpu::upload(std::span<const Vec3d> points) {
  auto uploaded = std::make_unique<GpuPoints::State>(state_->context);
  uploaded->size = points.size();
  const gl::CurrentContext current(state_->context);
  for (std::size_t begin = 0; begin < points.size(); begin += state_->max_points) {
    const auto own = points.subspan(begin, std::min(state_->max_points, points.size() - begin));
    uploaded->ranges.push_back(make_range(own, begin));
    state_->count_sent(own.size_bytes());
  }
  uploaded->counts = gl::make_storage(nullptr, kCountWords * sizeof(std::uint32_t));
  clear_counts(*uploaded);
  glFinish();
  gl::require_no_error();
  return GpuPoints(std::move(uploaded));
}

void Gpu::write(GpuPoints& points, std::size_t first, std::span<const Vec3d> positions) {
  const std::size_t end = first + positions.size();
  if (end > points.size() || first % kGroup != 0 || (end % kGroup != 0 && end != points.size())) {
    throw InvalidInput("give whole groups of 64 of the GPU's points");
  }
  const gl::CurrentContext current(state_->context);
  for (const Range& range : points.state_->ranges) {
    const std::size_t begin = std::max(first, range.begin);
    const std::size_t stop = std::min(end, range.begin + range.count);
    if (begin >= stop) continue;
    const auto own = positions.subspan(begin - first, stop - begin);
    const Balls balls(own);
    const std::size_t place = begin - range.begin;
    gl::write_storage(range.points, place * sizeof(Vec3d), own.size_bytes(), own.data());
    gl::write_storage(range.bounds, place / kGroup * 4 * sizeof(double), balls.bounds.size() * sizeof(double),
                      balls.bounds.data());
    gl::write_storage(range.radii, place / kGroup * sizeof(float), balls.radii.size() * sizeof(float),
                      balls.radii.data());
    state_->count_sent(own.size_bytes());
  }
  gl::require_no_error();
}

void Gpu::assign(GpuPoints& to, const GpuPoints& from) const {
  if (to.size() != from.size()) throw InvalidInput("the GPU's points differ in number");
  const gl::CurrentContext current(state_->context);
  for (std::size_t i = 0; i < from.state_->ranges.size(); ++i) {
    const Range& source = from.state_->ranges[i];
    const Range& target = to.state_->ranges[i];
    const std::size_t groups = (source.count + kGroup - 1) / kGroup;
    gl::copy_storage(source.points, target.points, source.count * sizeof(Vec3d));
    gl::copy_storage(source.bounds, target.bounds, groups * 4 * sizeof(double));
    gl::copy_storage(source.radii, target.radii, groups * sizeof(float));
  }
  gl::require_no_error();
}

std::vector<GpuBuffer> Gpu::buffers(const GpuPoints& points) {
  std::vector<GpuBuffer> result;
  for (const Range& range : points.state_->ranges) result.push_back({range.points.get(), range.begin, range.count});
  return result;
}

AdvectResult Gpu::advect(const Flow& flow, GpuPoints& points, const AdvectOptions& options) {
  check(flow, options, points.size());
  const gl::CurrentContext current(state_->context);
  const Calls calls{*state_, options};
  clear_counts(*points.state_, options);
  std::span<const Segment> rest = flow.segments;
  AdvectResult result;
  while (!rest.empty() && result.status == AdvectStatus::done) {
    const std::size_t length = pack_length(rest, options);
    const bool is_done = calls.send(rest.first(length), *points.state_);
    rest = rest.subspan(length);
    result = read_counts(*state_, *points.state_);
    if (!is_done || calls.are_cancelled()) result.status = AdvectStatus::cancelled;
  }
  gl::require_no_error();
  if (options.steps.empty()) return result;
  std::vector<std::uint32_t> steps;
  for (const Range& range : points.state_->ranges) {
    steps.resize(range.count);
    state_->read(range.steps, 0, range.count * sizeof(std::uint32_t), steps.data());
    for (std::size_t i = 0; i < range.count; ++i) options.steps[range.begin + i] += steps[i];
  }
  return result;
}

void Gpu::enqueue(const Flow& flow, GpuPoints& points, const AdvectOptions& options) {
  check(flow, options, points.size());
  const gl::CurrentContext current(state_->context);
  AdvectOptions own = options;
  own.progress = nullptr;
  own.steps = {};
  const Calls calls{*state_, own, false};
  for (std::span<const Segment> rest = flow.segments; !rest.empty();) {
    const std::size_t length = pack_length(rest, options);
    calls.send(rest.first(length), *points.state_);
    rest = rest.subspan(length);
  }
}

AdvectResult Gpu::collect(GpuPoints& points) {
  const gl::CurrentContext current(state_->context);
  const AdvectResult result = read_counts(*state_, *points.state_);
  clear_counts(*points.state_);
  gl::require_no_error();
  return result;
}

void Gpu::download(const GpuPoints& points, std::span<Vec3d> result) {
  if (result.size() != points.size()) throw InvalidInput("give a place for each of the GPU's points");
  const gl::CurrentContext current(state_->context);
  for (const Range& range : points.state_->ranges) {
    state_->read(range.points, 0, range.count * sizeof(Vec3d), result.data() + range.begin);
  }
  gl::require_no_error();
}

AdvectResult Gpu::advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
  check(flow, options, points.size());
  GpuPoints on_gpu = upload(points);
  std::vector<std::uint32_t> steps(options.steps.size());
  AdvectOptions own = options;
  own.steps = steps;
  const AdvectResult result = advect(flow, on_gpu, own);
  if (result.status != AdvectStatus::done) return result;
  std::vector<Vec3d> moved(points.size());
  download(on_gpu, moved);
  std::copy(moved.begin(), moved.end(), points.begin());
  for (std::size_t i = 0; i < steps.size(); ++i) options.steps[i] += steps[i];
  return result;
}

Backend backend_or_cpu(std::function<void(const std::string& why)> on_failure, const GpuOptions& options) {
  const auto state = std::make_shared<GpuOrCpu>();
  return [state, options, tell = std::move(on_failure)](const Flow& flow, std::span<Vec3d> points,
                                                        const AdvectOptions& advect_options) {
    const std::scoped_lock lock(state->mutex);
    if (state->has_failed || !runs_on_gpu(flow, advect_options)) return knead::advect(flow, points, advect_options);
    const std::uint64_t done = advect_options.progress != nullptr ? advect_options.progress->done.load() : 0;
    std::string why;
    try {
      if (state->gpu == nullptr) state->gpu = std::make_unique<Gpu>(options);
      return state->gpu->advect(flow, points, advect_options);
    } catch (const GpuError& error) {
      why = error.what();
    } catch (const std::bad_alloc&) {  // the CPU needs less memory
      why = "there is too little memory for what goes to the GPU; close other programs, or use the CPU";
    }
    state->has_failed = true;
    state->gpu.reset();
    if (advect_options.progress != nullptr) advect_options.progress->done = done;
    if (tell) tell(why);
    return knead::advect(flow, points, advect_options);
  };
}

double Gpu::multiply_add_gflops() {
  const gl::CurrentContext current(state_->context);
  const gl::Program program = gl::make_compute_program(kMultiplyAddShader);
  const gl::Buffer result = gl::make_storage(nullptr, kWorkGroups * kThreadsToAWorkGroup * sizeof(float));
  glUseProgram(program.get());
  glUniform1f(uniform(program, "factor"), 0.999F);
  glUniform1f(uniform(program, "summand"), 0.001F);
  gl::bind_storage(0, result);
  // Measures the difference between twice as many rounds and these, because a call has overhead and may compile.
  int rounds = 1;
  double seconds = seconds_of(program, rounds);
  double more = 0;
  while (true) {
    const double doubled = seconds_of(program, 2 * rounds);
    more = doubled - seconds;
    if ((more >= kMinSeconds && more >= kMinShareOfCall * seconds) || 4 * rounds > kMaxRounds) break;
    rounds *= 2;
    seconds = doubled;
  }
  const double done = static_cast<double>(kWorkGroups * kThreadsToAWorkGroup * kMultiplyAddsToARound) * rounds;
  return 2e-9 * done / std::max(more, 1e-9);
}

}  // namespace knead::gpu
