// Pulls the first vertex of a shape up by a tenth of the shape's size: pull IN OUT
#include <knead/knead.h>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 3) throw std::runtime_error("usage: pull IN OUT");
  knead::ShapeFile shape = knead::read_shape(argv[1]);
  std::vector<knead::Vec3d> points = shape.mesh.positions;
  const double size = knead::bounding_box(points).diagonal();
  knead::ImplicitStroke pull;  // a ball: points within `inner` move with it, points beyond `outer` stay
  pull.path = {points[0], points[0] + knead::Vec3d{0, 0.1 * size, 0}};
  pull.inner = 0.02 * size;
  pull.outer = 0.15 * size;
  knead::advect(knead::flow_of(pull), points, {.tolerance = 1e-5 * size});
  knead::write_shape(argv[2], shape, points);
} catch (const std::exception& error) {
  std::fprintf(stderr, "pull: %s\n", error.what());
  return 1;
}
