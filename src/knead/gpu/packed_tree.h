// A set's tree of clusters as the numbers that the shaders read. Internal to the gpu room.
#pragma once

#include <cstdint>
#include <vector>

#include "knead/flow/advect.h"

namespace knead::gpu {

// Whether pack_tree may be asked: of many points alone that move with a swept translation, as set_cells.h has it.
bool may_have_tree(const Field& field, const Segment& segment);

struct PackedTree {
  std::int32_t nodes = 0;             // 0: to add up all points takes no longer
  std::vector<Vec3d> points;          // in the tree's order
  double error_of_one = 0;            // what one point may take of the sum's relative error
  std::vector<double> numbers;        // kNodeNumbers a node
  std::vector<std::int32_t> entries;  // kNodeEntries a node; points by where they are beyond the set's first in n[]
};

// Of the field's set.
PackedTree pack_tree(const Field& field, const Segment& segment, const AdvectOptions& options);

}  // namespace knead::gpu
