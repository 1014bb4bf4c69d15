// The edges of a mesh and how its faces hang together around them.
#pragma once

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead {

// One traversal of an edge by a face: from corner `corner` to the next corner of its face.
struct EdgeUse {
  std::uint32_t low = 0;   // the edge's smaller vertex
  std::uint32_t high = 0;  // and its larger
  std::uint32_t corner = 0;
  std::uint32_t next_corner = 0;
  bool upward = false;  // traversed from low to high
};

// Every traversal of every edge, sorted by edge and then by corner: the uses of an edge follow each other. A corner
// whose successor is the same vertex has no edge. Time: linear, and a sort of the few uses at each vertex.
std::vector<EdgeUse> edge_uses(const Mesh& mesh);

// Whether there are faces, every edge is traversed more than once, and as often one way as the other but for one
// traversal: closed() and oriented() of measure(mesh), sooner.
bool is_closed_and_oriented(const Mesh& mesh);

// Calls visit(uses) once per edge, with all of its uses.
template <class Visit>
void for_each_edge(std::span<const EdgeUse> uses, Visit visit) {
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin + 1;
    while (end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high) ++end;
    visit(uses.subspan(begin, end - begin));
    begin = end;
  }
}

// Disjoint sets of the numbers below a count (union by smaller number, path halving).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }

  // The smallest number in i's set.
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a < b) parent_[b] = a;
    if (b < a) parent_[a] = b;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace knead
