// Making a mesh of the columns of a PLY file.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "knead/io/face_builder.h"
#include "knead/io/ply.h"
#include "knead/io/ply_header.h"
#include "knead/io/text.h"
#include "knead/math/error.h"

namespace knead {
namespace {

// Scalar properties that together make one attribute.
struct Group {
  std::string_view attribute;
  std::array<std::string_view, 4> properties;
  std::size_t needed;    // so many must be there
  std::size_t possible;  // and so many may
};

constexpr std::array<Group, 6> kGroups = {{{"normal", {"nx", "ny", "nz", ""}, 3, 3},
                                           {"uv", {"s", "t", "", ""}, 2, 2},
                                           {"uv", {"u", "v", "", ""}, 2, 2},
                                           {"uv", {"texture_u", "texture_v", "", ""}, 2, 2},
                                           {"uv", {"texture_s", "texture_t", "", ""}, 2, 2},
                                           {"color", {"red", "green", "blue", "alpha"}, 3, 4}}};

bool is_group_name(const std::string& name) {
  return std::any_of(kGroups.begin(), kGroups.end(), [&](const Group& group) { return group.attribute == name; });
}

std::optional<std::size_t> find_scalar(const PlyElement& element, std::string_view name) {
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    if (element.properties[p].name == name && !element.properties[p].is_list) return p;
  }
  return std::nullopt;
}

class MeshMaker {
 public:
  MeshMaker(ShapeFile& shape, std::vector<PlyColumns>& columns, const std::string& name)
      : shape_(shape), layout_(std::get<PlyLayout>(shape.layout)), columns_(columns), name_(name) {}

  void run() {
    add_positions();
    FaceBuilder faces(shape_.mesh);
    bool strips = false;
    for (std::size_t e = 0; e < layout_.elements.size(); ++e) {
      if (layout_.elements[e].name == "face") add_faces(e, faces);
      if (layout_.elements[e].name == "tristrips") strips = add_strips(e, faces) || strips;
    }
    faces.append_notes(shape_.notes);
    for (std::size_t e = 0; e < layout_.elements.size(); ++e) {
      if (e == layout_.vertex_element) add_attributes(e, Domain::vertex);
      if (layout_.elements[e].name == "face" && !strips) add_attributes(e, Domain::face);
    }
    add_final_notes();
  }

 private:
  [[noreturn]] void fail(std::size_t position, const std::string& what) const {
    fail_in_ply(shape_.bytes, layout_, position, name_, what);
  }

  void add_positions() {
    const PlyElement& element = layout_.elements[layout_.vertex_element];
    if (element.count == 0) throw InvalidInput(Place{name_}, "has no vertices; there is no shape in it");
    shape_.mesh.positions.resize(element.count);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string property(1, "xyz"[axis]);
      const std::optional<std::size_t> p = find_scalar(element, property);
      if (!p) throw InvalidInput(Place{name_}, "element 'vertex' has no property '" + property + "'; add one");
      const std::vector<double>& values = columns_[layout_.vertex_element].values[*p];
      for (std::size_t i = 0; i < element.count; ++i) {
        if (!std::isfinite(values[i])) {
          fail(layout_.row_begin[i],
               "coordinate " + property + " of vertex " + std::to_string(i) + " is not finite; repair the file");
        }
        shape_.mesh.positions[i][axis] = values[i];
      }
    }
  }

