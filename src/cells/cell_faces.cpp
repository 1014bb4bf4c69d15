// The quality of the faces between cells for a finite volume method, and cells compared with those before.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <utility>

#include "cells/cells.h"
#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "math/elementary.h"

namespace knead {

namespace {

// The faces of all cells, those of each cell together. A face between two cells occurs twice.
struct Faces {
  std::vector<std::size_t> first_of_cell{0};
  std::vector<std::size_t> first_corner{0};
  std::vector<std::uint32_t> corners;
  std::size_t linear = 0;  // linear cells, whose faces look outward if they are right-handed; the rest are polyhedra

  std::size_t cells() const { return first_of_cell.size() - 1; }
  std::size_t size() const { return first_corner.size() - 1; }
  std::span<const std::uint32_t> corners_of(std::size_t face) const {
    return std::span(corners).subspan(first_corner[face], first_corner[face + 1] - first_corner[face]);
  }

  // Leaves out repeated corners, and faces with fewer than three different ones.
  void add(std::span<const std::uint32_t> face, std::size_t points) {
    const std::size_t begin = corners.size();
    for (const std::uint32_t v : face) {
      if (v >= points) {
        throw InvalidInput(fmt::format("cell {} has the corner {}, but there are {} points", cells(), v, points));
      }
      const auto own = corners.begin() + static_cast<std::ptrdiff_t>(begin);
      if (std::find(own, corners.end(), v) == corners.end()) corners.push_back(v);
    }
    if (corners.size() - begin < 3) {
      corners.resize(begin);
    } else {
      first_corner.push_back(corners.size());
    }
  }
  void end_cell() { first_of_cell.push_back(size()); }
};

void add_linear(const Cells& cells, std::size_t points, Faces& faces) {
  std::array<std::uint32_t, 4> face{};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::span<const std::uint32_t> corners = cells.corners_of(i);
    for (const CellFace& of_kind : shape_of(cells.kinds[i]).faces) {
      std::transform(of_kind.begin(), of_kind.end(), face.begin(), [&](std::uint8_t k) { return corners[k]; });
      faces.add(face, points);
    }
    faces.end_cell();
  }
  faces.linear = cells.size();
}

Faces faces_of(const Cells& cells, std::size_t points, std::span<const std::span<const std::uint32_t>> polyhedra) {
  Faces faces;
  faces.corners.reserve(3 * cells.corners.size());
  add_linear(cells, points, faces);
  for (const std::span<const std::uint32_t> polyhedron : polyhedra) {
    for (std::size_t at = 0; at < polyhedron.size();) {
      const std::size_t count = polyhedron[at++];
      if (count == 0 || count > polyhedron.size() - at) {
        throw InvalidInput("the list of a polyhedron's faces is cut off");
      }
      faces.add(polyhedron.subspan(at, count), points);
      at += count;
    }
    faces.end_cell();
  }
  return faces;
}

// Returns a hash that does not depend on the order of the corners: the sum of splitmix64 of each.
std::uint64_t hash_of(std::span<const std::uint32_t> corners) {
  std::uint64_t sum = 0;
  for (const std::uint32_t v : corners) {
    std::uint64_t x = v + 0x9e3779b97f4a7c15U;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
    sum += x ^ (x >> 31);
  }
  return sum;
}

constexpr std::size_t kNoFace = std::numeric_limits<std::size_t>::max();

// Returns for each face the face of the cell on its other side; kNoFace on the boundary, or if more than two are equal.
std::vector<std::size_t> opposites_of(const Faces& faces) {
  std::vector<std::pair<std::uint64_t, std::size_t>> keys(faces.size());
  for (std::size_t f = 0; f < keys.size(); ++f) keys[f] = {hash_of(faces.corners_of(f)), f};
  std::sort(keys.begin(), keys.end());
  std::vector<std::size_t> opposites(faces.size(), kNoFace);
  for (std::size_t i = 0; i < keys.size();) {
    std::size_t end = i;
    while (end < keys.size() && keys[end].first == keys[i].first) ++end;
    const auto is_same = [&] {
      const auto a = faces.corners_of(keys[i].second);
      const auto b = faces.corners_of(keys[i + 1].second);
      return a.size() == b.size() && std::is_permutation(a.begin(), a.end(), b.begin());
    };
    if (end - i == 2 && is_same()) {
      opposites[keys[i].second] = keys[i + 1].second;
      opposites[keys[i + 1].second] = keys[i].second;
    }
    i = end;
  }
  return opposites;
}

struct FaceGeometry {
  Vec3d center;
  Vec3d area;  // the area vector, on the side from which the corners are counter-clockwise
};

// A polygon is cut into triangles around the mean of its corners.
FaceGeometry geometry_of(std::span<const std::uint32_t> corners, std::span<const Vec3d> points) {
  const Vec3d& origin = points[corners[0]];  // because large coordinates would cancel
  if (corners.size() == 3) {
    const Vec3d a = points[corners[1]] - origin;
    const Vec3d b = points[corners[2]] - origin;
    return {origin + (a + b) / 3.0, cross(a, b) * 0.5};
  }
  Vec3d mean{};
  for (const std::uint32_t v : corners) mean += points[v] - origin;
  mean = mean / static_cast<double>(corners.size());
  FaceGeometry face;
  Vec3d center{};
  double total = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3d a = points[corners[k]] - origin;
    const Vec3d b = points[corners[(k + 1) % corners.size()]] - origin;
    const Vec3d twice = cross(b - a, mean - a);
    const double size = norm(twice);
    face.area += twice * 0.5;
    center += (a + b + mean) * size;
    total += size;
  }
  face.center = origin + (total > 0 ? center / (3 * total) : mean);
  return face;
}

