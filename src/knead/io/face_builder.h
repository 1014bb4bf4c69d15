// Faces as readers add them: what is no face is left out and counted.
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "knead/math/error.h"
#include "knead/mesh/mesh.h"

namespace knead::io_detail {

inline std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

// Meshes count vertices and corners in 32 bits.
inline constexpr std::size_t kMostElements = std::numeric_limits<std::uint32_t>::max();

class FaceBuilder {
 public:
  explicit FaceBuilder(Mesh& mesh) : mesh_(&mesh) {}

  // Counts faces and adds them to no mesh.
  FaceBuilder() = default;

  // Returns how many vertices the counted faces use.
  std::size_t used_vertices() const { return static_cast<std::size_t>(std::count(used_.begin(), used_.end(), true)); }

  std::size_t faces() const { return faces_; }
  std::size_t corners() const { return corners_; }

  // Adds a face and returns true; one of fewer than three corners is dropped. The caller has checked the range.
  bool add(std::span<const std::uint32_t> vertices) { return add_equal(vertices, vertices.size(), 1); }

  // The same for `count` faces that have as many corners each, one after the other.
  bool add_equal(std::span<const std::uint32_t> vertices, std::size_t corners, std::size_t count) {
    if (corners < 3) {
      dropped_ += count;
      return false;
    }
    corners_ += vertices.size();
    faces_ += count;
    if (corners_ > kMostElements) throw InvalidInput("more than 4294967295 corners; split the shape");
    for (std::size_t i = 0; i < count; ++i) {
      if (has_repeated(vertices.subspan(i * corners, corners))) ++repeated_;
    }
    if (mesh_ == nullptr) {
      note_used(vertices);
      return true;
    }
    mesh_->corner_vertex.insert(mesh_->corner_vertex.end(), vertices.begin(), vertices.end());
    for (std::size_t i = 0; i < count; ++i) {
      mesh_->face_begin.push_back(mesh_->face_begin.back() + static_cast<std::uint32_t>(corners));
    }
    return true;
  }

  void append_notes(std::vector<std::string>& notes) const {
    if (dropped_ > 0) {
      notes.push_back(counted(dropped_, "face has fewer than three vertices and is left out",
                              "faces have fewer than three vertices and are left out"));
    }
    if (repeated_ > 0) {
      notes.push_back(counted(repeated_, "face repeats a vertex", "faces repeat a vertex"));
    }
  }

 private:
  void note_used(std::span<const std::uint32_t> vertices) {
    if (vertices.empty()) return;
    const std::size_t most = *std::max_element(vertices.begin(), vertices.end());
    if (most >= used_.size()) used_.resize(std::max(most + 1, 2 * used_.size()));
    for (const std::uint32_t v : vertices) used_[v] = true;
  }

  bool has_repeated(std::span<const std::uint32_t> v) {
    if (v.size() == 3) return v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
    sorted_.assign(v.begin(), v.end());
    std::sort(sorted_.begin(), sorted_.end());
    return std::adjacent_find(sorted_.begin(), sorted_.end()) != sorted_.end();
  }

  Mesh* mesh_ = nullptr;
  std::size_t faces_ = 0;
  std::size_t corners_ = 0;
  std::vector<std::uint32_t> sorted_;
  std::vector<bool> used_;  // of the vertices, while faces are only counted
  std::size_t dropped_ = 0;
  std::size_t repeated_ = 0;
};

}  // namespace knead::io_detail
