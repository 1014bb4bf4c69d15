// Writing 3MF: the source's archive with some numbers, or meshes, of its models replaced, or a new file.
#include <algorithm>
#include <array>
#include <charconv>
#include <functional>
#include <map>
#include <optional>
#include <utility>

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

constexpr std::uint32_t kNone = 0xffffffff;
constexpr std::string_view kSlicerParts = "Metadata/Slic3r_PE_model.config";  // numbers the triangles of its volumes

// The instances of each mesh of a part, by their numbers.
std::vector<std::vector<std::size_t>> instances_of(const Layout& layout, std::size_t part) {
  std::vector<std::vector<std::size_t>> result(layout.parts[part].meshes.size());
  for (std::size_t i = 0; i < layout.instances.size(); ++i) {
    if (layout.instances[i].part == part) result[layout.instances[i].mesh].push_back(i);
  }
  return result;
}

// Returns the instance to write for a mesh, if it has changed. Throws InvalidInput for one that is placed several
// times.
template <class HasChanged>
const Instance* changed_instance(const Layout& layout, std::span<const std::size_t> instances, const std::string& id,
                                 const HasChanged& has_changed) {
  const auto found =
      std::find_if(instances.begin(), instances.end(), [&](std::size_t i) { return has_changed(layout.instances[i]); });
  if (found == instances.end()) return nullptr;
  if (instances.size() > 1) {
    throw InvalidInput("object " + in_quotes(id) + " of the 3MF file is placed " + std::to_string(instances.size()) +
                       " times, so that it cannot change at one place; write another format, or make the copies "
                       "objects of their own");
  }
  return &layout.instances[*found];
}

std::string archive_with(const ShapeFile& source,
                         const std::function<std::string(std::size_t part, std::string_view text)>& changed,
                         const std::function<std::string(std::string_view text)>& slicer_parts = {}) {
  const Layout& layout = layout_of<Layout>(source);
  const std::string name = "3mf";
  const zip::Archive archive(source.bytes, name);
  std::vector<std::pair<const zip::Entry*, std::string>> contents;
  for (std::size_t part = 0; part < layout.parts.size(); ++part) {
    std::string text = changed(part, layout.parts[part].text);
    if (text != layout.parts[part].text) contents.emplace_back(archive.find(layout.parts[part].name), std::move(text));
  }
  const zip::Entry* const entry = archive.find(kSlicerParts);
  if (slicer_parts && entry != nullptr) contents.emplace_back(entry, slicer_parts(archive.content(*entry)));
  return archive.with(contents);
}

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d>,
                    const WriteOptions& options) {
  const Layout& layout = layout_of<Layout>(source);
  const auto has_moved = [&](std::size_t v) { return !(positions[v] == source.mesh.positions[v]); };
  return archive_with(source, [&](std::size_t part, std::string_view text) {
    Splice splice(text, options.decimals);
    const auto instances = instances_of(layout, part);
    const std::vector<MeshText>& meshes = layout.parts[part].meshes;
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      const Instance* const instance = changed_instance(layout, instances[m], meshes[m].id, [&](const Instance& i) {
        for (std::size_t v = i.first_vertex; v < i.first_vertex + i.vertices; ++v) {
          if (has_moved(v)) return true;
        }
        return false;
      });
      if (instance == nullptr) continue;
      TagCursor cursor(text.substr(0, meshes[m].vertices_end), source.format, meshes[m].vertices_begin);
      Tag tag;
      Numbers numbers;
      for (std::size_t v = instance->first_vertex; cursor.next(tag);) {
        if (tag.is_end || tag.name != "vertex") continue;
        const std::size_t vertex = v++;
        if (!has_moved(vertex)) continue;
        take_numbers(cursor, tag, kVertexNames, numbers);
        const Vec3d to = instance->placement.inverse_image(positions[vertex]);
        std::array<std::size_t, 3> order{0, 1, 2};  // as they stand in the text
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return numbers.words[a].data() < numbers.words[b].data(); });
        for (const std::size_t axis : order) {
          double from = 0;
          parse_real(numbers.words[axis], from);  // read before: well formed
          splice.replace_coordinate(numbers.words[axis], from, to[axis]);
        }
      }
    }
    return splice.finish();
  });
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  for (const Part& part : layout_of<Layout>(source).parts) {
    for (const MeshText& mesh : part.meshes) {
      TagCursor cursor(std::string_view(part.text).substr(0, mesh.vertices_end), part.name, mesh.vertices_begin);
      Numbers numbers;
      for (Tag tag; cursor.next(tag);) {
        if (tag.is_end || tag.name != "vertex") continue;
        take_numbers(cursor, tag, kVertexNames, numbers);
        for (const std::string_view word : numbers.words) visit(word);
      }
    }
  }
}

