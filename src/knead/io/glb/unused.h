// The parts of a GLB file that become unused when some of its primitives get other numbers, and the removal of their
// bytes.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knead/io/glb/accessor.h"

namespace knead::io_detail::glb {

struct Unused {
  std::vector<std::size_t> accessors;
  std::vector<std::size_t> views;  // buffer views that only these accessors name
};

// Returns the accessors and views that only the attributes and indices of these primitives (mesh, number) use. Returns
// nothing if the file has an unknown extension, which may name accessors or views in an unknown way.
Unused unused_after(const Document& document, const std::set<std::pair<std::size_t, std::size_t>>& primitives);

// The bytes of the binary chunk that are removed.
class Cuts {
 public:
  Cuts() = default;

  // Removes the bytes that only views with is_replaced[view] cover, in multiples of four; none if a view is malformed.
  Cuts(const Document& document, const std::vector<bool>& is_replaced);

  bool empty() const { return spans_.empty(); }

  // Returns the new position of a byte that stays.
  std::size_t moved(std::size_t position) const;

  // Returns the bytes that stay.
  std::string applied(std::string_view bytes) const;

 private:
  void subtract(Span range, const std::vector<Span>& kept);
  void add(Span span);

  std::vector<Span> spans_;           // in order
  std::vector<std::size_t> through_;  // how many bytes are removed up to the end of each
};

}  // namespace knead::io_detail::glb
