// The limb that a point of a surface belongs to: its vertices, root and neck.
#include "knead/editor/tools.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <queue>
#include <stdexcept>

#include "strokes/pose.h"

namespace knead {

namespace {

constexpr std::size_t kLevels = 200;  // from the tip to the farthest place
constexpr double kWidens = 0.75;      // of the greatest girth within the next thickness: less is a neck
constexpr double kSameNeck = 1.2;     // of a girth: what a thinner place near it may have
constexpr double kMaxArea = 0.6;      // of the surface, of a limb
// Thicknesses that bend: of the limb beyond its neck, behind it, and along what runs beside the limb.
constexpr double kBendingAhead = 0.75;
constexpr double kBending = 1.5;
constexpr double kBendingBeside = 0.8;
constexpr double kMaxThickness = 0.08;  // of the shape's diagonal
constexpr std::size_t kEnds = 5;        // of a shape, that are looked at
constexpr double kCoreOfLimb = 1.1;     // of the least distance from the farthest end
constexpr double kStraightLimb = 0.7;   // of a distance along the surface: the least rise of a path along a limb
constexpr double kTip = 0.9;            // of that, at a tip

// The vertices next to each vertex.
class Neighbours {
 public:
  Neighbours(std::size_t vertices, std::span<const Triangle> triangles) : first_(vertices + 1) {
    for (const Triangle& t : triangles) {
      for (const std::uint32_t v : t) first_[v + 1] += 2;
    }
    for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
    next_.resize(first_.back());
    std::vector<std::uint32_t> end(first_.begin(), first_.end() - 1);
    for (const Triangle& t : triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        next_[end[t[i]]++] = t[(i + 1) % 3];
        next_[end[t[i]]++] = t[(i + 2) % 3];
      }
    }
  }

  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(next_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> next_;
};

using Reached = std::pair<double, std::uint32_t>;
using Queue = std::priority_queue<Reached, std::vector<Reached>, std::greater<>>;

// Returns distances along edges; infinite for unconnected vertices.
std::vector<double> distances_from(std::span<const std::uint32_t> starts, std::span<const Vec3d> positions,
                                   const Neighbours& neighbours) {
  std::vector<double> distances(positions.size(), kInfinity);
  Queue queue;
  for (const std::uint32_t start : starts) {
    distances[start] = 0;
    queue.emplace(0, start);
  }
  while (!queue.empty()) {
    const auto [distance, v] = queue.top();
    queue.pop();
    if (distance > distances[v]) continue;
    for (const std::uint32_t next : neighbours.of(v)) {
      const double there = distance + norm(positions[next] - positions[v]);
      if (there >= distances[next]) continue;
      distances[next] = there;
      queue.emplace(there, next);
    }
  }
  return distances;
}

std::vector<double> distances_from(std::uint32_t start, std::span<const Vec3d> positions,
                                   const Neighbours& neighbours) {
  return distances_from(std::span(&start, 1), positions, neighbours);
}

std::uint32_t farthest(const std::vector<double>& distances) {
  std::uint32_t best = 0;
  double most = -1;
  for (std::uint32_t v = 0; v < distances.size(); ++v) {
    if (distances[v] < kInfinity && distances[v] > most) {
      most = distances[v];
      best = v;
    }
  }
  return best;
}

// Returns the core of the shape: the vertices about equally far from its ends.
std::vector<std::uint32_t> core_of(std::vector<double> nearest, std::span<const Vec3d> positions,
                                   const Neighbours& neighbours) {
  std::vector<double> greatest(positions.size());
  for (std::size_t i = 0; i < kEnds; ++i) {
    const std::vector<double> from_end = distances_from(farthest(nearest), positions, neighbours);
    for (std::size_t v = 0; v < positions.size(); ++v) {
      nearest[v] = i == 0 ? from_end[v] : std::min(nearest[v], from_end[v]);
      greatest[v] = std::max(greatest[v], from_end[v]);
    }
  }
  const double least = *std::min_element(greatest.begin(), greatest.end());
  std::vector<std::uint32_t> core;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (greatest[v] <= kCoreOfLimb * least) core.push_back(v);
  }
  return core;
}

// Returns the highest of the places to which the surface rises from the vertex without a detour, and those about as
// high.
std::vector<std::uint32_t> tip_above(std::uint32_t vertex, std::span<const Vec3d> positions,
                                     const Neighbours& neighbours) {
  const std::vector<double> from_vertex = distances_from(vertex, positions, neighbours);
  const std::vector<double> heights =
      distances_from(core_of(from_vertex, positions, neighbours), positions, neighbours);
  double most = 0;
  std::vector<std::uint32_t> above;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const double rise = heights[v] - heights[vertex];
    if (!(heights[v] < kInfinity) || rise < kStraightLimb * from_vertex[v]) continue;
    above.push_back(v);
    most = std::max(most, rise);
  }
  std::erase_if(above, [&](std::uint32_t v) { return heights[v] - heights[vertex] < kTip * most; });
  return above;
}

