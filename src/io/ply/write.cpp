#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include "io/formats.h"
#include "io/mesh_builder.h"
#include "io/ply/ply.h"
#include "io/text.h"
#include "knead/error.h"
#include "math/system.h"

namespace knead::io_detail::ply {
namespace {

template <class T, bool kSwapped>
T load(const char* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return kSwapped ? swap_bytes(value) : value;
}

// Calls visit(T{}, std::bool_constant) for a number type and a byte order.
template <class Visit>
void visit_stored(StoredType type, bool swapped, Visit visit) {
  visit_type(type, [&](auto value) {
    if (swapped) {
      visit(value, std::true_type{});
    } else {
      visit(value, std::false_type{});
    }
  });
}

// Where rows of one length stand in the file.
struct Block {
  const char* bytes = nullptr;
  std::size_t stride = 0;
  Rows rows;
  std::size_t position = 0;  // of its first byte in the file
};

class ColumnReader {
 public:
  ColumnReader(BinaryBody& body, const Element& element, const std::vector<Sink>& sinks, Target& target)
      : body_(body), element_(element), sinks_(sinks), target_(target) {
    for (const Property& property : element.properties) {
      if (property.is_list) {
        list_ = &property;
        break;
      }
      before_list_ += size_of(property.type);
    }
  }

  void run() {
    std::size_t kept = 0;
    for (std::size_t done = 0; done < element_.count;) {
      const std::size_t count = measure_run(element_.count - done);
      const bool keep = list_ == nullptr || corners_ >= 3;
      const std::size_t position = body_.position();
      read_block({body_.skip(count * stride_), stride_, {kept, count}, position});
      if (keep) kept += count;
      done += count;
    }
  }

 private:
  // Returns how many of the next rows have lists as long as that of the first, at most as many as the cache holds. Sets
  // their length.
  std::size_t measure_run(std::size_t most) {
    most = std::min<std::size_t>(most, 2048);
    stride_ = smallest_row(element_, false);
    if (list_ == nullptr) return most;  // check_count has seen to their bytes
    if (body_.left() < stride_) body_.fail_missing(element_);
    corners_ = body_.length_at(before_list_, *list_, element_);
    stride_ += corners_ * size_of(list_->type);
    if (body_.left() < stride_) body_.fail_missing(element_);
    most = std::min(most, body_.left() / stride_);
    const auto same_length = [&](auto type, auto swapped) {
      using T = decltype(type);
      const char* from = body_.data(most * stride_) + before_list_;
      const T length = load<T, swapped()>(from);
      std::size_t count = 1;
      while (count < most && load<T, swapped()>(from + count * stride_) == length) ++count;
      most = count;
    };
    visit_stored(list_->count_type, body_.swapped(), same_length);
    return most;
  }

  void read_block(const Block& block) {
    if (list_ != nullptr) add_faces(block);
    if (list_ != nullptr && corners_ < 3) return;  // no faces
    target_.grow(sinks_, block.rows);
    std::size_t offset = 0;
    bool coordinates = false;
    for (std::size_t p = 0; p < element_.properties.size(); ++p) {
      const Property& property = element_.properties[p];
      if (!property.is_list) read_column(property.type, block, offset, sinks_[p]);
      coordinates = coordinates || sinks_[p].kind == Sink::Kind::coordinate;
      offset +=
          property.is_list ? size_of(property.count_type) + corners_ * size_of(property.type) : size_of(property.type);
    }
    if (coordinates) target_.check_coordinates(block.rows, block.position, block.stride);
  }

  void read_column(StoredType type, const Block& block, std::size_t offset, const Sink& sink) {
    double* const to = target_.place(sink, block.rows.first);
    if (to == nullptr) return;
    const std::size_t to_stride = target_.place_stride(sink);
    const char* const from = block.bytes + offset;
    visit_stored(type, body_.swapped(), [&](auto number, auto swapped) {
      for (std::size_t i = 0; i < block.rows.count; ++i) {
        to[i * to_stride] = static_cast<double>(load<decltype(number), swapped()>(from + i * block.stride));
      }
    });
    if (sink.kind == Sink::Kind::coordinate || is_integer(type)) return;
    for (std::size_t i = 0; i < block.rows.count; ++i) to[i * to_stride] = target_.finite(to[i * to_stride]);
  }

