// Validates skins, and poses them by linear blend and dual quaternions.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/error.h"
#include "knead/fit.h"
#include "skin/rigid.h"

namespace knead {

using namespace detail;

namespace {

void require_skin(bool holds, const std::string& what) {
  if (!holds) throw InvalidInput(what);
}

std::string name_of(const Skin& skin, std::size_t bone) {
  return bone < skin.names.size() && !skin.names[bone].empty() ? fmt::format("bone {} ({})", bone, skin.names[bone])
                                                               : fmt::format("bone {}", bone);
}

bool is_finite(const BoneTransform& t) {
  return knead::is_finite(t.linear.row0) && knead::is_finite(t.linear.row1) && knead::is_finite(t.linear.row2) &&
         knead::is_finite(t.offset);
}

void require_transforms(const Skin& skin, const std::vector<BoneTransform>& transforms, std::string_view what) {
  constexpr double kMinVolume = 1e-12;  // of the columns, relative to their lengths
  for (std::size_t b = 0; b < transforms.size(); ++b) {
    const BoneTransform& t = transforms[b];
    require_skin(is_finite(t), fmt::format("the {} of {} is not finite", what, name_of(skin, b)));
    const double sizes = norm(t.linear.column(0)) * norm(t.linear.column(1)) * norm(t.linear.column(2));
    require_skin(std::abs(determinant(t.linear)) > kMinVolume * sizes,
                 fmt::format("the {} of {} is flat: its matrix has no inverse", what, name_of(skin, b)));
  }
}

void require_forest(const Skin& skin) {
  const auto bones = static_cast<std::int32_t>(skin.rest.size());
  std::vector<char> state(skin.rest.size(), 0);  // 1: on the path up from the current bone, 2: known to reach a root
  for (std::size_t b = 0; b < skin.parents.size(); ++b) {
    require_skin(skin.parents[b] >= -1 && skin.parents[b] < bones,
                 fmt::format("the parent of {} is {}, but there are {} bones; give -1 for none", name_of(skin, b),
                             skin.parents[b], bones));
  }
  for (std::size_t b = 0; b < skin.parents.size(); ++b) {
    std::vector<std::size_t> way;
    for (auto at = static_cast<std::int32_t>(b); at >= 0 && state[static_cast<std::size_t>(at)] != 2;
         at = skin.parents[static_cast<std::size_t>(at)]) {
      const auto bone = static_cast<std::size_t>(at);
      require_skin(state[bone] == 0, fmt::format("the parents of {} go round in a circle", name_of(skin, bone)));
      state[bone] = 1;
      way.push_back(bone);
    }
    for (const std::size_t bone : way) state[bone] = 2;
  }
}

// Returns the sum of a vertex's weights.
double sum_of(const Skin& skin, std::size_t v) {
  double sum = 0;
  for (std::size_t i = skin.begin[v]; i < skin.begin[v + 1]; ++i) sum += skin.weights[i].weight;
  return sum;
}

BoneTransform blended(const Skin& skin, const std::vector<BoneTransform>& motions, std::size_t v) {
  const double sum = sum_of(skin, v);
  if (!(sum > 0)) return {};
  BoneTransform blend{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {0, 0, 0}};
  for (std::size_t i = skin.begin[v]; i < skin.begin[v + 1]; ++i) {
    const BoneTransform& motion = motions[skin.weights[i].bone];
    const double w = skin.weights[i].weight / sum;
    blend.linear = blend.linear + motion.linear * w;
    blend.offset += motion.offset * w;
  }
  return blend;
}

struct DualQuaternion {
  Quaternion real;
  Quaternion dual;
};

DualQuaternion dual_of(const Rigid& motion) {
  const Quaternion half = Quaternion{0, motion.offset * 0.5} * motion.turn;
  return {motion.turn, half};
}

}  // namespace

void validate(const Skin& skin, std::size_t vertices) {
  require_skin(!skin.rest.empty(), "a skin needs at least one bone");
  require_skin(skin.parents.empty() || skin.parents.size() == skin.rest.size(),
               fmt::format("there are {} parents for {} bones; give one for each, or none at all", skin.parents.size(),
                           skin.rest.size()));
  require_skin(skin.begin.size() == vertices + 1,
               fmt::format("the weights are for {} vertices, but the shape has {}",
                           skin.begin.empty() ? 0 : skin.begin.size() - 1, vertices));
  require_skin(skin.begin.front() == 0 && skin.begin.back() == skin.weights.size() &&
                   std::is_sorted(skin.begin.begin(), skin.begin.end()),
               "the rows of the weights are not in order");
  require_transforms(skin, skin.rest, "rest");
  require_forest(skin);
  for (std::size_t v = 0; v < vertices; ++v) {
    for (std::size_t i = skin.begin[v]; i < skin.begin[v + 1]; ++i) {
      const BoneWeight& w = skin.weights[i];
      require_skin(w.bone < skin.rest.size(),
                   fmt::format("vertex {} hangs on bone {}, but there are {}", v, w.bone, skin.rest.size()));
      require_skin(
          w.weight >= 0 && std::isfinite(w.weight),
          fmt::format("vertex {} has the weight {} of {}; weights are 0 or more", v, w.weight, name_of(skin, w.bone)));
    }
  }
}

void validate(const Skin& skin, const SkinPose& pose) {
  require_skin(pose.size() == skin.rest.size(),
               fmt::format("the pose has {} bones, but the skin has {}", pose.size(), skin.rest.size()));
  require_transforms(skin, pose, "pose");
  for (std::size_t b = 0; b < pose.size(); ++b) {
    require_skin(determinant(pose[b].linear) * determinant(skin.rest[b].linear) > 0,
                 fmt::format("the pose mirrors {}; a shape cannot be turned inside out", name_of(skin, b)));
  }
}

std::vector<Vec3d> linear_blend(std::span<const Vec3d> positions, const Skin& skin, const SkinPose& pose) {
  validate(skin, positions.size());
  validate(skin, pose);
  const std::vector<BoneTransform> motions = motions_of(skin, pose);
  std::vector<Vec3d> result;
  result.reserve(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) result.push_back(apply(blended(skin, motions, v), positions[v]));
  return result;
}

std::vector<Vec3d> dual_quaternion_blend(std::span<const Vec3d> positions, const Skin& skin, const SkinPose& pose) {
  validate(skin, positions.size());
  validate(skin, pose);
  const std::vector<BoneTransform> motions = motions_of(skin, pose);
  std::vector<DualQuaternion> duals;
  for (std::size_t b = 0; b < motions.size(); ++b)
    duals.push_back(dual_of(rigid_part(motions[b], skin.rest[b].offset)));
  std::vector<Vec3d> result;
  result.reserve(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    DualQuaternion sum{{0, {0, 0, 0}}, {0, {0, 0, 0}}};
    const BoneWeight* pivot = nullptr;
    for (std::size_t i = skin.begin[v]; i < skin.begin[v + 1]; ++i) {
      if (pivot == nullptr || skin.weights[i].weight > pivot->weight) pivot = &skin.weights[i];
    }
    for (std::size_t i = skin.begin[v]; i < skin.begin[v + 1]; ++i) {
      const DualQuaternion& d = duals[skin.weights[i].bone];
      const DualQuaternion& main = duals[pivot->bone];
      const double side = d.real.w * main.real.w + dot(d.real.v, main.real.v) < 0 ? -1.0 : 1.0;
      const double w = side * skin.weights[i].weight;
      sum.real = {sum.real.w + w * d.real.w, sum.real.v + d.real.v * w};
      sum.dual = {sum.dual.w + w * d.dual.w, sum.dual.v + d.dual.v * w};
    }
    const double size = std::sqrt(sum.real.w * sum.real.w + dot(sum.real.v, sum.real.v));
    if (!(size > 0)) {
      result.push_back(positions[v]);
      continue;
    }
    const Quaternion turn{sum.real.w / size, sum.real.v / size};
    const Quaternion dual{sum.dual.w / size, sum.dual.v / size};
    result.push_back(turn * positions[v] + ((dual * inverse(turn)).v) * 2.0);
  }
  return result;
}

std::vector<Vec3d> corrective_shape(std::span<const Vec3d> positions, std::span<const Vec3d> posed, const Skin& skin,
                                    const SkinPose& pose) {
  constexpr double kMinDeterminant = 0.05;  // relative to that of rigid motions
  validate(skin, positions.size());
  validate(skin, pose);
  require_skin(posed.size() == positions.size(),
               fmt::format("there are {} posed positions for {} vertices", posed.size(), positions.size()));
  const std::vector<BoneTransform> motions = motions_of(skin, pose);
  std::vector<Vec3d> result;
  result.reserve(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const BoneTransform blend = blended(skin, motions, v);
    result.push_back(determinant(blend.linear) > kMinDeterminant ? apply(inverse(blend), posed[v]) : positions[v]);
  }
  return result;
}

}  // namespace knead