// The new meshes of a source.
class MeshWriter {
 public:
  MeshWriter(const NewMesh& shape, const WriteOptions& options)
      : shape_(shape),
        layout_(layout_of<Layout>(shape.source)),
        decimals_(options.decimals),
        new_faces_(shape.face_source, shape.source.mesh.face_count()),
        number_(shape.mesh.vertex_count(), kNone) {}

  std::string run() {
    return archive_with(
        shape_.source, [&](std::size_t part, std::string_view text) { return changed_part(part, text); },
        [&](std::string_view text) { return slicer_parts(text); });
  }

 private:
  bool is_same(std::uint32_t new_face, std::uint32_t old_face) const {
    const auto now = shape_.mesh.face(new_face);
    const auto before = shape_.source.mesh.face(old_face);
    return std::equal(now.begin(), now.end(), before.begin(), before.end(), [&](std::uint32_t a, std::uint32_t b) {
      return shape_.mesh.positions[a] == shape_.source.mesh.positions[b];
    });
  }

  bool has_changed(const Instance& instance) const {
    for (std::uint32_t f = instance.first_face; f < instance.first_face + instance.faces; ++f) {
      const auto faces = new_faces_.of(f);
      if (faces.size() != 1 || !is_same(faces[0], f)) return true;
    }
    return false;
  }

