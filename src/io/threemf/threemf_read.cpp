// Reading 3MF: the objects of its models, what the build places, and the colors of triangles.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/text.h"
#include "io/threemf/threemf.h"
#include "io/threemf/zip.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::detail::threemf {

namespace {

constexpr std::string_view kModelType = "/3dmodel";  // the end of the type of the relationship to the root model
constexpr std::size_t kMaxInstances = 100'000;
constexpr int kMaxDepth = 32;  // of objects within objects

using Color = std::array<std::uint8_t, 4>;

// An item of the build, or a component of an object.
struct Placed {
  std::string part;  // empty: the same
  std::string id;
  Placement placement;
};

struct Object {
  std::size_t mesh = 0;  // of its part, if it has no components
  bool has_mesh = false;
  std::vector<Vec3d> positions{};
  std::vector<Triangle> triangles{};
  std::vector<std::uint32_t> labels{};         // of the triangles
  std::vector<std::array<Color, 3>> colors{};  // of the triangles' corners, where the model has colors
  std::vector<Placed> components{};
};

// What a part holds.
struct Model {
  std::map<std::string, Object, std::less<>> objects;
  std::vector<Placed> items;
  std::string unit = "millimeter";
};

std::optional<Color> parsed_color(std::string_view text) {
  if (!text.starts_with('#') || (text.size() != 7 && text.size() != 9)) return std::nullopt;
  Color color{0, 0, 0, 255};
  for (std::size_t i = 0; 2 * i + 2 < text.size(); ++i) {
    const auto [end, error] = std::from_chars(text.data() + 2 * i + 1, text.data() + 2 * i + 3, color[i], 16);
    if (error != std::errc() || end != text.data() + 2 * i + 3) return std::nullopt;
  }
  return color;
}

// The labels of triangles by the text of their properties, in all parts.
class Labels {
 public:
  std::uint32_t of(const std::string& properties) {
    if (properties.empty()) return 0;
    return known_.try_emplace(properties, static_cast<std::uint32_t>(known_.size() + 1)).first->second;
  }

 private:
  std::unordered_map<std::string, std::uint32_t> known_;
};

// Reads one part.
class ModelReader {
 public:
  ModelReader(Part& part, const std::string& file, Labels& labels, Layout& layout)
      : part_(part),
        name_(file + ": " + part.name),
        cursor_(part.text, name_, text_begin(part.text, name_)),
        labels_(labels),
        layout_(layout) {}

  Model run() {
    Tag tag;
    if (!cursor_.next(tag) || tag.name != "model") cursor_.fail(tag.begin, "is no model of 3MF");
    if (const std::string_view unit = cursor_.value(tag, "unit"); !unit.empty()) model_.unit = unit;
    while (cursor_.next(tag)) {
      if (tag.is_end) continue;
      if (tag.name == "object") {
        read_object(tag);
      } else if (tag.name == "item") {
        model_.items.push_back(placed(tag));
      } else if (tag.name == "basematerials" || tag.name == "colorgroup") {
        group_ = &groups_[std::string(cursor_.value(tag, "id"))];
      } else if (tag.name == "base" || tag.name == "color") {
        read_color(tag);
      } else if (tag.name == "metadata") {
        layout_.has_metadata = true;
      }
    }
    return std::move(model_);
  }

 private:
  std::size_t place_of(std::string_view word) const {
    return static_cast<std::size_t>(word.data() - part_.text.data());
  }

  double real(std::string_view word) const {
    double value = 0;
    if (parse_real(word, value) != ParseResult::ok || !std::isfinite(value)) {
      cursor_.fail(place_of(word), in_quotes(word) + " is no finite number; repair the file");
    }
    return value;
  }

  // A whole number below `count`.
  std::size_t index(std::string_view word, std::size_t count, const char* what) const {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value >= count) {
      cursor_.fail(place_of(word), in_quotes(word) + " is no " + what);
    }
    return value;
  }

  void read_color(const Tag& tag) {
    if (group_ == nullptr) return;
    const std::string_view text = cursor_.value(tag, tag.name == "base" ? "displaycolor" : "color");
    group_->push_back(parsed_color(text).value_or(Color{255, 255, 255, 255}));
  }

