// Corrective shapes: the error of linear blend, joint by joint.
#include <algorithm>
#include <numbers>
#include <optional>

#include "knead/error.h"
#include "knead/fit.h"
#include "math/elementary.h"
#include "skin/joints.h"
#include "skin/rigid.h"

namespace knead {

using namespace detail;

namespace {

constexpr double kMinTurn = 5 * std::numbers::pi / 180;

// Returns a bone's motion against its parent, in the shape's coordinates at rest.
BoneTransform joint_motion(const std::vector<std::int32_t>& parents, const std::vector<BoneTransform>& motions,
                           std::size_t bone) {
  const std::int32_t parent = parents[bone];
  return parent < 0 ? motions[bone] : after(inverse(motions[static_cast<std::size_t>(parent)]), motions[bone]);
}

// Returns the pose with these motions of the bones against their parents.
SkinPose pose_by_joints(const Skin& skin, const std::vector<std::int32_t>& parents,
                        const std::vector<BoneTransform>& own) {
  std::vector<std::optional<BoneTransform>> motions(skin.rest.size());
  SkinPose pose;
  for (std::size_t b = 0; b < skin.rest.size(); ++b) {
    std::vector<std::size_t> way;
    for (auto at = static_cast<std::int32_t>(b); at >= 0 && !motions[static_cast<std::size_t>(at)];
         at = parents[static_cast<std::size_t>(at)]) {
      way.push_back(static_cast<std::size_t>(at));
    }
    for (auto it = way.rbegin(); it != way.rend(); ++it) {
      const std::int32_t parent = parents[*it];
      motions[*it] = parent < 0 ? own[*it] : after(*motions[static_cast<std::size_t>(parent)], own[*it]);
    }
    pose.push_back(*motions[b] == BoneTransform{} ? skin.rest[b] : after(*motions[b], skin.rest[b]));
  }
  return pose;
}

struct TurningJoint {
  std::size_t bone = 0;
  BoneTransform motion;  // against its parent
  Vec3d axis;
  double angle = 0;
};

class Maker {
 public:
  Maker(const Mesh& mesh, const Skin& skin, const SkinPose& pose, const SkinOptions& options)
      : mesh_(mesh), skin_(skin), options_(options), parents_(parents_of(skin, mesh.positions.size())) {
    const std::vector<BoneTransform> motions = motions_of(skin, pose);
    std::vector<bool> is_used(pose.size(), false);  // the bone, or one behind it, has vertices
    for (const BoneWeight& w : skin.weights) {
      std::int32_t at = w.weight > 0 ? static_cast<std::int32_t>(w.bone) : -1;
      while (at >= 0 && !is_used[static_cast<std::size_t>(at)]) {
        is_used[static_cast<std::size_t>(at)] = true;
        at = parents_[static_cast<std::size_t>(at)];
      }
    }
    for (std::size_t b = 0; b < pose.size(); ++b) {
      if (parents_[b] < 0 || !is_used[b]) continue;  // a root moves the whole shape
      const BoneTransform motion = joint_motion(parents_, motions, b);
      const Screw screw = screw_of(rigid_part(motion, skin.rest[b].offset), skin.rest[b].offset);
      if (screw.angle >= kMinTurn) joints_.push_back({b, motion, screw.axis, screw.angle});
    }
  }

  std::vector<Corrective> run() {
    std::vector<Corrective> result;
    for (const TurningJoint& joint : joints_) result.push_back(corrective_of({&joint}));
    const std::size_t singles = result.size();
    for (std::size_t i = 0; i < singles; ++i) {
      const std::optional<std::size_t> before = turning_before(joints_[i].bone);
      if (!before) continue;
      Corrective both = corrective_of({&joints_[*before], &joints_[i]});
      for (std::size_t v = 0; v < both.offsets.size(); ++v) {
        both.offsets[v] -= result[*before].offsets[v] + result[i].offsets[v];
      }
      result.push_back(std::move(both));
    }
    return result;
  }

 private:
  // Returns the nearest turning joint before a bone.
  std::optional<std::size_t> turning_before(std::size_t bone) const {
    for (std::int32_t at = parents_[bone]; at >= 0; at = parents_[static_cast<std::size_t>(at)]) {
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        if (joints_[j].bone == static_cast<std::size_t>(at)) return j;
      }
    }
    return std::nullopt;
  }

  // Returns the pose in which only these joints turn, by a part of their motions.
  SkinPose pose_of(const std::vector<const TurningJoint*>& joints, double part = 1) const {
    std::vector<BoneTransform> own(skin_.rest.size());
    for (const TurningJoint* joint : joints) {
      own[joint->bone] = part < 1 ? part_of(*joint, part) : joint->motion;
    }
    return pose_by_joints(skin_, parents_, own);
  }