  std::string changed_part(std::size_t part, std::string_view text) {
    Splice splice(text);
    const auto instances = instances_of(layout_, part);
    const std::vector<MeshText>& meshes = layout_.parts[part].meshes;
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      const Instance* const instance =
          changed_instance(layout_, instances[m], meshes[m].id, [&](const Instance& i) { return has_changed(i); });
      if (instance == nullptr) continue;
      if (meshes[m].has_more) {
        throw InvalidInput("object " + in_quotes(meshes[m].id) +
                           " of the 3MF file has parts that number its triangles (sets, beams); write another format, "
                           "or keep the faces");
      }
      const std::string name = layout_.parts[part].name;
      const auto inner = [&](std::size_t begin, std::size_t end) { return text.substr(begin, end - begin); };
      const std::string triangles = triangles_text(text, meshes[m], *instance, name);
      const std::string vertices = vertices_text(text, meshes[m], *instance, name);
      splice.replace_text(inner(meshes[m].vertices_begin, meshes[m].vertices_end), vertices);
      splice.replace_text(inner(meshes[m].triangles_begin, meshes[m].triangles_end), triangles);
    }
    return splice.finish();
  }

  // How the elements between two bytes are spelled: the blanks before the first, its < and name, and the blanks after
  // the last.
  struct Spelling {
    std::string_view gap;
    std::string_view opening;
    std::string_view last_gap;
  };

  static Spelling spelling_of(std::string_view text, std::size_t begin, std::size_t end, const std::string& name,
                              std::string_view element) {
    TagCursor cursor(text.substr(0, end), name, begin);
    Tag first;
    while (cursor.next(first) && (first.is_end || first.name != element)) {
    }
    const std::size_t last = text.rfind('>', end - 1) + 1;
    const auto name_end = static_cast<std::size_t>(first.attributes.data() - text.data());
    const bool is_blank_gap = text.substr(begin, first.begin - begin).find('<') == text.npos;
    return {is_blank_gap ? text.substr(begin, first.begin - begin) : std::string_view("\n"),
            text.substr(first.begin, name_end - first.begin), text.substr(last, end - last)};
  }

  // Numbers the vertices of its new faces, in their order.
  void number_vertices(const Instance& instance) {
    vertices_.clear();
    for (std::uint32_t f = instance.first_face; f < instance.first_face + instance.faces; ++f) {
      for (const std::uint32_t face : new_faces_.of(f)) {
        for (const std::uint32_t v : shape_.mesh.face(face)) vertices_.push_back(v);
      }
    }
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    for (std::size_t i = 0; i < vertices_.size(); ++i) number_[vertices_[i]] = static_cast<std::uint32_t>(i);
  }

  std::string vertices_text(std::string_view text, const MeshText& mesh, const Instance& instance,
                            const std::string& name) const {
    const Spelling spelling = spelling_of(text, mesh.vertices_begin, mesh.vertices_end, name, "vertex");
    std::string result;
    for (const std::uint32_t v : vertices_) {
      const Vec3d p = instance.placement.inverse_image(shape_.mesh.positions[v]);
      result.append(spelling.gap).append(spelling.opening);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        result.append(" ").append(kVertexNames[axis]).append("=\"");
        append_decimals(result, p[axis], decimals_);
        result += '"';
      }
      result += "/>";
    }
    return result.append(spelling.last_gap);
  }

  // A triangle that is another one than its source keeps what holds for all its corners.
  static std::string without_corners(const std::string& properties, const TagCursor& cursor) {
    std::string result;
    TagAttribute attribute;
    for (std::string_view rest = properties; cursor.next_attribute(rest, attribute);) {
      if (attribute.name == "p2" || attribute.name == "p3") continue;
      const char* const begin = attribute.name.data();
      result.append(" ").append(begin, attribute.value.data() + attribute.value.size() + 1 - begin);
    }
    return result;
  }

  std::string triangles_text(std::string_view text, const MeshText& mesh, const Instance& instance,
                             const std::string& name) {
    number_vertices(instance);
    const Spelling spelling = spelling_of(text, mesh.triangles_begin, mesh.triangles_end, name, "triangle");
    TagCursor cursor(text.substr(0, mesh.triangles_end), name, mesh.triangles_begin);
    std::vector<std::uint32_t>& first_new = first_new_[mesh.id];
    std::uint32_t count = 0;
    std::string result;
    Numbers numbers;
    std::uint32_t old_face = instance.first_face;
    for (Tag tag; cursor.next(tag);) {
      if (tag.is_end || tag.name != "triangle") continue;
      take_numbers(cursor, tag, kTriangleNames, numbers);
      first_new.push_back(count);
      for (const std::uint32_t face : new_faces_.of(old_face)) {
        const auto corners = shape_.mesh.face(face);
        for (std::size_t i = 2; i < corners.size(); ++i) {
          Triangle triangle{number_[corners[0]], number_[corners[i - 1]], number_[corners[i]]};
          if (instance.is_mirrored()) std::swap(triangle[1], triangle[2]);
          result.append(spelling.gap).append(spelling.opening);
          for (std::size_t c = 0; c < 3; ++c) {
            result.append(" ").append(kTriangleNames[c]).append("=\"").append(std::to_string(triangle[c])).append("\"");
          }
          const bool keeps = numbers.properties.empty() || is_same(face, old_face);
          result.append(keeps ? numbers.properties : without_corners(numbers.properties, cursor)).append("/>");
          ++count;
        }
      }
      ++old_face;
    }
    first_new.push_back(count);
    return result.append(spelling.last_gap);
  }

  // The table of a slicer, with the new numbers of triangles.
  std::string slicer_parts(std::string_view text) const {
    Splice splice(text);
    const std::string name(kSlicerParts);
    TagCursor cursor(text, name);
    const std::vector<std::uint32_t>* first_new = nullptr;
    for (Tag tag; cursor.next(tag);) {
      if (tag.is_end) continue;
      if (tag.name == "object") {
        const auto found = first_new_.find(std::string(cursor.value(tag, "id")));
        first_new = found == first_new_.end() ? nullptr : &found->second;
      }
      if (tag.name != "volume" || first_new == nullptr) continue;
      TagAttribute attribute;
      for (std::string_view rest = tag.attributes; cursor.next_attribute(rest, attribute);) {
        if (attribute.name != "firstid" && attribute.name != "lastid") continue;
        const std::size_t is_last = attribute.name == "lastid" ? 1 : 0;
        std::size_t old = 0;
        std::from_chars(attribute.value.data(), attribute.value.data() + attribute.value.size(), old);
        if (old + is_last >= first_new->size()) continue;
        splice.replace_text(attribute.value, std::to_string((*first_new)[old + is_last] - is_last));
      }
    }
    return splice.finish();
  }

  const NewMesh& shape_;
  const Layout& layout_;
  std::optional<int> decimals_;
  BySource new_faces_;
  std::vector<std::uint32_t> number_;                            // of a vertex within its object
  std::vector<std::uint32_t> vertices_;                          // of the object that is written
  std::map<std::string, std::vector<std::uint32_t>> first_new_;  // of each triangle, by the object's id
};

