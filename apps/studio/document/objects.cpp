// Objects of a document: which faces are whose, and which are shown.
#include "document/objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "document/document.h"
#include "knead/error.h"
#include "knead/io.h"

namespace knead::studio {

namespace {

std::uint32_t source_of(const ShapeState& state, std::uint32_t face) {
  return state.provenance != nullptr ? state.provenance->face_source[face] : face;
}

// Returns for each face of a state whether it is not hidden, and its object is chosen.
template <class Chosen>
std::vector<bool> faces_of(const DocumentObjects& objects, const ShapeState& state, const Chosen& is_chosen) {
  std::vector<bool> faces(state.mesh->face_count());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    const std::uint32_t source = source_of(state, f);
    const bool is_hidden = objects.hidden != nullptr && (*objects.hidden)[source];
    faces[f] = !is_hidden && is_chosen(objects.joined != nullptr ? objects.joined->part_of_face(source) : 0);
  }
  return faces;
}

bool are_all_visible(const DocumentObjects& objects) {
  return std::all_of(objects.list.begin(), objects.list.end(), [](const DocumentObject& o) { return o.is_visible; });
}

Mesh with_faces(const Mesh& mesh, const std::vector<bool>& faces) {
  Mesh result;
  result.positions = mesh.positions;
  std::copy_if(mesh.attributes.begin(), mesh.attributes.end(), std::back_inserter(result.attributes),
               [](const Attribute& attribute) { return attribute.domain == Domain::vertex; });
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    if (!faces[f]) continue;
    const auto face = mesh.face(f);
    result.corner_vertex.insert(result.corner_vertex.end(), face.begin(), face.end());
    result.face_begin.push_back(static_cast<std::uint32_t>(result.corner_vertex.size()));
  }
  return result;
}

}  // namespace

bool DocumentObjects::is_seen_as(const DocumentObjects& other) const {
  return joined == other.joined && active == other.active && hidden == other.hidden &&
         std::equal(list.begin(), list.end(), other.list.begin(), other.list.end(),
                    [](const DocumentObject& a, const DocumentObject& b) { return a.is_visible == b.is_visible; });
}

bool DocumentObjects::are_all_met() const {
  return hidden == nullptr && (joined == nullptr || (!active && are_all_visible(*this)));
}

void join(DocumentObjects& objects) {
  objects.joined.reset();
  if (objects.list.size() < 2) return;
  std::vector<const Mesh*> meshes;
  for (const DocumentObject& object : objects.list) {
    if (object.source->mesh.face_count() == 0) {
      throw InvalidInput(fmt::format(
          "{}: a point cloud cannot be one of several objects; open it alone, or take a mesh", object.name));
    }
    meshes.push_back(&object.source->mesh);
  }
  objects.joined = std::make_shared<const JoinedMeshes>(meshes);
}

std::vector<std::uint32_t> face_labels(const DocumentObjects& objects) {
  if (objects.joined == nullptr) return knead::face_labels(*objects.list.front().source);
  std::vector<std::uint32_t> all;
  bool has_labels = false;
  for (const DocumentObject& object : objects.list) {
    std::vector<std::uint32_t> labels = knead::face_labels(*object.source);
    has_labels = has_labels || !labels.empty();
    labels.resize(object.source->mesh.face_count());
    all.insert(all.end(), labels.begin(), labels.end());
  }
  return has_labels ? all : std::vector<std::uint32_t>{};
}

std::vector<bool> met_faces(const DocumentObjects& objects, const ShapeState& state) {
  if (objects.are_all_met()) return {};
  return faces_of(objects, state, [&](std::size_t number) {
    return objects.list[number].is_visible && objects.active.value_or(number) == number;
  });
}

Mesh visible_mesh(const DocumentObjects& objects, const ShapeState& state) {
  Mesh mesh = state.to_mesh();
  if (objects.joined != nullptr) mesh.attributes.clear();
  if (objects.hidden == nullptr && (objects.joined == nullptr || are_all_visible(objects))) return mesh;
  return with_faces(mesh,
                    faces_of(objects, state, [&](std::size_t number) { return objects.list[number].is_visible; }));
}