// The cross-sections of a shape at equally spaced distances from a tip.
struct Sections {
  double spacing = 0;
  std::vector<double> girths;
  std::vector<Vec3d> middles;
  std::vector<double> areas;  // on the tip's side, as a fraction of the surface

  double level(std::size_t i) const { return spacing * static_cast<double>(i); }
  double thickness(std::size_t i) const { return girths[i] / std::numbers::pi; }
};

void add_triangle(const Triangle& t, std::span<const Vec3d> positions, const std::vector<double>& distances,
                  Sections& sections) {
  Triangle s = t;
  std::sort(s.begin(), s.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(distances[a], a) < std::pair(distances[b], b);  // a whole order: the same in every library
  });
  const std::array<double, 3> d{distances[s[0]], distances[s[1]], distances[s[2]]};
  if (!(d[2] < kInfinity)) return;
  const std::array<Vec3d, 3> p{positions[s[0]], positions[s[1]], positions[s[2]]};
  const auto at = [&](std::size_t a, std::size_t b, double level) {
    return d[b] > d[a] ? p[a] + (p[b] - p[a]) * ((level - d[a]) / (d[b] - d[a])) : p[a];
  };
  const auto index = [&](double depth) {
    return std::min(static_cast<std::size_t>(std::max(std::ceil(depth / sections.spacing), 0.0)), kLevels);
  };
  const std::size_t last = index(d[2]);
  for (std::size_t i = index(d[0]); i < last; ++i) {
    const double level = sections.level(i);
    const Vec3d a = at(0, 2, level);
    const Vec3d b = level < d[1] ? at(0, 1, level) : at(1, 2, level);
    const double length = norm(b - a);
    sections.girths[i] += length;
    sections.middles[i] += (a + b) * (0.5 * length);
  }
  sections.areas[last] += 0.5 * norm(cross(p[1] - p[0], p[2] - p[0]));
}

Sections sections_of(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                     const std::vector<double>& distances) {
  Sections sections;
  sections.spacing = distances[farthest(distances)] / static_cast<double>(kLevels);
  sections.girths.resize(kLevels + 1);
  sections.middles.resize(kLevels + 1);
  sections.areas.resize(kLevels + 1);
  if (!(sections.spacing > 0)) return sections;
  for (const Triangle& t : triangles) add_triangle(t, positions, distances, sections);
  double sum = 0;
  for (std::size_t i = 0; i <= kLevels; ++i) {
    if (sections.girths[i] > 0) sections.middles[i] = sections.middles[i] / sections.girths[i];
    sum += sections.areas[i];
    sections.areas[i] = sum;
  }
  for (double& area : sections.areas) area /= sum;
  return sections;
}

// Returns the girth divided by the greatest one within the next thickness: small before the shape widens.
double neck_at(const Sections& sections, std::size_t i) {
  double most = sections.girths[i];
  for (std::size_t k = i; k <= kLevels && sections.level(k) <= sections.level(i) + sections.thickness(i); ++k) {
    most = std::max(most, sections.girths[k]);
  }
  return most > 0 ? sections.girths[i] / most : 1;
}

// Returns the first neck from a level on; nothing if there is none.
std::optional<std::size_t> find_neck(const Sections& sections, std::size_t from) {
  for (std::size_t i = from; i <= kLevels && sections.areas[i] <= kMaxArea; ++i) {
    // Within one thickness of the tip, the shape widens because of the tip.
    const bool is_tip = !(sections.girths[i] > 0) || sections.level(i) < sections.thickness(i);
    if (is_tip || neck_at(sections, i) > kWidens) continue;
    std::size_t best = i;
    const double end = sections.level(i) + sections.thickness(i);
    for (std::size_t k = i; k <= kLevels && sections.level(k) <= end; ++k) {
      const bool is_thin = sections.girths[k] <= kSameNeck * sections.girths[i];
      if (is_thin && neck_at(sections, k) < neck_at(sections, best)) best = k;
    }
    return best;
  }
  return std::nullopt;
}

