// `knead bench`: strokes of Knead, compared with the brushes that people would use instead.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/stroke.h"

namespace knead::command {

struct PeerScene {
  std::string name;  // of the shape and the stroke
  Mesh mesh;
  ImplicitStroke stroke;
};

// Returns three scenes on a shape: a pull by the brush's radius with as many samples as a slow pointer gives; the same
// with one sample, as grab brushes are applied; a push by three radii into the shape in four pieces. Returns none for a
// shape that is not closed.
std::vector<PeerScene> peer_scenes(const std::string& name, const Mesh& mesh);

// Returns the same for the paper's armadillo in the folder, or for a procedural shape of its size.
std::vector<PeerScene> standard_peer_scenes(const std::string& folder);

// The result of one method in a scene, on one thread.
struct PeerRow {
  std::string method;
  std::string scene;
  double seconds = 0;  // median
  double volume_error = 0;
  std::size_t self_intersections_before = 0;  // counted up to a million
  std::size_t self_intersections_after = 0;
  double motion_beyond_outer = 0;  // the greatest of the vertices that are at least `outer` from the path; of the
                                   // box diagonal
};

std::vector<PeerRow> measure_peers(const PeerScene& scene);

Json json_of(const PeerRow& row);
std::string peers_heading();
std::string text_of(const PeerRow& row);

}  // namespace knead::command