  void add_faces(const Block& block) {
    indices_.resize(block.rows.count * corners_);
    const char* const from = block.bytes + before_list_ + size_of(list_->count_type);
    std::uint64_t largest = 0;
    visit_stored(list_->type, body_.swapped(), [&](auto number, auto swapped) {
      using T = decltype(number);
      if constexpr (std::is_integral_v<T>) {
        std::uint32_t* to = indices_.data();
        for (std::size_t i = 0; i < block.rows.count; ++i) {
          for (std::size_t c = 0; c < corners_; ++c) {
            const T index = load<T, swapped()>(from + i * block.stride + c * sizeof(T));
            // NOLINTBEGIN(bugprone-signed-char-misuse): a number, no character; a negative one becomes huge
            largest = std::max(largest, static_cast<std::uint64_t>(static_cast<std::int64_t>(index)));
            *to++ = static_cast<std::uint32_t>(index);
            // NOLINTEND(bugprone-signed-char-misuse)
          }
        }
      }
    });
    if (largest >= target_.vertices() && corners_ > 0) fail_index(block);
    target_.faces().add_equal(indices_, corners_, block.rows.count);
  }

  [[noreturn]] void fail_index(const Block& block) {
    const std::size_t first = before_list_ + size_of(list_->count_type);
    for (std::size_t i = 0; i < block.rows.count; ++i) {
      for (std::size_t c = 0; c < corners_; ++c) {
        const std::size_t offset = i * block.stride + first + c * size_of(list_->type);
        const double index = read_binary(block.bytes + offset, list_->type, body_.swapped());
        if (index >= 0 && index < static_cast<double>(target_.vertices())) continue;
        body_.fail_at(block.position + offset, index_message(index, target_.vertices()));
      }
    }
    body_.fail_at(block.position, "an index is out of range; repair the file");
  }

  BinaryBody& body_;
  const Element& element_;
  const std::vector<Sink>& sinks_;
  Target& target_;
  const Property* list_ = nullptr;
  std::size_t before_list_ = 0;  // bytes of a row
  std::size_t corners_ = 0;      // of each face of the run
  std::size_t stride_ = 0;       // bytes of each row of the run
  std::vector<std::uint32_t> indices_;
};

}  // namespace

void read_columns(BinaryBody& body, const Element& element, const std::vector<Sink>& sinks, Target& target) {
  ColumnReader(body, element, sinks, target).run();
}

std::size_t smallest_row(const Element& element, bool ascii) {
  std::size_t smallest = 0;
  for (const Property& p : element.properties) {
    smallest += ascii ? 2 : size_of(p.is_list ? p.count_type : p.type);
  }
  return smallest;
}

void reserve_rows(const Element& element, const std::vector<Sink>& sinks, std::size_t left, bool ascii,
                  Target& target) {
  if (target.is_one_block()) return;
  Mesh& mesh = target.mesh();
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const Sink& sink = sinks[p];
    if (sink.kind == Sink::Kind::coordinate) reserve_large(mesh.positions, element.count);
    if (sink.kind == Sink::Kind::attribute) {
      Attribute& attribute = mesh.attributes[sink.attribute];
      reserve_large(attribute.values, element.count * static_cast<std::size_t>(attribute.components));
    }
    if (sink.kind != Sink::Kind::faces) continue;
    const std::size_t item = ascii ? 2 : size_of(element.properties[p].type);
    const std::size_t items = (left - std::min(left, element.count * smallest_row(element, ascii))) / item;
    reserve_large(mesh.face_begin, element.count + 1);
    reserve_large(mesh.corner_vertex, std::min(items, 4 * element.count));
  }
}

std::string index_message(double index, std::size_t vertices) {
  return fmt::format("vertex index {:.0f} is not one of the {} vertices, counted from 0; repair the file", index,
                     vertices);
}

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

// The names of the list of a face's vertices; the first two are the usual ones.
constexpr std::array<std::string_view, 5> kIndexNames = {"vertex_indices", "vertex_index", "vertex_indexes", "indices",
                                                         "vertices"};

bool is_group_name(const std::string& name) {
  return std::any_of(kGroups.begin(), kGroups.end(), [&](const Group& group) { return group.attribute == name; });
}

std::optional<std::size_t> find_scalar(const Element& element, std::string_view name) {
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    if (element.properties[p].name == name && !element.properties[p].is_list) return p;
  }
  return std::nullopt;
}

class Planner {
 public:
  Planner(const Layout& layout, const std::string& name) : layout_(layout), name_(name) {}

  Plan run() {
    for (const Element& element : layout_.elements) {
      sinks_ = &plan_.sinks.emplace_back(element.properties.size());
      const bool is_vertex = &element == &layout_.elements[layout_.vertex_element];
      if (is_vertex) add_coordinates(element);
      if (element.name == "face" || element.name == "tristrips") add_indices(element);
      if (is_vertex || element.name == "face") add_attributes(element, is_vertex ? Domain::vertex : Domain::face);
    }
    return std::move(plan_);
  }

