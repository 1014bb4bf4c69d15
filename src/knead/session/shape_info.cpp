#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "knead/io/json.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/report.h"

namespace knead {

namespace {

Json json_of(const Vec3d& v) { return std::vector<Json>{v.x, v.y, v.z}; }

Json json_of(const ShapeInfo& info) {
  const Measures& m = info.measures;
  const bool has_volume = m.closed() && m.oriented();
  Json json;
  json.set("format", info.format.empty() ? Json() : Json(info.format));
  json.set("vertices", m.vertices);
  json.set("faces", m.faces);
  json.set("triangles", m.triangles);
  json.set("closed", m.closed());
  json.set("manifold", m.manifold());
  json.set("oriented", m.oriented());
  json.set("components", m.components);
  json.set("boundary_loops", m.boundary_loops);
  json.set("euler", m.euler);
  json.set("volume", has_volume ? Json(m.volume) : Json());
  json.set("area", m.area);
  json.set("box_min", json_of(m.box.min));
  json.set("box_max", json_of(m.box.max));
  json.set("diagonal", m.box.diagonal());
  json.set("attributes", info.attributes);
  json.set("notes", info.notes);
  return json;
}

std::size_t count_repeated(std::vector<Vec3d> positions) {
  const auto key = [](const Vec3d& p) { return std::array{p.x, p.y, p.z}; };
  std::sort(positions.begin(), positions.end(), [&](const Vec3d& a, const Vec3d& b) { return key(a) < key(b); });
  std::size_t repeated = 0;
  for (std::size_t i = 1; i < positions.size(); ++i) repeated += positions[i] == positions[i - 1] ? 1 : 0;
  return repeated;
}

}  // namespace

ShapeInfo describe(const Mesh& mesh) {
  ShapeInfo info;
  info.measures = measure(mesh);
  for (const Attribute& attribute : mesh.attributes) info.attributes.push_back(attribute.name);
  info.notes = describe_oddities(info.measures);
  return info;
}

ShapeInfo describe(const ShapeFile& file) {
  ShapeInfo info = describe(file.mesh);
  info.format = file.format;
  info.notes.insert(info.notes.begin(), file.notes.begin(), file.notes.end());
  return info;
}

SurfaceCheck check_surface(const Mesh& mesh, ShapeInfo info, const Progress* progress) {
  SurfaceCheck check;
  check.self_intersections = self_intersections(triangulate(mesh), mesh.positions, {.progress = progress});
  check.folded_edges = count_folded_edges(mesh);
  const std::size_t count = check.self_intersections.count;
  if (!check.self_intersections.complete) {
    info.notes.push_back(fmt::format("more than {} pairs of triangles intersect; the count stops there", count));
  }
  const std::size_t repeated = count > 0 ? count_repeated(mesh.positions) : 0;
  if (repeated > 0) {
    info.notes.push_back(
        fmt::format("{} vertices share their position with another one, as along seams; triangles that touch there "
                    "count as intersecting",
                    repeated));
  }
  check.info = std::move(info);
  return check;
}

std::string to_json(const ShapeInfo& info) { return to_indented_text(json_of(info)); }

std::string to_json(const ShapeSummary& summary) {
  return to_indented_text(Json{{"format", summary.format},
                               {"vertices", summary.vertices},
                               {"faces", summary.faces},
                               {"triangles", summary.triangles},
                               {"box_min", json_of(summary.box.min)},
                               {"box_max", json_of(summary.box.max)},
                               {"diagonal", summary.box.diagonal()},
                               {"attributes", summary.attributes},
                               {"notes", summary.notes}});
}

std::string to_json(const SurfaceCheck& check) {
  const Measures& m = check.info.measures;
  Json json = json_of(check.info);
  json.set("boundary_edges", m.boundary_edges);
  json.set("nonmanifold_edges", m.nonmanifold_edges);
  json.set("nonmanifold_vertices", m.nonmanifold_vertices);
  json.set("misoriented_edges", m.misoriented_edges);
  json.set("self_intersections", check.self_intersections.count);
  json.set("degenerate_triangles", m.degenerate_triangles);
  json.set("smallest_angle_deg", m.smallest_angle_deg);
  json.set("folded_edges", check.folded_edges);
  json.set("flipped_triangles", check.flipped_triangles);
  return to_indented_text(json);
}

}  // namespace knead
