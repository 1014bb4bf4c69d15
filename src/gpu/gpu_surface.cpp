// Volumes and rays of a surface whose points are on a GPU.
#include "knead/editor/gpu.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "gpu/glsl.h"
#include "gpu/gpu_state.h"
#include "knead/error.h"
#include "math/geometry.h"

namespace knead::gpu {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

// The layout of the shader.
struct Candidate {
  std::array<Vec3d, 3> corners{};
  std::uint32_t triangle = 0;
  std::uint32_t unused = 0;
};
static_assert(sizeof(Candidate) == 80);
constexpr std::size_t kHeaderBytes = 8;  // the number of candidates
constexpr std::size_t kReadAtOnce = 16;

constexpr std::size_t bytes_of(std::size_t candidates) { return kHeaderBytes + candidates * sizeof(Candidate); }

// Triangles in one buffer.
struct Part {
  std::size_t begin = 0;
  std::size_t count = 0;
  gl::Buffer triangles;

  std::size_t groups() const { return (count + kTrianglesToAWorkGroup - 1) / kTrianglesToAWorkGroup; }
};

std::size_t groups_of(const std::vector<Part>& parts) {
  std::size_t sum = 0;
  for (const Part& part : parts) sum += part.groups();
  return sum;
}

void set(const gl::Program& program, const char* name, std::size_t value) {
  glUniform1ui(uniform(program, name), static_cast<GLuint>(value));
}

void set(const gl::Program& program, const char* name, const Vec3d& value) {
  glUniform3d(uniform(program, name), value.x, value.y, value.z);
}

void bind_points(const gl::Program& program, const GpuPoints::State& points) {
  if (points.ranges.size() > kSurfaceRanges) {
    throw GpuError("the graphics driver's buffers are too small for a surface of so many points; use the CPU");
  }
  set(program, "points_to_a_range", points.ranges.front().count);
  for (std::size_t i = 0; i < kSurfaceRanges; ++i) {
    gl::bind_storage(static_cast<GLuint>(i), points.ranges[std::min(i, points.ranges.size() - 1)].points);
  }
}

// Returns the first candidate that the ray meets, and where the ray first leaves.
std::optional<GpuHit> nearest_of(std::span<const Candidate> candidates, const TriangleRay& ray) {
  const Candidate* nearest = nullptr;
  double t = kInfinity;
  double leaves_at = kInfinity;
  for (const Candidate& candidate : candidates) {
    const std::optional<TriangleRay::Meeting> meeting = ray.meet(candidate.corners);
    if (!meeting || !(meeting->t >= 0)) continue;
    if (meeting->leaves) leaves_at = std::min(leaves_at, meeting->t);
    if (nearest != nullptr && std::pair(t, nearest->triangle) < std::pair(meeting->t, candidate.triangle)) continue;
    nearest = &candidate;
    t = meeting->t;
  }
  if (nearest == nullptr) return std::nullopt;
  GpuHit hit{nearest->triangle, t, nearest->corners};
  if (std::isfinite(leaves_at)) hit.leaves_at = leaves_at;
  return hit;
}

}  // namespace

struct GpuSurface::State {
  Gpu::State& gpu;
  std::size_t points = 0;  // that the triangles need
  std::vector<Part> parts{};
  gl::Program volume{};
  gl::Program sum{};
  gl::Program candidates{};
  gl::Buffer group_sums{};
  gl::Buffer result{};
  gl::Buffer found{};
  std::size_t capacity = 256;  // of `found`

  explicit State(Gpu::State& of) : gpu(of) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State();

  void open(std::span<const Triangle> triangles);

  void require(const GpuPoints::State& of) const {
    if (of.size < points) throw InvalidInput("a triangle refers to a point that does not exist");
  }

  // Runs the program in use over all triangles.
  template <class Before>
  void dispatch(const gl::Program& program, Before before) const {
    for (const Part& part : parts) {
      gl::bind_storage(kTrianglesPlace, part.triangles);
      set(program, "triangle_count", part.count);
      before(part);
      glDispatchCompute(static_cast<GLuint>(part.groups()), 1, 1);
    }
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    gl::require_no_error();
  }

  void find_candidates(const GpuPoints::State& of, const Vec3d& origin, const Vec3d& direction) const;
  std::vector<Candidate> read_candidates();
};

void GpuSurface::State::open(std::span<const Triangle> triangles) {
  for (const Triangle& t : triangles) points = std::max<std::size_t>(points, std::max({t[0], t[1], t[2]}) + 1ULL);
  const gl::CurrentContext current(gpu.context);
  constexpr std::size_t max_groups = 65535;  // that every driver accepts in a call
  const std::size_t groups = gpu.max_bytes / sizeof(Triangle) / kTrianglesToAWorkGroup;
  const std::size_t most = std::clamp<std::size_t>(groups, 1, max_groups) * kTrianglesToAWorkGroup;
  for (std::size_t begin = 0; begin < triangles.size(); begin += most) {
    const auto own = triangles.subspan(begin, std::min(most, triangles.size() - begin));
    parts.push_back({begin, own.size(), gl::make_storage(own.data(), own.size_bytes())});
    gpu.count_sent(own.size_bytes());
  }
  volume = gl::make_compute_program(volume_source());
  sum = gl::make_compute_program(sum_source());
  candidates = gl::make_compute_program(candidates_source());
  group_sums = gl::make_storage(nullptr, groups_of(parts) * sizeof(double));
  result = gl::make_storage(nullptr, sizeof(double));
  found = gl::make_storage(nullptr, bytes_of(capacity));
  gl::require_no_error();
}

