// Measures Knead's strokes against the brushes that people would use instead.
#include "comparisons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <span>

#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "scenes.h"
#include "yardsticks.h"

namespace knead::command {
namespace {

// Crossings are counted up to this number, which takes some seconds at most.
constexpr SelfIntersectionOptions kCount{.threads = 0, .limit = 1'000'000};

// The brush as wide as ours: straight ahead of the tip ours moves by half where the weight is one half, a Kelvinlet
// where eps/R is, at sqrt(3) eps.
double comparable_epsilon(const ImplicitStroke& stroke) {
  return (stroke.inner + kCenterFraction * (stroke.outer - stroke.inner)) / std::sqrt(3.0);
}

double motion_beyond(const PeerScene& scene, const std::vector<Vec3d>& moved) {
  const std::vector<Vec3d>& path = scene.stroke.path;
  double greatest = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Vec3d& p = scene.mesh.positions[i];
    bool beyond = true;
    for (std::size_t k = 1; k < path.size() && beyond; ++k) {
      beyond = distance_to_segment(p, path[k - 1], path[k]) >= scene.stroke.outer;
    }
    if (beyond) greatest = std::max(greatest, norm(moved[i] - p));
  }
  return greatest;
}

// Returns a stroke of a brush with a reach of 0.142 of the diagonal: it starts at the shape's foremost vertex and moves
// along z by `distance` times the reach.
PeerScene stroke_at_front(const std::string& name, const Mesh& mesh, double distance, int pieces) {
  PeerScene scene{fmt::format("{}, {} in {}", name, distance > 0 ? "pull" : "push", pieces), mesh, {}};
  const auto foremost = std::max_element(mesh.positions.begin(), mesh.positions.end(),
                                         [](const Vec3d& a, const Vec3d& b) { return a.z < b.z; });
  const double outer = 0.142 * bounding_box(mesh.positions).diagonal();
  scene.stroke.inner = 0.16 * outer;
  scene.stroke.outer = outer;
  for (int i = 0; i <= pieces; ++i) {
    scene.stroke.path.push_back(*foremost + Vec3d{0.1, 0.2, 1} * (distance * outer * i / pieces));
  }
  return scene;
}

struct Method {
  std::string name;
  std::function<void(std::span<Vec3d>)> move;
};

// Measures each method on one thread.
std::vector<Method> methods_of(const PeerScene& scene, double size) {
  const ImplicitStroke& stroke = scene.stroke;
  const bench::KelvinletBrush brush{stroke.path, comparable_epsilon(stroke)};
  AdvectOptions options;
  options.tolerance = 1e-5 * size;
  options.threads = 1;
  return {{"knead", [=, flow = flow_of(stroke)](std::span<Vec3d> points) { advect(flow, points, options); }},
          {"kelvinlet, integrated",
           [=](std::span<Vec3d> points) { bench::advect_kelvinlet(brush, points, bench::sufficient_steps(brush)); }},
          {"kelvinlet, displaced", [=](std::span<Vec3d> points) { bench::displace_kelvinlet(brush, points); }}};
}

}  // namespace

std::vector<PeerScene> peer_scenes(const std::string& name, const Mesh& mesh) {
  const Measures measures = measure(mesh);
  if (!measures.closed() || !measures.oriented()) return {};
  return {stroke_at_front(name, mesh, 1, 20), stroke_at_front(name, mesh, 1, 1), stroke_at_front(name, mesh, -3, 4)};
}

std::vector<PeerScene> standard_peer_scenes(const std::string& folder) {
  const std::string file = "armadillo_173k_constructed.ply";
  const std::filesystem::path path = std::filesystem::path(folder) / file;
  if (std::filesystem::exists(path)) return peer_scenes(file, read_shape(path).mesh);
  return peer_scenes("knot 172974", make_shape(ShapeKind::knot, 172'974));
}

std::vector<PeerRow> measure_peers(const PeerScene& scene) {
  const std::vector<Vec3d>& before = scene.mesh.positions;
  const double size = bounding_box(before).diagonal();
  const std::vector<Triangle> triangles = triangulate(scene.mesh);
  const double volume = measure_volume_and_area(scene.mesh, before).volume;
  const std::size_t crossings = self_intersections(triangles, before, kCount).count;
  std::vector<PeerRow> rows;
  for (const auto& [name, move] : methods_of(scene, size)) {
    PeerRow& row = rows.emplace_back(PeerRow{name, scene.name});
    std::vector<Vec3d> moved;
    row.seconds = median_seconds([&, &move = move] {
      moved = before;
      move(moved);
    });
    row.volume_error = measure_volume_and_area(scene.mesh, moved).volume / volume - 1;
    row.self_intersections_before = crossings;
    row.self_intersections_after = self_intersections(triangles, moved, kCount).count;
    row.motion_beyond_outer = motion_beyond(scene, moved) / size;
  }
  return rows;
}

Json json_of(const PeerRow& row) {
  return {{"method", row.method},
          {"scene", row.scene},
          {"seconds", row.seconds},
          {"volume_error", row.volume_error},
          {"self_intersections_before", row.self_intersections_before},
          {"self_intersections_after", row.self_intersections_after},
          {"motion_beyond_outer", row.motion_beyond_outer}};
}

std::string peers_heading() {
  return fmt::format("\n{:44} {:26} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "beside others", "method", "ms", "volume",
                     "crossings", "after", "beyond");
}

std::string text_of(const PeerRow& row) {
  return fmt::format("{:44} {:26} {:9.3f} {:9.1e} {:9} {:9} {:9.1e}\n", row.scene, row.method, 1e3 * row.seconds,
                     row.volume_error, row.self_intersections_before, row.self_intersections_after,
                     row.motion_beyond_outer);
}

}  // namespace knead::command