  std::optional<std::size_t> find_index_list(const PlyElement& element) const {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (!is_index_list(element, element.properties[p])) continue;
      if (!is_integer(element.properties[p].type)) {
        throw InvalidInput(Place{name_}, "the indices of element '" + element.name + "' must have an integer type");
      }
      return p;
    }
    if (element.count == 0) return std::nullopt;
    throw InvalidInput(Place{name_}, "element '" + element.name + "' has no list 'vertex_indices'; add one");
  }

  std::uint32_t checked_index(double value, std::size_t row_begin) const {
    if (value != std::floor(value) || value < 0 || value >= static_cast<double>(shape_.mesh.vertex_count())) {
      fail(row_begin, "vertex index " + shown(value) + " is not one of 0 to " +
                          std::to_string(shape_.mesh.vertex_count() - 1) + "; repair the file");
    }
    return static_cast<std::uint32_t>(value);
  }

  void add_faces(std::size_t e, FaceBuilder& faces) {
    const std::optional<std::size_t> p = find_index_list(layout_.elements[e]);
    if (!p) return;
    const PlyColumns& columns = columns_[e];
    std::vector<std::uint32_t> face;
    for (std::size_t row = 0, i = 0; row < columns.ends[*p].size(); ++row) {
      face.clear();
      for (; i < columns.ends[*p][row]; ++i)
        face.push_back(checked_index(columns.values[*p][i], columns.row_begin[row]));
      face_kept_.push_back(faces.add(face));
    }
  }

  // Strips of triangles with -1 between them; every other triangle is turned round. A repeated vertex is how strips are
  // stitched together and makes no face.
  bool add_strips(std::size_t e, FaceBuilder& faces) {
    const std::optional<std::size_t> p = find_index_list(layout_.elements[e]);
    if (!p) return false;
    const PlyColumns& columns = columns_[e];
    for (std::size_t row = 0, i = 0; row < columns.ends[*p].size(); ++row) {
      std::vector<std::uint32_t> strip;
      for (; i < columns.ends[*p][row]; ++i) {
        if (columns.values[*p][i] == -1) {
          strip.clear();
          continue;
        }
        strip.push_back(checked_index(columns.values[*p][i], columns.row_begin[row]));
        add_strip_triangle(strip, faces);
      }
    }
    return true;
  }

  static void add_strip_triangle(const std::vector<std::uint32_t>& strip, FaceBuilder& faces) {
    const std::size_t n = strip.size();
    if (n < 3) return;
    std::uint32_t a = strip[n - 3];
    std::uint32_t b = strip[n - 2];
    const std::uint32_t c = strip[n - 1];
    if (a == b || b == c || c == a) return;
    if (n % 2 == 0) std::swap(a, b);
    faces.add({a, b, c});
  }

  void add_attributes(std::size_t e, Domain domain) {
    const PlyElement& element = layout_.elements[e];
    std::vector<bool> used(element.properties.size(), false);
    for (std::size_t axis = 0; axis < 3 && domain == Domain::vertex; ++axis) {
      used[*find_scalar(element, std::string_view("xyz").substr(axis, 1))] = true;
    }
    for (const Group& group : kGroups) add_group(e, domain, group, used);
    if (domain == Domain::face) add_corner_uv(e);
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (!used[p] && !property.is_list && !is_group_name(property.name)) {
        add_attribute(e, domain, property.name, {p});
      }
    }
  }

  void add_group(std::size_t e, Domain domain, const Group& group, std::vector<bool>& used) {
    const PlyElement& element = layout_.elements[e];
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < group.possible; ++i) {
      const std::optional<std::size_t> p = find_scalar(element, group.properties[i]);
      if (!p || element.properties[*p].type != element.properties[members.empty() ? *p : members[0]].type) break;
      members.push_back(*p);
    }
    const bool needs_reals = group.attribute != "color";
    if (members.size() < group.needed || (needs_reals && is_integer(element.properties[members[0]].type))) return;
    for (const std::size_t p : members) used[p] = true;
    add_attribute(e, domain, std::string(group.attribute), members);
  }

  void add_attribute(std::size_t e, Domain domain, const std::string& attribute,
                     const std::vector<std::size_t>& members) {
    const PlyElement& element = layout_.elements[e];
    Attribute result{attribute, domain, element.properties[members[0]].type, static_cast<int>(members.size()), {}};
    result.values.reserve(element.count * members.size());
    for (std::size_t row = 0; row < element.count; ++row) {
      if (domain == Domain::face && !face_kept_[row]) continue;
      for (const std::size_t p : members) result.values.push_back(finite(columns_[e].values[p][row]));
    }
    shape_.mesh.attributes.push_back(std::move(result));
  }

  // The list "texcoord": u v for each corner of a face. Faces whose list has another length make it no attribute.
  void add_corner_uv(std::size_t e) {
    const PlyElement& element = layout_.elements[e];
    const std::optional<std::size_t> indices = find_index_list(element);
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (!element.properties[p].is_list || element.properties[p].name != "texcoord" || !indices) continue;
      const auto list_size = [&](std::size_t q, std::size_t row) {
        return columns_[e].ends[q][row] - (row > 0 ? columns_[e].ends[q][row - 1] : 0);
      };
      Attribute uv{"uv", Domain::corner, element.properties[p].type, 2, {}};
      for (std::size_t row = 0; row < element.count; ++row) {
        if (list_size(p, row) != 2 * list_size(*indices, row)) return;
        if (!face_kept_[row]) continue;
        const std::size_t end = columns_[e].ends[p][row];
        for (std::size_t i = end - list_size(p, row); i < end; ++i)
          uv.values.push_back(finite(columns_[e].values[p][i]));
      }
      shape_.mesh.attributes.push_back(std::move(uv));
    }
  }

  double finite(double value) {
    if (std::isfinite(value)) return value;
    ++not_finite_;
    return 0;
  }

  void add_final_notes() {
    if (not_finite_ > 0) {
      shape_.notes.push_back(counted(not_finite_, "attribute value is not finite and is taken as 0",
                                     "attribute values are not finite and are taken as 0"));
    }
    if (shape_.mesh.face_count() > 0) return;
    shape_.notes.push_back("has no faces and is read as a point cloud");
    if (shape_.mesh.find_attribute("normal") != nullptr) {
      shape_.notes.push_back("without faces, normals stay as they are when points move");
    }
  }

  ShapeFile& shape_;
  const PlyLayout& layout_;
  std::vector<PlyColumns>& columns_;
  const std::string& name_;
  std::vector<bool> face_kept_;
  std::size_t not_finite_ = 0;
};

}  // namespace

void build_ply_mesh(ShapeFile& shape, std::vector<PlyColumns>& columns, const std::string& name) {
  MeshMaker(shape, columns, name).run();
}

}  // namespace knead
