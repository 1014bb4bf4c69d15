// A grey picture that lies in a plane, such as a letter of a text.
#pragma once

#include <vector>

namespace knead {

struct GreyTile {
  int width = 0;  // pixels
  int height = 0;
  std::vector<float> values;  // from 0 to 1, rows from the top
  double left = 0;            // of the left edge, to the right of the pattern's middle; in pixels
  double top = 0;             // of the upper edge, above the middle
};

// Tiles side by side, of one scale.
struct GreyPattern {
  std::vector<GreyTile> tiles;
  double height = 1;  // in pixels, of what the print's height says
};

}  // namespace knead
