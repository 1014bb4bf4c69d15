// Walls on a mesh: putting points back, periodic pairs, layers.
#include "engineering/mesh_walls.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "knead/cells.h"
#include "knead/error.h"

namespace knead::detail {

namespace {

constexpr double kWidth = 0.1;         // of the diagonal
constexpr double kDepth = 0.75;        // of the greatest distance of the mesh from the wall
constexpr double kSmall = 0.125;       // of the width: a correction that the mesh beside the wall can follow
constexpr double kSmallTurn = 0.94;    // cosine of 20 degrees, by which a normal may turn at once
constexpr int kRounds = 16;            // over points that are kept by several walls
constexpr double kSame = 1e-13;        // of the diagonal
constexpr std::size_t kPoints = 1024;  // that one thread processes together

void count(std::size_t points, const WallOptions& options) {
  stop_if_cancelled(options.progress);
  if (options.progress != nullptr) options.progress->done += points;
}

bool is_fixed(const SlidingWall& wall) { return wall.surface.form() == WallSurface::Form::fixed; }

double distance_to_box(const Vec3d& p, const Box& box) {
  Vec3d out{};
  for (std::size_t k = 0; k < 3; ++k) out[k] = std::max({box.min[k] - p[k], 0.0, p[k] - box.max[k]});
  return norm(out);
}

// Returns a weight of 1 at the wall and 0 at the width, smooth at both.
double fade(double distance, double width) {
  const double t = distance / width;
  return t < 1 ? (1 - t * t) * (1 - t * t) : 0;
}

// Returns v after the smallest rotation that takes the unit normal `from` to `to`; v itself for more than 120 degrees.
Vec3d turned(const Vec3d& v, const Vec3d& from, const Vec3d& to) {
  const double cosine = dot(from, to);
  if (!(cosine > -0.5)) return v;
  const Vec3d axis = cross(from, to);
  const Vec3d once = cross(axis, v);
  return v + once + cross(axis, once) / (1 + cosine);
}

// Moves middle nodes along with the corners beside them.
void move_middle_nodes(const VolumeCells& cells, std::span<const Vec3d> flowed, std::span<Vec3d> points) {
  for (std::size_t i = 0; i < cells.middles.cells.size(); ++i) {
    const std::size_t cell = cells.middles.cells[i];
    const std::span<const std::uint32_t> corners = cells.cells.corners_of(cell);
    std::size_t node = cells.middles.first[i];
    for (const auto& [a, b] : edges_of(cells.cells.kinds[cell])) {
      const std::uint32_t v = cells.middles.points[node++];
      points[v] = flowed[v] + (points[corners[a]] - flowed[corners[a]] + points[corners[b]] - flowed[corners[b]]) * 0.5;
    }
  }
}

}  // namespace

struct MeshWalls::Turns {
  std::vector<Vec3d> before;
  std::vector<Vec3d> after;
};

MeshWalls::MeshWalls(WallParts parts, std::span<const Vec3d> points, double diagonal, const WallOptions& options)
    : planes_(std::move(parts.planes)),
      walls_(std::move(parts.walls)),
      pairs_(std::move(parts.pairs)),
      cells_(options.cells),
      kept_(points.size()),
      is_fixed_(points.size()),
      diagonal_(diagonal) {
  if (walls_.empty()) return;
  for (const SlidingWall& wall : walls_) {
    for (const std::uint32_t i : wall.surface.numbers()) {
      on_wall_.push_back(i);
      if (kept_[i] < 255) ++kept_[i];
      if (is_fixed(wall)) is_fixed_[i] = 1;
    }
  }
  for (const auto& [first, second] : pairs_) {
    shifts_.push_back(points[second] - points[first]);
    for (const std::uint32_t i : {first, second}) kept_[i] = std::max<std::uint8_t>(kept_[i], 2);
  }
  std::sort(on_wall_.begin(), on_wall_.end());
  on_wall_.erase(std::unique(on_wall_.begin(), on_wall_.end()), on_wall_.end());
  if (options.progress != nullptr) options.progress->total = points.size() * (walls_.size() + 1);
  for (SlidingWall& wall : walls_) wall.width = width_of(wall, points, options);
  find_links(points, options);
}

double MeshWalls::put_on_planes(std::span<Vec3d> points) const {
  double greatest = 0;
  for (const auto& [plane, numbers] : planes_) {
    const auto& [normal, point] = plane;
    for (const std::uint32_t i : numbers) {
      const double distance = dot(points[i] - point, normal) / dot(normal, normal);
      const Vec3d before = points[i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool is_axis = std::abs(normal[axis]) == 1;
        points[i][axis] = is_axis ? point[axis] : points[i][axis] - distance * normal[axis];
      }
      greatest = std::max(greatest, norm(points[i] - before));
    }
  }
  return greatest;
}

std::shared_ptr<const PointConstraint> MeshWalls::without_layers() const {
  const auto keeps_layers = [](const SlidingWall& wall) { return wall.keeps_layers; };
  if (!cells_ || std::none_of(walls_.begin(), walls_.end(), keeps_layers)) return nullptr;
  auto others = std::make_shared<MeshWalls>(*this);
  const auto is_kept = [&](const Link& link) { return walls_[link.wall].keeps_layers; };
  std::erase_if(others->links_, is_kept);
  std::erase_if(others->wall_links_, is_kept);
  if (pairs_.empty() && std::all_of(walls_.begin(), walls_.end(),
                                    [&](const SlidingWall& wall) { return keeps_layers(wall) || is_fixed(wall); })) {
    others->walls_.clear();
  }
  return others;
}

std::vector<Vec3d> MeshWalls::no_worse(std::span<const Vec3d> before, std::span<const Vec3d> with_layers,
                                       std::span<const Vec3d> without, int threads) const {
  constexpr int kParts = 8;
  constexpr double kSameAngle = 1e-3;  // degrees
  const auto quality = [&](std::span<const Vec3d> points) {
    return std::pair(count_inverted_since(*cells_, before, points, threads),
                     check_cells(*cells_, points, threads).max_non_orthogonality_deg);
  };
  const auto [most_inverted, greatest_angle] = quality(without);
  std::vector<Vec3d> points(with_layers.begin(), with_layers.end());
  for (int part = kParts; part > 0; --part) {
    const double share = static_cast<double>(part) / kParts;
    for (std::size_t i = 0; i < points.size() && part < kParts; ++i) {
      points[i] = without[i] + (with_layers[i] - without[i]) * share;
    }
    const auto [inverted, angle] = quality(points);
    if (inverted <= most_inverted && angle <= greatest_angle + kSameAngle) return points;
  }
  return {without.begin(), without.end()};
}

std::optional<KeptCells> MeshWalls::keep_cells(std::span<const Vec3d> before, std::span<const Vec3d> after,
                                               const CarryPoints& carry, const std::string& name, int threads,
                                               const Progress* progress) const {
  if (!cells_) return std::nullopt;
  std::size_t count = count_inverted_since(*cells_, before, after, threads);
  if (count == 0) return std::nullopt;
  KeptCells kept{{after.begin(), after.end()}};
  // The cells of a layer have no points inside, and nodes of the third order would not move with it.
  if (!cells_->is_flat && cells_->by_corners == 0 && cells_->cells.size() > 0) {
    std::vector<std::uint8_t> fixed(after.size());
    for (const std::uint32_t v : cells_->on_surfaces) fixed[v] = 1;
    const auto carry_on = [&](double from, double to, std::span<Vec3d> points) {
      from == 0 && to == 1 ? static_cast<void>(std::copy(after.begin(), after.end(), points.begin()))
                           : carry(from, to, points);
    };
    const CellOptions options{.fixed = fixed, .threads = threads, .progress = progress};
    DeformedCells deformed = deform_cells(cells_->cells, before, carry_on, options);
    kept = {std::move(deformed.points), deformed.freed};
    move_middle_nodes(*cells_, after, kept.points);
    count = count_inverted_since(*cells_, before, kept.points, threads);
  }
  if (count == 0) return kept;
  throw QualityLimit(fmt::format("{}: {} cell{} would be inverted; deform less, or give the {} another \"{}\"", name,
                                 count, count == 1 ? "" : "s", is_flow() ? "strokes" : "walls",
                                 is_flow() ? "outer" : "width"));
}

double MeshWalls::width_of(const SlidingWall& wall, std::span<const Vec3d> points, const WallOptions& options) const {
  if (wall.width || !wall.is_followed) {
    count(points.size(), options);
    return wall.width.value_or(kInfinity);
  }
  const double most = kWidth * diagonal_;
  Box box;  // of the wall: points far from the box are far from the wall
  for (const std::uint32_t i : wall.surface.numbers()) box.extend(points[i]);
  std::atomic<bool> goes_far = std::any_of(points.begin(), points.end(),
                                           [&](const Vec3d& p) { return distance_to_box(p, box) > most / kDepth; });
  std::vector<double> greatest((points.size() + kPoints - 1) / kPoints);
  parallel_for(points.size(), kPoints, options.threads, [&](std::size_t begin, std::size_t end) {
    count(end - begin, options);
    for (std::size_t i = begin; i < end && !goes_far; ++i) {
      const auto found = wall.surface.tree().closest(points[i], most / kDepth);
      if (!found) goes_far = true;
      if (found) greatest[begin / kPoints] = std::max(greatest[begin / kPoints], found->distance);
    }
  });
  if (goes_far) return most;
  const double depth = *std::max_element(greatest.begin(), greatest.end());
  return depth > 0 ? std::min(most, kDepth * depth) : most;
}

// If several walls are near, the nearer one has the greater weight, and at a wall it has the whole weight.
void MeshWalls::find_links(std::span<const Vec3d> points, const WallOptions& options) {
  const auto is_on = [&](std::uint32_t wall, std::uint32_t i) {
    const std::vector<std::uint32_t>& numbers = walls_[wall].surface.numbers();
    return std::binary_search(numbers.begin(), numbers.end(), i);
  };
  std::vector<std::vector<Link>> parts((points.size() + kPoints - 1) / kPoints);
  parallel_for(points.size(), kPoints, options.threads, [&](std::size_t begin, std::size_t end) {
    count(end - begin, options);
    std::vector<Link>& own = parts[begin / kPoints];
    for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
      if (is_fixed_[i] != 0) continue;
      const std::size_t first = own.size();
      double sum = 0;
      for (std::uint32_t w = 0; w < walls_.size(); ++w) {
        if (!walls_[w].is_followed || (kept_[i] != 0 && is_on(w, i))) continue;
        const auto found = walls_[w].surface.tree().closest(points[i], *walls_[w].width);
        if (!found) continue;
        const double near = std::max(found->distance, 1e-15 * diagonal_);
        const double faded = fade(near, *walls_[w].width);
        const double weight = faded / (near * near);
        sum += weight;
        own.push_back({i, w, walls_[w].surface.faces()[found->triangle], found->barycentric, faded * weight});
      }
      for (std::size_t k = first; k < own.size(); ++k) own[k].share = sum > 0 ? own[k].share / sum : 0;
    }
    std::erase_if(own, [&](const Link& link) { return !(link.share > 0) || is_fixed(walls_[link.wall]); });
  });
  for (const std::vector<Link>& part : parts) {
    for (const Link& link : part) (kept_[link.point] == 0 ? links_ : wall_links_).push_back(link);
  }
}

