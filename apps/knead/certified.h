// Applies a session to a shape, certifies the result, and tries again with a finer mesh if it misses a bound. Reads the
// bounds of --require.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "inputs.h"
#include "knead/certify.h"

namespace knead::command {

// --- bounds on the certificate of a deformation: knead deform --require LIST

// One item of the list, such as volume=1e-5; its name is known.
struct Bound {
  std::string name;
  double limit = 0;
};

// The name of the bound on pairs of triangles that cross. Given, it replaces all other refusals of crossings.
inline constexpr const char* kCrossingsBound = "crossings";

// Returns all names, each with the placeholder of its limit, separated by commas.
std::string known_bounds();

// Parses items separated by commas. Throws UsageError for an unknown name, and for a limit that is not a number or is
// out of range.
std::vector<Bound> parse_bounds(const std::string& list);

// How remeshing can help to meet a bound.
enum class Cure { none, shorter_chords, more_rounds };

struct Unmet {
  std::string text;  // what is wrong: "the volume changed by a fraction of 0.0012, more than 1e-05"
  Cure cure = Cure::none;
};

// Returns what is wrong; nothing if the bound is met.
std::optional<Unmet> unmet(const Bound& bound, const Certificate& certificate);

// --- sessions applied and certified

struct Certified {
  ReplayResult result;
  std::optional<Certificate> certificate;  // if it was asked for, or there are bounds
  ReplayOptions options;                   // of the last attempt
  Session session;                         // of the last attempt
};

// Calls replay_watched(), and certifies the result if `check` or bounds ask for it. If a remeshed result misses a
// bound, tries up to three times more, with chords half as long (volume, crossings, flipped, distance) or twice as many
// rounds (min-angle). Throws QualityError if a bound is still not met. With bounds, delivers frames only after all are
// met. Without a bound on distances of its own, and with options.must_follow, a remeshed result is bounded to 1e-3 of
// the size from the exact image. options.remesh.single_precision: the result is written, and so certified, with
// positions rounded to float. `max_points`: as CertificateBuilder.
Certified replay_certified(const Inputs& inputs, const ReplayOptions& options, bool check,
                           const std::vector<Bound>& asked, bool quiet,
                           std::size_t max_points = std::numeric_limits<std::size_t>::max());

// Returns the certificate as one line of text.
std::string line_of(const Certificate& certificate);

// --- requirements on a shape: knead check --require LIST

// One item of the list; its word is a known one.
struct Requirement {
  std::string word;
  double bound = 0;  // the number, if it has one
};

// Returns all words, separated by commas.
std::string known_requirements();

// Parses words separated by commas, e.g. "closed,min-angle=5". Throws UsageError for an unknown word, and for
// no-flipped if has_before is false.
std::vector<Requirement> parse_requirements(const std::string& list, bool has_before);

// Returns what is wrong and what to do; nothing if the requirement is met.
std::optional<std::string> unmet(const Requirement& requirement, const SurfaceCheck& check);

}  // namespace knead::command
