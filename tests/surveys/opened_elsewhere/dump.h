// What a program read, as numbers in a file; dump.py reads it.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <vector>

// `uv`, `color` and `normal` have one entry for each corner, or for each vertex if there are no faces; or none.
struct Dump {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::int32_t> sizes;    // corners of each face
  std::vector<std::int32_t> corners;  // vertices of all faces
  std::vector<std::array<double, 2>> uv;
  std::vector<std::array<double, 4>> color;
  std::vector<std::array<double, 3>> normal;
};

template <typename T>
bool put(std::FILE* file, const std::vector<T>& values) {
  return std::fwrite(values.data(), sizeof(T), values.size(), file) == values.size();
}

// Native byte order: six counts of 64 bits, then the six lists.
inline bool write_dump(const char* path, const Dump& dump) {
  std::FILE* file = std::fopen(path, "wb");
  if (file == nullptr) return false;
  const std::vector<std::uint64_t> counts{dump.positions.size(), dump.sizes.size(), dump.corners.size(),
                                          dump.uv.size(),        dump.color.size(), dump.normal.size()};
  const bool whole = put(file, counts) && put(file, dump.positions) && put(file, dump.sizes) &&
                     put(file, dump.corners) && put(file, dump.uv) && put(file, dump.color) && put(file, dump.normal);
  return (std::fclose(file) == 0) && whole;
}
