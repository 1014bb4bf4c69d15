#include "remesh/patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "remesh/features.h"
#include "remesh/surface.h"

namespace knead::remesh_detail {

namespace {

// Returns whether a mask holds all vertices of the face.
bool stays(std::span<const std::uint32_t> face, const RemeshOptions& options) {
  return !options.held.empty() &&
         std::all_of(face.begin(), face.end(), [&](std::uint32_t v) { return options.held[v] != 0; });
}

bool repeats_a_vertex(std::span<const std::uint32_t> face) {
  for (std::size_t i = 0; i < face.size(); ++i) {
    for (std::size_t j = i + 1; j < face.size(); ++j) {
      if (face[i] == face[j]) return true;
    }
  }
  return false;
}

// Returns whether the face can be cut into triangles with an area. One that runs round a hole passes the ends of a
// bridge twice; there its triangles meet.
bool is_sound(std::span<const Vec3d> positions, std::span<const std::uint32_t> face) {
  if (face.size() < 3) return false;
  if (!repeats_a_vertex(face)) return true;
  std::vector<Triangle> parts;
  triangulate_polygon(positions, face, parts);
  return std::none_of(parts.begin(), parts.end(), [&](const Triangle& t) {
    return repeats_a_vertex(t) || is_degenerate(positions[t[0]], positions[t[1]], positions[t[2]]);
  });
}

// Returns a flag for each face of the mesh: true if the patch holds it.
std::vector<bool> find_faces(const Mesh& before, const std::vector<bool>& moved, const Deformation& deformation,
                             const RemeshOptions& options) {
  const bool whole = options.whole;
  const std::size_t faces = before.face_count();
  std::vector<bool> touched(faces, whole);
  FaceSamples large(deformation, options.progress);
  const bool search = std::isfinite(deformation.feature) && !whole;
  std::vector<Triangle> parts;
  for (std::size_t f = 0; f < faces && !whole; ++f) {
    stop_if_cancelled(options.progress);
    const auto face = before.face(f);
    touched[f] = std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return moved[v]; });
    if (touched[f] || !search || face.size() < 3) continue;
    parts.clear();
    triangulate_polygon(before.positions, face, parts);
    for (const Triangle& t : parts) {
      const std::array<Vec3d, 3> corners{before.positions[t[0]], before.positions[t[1]], before.positions[t[2]]};
      large.add(static_cast<std::uint32_t>(f), corners, corners);
    }
  }
  const std::optional<std::vector<std::uint32_t>> deviating = large.deviating_faces(0);
  if (!deviating) large.refuse(options.targets.max_vertices);
  for (const std::uint32_t f : *deviating) touched[f] = true;
  std::vector<bool> near(before.vertex_count(), false);
  for (std::size_t f = 0; f < faces; ++f) {
    if (!touched[f]) continue;
    for (const std::uint32_t v : before.face(f)) near[v] = true;
  }
  std::vector<bool> held(faces, false);
  for (std::size_t f = 0; f < faces; ++f) {
    const auto face = before.face(f);
    const bool is_near = std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return near[v]; });
    held[f] = is_near && !stays(face, options) && is_sound(before.positions, face);
  }
  return held;
}

struct Columns {
  std::vector<const Attribute*> attributes;
  std::size_t stride = 0;
};

Columns columns_of(const Mesh& mesh, Domain domain) {
  Columns columns;
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain != domain) continue;
    columns.attributes.push_back(&attribute);
    columns.stride += static_cast<std::size_t>(attribute.components);
  }
  return columns;
}

void append_row(const Columns& columns, std::size_t element, Values& values) {
  for (const Attribute* attribute : columns.attributes) {
    const auto n = static_cast<std::size_t>(attribute->components);
    const auto from = attribute->values.begin() + static_cast<std::ptrdiff_t>(element * n);
    values.numbers.insert(values.numbers.end(), from, from + static_cast<std::ptrdiff_t>(n));
  }
}

// Returns the number in the patch of each vertex of the mesh, in the order of the mesh; kNone outside the patch.
std::vector<std::uint32_t> number_vertices(const Mesh& mesh, Patch& patch) {
  std::vector<std::uint32_t> number(mesh.vertex_count(), kNone);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (!patch.holds_face[f]) continue;
    for (const std::uint32_t v : mesh.face(f)) number[v] = 0;
  }
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == kNone) continue;
    number[v] = static_cast<std::uint32_t>(patch.vertex_source.size());
    patch.vertex_source.push_back(v);
  }
  return number;
}

