// The quality of linear cells and polyhedra, the boundary of a volume mesh, and what a deformation did to cells.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include "cells/cells.h"
#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/predicates.h"

namespace knead {

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

constexpr std::array<CellCorner, 4> kTetrahedronCorners{{{0, 1, 2, 3}, {1, 2, 0, 3}, {2, 0, 1, 3}, {3, 0, 2, 1}}};
constexpr std::array<CellFace, 4> kTetrahedronFaces{{{0, 2, 1, 0}, {0, 1, 3, 0}, {1, 2, 3, 1}, {2, 0, 3, 2}}};
constexpr std::array<CellCorner, 4> kPyramidCorners{{{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}}};
constexpr std::array<CellFace, 5> kPyramidFaces{{{0, 3, 2, 1}, {0, 1, 4, 0}, {1, 2, 4, 1}, {2, 3, 4, 2}, {3, 0, 4, 3}}};
constexpr std::array<CellCorner, 6> kWedgeCorners{
    {{0, 2, 1, 3}, {1, 0, 2, 4}, {2, 1, 0, 5}, {3, 4, 5, 0}, {4, 5, 3, 1}, {5, 3, 4, 2}}};
constexpr std::array<CellFace, 5> kWedgeFaces{{{0, 1, 2, 0}, {3, 5, 4, 3}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}};
constexpr std::array<CellCorner, 8> kHexahedronCorners{
    {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7}, {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}}};
constexpr std::array<CellFace, 6> kHexahedronFaces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

double determinant_of(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return dot(cross(a, b), c); }

// Returns the point with coordinates that are too small for the predicates set to 0.
Vec3d without_tiny(const Vec3d& p) {
  const auto kept = [](double x) { return std::abs(x) < 1e-75 ? 0.0 : x; };
  return {kept(p.x), kept(p.y), kept(p.z)};
}

// The three edges at a corner of a cell.
struct Corner {
  double determinant;
  double lengths;  // their product

  double jacobian() const { return lengths > 0 ? determinant / lengths : 0.0; }
};

Corner measured(const CellCorner& c, std::span<const Vec3d> corners) {
  const Vec3d a = corners[c[1]] - corners[c[0]];
  const Vec3d b = corners[c[2]] - corners[c[0]];
  const Vec3d d = corners[c[3]] - corners[c[0]];
  return {determinant_of(a, b, d), norm(a) * norm(b) * norm(d)};
}

// Returns the exact sign. The determinant's rounding error is below 1e-14 of the product of the lengths, so it mostly
// decides.
int sign_of(const Corner& corner, const CellCorner& c, std::span<const Vec3d> corners) {
  constexpr double kMinProduct = 1e-200;  // below it, intermediate results may have lost digits
  if (corner.lengths > kMinProduct && std::abs(corner.determinant) > 1e-12 * corner.lengths) {
    return corner.determinant > 0 ? 1 : -1;
  }
  return orient3d(without_tiny(corners[c[0]]), without_tiny(corners[c[1]]), without_tiny(corners[c[2]]),
                  without_tiny(corners[c[3]]));
}

// All corners of a tetrahedron have the same determinant, which is computed once.
struct Tetrahedron {
  Corner first;
  double least_jacobian;

  explicit Tetrahedron(std::span<const Vec3d> p) {
    const Vec3d a = p[1] - p[0];
    const Vec3d b = p[2] - p[0];
    const Vec3d c = p[3] - p[0];
    const double la = norm(a);
    const double lb = norm(b);
    const double lc = norm(c);
    const double lab = norm(p[2] - p[1]);
    const double lac = norm(p[3] - p[1]);
    const double lbc = norm(p[3] - p[2]);
    first = {determinant_of(a, b, c), la * lb * lc};
    const auto [least, greatest] = std::minmax({first.lengths, la * lab * lac, lb * lab * lbc, lc * lac * lbc});
    least_jacobian = Corner{first.determinant, first.determinant > 0 ? greatest : least}.jacobian();
  }

