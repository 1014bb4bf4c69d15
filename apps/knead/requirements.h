// Requirements on a shape: knead check --require LIST.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "knead/mesh/measures.h"
#include "knead/mesh/self_intersections.h"

namespace knead::command {

// What `knead check` finds.
struct Findings {
  Measures measures;
  SelfIntersections self_intersections;
  std::size_t folded_edges = 0;
  std::optional<std::size_t> flipped_triangles;  // since the shape of --before
};

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
std::optional<std::string> unmet(const Requirement& requirement, const Findings& findings);

}  // namespace knead::command
