// Finds the limbs and joints of a pose.
#include "skin/joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "knead/vec.h"

namespace knead::detail {

namespace {

constexpr double kMaxSameTurn = 5e-3;     // radians: bones with a smaller relative turn move alike,
constexpr double kMaxSameShift = 1e-3;    // if their relative shift is also smaller than this, of the diagonal
constexpr double kStageRatio = 3;         // of the radii within one stage
constexpr double kMinFleshLength = 0.6;   // the remaining length of the flesh inside a joint, relative to rest
constexpr double kMaxBendingLength = 3;   // in radii
constexpr double kUsualDetail = 2;        // spacing of the grids in radii of the limbs
constexpr double kThinDetail = 1.5;       // the same for fingers and the like, which lie beside each other:
constexpr double kThinRadius = 0.01;      // limbs with a smaller radius, of the diagonal
constexpr double kMaxScaling = 0.02;      // of a bone's volume; a note names more
constexpr double kFallbackRadius = 0.03;  // of the diagonal, for joints without flesh

// Returns the area that belongs to each vertex.
std::vector<double> areas_of(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  std::vector<double> areas(positions.size(), 0.0);
  for (const Triangle& t : triangles) {
    const double area = norm(cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]])) / 6;
    for (const std::uint32_t v : t) areas[v] += area;
  }
  if (triangles.empty()) std::fill(areas.begin(), areas.end(), 1.0);
  return areas;
}

// Finds the joints of a pose.
class JointFinder {
 public:
  JointFinder(std::span<const Vec3d> positions, std::span<const Triangle> triangles, const Skin& skin,
              const SkinPose& pose)
      : positions_(positions), skin_(skin), areas_(areas_of(positions, triangles)) {
    Box box;
    for (std::size_t v = 0; v < positions.size(); ++v) {
      if (areas_[v] > 0) box.extend(positions[v]);
    }
    diagonal_ = box.diagonal();
    find_rigid(pose);
  }

  Joints run(double detail) {
    find_tree();
    find_base();
    find_limbs();
    find_weights();
    remove_free_limbs();
    for (std::size_t i = 1; i < joints_.limbs.size(); ++i) measure(i);
    find_stages(detail);
    return std::move(joints_);
  }

