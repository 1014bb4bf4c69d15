// The tool of a stamp: its contact with a surface, and the points that lead it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "strokes/stamp.h"

namespace knead::detail {

namespace {

constexpr double kSideways = 0.1;     // n.v0 up to that much of |v0|: the face looks sideways or back
constexpr double kFarFront = 1.5;     // of |v0|
constexpr double kMaxSamples = 1000;  // along an edge

// Calls body(i, out) for every i and joins what was appended, in the order of i.
template <class T, class Body>
std::vector<T> collected(std::size_t count, int threads, Body body) {
  constexpr std::size_t grain = 512;
  std::vector<std::vector<T>> chunks((count + grain - 1) / grain);
  parallel_for(count, grain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i, chunks[begin / grain]);
  });
  std::vector<T> all;
  for (const std::vector<T>& chunk : chunks) all.insert(all.end(), chunk.begin(), chunk.end());
  return all;
}

bool may_reach(const Box& box, const std::array<Vec3d, 3>& c) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::min({c[0][k], c[1][k], c[2][k]}) > box.max[k] || std::max({c[0][k], c[1][k], c[2][k]}) < box.min[k]) {
      return false;
    }
  }
  return true;
}

// Returns the number of parts, no longer than spacing, of a length.
int parts_of(double length, double spacing) {
  return static_cast<int>(std::clamp<double>(std::ceil(length / spacing), 1, kMaxSamples));
}

// Adds places on the triangle, without its corners, in rows along its longest side: a sliver gets no more than a line.
void sample(const Triangle& t, const std::array<Vec3d, 3>& c, const Box& box, double spacing,
            std::vector<StampPlace>& places) {
  std::size_t i = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (norm2(c[(k + 1) % 3] - c[k]) > norm2(c[(i + 1) % 3] - c[i])) i = k;
  }
  const std::size_t j = (i + 1) % 3;
  const std::size_t apex = (i + 2) % 3;
  const double longest = norm(c[j] - c[i]);
  if (longest <= spacing) return;
  const int rows = parts_of(norm(cross(c[j] - c[i], c[apex] - c[i])) / longest, spacing);
  for (int row = 0; row < rows; ++row) {
    const double up = 1.0 * row / rows;
    const int columns = parts_of(longest * (1 - up), spacing);
    for (int column = 0; column <= columns; ++column) {
      if (row == 0 && (column == 0 || column == columns)) continue;
      StampPlace place{t, {}};
      place.barycentric[apex] = up;
      place.barycentric[j] = (1 - up) * column / columns;
      place.barycentric[i] = (1 - up) * (columns - column) / columns;
      if (contains(box, c[i] * place.barycentric[i] + c[j] * place.barycentric[j] + c[apex] * up))
        places.push_back(place);
    }
  }
}

// Vertices and samples inside the box.
std::vector<StampPlace> places_in(const Box& box, const LiveSurface& surface, const StampStep& step) {
  const std::span<const Vec3d> positions = surface.positions;
  std::vector<StampPlace> places = collected<StampPlace>(positions.size(), step.threads, [&](std::size_t i, auto& out) {
    const auto v = static_cast<std::uint32_t>(i);
    if (contains(box, positions[i])) out.push_back({{v, v, v}});
  });
  const std::vector<StampPlace> samples =
      collected<StampPlace>(surface.triangles.size(), step.threads, [&](std::size_t i, auto& out) {
        const Triangle& t = surface.triangles[i];
        const std::array<Vec3d, 3> corners{positions[t[0]], positions[t[1]], positions[t[2]]};
        if (may_reach(box, corners)) sample(t, corners, box, step.spacing, out);
      });
  places.insert(places.end(), samples.begin(), samples.end());
  return places;
}

Box moved(const Box& box, const Vec3d& by) { return {box.min + by, box.max + by}; }

// Different cells may share a key: that costs time only.
std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto part = [](std::int64_t i) { return static_cast<std::uint64_t>(i) & 0x1fffff; };
  return part(x) << 42 | part(y) << 21 | part(z);
}

void require_solid(const Mesh& mesh) {
  const Measures measures = measure(WeldedMesh(mesh).mesh());
  if (measures.faces == 0) throw InvalidInput("\"mesh\" must be a closed surface, and this has no faces");
  if (!measures.closed()) {
    throw InvalidInput(fmt::format("\"mesh\" must be a closed surface, and this has {} boundary edges; close its holes",
                                   measures.boundary_edges));
  }
  if (!measures.oriented()) {
    throw InvalidInput(
        fmt::format("\"mesh\" must have faces that look outward, and along {} edges they disagree; "
                    "orient them alike",
                    measures.misoriented_edges));
  }
  if (!(measures.volume > 0)) {
    throw InvalidInput(
        "\"mesh\" must have faces that look outward, and these look inward or enclose nothing; "
        "turn them round");
  }
}