// The centres and sizes of all faces and cells.
struct CellGeometry {
  std::vector<FaceGeometry> faces;
  std::vector<Vec3d> centers;
  std::vector<double> volumes;  // of the cells
  double volume = 0;            // of all linear cells
};

// Sets the centre of a cell, the mean of the centres of the pyramids over its faces. Returns the volume.
double find_center(std::span<FaceGeometry> faces, bool looks_outward, Vec3d& center) {
  Vec3d estimate{};
  for (const FaceGeometry& face : faces) estimate += face.center - faces.front().center;
  if (faces.empty()) return 0;
  estimate = faces.front().center + estimate / static_cast<double>(faces.size());
  double volume = 0;
  Vec3d moment{};
  for (FaceGeometry& face : faces) {
    const Vec3d arm = face.center - estimate;
    if (!looks_outward && dot(face.area, arm) < 0) face.area = face.area * -1.0;
    const double threefold = dot(face.area, arm);
    moment += arm * (0.75 * threefold);
    volume += threefold;
  }
  center = estimate;
  if (volume != 0 && is_finite(moment / volume)) center += moment / volume;
  return volume / 3;
}

CellGeometry geometry_of(const Faces& faces, std::span<const Vec3d> points, int threads) {
  CellGeometry geometry{std::vector<FaceGeometry>(faces.size()), std::vector<Vec3d>(faces.cells()),
                        std::vector<double>(faces.cells())};
  parallel_for(faces.cells(), kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t first = faces.first_of_cell[i];
      const std::size_t last = faces.first_of_cell[i + 1];
      for (std::size_t f = first; f < last; ++f) geometry.faces[f] = geometry_of(faces.corners_of(f), points);
      geometry.volumes[i] =
          find_center(std::span(geometry.faces).subspan(first, last - first), i < faces.linear, geometry.centers[i]);
    }
  });
  for (std::size_t i = 0; i < faces.linear; ++i) geometry.volume += geometry.volumes[i];
  return geometry;
}

double ratio(double part, double whole) { return whole != 0 ? part / whole : 0; }

// Returns the distance of the line d through a cell's centre from the face's centre, divided by the face's size in that
// direction, or by a part of |d| if that is greater.
double skewness_of(const FaceGeometry& face, std::span<const std::uint32_t> corners, std::span<const Vec3d> points,
                   const Vec3d& center, const Vec3d& d, double part_of_d) {
  const Vec3d arm = face.center - center;
  const Vec3d past = arm - d * ratio(dot(face.area, arm), dot(face.area, d));
  const double length = norm(past);
  if (!(length > 0)) return 0;
  double size = part_of_d * norm(d);
  for (const std::uint32_t v : corners) size = std::max(size, std::abs(dot(past, points[v] - face.center)) / length);
  return length / size;
}

