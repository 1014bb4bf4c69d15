// What a finite volume method asks of the faces between cells.
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

constexpr std::size_t kCellsAtATime = 1024;

// The faces of all cells, those of each cell together. A face between two cells is there twice.
struct Faces {
  std::vector<std::size_t> first_of_cell{0};
  std::vector<std::size_t> first_corner{0};
  std::vector<std::uint32_t> corners;
  std::size_t linear = 0;  // cells whose faces look outward where they are right-handed; the others are polyhedra

  std::size_t cells() const { return first_of_cell.size() - 1; }
  std::size_t size() const { return first_corner.size() - 1; }
  std::span<const std::uint32_t> corners_of(std::size_t face) const {
    return std::span(corners).subspan(first_corner[face], first_corner[face + 1] - first_corner[face]);
  }

  // Leaves out corners given twice, and a face of which fewer than three are left.
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

// The same for every order of the corners (splitmix64 of each, summed).
std::uint64_t key_of(std::span<const std::uint32_t> corners) {
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

// Returns for each face the one of the cell on its other side; kNoFace on the boundary, or where more than two meet.
std::vector<std::size_t> opposites_of(const Faces& faces) {
  std::vector<std::pair<std::uint64_t, std::size_t>> keys(faces.size());
  for (std::size_t f = 0; f < keys.size(); ++f) keys[f] = {key_of(faces.corners_of(f)), f};
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

struct FacePlace {
  Vec3d center;
  Vec3d area;  // its vector, outward as the corners have it
};

// A polygon is cut into triangles around the mean of its corners.
FacePlace place_of(std::span<const std::uint32_t> corners, std::span<const Vec3d> points) {
  const Vec3d& origin = points[corners[0]];  // because large coordinates would cancel
  if (corners.size() == 3) {
    const Vec3d a = points[corners[1]] - origin;
    const Vec3d b = points[corners[2]] - origin;
    return {origin + (a + b) / 3.0, cross(a, b) * 0.5};
  }
  Vec3d mean{};
  for (const std::uint32_t v : corners) mean += points[v] - origin;
  mean = mean / static_cast<double>(corners.size());
  FacePlace place;
  Vec3d center{};
  double total = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3d a = points[corners[k]] - origin;
    const Vec3d b = points[corners[(k + 1) % corners.size()]] - origin;
    const Vec3d twice = cross(b - a, mean - a);
    const double size = norm(twice);
    place.area += twice * 0.5;
    center += (a + b + mean) * size;
    total += size;
  }
  place.center = origin + (total > 0 ? center / (3 * total) : mean);
  return place;
}

// The places of all faces and the centres of all cells.
struct Places {
  std::vector<FacePlace> faces;
  std::vector<Vec3d> centers;
  std::vector<double> volumes;  // of the cells
  double volume = 0;            // of the cells whose faces look outward
};

// The centre of a cell is the mean of those of the pyramids over its faces. Returns the volume.
double find_center(std::span<FacePlace> faces, bool looks_outward, Vec3d& center) {
  Vec3d estimate{};
  for (const FacePlace& face : faces) estimate += face.center - faces.front().center;
  if (faces.empty()) return 0;
  estimate = faces.front().center + estimate / static_cast<double>(faces.size());
  double volume = 0;
  Vec3d moment{};
  for (FacePlace& face : faces) {
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

Places places_of(const Faces& faces, std::span<const Vec3d> points, int threads) {
  Places places{std::vector<FacePlace>(faces.size()), std::vector<Vec3d>(faces.cells()),
                std::vector<double>(faces.cells())};
  parallel_for(faces.cells(), kCellsAtATime, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t first = faces.first_of_cell[i];
      const std::size_t last = faces.first_of_cell[i + 1];
      for (std::size_t f = first; f < last; ++f) places.faces[f] = place_of(faces.corners_of(f), points);
      places.volumes[i] =
          find_center(std::span(places.faces).subspan(first, last - first), i < faces.linear, places.centers[i]);
    }
  });
  for (std::size_t i = 0; i < faces.linear; ++i) places.volume += places.volumes[i];
  return places;
}

double ratio(double part, double whole) { return whole != 0 ? part / whole : 0; }

// How far the line d from a cell's centre passes by the face's centre, beside the face's size in that direction, or
// beside a part of d where that is more.
double skewness_of(const FacePlace& face, std::span<const std::uint32_t> corners, std::span<const Vec3d> points,
                   const Vec3d& center, const Vec3d& d, double part_of_d) {
  const Vec3d arm = face.center - center;
  const Vec3d past = arm - d * ratio(dot(face.area, arm), dot(face.area, d));
  const double length = norm(past);
  if (!(length > 0)) return 0;
  double size = part_of_d * norm(d);
  for (const std::uint32_t v : corners) size = std::max(size, std::abs(dot(past, points[v] - face.center)) / length);
  return length / size;
}

// The aspect ratio of a cell, by the formula of checkMesh for three dimensions.
double aspect_ratio_of(std::span<const FacePlace> faces, double volume) {
  Vec3d shown{};
  for (const FacePlace& face : faces) {
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

}  // namespace

CellFaceQuality cell_face_quality(const Cells& cells, std::span<const Vec3d> points,
                                  std::span<const std::span<const std::uint32_t>> polyhedra, int threads) {
  const Faces faces = faces_of(cells, points.size(), polyhedra);
  const std::vector<std::size_t> opposites = opposites_of(faces);
  const Places places = places_of(faces, points, threads);
  std::vector<std::size_t> cell_of(faces.size());
  for (std::size_t i = 0; i < faces.cells(); ++i) {
    std::fill(cell_of.begin() + static_cast<std::ptrdiff_t>(faces.first_of_cell[i]),
              cell_of.begin() + static_cast<std::ptrdiff_t>(faces.first_of_cell[i + 1]), i);
  }
  CellFaceQuality result{std::vector<double>(faces.cells()), std::vector<double>(faces.cells()),
                         std::vector<double>(faces.cells())};
  std::vector<double> cosines(faces.cells());      // sums of those of the faces that a cell owns
  const double side = places.volume < 0 ? -1 : 1;  // a mesh whose cells are all left-handed
  parallel_for(faces.cells(), kCellsAtATime, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3d& own = places.centers[i];
      const std::size_t first = faces.first_of_cell[i];
      result.aspect_ratio[i] = aspect_ratio_of(
          std::span(places.faces).subspan(first, faces.first_of_cell[i + 1] - first), std::abs(places.volumes[i]));
      for (std::size_t f = faces.first_of_cell[i]; f < faces.first_of_cell[i + 1]; ++f) {
        const std::size_t other = opposites[f];
        // Of both cells at a face the first one's area and centre count, so that they have the same value.
        const std::size_t owner = std::min(f, other);
        const FacePlace& face = places.faces[owner];
        double skewness = 0;
        if (other == kNoFace) {
          const double size = norm(face.area);
          const Vec3d normal = size > 0 ? face.area / size : Vec3d{};
          const Vec3d d = normal * dot(normal, face.center - own);
          skewness = skewness_of(face, faces.corners_of(owner), points, own, d, 0.4);
        } else {
          const Vec3d& start = places.centers[cell_of[owner]];
          const Vec3d d = places.centers[cell_of[std::max(f, other)]] - start;
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
  constexpr double least = 1e4 * std::numeric_limits<float>::epsilon();
  const Faces faces = faces_of(cells, points.size(), polyhedra);
  const auto is_unresolved = [&](std::size_t face) {
    const std::span<const std::uint32_t> corners = faces.corners_of(face);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vec3d& a = points[corners[k]];
      const Vec3d& b = points[corners[(k + 1) % corners.size()]];
      double most = 0;
      for (int axis = 0; axis < 3; ++axis) most = std::max({most, std::abs(a[axis]), std::abs(b[axis])});
      if (norm(b - a) < least * most) return true;
    }
    return false;
  };
  std::atomic<std::size_t> count{0};
  parallel_for(faces.cells(), kCellsAtATime, threads, [&](std::size_t begin, std::size_t end) {
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

namespace {

constexpr std::size_t kChunk = 4096;

CellQuality quality_of(const Cells& cells, std::size_t cell, std::span<const Vec3d> points) {
  const std::span<const std::uint32_t> numbers = cells.corners_of(cell);
  std::array<Vec3d, 8> corners;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (numbers[k] >= points.size()) {
      throw InvalidInput(
          fmt::format("cell {} has the corner {}, but there are {} points", cell, numbers[k], points.size()));
    }
    corners[k] = points[numbers[k]];
  }
  return cell_quality(cells.kinds[cell], std::span(corners).first(numbers.size()));
}

// A total order, so that the order of the threads does not matter.
bool is_worse(const std::optional<WorstCell>& a, const std::optional<WorstCell>& b) {
  if (!a || !b) return a.has_value();
  return std::pair(a->scaled_jacobian, a->cell) < std::pair(b->scaled_jacobian, b->cell);
}

}  // namespace

CellBaseline::CellBaseline(const Cells& cells, std::span<const Vec3d> before, int threads, const Progress* progress)
    : cells_(cells),
      before_(before),
      threads_(threads),
      progress_(progress),
      sides_(cells.size()),
      jacobians_(cells.size()),
      volumes_(cells.size()) {
  parallel_for(cells.size(), kChunk, threads, [&](std::size_t begin, std::size_t end) {
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

CellNow CellBaseline::now(std::size_t cell, std::span<const Vec3d> after) const {
  if (!is_moved(cell, after)) return {volumes_[cell] / volumes_[cell], jacobians_[cell], false};
  const CellQuality quality = quality_of(cells_, cell, after);
  const bool was_inside_out = sides_[cell] == -1;
  return {quality.volume / volumes_[cell], was_inside_out ? -quality.scaled_jacobian : quality.scaled_jacobian,
          sides_[cell] != 0 && quality.orientation != sides_[cell]};
}

std::optional<WorstCell> CellBaseline::worst_spoiled(std::span<const Vec3d> after, double bound) const {
  std::optional<WorstCell> worst;
  std::mutex mutex;
  parallel_for(cells_.size(), kChunk, threads_, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress_);
    std::optional<WorstCell> own;
    for (std::size_t i = begin; i < end; ++i) {
      if (sides_[i] == 0 || !is_moved(i, after)) continue;
      const CellNow cell = now(i, after);
      const bool is_spoiled = cell.is_inverted || is_below(i, cell.scaled_jacobian, bound);
      if (is_spoiled && is_worse(WorstCell{i, cell.scaled_jacobian}, own)) own = WorstCell{i, cell.scaled_jacobian};
    }
    const std::scoped_lock lock(mutex);
    if (is_worse(own, worst)) worst = own;
  });
  return worst;
}

}  // namespace knead