std::vector<Vec3d> posed_solid(const Mesh& mesh, const Mat3d& pose) {
  require_solid(mesh);
  std::vector<Vec3d> positions = mesh.positions;
  for (Vec3d& p : positions) p = pose * p;
  return positions;
}

// Unit vectors across a direction, evenly spread over half a turn.
std::vector<Vec3d> directions_across(const Vec3d& direction, int count) {
  const Vec3d a = any_orthogonal(direction);
  const Vec3d b = cross(direction, a);
  std::vector<Vec3d> result;
  for (int k = 0; k < count; ++k) {
    const SinCos<double> turn = sincos(std::numbers::pi * k / count);
    result.push_back(a * turn.cos + b * turn.sin);
  }
  return result;
}

}  // namespace

bool Thinned::take(const Vec3d& p) {
  const std::array<std::int64_t, 3> cell{index(p.x), index(p.y), index(p.z)};
  for (std::int64_t x = cell[0] - 1; x <= cell[0] + 1; ++x) {
    for (std::int64_t y = cell[1] - 1; y <= cell[1] + 1; ++y) {
      for (std::int64_t z = cell[2] - 1; z <= cell[2] + 1; ++z) {
        if (is_near(p, key(x, y, z))) return false;
      }
    }
  }
  cells_[key(cell[0], cell[1], cell[2])].push_back(p);
  return true;
}

std::int64_t Thinned::index(double x) const { return static_cast<std::int64_t>(std::floor(x / spacing_)); }

bool Thinned::is_near(const Vec3d& p, std::uint64_t key) const {
  const auto found = cells_.find(key);
  if (found == cells_.end()) return false;
  return std::any_of(found->second.begin(), found->second.end(),
                     [&](const Vec3d& q) { return norm2(p - q) < spacing_ * spacing_; });
}

std::vector<Contact> find_contacts(const StampTool& tool, const LiveSurface& surface, const StampStep& step) {
  const double length = norm(step.motion);
  const Vec3d direction = step.motion / length;
  const std::vector<StampPlace> places = places_in(moved(tool.box(), step.to), surface, step);
  std::vector<Contact> contacts = collected<Contact>(places.size(), step.threads, [&](std::size_t i, auto& out) {
    const Vec3d point = places[i].at(surface.positions);
    const std::optional<StampTool::Front> front = tool.front(point - step.to, direction);
    if (!front || dot(front->normal, direction) <= kSideways) return;
    if (front->need > kFarFront * length && dot(tool.nearest_normal(point - step.to), direction) <= kSideways) return;
    out.push_back({places[i], point, 1 - front->need / length});
  });
  std::stable_sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) { return a.tau < b.tau; });
  Thinned thinned(step.spacing);
  std::erase_if(contacts, [&](const Contact& contact) { return !thinned.take(contact.point - step.to); });
  return contacts;
}

std::vector<Penetration> find_intrusions(const StampTool& tool, const LiveSurface& surface, const StampStep& step) {
  const std::vector<StampPlace> places = places_in(moved(tool.box(), step.to), surface, step);
  std::vector<Penetration> found = collected<Penetration>(places.size(), step.threads, [&](std::size_t i, auto& out) {
    const Vec3d point = places[i].at(surface.positions);
    if (const auto way = tool.exit_vector(point - step.to)) out.push_back({places[i], point, *way});
  });
  std::stable_sort(found.begin(), found.end(),
                   [](const Penetration& a, const Penetration& b) { return norm2(a.way) > norm2(b.way); });
  return found;
}

std::vector<StampPlace> find_touching(const StampTool& tool, const LiveSurface& surface, const StampStep& step,
                                      double distance) {
  const Vec3d beside{distance, distance, distance};
  const Box box{tool.box().min - beside, tool.box().max + beside};
  const std::vector<StampPlace> places = places_in(moved(box, step.to), surface, step);
  return collected<StampPlace>(places.size(), step.threads, [&](std::size_t i, auto& out) {
    if (tool.distance(places[i].at(surface.positions) - step.to) < distance) out.push_back(places[i]);
  });
}

double deepest_penetration(const StampTool& tool, const LiveSurface& surface, const StampStep& step) {
  const std::vector<StampPlace> places = places_in(moved(tool.box(), step.to), surface, step);
  const std::vector<double> depths = collected<double>(places.size(), step.threads, [&](std::size_t i, auto& out) {
    out.push_back(tool.depth(places[i].at(surface.positions) - step.to));
  });
  return depths.empty() ? 0 : *std::max_element(depths.begin(), depths.end());
}

