#include "knead/mesh/cell_stars.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "knead/math/error.h"
#include "knead/math/parallel.h"
#include "knead/mesh/cell_shape.h"

namespace knead {

CellStars stars_of(const Cells& cells, std::size_t points) {
  CellStars stars{std::vector<std::size_t>(points + 1), std::vector<std::uint32_t>(cells.corners.size())};
  for (const std::uint32_t corner : cells.corners) ++stars.first[corner + 1];
  for (std::size_t v = 0; v < points; ++v) stars.first[v + 1] += stars.first[v];
  std::vector<std::size_t> next(stars.first.begin(), stars.first.end() - 1);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const std::uint32_t corner : cells.corners_of(i)) stars.cells[next[corner]++] = static_cast<std::uint32_t>(i);
  }
  return stars;
}

bool is_on_boundary(const Cells& cells, const CellStars& stars, std::uint32_t point) {
  std::vector<std::array<std::uint32_t, 4>> faces;
  for (const std::uint32_t cell : stars.of(point)) {
    const std::span<const std::uint32_t> corners = cells.corners_of(cell);
    for (const CellFace& face : shape_of(cells.kinds[cell]).faces) {
      std::array<std::uint32_t, 4> key{corners[face[0]], corners[face[1]], corners[face[2]], corners[face[3]]};
      if (std::find(key.begin(), key.end(), point) == key.end()) continue;
      if (face[3] == face[0]) key[3] = std::numeric_limits<std::uint32_t>::max();
      std::sort(key.begin(), key.end());
      faces.push_back(key);
    }
  }
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i;
    while (end < faces.size() && faces[end] == faces[i]) ++end;
    if (end - i != 2) return true;
    i = end;
  }
  return false;
}

std::vector<std::uint32_t> boundary_points(const Cells& cells, std::size_t points, int threads) {
  constexpr std::size_t points_at_a_time = 1024;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const std::uint32_t corner : cells.corners_of(i)) {
      if (corner < points) continue;
      throw InvalidInput(fmt::format("cell {} has the corner {}, but there are {} points", i, corner, points));
    }
  }
  const CellStars stars = stars_of(cells, points);
  std::vector<std::uint8_t> is_there(points);
  parallel_for(points, points_at_a_time, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      is_there[v] = is_on_boundary(cells, stars, static_cast<std::uint32_t>(v)) ? 1 : 0;
    }
  });
  std::vector<std::uint32_t> found;
  for (std::size_t v = 0; v < points; ++v) {
    if (is_there[v] != 0) found.push_back(static_cast<std::uint32_t>(v));
  }
  return found;
}

}  // namespace knead
