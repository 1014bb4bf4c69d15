// Defines a region of its own, a ring, and raises a ridge around the first vertex of a shape: torus_tool IN OUT
#include <knead/flow.h>
#include <knead/io.h>
#include <knead/vec.h>

#include <cmath>
#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 3) throw std::runtime_error("usage: torus_tool IN OUT");
  knead::ShapeFile shape = knead::read_shape(argv[1]);
  std::vector<knead::Vec3d> points = shape.mesh.positions;
  const double size = knead::bounding_box(points).diagonal();
  const auto ring = [=](const knead::Vec3d& d, double /*t*/) {  // the distance from a circle about the y axis
    const double scale = 0.12 * size / std::hypot(d.x, d.z);
    const knead::Vec3d away = std::isfinite(scale) ? d - knead::Vec3d{d.x, 0, d.z} * scale : knead::Vec3d{size, 0, 0};
    const double r = norm(away);
    return knead::RegionValue<double>{r, r > 0 ? away / r : away};
  };
  const knead::Vec3d up{0, 0.06 * size, 0};
  knead::Segment lift;
  lift.displacement = up;
  lift.fields = {{points[0], knead::Translation<double>{up}, knead::custom_region(ring), {0.01 * size, 0.1 * size}}};
  knead::advect({{lift}}, points, {.tolerance = 1e-5 * size});
  knead::write_shape(argv[2], shape, points);
} catch (const std::exception& error) {
  std::fprintf(stderr, "torus_tool: %s\n", error.what());
  return 1;
}