  Placed placed(const Tag& tag) const {
    Placed result;
    result.id = cursor_.value(tag, "objectid");
    result.part = cursor_.value(tag, "path");
    const std::string_view text = cursor_.value(tag, "transform");
    if (text.empty()) return result;
    double m[12];
    std::size_t at = 0;
    for (double& number : m) {
      while (at < text.size() && (is_blank(text[at]) || is_line_end(text[at]))) ++at;
      const std::size_t end = token_end(text, at);
      if (end == at) cursor_.fail(place_of(text), "a transform has fewer than 12 numbers");
      number = real(text.substr(at, end - at));
      at = end;
    }
    result.placement = {{{m[0], m[3], m[6]}, {m[1], m[4], m[7]}, {m[2], m[5], m[8]}}, {m[9], m[10], m[11]}};
    if (determinant(result.placement.turn) == 0) {
      cursor_.fail(place_of(text), "a transform makes an object flat; repair the file");
    }
    return result;
  }

  void read_object(const Tag& opening) {
    group_ = nullptr;
    Object object;
    const std::string id(cursor_.value(opening, "id"));
    default_group_ = cursor_.value(opening, "pid");
    default_index_ = cursor_.value(opening, "pindex");
    Tag tag;
    while (!opening.is_empty && cursor_.next(tag) && !(tag.is_end && tag.name == "object")) {
      if (tag.is_end) continue;
      if (tag.name == "mesh" && !tag.is_empty) read_mesh(object, id);
      if (tag.name == "component") object.components.push_back(placed(tag));
      if (tag.name == "metadata") layout_.has_metadata = true;
    }
    if (!model_.objects.try_emplace(id, std::move(object)).second) {
      cursor_.fail(opening.begin, "a second object has the id " + in_quotes(id));
    }
  }

  void read_mesh(Object& object, const std::string& id) {
    object.has_mesh = true;
    object.mesh = part_.meshes.size();
    MeshText& text = part_.meshes.emplace_back();
    text.id = id;
    Tag tag;
    while (cursor_.next(tag) && !(tag.is_end && tag.name == "mesh")) {
      if (tag.is_end) continue;
      if (tag.name == "vertices" && object.positions.empty()) {
        text.vertices_begin = text.vertices_end = tag.end;
        if (!tag.is_empty) read_vertices(object, text);
      } else if (tag.name == "triangles" && object.triangles.empty()) {
        text.triangles_begin = text.triangles_end = tag.end;
        if (!tag.is_empty) read_triangles(object, text);
      } else {
        text.has_more = true;
      }
    }
  }

  void read_vertices(Object& object, MeshText& text) {
    Numbers numbers;
    Tag tag;
    while (cursor_.next(tag) && !(tag.is_end && tag.name == "vertices")) {
      if (tag.is_end || tag.name != "vertex") continue;
      take_numbers(cursor_, tag, kVertexNames, numbers);
      object.positions.push_back({real(numbers.words[0]), real(numbers.words[1]), real(numbers.words[2])});
    }
    text.vertices_end = tag.begin;
  }

