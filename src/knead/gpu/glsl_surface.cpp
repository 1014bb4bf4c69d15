#include "knead/gpu/glsl_surface.h"

#include <fmt/format.h>

namespace knead::gpu {

namespace {

std::string opening() {
  return fmt::format("#version 430 core\nlayout(local_size_x = 64) in;\nconst uint kRounds = {}u;\n",
                     kTrianglesToAWorkGroup / 64);
}

// The corners of triangle i.
constexpr const char* kCorners = R"(
layout(std430, binding = 0) restrict readonly buffer Points0 { double points0[]; };
layout(std430, binding = 1) restrict readonly buffer Points1 { double points1[]; };
layout(std430, binding = 2) restrict readonly buffer Points2 { double points2[]; };
layout(std430, binding = 3) restrict readonly buffer Points3 { double points3[]; };
layout(std430, binding = 4) restrict readonly buffer Triangles { uint triangles[]; };
uniform uint points_to_a_range;
uniform uint triangle_count;
uniform dvec3 origin;

dvec3 place(uint point) {
  uint range = point / points_to_a_range;
  uint i = 3u * (point - range * points_to_a_range);
  if (range == 0u) return dvec3(points0[i], points0[i + 1u], points0[i + 2u]);
  if (range == 1u) return dvec3(points1[i], points1[i + 1u], points1[i + 2u]);
  if (range == 2u) return dvec3(points2[i], points2[i + 1u], points2[i + 2u]);
  return dvec3(points3[i], points3[i + 1u], points3[i + 2u]);
}

dvec3 corner(uint i, uint k) { return place(triangles[3u * i + k]); }
)";

// Of the threads' sums, in an order that does not depend on when each is ready.
constexpr const char* kSumOfThreads = R"(
layout(std430, binding = 5) restrict writeonly buffer Result { double result[]; };
shared double sums[64];

void write_sum(double own, uint at) {
  uint thread = gl_LocalInvocationID.x;
  sums[thread] = own;
  memoryBarrierShared();
  barrier();
  for (uint width = 32u; width > 0u; width /= 2u) {
    if (thread < width) sums[thread] += sums[thread + width];
    memoryBarrierShared();
    barrier();
  }
  if (thread == 0u) result[at] = sums[0];
}
)";

constexpr const char* kVolume = R"(
uniform uint first_group;

void main() {
  precise double sum = 0.0;
  for (uint round = 0u; round < kRounds; ++round) {
    uint i = (gl_WorkGroupID.x * kRounds + round) * 64u + gl_LocalInvocationID.x;
    if (i >= triangle_count) continue;
    precise dvec3 a = corner(i, 0u) - origin;
    precise dvec3 b = corner(i, 1u) - origin;
    precise dvec3 c = corner(i, 2u) - origin;
    precise dvec3 normal = dvec3(b.y * c.z - b.z * c.y, b.z * c.x - b.x * c.z, b.x * c.y - b.y * c.x);
    sum += a.x * normal.x + a.y * normal.y + a.z * normal.z;
  }
  write_sum(sum, first_group + gl_WorkGroupID.x);
}
)";

constexpr const char* kSum = R"(
layout(std430, binding = 0) restrict readonly buffer Terms { double terms[]; };
uniform uint count;

void main() {
  precise double sum = 0.0;
  for (uint i = gl_LocalInvocationID.x; i < count; i += 64u) sum += terms[i];
  write_sum(sum, 0u);
}
)";

// Those on which no rounding can cast a doubt are left out: 1e-14 is some ten times what rounds in `edge`.
constexpr const char* kCandidates = R"(
struct Candidate {
  double corners[9];
  uint triangle;
  uint unused;
};
layout(std430, binding = 5) restrict buffer Candidates {
  uint count;
  uint unused;
  Candidate candidates[];
};
uniform uint first_triangle;
uniform uint capacity;
uniform int axis;
uniform dvec3 shear;

// A corner in the space where the ray is the z axis, and its size before the shear.
dvec4 sheared(dvec3 x) {
  dvec3 q = x - origin;
  q = axis == 0 ? q.yzx : (axis == 1 ? q.zxy : q);
  return dvec4(q.xy - shear.xy * q.z, shear.z * q.z, abs(q.x) + abs(q.y) + abs(q.z));
}

// Of which side of the ray the edge passes: 1, -1, or 0 for what is not certain.
int side(dvec4 a, dvec4 b) {
  double area = a.x * b.y - a.y * b.x;
  double bound = 1e-14lf * a.w * b.w;
  return area > bound ? 1 : (area < -bound ? -1 : 0);
}

void look_at(uint i) {
  dvec3 x[3] = dvec3[](corner(i, 0u), corner(i, 1u), corner(i, 2u));
  dvec4 a = sheared(x[0]);
  dvec4 b = sheared(x[1]);
  dvec4 c = sheared(x[2]);
  if (a.z < 0.0 && b.z < 0.0 && c.z < 0.0) return;
  int first = side(a, b);
  int second = side(b, c);
  int third = side(c, a);
  if (first * second < 0 || second * third < 0 || third * first < 0) return;
  uint at = atomicAdd(count, 1u);
  if (at >= capacity) return;
  for (int k = 0; k < 3; ++k) {
    candidates[at].corners[3 * k] = x[k].x;
    candidates[at].corners[3 * k + 1] = x[k].y;
    candidates[at].corners[3 * k + 2] = x[k].z;
  }
  candidates[at].triangle = first_triangle + i;
}

void main() {
  for (uint round = 0u; round < kRounds; ++round) {
    uint i = (gl_WorkGroupID.x * kRounds + round) * 64u + gl_LocalInvocationID.x;
    if (i < triangle_count) look_at(i);
  }
}
)";

}  // namespace

std::string volume_source() { return opening() + kCorners + kSumOfThreads + kVolume; }
std::string sum_source() { return opening() + kSumOfThreads + kSum; }
std::string candidates_source() { return opening() + kCorners + kCandidates; }

}  // namespace knead::gpu
