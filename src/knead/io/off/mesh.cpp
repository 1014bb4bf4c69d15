#include "knead/io/off/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace knead::io_detail::off {

void Colors::add(std::span<const double> numbers, bool are_whole) {
  if (elements_++ == 0) width_ = numbers.size();
  same_width_ = same_width_ && numbers.size() == width_;
  whole_ = whole_ && are_whole;
  if (same_width_) {
    values_.insert(values_.end(), numbers.begin(), numbers.end());
  } else {
    values_ = {};
  }
}

bool Colors::readable(Domain domain) const {
  const auto all_within = [&](double most) {
    return std::all_of(values_.begin(), values_.end(), [&](double value) { return value >= 0 && value <= most; });
  };
  if (!same_width_) return false;
  if (width_ == 0) return true;
  if (width_ == 1) return domain == Domain::face && whole_ && all_within(std::numeric_limits<std::int32_t>::max());
  return (width_ == 3 || width_ == 4) && all_within(whole_ ? 255 : std::numeric_limits<float>::max());
}

std::optional<Attribute> Colors::attribute(Domain domain) const {
  if (width_ == 0 || !readable(domain)) return std::nullopt;
  if (width_ == 1) return Attribute{"color_index", domain, NumberType::int32, 1, values_};
  return Attribute{"color", domain, whole_ ? NumberType::uint8 : NumberType::float32, static_cast<int>(width_),
                   values_};
}

double MeshBuilder::finite(double value) {
  if (std::isfinite(value)) return value;
  ++not_finite_;
  return 0;
}

void MeshBuilder::add_vertex(std::span<const double> numbers, const std::vector<bool>& is_whole) {
  shape_.mesh.positions.push_back({numbers[0], numbers[1], numbers[2]});
  if (numbers.size() == 3) return;
  const std::size_t color_begin = fields_.normals ? 6 : 3;
  const std::size_t color_end = numbers.size() - (fields_.uv ? 2 : 0);
  for (std::size_t i = 3; i < color_begin; ++i) normals_.push_back(finite(numbers[i]));
  for (std::size_t i = color_end; i < numbers.size(); ++i) uv_.push_back(finite(numbers[i]));
  bool whole = true;
  for (std::size_t i = color_begin; i < color_end; ++i) whole = whole && is_whole[i];
  vertex_colors_.add(numbers.subspan(color_begin, color_end - color_begin), whole);
}

void MeshBuilder::add_face(std::span<const std::uint32_t> vertices, std::span<const double> color, bool is_whole) {
  face_.assign(vertices.begin(), vertices.end());
  if (faces_.add(face_)) face_colors_.add(color, is_whole);
}

void MeshBuilder::add_attribute(const char* name, int components, std::vector<double>& values) {
  shape_.mesh.attributes.push_back({name, Domain::vertex, NumberType::float32, components, std::move(values)});
}

bool MeshBuilder::add_colors(const Colors& colors, Domain domain) {
  if (std::optional<Attribute> attribute = colors.attribute(domain)) {
    shape_.mesh.attributes.push_back(*std::move(attribute));
  }
  if (colors.readable(domain)) return true;
  shape_.notes.push_back(std::string("the numbers after the ") +
                         (domain == Domain::face ? "indices of faces" : "coordinates of vertices") +
                         " are not colors of one kind; they are kept but not read");
  return false;
}

bool MeshBuilder::finish() {
  faces_.append_notes(shape_.notes);
  if (fields_.normals) add_attribute("normal", 3, normals_);
  if (fields_.uv) add_attribute("uv", 2, uv_);
  const bool vertices_read = add_colors(vertex_colors_, Domain::vertex);
  const bool faces_read = add_colors(face_colors_, Domain::face);
  if (not_finite_ > 0) {
    shape_.notes.push_back(counted(not_finite_, "attribute value is not finite and is read as 0",
                                   "attribute values are not finite and are read as 0"));
  }
  if (shape_.mesh.face_count() == 0) shape_.notes.push_back("has no faces and is read as a point cloud");
  return vertices_read && faces_read;
}

}  // namespace knead::io_detail::off
