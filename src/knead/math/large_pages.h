// Memory for whole files.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace knead {

// Asks the system for large pages where memory was set aside and is about to be filled for the first time. Without them
// most of the time of reading a large file goes into faulting in pages of 4 KB. A hint: nothing happens where the
// system has no large pages or the memory is small.
void prefer_large_pages(void* begin, std::size_t bytes) noexcept;

template <class T>
void reserve_large(std::vector<T>& items, std::size_t count) {
  if (count <= items.capacity()) return;
  items.reserve(count);
  prefer_large_pages(items.data(), items.capacity() * sizeof(T));
}

inline void reserve_large(std::string& bytes, std::size_t count) {
  if (count <= bytes.capacity()) return;
  bytes.reserve(count);
  prefer_large_pages(bytes.data(), bytes.capacity());
}

}  // namespace knead