GpuSurface::State::~State() {
  try {
    const gl::CurrentContext current(gpu.context);
    parts.clear();
    for (gl::Program* program : {&volume, &sum, &candidates}) *program = {};
    for (gl::Buffer* buffer : {&group_sums, &result, &found}) *buffer = {};
  } catch (const GpuError&) {  // a lost GPU has freed everything
    for (Part& part : parts) part.triangles.forget();
    for (gl::Program* program : {&volume, &sum, &candidates}) program->forget();
    for (gl::Buffer* buffer : {&group_sums, &result, &found}) buffer->forget();
  }
}

GpuSurface::GpuSurface(Gpu& gpu, std::span<const Triangle> triangles) : state_(std::make_unique<State>(*gpu.state_)) {
  state_->open(triangles);
}
GpuSurface::~GpuSurface() = default;
GpuSurface::GpuSurface(GpuSurface&&) noexcept = default;
GpuSurface& GpuSurface::operator=(GpuSurface&&) noexcept = default;

double GpuSurface::volume(const GpuPoints& points, const Vec3d& origin) const {
  state_->require(*points.state_);
  if (state_->parts.empty()) return 0;
  const gl::CurrentContext current(state_->gpu.context);
  const gl::Program& program = state_->volume;
  glUseProgram(program.get());
  bind_points(program, *points.state_);
  gl::bind_storage(kResultPlace, state_->group_sums);
  set(program, "origin", origin);
  std::size_t first_group = 0;
  state_->dispatch(program, [&](const Part& part) {
    set(program, "first_group", first_group);
    first_group += part.groups();
  });
  glUseProgram(state_->sum.get());
  set(state_->sum, "count", first_group);
  gl::bind_storage(0, state_->group_sums);
  gl::bind_storage(kResultPlace, state_->result);
  glDispatchCompute(1, 1, 1);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  double volume6 = 0;
  state_->gpu.read(state_->result, 0, sizeof(double), &volume6);
  gl::require_no_error();
  return volume6 / 6;
}

void GpuSurface::State::find_candidates(const GpuPoints::State& of, const Vec3d& origin, const Vec3d& direction) const {
  const std::size_t axis = TriangleRay(origin, direction).axis();
  const double along = direction[axis];
  glUseProgram(candidates.get());
  gl::clear_storage(found);
  bind_points(candidates, of);
  gl::bind_storage(kResultPlace, found);
  set(candidates, "origin", origin);
  set(candidates, "shear", Vec3d{direction[(axis + 1) % 3] / along, direction[(axis + 2) % 3] / along, 1 / along});
  set(candidates, "capacity", capacity);
  glUniform1i(uniform(candidates, "axis"), static_cast<GLint>(axis));
  dispatch(candidates, [&](const Part& part) { set(candidates, "first_triangle", part.begin); });
}

// Returns nothing if there was no room for all, and makes room.
std::vector<Candidate> GpuSurface::State::read_candidates() {
  struct Block {
    std::uint32_t count = 0;
    std::uint32_t unused = 0;
    std::array<Candidate, kReadAtOnce> first{};
  } block;
  static_assert(sizeof(Block) == bytes_of(kReadAtOnce));
  gpu.read(found, 0, sizeof(Block), &block);
  gl::require_no_error();
  if (block.count > capacity) {
    found = gl::make_storage(nullptr, bytes_of(block.count));
    capacity = block.count;
    return {};
  }
  std::vector<Candidate> all(block.first.begin(), block.first.end());
  all.resize(block.count);
  if (block.count > kReadAtOnce) gpu.read(found, kHeaderBytes, all.size() * sizeof(Candidate), all.data());
  gl::require_no_error();
  return all;
}

std::optional<GpuHit> GpuSurface::first_hit(const GpuPoints& points, const Vec3d& origin,
                                            const Vec3d& direction) const {
  state_->require(*points.state_);
  if (state_->parts.empty()) return std::nullopt;
  const gl::CurrentContext current(state_->gpu.context);
  std::vector<Candidate> candidates;
  for (std::size_t room = 0; room != state_->capacity;) {  // again with more room
    room = state_->capacity;
    state_->find_candidates(*points.state_, origin, direction);
    candidates = state_->read_candidates();
  }
  return nearest_of(candidates, TriangleRay(origin, direction));
}

}  // namespace knead::gpu
