// Shaders for the volume of a surface and the triangles that a ray may meet; and sums over trees of points in GLSL.
#include <fmt/format.h>

#include "gpu/glsl.h"

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

// Adds the threads' sums, in an order that does not depend on their timing.
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

// Omits triangles that the ray misses beyond doubt: 1e-14 is about ten times the rounding of `area`.
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

// On which side of the ray the edge passes: 1, -1, or 0 if that is not certain.
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

// Sums over the points of a set by its tree of clusters (flow/sets.h), with the error bound of the CPU's lists. The
// tree is walked for each place, because lists would have to be made before it is known which cells points reach. A
// set's entries in table[], from `set` + 5 on: its nodes in table[], their numbers in n[], and the number of nodes (0:
// no tree). Nodes are in preorder. The number before theirs is the allowed error of the sum divided by the number of
// points: the part of each point of a cluster.
const char* const kGlslTrees = R"(
#ifdef WITH_TREES

int node_entries(int set, int node) { return table[set + 5] + kNodeEntries * node; }
int node_numbers(int set, int node) { return table[set + 6] + kNodeNumbers * node; }

// The begin and end of the points of the leaf to which the nearer children lead.
ivec2 near_leaf(int set, R3 d) {
  int node = 0;
  int right = table[node_entries(set, node) + 3];
  while (right != 0) {
    R to_left = squared_distance(d, node_numbers(set, node + 1));
    R to_right = squared_distance(d, node_numbers(set, right));
    node = to_left <= to_right ? node + 1 : right;
    right = table[node_entries(set, node) + 3];
  }
  int entries = node_entries(set, node);
  return table[set] + ivec2(table[entries + 1], table[entries + 2]);
}

R tree_nearest_squared(int set, R3 d) {
  ivec2 leaf = near_leaf(set, d);
  R least = nearest_point_squared(leaf.x, leaf.y, d);
  int count = table[set + 7];
  for (int node = 0; node < count;) {
    int entries = node_entries(set, node);
    int numbers = node_numbers(set, node);
    R away = max(sqrt(squared_distance(d, numbers)) - n[numbers + 3], R(0));
    bool is_leaf = table[entries + 3] == 0;
    bool is_near = away * away < least;
    if (is_near && is_leaf) {
      int first = table[set];
      least = min(least, nearest_point_squared(first + table[entries + 1], first + table[entries + 2], d));
    }
    node = is_near && !is_leaf ? node + 1 : table[entries];
  }
  return least;
}

// As sum_over_points, with an error of at most the allowed part of least_sum, a lower bound of the sum. A cluster is
// left out where its greatest terms are small enough, and taken as its centroid where Taylor's remainder is.
R4 sum_over_tree(int set, R3 d, R inverse, R least_sum) {
  int half_exponent = table[set + 2] / 2;
  R allowed = n[table[set + 6] - 1] * least_sum;
  R4 sum = R4(0);
  int count = table[set + 7];
  for (int node = 0; node < count;) {
    int entries = node_entries(set, node);
    int numbers = node_numbers(set, node);
    R3 from = (d - part(numbers)) * inverse;
    R square = dot(from, from);
    R nearest = sqrt(square) - n[numbers + 3] * inverse;
    R2 ratios = R2(1) / R2(square, nearest * nearest);
    R2 terms = integer_powers(R4(ratios, R2(0)), half_exponent).xy;
    R remainder = terms.y * ratios.y * (n[numbers + 4] * inverse * inverse);
    bool is_far = nearest > R(0) && min(terms.y, remainder) <= allowed;
    if (is_far && terms.y > allowed) {
      R term = terms.x * R((table[entries + 2] - table[entries + 1]) / 3);
      sum += R4(term, from * (term * ratios.x));
    }
    bool is_leaf = table[entries + 3] == 0;
    if (is_leaf && !is_far) {
      int first = table[set];
      sum += sum_over_points(first + table[entries + 1], first + table[entries + 2], d, inverse, half_exponent);
    }
    node = is_leaf || is_far ? table[entries] : node + 1;
  }
  return sum;
}

// r and its gradient; not where the powers are out of range, d being much nearer to a point than to those of its leaf.
bool is_known_by_tree(int set, R3 d, out Region found) {
  ivec2 leaf = near_leaf(set, d);
  R scale = sqrt(nearest_point_squared(leaf.x, leaf.y, d));
  found = Region(R(0), R3(0));
  if (!(scale > R(0))) return true;
  int exponent = table[set + 2];
  R least_sum = sum_over_points(leaf.x, leaf.y, d, R(1) / scale, exponent / 2).x;
  R4 sum = sum_over_tree(set, d, R(1) / scale, least_sum);
  if (!(sum.x > R(1e-20) && sum.x < R(1e20))) return false;
  R root = inverse_root(sum.x, exponent);
  found = Region(scale * root, sum.yzw * (root / sum.x));
  return true;
}
#endif
)";

}  // namespace knead::gpu