StampTool::StampTool(const Mesh& mesh, const Mat3d& pose)
    : positions_(posed_solid(mesh, pose)), triangles_(triangulate(mesh)), tree_(triangles_, positions_) {
  for (const Triangle& t : triangles_) {
    for (const std::uint32_t v : t) box_.extend(positions_[v]);
  }
}

Vec3d StampTool::normal_of(std::uint32_t triangle) const {
  const Triangle& t = triangles_[triangle];
  const Vec3d normal = cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
  const double length = norm(normal);
  return length > 0 ? normal / length : Vec3d{0, 0, 0};
}

// A ray that leaves the tool more often than it enters starts inside; it is outside once all these exits are passed.
std::optional<StampTool::Front> StampTool::front(const Vec3d& p, const Vec3d& direction) const {
  const std::vector<RayHit> hits = tree_.hits(p, direction);
  int inside = 0;
  for (const RayHit& hit : hits) inside += hit.leaves ? 1 : -1;
  if (inside <= 0) return std::nullopt;
  for (const RayHit& hit : hits) {
    inside -= hit.leaves ? 1 : -1;
    if (inside <= 0) return Front{hit.t, normal_of(hit.triangle)};
  }
  return std::nullopt;
}

Vec3d StampTool::nearest_normal(const Vec3d& p) const { return normal_of(tree_.closest(p)->triangle); }

std::optional<Vec3d> StampTool::exit_vector(const Vec3d& p) const {
  if (!front(p, {0, 0, 1})) return std::nullopt;
  return tree_.closest(p)->point - p;
}

double StampTool::distance(const Vec3d& p) const { return norm(tree_.closest(p)->point - p); }

double StampTool::depth(const Vec3d& p) const {
  const std::optional<Vec3d> way = exit_vector(p);
  return way ? norm(*way) : 0.0;
}

double StampTool::half_width(const Vec3d& direction) const {
  double largest = 0;
  for (const Vec3d& across : directions_across(direction, 64)) {
    double low = dot(across, positions_[triangles_[0][0]]);
    double high = low;
    for (const Triangle& t : triangles_) {
      for (const std::uint32_t v : t) {
        low = std::min(low, dot(across, positions_[v]));
        high = std::max(high, dot(across, positions_[v]));
      }
    }
    largest = std::max(largest, high - low);
  }
  return largest / 2;
}

std::optional<double> StampTool::width_at(const Vec3d& p, std::span<const Vec3d> across) const {
  std::vector<double> chords;
  for (const Vec3d& way : across) {
    const std::optional<Front> there = front(p, way);
    const std::optional<Front> back = front(p, -way);
    if (!there || !back) return std::nullopt;
    chords.push_back(there->need + back->need);
  }
  std::nth_element(chords.begin(), chords.begin() + 2, chords.end());
  return chords[2];
}

// Beside a wall the chords that cross it are short for any width of the tool. So the third shortest of eight evenly
// turned chords counts, which is at most 1.2 times the width of a bar.
double StampTool::narrowest_width(const Vec3d& direction, double below) const {
  constexpr std::size_t samples = 128;
  constexpr double left_out = 0.05;
  const std::vector<Vec3d> across = directions_across(direction, 8);
  std::vector<std::pair<double, double>> widths;  // and the area that each stands for
  double area = 0;
  const std::size_t stride = std::max<std::size_t>(1, triangles_.size() / samples);
  for (std::size_t t = 0; t < triangles_.size(); t += stride) {
    const std::array<Vec3d, 3> c = {positions_[triangles_[t][0]], positions_[triangles_[t][1]],
                                    positions_[triangles_[t][2]]};
    const double facing = dot(cross(c[1] - c[0], c[2] - c[0]), direction);
    if (!(facing > 0)) continue;
    const Vec3d face = (c[0] + c[1] + c[2]) / 3;
    const std::optional<Front> back = front(face - direction * (1e-6 * below), -direction);
    if (!back) continue;
    const std::optional<double> width = width_at(face - direction * std::min(below, back->need / 2), across);
    if (!width) continue;
    widths.emplace_back(*width, facing);
    area += facing;
  }
  std::sort(widths.begin(), widths.end());
  double counted = 0;
  for (const auto& [width, share] : widths) {
    counted += share;
    if (counted > left_out * area) return width;
  }
  return 2 * half_width(direction);
}

}  // namespace knead::detail
