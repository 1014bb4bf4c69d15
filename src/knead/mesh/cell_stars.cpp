#include "knead/mesh/cell_stars.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

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

namespace {

// Returns the points of a face, ascending, and kNoCorner where it is a triangle; nothing if fewer than three differ, as
// in a cell with corners given twice.
std::optional<CellBoundaryFace> key_of(const CellFace& face, std::span<const std::uint32_t> corners) {
  CellBoundaryFace key{corners[face[0]], corners[face[1]], corners[face[2]], corners[face[3]]};
  std::sort(key.begin(), key.end());
  const auto end = std::unique(key.begin(), key.end());
  if (end - key.begin() < 3) return std::nullopt;
  std::fill(end, key.end(), kNoCorner);
  return key;
}

// Returns the faces at the point that belong to one cell only, or to more than two.
std::vector<CellBoundaryFace> unpaired_faces(const Cells& cells, const CellStars& stars, std::uint32_t point) {
  std::vector<CellBoundaryFace> faces;
  for (const std::uint32_t cell : stars.of(point)) {
    const std::span<const std::uint32_t> corners = cells.corners_of(cell);
    for (const CellFace& face : shape_of(cells.kinds[cell]).faces) {
      const std::optional<CellBoundaryFace> key = key_of(face, corners);
      if (key && std::find(key->begin(), key->end(), point) != key->end()) faces.push_back(*key);
    }
  }
  std::sort(faces.begin(), faces.end());
  std::vector<CellBoundaryFace> unpaired;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i;
    while (end < faces.size() && faces[end] == faces[i]) ++end;
    if (end - i != 2) unpaired.push_back(faces[i]);
    i = end;
  }
  return unpaired;
}

}  // namespace

bool is_on_boundary(const Cells& cells, const CellStars& stars, std::uint32_t point) {
  return !unpaired_faces(cells, stars, point).empty();
}

std::vector<CellBoundaryFace> boundary_faces(const Cells& cells, std::size_t points, int threads) {
  constexpr std::size_t points_at_a_time = 1024;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const std::uint32_t corner : cells.corners_of(i)) {
      if (corner < points) continue;
      throw InvalidInput(fmt::format("cell {} has the corner {}, but there are {} points", i, corner, points));
    }
  }
  const CellStars stars = stars_of(cells, points);
  std::vector<std::vector<CellBoundaryFace>> parts((points + points_at_a_time - 1) / points_at_a_time);
  parallel_for(points, points_at_a_time, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      for (const CellBoundaryFace& face : unpaired_faces(cells, stars, static_cast<std::uint32_t>(v))) {
        if (face.front() == v) parts[begin / points_at_a_time].push_back(face);
      }
    }
  });
  std::vector<CellBoundaryFace> all;
  for (const std::vector<CellBoundaryFace>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<std::uint32_t> boundary_points(const Cells& cells, std::size_t points, int threads) {
  std::vector<std::uint32_t> found;
  for (const CellBoundaryFace& face : boundary_faces(cells, points, threads)) {
    found.insert(found.end(), face.begin(), face.begin() + (face.back() == kNoCorner ? 3 : 4));
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace knead
