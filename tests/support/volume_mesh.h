// Volume meshes of boxes.
#pragma once

#include <array>
#include <cstdint>
#include <ostream>
#include <vector>

#include "knead/cells.h"
#include "knead/mesh.h"

namespace knead {

// The kinds of cells that box_of_cells() makes; a name of a test's parameter.
inline void PrintTo(CellKind kind, std::ostream* out) {
  *out << (kind == CellKind::tetrahedron ? "Tetrahedra" : "Hexahedra");
}

}  // namespace knead

namespace knead::test {

struct VolumeMesh {
  std::vector<Vec3d> points;
  Cells cells;
};

// A box from -1 to 1 of n^3 hexahedra, or six tetrahedra for each.
inline VolumeMesh box_of_cells(std::uint32_t n, CellKind kind) {
  VolumeMesh volume;
  const std::uint32_t side = n + 1;
  const auto place = [n](std::uint32_t i) { return 2.0 * i / n - 1; };
  for (std::uint32_t i = 0; i < side * side * side; ++i) {
    volume.points.push_back({place(i % side), place(i / side % side), place(i / side / side)});
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kParts{
      {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}}};
  for (std::uint32_t i = 0; i < n * n * n; ++i) {
    const std::uint32_t at = i % n + side * (i / n % n + side * (i / n / n));
    const std::uint32_t up = at + side * side;
    const std::array<std::uint32_t, 8> c{at, at + 1, at + 1 + side, at + side, up, up + 1, up + 1 + side, up + side};
    if (kind == CellKind::hexahedron) {
      volume.cells.add(kind, c);
    } else {
      for (const auto& p : kParts) volume.cells.add(kind, std::array{c[p[0]], c[p[1]], c[p[2]], c[p[3]]});
    }
  }
  return volume;
}

}  // namespace knead::test