// The cross-section at which a part of a shape ends.
struct Border {
  Vec3d middle{0, 0, 0};
  double girth = 0;  // 0: nowhere
  Vec3d inwards{0, 0, 0};
};

Border border_of(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                 const std::vector<bool>& is_part) {
  Border border;
  for (const Triangle& t : triangles) {
    std::array<Vec3d, 2> cut;  // the middles of the edges that lead out of the part
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i];
      const std::uint32_t to = t[(i + 1) % 3];
      if (is_part[from] != is_part[to]) cut[count++] = (positions[from] + positions[to]) * 0.5;
    }
    if (count == 0) continue;
    const double length = norm(cut[1] - cut[0]);
    border.girth += length;
    border.middle += (cut[0] + cut[1]) * (0.5 * length);
  }
  if (!(border.girth > 0)) return border;
  border.middle = border.middle / border.girth;
  Vec3d near{0, 0, 0};
  Vec3d all{0, 0, 0};
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!is_part[v]) continue;
    const Vec3d off = positions[v] - border.middle;
    all += off;
    if (norm(off) < border.girth / std::numbers::pi) near += off;
  }
  const Vec3d along = norm(near) > 0 ? near : all;
  if (norm(along) > 0) border.inwards = normalized(along);
  return border;
}

}  // namespace

std::vector<std::uint32_t> bending_about(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                         std::span<const std::uint32_t> part) {
  std::vector<bool> is_part(positions.size(), false);
  for (const std::uint32_t v : part) is_part.at(v) = true;
  const Border border = border_of(positions, triangles, is_part);
  if (!(border.girth > 0)) return {};
  LiveSurface shape;
  shape.positions = positions;
  shape.triangles = triangles;
  const double thickness = std::min(border.girth / std::numbers::pi, kMaxThickness * detail::diagonal_of(shape));
  const std::vector<double> behind = distances_from(part, positions, Neighbours(positions.size(), triangles));
  const Vec3d neck = border.middle - border.inwards * (kBendingAhead * thickness);
  std::vector<std::uint32_t> bending;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const bool is_beside = dot(positions[v] - neck, border.inwards) > 0;
    const double reach = (kBendingAhead + (is_beside ? kBendingBeside : kBending)) * thickness;
    if (!is_part[v] && behind[v] <= reach) bending.push_back(v);
  }
  return bending;
}

Limb find_limb(std::span<const Vec3d> positions, std::span<const Triangle> triangles, std::uint32_t vertex) {
  if (vertex >= positions.size()) throw std::out_of_range("find_limb: there is no such vertex");
  Limb limb;
  const Neighbours neighbours(positions.size(), triangles);
  if (neighbours.of(vertex).empty()) return limb;
  const std::vector<std::uint32_t> tip = tip_above(vertex, positions, neighbours);
  const std::vector<double> distances = distances_from(tip, positions, neighbours);
  const Sections sections = sections_of(positions, triangles, distances);
  if (!(sections.spacing > 0)) return limb;
  const auto here = std::min(static_cast<std::size_t>(std::ceil(distances[vertex] / sections.spacing)), kLevels - 1);
  const std::optional<std::size_t> neck = find_neck(sections, here);
  const std::size_t joint = std::max<std::size_t>(neck.value_or(here), 1);
  limb.has_neck = neck.has_value();
  limb.joint = sections.middles[joint];
  limb.girth = sections.girths[joint];
  const double thickness = sections.thickness(joint);
  const double neck_level = sections.level(joint);
  const double end = std::max(neck_level - kBendingAhead * thickness, 0.5 * neck_level);
  const auto back = static_cast<std::size_t>(0.5 * thickness / sections.spacing) + 1;
  const Vec3d along = (back < joint ? sections.middles[joint - back] : positions[tip.front()]) - limb.joint;
  if (norm(along) > 0) limb.direction = normalized(along);
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (distances[v] <= end) limb.vertices.push_back(v);
  }
  limb.bending = bending_about(positions, triangles, limb.vertices);
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const bool bends = std::binary_search(limb.bending.begin(), limb.bending.end(), v);
    if (distances[v] > end && distances[v] < kInfinity && !bends) limb.body.push_back(v);
  }
  return limb;
}

}  // namespace knead
