// Takes the part of a mesh that a deformation touches out.
#include "remesh/patch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "remesh/face_samples.h"

namespace knead::detail {

namespace {

// Returns true if a mask holds all vertices of the face.
bool is_held(std::span<const std::uint32_t> face, const RemeshOptions& options) {
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

// Returns true if the face can be cut into triangles with an area. A face around a hole passes the ends of a bridge
// twice; there its triangles meet.
bool is_sound(std::span<const Vec3d> positions, std::span<const std::uint32_t> face) {
  if (face.size() < 3) return false;
  if (!repeats_a_vertex(face)) return true;
  std::vector<Triangle> parts;
  triangulate_polygon(positions, face, parts);
  return std::none_of(parts.begin(), parts.end(), [&](const Triangle& t) {
    return repeats_a_vertex(t) || is_degenerate(positions[t[0]], positions[t[1]], positions[t[2]]);
  });
}

constexpr std::size_t kPatchGrain = 8192;  // faces or vertices that a thread takes at a time

// Returns 1 for each face with a moved vertex.
std::vector<std::uint8_t> touched_faces(const Mesh& before, const std::vector<std::uint8_t>& moved,
                                        const RemeshOptions& options) {
  std::vector<std::uint8_t> touched(before.face_count(), options.whole ? 1 : 0);
  if (options.whole) return touched;
  parallel_for(touched.size(), kPatchGrain, options.threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(options.progress);
    for (std::size_t f = begin; f < end; ++f) {
      for (const std::uint32_t v : before.face(f)) touched[f] |= moved[v];
    }
  });
  return touched;
}

// Returns the triangles of untouched faces that are so large that the deformation may move their inside: each with its
// face, ascending.
std::vector<std::pair<std::uint32_t, Triangle>> large_triangles(const Mesh& before,
                                                                const std::vector<std::uint8_t>& touched,
                                                                const FaceSamples& samples,
                                                                const RemeshOptions& options) {
  std::vector<std::vector<std::pair<std::uint32_t, Triangle>>> of_chunk(touched.size() / kPatchGrain + 1);
  parallel_for(touched.size(), kPatchGrain, options.threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(options.progress);
    std::vector<Triangle> parts;
    for (std::size_t f = begin; f < end; ++f) {
      if (touched[f] != 0 || before.face(f).size() < 3) continue;
      parts.clear();
      triangulate_polygon(before.positions, before.face(f), parts);
      for (const Triangle& t : parts) {
        const auto& p = before.positions;
        if (samples.is_large({p[t[0]], p[t[1]], p[t[2]]})) of_chunk[begin / kPatchGrain].emplace_back(f, t);
      }
    }
  });
  std::vector<std::pair<std::uint32_t, Triangle>> all;
  for (const auto& some : of_chunk) all.insert(all.end(), some.begin(), some.end());
  return all;
}

// Returns 1 for each face of the mesh that the patch holds.
std::vector<std::uint8_t> find_faces(const Mesh& before, const std::vector<std::uint8_t>& moved,
                                     const Deformation& deformation, const RemeshOptions& options) {
  std::vector<std::uint8_t> touched = touched_faces(before, moved, options);
  if (std::isfinite(deformation.feature) && !options.whole) {
    FaceSamples large(deformation, options.progress);
    for (const auto& [f, t] : large_triangles(before, touched, large, options)) {
      const std::array<Vec3d, 3> corners{before.positions[t[0]], before.positions[t[1]], before.positions[t[2]]};
      large.add(f, corners, corners);
    }
    const std::optional<std::vector<std::uint32_t>> deviating =
        large.deviating_faces(0, [](std::uint32_t /*face*/, const Vec3d& deviation) { return norm(deviation); });
    if (!deviating) large.refuse(options.targets.max_vertices);
    for (const std::uint32_t f : *deviating) touched[f] = 1;
  }
  std::vector<std::uint8_t> near(before.vertex_count(), 0);
  for (std::size_t f = 0; f < touched.size(); ++f) {
    if (touched[f] == 0) continue;
    for (const std::uint32_t v : before.face(f)) near[v] = 1;
  }
  std::vector<std::uint8_t> held(touched.size(), 0);
  parallel_for(held.size(), kPatchGrain, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const auto face = before.face(f);
      std::uint8_t is_near = 0;
      for (const std::uint32_t v : face) is_near |= near[v];
      held[f] = is_near != 0 && !is_held(face, options) && is_sound(before.positions, face) ? 1 : 0;
    }
  });
  return held;
}

