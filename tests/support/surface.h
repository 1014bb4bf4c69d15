// A mesh as the tools that ask a surface see it.
#pragma once

#include <utility>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"

namespace knead::test {

struct Surface {
  explicit Surface(const Mesh& mesh) : positions(mesh.positions), triangles(triangulate(mesh)) {}

  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;
};

// A surface that applies strokes to its own positions, and keeps them.
struct MovedSurface {
  Mesh mesh;
  std::vector<Triangle> triangles;
  std::vector<Stroke> applied;
  Progress progress;

  explicit MovedSurface(Mesh of) : mesh(std::move(of)), triangles(triangulate(mesh)) {}

  LiveSurface live(int threads = 0) {
    LiveSurface surface;
    surface.positions = mesh.positions;
    surface.triangles = triangles;
    surface.progress = &progress;
    surface.apply = [this, threads](const Stroke& part) {
      applied.push_back(part);
      AdvectOptions options;
      options.tolerance = 1e-5;
      options.threads = threads;
      advect(flow_of(part), mesh.positions, options);
      return true;
    };
    return surface;
  }
};

}  // namespace knead::test
