// How much each vertex is masked, and the strokes that say so.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "gestures/screen.h"
#include "knead/workbench.h"

namespace knead::studio {

// For each vertex, from 0: free to 255: stays; empty: no vertex is masked.
using MaskValues = std::vector<std::uint8_t>;

// Returns the values of the mask that is in force after these entries, for the vertices of the state. After remeshing,
// new vertices are masked where the mask holds them.
MaskValues mask_values(std::span<const std::shared_ptr<const HistoryEntry>> history, const ShapeState& state);

// Returns the stroke that masks the vertices of the state so, with a border of this width. It names vertices, or points
// where remeshing has changed the vertices' numbers.
MaskStroke mask_stroke(const MaskValues& values, const ShapeState& state, double width);

// What changes a whole mask: blur takes means over neighbours, grow the greatest and shrink the smallest value.
enum class MaskEdit { fill, clear, invert, blur, grow, shrink };

// Returns the edit with a name in lower case, or nothing.
std::optional<MaskEdit> mask_edit(std::string_view word);

MaskValues changed(MaskValues values, MaskEdit edit, const Mesh& mesh);

// A brush: full within `inner` of the center, down to nothing at `outer`.
struct MaskBrush {
  Vec3d center;
  double inner = 0;
  double outer = 0;
  bool erases = false;
};
void paint(const MaskBrush& brush, const Snapshot& positions, MaskValues& values);

// Masks or frees every vertex that is seen within a closed line, also behind others.
void fill(std::span<const Pixel> line, const Screen& screen, bool erases, const Snapshot& positions,
          MaskValues& values);

}  // namespace knead::studio