 private:
  // Finds the rigid motion of each bone, about the centre of its vertices.
  void find_rigid(const SkinPose& pose) {
    const std::size_t bones = pose.size();
    area_.assign(bones, 0.0);
    middle_.assign(bones, Vec3d{0, 0, 0});
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      const double sum = sum_of(v);
      for (std::size_t i = skin_.begin[v]; i < skin_.begin[v + 1] && sum > 0; ++i) {
        const double area = areas_[v] * skin_.weights[i].weight / sum;
        area_[skin_.weights[i].bone] += area;
        middle_[skin_.weights[i].bone] += positions_[v] * area;
      }
    }
    const std::vector<BoneTransform> motions = motions_of(skin_, pose);
    std::size_t scaled = 0;
    for (std::size_t b = 0; b < bones; ++b) {
      middle_[b] = area_[b] > 0 ? middle_[b] / area_[b] : skin_.rest[b].offset;
      rigid_.push_back(rigid_part(motions[b], skin_.rest[b].offset));
      const double volume = determinant(motions[b].linear);
      if (area_[b] > 0 && std::abs(volume - 1) > kMaxScaling) ++scaled;
    }
    if (scaled > 0) {
      joints_.notes.push_back(fmt::format(
          "{} of {} bones scale in this pose; a flow keeps the volume, so that only their turns count", scaled, bones));
    }
  }

  double sum_of(std::size_t v) const {
    double sum = 0;
    for (std::size_t i = skin_.begin[v]; i < skin_.begin[v + 1]; ++i) sum += skin_.weights[i].weight;
    return sum;
  }

  // Connects each bone with its parent, and roots with each other.
  void find_tree() {
    const std::size_t bones = rigid_.size();
    near_.assign(bones, {});
    const std::vector<std::int32_t> parents = parents_of(skin_, positions_.size());
    const auto first = static_cast<std::size_t>(std::find(parents.begin(), parents.end(), -1) - parents.begin());
    for (std::size_t b = 0; b < bones; ++b) {
      if (b == first) continue;
      const std::size_t other = parents[b] < 0 ? first : static_cast<std::size_t>(parents[b]);
      near_[b].push_back(other);
      near_[other].push_back(b);
    }
  }

  bool move_alike(std::size_t a, std::size_t b) const {
    const Rigid relative = inverse(rigid_[a]) * rigid_[b];
    if (angle_of(relative.turn) > kMaxSameTurn) return false;
    const auto shift = [&](const Vec3d& p) { return norm(relative(p) - p); };
    return std::max(shift(skin_.rest[b].offset), shift(middle_[b])) <= kMaxSameShift * diagonal_;
  }

  // Groups connected bones that move alike; the base is the group with most of the surface.
  void find_base() {
    const std::size_t bones = rigid_.size();
    group_.assign(bones, bones);
    std::vector<double> area;
    for (std::size_t start = 0; start < bones; ++start) {
      if (group_[start] != bones) continue;
      const std::size_t group = area.size();
      area.push_back(0);
      std::vector<std::size_t> waiting{start};
      group_[start] = group;
      while (!waiting.empty()) {
        const std::size_t b = waiting.back();
        waiting.pop_back();
        area[group] += area_[b];
        for (const std::size_t other : near_[b]) {
          if (group_[other] != bones || !move_alike(start, other)) continue;
          group_[other] = group;
          waiting.push_back(other);
        }
      }
    }
    const auto most = static_cast<std::size_t>(std::max_element(area.begin(), area.end()) - area.begin());
    for (std::size_t b = 0; b < bones; ++b) {
      if (group_[b] == most && (group_[base_bone_] != most || area_[b] > area_[base_bone_])) base_bone_ = b;
    }
    joints_.base = rigid_[base_bone_];
  }

  // Makes limbs of the groups, beginning with the base.
  void find_limbs() {
    limb_.assign(rigid_.size(), rigid_.size());
    std::vector<std::size_t> of_group(rigid_.size(), rigid_.size());
    std::vector<std::size_t> waiting{base_bone_};
    joints_.limbs.push_back({std::nullopt, static_cast<std::uint32_t>(base_bone_)});
    of_group[group_[base_bone_]] = 0;
    limb_[base_bone_] = 0;
    for (std::size_t next = 0; next < waiting.size(); ++next) {
      const std::size_t b = waiting[next];
      for (const std::size_t other : near_[b]) {
        if (limb_[other] != rigid_.size()) continue;
        std::size_t& limb = of_group[group_[other]];
        if (limb == rigid_.size()) {
          limb = joints_.limbs.size();
          joints_.limbs.push_back({limb_[b], static_cast<std::uint32_t>(other)});
        }
        limb_[other] = limb;
        SkinLimb& known = joints_.limbs[limb];
        if (limb != 0 && area_[other] > area_[known.bone]) known.bone = static_cast<std::uint32_t>(other);
        waiting.push_back(other);
      }
    }
  }

  void find_weights() {
    joints_.begin.assign(1, 0);
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      const double sum = sum_of(v);
      std::map<std::uint32_t, double> of_limb;
      for (std::size_t i = skin_.begin[v]; i < skin_.begin[v + 1] && sum > 0; ++i) {
        const BoneWeight& w = skin_.weights[i];
        if (w.weight > 0) of_limb[static_cast<std::uint32_t>(limb_[w.bone])] += w.weight / sum;
      }
      for (const auto& [limb, weight] : of_limb) joints_.weights.push_back({limb, weight});
      joints_.begin.push_back(joints_.weights.size());
    }
  }

  // Removes limbs without vertices, if no limb behind them has any.
  void remove_free_limbs() {
    std::vector<bool> is_used(joints_.limbs.size(), false);
    is_used[0] = true;
    for (const BoneWeight& w : joints_.weights) is_used[w.bone] = true;
    for (std::size_t i = is_used.size() - 1; i > 0; --i) {
      if (is_used[i]) is_used[*joints_.limbs[i].before] = true;
    }
    std::vector<std::size_t> number(is_used.size());
    std::vector<SkinLimb> used;
    for (std::size_t i = 0; i < is_used.size(); ++i) {
      number[i] = used.size();
      if (!is_used[i]) continue;
      used.push_back(joints_.limbs[i]);
      if (i > 0) used.back().before = number[*used.back().before];
    }
    joints_.limbs = std::move(used);
    for (BoneWeight& w : joints_.weights) w.bone = static_cast<std::uint32_t>(number[w.bone]);
  }

  // Returns for each vertex its weight beyond a limb's joint.
  std::vector<double> weights_beyond(std::size_t limb) const {
    std::vector<bool> beyond(joints_.limbs.size(), false);
    for (std::size_t i = limb; i < beyond.size(); ++i) {
      beyond[i] = i == limb || (joints_.limbs[i].before && beyond[*joints_.limbs[i].before]);
    }
    std::vector<double> sums(positions_.size(), 0.0);
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      for (std::size_t i = joints_.begin[v]; i < joints_.begin[v + 1]; ++i) {
        if (beyond[joints_.weights[i].bone]) sums[v] += joints_.weights[i].weight;
      }
    }
    return sums;
  }

  // Finds the position, direction and radius of the flesh at a joint, and its screw.
  void measure(std::size_t number) {
    constexpr double kMinShare = 0.1;
    SkinLimb& limb = joints_.limbs[number];
    const std::vector<double> beyond = weights_beyond(number);
    Vec3d middle{0, 0, 0};
    double mean = 0;
    double area = 0;
    std::vector<std::size_t> flesh;
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      if (!(beyond[v] > kMinShare && beyond[v] < 1 - kMinShare)) continue;
      flesh.push_back(v);
      middle += positions_[v] * areas_[v];
      mean += beyond[v] * areas_[v];
      area += areas_[v];
    }
    const Rigid relative = inverse(rigid_[joints_.limbs[*limb.before].bone]) * rigid_[limb.bone];
    limb.center = area > 0 ? middle / area : skin_.rest[limb.bone].offset;
    limb.screw = screw_of(relative, limb.center);
    if (!(area > 0)) return;
    Vec3d along{0, 0, 0};
    for (const std::size_t v : flesh) {
      along += (positions_[v] - limb.center) * (areas_[v] * (beyond[v] - mean / area));
    }
    if (norm(along) > 0) limb.direction = normalized(along);
    std::vector<double> radii;
    radii.reserve(flesh.size());
    for (const std::size_t v : flesh) radii.push_back(norm(cross(positions_[v] - limb.center, limb.direction)));
    std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2), radii.end());
    limb.radius = radii[radii.size() / 2];
  }

  // Assigns joints of about one size to a stage, the smallest first.
  void find_stages(double detail) {
    std::vector<std::size_t> order;
    for (std::size_t i = 1; i < joints_.limbs.size(); ++i) {
      SkinLimb& limb = joints_.limbs[i];
      if (!(limb.radius > 0)) limb.radius = kFallbackRadius * diagonal_;
      order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return joints_.limbs[a].radius < joints_.limbs[b].radius; });
    double first = 0;
    for (const std::size_t i : order) {
      SkinLimb& limb = joints_.limbs[i];
      if (joints_.spacing.empty() || limb.radius > kStageRatio * first) {
        first = limb.radius;
        const double usual = first < kThinRadius * diagonal_ ? kThinDetail : kUsualDetail;
        joints_.spacing.push_back((detail > 0 ? detail : usual) * first);
        joints_.is_thin.push_back(first < kThinRadius * diagonal_);
      }
      limb.stage = joints_.spacing.size() - 1;
    }
    joints_.stages = joints_.spacing.size();
  }

  std::span<const Vec3d> positions_;
  const Skin& skin_;
  std::vector<double> areas_;
  double diagonal_ = 0;
  std::vector<double> area_;   // of each bone
  std::vector<Vec3d> middle_;  // of its vertices
  std::vector<Rigid> rigid_;
  std::vector<std::vector<std::size_t>> near_;
  std::vector<std::size_t> group_;
  std::size_t base_bone_ = 0;
  std::vector<std::size_t> limb_;  // of each bone
  Joints joints_;
};

}  // namespace

