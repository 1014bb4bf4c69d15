// The real meshes that some tests use. They are no part of the project; tests that need them skip where they are
// absent.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace knead {

// The path of one of them, e.g. test_mesh("bunny_35k.ply") or test_mesh("bad/garbage.ply").
inline std::filesystem::path test_mesh(const std::string& name) {
  return std::filesystem::path(KNEAD_TEST_MESHES) / name;
}

inline bool has_test_mesh(const std::string& name) { return std::filesystem::exists(test_mesh(name)); }

inline std::string file_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace knead

// At the beginning of a test.
#define KNEAD_NEEDS_TEST_MESH(name) \
  if (!::knead::has_test_mesh(name)) GTEST_SKIP() << ::knead::test_mesh(name) << " is absent"