 private:
  void add_coordinates(const Element& element) {
    if (element.count == 0) throw InvalidInput(Place{name_}, "has no vertices; there is no shape in it");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string property(1, "xyz"[axis]);
      const std::optional<std::size_t> p = find_scalar(element, property);
      if (!p) throw InvalidInput(Place{name_}, "element 'vertex' has no property '" + property + "'; add one");
      (*sinks_)[*p] = {Sink::Kind::coordinate, 0, axis};
    }
  }

  void add_indices(const Element& element) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (!is_index_list(element, element.properties[p])) continue;
      (*sinks_)[p].kind = element.name == "face" ? Sink::Kind::faces : Sink::Kind::strips;
      return;
    }
    if (element.count == 0) return;
    throw InvalidInput(Place{name_}, "element '" + element.name + "' has no list 'vertex_indices'; add one");
  }

  void add_attributes(const Element& element, Domain domain) {
    for (const Group& group : kGroups) add_group(element, domain, group);
    if (domain == Domain::face) add_corner_uv(element);
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if ((*sinks_)[p].kind == Sink::Kind::skip && !property.is_list && !is_group_name(property.name)) {
        add_attribute(element, domain, property.name, {p});
      }
    }
  }

  void add_group(const Element& element, Domain domain, const Group& group) {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < group.possible; ++i) {
      const std::optional<std::size_t> p = find_scalar(element, group.properties[i]);
      if (!p || element.properties[*p].type != element.properties[members.empty() ? *p : members[0]].type) break;
      members.push_back(*p);
    }
    const bool needs_reals = group.attribute != "color";
    if (members.size() < group.needed || (needs_reals && is_integer(element.properties[members[0]].type))) return;
    add_attribute(element, domain, std::string(group.attribute), members);
  }

  void add_attribute(const Element& element, Domain domain, const std::string& attribute,
                     const std::vector<std::size_t>& members) {
    for (std::size_t i = 0; i < members.size(); ++i) {
      (*sinks_)[members[i]] = {Sink::Kind::attribute, plan_.attributes.size(), i};
    }
    const NumberType type = number_type(element.properties[members[0]].type);
    plan_.attributes.push_back({attribute, domain, type, static_cast<int>(members.size()), {}});
  }

  void add_corner_uv(const Element& element) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (!element.properties[p].is_list || element.properties[p].name != "texcoord") continue;
      (*sinks_)[p] = {Sink::Kind::corner_uv, plan_.attributes.size(), 0};
      plan_.attributes.push_back({"uv", Domain::corner, number_type(element.properties[p].type), 2, {}});
    }
  }

  const Layout& layout_;
  const std::string& name_;
  Plan plan_;
  std::vector<Sink>* sinks_ = nullptr;
};

}  // namespace

Plan make_plan(const Layout& layout, const std::string& name) { return Planner(layout, name).run(); }

bool is_index_list(const Element& element, const Property& property) {
  return property.is_list && (element.name == "face" || element.name == "tristrips") &&
         std::find(kIndexNames.begin(), kIndexNames.end(), property.name) != kIndexNames.end();
}

// Writing a mesh as a new PLY file.

namespace {

// The attributes as PLY holds them: numbers per vertex, numbers per face, and u v per corner as a list per face.
struct Holdings {
  std::vector<Attribute> vertex;
  std::vector<Attribute> face;
  std::optional<Attribute> corner_uv;
  std::vector<std::string> losses;
};

Holdings sort_attributes(const Mesh& mesh) {
  Holdings held;
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain == Domain::vertex) {
      held.vertex.push_back(attribute);
    } else if (attribute.domain == Domain::face) {
      held.face.push_back(attribute);
    } else if (std::optional<Attribute> merged = merge_corners(mesh, attribute)) {
      held.vertex.push_back(*std::move(merged));
    } else if (attribute.name == "uv" && attribute.components == 2) {
      held.corner_uv = attribute;
    } else {
      held.losses.push_back("PLY cannot hold '" + attribute.name + "' that differs between the faces at a vertex");
    }
  }
  return held;
}

std::string property_name(const Attribute& attribute, int component) {
  const std::size_t i = static_cast<std::size_t>(component);
  if (attribute.name == "normal" && i < 3) return std::array{"nx", "ny", "nz"}[i];
  if (attribute.name == "uv" && i < 2) return std::array{"s", "t"}[i];
  if (attribute.name == "color" && i < 4) return std::array{"red", "green", "blue", "alpha"}[i];
  return attribute.components == 1 ? attribute.name : attribute.name + std::to_string(component);
}

void append_properties(std::string& header, const std::vector<Attribute>& attributes) {
  for (const Attribute& attribute : attributes) {
    for (int c = 0; c < attribute.components; ++c) {
      header +=
          "property " + std::string(type_name(stored_type(attribute.type))) + " " + property_name(attribute, c) + "\n";
    }
  }
}