std::vector<std::string> remesh_losses(const ShapeFile& source) {
  for (const Part& part : layout_of<Layout>(source).parts) {
    if (part.text.find(" p2=") == part.text.npos) continue;
    return {"colors that differ at the corners of a triangle become one where the triangle is divided"};
  }
  return {};
}

std::vector<std::uint32_t> face_labels(const ShapeFile& source) { return layout_of<Layout>(source).labels; }

// New files.

bool is_color(const Attribute& attribute) {
  return attribute.name == "color" && (attribute.components == 3 || attribute.components == 4);
}

std::string color_text(const Attribute& color, std::size_t element) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  const auto n = static_cast<std::size_t>(color.components);
  std::string text = "#";
  for (std::size_t i = 0; i < n; ++i) {
    const auto byte = static_cast<std::size_t>(as_byte(color.values[element * n + i], color.type));
    text += digits[byte / 16];
    text += digits[byte % 16];
  }
  return text;
}

// The colors of a mesh, each once, and the one of each corner.
struct Colors {
  std::map<std::string, std::size_t> number;
  std::vector<std::size_t> of_corner;

  explicit Colors(const Mesh& mesh) {
    const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(), is_color);
    if (found == mesh.attributes.end()) return;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      for (std::size_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) {
        const std::size_t element = found->domain == Domain::face     ? f
                                    : found->domain == Domain::corner ? c
                                                                      : mesh.corner_vertex[c];
        of_corner.push_back(number.try_emplace(color_text(*found, element), number.size()).first->second);
      }
    }
  }

  std::string text() const {
    std::vector<std::string_view> in_order(number.size());
    for (const auto& [color, place] : number) in_order[place] = color;
    std::string result = "  <m:colorgroup id=\"1\">\n";
    for (const std::string_view color : in_order) {
      result.append("   <m:color color=\"").append(color).append("\"/>\n");
    }
    return result + "  </m:colorgroup>\n";
  }
};

