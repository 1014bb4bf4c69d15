// Strokes that go on where others ended: a stroke while it is being made, and what of it was made in pieces.
#pragma once

#include <optional>

#include "knead/tool/stroke.h"

namespace knead {

// What `now` has beyond `before` where it is the same stroke gone on with: an implicit stroke's longer path, more
// samples of a painted one. before and then the rest give the same segments as now, to the bit. Nothing where it is
// another stroke, or the same.
std::optional<Stroke> rest_of(const Stroke& before, const Stroke& now);

// The same for the flows: also of point sets with more displacements. The strokes are valid and read no surface.
std::optional<Flow> rest_of_flow(const Stroke& before, const Stroke& now);

// Whether `next` begins where `last` ended, by the same tool with the same numbers: an implicit stroke or a stamp whose
// path goes on, a painted stroke of the same brush. Painted strokes do not tell whether the hand was lifted between
// them.
bool continues(const Stroke& last, const Stroke& next);

// One stroke that does what the two do after each other, to the bit; nothing where there is none (of stamps, whose
// contacts are chosen for a whole stroke).
std::optional<Stroke> joined(const Stroke& last, const Stroke& next);

}  // namespace knead
