#include "knead/mesh/measures.h"

#include <fmt/format.h>

#include <algorithm>

namespace knead {
namespace {

constexpr double kFar = 10;            // in extents of the other points
constexpr std::size_t kOneAmong = 20;  // points, the most that may lie astray on a side

// Keeps the `most` least values, of which the first is the largest.
void keep_least(std::vector<double>& heap, double value, std::size_t most) {
  if (heap.size() == most) {
    if (!(value < heap.front())) return;
    std::pop_heap(heap.begin(), heap.end());
    heap.pop_back();
  }
  heap.push_back(value);
  std::push_heap(heap.begin(), heap.end());
}

std::vector<bool> used_vertices(const Mesh& mesh) {
  std::vector<bool> used(mesh.vertex_count());
  for (const std::uint32_t v : mesh.corner_vertex) used[v] = true;
  return used;
}

}  // namespace

void CloudBox::add(std::span<const Vec3d> points) {
  points_ += points.size();
  for (const Vec3d& p : points) {
    whole_.extend(p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      keep_least(ends_[2 * axis], p[axis], kMost + 1);
      keep_least(ends_[2 * axis + 1], -p[axis], kMost + 1);
    }
  }
}

Box CloudBox::box() const {
  const std::size_t most = std::min(kMost, points_ / kOneAmong);
  if (most == 0) return whole_;
  std::array<std::vector<double>, 6> ends = ends_;
  double extent = 0;  // of the points without `most` of them at each end
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t side : {0, 1}) std::sort(ends[2 * axis + side].begin(), ends[2 * axis + side].end());
    extent = std::max(extent, -ends[2 * axis + 1][most] - ends[2 * axis][most]);
  }
  if (!(extent > 0)) return whole_;
  // The end of a side: the outermost value that is not far from the one that `most` are beyond.
  const auto end_of = [&](const std::vector<double>& values) {
    return *std::lower_bound(values.begin(), values.end(), values[most] - kFar * extent);
  };
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = end_of(ends[2 * axis]);
    box.max[axis] = -end_of(ends[2 * axis + 1]);
  }
  return box;
}

Box shape_box(const Mesh& mesh) { return shape_box(mesh, mesh.positions); }

Box shape_box(const Mesh& mesh, std::span<const Vec3d> positions) {
  if (mesh.face_count() == 0) {
    CloudBox cloud;
    cloud.add(positions);
    return cloud.box();
  }
  const std::vector<bool> used = used_vertices(mesh);
  Box box;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (used[v]) box.extend(positions[v]);
  }
  return box;
}

std::string stray_note(const Mesh& mesh) {
  Box box = shape_box(mesh);
  const double margin = box.diagonal();
  box.min -= Vec3d{margin, margin, margin};
  box.max += Vec3d{margin, margin, margin};
  std::size_t count = 0;
  std::size_t first = 0;
  for (std::size_t v = mesh.vertex_count(); v > 0; --v) {
    if (contains(box, mesh.positions[v - 1])) continue;
    ++count;
    first = v - 1;
  }
  if (count == 0) return {};
  const Vec3d& p = mesh.positions[first];
  const std::string place = fmt::format("vertex {} at {:.6g} {:.6g} {:.6g}", first, p.x, p.y, p.z);
  const std::string which = count == 1 ? place : fmt::format("{} vertices ({} is the first)", count, place);
  const char* why = mesh.face_count() > 0 ? "far from the shape, in no face" : "far from all others";
  const char* lie = count == 1 ? "lies" : "lie";
  return fmt::format("{} {} {}; the box, and lengths that are relative to it, leave out such vertices", which, lie,
                     why);
}

}  // namespace knead
