// The formats' parts of remeshed.h. Internal to it: what they are given has been checked.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "knead/io/ply_header.h"
#include "knead/io/shape_file.h"

namespace knead {

// A mesh in the place of its source's.
struct NewMesh {
  const ShapeFile& source;
  const Mesh& mesh;
  std::span<const std::uint32_t> face_source;
};

std::string remeshed_ply(const NewMesh& shape, const WriteOptions& options);
std::string remeshed_obj(const NewMesh& shape, const WriteOptions& options);
std::string remeshed_glb(const NewMesh& shape, const WriteOptions& options);
std::string remeshed_stl(const NewMesh& shape, const WriteOptions& options);
std::string remeshed_off(const NewMesh& shape, const WriteOptions& options);

// face_labels of OBJ.
std::vector<std::uint32_t> obj_face_labels(const ShapeFile& source);

// What they leave out of the source, a sentence each.
std::vector<std::string> ply_remesh_losses(const ShapeFile& source);
std::vector<std::string> obj_remesh_losses(const ShapeFile& source);
std::vector<std::string> glb_remesh_losses(const ShapeFile& source);
std::vector<std::string> stl_remesh_losses(const ShapeFile& source);
std::vector<std::string> off_remesh_losses(const ShapeFile& source);

// The new elements (faces, triangles) that lie in each face of the source, in their order.
class BySource {
 public:
  BySource(std::span<const std::uint32_t> source_of, std::size_t sources) : begin_(sources + 1, 0) {
    for (const std::uint32_t source : source_of) ++begin_[source + 1];
    for (std::size_t i = 0; i < sources; ++i) begin_[i + 1] += begin_[i];
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    elements_.resize(source_of.size());
    for (std::size_t i = 0; i < source_of.size(); ++i) elements_[next[source_of[i]]++] = static_cast<std::uint32_t>(i);
  }

  std::span<const std::uint32_t> of(std::size_t source) const {
    return std::span(elements_).subspan(begin_[source], begin_[source + 1] - begin_[source]);
  }

 private:
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> elements_;
};

// A value as near as a type can hold it: integers rounded.
inline double nearest_of(NumberType type, double value) {
  return visit_type(type, [&](auto number) {
    using Limits = std::numeric_limits<decltype(number)>;
    const double whole = Limits::is_integer ? std::round(value) : value;
    return std::clamp(whole, double{Limits::lowest()}, double{Limits::max()});
  });
}

// The first line end of a text; "\n" without one.
inline std::string_view line_end_of(std::string_view text) {
  const std::size_t end = text.find_first_of("\r\n");
  if (end == std::string_view::npos) return "\n";
  return text.substr(end, text.substr(end, 2) == "\r\n" ? 2 : 1);
}

}  // namespace knead
