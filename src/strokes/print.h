// The pattern of the tool "print" (docs/decisions/0045-prints.md). Internal to the library.
#pragma once

#include <vector>

#include "knead/mesh.h"
#include "knead/stroke.h"

namespace knead {

// A grey picture that lies in a plane, such as a letter of a text.
struct GreyTile {
  int width = 0;  // pixels
  int height = 0;
  std::vector<float> values;  // from 0 to 1, rows from the top
  double left = 0;            // position of the left edge, to the right of the pattern's middle; in pixels
  double top = 0;             // position of the upper edge, above the middle
};

// Tiles side by side, of one scale.
struct GreyPattern {
  std::vector<GreyTile> tiles;
  double height = 1;  // the print's height, in pixels
};

namespace detail {

// Returns the pattern of a mesh: its lowest face, as seen from above. Points that lie less than the depth above it are
// grey. Throws InvalidInput for a mesh without faces.
GreyPattern face_of(const Mesh& mesh, const PrintStroke& stroke);

// Returns the mean of a tile's pixels in a rectangle, in pixels from its upper left corner; what is beyond counts as 0.
double mean_in(const GreyTile& tile, double x0, double y0, double x1, double y1);

}  // namespace detail

}  // namespace knead