  void read_triangles(Object& object, MeshText& text) {
    Numbers numbers;
    Tag tag;
    while (cursor_.next(tag) && !(tag.is_end && tag.name == "triangles")) {
      if (tag.is_end || tag.name != "triangle") continue;
      take_numbers(cursor_, tag, kTriangleNames, numbers);
      Triangle& triangle = object.triangles.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) {
        triangle[i] = static_cast<std::uint32_t>(
            index(numbers.words[i], std::min(object.positions.size(), kMaxElements), "vertex of its mesh"));
      }
      object.labels.push_back(labels_.of(numbers.properties));
      if (!groups_.empty()) object.colors.push_back(colors_of(tag));
    }
    text.triangles_end = tag.begin;
  }

  std::array<Color, 3> colors_of(const Tag& tag) const {
    std::string_view group = default_group_;
    std::array<std::string_view, 3> words{default_index_, {}, {}};
    TagAttribute attribute;
    for (std::string_view rest = tag.attributes; cursor_.next_attribute(rest, attribute);) {
      if (attribute.name == "pid") group = attribute.value;
      if (attribute.name == "p1") words[0] = attribute.value;
      if (attribute.name == "p2") words[1] = attribute.value;
      if (attribute.name == "p3") words[2] = attribute.value;
    }
    std::array<Color, 3> colors{};
    colors.fill({255, 255, 255, 255});
    const auto found = groups_.find(group);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string_view word = words[i].empty() ? words[0] : words[i];
      if (found == groups_.end() || word.empty()) continue;
      colors[i] = found->second[index(word, found->second.size(), "color of its group")];
    }
    return colors;
  }

  Part& part_;
  std::string name_;
  TagCursor cursor_;
  Labels& labels_;
  Layout& layout_;
  Model model_;
  std::map<std::string, std::vector<Color>, std::less<>> groups_;
  std::vector<Color>* group_ = nullptr;
  std::string_view default_group_;
  std::string_view default_index_;
};

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name)
      : shape_(shape), name_(name), archive_(shape.bytes, name), faces_(shape.mesh) {}

  Layout run() {
    const std::size_t root = part_of(root_name());
    const std::vector<Placed> items = models_[root].items;
    const std::string unit = models_[root].unit;
    for (const Placed& item : items) place(item, root, {}, 0);
    if (shape_.mesh.face_count() == 0) {
      throw InvalidInput(Place{name_}, "its build places no object with triangles; there is no shape in it");
    }
    if (unit != "millimeter") shape_.notes.push_back("its unit is the " + unit + ", and so is that of all lengths");
    if (layout_.instances.size() > 1) {
      shape_.notes.push_back(std::to_string(layout_.instances.size()) + " objects are placed, and read as one shape");
    }
    faces_.append_notes(shape_.notes);
    const auto is_plain = [](std::uint32_t label) { return label == 0; };
    if (std::all_of(layout_.labels.begin(), layout_.labels.end(), is_plain)) layout_.labels.clear();
    add_colors();
    return std::move(layout_);
  }

 private:
  std::string root_name() const {
    const zip::Entry* const relations = archive_.find("_rels/.rels");
    if (relations == nullptr) throw InvalidInput(Place{name_}, "is no 3MF file: its part _rels/.rels is missing");
    const std::string text = archive_.content(*relations);
    const std::string part = name_ + ": " + relations->name;
    TagCursor cursor(text, part);
    for (Tag tag; cursor.next(tag);) {
      if (tag.name == "Relationship" && cursor.value(tag, "Type").ends_with(kModelType)) {
        return std::string(cursor.value(tag, "Target"));
      }
    }
    throw InvalidInput(Place{part}, "names no model; this is no 3MF file");
  }

  // Reads a part, once.
  std::size_t part_of(const std::string& name) {
    const zip::Entry* const entry = archive_.find(name);
    if (entry == nullptr) throw InvalidInput(Place{name_}, "its part " + in_quotes(name) + " is missing");
    for (std::size_t i = 0; i < layout_.parts.size(); ++i) {
      if (layout_.parts[i].name == entry->name) return i;
    }
    layout_.parts.push_back({entry->name, archive_.content(*entry)});
    models_.push_back(ModelReader(layout_.parts.back(), name_, labels_, layout_).run());
    return layout_.parts.size() - 1;
  }

  void place(const Placed& placed, std::size_t part, const Placement& outer, int depth) {
    if (!placed.part.empty()) part = part_of(placed.part);
    const auto found = models_[part].objects.find(placed.id);
    if (found == models_[part].objects.end()) {
      throw InvalidInput(Place{name_ + ": " + layout_.parts[part].name},
                         "an object " + in_quotes(placed.id) + " is placed that is not there; repair the file");
    }
    if (depth > kMaxDepth || layout_.instances.size() > kMaxInstances) {
      throw InvalidInput(Place{name_}, "objects contain each other too often; repair the file");
    }
    const Placement placement = outer * placed.placement;
    const std::vector<Placed> components = found->second.components;
    if (found->second.has_mesh) add(found->second, part, placement);
    for (const Placed& component : components) {
      if (++components_ > kMaxInstances) throw InvalidInput(Place{name_}, "it places too many objects");
      place(component, part, placement, depth + 1);
    }
  }

  void add(const Object& object, std::size_t part, const Placement& placement) {
    Mesh& mesh = shape_.mesh;
    if (mesh.vertex_count() + object.positions.size() > kMaxElements) {
      throw InvalidInput(Place{name_}, "more than 4294967295 vertices; split the shape");
    }
    Instance instance{part, object.mesh, placement};
    instance.first_vertex = static_cast<std::uint32_t>(mesh.vertex_count());
    instance.vertices = static_cast<std::uint32_t>(object.positions.size());
    instance.first_face = static_cast<std::uint32_t>(mesh.face_count());
    instance.faces = static_cast<std::uint32_t>(object.triangles.size());
    for (const Vec3d& p : object.positions) {
      mesh.positions.push_back(placement(p));
      if (!is_finite(mesh.positions.back())) {
        throw InvalidInput(Place{name_}, "a transform leaves the range of numbers; repair the file");
      }
    }
    const bool is_mirrored = instance.is_mirrored();
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
      Triangle triangle = object.triangles[t];
      for (std::uint32_t& v : triangle) v += instance.first_vertex;
      if (is_mirrored) std::swap(triangle[1], triangle[2]);
      faces_.add(triangle);
      for (const std::size_t c : {0, is_mirrored ? 2 : 1, is_mirrored ? 1 : 2}) {
        const bool has_color = !object.colors.empty();
        has_colors_ = has_colors_ || has_color;
        colors_.push_back(has_color ? object.colors[t][c] : Color{255, 255, 255, 255});
      }
    }
    layout_.labels.insert(layout_.labels.end(), object.labels.begin(), object.labels.end());
    layout_.instances.push_back(instance);
  }

  // Of faces where their corners have the same, else of corners.
  void add_colors() {
    if (!has_colors_) return;
    const bool is_opaque = std::all_of(colors_.begin(), colors_.end(), [](const Color& c) { return c[3] == 255; });
    bool of_faces = true;
    for (std::size_t c = 0; c < colors_.size(); ++c) of_faces = of_faces && colors_[c] == colors_[c / 3 * 3];
    Attribute color{"color", of_faces ? Domain::face : Domain::corner, NumberType::uint8, is_opaque ? 3 : 4, {}};
    for (std::size_t c = 0; c < colors_.size(); c += of_faces ? 3 : 1) {
      color.values.insert(color.values.end(), colors_[c].begin(), colors_[c].end() - (is_opaque ? 1 : 0));
    }
    shape_.mesh.attributes.push_back(std::move(color));
  }

  ShapeFile& shape_;
  const std::string& name_;
  zip::Archive archive_;
  FaceBuilder faces_;
  Layout layout_;
  std::vector<Model> models_;  // of the parts
  Labels labels_;
  std::vector<Color> colors_;  // of the corners
  bool has_colors_ = false;
  std::size_t components_ = 0;
};

}  // namespace

