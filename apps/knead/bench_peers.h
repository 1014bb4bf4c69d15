// `knead bench`: strokes made by us, and by the brushes that people would use instead.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "knead/io/json.h"
#include "knead/mesh/mesh.h"
#include "knead/tool/stroke.h"

namespace knead::command {

struct PeerScene {
  std::string name;  // of the shape and the stroke
  Mesh mesh;
  ImplicitStroke stroke;
};

// On a shape: a pull by the brush's radius, with as many samples as a pointer gives that is moved slowly, and with one,
// as brushes that grab are applied; and a push by three radii into the shape in four pieces. None for a shape that is
// not closed.
std::vector<PeerScene> peer_scenes(const std::string& name, const Mesh& mesh);

// The same of the paper's armadillo in the folder, or of a procedural shape of its size.
std::vector<PeerScene> standard_peer_scenes(const std::string& folder);

// What one method made of a scene. One thread.
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
