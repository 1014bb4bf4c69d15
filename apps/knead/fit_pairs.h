// The landmarks of `knead fit`: a CSV file of pairs.
#pragma once

#include <string>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead::command {

struct LandmarkPairs {
  std::vector<Vec3d> source;
  std::vector<Vec3d> target;
};

// Reads pairs of places (source_x,source_y,source_z,target_x,target_y,target_z) or of vertices from 0 on
// (source_vertex,target_vertex), whichever the first line names. Throws IoError(read), and InvalidInput with the line.
LandmarkPairs read_pairs(const std::string& path, const Mesh& source, const Mesh& target);

}  // namespace knead::command