// A value of an attribute as near as its type can hold it.
double nearest(NumberType type, double value) {
  constexpr double most = std::numeric_limits<float>::max();
  return type == NumberType::float32 ? std::clamp(value, -most, most) : value;
}

void append_values(std::string& bytes, const std::vector<Attribute>& attributes, std::size_t element) {
  for (const Attribute& attribute : attributes) {
    const std::size_t n = static_cast<std::size_t>(attribute.components);
    for (std::size_t c = 0; c < n; ++c)
      append_binary(bytes, stored_type(attribute.type), nearest(attribute.type, attribute.values[element * n + c]),
                    is_swapped(Encoding::little_endian));
  }
}

std::size_t largest_face(const Mesh& mesh) {
  std::size_t largest = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) largest = std::max(largest, mesh.face(f).size());
  return largest;
}

std::string header_for(const Mesh& mesh, const Holdings& held, StoredType coordinate, StoredType length,
                       StoredType uv_length) {
  const std::string type(type_name(coordinate));
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.vertex_count()) +
                       "\nproperty " + type + " x\nproperty " + type + " y\nproperty " + type + " z\n";
  append_properties(header, held.vertex);
  header += "element face " + std::to_string(mesh.face_count()) + "\nproperty list " + std::string(type_name(length)) +
            " int vertex_indices\n";
  if (held.corner_uv) header += "property list " + std::string(type_name(uv_length)) + " float texcoord\n";
  append_properties(header, held.face);
  return header + "end_header\n";
}

void check_range(const Mesh& mesh) {
  for (const Vec3d& p : mesh.positions) {
    if (fits_float(p.x) && fits_float(p.y) && fits_float(p.z)) continue;
    throw InvalidInput("a coordinate does not fit in a float; use double precision");
  }
}

void append_corner_uv(std::string& bytes, const Mesh& mesh, const Attribute& uv, std::size_t f, StoredType length) {
  append_binary(bytes, length, 2.0 * static_cast<double>(mesh.face(f).size()), is_swapped(Encoding::little_endian));
  for (std::size_t i = 2 * std::size_t{mesh.face_begin[f]}; i < 2 * std::size_t{mesh.face_begin[f + 1]}; ++i) {
    append_binary(bytes, StoredType::float32, nearest(NumberType::float32, uv.values[i]),
                  is_swapped(Encoding::little_endian));
  }
}

}  // namespace

std::string generate(const Mesh& mesh, const WriteOptions& options) {
  if (!options.double_coordinates) check_range(mesh);
  const bool swapped = is_swapped(Encoding::little_endian);
  const Holdings held = sort_attributes(mesh);
  const StoredType coordinate = options.double_coordinates ? StoredType::float64 : StoredType::float32;
  const std::size_t largest = largest_face(mesh);
  const StoredType length = largest < 256 ? StoredType::uint8 : StoredType::uint32;
  const StoredType uv_length = largest < 128 ? StoredType::uint8 : StoredType::uint32;
  std::string bytes = header_for(mesh, held, coordinate, length, uv_length);
  bytes.reserve(bytes.size() + mesh.vertex_count() * 24 + mesh.face_count() * 4 + mesh.corner_vertex.size() * 4);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) append_binary(bytes, coordinate, mesh.positions[i][axis], swapped);
    append_values(bytes, held.vertex, i);
  }
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    append_binary(bytes, length, static_cast<double>(mesh.face(f).size()), swapped);
    for (const std::uint32_t v : mesh.face(f)) append_binary(bytes, StoredType::int32, v, swapped);
    if (held.corner_uv) append_corner_uv(bytes, mesh, *held.corner_uv, f, uv_length);
    append_values(bytes, held.face, f);
  }
  return bytes;
}

void append_row_losses(const Layout& layout, std::vector<std::string>& losses) {
  if (!layout.unplaced.empty()) losses.push_back(unplaced_loss(layout.unplaced.size()));
  if (layout.surplus) losses.emplace_back("numbers beyond those that the header declares are left out");
}

std::vector<std::string> losses(const Mesh& mesh) { return sort_attributes(mesh).losses; }

std::vector<std::string> source_losses(const ShapeFile& source) {
  std::vector<std::string> losses;
  for (const Element& element : layout_of<Layout>(source).elements) {
    const bool is_known = element.name == "vertex" || element.name == "face" || element.name == "tristrips";
    if (!is_known) losses.push_back("element '" + element.name + "' is left out");
    for (const Property& property : element.properties) {
      const bool is_read = is_index_list(element, property) || (element.name == "face" && property.name == "texcoord");
      if (is_known && property.is_list && !is_read) losses.push_back("list '" + property.name + "' is left out");
    }
  }
  append_row_losses(layout_of<Layout>(source), losses);
  return losses;
}

}  // namespace knead::io_detail::ply
