// Requirements on a shape: knead check --require LIST.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "knead/certify.h"

namespace knead::command {

// One item of the list; its word is a known one.
struct Requirement {
  std::string word;
  double bound = 0;  // of min-angle
};

// Returns all words, separated by commas.
std::string known_requirements();

// Parses words separated by commas, e.g. "closed,min-angle=5". Throws UsageError for an unknown word, and for
// no-flipped if has_before is false.
std::vector<Requirement> parse_requirements(const std::string& list, bool has_before);

// Returns what is wrong and what to do; nothing if the requirement is met.
std::optional<std::string> unmet(const Requirement& requirement, const SurfaceCheck& check);

}  // namespace knead::command
