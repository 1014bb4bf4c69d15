#include "knead/io/obj/normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "knead/mesh/normals.h"

namespace knead::io_detail::obj {
namespace {

// The corners that have a normal, ordered by a key and then as in the file.
template <class Key>
std::vector<std::uint32_t> corners_by(const Layout& layout, const Key& key) {
  std::vector<std::uint32_t> corners;
  for (std::uint32_t c = 0; c < layout.corner_normal.size(); ++c) {
    if (layout.corner_normal[c] != kNoNormal) corners.push_back(c);
  }
  std::stable_sort(corners.begin(), corners.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  return corners;
}

// A line of the file, and the cell of a grid that a normal of its corners lies in; the first cell is that of corners
// which did not turn.
using Cell = std::array<double, 5>;

Cell cell_of(const Vec3d& normal, const Vec3d& before, std::uint32_t line) {
  if (normal == before) return {static_cast<double>(line), 0, 0, 0, 0};
  const double grid = 1e-4 * norm(normal);
  const auto index = [&](double x) { return grid > 0 ? std::floor(x / grid + 0.5) : 0; };
  return {static_cast<double>(line), 1, index(normal.x), index(normal.y), index(normal.z)};
}

}  // namespace

std::vector<Vec3d> moved_corner_normals(const Mesh& mesh, const Layout& layout, std::span<const Vec3d> after) {
  using Use = std::array<std::uint32_t, 2>;
  const auto use = [&](std::uint32_t c) { return Use{layout.corner_normal[c], mesh.corner_vertex[c]}; };
  std::vector<Vec3d> normals;
  std::vector<std::uint32_t> corner_use(layout.corner_normal.size(), kNoNormal);
  Use last{kNoNormal, 0};
  for (const std::uint32_t c : corners_by(layout, use)) {
    if (use(c) != last) normals.push_back(layout.normals[layout.corner_normal[c]]);
    last = use(c);
    corner_use[c] = static_cast<std::uint32_t>(normals.size() - 1);
  }
  const std::vector<Vec3d> moved = transport_normals(mesh, after, normals, corner_use);
  std::vector<Vec3d> corner_normals(corner_use.size());
  for (std::size_t c = 0; c < corner_use.size(); ++c) {
    if (corner_use[c] != kNoNormal) corner_normals[c] = moved[corner_use[c]];
  }
  return corner_normals;
}

NormalLines plan_normals(const Layout& layout, std::span<const Vec3d> corner_normals) {
  NormalLines plan;
  for (std::size_t n = 0; n < layout.normals.size(); ++n) {
    plan.lines.push_back({layout.normals[n], static_cast<std::uint32_t>(n)});
  }
  if (corner_normals.empty()) return plan;
  plan.corner_line = layout.corner_normal;
  const auto line_of = [&](std::uint32_t c) { return layout.corner_normal[c]; };
  std::vector<Cell> cells(layout.corner_normal.size());
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    if (line_of(c) != kNoNormal) cells[c] = cell_of(corner_normals[c], layout.normals[line_of(c)], line_of(c));
  }
  const auto cell = [&](std::uint32_t c) -> const Cell& { return cells[c]; };
  // Of each line the corner whose cell keeps it: one that did not turn, or else the first in the file.
  const std::vector<std::uint32_t> corners = corners_by(layout, cell);
  std::vector<std::uint32_t> keeper(layout.normals.size(), kNoNormal);
  for (const std::uint32_t c : corners) {
    std::uint32_t& kept = keeper[line_of(c)];
    const bool unturned = kept != kNoNormal && cell(kept)[1] == 0;
    if (kept == kNoNormal || (!unturned && c < kept)) kept = c;
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t c = corners[i];
    const std::uint32_t line = line_of(c);
    if (cell(c) == cell(keeper[line])) {
      plan.lines[line].normal = corner_normals[keeper[line]];
    } else if (i > 0 && cell(c) == cell(corners[i - 1])) {
      plan.corner_line[c] = plan.corner_line[corners[i - 1]];
    } else {
      plan.corner_line[c] = static_cast<std::uint32_t>(plan.lines.size());
      plan.lines.push_back({corner_normals[c], line});
    }
  }
  if (plan.lines.size() == layout.normals.size()) plan.corner_line.clear();
  return plan;
}

}  // namespace knead::io_detail::obj
