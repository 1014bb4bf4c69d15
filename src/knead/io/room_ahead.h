// Memory for what is still to come in a file.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "knead/math/large_pages.h"

namespace knead::io_detail {

// Lets a vector grow once instead of again and again: as far as the rest of the file would fill it if it went on like
// the part since its first item. Memory that is set aside and not used is never touched.
class RoomAhead {
 public:
  // Makes room for `more` items; `position` is how much of the file's `size` bytes has been read.
  template <class T>
  void make(std::vector<T>& items, std::size_t more, std::size_t position, std::size_t size) {
    if (!begin_) begin_ = position;
    const std::size_t needed = items.size() + more;
    if (needed <= items.capacity()) return;
    constexpr std::size_t least = 4096;  // fewer are no sample
    const double share = static_cast<double>(size - *begin_) / static_cast<double>(std::max(position - *begin_, least));
    const double ahead = items.size() < least ? 0 : 1.02 * static_cast<double>(items.size()) * share;
    reserve_large(items, std::max({needed, 2 * items.capacity(), static_cast<std::size_t>(ahead)}));
  }

 private:
  std::optional<std::size_t> begin_;  // where in the file the first item was
};

}  // namespace knead::io_detail
