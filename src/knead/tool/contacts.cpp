#include "knead/tool/contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <unordered_map>

#include "knead/math/parallel.h"

namespace knead::tool_detail {

namespace {

constexpr double kSideways = 0.1;      // n.v0 up to that much of |v0|: the face looks sideways or back
constexpr double kFarFront = 1.5;      // of |v0|
constexpr double kMostSamples = 1000;  // along an edge

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

bool holds(const Box& box, const Vec3d& p) {
  return p.x >= box.min.x && p.x <= box.max.x && p.y >= box.min.y && p.y <= box.max.y && p.z >= box.min.z &&
         p.z <= box.max.z;
}

bool may_reach(const Box& box, const std::array<Vec3d, 3>& c) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::min({c[0][k], c[1][k], c[2][k]}) > box.max[k] || std::max({c[0][k], c[1][k], c[2][k]}) < box.min[k]) {
      return false;
    }
  }
  return true;
}

// Into how many parts no longer than spacing.
int parts_of(double length, double spacing) {
  return static_cast<int>(std::clamp<double>(std::ceil(length / spacing), 1, kMostSamples));
}

// Places on the triangle, its corners left out, in rows along its longest side: no more of them on a sliver than on a
// line.
void sample(const Triangle& t, const std::array<Vec3d, 3>& c, const Box& box, double spacing,
            std::vector<Place>& places) {
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
      Place place{t, {}};
      place.barycentric[apex] = up;
      place.barycentric[j] = (1 - up) * column / columns;
      place.barycentric[i] = (1 - up) * (columns - column) / columns;
      if (holds(box, c[i] * place.barycentric[i] + c[j] * place.barycentric[j] + c[apex] * up)) places.push_back(place);
    }
  }
}

// Vertices and samples inside the box.
std::vector<Place> places_in(const Box& box, const LiveSurface& surface, const StampStep& step) {
  const std::span<const Vec3d> positions = surface.positions;
  std::vector<Place> places = collected<Place>(positions.size(), step.threads, [&](std::size_t i, auto& out) {
    const auto v = static_cast<std::uint32_t>(i);
    if (holds(box, positions[i])) out.push_back({{v, v, v}});
  });
  const std::vector<Place> samples =
      collected<Place>(surface.triangles.size(), step.threads, [&](std::size_t i, auto& out) {
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
  const std::vector<Place> places = places_in(moved(tool.box(), step.to), surface, step);
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

std::vector<Intrusion> find_intrusions(const StampTool& tool, const LiveSurface& surface, const StampStep& step) {
  const std::vector<Place> places = places_in(moved(tool.box(), step.to), surface, step);
  std::vector<Intrusion> found = collected<Intrusion>(places.size(), step.threads, [&](std::size_t i, auto& out) {
    const Vec3d point = places[i].at(surface.positions);
    if (const auto way = tool.way_out(point - step.to)) out.push_back({places[i], point, *way});
  });
  std::stable_sort(found.begin(), found.end(),
                   [](const Intrusion& a, const Intrusion& b) { return norm2(a.way) > norm2(b.way); });
  return found;
}

std::vector<Place> find_touching(const StampTool& tool, const LiveSurface& surface, const StampStep& step,
                                 double distance) {
  const Vec3d beside{distance, distance, distance};
  const Box box{tool.box().min - beside, tool.box().max + beside};
  const std::vector<Place> places = places_in(moved(box, step.to), surface, step);
  return collected<Place>(places.size(), step.threads, [&](std::size_t i, auto& out) {
    if (tool.distance(places[i].at(surface.positions) - step.to) < distance) out.push_back(places[i]);
  });
}

double deepest_penetration(const StampTool& tool, const LiveSurface& surface, const StampStep& step) {
  const std::vector<Place> places = places_in(moved(tool.box(), step.to), surface, step);
  const std::vector<double> depths = collected<double>(places.size(), step.threads, [&](std::size_t i, auto& out) {
    out.push_back(tool.depth(places[i].at(surface.positions) - step.to));
  });
  return depths.empty() ? 0 : *std::max_element(depths.begin(), depths.end());
}

}  // namespace knead::tool_detail