// Returns the aspect ratio of a cell by the formula of checkMesh for three dimensions.
double aspect_ratio_of(std::span<const FaceGeometry> faces, double volume) {
  Vec3d shown{};
  for (const FaceGeometry& face : faces) {
    shown += {std::abs(face.area.x), std::abs(face.area.y), std::abs(face.area.z)};
  }
  const double least = std::min({shown.x, shown.y, shown.z});
  const double greatest = std::max({shown.x, shown.y, shown.z});
  if (!(least > 0 && volume > 0)) return greatest > 0 ? std::numeric_limits<double>::infinity() : 1;
  const double root = elementary::cbrt(volume);
  return std::max(greatest / least, (shown.x + shown.y + shown.z) / (6 * root * root));
}

double cosine_between(const Vec3d& a, const Vec3d& b) {
  const double lengths = norm(a) * norm(b);
  return lengths > 0 ? dot(a, b) / lengths : 0;
}

double degrees_between(const Vec3d& a, const Vec3d& b) {
  return elementary::atan2(norm(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}

CellQuality quality_of(const Cells& cells, std::size_t cell, std::span<const Vec3d> points) {
  std::array<Vec3d, 8> corners;
  return cell_quality(cells.kinds[cell], corner_positions(cells, cell, points, corners));
}

// A total order: the order of the threads does not matter.
bool is_worse(const std::optional<WorstCell>& a, const std::optional<WorstCell>& b) {
  if (!a || !b) return a.has_value();
  return std::pair(a->scaled_jacobian, a->cell) < std::pair(b->scaled_jacobian, b->cell);
}

}  // namespace

CellFaceQuality cell_face_quality(const Cells& cells, std::span<const Vec3d> points,
                                  std::span<const std::span<const std::uint32_t>> polyhedra, int threads) {
  const Faces faces = faces_of(cells, points.size(), polyhedra);
  const std::vector<std::size_t> opposites = opposites_of(faces);
  const CellGeometry geometry = geometry_of(faces, points, threads);
  std::vector<std::size_t> cell_of(faces.size());
  for (std::size_t i = 0; i < faces.cells(); ++i) {
    std::fill(cell_of.begin() + static_cast<std::ptrdiff_t>(faces.first_of_cell[i]),
              cell_of.begin() + static_cast<std::ptrdiff_t>(faces.first_of_cell[i + 1]), i);
  }
  CellFaceQuality result{std::vector<double>(faces.cells()), std::vector<double>(faces.cells()),
                         std::vector<double>(faces.cells())};
  std::vector<double> cosines(faces.cells());        // sums over the faces that a cell owns
  const double side = geometry.volume < 0 ? -1 : 1;  // -1 for a mesh whose cells are left-handed
  parallel_for(faces.cells(), kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3d& own = geometry.centers[i];
      const std::size_t first = faces.first_of_cell[i];
      result.aspect_ratio[i] = aspect_ratio_of(
          std::span(geometry.faces).subspan(first, faces.first_of_cell[i + 1] - first), std::abs(geometry.volumes[i]));
      for (std::size_t f = faces.first_of_cell[i]; f < faces.first_of_cell[i + 1]; ++f) {
        const std::size_t other = opposites[f];
        // The area and centre of the first of both cells count, so that both have the same value.
        const std::size_t owner = std::min(f, other);
        const FaceGeometry& face = geometry.faces[owner];
        double skewness = 0;
        if (other == kNoFace) {
          const double size = norm(face.area);
          const Vec3d normal = size > 0 ? face.area / size : Vec3d{};
          const Vec3d d = normal * dot(normal, face.center - own);
          skewness = skewness_of(face, faces.corners_of(owner), points, own, d, 0.4);
        } else {
          const Vec3d& start = geometry.centers[cell_of[owner]];
          const Vec3d d = geometry.centers[cell_of[std::max(f, other)]] - start;
          const double turned = cell_of[owner] < faces.linear ? side : 1.0;
          skewness = skewness_of(face, faces.corners_of(owner), points, start, d, 0.2);
          const double angle = degrees_between(d, face.area * turned);
          if (f == owner) cosines[i] += cosine_between(d, face.area * turned);
          result.non_orthogonality_deg[i] = std::max(result.non_orthogonality_deg[i], angle);
        }
        result.skewness[i] = std::max(result.skewness[i], skewness);
      }
    }
  });
  const auto paired = std::count_if(opposites.begin(), opposites.end(), [](std::size_t f) { return f != kNoFace; });
  double mean = 0;
  for (const double cosine : cosines) mean += cosine;
  mean = paired > 0 ? std::min(1.0, mean / (0.5 * static_cast<double>(paired))) : 1;
  result.mean_non_orthogonality_deg = elementary::atan2(std::sqrt(1 - mean * mean), mean) * 180 / std::numbers::pi;
  return result;
}

