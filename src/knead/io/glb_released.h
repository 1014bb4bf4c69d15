// What of a GLB file nothing names any more once some of its primitives have other numbers. Internal to the GLB writer.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knead/io/glb_accessor.h"

namespace knead::io_detail::glb {

struct Released {
  std::vector<std::size_t> accessors;
  std::vector<std::size_t> views;  // of the buffer, that only these accessors name
};

// What only the attributes and indices of these primitives (mesh, number) name. Nothing where the file uses an
// extension that may name accessors or views in a way not known here.
Released released_by(const Document& document, const std::set<std::pair<std::size_t, std::size_t>>& primitives);

// Bytes of the binary chunk that are left out.
class Cuts {
 public:
  Cuts() = default;

  // Those that only views for which `is_replaced` says so hold, in multiples of four; none where some view is
  // malformed.
  Cuts(const Document& document, const std::vector<bool>& is_replaced);

  bool empty() const { return spans_.empty(); }

  // Where a byte that stays comes to be.
  std::size_t moved(std::size_t position) const;

  // The bytes that stay.
  std::string applied(std::string_view bytes) const;

 private:
  void subtract(Span range, const std::vector<Span>& kept);
  void add(Span span);

  std::vector<Span> spans_;           // in order
  std::vector<std::size_t> through_;  // how many bytes are left out up to the end of each
};

}  // namespace knead::io_detail::glb