// Moves both points of a pair by the mean of their motions.
void MeshWalls::move_pairs(std::span<const Vec3d> before, std::span<Vec3d> after) const {
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [first, second] = pairs_[k];
    if (after[first] == before[first] && after[second] == before[second]) continue;
    const bool stays = is_fixed_[first] != 0 || is_fixed_[second] != 0;
    const Vec3d motion = (after[first] - before[first]) * 0.5 + (after[second] - before[second]) * 0.5;
    after[first] = stays ? before[first] : before[first] + motion;
    after[second] = stays ? before[second] : after[first] + shifts_[k];
  }
}

void MeshWalls::put_points_back(std::span<const Vec3d> before, std::span<Vec3d> after, int threads) const {
  double change = kInfinity;
  for (int round = 0; round < kRounds && change > kSame * diagonal_; ++round) {
    std::vector<Vec3d> last;
    if (round > 0) {
      for (const std::uint32_t i : on_wall_) last.push_back(after[i]);
    }
    for (const SlidingWall& wall : walls_) {
      const std::vector<std::uint32_t>& numbers = wall.surface.numbers();
      parallel_for(numbers.size(), kPoints, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const std::uint32_t i = numbers[k];
          const bool is_done = round > 0 && kept_[i] == 1;
          if (is_done || after[i] == before[i]) continue;
          after[i] = is_fixed_[i] != 0 ? before[i] : wall.surface.put_back(k, after[i], before[i]);
        }
      });
    }
    move_pairs(before, after);
    if (round == 0) continue;
    change = 0;
    for (std::size_t k = 0; k < on_wall_.size(); ++k) change = std::max(change, norm(after[on_wall_[k]] - last[k]));
  }
}

