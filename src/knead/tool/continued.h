// Strokes that continue others: the new part of a growing stroke, and the pieces of one stroke joined.
#pragma once

#include <optional>

#include "knead/tool/stroke.h"

namespace knead {

// Returns the part of `now` that `before` lacks, if `now` extends `before`: the rest of an implicit stroke's path,
// the new samples of a painted stroke, or the new points of a relax stroke. `before` followed by this part gives the
// same segments as `now`, to the bit. Returns nothing if the strokes are equal, or `now` does not extend `before`.
std::optional<Stroke> rest_of(const Stroke& before, const Stroke& now);

// Returns the flow of that part; works also for point sets with more displacements. The strokes are valid. Nothing for
// relax strokes, which are no flow. Both are mirrored.
std::optional<Flow> rest_of_flow(const Stroke& before, const Stroke& now, const Mirror& mirror = {});

// Returns whether `next` begins where `last` ended, with the same tool and the same numbers: an implicit stroke or a
// stamp whose path continues, a painted stroke of the same brush, or a relax
// stroke that goes on nearby. Painted strokes do not show whether the pointer
// was released between them.
bool continues(const Stroke& last, const Stroke& next);

// Returns one stroke that gives the result of the two, one after the other, to the bit. Returns nothing if there is
// none, as for stamps, whose contacts are chosen for a whole stroke.
std::optional<Stroke> joined(const Stroke& last, const Stroke& next);

}  // namespace knead
