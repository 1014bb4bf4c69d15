// The landmarks of `knead fit`: a table of pairs, or one file of points for each shape.
#pragma once

#include <string>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead::command {

struct LandmarkPairs {
  std::vector<Vec3d> source;
  std::vector<Vec3d> target;
  std::vector<double> tolerance;  // as many lengths, 0: exact
  std::vector<std::string> notes;
};

// Reads pairs of places (source_x,source_y,source_z,target_x,target_y,target_z) or of vertices from 0 on
// (source_vertex,target_vertex), as the first line names them, or by the number of columns; a column `tolerance` may
// follow. Fields lie between commas,
// semicolons or tabs, also in quotes; decimal commas are read where semicolons or tabs separate. A pair that is given
// twice counts once. Throws IoError(read), and InvalidInput with the line.
LandmarkPairs read_pairs(const std::string& path, const Mesh& source, const Mesh& target);

// Reads the landmarks of one shape from each file: .fcsv or .mrk.json of 3D Slicer, or a table x,y,z with or without
// `label`. Points belong together by their labels if both files have the same ones, otherwise by their order. Where one
// file is in RAS and the other in LPS, x and y of the one in RAS change their signs; a note says so. Throws as above.
LandmarkPairs read_points(const std::string& source, const std::string& target);

// Throws InvalidInput where the places of the target lie far from those of the source, or are their mirror images in
// axes, as between RAS and LPS. `diagonal`: of the source.
void check_frames(const LandmarkPairs& pairs, const std::string& path, double diagonal);

}  // namespace knead::command
