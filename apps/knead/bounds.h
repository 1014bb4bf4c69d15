// Bounds on the certificate of a deformation: knead deform --require LIST.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "knead/certify.h"

namespace knead::command {

// One item of the list, such as volume=1e-5; its name is known.
struct Bound {
  std::string name;
  double limit = 0;
};

// The name of the bound on pairs of triangles that cross: who gives it wants no other refusal of them.
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

}  // namespace knead::command
