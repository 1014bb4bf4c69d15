// Merges a patch that has changed into its mesh again.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "remesh/patch.h"

namespace knead::detail {

namespace {

// Builds the resulting mesh.
class Assembly {
 public:
  Assembly(const Mesh& before, std::span<const Vec3d> after, const Patch& patch, MorePlaces& places,
           const Progress* progress)
      : before_(before), after_(after), patch_(patch), s_(patch.surface), places_(places), progress_(progress) {
    const std::size_t vertices = before.vertex_count() + s_.vertex_count() - patch.vertex_source.size();
    const std::size_t corners = before.corner_vertex.size() + 3 * (s_.face_count() - patch.triangles.size());
    const std::size_t faces = before.face_count() + s_.face_count();
    mesh().positions.reserve(vertices);
    mesh().corner_vertex.reserve(corners);
    mesh().face_begin.reserve(faces + 1);
    result_.moved.reserve(vertices);
    result_.vertex_source.reserve(vertices);
    result_.face_source.reserve(faces);
    places.after.resize(places.before.size());
    for (std::vector<Vec3d>& list : places.after) list.reserve(vertices);
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
    std::uint32_t first = 0;
    for (std::uint32_t p = 0; p < patch_.vertex_source.size(); ++p) {
      const std::uint32_t v = patch_.vertex_source[p];
      copy_vertices(first, v);
      if (!s_.has(p, kRemoved)) of_mesh_[v] = add_patch_vertex(p, v);
      first = v + 1;
    }
    copy_vertices(first, static_cast<std::uint32_t>(before_.vertex_count()));
    for (auto p = static_cast<std::uint32_t>(patch_.vertex_source.size()); p < s_.vertex_count(); ++p) {
      if (!s_.has(p, kRemoved)) add_patch_vertex(p, kNewVertex);
    }
  }

  // Copies consecutive vertices outside the patch.
  void copy_vertices(std::uint32_t first, std::uint32_t last) {
    if (first == last) return;
    const auto number = static_cast<std::uint32_t>(mesh().positions.size());
    std::iota(of_mesh_.begin() + first, of_mesh_.begin() + last, number);
    mesh().positions.insert(mesh().positions.end(), after_.begin() + first, after_.begin() + last);
    result_.moved.insert(result_.moved.end(), last - first, false);
    result_.vertex_source.resize(number + last - first);
    std::iota(result_.vertex_source.begin() + number, result_.vertex_source.end(), first);
    append_from_mesh(Domain::vertex, first, last);
    for (std::size_t i = 0; i < places_.before.size(); ++i) {
      const auto from = places_.before[i].begin();
      places_.after[i].insert(places_.after[i].end(), from + first, from + last);
    }
  }

  std::uint32_t add_patch_vertex(std::uint32_t p, std::uint32_t source) {
    number_[p] = static_cast<std::uint32_t>(mesh().positions.size());
    mesh().positions.push_back(s_.after[p]);
    result_.moved.push_back(s_.has(p, kMoved));
    result_.vertex_source.push_back(source);
    std::span<const double> rest = append_values(Domain::vertex, s_.vertex_values.of(p));
    for (std::vector<Vec3d>& list : places_.after) {
      list.push_back({rest[0], rest[1], rest[2]});
      rest = rest.subspan(3);
    }
    return number_[p];
  }

  void add_faces() {
    std::size_t triangle = 0;
    std::uint32_t copied = 0;  // faces before it
    while (triangle < patch_.triangles.size()) {
      stop_if_cancelled(progress_);
      const std::uint32_t f = s_.face_source[triangle];
      const std::size_t first = triangle;
      while (triangle < patch_.triangles.size() && s_.face_source[triangle] == f) ++triangle;
      if (before_.face(f).size() > 3 && patch_.equal_to(f).empty() && is_untouched(first, triangle)) continue;
      copy_faces(copied, f);
      copied = f + 1;
      for (std::size_t t = first; t < triangle; ++t) add_triangle(t);
    }
    copy_faces(copied, static_cast<std::uint32_t>(before_.face_count()));
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

  // Copies consecutive faces, except those that are divided as their equal face is.
  void copy_faces(std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t f = first; f < last && !patch_.equal_faces.empty(); ++f) {
      if (patch_.holds_face[f] != 2) continue;
      copy_run(first, f);
      first = f + 1;
    }
    copy_run(first, last);
  }

