// A mesh that takes the place of the one that a file was read into.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead::io_detail {

// The arguments of serialize_remeshed, checked.
struct NewMesh {
  const ShapeFile& source;
  const Mesh& mesh;
  std::span<const std::uint32_t> face_source;
};

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

// The first line end of a text; "\n" without one.
inline std::string_view line_end_of(std::string_view text) {
  const std::size_t end = text.find_first_of("\r\n");
  if (end == std::string_view::npos) return "\n";
  return text.substr(end, text.substr(end, 2) == "\r\n" ? 2 : 1);
}

}  // namespace knead::io_detail