// The attributes of one kind of element, side by side in a row of values.
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

// Sets the values of vertices, given by their numbers in the mesh: those of the columns, then the further positions.
void take_values(const Columns& columns, const MorePlaces& places, const std::vector<std::uint32_t>& sources,
                 Values& values) {
  values.stride = columns.stride + 3 * places.before.size();
  values.resize(sources.size());
  std::size_t offset = 0;
  for (const Attribute* attribute : columns.attributes) {
    const auto n = static_cast<std::size_t>(attribute->components);
    for (std::size_t i = 0; i < sources.size(); ++i) {
      std::copy_n(attribute->values.begin() + static_cast<std::ptrdiff_t>(sources[i] * n), n,
                  values.of(i).subspan(offset).begin());
    }
    offset += n;
  }
  for (const std::span<const Vec3d> list : places.before) {
    for (std::size_t i = 0; i < sources.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) values.of(i)[offset + axis] = list[sources[i]][axis];
    }
    offset += 3;
  }
}

// Returns the number in the patch of each vertex of the mesh, in the order of the mesh; kNone outside the patch.
std::vector<std::uint32_t> number_vertices(const Mesh& mesh, Patch& patch) {
  std::vector<std::uint32_t> number(mesh.vertex_count(), kNone);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (patch.holds_face[f] == 0) continue;
    for (const std::uint32_t v : mesh.face(f)) number[v] = 0;
  }
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == kNone) continue;
    number[v] = static_cast<std::uint32_t>(patch.vertex_source.size());
    patch.vertex_source.push_back(v);
  }
  return number;
}

// Appends the rows of the corner at v: the row of the face, then those of its equal faces.
void append_corner(const Mesh& mesh, const Columns& columns, std::uint32_t f, std::uint32_t v, Patch& patch) {
  const std::span<const EqualFace> equal = patch.equal_to(f);
  for (std::size_t row = 0; row < patch.corner_rows; ++row) {
    const std::uint32_t of = row == 0 || row > equal.size() ? f : equal[row - 1].other;
    const auto face = mesh.face(of);
    const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin());
    append_row(columns, mesh.face_begin[of] + at, patch.surface.corner_values);
  }
}

void take_faces(const Mesh& mesh, const std::vector<std::uint32_t>& number, const Progress* progress, Patch& patch) {
  Surface& s = patch.surface;
  const Columns columns = columns_of(mesh, Domain::corner);
  s.corner_values.stride = columns.stride * patch.corner_rows;
  const std::size_t held =
      static_cast<std::size_t>(std::count(patch.holds_face.begin(), patch.holds_face.end(), std::uint8_t{1}));
  const std::size_t more = held + held / 8;  // room for splits
  patch.triangles.reserve(held);
  s.face_source.reserve(more);
  s.corner.reserve(3 * more);
  s.opposite.reserve(3 * more);
  s.edge.reserve(3 * more);
  std::vector<Triangle> parts;
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    if (patch.holds_face[f] != 1) continue;
    stop_if_cancelled(progress);
    parts.clear();
    triangulate_polygon(mesh.positions, mesh.face(f), parts);
    for (const Triangle& t : parts) {
      s.face_source.push_back(f);
      patch.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
      s.corner.insert(s.corner.end(), patch.triangles.back().begin(), patch.triangles.back().end());
      if (columns.stride == 0) continue;
      for (const std::uint32_t v : t) append_corner(mesh, columns, f, v, patch);
    }
  }
}

// Returns true if the second face has the vertices of the first in the same cyclic order, taken with this step.
bool is_same_cycle(std::span<const std::uint32_t> face, std::span<const std::uint32_t> other, std::size_t step) {
  const std::size_t n = face.size();
  const auto at = static_cast<std::size_t>(std::find(other.begin(), other.end(), face[0]) - other.begin());
  std::size_t same = 0;
  while (same < n && other.size() == n && at < n && other[(at + same * step) % n] == face[same]) ++same;
  return same == n;
}