Vec3d Placement::inverse_image(const Vec3d& p) const {
  if (is_identity()) return p;
  const Vec3d c0 = turn.column(0);
  const Vec3d c1 = turn.column(1);
  const Vec3d c2 = turn.column(2);
  const Vec3d d = p - shift;
  return Vec3d{dot(cross(c1, c2), d), dot(cross(c2, c0), d), dot(cross(c0, c1), d)} / determinant(turn);
}

void take_numbers(const TagCursor& cursor, const Tag& tag, const std::string_view (&names)[3], Numbers& numbers) {
  numbers.properties.clear();
  for (std::string_view& word : numbers.words) word = {};
  TagAttribute attribute;
  for (std::string_view rest = tag.attributes; cursor.next_attribute(rest, attribute);) {
    const auto* const name = std::find(std::begin(names), std::end(names), attribute.name);
    if (name != std::end(names)) {
      numbers.words[name - std::begin(names)] = attribute.value;
    } else {
      const char* const begin = attribute.name.data();
      numbers.properties.append(" ").append(begin, attribute.value.data() + attribute.value.size() + 1 - begin);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (numbers.words[i].empty()) cursor.fail(tag.begin, "the attribute " + std::string(names[i]) + " is missing");
  }
}

void read(ShapeFile& shape, const std::string& name) { set_layout(shape, Reader(shape, name).run()); }

}  // namespace knead::detail::threemf