std::size_t count_cells_unresolved_in_float(const Cells& cells, std::span<const Vec3d> points,
                                            std::span<const std::span<const std::uint32_t>> polyhedra, int threads) {
  constexpr double kMinEdge = 1e4 * std::numeric_limits<float>::epsilon();
  const Faces faces = faces_of(cells, points.size(), polyhedra);
  const auto is_unresolved = [&](std::size_t face) {
    const std::span<const std::uint32_t> corners = faces.corners_of(face);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vec3d& a = points[corners[k]];
      const Vec3d& b = points[corners[(k + 1) % corners.size()]];
      double greatest = 0;
      for (int axis = 0; axis < 3; ++axis) greatest = std::max({greatest, std::abs(a[axis]), std::abs(b[axis])});
      if (norm(b - a) < kMinEdge * greatest) return true;
    }
    return false;
  };
  std::atomic<std::size_t> count{0};
  parallel_for(faces.cells(), kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      bool found = false;
      for (std::size_t f = faces.first_of_cell[i]; f < faces.first_of_cell[i + 1] && !found; ++f) {
        found = is_unresolved(f);
      }
      if (found) ++count;
    }
  });
  return count;
}

CellBaseline::CellBaseline(const Cells& cells, std::span<const Vec3d> before, int threads, const Progress* progress)
    : cells_(cells),
      before_(before),
      threads_(threads),
      progress_(progress),
      sides_(cells.size()),
      jacobians_(cells.size()),
      volumes_(cells.size()) {
  parallel_for(cells.size(), kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress);
    for (std::size_t i = begin; i < end; ++i) {
      const CellQuality quality = quality_of(cells, i, before);
      sides_[i] = static_cast<std::int8_t>(quality.orientation);
      jacobians_[i] = quality.orientation == -1 ? -quality.scaled_jacobian : quality.scaled_jacobian;
      volumes_[i] = quality.volume;
    }
  });
}

bool CellBaseline::is_moved(std::size_t cell, std::span<const Vec3d> after) const {
  const std::span<const std::uint32_t> corners = cells_.corners_of(cell);
  return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return after[v] != before_[v]; });
}

DeformedCell CellBaseline::now(std::size_t cell, std::span<const Vec3d> after) const {
  if (!is_moved(cell, after)) return {volumes_[cell] / volumes_[cell], jacobians_[cell], false};
  const CellQuality quality = quality_of(cells_, cell, after);
  const bool was_inside_out = sides_[cell] == -1;
  return {quality.volume / volumes_[cell], was_inside_out ? -quality.scaled_jacobian : quality.scaled_jacobian,
          sides_[cell] != 0 && quality.orientation != sides_[cell]};
}

std::optional<WorstCell> CellBaseline::worst_spoiled(std::span<const Vec3d> after, double bound) const {
  std::optional<WorstCell> worst;
  std::mutex mutex;
  parallel_for(cells_.size(), kCellGrain, threads_, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress_);
    std::optional<WorstCell> own;
    for (std::size_t i = begin; i < end; ++i) {
      if (sides_[i] == 0 || !is_moved(i, after)) continue;
      const DeformedCell cell = now(i, after);
      const bool is_spoiled = cell.is_inverted || is_below(i, cell.scaled_jacobian, bound);
      if (is_spoiled && is_worse(WorstCell{i, cell.scaled_jacobian}, own)) own = WorstCell{i, cell.scaled_jacobian};
    }
    const std::scoped_lock lock(mutex);
    if (is_worse(own, worst)) worst = own;
  });
  return worst;
}

}  // namespace knead
