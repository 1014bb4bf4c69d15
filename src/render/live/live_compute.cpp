// LiveCompute: positions and normals of drawn vertices by compute shaders.
#include <algorithm>
#include <string>
#include <vector>

#include "knead/editor/gl.h"
#include "render/live/live.h"

namespace knead::render {
namespace {

constexpr std::uint32_t kGroup = 256;

// One call for each thing, in rows of as many groups as drivers accept.
constexpr const char* kThings = R"(#version 430 core
layout(local_size_x = 256) in;
uint thing() { return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 256u + gl_LocalInvocationID.x; }
)";

constexpr const char* kPlace = R"(
layout(std430, binding = 0) restrict readonly buffer Points { double points[]; };
layout(std430, binding = 1) restrict writeonly buffer Placed { float placed[]; };
uniform uint first;
uniform uint count;
uniform dvec3 center;
uniform double scale;

void main() {
  uint i = thing();
  if (i >= count) return;
  for (uint k = 0u; k < 3u; ++k) placed[3u * (first + i) + k] = float((points[3u * i + k] - center[k]) * scale);
}
)";

// As set_ring_normals (live_normals.cpp).
constexpr const char* kShade = R"(
layout(std430, binding = 0) restrict readonly buffer Placed { float placed[]; };
layout(std430, binding = 1) restrict readonly buffer Source { uint source[]; };
layout(std430, binding = 2) restrict readonly buffer RingBegin { uint ring_begin[]; };
layout(std430, binding = 3) restrict readonly buffer RingList { uint ring_list[]; };
layout(std430, binding = 4) restrict writeonly buffer Drawn { float drawn[]; };
uniform uint count;
uniform bool has_rings;

const uint kNoVertex = 0xffffffffu;

vec3 place_of(uint v) { return vec3(placed[3u * v], placed[3u * v + 1u], placed[3u * v + 2u]); }

vec3 unit_or_zero(vec3 v) { return v * inversesqrt(dot(v, v) + 1e-30); }

// About as long as the angle between the two.
vec3 corner(vec3 a, vec3 b) {
  float c = dot(a, b);
  return cross(a, b) * (1.5708 + c * (-1.0 + c * (0.55 - 0.12 * c)));
}

vec3 normal_at(uint d, vec3 p) {
  vec3 sum = vec3(0.0);
  vec3 before = vec3(0.0);
  for (uint i = ring_begin[d]; i < ring_begin[d + 1u]; ++i) {
    uint v = ring_list[i];
    vec3 edge = v == kNoVertex ? vec3(0.0) : unit_or_zero(place_of(v) - p);
    sum += corner(before, edge);
    before = edge;
  }
  sum = unit_or_zero(sum);
  return dot(sum, sum) > 0.5 ? sum : vec3(0.0, 0.0, 1.0);
}

void main() {
  uint d = thing();
  if (d >= count) return;
  vec3 p = place_of(source[d]);
  vec3 n = has_rings ? normal_at(d, p) : vec3(0.0);
  for (uint k = 0u; k < 3u; ++k) {
    drawn[6u * d + k] = p[k];
    drawn[6u * d + 3u + k] = n[k];
  }
}
)";

gl::Buffer make_storage(std::span<const std::uint32_t> words) {
  return gl::make_storage(words.data(), words.size_bytes());
}

void dispatch(std::uint32_t count) {
  constexpr std::uint32_t row = 32768;
  const std::uint32_t groups = (count + kGroup - 1) / kGroup;
  if (groups > 0) glDispatchCompute(std::min(groups, row), (groups + row - 1) / row, 1);
}

std::vector<std::uint32_t> sources_of(const LiveMesh& mesh) {
  std::vector<std::uint32_t> result(mesh.vertices().size());
  mesh.for_each_drawn({0, static_cast<std::uint32_t>(mesh.vertex_count())},
                      [&](std::uint32_t v, std::uint32_t d) { result[d] = v; });
  return result;
}

}  // namespace

LiveCompute::LiveCompute(const LiveMesh& mesh)
    : drawn_count_(static_cast<std::uint32_t>(mesh.vertices().size())), has_rings_(!mesh.rings().list.empty()) {
  gl::require_version(43);
  while (glGetError() != GL_NO_ERROR) {  // of earlier calls
  }
  place_ = gl::make_compute_program(std::string(kThings) + kPlace);
  shade_ = gl::make_compute_program(std::string(kThings) + kShade);
  placed_ = gl::make_storage(nullptr, mesh.vertex_count() * sizeof(Vec3f));
  source_ = make_storage(sources_of(mesh));
  ring_begin_ = make_storage(mesh.rings().begin);
  ring_list_ = make_storage(mesh.rings().list);
  gl::make_storage(nullptr, drawn_count_ * sizeof(LiveVertex));  // fails if the driver allows no buffer of this size
}

void LiveCompute::move(std::span<const PointBuffer> points, const Placement& placement,
                       const LiveBuffers& drawn) const {
  glUseProgram(place_.get());
  glUniform3d(uniform(place_, "center"), placement.center.x, placement.center.y, placement.center.z);
  glUniform1d(uniform(place_, "scale"), placement.scale);
  gl::bind_storage(1, placed_);
  for (const PointBuffer& part : points) {
    const std::uint32_t count = part.vertices.end - part.vertices.begin;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, part.buffer);
    glUniform1ui(uniform(place_, "first"), part.vertices.begin);
    glUniform1ui(uniform(place_, "count"), count);
    dispatch(count);
  }
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glUseProgram(shade_.get());
  glUniform1ui(uniform(shade_, "count"), drawn_count_);
  glUniform1i(uniform(shade_, "has_rings"), has_rings_ ? GL_TRUE : GL_FALSE);
  gl::bind_storage(0, placed_);
  gl::bind_storage(1, source_);
  gl::bind_storage(2, ring_begin_);
  gl::bind_storage(3, ring_list_);
  gl::bind_storage(4, drawn.vertices);
  dispatch(drawn_count_);
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT | GL_PIXEL_BUFFER_BARRIER_BIT);
}

}  // namespace knead::render
