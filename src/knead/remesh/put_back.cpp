#include <algorithm>

#include "knead/remesh/patch.h"

namespace knead::remesh_detail {

namespace {

// Builds the resulting mesh.
class Assembly {
 public:
  Assembly(const Mesh& before, std::span<const Vec3d> after, const Patch& patch, const Progress* progress)
      : before_(before), after_(after), patch_(patch), s_(patch.surface), progress_(progress) {
    for (const Attribute& attribute : before.attributes) {
      Attribute empty = attribute;
      empty.values.clear();
      mesh().attributes.push_back(std::move(empty));
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

Remeshed put_back(const Mesh& before, std::span<const Vec3d> after, const Patch& patch, const Progress* progress) {
  return Assembly(before, after, patch, progress).run();
}

}  // namespace knead::remesh_detail