  int sign(std::span<const Vec3d> corners) const { return sign_of(first, kTetrahedronCorners.front(), corners); }
};

int common_sign(std::span<const int> signs) {
  const bool is_common = std::all_of(signs.begin(), signs.end(), [&](int sign) { return sign == signs.front(); });
  return is_common ? signs.front() : 0;
}

void require_usable(CellKind kind, std::span<const Vec3d> corners) {
  constexpr double kMaxCoordinate = 1e75;
  if (corners.size() != corner_count(kind)) throw InvalidInput("a cell of this kind has another number of corners");
  for (const Vec3d& p : corners) {
    const bool is_usable =  // false for NaN
        std::abs(p.x) < kMaxCoordinate && std::abs(p.y) < kMaxCoordinate && std::abs(p.z) < kMaxCoordinate;
    if (!is_usable) throw InvalidInput("a corner of the cell is not finite, or beyond 1e75");
  }
}

// A collapsed cell's least scaled Jacobian, and its orientation.
struct CollapsedQuality {
  double scaled_jacobian = 0;
  int orientation = 0;

  CollapsedQuality(const CellShape& shape, std::span<const Vec3d> corners) {
    const CollapsedCell cell = collapsed_cell(shape, corners);
    if (cell.count == 0) return;
    if (cell.is_tetrahedron) {
      const CellCorner& c = cell.corners[0];
      const std::array<Vec3d, 4> four{corners[c[0]], corners[c[1]], corners[c[2]], corners[c[3]]};
      const Tetrahedron tetrahedron(four);
      scaled_jacobian = cell.regular * tetrahedron.least_jacobian;
      orientation = tetrahedron.sign(four);
      return;
    }
    std::array<int, 8> signs{};
    scaled_jacobian = kInfinity;
    for (std::size_t k = 0; k < cell.count; ++k) {
      const Corner corner = measured(cell.corners[k], corners);
      scaled_jacobian = std::min(scaled_jacobian, cell.regular * corner.jacobian());
      signs[k] = sign_of(corner, cell.corners[k], corners);
    }
    orientation = common_sign(std::span(signs).first(cell.count));
  }
};

// Returns the orientation as cell_quality() does.
int orientation_of(CellKind kind, std::span<const Vec3d> corners) {
  require_usable(kind, corners);
  if (kind == CellKind::tetrahedron) return Tetrahedron(corners).sign(corners);
  const CellShape& shape = shape_of(kind);
  const auto sign = [&](const CellCorner& c) { return sign_of(measured(c, corners), c, corners); };
  if (is_collapsed(shape, corners)) return CollapsedQuality(shape, corners).orientation;
  const int first = sign(shape.corners.front());
  const bool is_common =
      std::all_of(shape.corners.begin(), shape.corners.end(), [&](const CellCorner& c) { return sign(c) == first; });
  return is_common ? first : 0;
}

// The volume below a bilinear face is the mean of those below its two triangulations. With corners a, b, c and d the
// sum of the four determinants is half of (a + b + c + d) . ((c - a) x (d - b)).
double volume_of(const CellShape& shape, std::span<const Vec3d> corners) {
  double sum = 0;
  for (const CellFace& f : shape.faces) {
    const Vec3d a = corners[f[0]] - corners[0];
    const Vec3d b = corners[f[1]] - corners[0];
    const Vec3d c = corners[f[2]] - corners[0];
    const Vec3d d = corners[f[3]] - corners[0];
    sum += dot(a + b + (c + d), cross(c - a, d - b));
  }
  return sum / 24;
}

// One cell at both times. Throws InvalidInput for a corner that is no point.
struct MovedCell {
  std::array<Vec3d, 8> before;
  std::array<Vec3d, 8> after;
  bool rests = true;

