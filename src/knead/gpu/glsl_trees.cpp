#include "knead/gpu/glsl.h"

namespace knead::gpu {

// Sums over the points of a set by its tree of clusters (flow/point_tree.h), with the same bound on the error as the
// CPU's lists have, but for each place anew: a list for each cell of space would have to be made before it is known
// which cells points come to. A set's entries in table[], from `set` + 5 on: where its nodes begin in table[], where in
// n[], how many there are (0: no tree). Nodes are in preorder. Before their numbers stands the error of the sum that is
// allowed, by the number of points: each cluster may have its points' part of it.
const char* const kGlslTrees = R"(
#ifdef WITH_TREES

int node_entries(int set, int node) { return table[set + 5] + kNodeEntries * node; }
int node_numbers(int set, int node) { return table[set + 6] + kNodeNumbers * node; }

// Where the points of the leaf begin and end to which the nearer child always leads.
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

// As sum_over_points, with an error of at most the allowed part of least_sum, which the sum is not below. A cluster is
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
