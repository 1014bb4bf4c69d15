// What a deformation's certificate is asked to hold: knead deform --require LIST.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "knead/session/report.h"

namespace knead::command {

// One item of the list, such as volume=1e-5; its name is known.
struct Bound {
  std::string name;
  double limit = 0;
};

// The names there are, with commas between them and what stands behind each.
std::string known_bounds();

// Items with commas between them. Throws UsageError for other names, and for limits that are no number or out of range.
std::vector<Bound> parse_bounds(const std::string& list);

// What remeshing can do about a bound that is not met.
enum class Cure { none, shorter_chords, more_rounds };

struct Unmet {
  std::string text;  // what is wrong: "the volume changed by 0.0012 of itself, more than 1e-05"
  Cure cure = Cure::none;
};

// Nothing where the bound is met.
std::optional<Unmet> unmet(const Bound& bound, const Certificate& certificate);

}  // namespace knead::command