  void read(const Cells& cells, std::size_t cell, std::span<const Vec3d> from, std::span<const Vec3d> to) {
    const std::span<const std::uint32_t> corners = cells.corners_of(cell);
    const std::size_t points = std::min(from.size(), to.size());
    rests = true;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      if (corners[k] >= points) {
        throw InvalidInput(fmt::format("cell {} has the corner {}, but there are {} points", cell, corners[k], points));
      }
      before[k] = from[corners[k]];
      after[k] = to[corners[k]];
      rests = rests && before[k] == after[k];
    }
  }
};

// Calls use(points of the face, from `apex`) for each face of a polyhedron.
void for_each_face(std::span<const std::uint32_t> faces, std::span<const Vec3d> points, const Vec3d& apex,
                   const std::function<void(std::span<const Vec3d>)>& use) {
  std::vector<Vec3d> corners;
  for (std::size_t at = 0; at < faces.size();) {
    const std::size_t count = faces[at++];
    if (count == 0 || count > faces.size() - at) throw InvalidInput("the list of a polyhedron's faces is cut off");
    corners.clear();
    for (const std::uint32_t v : faces.subspan(at, count)) {
      if (v < points.size()) {
        corners.push_back(points[v] - apex);
        continue;
      }
      throw InvalidInput(fmt::format("a polyhedron has the corner {}, but there are {} points", v, points.size()));
    }
    use(corners);
    at += count;
  }
}

// Returns six times the volume of the pyramid over a face with its apex in the origin.
double sixfold_pyramid(std::span<const Vec3d> face) {
  Vec3d middle{0, 0, 0};
  for (const Vec3d& p : face) middle += p * (1.0 / static_cast<double>(face.size()));
  double result = 0;
  for (std::size_t k = 0; k < face.size(); ++k) result += determinant_of(middle, face[k], face[(k + 1) % face.size()]);
  return result;
}

}  // namespace

CellStars stars_of(const Cells& cells, std::span<const std::uint32_t> numbers, std::size_t points) {
  CellStars stars{std::vector<std::size_t>(points + 1), {}};
  for (const std::uint32_t cell : numbers) {
    for (const std::uint32_t corner : cells.corners_of(cell)) ++stars.first[corner + 1];
  }
  for (std::size_t v = 0; v < points; ++v) stars.first[v + 1] += stars.first[v];
  stars.cells.resize(stars.first.back());
  std::vector<std::size_t> next(stars.first.begin(), stars.first.end() - 1);
  for (const std::uint32_t cell : numbers) {
    for (const std::uint32_t corner : cells.corners_of(cell)) stars.cells[next[corner]++] = cell;
  }
  return stars;
}

std::span<const Vec3d> corner_positions(const Cells& cells, std::size_t cell, std::span<const Vec3d> points,
                                        std::array<Vec3d, 8>& corners) {
  const std::span<const std::uint32_t> numbers = cells.corners_of(cell);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (numbers[k] >= points.size()) {
      throw InvalidInput(
          fmt::format("cell {} has the corner {}, but there are {} points", cell, numbers[k], points.size()));
    }
    corners[k] = points[numbers[k]];
  }
  return std::span(corners).first(numbers.size());
}

bool is_on_boundary(const Cells& cells, const CellStars& stars, std::uint32_t point) {
  return !unpaired_faces(cells, stars, point).empty();
}

