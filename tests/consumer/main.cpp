// Uses an installed Knead: makes the sphere that an example then deforms, and checks what came out.
#include <cstdio>

#include "knead/knead.h"

static_assert(KNEAD_VERSION_NUMBER >= 1000, "the headers are those of " KNEAD_VERSION);

int main(int argc, char** argv) {
  if (argc == 2) {
    knead::write_mesh(argv[1], knead::make_shape(knead::ShapeKind::sphere));
    return 0;
  }
  const knead::Measures before = knead::measure(knead::read_shape(argv[1]).mesh);
  const knead::Measures after = knead::measure(knead::read_shape(argv[2]).mesh);
  const double error = after.volume / before.volume - 1;
  std::printf("area %g -> %g, volume error %g\n", before.area, after.area, error);
  return after.area > before.area * 1.001 && error < 1e-3 && error > -1e-3 ? 0 : 1;
}