// Returns the place to which the wall moves a point beside it.
Vec3d MeshWalls::beside(const Link& link, const Turns& turns, std::span<const Vec3d> before,
                        std::span<const Vec3d> after) const {
  const std::vector<std::uint32_t>& numbers = walls_[link.wall].surface.numbers();
  Vec3d foot{};
  Vec3d foot_after{};
  bool has_moved = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t i = numbers[link.corners[k]];
    foot += before[i] * link.weights[k];
    foot_after += after[i] * link.weights[k];
    has_moved = has_moved || before[i] != after[i] || turns.before[link.corners[k]] != turns.after[link.corners[k]];
  }
  const Vec3d& p = before[link.point];
  if (!has_moved) return p;
  Vec3d arm{};
  for (std::size_t k = 0; k < 3; ++k) {
    arm += turned(p - foot, turns.before[link.corners[k]], turns.after[link.corners[k]]) * link.weights[k];
  }
  return foot_after + arm;
}

std::vector<MeshWalls::Turns> MeshWalls::turns_of(std::span<const Vec3d> before, std::span<const Vec3d> after) const {
  std::vector<Turns> turns(walls_.size());
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    if (is_fixed(walls_[w]) || !walls_[w].is_followed) continue;
    std::vector<Vec3d> old;
    std::vector<Vec3d> now;
    for (const std::uint32_t i : walls_[w].surface.numbers()) {
      old.push_back(before[i]);
      now.push_back(after[i]);
    }
    turns[w] = {walls_[w].surface.normals(old), walls_[w].surface.normals(now)};
  }
  return turns;
}

