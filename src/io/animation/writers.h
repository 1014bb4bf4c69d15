// Functions that the writers of animations share: differences of a frame from the first one, and its normals.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "knead/io.h"
#include "knead/vec.h"

namespace knead::detail {

// Vectors as floats, three numbers each.
inline std::vector<float> as_floats(std::span<const Vec3d> vectors) {
  std::vector<float> floats;
  floats.reserve(3 * vectors.size());
  for (const Vec3d& v : vectors) {
    for (std::size_t axis = 0; axis < 3; ++axis) floats.push_back(static_cast<float>(v[axis]));
  }
  return floats;
}

// The elements that differ, in order, and their new values.
struct Changes {
  std::vector<std::uint32_t> elements;
  std::vector<float> values;  // three for each

  friend bool operator==(const Changes&, const Changes&) = default;
};

inline Changes changes_between(std::span<const float> before, std::span<const float> after) {
  Changes changes;
  for (std::size_t i = 0; i < before.size(); i += 3) {
    if (before[i] == after[i] && before[i + 1] == after[i + 1] && before[i + 2] == after[i + 2]) continue;
    changes.elements.push_back(static_cast<std::uint32_t>(i / 3));
    changes.values.insert(changes.values.end(), {after[i], after[i + 1], after[i + 2]});
  }
  return changes;
}

// Returns the writer of a glTF file. The source must outlive it.
AnimationFile::Writer glb_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options);

// Returns whether the source has a normal of its own for each vertex, and faces.
bool has_vertex_normals(const ShapeFile& source);

// Returns the normals of the source's vertices at these positions: its own ones, turned, else those of the surface.
// Empty for a source without faces.
class FrameNormals {
 public:
  explicit FrameNormals(const ShapeFile& source);

  const std::vector<Vec3d>& first() const { return first_; }
  std::vector<Vec3d> at(std::span<const Vec3d> positions) const;

 private:
  const ShapeFile& source_;
  std::vector<Vec3d> first_;  // before anything moves
};

}  // namespace knead::detail