  BoneTransform part_of(const TurningJoint& joint, double part) const {
    const Vec3d& center = skin_.rest[joint.bone].offset;
    const Rigid motion = screw_of(rigid_part(joint.motion, center), center).at(part);
    const Vec3d x = motion.turn * Vec3d{1, 0, 0};
    const Vec3d y = motion.turn * Vec3d{0, 1, 0};
    const Vec3d z = motion.turn * Vec3d{0, 0, 1};
    return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}, motion.offset};
  }

  Corrective corrective_of(const std::vector<const TurningJoint*>& joints) const {
    const SkinPose pose = pose_of(joints);
    const SkinResult posed = pose_skin(mesh_, skin_, pose, options_, false);
    const double part = posed.report.reached;  // a pose that fell short corrects the blend of where it came to
    const std::vector<Vec3d> shape =
        corrective_shape(mesh_.positions, posed.positions, skin_, part < 1 ? pose_of(joints, part) : pose);
    Corrective result;
    result.flow = posed.report.flow;
    result.problem = complaint_about(posed.report);
    for (std::size_t v = 0; v < shape.size(); ++v) result.offsets.push_back(shape[v] - mesh_.positions[v]);
    for (const TurningJoint* joint : joints) {
      result.bones.push_back(static_cast<std::uint32_t>(joint->bone));
      result.axes.push_back(joint->axis);
      result.angles_deg.push_back(part * joint->angle * 180 / std::numbers::pi);
    }
    return result;
  }

  const Mesh& mesh_;
  const Skin& skin_;
  const SkinOptions& options_;
  std::vector<std::int32_t> parents_;
  std::vector<TurningJoint> joints_;
};

}  // namespace

SkinPose turned_pose(const Skin& skin, std::span<const BoneTurn> turns) {
  std::vector<BoneTransform> own(skin.rest.size());
  for (const BoneTurn& turn : turns) {
    if (turn.bone >= own.size() || !(norm(turn.axis) > 0)) {
      throw InvalidInput("a turn names a bone that the skin does not have, or an axis without length");
    }
    const SinCos<double> half = sincos(turn.angle_deg * std::numbers::pi / 360);
    const Quaternion q{half.cos, normalized(turn.axis) * half.sin};
    const Vec3d x = q * Vec3d{1, 0, 0};
    const Vec3d y = q * Vec3d{0, 1, 0};
    const Vec3d z = q * Vec3d{0, 0, 1};
    const Vec3d& center = skin.rest[turn.bone].offset;
    own[turn.bone] = {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}, center - q * center};
  }
  return pose_by_joints(skin, parents_of(skin, skin.begin.size() - 1), own);
}

SkinPose widest_pose(const Skin& skin, std::span<const SkinPose> poses) {
  const std::vector<std::int32_t> parents = parents_of(skin, skin.begin.size() - 1);
  std::vector<BoneTransform> own(skin.rest.size());
  std::vector<double> widest(skin.rest.size(), -1.0);
  for (const SkinPose& pose : poses) {
    validate(skin, pose);
    const std::vector<BoneTransform> motions = motions_of(skin, pose);
    for (std::size_t b = 0; b < own.size(); ++b) {
      const BoneTransform motion = joint_motion(parents, motions, b);
      const double angle = angle_of(turn_of(motion.linear));
      if (!(angle > widest[b])) continue;
      widest[b] = angle;
      own[b] = motion;
    }
  }
  return pose_by_joints(skin, parents, own);
}

std::vector<double> corrective_weights(std::span<const Corrective> correctives, const Skin& skin,
                                       const SkinPose& pose) {
  if (skin.begin.empty()) throw InvalidInput("the rows of the weights are not in order");
  validate(skin, skin.begin.size() - 1);
  validate(skin, pose);
  const std::vector<std::int32_t> parents = parents_of(skin, skin.begin.size() - 1);
  const std::vector<BoneTransform> motions = motions_of(skin, pose);
  std::vector<double> weights;
  for (const Corrective& corrective : correctives) {
    double weight = 1;
    for (std::size_t j = 0; j < corrective.bones.size(); ++j) {
      const std::size_t bone = corrective.bones[j];
      if (bone >= skin.rest.size()) throw InvalidInput("a corrective names a bone that the skin does not have");
      Quaternion turn = turn_of(joint_motion(parents, motions, bone).linear);
      if (turn.w < 0) turn = {-turn.w, -turn.v};
      const double angle = 2 * elementary::atan2(dot(turn.v, corrective.axes[j]), turn.w) * 180 / std::numbers::pi;
      const double part = std::clamp(angle / corrective.angles_deg[j], 0.0, 1.0);
      weight *= part * part;
    }
    weights.push_back(weight);
  }
  return weights;
}

std::vector<Corrective> make_correctives(const Mesh& mesh, const Skin& skin, const SkinPose& pose,
                                         const SkinOptions& options) {
  knead::validate(mesh);
  validate(skin, mesh.positions.size());
  validate(skin, pose);
  return Maker(mesh, skin, pose, options).run();
}

std::vector<Vec3d> corrected_blend(std::span<const Vec3d> positions, std::span<const Corrective> correctives,
                                   const Skin& skin, const SkinPose& pose) {
  const std::vector<double> weights = corrective_weights(correctives, skin, pose);
  std::vector<Vec3d> corrected(positions.begin(), positions.end());
  for (std::size_t c = 0; c < correctives.size(); ++c) {
    if (correctives[c].offsets.size() != positions.size()) {
      throw InvalidInput("a corrective has not one offset for each vertex");
    }
    for (std::size_t v = 0; v < corrected.size(); ++v) corrected[v] += correctives[c].offsets[v] * weights[c];
  }
  return linear_blend(corrected, skin, pose);
}

}  // namespace knead