std::vector<CellBoundaryFace> boundary_faces(const Cells& cells, std::size_t points, int threads) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const std::uint32_t corner : cells.corners_of(i)) {
      if (corner < points) continue;
      throw InvalidInput(fmt::format("cell {} has the corner {}, but there are {} points", i, corner, points));
    }
  }
  std::vector<std::uint32_t> all_cells(cells.size());
  std::iota(all_cells.begin(), all_cells.end(), 0U);
  const CellStars stars = stars_of(cells, all_cells, points);
  std::vector<std::vector<CellBoundaryFace>> parts((points + kCellGrain - 1) / kCellGrain);
  parallel_for(points, kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      for (const CellBoundaryFace& face : unpaired_faces(cells, stars, static_cast<std::uint32_t>(v))) {
        if (face.front() == v) parts[begin / kCellGrain].push_back(face);
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

const CellShape& shape_of(CellKind kind) {
  static const std::array<CellShape, 4> kShapes{{{kTetrahedronCorners, kTetrahedronFaces, std::sqrt(2.0)},
                                                 {kPyramidCorners, kPyramidFaces, std::sqrt(2.0)},
                                                 {kWedgeCorners, kWedgeFaces, 2 / std::sqrt(3.0)},
                                                 {kHexahedronCorners, kHexahedronFaces, 1}}};
  return kShapes[static_cast<std::size_t>(kind)];
}

bool is_collapsed(const CellShape& shape, std::span<const Vec3d> corners) {
  return std::any_of(shape.corners.begin(), shape.corners.end(), [&](const CellCorner& c) {
    const Vec3d& p = corners[c[0]];
    return p == corners[c[1]] || p == corners[c[2]] || p == corners[c[3]];
  });
}

CollapsedCell collapsed_cell(const CellShape& shape, std::span<const Vec3d> corners) {
  std::array<std::uint8_t, 8> first{};  // the first corner at the position of each
  std::size_t positions = 0;
  for (std::uint8_t k = 0; k < corners.size(); ++k) {
    while (corners[first[k]] != corners[k]) ++first[k];
    positions += first[k] == k ? 1 : 0;
  }
  // For each position the faces there: the corner before it and the one after it.
  std::array<std::vector<std::array<std::uint8_t, 2>>, 8> around;
  for (const CellFace& face : shape.faces) {
    std::vector<std::uint8_t> ring;
    for (const std::uint8_t k : face) {
      if (std::find(ring.begin(), ring.end(), first[k]) == ring.end()) ring.push_back(first[k]);
    }
    for (std::size_t i = 0; i < ring.size() && ring.size() >= 3; ++i) {
      around[ring[i]].push_back({ring[(i + ring.size() - 1) % ring.size()], ring[(i + 1) % ring.size()]});
    }
  }
  CollapsedCell cell;
  cell.is_tetrahedron = positions == 4;
  cell.regular = positions < 6 ? std::sqrt(2.0) : (positions == 6 ? 2 / std::sqrt(3.0) : 1.0);
  for (std::uint8_t k = 0; k < corners.size(); ++k) {
    if (around[k].size() != 3) continue;
    // Faces look outward: seen from outside, the corners are counter-clockwise and the third edge leads away.
    const auto [before, after] = around[k][0];
    const auto [from, to] = around[k][1];
    const std::uint8_t third = from == before || from == after ? to : from;
    cell.corners[cell.count++] = {k, before, after, third};
  }
  return cell;
}

double scaled_jacobian(const CellShape& shape, std::span<const Vec3d> corners) {
  if (corners.size() == kTetrahedronCorners.size()) return shape.regular * Tetrahedron(corners).least_jacobian;
  if (is_collapsed(shape, corners)) return CollapsedQuality(shape, corners).scaled_jacobian;
  double least = kInfinity;
  for (const CellCorner& c : shape.corners) least = std::min(least, shape.regular * measured(c, corners).jacobian());
  return least;
}

std::size_t corner_count(CellKind kind) {
  constexpr std::array<std::size_t, 4> counts{4, 5, 6, 8};
  return counts[static_cast<std::size_t>(kind)];
}

CellQuality cell_quality(CellKind kind, std::span<const Vec3d> corners) {
  require_usable(kind, corners);
  const CellShape& shape = shape_of(kind);
  CellQuality quality;
  if (kind == CellKind::tetrahedron) {
    const Tetrahedron tetrahedron(corners);
    quality.scaled_jacobian = shape.regular * tetrahedron.least_jacobian;
    quality.orientation = tetrahedron.sign(corners);
    quality.volume = tetrahedron.first.determinant / 6;
    return quality;
  }
  if (is_collapsed(shape, corners)) {
    const CollapsedQuality collapsed(shape, corners);
    return {volume_of(shape, corners), collapsed.scaled_jacobian, collapsed.orientation};
  }
  std::array<int, 8> signs{};
  quality.scaled_jacobian = kInfinity;
  for (std::size_t k = 0; k < shape.corners.size(); ++k) {
    const Corner corner = measured(shape.corners[k], corners);
    quality.scaled_jacobian = std::min(quality.scaled_jacobian, shape.regular * corner.jacobian());
    signs[k] = sign_of(corner, shape.corners[k], corners);
  }
  quality.orientation = common_sign(std::span(signs).first(shape.corners.size()));
  quality.volume = volume_of(shape, corners);
  return quality;
}

void Cells::add(CellKind kind, std::span<const std::uint32_t> numbers) {
  if (numbers.size() != corner_count(kind)) throw InvalidInput("a cell of this kind has another number of corners");
  kinds.push_back(kind);
  corners.insert(corners.end(), numbers.begin(), numbers.end());
  first.push_back(corners.size());
}

CellChanges compare_cells(const Cells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after, int threads,
                          CellValues values) {
  const std::size_t count = cells.size();
  const std::size_t valued = values == CellValues::all ? count : 0;
  CellChanges changes{std::vector<double>(valued), std::vector<double>(valued), std::vector<std::uint8_t>(count), 0};
  std::atomic<std::size_t> inverted{0};
  parallel_for(count, kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    MovedCell cell;
    for (std::size_t i = begin; i < end; ++i) {
      cell.read(cells, i, before, after);
      if (cell.rests && valued == 0) continue;
      const CellKind kind = cells.kinds[i];
      const auto old = std::span<const Vec3d>(cell.before).first(corner_count(kind));
      const auto now = std::span<const Vec3d>(cell.after).first(corner_count(kind));
      int was = 0;
      int is = 0;
      if (valued == 0) {
        was = orientation_of(kind, old);
        is = orientation_of(kind, now);
      } else {
        const CellQuality first = cell_quality(kind, old);
        const CellQuality last = cell.rests ? first : cell_quality(kind, now);
        changes.volume_ratio[i] = last.volume / first.volume;
        changes.scaled_jacobian[i] = first.orientation == -1 ? -last.scaled_jacobian : last.scaled_jacobian;
        was = first.orientation;
        is = last.orientation;
      }
      if (was == 0 || is == was) continue;
      changes.is_inverted[i] = 1;
      ++inverted;
    }
  });
  changes.inverted = inverted;
  return changes;
}

double polyhedron_volume(std::span<const std::uint32_t> faces, std::span<const Vec3d> points) {
  if (faces.size() < 2) return 0;
  // Measured from a corner, because large coordinates would cancel.
  const Vec3d apex = faces[1] < points.size() ? points[faces[1]] : Vec3d{0, 0, 0};
  double sixths = 0;
  for_each_face(faces, points, apex, [&](std::span<const Vec3d> face) { sixths += sixfold_pyramid(face); });
  return sixths / 6;
}

int polyhedron_orientation(std::span<const std::uint32_t> faces, std::span<const Vec3d> points) {
  Vec3d sum{0, 0, 0};
  double count = 0;
  const Vec3d first = faces.size() > 1 && faces[1] < points.size() ? points[faces[1]] : Vec3d{0, 0, 0};
  for_each_face(faces, points, first, [&](std::span<const Vec3d> face) {
    for (const Vec3d& p : face) sum += p;
    count += static_cast<double>(face.size());
  });
  if (count == 0) return 0;
  bool has_outward = false;
  bool has_inward = false;
  for_each_face(faces, points, first + sum / count, [&](std::span<const Vec3d> face) {
    const double volume = sixfold_pyramid(face);
    has_outward = has_outward || volume > 0;
    has_inward = has_inward || !(volume > 0);
  });
  if (has_outward == has_inward) return 0;
  return has_outward ? 1 : -1;
}

}  // namespace knead