// Finds the equal faces of the mesh: among these pairs of triangles, and at edges of more than two faces, where equal
// faces may have been cut into different triangles. Returns false if there are none.
bool find_equal_faces(const Mesh& mesh, const std::vector<std::array<std::uint32_t, 2>>& pairs, Patch& patch) {
  const Surface& s = patch.surface;
  std::vector<std::uint32_t> faces;
  for (const auto& [a, b] : pairs) faces.insert(faces.end(), {s.face_source[a], s.face_source[b]});
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    if (s.has_copies(s.edge[h])) faces.push_back(s.face_source[h / 3]);
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  std::map<std::vector<std::uint32_t>, std::uint32_t> kept;  // the first face with these vertices, which are ascending
  for (const std::uint32_t f : faces) {
    const auto face = mesh.face(f);
    std::vector<std::uint32_t> vertices(face.begin(), face.end());
    std::sort(vertices.begin(), vertices.end());
    const auto [first, is_new] = kept.try_emplace(std::move(vertices), f);
    if (is_new) continue;
    const bool is_reversed = !is_same_cycle(mesh.face(first->second), face, 1);
    if (is_reversed && !is_same_cycle(mesh.face(first->second), face, face.size() - 1)) continue;
    patch.holds_face[f] = 2;
    patch.equal_faces.push_back({first->second, f, is_reversed});
  }
  std::stable_sort(patch.equal_faces.begin(), patch.equal_faces.end(),
                   [](const EqualFace& a, const EqualFace& b) { return a.kept < b.kept; });
  for (const EqualFace& equal : patch.equal_faces) {
    patch.corner_rows = std::max(patch.corner_rows, 1 + patch.equal_to(equal.kept).size());
  }
  return !patch.equal_faces.empty();
}

[[noreturn]] void refuse_overlap(const Surface& s, std::uint32_t triangle, std::uint32_t other) {
  throw InvalidInput(
      fmt::format("faces {} and {} lie on each other with other corners or diagonals, and would cross "
                  "when they are divided; remove one of them",
                  s.face_source[triangle], s.face_source[other]));
}

// Returns true if the faces of two half-edges of one edge lie on each other, within 30 degrees.
bool is_overlap(const Surface& s, std::uint32_t h, std::uint32_t g) {
  constexpr double kOverlapCosine = 0.866;
  const Vec3d& origin = s.before[s.origin(h)];
  const Vec3d along = s.before[s.target(h)] - origin;
  const auto across = [&](std::uint32_t apex) { return cross(along, s.before[apex] - origin); };
  const Vec3d p = across(s.apex(h));
  const Vec3d q = across(s.apex(g));
  return dot(p, q) > kOverlapCosine * norm(p) * norm(q);
}

// Refuses a quadrilateral that is there twice, cut along both diagonals: its triangles would cross when they are
// divided. Each of them then lies, at two of its edges, on triangles with the same third corner.
void refuse_two_diagonals(const Surface& s) {
  std::vector<std::array<std::uint32_t, 3>> overlaps;  // a face, the third corner of another one, and this other one
  for (std::uint32_t e = 0; e < s.next_copy.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    s.for_each_copy(e, [&](std::uint32_t c) {
      const std::uint32_t g = s.halfedge[c];
      if (c != e && is_overlap(s, h, g)) overlaps.push_back({h / 3, s.apex(g), g / 3});
    });
  }
  std::sort(overlaps.begin(), overlaps.end());
  const auto same = [&](std::size_t i, std::size_t k) {
    return k < overlaps.size() && overlaps[i][0] == overlaps[k][0] && overlaps[i][1] == overlaps[k][1];
  };
  for (std::size_t i = 0, end = 0; i < overlaps.size(); i = end) {
    for (end = i + 1; same(i, end);) ++end;
    if (end - i != 2) continue;
    refuse_overlap(s, overlaps[i][0], overlaps[i][2]);
  }
}

// Connects the triangles of the patch. Equal faces are taken once: if each were divided on its own, they would cross.
// Refuses other faces that lie on each other.
void connect_patch(const Mesh& mesh, const std::vector<std::uint32_t>& number, const Progress* progress, Patch& patch) {
  Surface& s = patch.surface;
  std::vector<std::array<std::uint32_t, 2>> equal = connect(s, progress);
  if (find_equal_faces(mesh, equal, patch)) {
    patch.triangles.clear();
    s.corner.clear();
    s.face_source.clear();
    s.corner_values.numbers.clear();
    s.vertex_flags.clear();
    take_faces(mesh, number, progress, patch);
    equal = connect(s, progress);
  }
  for (const auto& [triangle, other] : equal) {
    if (s.face_source[triangle] != s.face_source[other]) refuse_overlap(s, triangle, other);
  }
  refuse_two_diagonals(s);
}

