// For tests: shapes moved by flows, and what is to be known of the remeshed results.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/stroke.h"

namespace knead::test {

// A shape and where a flow takes its vertices; the flow carries further points with the same accuracy.
class Deformed {
 public:
  Deformed(Mesh mesh, const Stroke& stroke) : mesh_(std::move(mesh)), flow_(flow_of(stroke)), reach_(flow_) {
    options_.tolerance = 1e-5 * bounding_box(mesh_.positions).diagonal();
    after_ = mesh_.positions;
    advect(flow_, after_, options_);
  }

  const Mesh& mesh() const { return mesh_; }
  const std::vector<Vec3d>& after() const { return after_; }
  const Flow& flow() const { return flow_; }

  Deformation deformation() const {
    Deformation result;
    result.carry = [this](std::span<Vec3d> points) { advect(flow_, points, options_); };
    result.may_move = [this](const Vec3d& center, double radius) { return reach_.may_move(center, radius); };
    result.feature = reach_.smallest_feature();
    return result;
  }

  using Remesh = Remeshed(const Mesh&, std::span<const Vec3d>, const Deformation&, const RemeshOptions&);

  Remeshed remeshed(RemeshOptions options = {}, const RemeshSettings& settings = {}, Remesh* by = remesh) const {
    options.targets = resolve(settings, mesh_);
    const std::vector<MeshEdge> creases = find_creases(mesh_);
    if (options.creases.empty()) options.creases = creases;
    return by(mesh_, after_, deformation(), options);
  }

 private:
  Mesh mesh_;
  Flow flow_;
  FlowSupport reach_;
  AdvectOptions options_;
  std::vector<Vec3d> after_;
};

inline ImplicitStroke pull(const Vec3d& from, const Vec3d& to, double inner, double outer) {
  ImplicitStroke stroke;
  stroke.path = {from, to};
  stroke.inner = inner;
  stroke.outer = outer;
  return stroke;
}

inline std::size_t crossings_as_float(const Mesh& mesh) {
  std::vector<Vec3d> positions;
  for (const Vec3d& p : mesh.positions) {
    positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  return self_intersections(triangulate(mesh), positions).count;
}

// Of the triangles at moved vertices, in degrees.
inline double smallest_moved_angle(const Remeshed& remeshed) {
  double smallest = 180;
  for (std::size_t f = 0; f < remeshed.mesh.face_count(); ++f) {
    const auto t = remeshed.mesh.face(f);
    if (std::none_of(t.begin(), t.end(), [&](std::uint32_t v) { return remeshed.moved[v]; })) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d& p = remeshed.mesh.positions[t[i]];
      const Vec3d u = remeshed.mesh.positions[t[(i + 1) % 3]] - p;
      const Vec3d v = remeshed.mesh.positions[t[(i + 2) % 3]] - p;
      smallest = std::min(smallest, std::atan2(norm(cross(u, v)), dot(u, v)) * 180 / std::numbers::pi);
    }
  }
  return smallest;
}

}  // namespace knead::test