void take_faces(const Mesh& mesh, const std::vector<std::uint32_t>& number, const Progress* progress, Patch& patch) {
  Surface& s = patch.surface;
  const Columns columns = columns_of(mesh, Domain::corner);
  s.corner_values.stride = columns.stride;
  std::vector<Triangle> parts;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    stop_if_cancelled(progress);
    if (!patch.holds_face[f]) continue;
    const auto face = mesh.face(f);
    parts.clear();
    triangulate_polygon(mesh.positions, face, parts);
    for (const Triangle& t : parts) {
      s.face_source.push_back(static_cast<std::uint32_t>(f));
      patch.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
      for (const std::uint32_t v : t) {
        s.corner.push_back(number[v]);
        const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin());
        append_row(columns, mesh.face_begin[f] + at, s.corner_values);
      }
    }
  }
}

// Fixes vertices that faces outside the patch use, and locks edges between two of them. Fixes those that are held.
void fix_border(const Mesh& mesh, const std::vector<std::uint32_t>& number, std::span<const std::uint8_t> held,
                Patch& patch) {
  Surface& s = patch.surface;
  std::vector<bool> on_border(s.vertex_count(), false);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (patch.holds_face[f]) continue;
    for (const std::uint32_t v : mesh.face(f)) {
      if (number[v] != kNone) on_border[number[v]] = true;
    }
  }
  for (std::size_t v = 0; v < on_border.size(); ++v) {
    const bool is_held = !held.empty() && held[patch.vertex_source[v]] != 0;
    if (on_border[v] || is_held) s.set(static_cast<std::uint32_t>(v), kFixed);
  }
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    if (on_border[s.origin(h)] && on_border[s.target(h)]) s.set_edge(h, kLocked);
  }
}

// Marks the moved vertices and their neighbours as the region to improve, or all vertices if `whole`.
void mark_region(const std::vector<bool>& moved, bool whole, Patch& patch) {
  Surface& s = patch.surface;
  for (std::size_t v = 0; v < s.vertex_count(); ++v) {
    if (moved[patch.vertex_source[v]]) s.set(static_cast<std::uint32_t>(v), kMoved);
  }
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    bool in_region = whole || s.has(v, kMoved);
    s.for_each_outgoing(
        v, [&](std::uint32_t h) { in_region = in_region || s.has(s.target(h), kMoved) || s.has(s.apex(h), kMoved); });
    if (in_region) s.set(v, kRegion);
  }
}

}  // namespace

Patch extract_patch(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                    const RemeshOptions& options) {
  std::vector<bool> moved(before.vertex_count());
  for (std::size_t v = 0; v < moved.size(); ++v) moved[v] = !same_bits(before.positions[v], after[v]);
  Patch patch;
  patch.holds_face = find_faces(before, moved, deformation, options);
  stop_if_cancelled(options.progress);
  const std::vector<std::uint32_t> number = number_vertices(before, patch);
  stop_if_cancelled(options.progress);
  Surface& s = patch.surface;
  const Columns columns = columns_of(before, Domain::vertex);
  s.vertex_values.stride = columns.stride;
  for (const std::uint32_t v : patch.vertex_source) {
    s.before.push_back(before.positions[v]);
    s.after.push_back(after[v]);
    append_row(columns, v, s.vertex_values);
  }
  take_faces(before, number, options.progress, patch);
  stop_if_cancelled(options.progress);
  connect(s, options.progress);
  stop_if_cancelled(options.progress);
  fix_border(before, number, options.held, patch);
  stop_if_cancelled(options.progress);
  mark_region(moved, options.whole, patch);
  mark_features(before, options, number, patch);
  return patch;
}

namespace {

// The half-edges sorted by their smaller vertex: those of v are [begin[v], begin[v + 1]).
struct Buckets {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> halfedges;
};

Buckets bucket_halfedges(const Surface& s) {
  Buckets buckets;
  buckets.begin.assign(s.vertex_count() + 1, 0);
  buckets.halfedges.resize(s.corner.size());
  const auto low = [&](std::uint32_t h) { return std::min(s.origin(h), s.target(h)); };
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) ++buckets.begin[low(h) + std::size_t{1}];
  for (std::size_t v = 0; v < s.vertex_count(); ++v) buckets.begin[v + 1] += buckets.begin[v];
  std::vector<std::uint32_t> at(buckets.begin.begin(), buckets.begin.end() - 1);
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) buckets.halfedges[at[low(h)]++] = h;
  return buckets;
}

std::uint32_t add_edge(Surface& s, std::uint8_t flags, std::uint32_t h) {
  s.edge[h] = static_cast<std::uint32_t>(s.halfedge.size());
  s.halfedge.push_back(h);
  s.edge_flags.push_back(flags);
  return s.edge[h];
}