// Returns 1 for each vertex of the patch that a face outside it uses.
std::vector<std::uint8_t> border_of(const Mesh& mesh, const std::vector<std::uint32_t>& number, const Patch& patch,
                                    int threads) {
  std::vector<std::vector<std::uint32_t>> of_chunk(mesh.face_count() / kPatchGrain + 1);
  parallel_for(mesh.face_count(), kPatchGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      if (patch.holds_face[f] != 0) continue;
      for (const std::uint32_t v : mesh.face(f)) {
        if (number[v] != kNone) of_chunk[begin / kPatchGrain].push_back(number[v]);
      }
    }
  });
  std::vector<std::uint8_t> on_border(patch.vertex_source.size(), 0);
  for (const std::vector<std::uint32_t>& vertices : of_chunk) {
    for (const std::uint32_t v : vertices) on_border[v] = 1;
  }
  return on_border;
}

// Fixes vertices that a mask holds or that faces outside the patch use, and locks edges between two of the latter.
void fix_border(const Mesh& mesh, const std::vector<std::uint32_t>& number, const RemeshOptions& options,
                Patch& patch) {
  Surface& s = patch.surface;
  const std::vector<std::uint8_t> on_border = border_of(mesh, number, patch, options.threads);
  for (std::size_t v = 0; v < on_border.size(); ++v) {
    const bool is_held = !options.held.empty() && options.held[patch.vertex_source[v]] != 0;
    if (on_border[v] != 0 || is_held) s.set(static_cast<std::uint32_t>(v), kImmovable);
  }
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    if ((on_border[s.origin(h)] & on_border[s.target(h)]) != 0) s.set_edge(h, kLocked);
  }
}

// Marks the moved vertices and their neighbours as the region to improve, or all vertices if `whole`.
void mark_region(const std::vector<std::uint8_t>& moved, bool whole, Patch& patch) {
  Surface& s = patch.surface;
  for (std::size_t v = 0; v < s.vertex_count(); ++v) {
    if (moved[patch.vertex_source[v]] != 0) s.set(static_cast<std::uint32_t>(v), kMoved);
  }
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    const auto rests = [&](std::uint32_t h) { return !s.has(s.target(h), kMoved) && !s.has(s.apex(h), kMoved); };
    if (whole || s.has(v, kMoved) || !s.all_outgoing(v, rests)) s.set(v, kRegion);
  }
}

}  // namespace

std::span<const EqualFace> Patch::equal_to(std::uint32_t f) const {
  const std::span all(equal_faces);
  const auto range = std::equal_range(all.data(), all.data() + all.size(), EqualFace{f, 0, false},
                                      [](const EqualFace& a, const EqualFace& b) { return a.kept < b.kept; });
  return {range.first, range.second};
}

Patch extract_patch(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                    const RemeshOptions& options, const MorePlaces& places) {
  std::vector<std::uint8_t> moved(before.vertex_count());
  for (std::size_t v = 0; v < moved.size(); ++v) moved[v] = same_bits(before.positions[v], after[v]) ? 0 : 1;
  Patch patch;
  patch.holds_face = find_faces(before, moved, deformation, options);
  stop_if_cancelled(options.progress);
  const std::vector<std::uint32_t> number = number_vertices(before, patch);
  stop_if_cancelled(options.progress);
  Surface& s = patch.surface;
  const std::size_t vertices = patch.vertex_source.size() + patch.vertex_source.size() / 8;  // room for splits
  s.before.reserve(vertices);
  s.after.reserve(vertices);
  for (const std::uint32_t v : patch.vertex_source) {
    s.before.push_back(before.positions[v]);
    s.after.push_back(after[v]);
  }
  const Columns columns = columns_of(before, Domain::vertex);
  take_values(columns, places, patch.vertex_source, s.vertex_values);
  s.has_attributes = columns.stride + columns_of(before, Domain::corner).stride > 0;
  take_faces(before, number, options.progress, patch);
  stop_if_cancelled(options.progress);
  connect_patch(before, number, options.progress, patch);
  stop_if_cancelled(options.progress);
  fix_border(before, number, options, patch);
  stop_if_cancelled(options.progress);
  mark_region(moved, options.whole, patch);
  mark_features(before, options, number, patch);
  return patch;
}

}  // namespace knead::detail
