// A session applied to a shape, its result certified, and done again with a finer mesh where bounds are not met.
#pragma once

#include <optional>
#include <vector>

#include "bounds.h"
#include "knead/session/report.h"
#include "work.h"

namespace knead::command {

struct Certified {
  ReplayResult result;
  std::optional<Certificate> certificate;  // where it was asked for, or there are bounds
  ReplayOptions options;                   // the last, and so those of the result; its session likewise
  Session session;
};

// replay_watched(), certified where `check` or bounds ask for it. Where bounds are not met and the session is remeshed,
// up to three times with chords half as long (volume, crossings, flipped, distance) or twice as many rounds
// (min-angle). Throws QualityError where they are not met then. With bounds, frames are delivered only once they are
// met. options.remesh.single_precision says that the result is written, and so certified, with positions rounded to float.
Certified replay_certified(const Inputs& inputs, const ReplayOptions& options, bool check,
                           const std::vector<Bound>& bounds, bool quiet);

// The certificate as a line for people.
std::string line_of(const Certificate& certificate);

}  // namespace knead::command