// One object of the triangles of triangulate(), in millimetres.
std::string generate(const Mesh& mesh, const WriteOptions& options) {
  if (mesh.face_count() == 0) throw InvalidInput("3MF cannot hold points without faces; write PLY or XYZ");
  const Colors colors(mesh);
  const bool has_colors = !colors.of_corner.empty();
  std::string model =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<model unit=\"millimeter\" xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"";
  if (has_colors) model += " xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\"";
  model += ">\n <metadata name=\"Application\">Knead</metadata>\n <resources>\n";
  if (has_colors) model += colors.text();
  model += "  <object id=\"2\" type=\"model\"";
  if (has_colors) model += " pid=\"1\" pindex=\"0\"";
  model += ">\n   <mesh>\n    <vertices>\n";
  for (const Vec3d& p : mesh.positions) {
    model += "     <vertex";
    for (std::size_t axis = 0; axis < 3; ++axis) {
      model.append(" ").append(kVertexNames[axis]).append("=\"");
      append_decimals(model, p[axis], options.decimals);
      model += '"';
    }
    model += "/>\n";
  }
  model += "    </vertices>\n    <triangles>\n";
  const std::vector<Triangle> triangles = triangulate(mesh);
  const std::vector<std::uint32_t> faces = triangle_faces(mesh);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    model += "     <triangle";
    for (std::size_t c = 0; c < 3; ++c) {
      model.append(" ").append(kTriangleNames[c]).append("=\"").append(std::to_string(triangles[t][c])).append("\"");
    }
    if (has_colors) model += " pid=\"1\"";
    for (std::size_t c = 0; c < 3 && has_colors; ++c) {
      const auto face = mesh.face(faces[t]);
      const auto corner = std::find(face.begin(), face.end(), triangles[t][c]) - face.begin();
      const std::size_t color = colors.of_corner[mesh.face_begin[faces[t]] + static_cast<std::size_t>(corner)];
      model += " p" + std::to_string(c + 1) + "=\"" + std::to_string(color) + '"';
    }
    model += "/>\n";
  }
  model +=
      "    </triangles>\n   </mesh>\n  </object>\n </resources>\n <build>\n  <item objectid=\"2\"/>\n "
      "</build>\n</model>\n";
  const std::string head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  return zip::archive_of(
      {{"[Content_Types].xml",
        head +
            "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n"
            " <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n"
            " <Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n"
            "</Types>\n"},
       {"_rels/.rels", head + "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n"
                              " <Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" "
                              "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>\n"
                              "</Relationships>\n"},
       {"3D/3dmodel.model", model}});
}

std::vector<std::string> losses(const Mesh& mesh) {
  std::vector<std::string> losses;
  if (mesh.face_count() == 0) losses.emplace_back("3MF cannot hold points without faces");
  std::size_t polygons = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) polygons += mesh.face(f).size() > 3 ? 1 : 0;
  if (polygons > 0) {
    losses.push_back(counted(polygons, "polygon is cut into triangles", "polygons are cut into triangles"));
  }
  for (const Attribute& attribute : mesh.attributes) {
    if (!is_color(attribute)) losses.push_back("3MF cannot hold '" + attribute.name + "'");
  }
  return losses;
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  std::vector<std::string> losses;
  if (layout.instances.size() > 1) {
    losses.push_back("the division into " + std::to_string(layout.instances.size()) + " objects is left out");
  }
  if (layout.has_metadata) losses.emplace_back("metadata is left out");
  return losses;
}

}  // namespace

std::string remeshed(const NewMesh& shape, const WriteOptions& options) { return MeshWriter(shape, options).run(); }

}  // namespace knead::detail::threemf

const knead::detail::Codec knead::detail::threemf_codec{.name = "3mf",
                                                        .read = threemf::read,
                                                        .rewrite = threemf::rewrite,
                                                        .generate = threemf::generate,
                                                        .losses = threemf::losses,
                                                        .source_losses = threemf::source_losses,
                                                        .remeshed = threemf::remeshed,
                                                        .remesh_losses = threemf::remesh_losses,
                                                        .face_labels = threemf::face_labels,
                                                        .needs_faces = true,
                                                        .visit_coordinates = threemf::visit_coordinates};