  void copy_run(std::uint32_t first, std::uint32_t last) {
    if (first == last) return;
    const std::uint32_t begin = before_.face_begin[first];
    const std::uint32_t end = before_.face_begin[last];
    const std::size_t corners = mesh().corner_vertex.size();
    mesh().corner_vertex.resize(corners + end - begin);
    std::transform(before_.corner_vertex.begin() + begin, before_.corner_vertex.begin() + end,
                   mesh().corner_vertex.begin() + static_cast<std::ptrdiff_t>(corners),
                   [&](std::uint32_t v) { return of_mesh_[v]; });
    for (std::uint32_t f = first; f < last; ++f) {
      mesh().face_begin.push_back(static_cast<std::uint32_t>(corners) + before_.face_begin[f + 1] - begin);
      result_.face_source.push_back(f);
    }
    append_from_mesh(Domain::corner, begin, end);
    append_from_mesh(Domain::face, first, last);
  }

  void add_triangle(std::size_t t) {
    if (!s_.is_alive(t)) return;
    const std::uint32_t source = s_.face_source[t];
    add_triangle_of(source, t, 0, false);
    std::size_t row = 0;
    for (const EqualFace& equal : patch_.equal_to(source)) add_triangle_of(equal.other, t, ++row, equal.is_reversed);
  }

  // Adds the triangle as a part of the face `source` of the mesh, with this row of its corners' values.
  void add_triangle_of(std::uint32_t source, std::size_t t, std::size_t row, bool is_reversed) {
    const std::size_t stride = s_.corner_values.stride / patch_.corner_rows;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t c = 3 * t + (is_reversed ? 2 - i : i);
      mesh().corner_vertex.push_back(number_[s_.corner[c]]);
      append_values(Domain::corner, s_.corner_values.of(c).subspan(row * stride));
    }
    mesh().face_begin.push_back(static_cast<std::uint32_t>(mesh().corner_vertex.size()));
    result_.face_source.push_back(source);
    append_from_mesh(Domain::face, source, source + std::size_t{1});
  }

  // Appends the values of consecutive elements.
  void append_from_mesh(Domain domain, std::size_t first, std::size_t last) {
    for (std::size_t k = 0; k < before_.attributes.size(); ++k) {
      const Attribute& from = before_.attributes[k];
      if (from.domain != domain) continue;
      const auto n = static_cast<std::size_t>(from.components);
      const auto begin = from.values.begin();
      std::vector<double>& to = mesh().attributes[k].values;
      to.insert(to.end(), begin + static_cast<std::ptrdiff_t>(first * n),
                begin + static_cast<std::ptrdiff_t>(last * n));
    }
  }

  // Appends the values of the attributes; returns the rest of the row.
  std::span<const double> append_values(Domain domain, std::span<const double> row) {
    for (Attribute& attribute : mesh().attributes) {
      if (attribute.domain != domain) continue;
      const auto n = static_cast<std::size_t>(attribute.components);
      attribute.values.insert(attribute.values.end(), row.begin(), row.begin() + static_cast<std::ptrdiff_t>(n));
      row = row.subspan(n);
    }
    return row;
  }

  const Mesh& before_;
  std::span<const Vec3d> after_;
  const Patch& patch_;
  const Surface& s_;
  MorePlaces& places_;
  const Progress* progress_;
  Remeshed result_;
  std::vector<std::uint32_t> number_;   // of each vertex of the patch: its number in the result
  std::vector<std::uint32_t> of_mesh_;  // of each vertex of the mesh: its number in the result
};

}  // namespace

Remeshed merge_patch(const Mesh& before, std::span<const Vec3d> after, const Patch& patch, MorePlaces& places,
                     const Progress* progress) {
  return Assembly(before, after, patch, places, progress).run();
}

}  // namespace knead::detail
