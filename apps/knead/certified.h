// Applies a session to a shape, certifies the result, and tries again with a finer mesh if bounds are not met.
#pragma once

#include <optional>
#include <vector>

#include "bounds.h"
#include "knead/certify.h"
#include "work.h"

namespace knead::command {

struct Certified {
  ReplayResult result;
  std::optional<Certificate> certificate;  // if it was asked for, or there are bounds
  ReplayOptions options;                   // of the last attempt
  Session session;                         // of the last attempt
};

// Calls replay_watched(), and certifies the result if `check` or bounds ask for it. If a remeshed result misses a
// bound, tries up to three times more, with chords half as long (volume, crossings, flipped, distance) or twice as many
// rounds (min-angle). Throws QualityError if a bound is still not met. With bounds, delivers frames only after all are
// met. options.remesh.single_precision: the result is written, and so certified, with positions rounded to float.
Certified replay_certified(const Inputs& inputs, const ReplayOptions& options, bool check,
                           const std::vector<Bound>& bounds, bool quiet);

// Returns the certificate as one line of text.
std::string line_of(const Certificate& certificate);

}  // namespace knead::command
