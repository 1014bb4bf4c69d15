// What readers and writers of meshes share: colors of every number type, attributes of corners as those of vertices,
// faces and vertices as they come, values and vertices that are not finite, and normals that follow a moved shape.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/system.h"

namespace knead::detail {

// Returns the factor that scales a value of a color to the range from 0 to 1.
inline double unit_scale(NumberType type) {
  if (type == NumberType::uint8) return 1.0 / 255;
  return type == NumberType::uint16 ? 1.0 / 65535 : 1.0;
}

// A value of a color as a whole number from 0 to 255.
inline double as_byte(double value, NumberType type) {
  return type == NumberType::uint8 ? value : std::round(std::clamp(value * unit_scale(type), 0.0, 1.0) * 255);
}

// Returns whether all colors are bytes, shorts, or reals from 0 to 1.
bool has_unit_colors(const Mesh& mesh);

// Converts colors to such values, by their color_scale().
Mesh with_unit_colors(Mesh mesh);

// Attributes of corners and of vertices, one as the other.

// Returns an attribute of corners as one of vertices, if all corners at each vertex have the same values; vertices in
// no face have 0.
std::optional<Attribute> merge_corners(const Mesh& mesh, const Attribute& attribute);

// Returns the first attribute of that name and number of components: of vertices, or of corners if it can become one of
// vertices.
std::optional<Attribute> vertex_attribute(const Mesh& mesh, const std::string& name, int components);

// The faces that a reader adds; faces of fewer than three corners are left out and counted.

inline std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

// Meshes count vertices and corners in 32 bits.
inline constexpr std::size_t kMaxElements = std::numeric_limits<std::uint32_t>::max();

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
    if (corners_ > kMaxElements) throw InvalidInput("more than 4294967295 corners; split the shape");
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

// Corners of triangles become vertices: equal positions are one.

// A hash table with open addressing over positions that are kept elsewhere. 0 and -0 are equal; a vertex has the sign
// of the corner that came first.
class Welder {
 public:
  // Adds to `positions`, which must outlive this, be empty, and change in no other way.
  explicit Welder(std::vector<Vec3d>& positions) : positions_(positions), slots_(kFirstSlots, kEmpty) {}

  // The vertex at a finite position, a new one where there is none. The caller keeps their number below 2^32 - 1.
  std::uint32_t vertex_at(const Vec3d& p);

 private:
  static constexpr std::size_t kFirstSlots = 1024;  // a power of two, as every size
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  void grow();

  std::vector<Vec3d>& positions_;
  std::vector<std::uint64_t> slots_;  // half of the position's hash, then its vertex
};

// Returns which vertices some face uses, and the numbers of the others.
std::vector<bool> used_vertices(const Mesh& mesh);
std::vector<std::uint32_t> vertices_in_no_face(const Mesh& mesh);

// Returns the note of readers on a shape without faces.
inline constexpr const char* kCloudNote = "has no faces and is read as a point cloud";

// Takes values of attributes from readers: values that are not finite become 0, and are counted.
class FiniteValues {
 public:
  double operator()(double value) {
    if (std::isfinite(value)) return value;
    ++replaced_;
    return 0;
  }

  // Appends the note that says so, if there were any.
  void append_note(std::vector<std::string>& notes) const;

 private:
  std::size_t replaced_ = 0;
};

// Vertices whose coordinates are not finite, as scanners write for directions without a point. They stay in the file
// unchanged, and do not belong to the mesh.

// The rows of such vertices in a file, ascending; they are counted from 0, with all vertices of the file.
struct Unplaced {
  std::vector<std::uint32_t> rows;
  std::vector<std::size_t> begin;  // the byte of each row, for messages

  // Adds a row; the same one again is no other.
  void add(std::size_t row, std::size_t byte);
};

// Returns whether a row has no place; `placed` is how many before it have one.
inline bool is_unplaced(std::span<const std::uint32_t> unplaced, std::size_t row, std::size_t placed) {
  return row - placed < unplaced.size() && unplaced[row - placed] == row;
}

// Returns the number, in `unplaced`, of the first of these vertices that a face of the mesh uses.
std::optional<std::size_t> first_used(const Unplaced& unplaced, const Mesh& mesh);

// Removes the vertices, which no face uses, with their attributes, and renumbers the others.
void remove_unplaced(const Unplaced& unplaced, Mesh& mesh);

// Returns one value for each row of the file: those of the mesh's vertices, and zero for vertices without a place.
std::vector<Vec3d> by_row(std::span<const Vec3d> values, std::span<const std::uint32_t> unplaced);

// Returns the note that says so; empty without such vertices.
std::string unplaced_note(std::size_t count);

// Returns the loss of a file that holds only the mesh; empty without such vertices.
std::string unplaced_loss(std::size_t count);

// The normals of a file after its shape has moved.

// Returns the authored normals after the source's vertices moved: one per corner of an OBJ file, else one per vertex;
// empty if the file has none that follow the shape. transport_normals turns those of shapes with faces; vertices with
// the same position and normal, as along a seam, turn together. Normals of points are options.normals, if given.
std::vector<Vec3d> moved_normals(const ShapeFile& source, std::span<const Vec3d> positions,
                                 const WriteOptions& options);

// Sets attributes with one component at these vertices: a value for each.
void put_values(Mesh& mesh, std::span<const Attribute> attributes, std::span<const std::uint32_t> vertices);

// Returns the source's mesh at the new positions, with its normals and tangents turned.
Mesh moved_mesh(const ShapeFile& source, std::span<const Vec3d> positions, const WriteOptions& options);

// Memory for the rest of a file.

// Reserves memory of a vector once instead of repeatedly: as much as the rest of the file fills if it is like the part
// since the first item. Reserved memory that is not used is never touched.
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

}  // namespace knead::detail