Joints find_joints(std::span<const Vec3d> positions, std::span<const Triangle> triangles, const Skin& skin,
                   const SkinPose& pose, double detail) {
  return JointFinder(positions, triangles, skin, pose).run(detail);
}

double SkinLimb::bending_length() const {
  return std::min(kMaxBendingLength * radius, screw.angle * radius / (1 - kMinFleshLength));
}

std::vector<Rigid> Joints::motions(std::size_t stage, double part) const {
  std::vector<Rigid> result(limbs.size());
  for (std::size_t i = 1; i < limbs.size(); ++i) {
    const SkinLimb& limb = limbs[i];
    const double done = limb.stage < stage ? 1 : limb.stage == stage ? part : 0;
    result[i] = result[*limb.before] * limb.screw.at(done * limb.reached);
  }
  return result;
}

std::size_t Joints::main_limb(std::size_t vertex) const {
  std::size_t limb = 0;
  double most = 0;
  for (std::size_t i = begin[vertex]; i < begin[vertex + 1]; ++i) {
    if (!(weights[i].weight > most)) continue;
    most = weights[i].weight;
    limb = weights[i].bone;
  }
  return limb;
}

std::optional<std::size_t> Joints::rigid_limb(std::size_t vertex, double weight) const {
  for (std::size_t i = begin[vertex]; i < begin[vertex + 1]; ++i) {
    if (weights[i].weight > weight) return weights[i].bone;
  }
  return std::nullopt;
}

