#include "knead/io/unplaced.h"

#include <algorithm>

#include "knead/io/face_builder.h"

namespace knead::io_detail {
namespace {

// Calls keep(from, to) for each row that stays, `to` its number without the others.
template <class Keep>
void for_each_kept(std::span<const std::uint32_t> unplaced, std::size_t rows, Keep keep) {
  std::size_t next = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    if (next < unplaced.size() && unplaced[next] == row) {
      ++next;
    } else {
      keep(row, row - next);
    }
  }
}

}  // namespace

void Unplaced::add(std::size_t row, std::size_t byte) {
  if (!rows.empty() && rows.back() == row) return;
  rows.push_back(static_cast<std::uint32_t>(row));
  begin.push_back(byte);
}

std::optional<std::size_t> first_used(const Unplaced& unplaced, const Mesh& mesh) {
  if (unplaced.rows.empty()) return std::nullopt;
  std::vector<bool> used(mesh.vertex_count(), false);
  for (const std::uint32_t v : mesh.corner_vertex) used[v] = true;
  for (std::size_t i = 0; i < unplaced.rows.size(); ++i) {
    if (used[unplaced.rows[i]]) return i;
  }
  return std::nullopt;
}

void remove_unplaced(const Unplaced& unplaced, Mesh& mesh) {
  if (unplaced.rows.empty()) return;
  const std::size_t rows = mesh.vertex_count();
  const std::size_t kept = rows - unplaced.rows.size();
  std::vector<std::uint32_t> number(mesh.corner_vertex.empty() ? 0 : rows, 0);
  for_each_kept(unplaced.rows, rows, [&](std::size_t from, std::size_t to) {
    mesh.positions[to] = mesh.positions[from];
    if (!number.empty()) number[from] = static_cast<std::uint32_t>(to);
  });
  mesh.positions.resize(kept);
  for (std::uint32_t& v : mesh.corner_vertex) v = number[v];
  for (Attribute& attribute : mesh.attributes) {
    if (attribute.domain != Domain::vertex) continue;
    const std::size_t n = static_cast<std::size_t>(attribute.components);
    for_each_kept(unplaced.rows, rows, [&](std::size_t from, std::size_t to) {
      for (std::size_t c = 0; c < n; ++c) attribute.values[to * n + c] = attribute.values[from * n + c];
    });
    attribute.values.resize(kept * n);
  }
}

std::vector<Vec3d> by_row(std::span<const Vec3d> values, std::span<const std::uint32_t> unplaced) {
  std::vector<Vec3d> rows(values.size() + unplaced.size());
  for_each_kept(unplaced, rows.size(), [&](std::size_t from, std::size_t to) { rows[from] = values[to]; });
  return rows;
}

std::string unplaced_note(std::size_t count) {
  if (count == 0) return {};
  return counted(count, "vertex has coordinates that are not finite; it is kept in the file and does not move",
                 "vertices have coordinates that are not finite; they are kept in the file and do not move");
}

std::string unplaced_loss(std::size_t count) {
  if (count == 0) return {};
  return counted(count, "vertex whose coordinates are not finite is left out",
                 "vertices whose coordinates are not finite are left out");
}

}  // namespace knead::io_detail