void MeshWalls::follow(const std::vector<Link>& links, std::span<const Vec3d> before, std::span<const Vec3d> flowed,
                       std::span<Vec3d> after, int threads) const {
  const std::vector<Turns> turns = turns_of(before, after);
  std::vector<Vec3d> changes(links.size());
  parallel_for(links.size(), kPoints, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      changes[k] = (beside(links[k], turns[links[k].wall], before, after) - flowed[links[k].point]) * links[k].share;
    }
  });
  for (std::size_t k = 0; k < links.size(); ++k) {
    const std::uint32_t i = links[k].point;
    if (k == 0 || links[k - 1].point != i) after[i] = flowed[i];
    after[i] += changes[k];
  }
}

PointCorrection MeshWalls::put_back(std::span<const Vec3d> before, std::span<Vec3d> after, int threads) const {
  const std::vector<Vec3d> flowed(after.begin(), after.end());
  put_points_back(before, after, threads);
  follow(wall_links_, before, flowed, after, threads);
  put_points_back(before, after, threads);
  follow(links_, before, flowed, after, threads);
  PointCorrection correction;
  for (const SlidingWall& wall : walls_) {
    for (const std::uint32_t i : wall.surface.numbers()) {
      const double distance = norm(after[i] - flowed[i]);
      correction.greatest = std::max(correction.greatest, distance);
      if (wall.is_followed && distance > kSmall * *wall.width) correction.is_small = false;
    }
  }
  for (const Turns& turns : turns_of(before, after)) {
    for (std::size_t k = 0; k < turns.before.size(); ++k) {
      const bool turns_far = turns.before[k] != Vec3d{} && dot(turns.before[k], turns.after[k]) < kSmallTurn;
      if (turns_far) correction.is_small = false;
    }
  }
  return correction;
}

}  // namespace knead::detail