std::vector<std::size_t> Joints::bodies(std::size_t stage) const {
  std::vector<std::size_t> result(limbs.size(), 0);
  for (std::size_t i = 1; i < limbs.size(); ++i) result[i] = limbs[i].stage == stage ? i : result[*limbs[i].before];
  return result;
}

std::optional<std::size_t> Joints::rigid_body(std::span<const std::size_t> bodies, std::size_t vertex,
                                              double weight) const {
  for (std::size_t i = begin[vertex]; i < begin[vertex + 1]; ++i) {
    double sum = 0;
    for (std::size_t k = begin[vertex]; k < begin[vertex + 1]; ++k) {
      if (bodies[weights[k].bone] == bodies[weights[i].bone]) sum += weights[k].weight;
    }
    if (sum > weight) return bodies[weights[i].bone];
  }
  return std::nullopt;
}

std::vector<std::int32_t> parents_of(const Skin& skin, std::size_t vertices) {
  if (!skin.parents.empty()) return skin.parents;
  // Builds the tree with the most shared weight (Prim).
  const std::size_t bones = skin.rest.size();
  std::vector<std::map<std::size_t, double>> shared(bones);
  for (std::size_t v = 0; v < vertices; ++v) {
    for (std::size_t i = skin.begin[v]; i < skin.begin[v + 1]; ++i) {
      for (std::size_t k = skin.begin[v]; k < skin.begin[v + 1]; ++k) {
        const BoneWeight& a = skin.weights[i];
        const BoneWeight& b = skin.weights[k];
        if (a.bone != b.bone && a.weight > 0 && b.weight > 0) shared[a.bone][b.bone] += a.weight * b.weight;
      }
    }
  }
  std::vector<std::int32_t> parents(bones, -1);
  std::vector<bool> reached(bones, false);
  for (std::size_t count = 0; count < bones; ++count) {
    std::size_t next = bones;
    double most = -1;
    std::int32_t parent = -1;
    for (std::size_t a = 0; a < bones; ++a) {
      if (!reached[a]) continue;
      for (const auto& [b, weight] : shared[a]) {
        if (reached[b] || weight <= most) continue;
        next = b;
        most = weight;
        parent = static_cast<std::int32_t>(a);
      }
    }
    if (next == bones)
      next = static_cast<std::size_t>(std::find(reached.begin(), reached.end(), false) - reached.begin());
    reached[next] = true;
    parents[next] = parent;
  }
  return parents;
}

}  // namespace knead::detail