// Makes the edge or edges that these half-edges form.
void join_uses(Surface& s, std::span<const std::uint32_t> uses) {
  if (uses.size() == 2 && s.origin(uses[0]) == s.target(uses[1])) {
    const std::uint32_t edge = add_edge(s, 0, uses[0]);
    s.edge[uses[1]] = edge;
    s.opposite[uses[0]] = uses[1];
    s.opposite[uses[1]] = uses[0];
    return;
  }
  const int flags = uses.size() == 1 ? kFeature | kBoundary : kFeature | kLocked;
  for (const std::uint32_t h : uses) {
    add_edge(s, static_cast<std::uint8_t>(flags), h);
    if (uses.size() == 1) return;
    s.set(s.origin(h), kFixed);
    s.set(s.target(h), kFixed);
  }
}

void join_halfedges(Surface& s, const Progress* progress) {
  const Buckets buckets = bucket_halfedges(s);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sorted;  // larger vertex, half-edge
  std::vector<std::uint32_t> uses;
  for (std::size_t v = 0; v < s.vertex_count(); ++v) {
    stop_if_cancelled(progress);
    sorted.clear();
    for (std::size_t i = buckets.begin[v]; i < buckets.begin[v + 1]; ++i) {
      const std::uint32_t h = buckets.halfedges[i];
      sorted.emplace_back(std::max(s.origin(h), s.target(h)), h);
    }
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < sorted.size();) {
      uses.clear();
      const std::uint32_t high = sorted[i].first;
      for (; i < sorted.size() && sorted[i].first == high; ++i) uses.push_back(sorted[i].second);
      join_uses(s, uses);
    }
  }
}

// Fixes the vertices whose faces form more than one fan.
void fix_pinched(Surface& s) {
  std::vector<std::uint32_t> faces(s.vertex_count(), 0);
  for (const std::uint32_t v : s.corner) ++faces[v];
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (s.outgoing[v] == kNone) continue;
    std::uint32_t in_fan = 0;
    s.for_each_outgoing(v, [&](std::uint32_t) { ++in_fan; });
    if (in_fan != faces[v]) s.set(v, kFixed);
  }
}

}  // namespace

void connect(Surface& s, const Progress* progress) {
  s.opposite.assign(s.corner.size(), kNone);
  s.edge.assign(s.corner.size(), kNone);
  s.halfedge.clear();
  s.edge_flags.clear();
  s.outgoing.assign(s.vertex_count(), kNone);
  s.vertex_flags.resize(s.vertex_count(), 0);
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) s.outgoing[s.corner[h]] = h;
  join_halfedges(s, progress);
  stop_if_cancelled(progress);
  fix_pinched(s);
}

namespace {

// Builds the resulting mesh.
class Assembly {
 public:
  Assembly(const Mesh& before, std::span<const Vec3d> after, const Patch& patch, const Progress* progress)
      : before_(before), after_(after), patch_(patch), s_(patch.surface), progress_(progress) {
    const std::size_t vertices = before.vertex_count() + s_.vertex_count() - patch.vertex_source.size();
    const std::size_t corners = before.corner_vertex.size() + 3 * (s_.face_count() - patch.triangles.size());
    const std::size_t faces = before.face_count() + s_.face_count();
    mesh().positions.reserve(vertices);
    mesh().corner_vertex.reserve(corners);
    mesh().face_begin.reserve(faces + 1);
    result_.moved.reserve(vertices);
    result_.vertex_source.reserve(vertices);
    result_.face_source.reserve(faces);
    for (const Attribute& attribute : before.attributes) {
      const std::size_t count = attribute.domain == Domain::vertex   ? vertices
                                : attribute.domain == Domain::corner ? corners
                                                                     : faces;
      mesh().attributes.push_back({attribute.name, attribute.domain, attribute.type, attribute.components, {}});
      mesh().attributes.back().values.reserve(count * static_cast<std::size_t>(attribute.components));
    }
  }

  Remeshed run() {
    add_vertices();
    add_faces();
    add_creases();
    return std::move(result_);
  }

 private:
  Mesh& mesh() { return result_.mesh; }

  void add_vertices() {
    number_.assign(s_.vertex_count(), kNone);
    of_mesh_.assign(before_.vertex_count(), kNone);
    std::uint32_t in_patch = 0;
    for (std::uint32_t v = 0; v < before_.vertex_count(); ++v) {
      const bool is_held = in_patch < patch_.vertex_source.size() && patch_.vertex_source[in_patch] == v;
      if (!is_held) {
        of_mesh_[v] = static_cast<std::uint32_t>(mesh().positions.size());
        mesh().positions.push_back(after_[v]);
        result_.moved.push_back(false);
        result_.vertex_source.push_back(v);
        append_from_mesh(Domain::vertex, v);
        continue;
      }
      const std::uint32_t p = in_patch++;
      if (!s_.has(p, kRemoved)) of_mesh_[v] = add_patch_vertex(p, v);
    }
    for (; in_patch < s_.vertex_count(); ++in_patch) {
      if (!s_.has(in_patch, kRemoved)) add_patch_vertex(in_patch, kNewVertex);
    }
  }

