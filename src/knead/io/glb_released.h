// What of a GLB file nothing names any more once some of its primitives have other numbers. Internal to the GLB writer.
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "knead/io/glb_accessor.h"

namespace knead::glb {

struct Released {
  std::vector<std::size_t> accessors;
  std::vector<std::size_t> views;  // of the buffer, that only these accessors name
};

// What only the attributes and indices of these primitives (mesh, number) name. Nothing where the file uses an
// extension that may name accessors or views in a way not known here.
Released released_by(const Document& document, const std::set<std::pair<std::size_t, std::size_t>>& primitives);

// Bytes [begin, end) of the binary chunk that only these views hold, in multiples of four, in order.
std::vector<Span> bytes_of_views_alone(const Document& document, const std::vector<std::size_t>& views);

}  // namespace knead::glb
