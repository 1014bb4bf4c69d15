// What a shape is asked to be: knead check --require LIST.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "knead/mesh/measures.h"
#include "knead/mesh/self_intersections.h"

namespace knead::command {

// What `knead check` finds beyond `knead info`.
struct Findings {
  Measures measures;
  SelfIntersections self_intersections;
  std::size_t folded_edges = 0;
  std::optional<std::size_t> flipped_triangles;  // since the shape of --before
};

// One word of the list, known to be one.
struct Requirement {
  std::string word;
  double bound = 0;  // of min-angle
};

// The words there are, with commas between them.
std::string known_requirements();

// Words with commas between them, e.g. "closed,min-angle=5". Throws UsageError for others, and for no-flipped where
// there is nothing to compare with.
std::vector<Requirement> parse_requirements(const std::string& list, bool has_before);

// What is wrong; what to do. Nothing where the requirement is met.
std::optional<std::string> unmet(const Requirement& requirement, const Findings& findings);

}  // namespace knead::command