  std::uint32_t add_patch_vertex(std::uint32_t p, std::uint32_t source) {
    number_[p] = static_cast<std::uint32_t>(mesh().positions.size());
    mesh().positions.push_back(s_.after[p]);
    result_.moved.push_back(s_.has(p, kMoved));
    result_.vertex_source.push_back(source);
    append_values(Domain::vertex, s_.vertex_values.of(p));
    return number_[p];
  }

  void add_faces() {
    std::size_t triangle = 0;
    for (std::uint32_t f = 0; f < before_.face_count(); ++f) {
      stop_if_cancelled(progress_);
      const std::size_t first = triangle;
      while (triangle < patch_.triangles.size() && s_.face_source[triangle] == f) ++triangle;
      if (!patch_.holds_face[f] || (before_.face(f).size() > 3 && is_untouched(first, triangle))) {
        copy_face(f);
        continue;
      }
      for (std::size_t t = first; t < triangle; ++t) add_triangle(t);
    }
    for (; triangle < s_.face_count(); ++triangle) add_triangle(triangle);
  }

  void add_creases() {
    const auto add = [&](std::uint32_t a, std::uint32_t b) {
      result_.creases.push_back({std::min(a, b), std::max(a, b)});
    };
    for (const auto& [a, b] : patch_.other_creases) add(of_mesh_[a], of_mesh_[b]);
    for (std::size_t e = 0; e < s_.halfedge.size(); ++e) {
      const std::uint32_t h = s_.halfedge[e];
      if (h != kNone && (s_.edge_flags[e] & kCrease) != 0) add(number_[s_.origin(h)], number_[s_.target(h)]);
    }
    std::sort(result_.creases.begin(), result_.creases.end());
  }

  bool is_untouched(std::size_t first, std::size_t last) const {
    for (std::size_t t = first; t < last; ++t) {
      if (!patch_.is_unchanged(t)) return false;
      for (const std::uint32_t v : s_.triangle(t)) {
        if (s_.after[v] != before_.positions[patch_.vertex_source[v]]) return false;
      }
    }
    return true;
  }

  void copy_face(std::uint32_t f) {
    for (std::uint32_t c = before_.face_begin[f]; c < before_.face_begin[f + 1]; ++c) {
      mesh().corner_vertex.push_back(of_mesh_[before_.corner_vertex[c]]);
      append_from_mesh(Domain::corner, c);
    }
    end_face(f);
  }

  void add_triangle(std::size_t t) {
    if (!s_.is_alive(t)) return;
    for (std::size_t c = 3 * t; c < 3 * t + 3; ++c) {
      mesh().corner_vertex.push_back(number_[s_.corner[c]]);
      append_values(Domain::corner, s_.corner_values.of(c));
    }
    end_face(s_.face_source[t]);
  }

  void end_face(std::uint32_t source) {
    mesh().face_begin.push_back(static_cast<std::uint32_t>(mesh().corner_vertex.size()));
    result_.face_source.push_back(source);
    append_from_mesh(Domain::face, source);
  }

  void append_from_mesh(Domain domain, std::size_t element) {
    for (std::size_t k = 0; k < before_.attributes.size(); ++k) {
      const Attribute& from = before_.attributes[k];
      if (from.domain != domain) continue;
      const auto n = static_cast<std::size_t>(from.components);
      const auto begin = from.values.begin() + static_cast<std::ptrdiff_t>(element * n);
      std::vector<double>& to = mesh().attributes[k].values;
      to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(n));
    }
  }

  void append_values(Domain domain, std::span<const double> row) {
    for (Attribute& attribute : mesh().attributes) {
      if (attribute.domain != domain) continue;
      const auto n = static_cast<std::size_t>(attribute.components);
      attribute.values.insert(attribute.values.end(), row.begin(), row.begin() + static_cast<std::ptrdiff_t>(n));
      row = row.subspan(n);
    }
  }

  const Mesh& before_;
  std::span<const Vec3d> after_;
  const Patch& patch_;
  const Surface& s_;
  const Progress* progress_;
  Remeshed result_;
  std::vector<std::uint32_t> number_;   // of each vertex of the patch: its number in the result
  std::vector<std::uint32_t> of_mesh_;  // of each vertex of the mesh: its number in the result
};

}  // namespace

Remeshed merge_patch(const Mesh& before, std::span<const Vec3d> after, const Patch& patch, const Progress* progress) {
  return Assembly(before, after, patch, progress).run();
}

}  // namespace knead::remesh_detail