Mesh active_mesh(const DocumentObjects& objects, const ShapeState& state) {
  Mesh mesh = state.to_mesh();
  if (objects.joined == nullptr || !objects.active) return mesh;
  std::vector<std::uint32_t> faces(mesh.face_count());
  std::vector<std::uint32_t> vertices(mesh.vertex_count());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    faces[f] = state.provenance != nullptr ? state.provenance->face_source[f] : f;
  }
  for (std::uint32_t v = 0; v < vertices.size(); ++v) {
    vertices[v] = state.provenance != nullptr ? state.provenance->vertex_source[v] : v;
  }
  return objects.joined->part_of(*objects.active, mesh, faces, vertices).mesh;
}

std::filesystem::path path_of_object(const DocumentObjects& objects, std::size_t number,
                                     const std::filesystem::path& path) {
  if (objects.joined == nullptr) return path;
  const auto stem_of = [](const DocumentObject& object) { return std::filesystem::path(object.name).stem().string(); };
  std::string name = stem_of(objects.list[number]);
  const auto namesakes = std::count_if(objects.list.begin(), objects.list.end(),
                                       [&](const DocumentObject& object) { return stem_of(object) == name; });
  if (namesakes > 1) name += fmt::format("_{}", number + 1);
  return path.parent_path() / fmt::format("{}_{}{}", path.stem().string(), name, path.extension().string());
}

DocumentObject read_object(const std::filesystem::path& path) {
  return {path.filename().string(), path, std::make_shared<const ShapeFile>(read_shape(path))};
}

// --- what the document does with them
// -----------------------------------------------------------------------------------

void Document::show_object(std::size_t object, bool is_visible) {
  if (!history_ || object >= shown_.objects.list.size()) return;
  shown_.objects.list[object].is_visible = is_visible;
  see_objects();
}

void Document::make_active(std::optional<std::size_t> object) {
  if (!history_ || object.value_or(0) >= shown_.objects.list.size()) return;
  shown_.objects.active = object;
  see_objects();
}

// A face as it was opened is hidden where all that became of it is.
void Document::hide_faces(const MaskValues& mask, bool masked) {
  if (!history_) return;
  constexpr std::uint8_t half = 128;
  const ShapeState& state = history_->state();
  const Mesh& mesh = *state.mesh;
  std::vector<bool> hidden(shown_.objects.mesh().face_count());
  if (shown_.objects.hidden != nullptr) hidden = *shown_.objects.hidden;
  std::vector<bool> chosen(hidden.size());
  std::vector<bool> stays(hidden.size());
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const bool is_masked =
        std::all_of(face.begin(), face.end(), [&](std::uint32_t v) { return v < mask.size() && mask[v] >= half; });
    (is_masked == masked ? chosen : stays)[source_of(state, f)] = true;
  }
  bool is_any_left = false;
  for (std::size_t f = 0; f < hidden.size(); ++f) {
    hidden[f] = hidden[f] || (chosen[f] && !stays[f]);
    is_any_left = is_any_left || !hidden[f];
  }
  if (!is_any_left) return options_.tell({false, "Nothing would be left to see: mask a part first."});
  shown_.objects.hidden = std::make_shared<const std::vector<bool>>(std::move(hidden));
  see_objects();
}

void Document::show_all_faces() {
  if (!history_ || shown_.objects.hidden == nullptr) return;
  shown_.objects.hidden.reset();
  see_objects();
}

// Renews the picker after the set of pickable objects has changed.
void Document::see_objects() {
  guarded(Subject::other, [&] {
    pickers_ = {};
    shown_.picker = pickers_.make(history_->state(), met_faces(shown_.objects, history_->state()));
    picker_is_stale_ = false;
    show();
  });
}

}  // namespace knead::studio
