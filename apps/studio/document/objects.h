// The objects of a document: shapes that one session moves together. The history treats them as one shape.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knead/editor/shape_state.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::studio {

// A shape as it was opened, and whether it is seen.
struct DocumentObject {
  std::string name;                         // for people: that of its file
  std::filesystem::path path;               // empty: the shape was made, or recovered
  std::shared_ptr<const ShapeFile> source;  // never null
  bool is_visible = true;
};

// The list of them.
struct DocumentObjects {
  std::vector<DocumentObject> list;            // empty: no shape is open
  std::optional<std::size_t> active;           // the only one that the pointer meets; nothing: all that are visible
  std::shared_ptr<const JoinedMeshes> joined;  // of all; null while there is one
  // For each face of mesh() whether it is hidden; null: none is. Hidden faces are neither drawn nor met by the pointer;
  // strokes move them.
  std::shared_ptr<const std::vector<bool>> hidden;

  // Returns the shape that the history moves. The list must not be empty.
  const Mesh& mesh() const { return joined != nullptr ? joined->mesh() : list.front().source->mesh; }

  // Returns whether two documents show, and let the pointer meet, the same objects.
  bool is_seen_as(const DocumentObjects& other) const;
  // Returns whether the pointer meets everything.
  bool are_all_met() const;
};

// Sets `joined`. Throws InvalidInput if a point cloud is among several shapes, or they have too many vertices.
void join(DocumentObjects& objects);

// Returns the labels that keep lines between groups of faces (knead/io.h), of all objects.
std::vector<std::uint32_t> face_labels(const DocumentObjects& objects);

// Returns for each face of a state whether the pointer meets it; empty: all.
std::vector<bool> met_faces(const DocumentObjects& objects, const ShapeState& state);

// Returns the shape in a state with the faces of visible objects that are not hidden, and all vertices. Attributes are
// those of the only object, of vertices alone where faces are hidden; of several there are none.
Mesh visible_mesh(const DocumentObjects& objects, const ShapeState& state);

// Returns the active object in a state as a shape of its own; the whole if there is none.
Mesh active_mesh(const DocumentObjects& objects, const ShapeState& state);

// Returns the file of an object if all are exported to `path`: with its name, unless it is the only one.
std::filesystem::path path_of_object(const DocumentObjects& objects, std::size_t number,
                                     const std::filesystem::path& path);

}  // namespace knead::studio
