// Characters: a shape that hangs on a skeleton, posed by a flow. Bones move rigidly, the flesh between them follows,
// the volume stays, and what a pose brings together flattens and does not enter (docs/characters.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/stroke.h"
#include "knead/vec.h"

namespace knead {

// Where a bone is: its own coordinates x become linear x + offset. Finite, and with an inverse.
struct BoneTransform {
  Mat3d linear;
  Vec3d offset;

  friend bool operator==(const BoneTransform&, const BoneTransform&) = default;
};

// How much of a vertex's motion is that of a bone.
struct BoneWeight {
  std::uint32_t bone = 0;
  double weight = 0;  // 0 or more
};

// A skeleton and how a mesh hangs on it.
struct Skin {
  std::vector<BoneTransform> rest;    // of each bone, in the shape's coordinates
  std::vector<std::int32_t> parents;  // as many: the number of each bone's parent, or -1; empty: found by the weights
  std::vector<std::size_t> begin;     // the weights of vertex v are begin[v] to begin[v + 1]; one more than vertices
  std::vector<BoneWeight> weights;    // those of a vertex need not sum to 1: they are divided by their sum
  std::vector<std::string> names{};   // of the bones, for messages; or empty
};

// A pose: where each bone of a skin is.
using SkinPose = std::vector<BoneTransform>;

// Throws InvalidInput with the number of the bone or vertex: lists of different lengths, parents in a circle, bones
// that do not exist, weights below 0 or not finite, transforms that are not finite or have no inverse.
void validate(const Skin& skin, std::size_t vertices);
void validate(const Skin& skin, const SkinPose& pose);

// Returns the positions by linear blend skinning: each vertex by the weighted mean of its bones' matrices. Vertices
// without weights stay.
std::vector<Vec3d> linear_blend(std::span<const Vec3d> positions, const Skin& skin, const SkinPose& pose);

// Returns the positions by dual quaternions (Kavan, Collins, Zara, O'Sullivan, "Skinning with Dual Quaternions", 2007).
// Of bones that scale or shear only the nearest rotation counts.
std::vector<Vec3d> dual_quaternion_blend(std::span<const Vec3d> positions, const Skin& skin, const SkinPose& pose);

// How a pose is solved for.
struct SkinOptions {
  double rigid_weight = 0.9;  // vertices whose weight of a bone is above this move with it; in [0.5, 1)
  double detail = 0;  // of the grids: their spacing as a fraction of the limb's radius at a joint, from 0.5 to 4;
                      // 0: 2, and 1.5 for fingers
  int threads = 0;    // 0: all; does not change a bit of the result
  Progress* progress = nullptr;  // counts up to its total, anew for each pose, and cancels
};

// What one way of posing does to a shape.
struct SkinMeasures {
  std::optional<double> volume_error;  // relative to rest; nothing unless closed and oriented
  std::size_t crossings = 0;           // pairs of triangles
  std::size_t crossings_new = 0;       // pairs that did not cross at rest
  double least_stretch = 1;            // of the triangles' singular values
  double greatest_stretch = 1;
  double rms_log_stretch = 0;
};

// What a pose did. Distances are fractions of the shape's diagonal at rest.
struct SkinReport {
  SkinMeasures linear;     // of linear_blend
  SkinMeasures dual;       // of dual_quaternion_blend
  SkinMeasures flow;       // of the result
  std::size_t bones = 0;   // bones that moved against each other
  std::size_t stages = 0;  // joints of about one size move at once, the smallest first
  std::size_t segments = 0;
  std::size_t unknowns = 0;        // of a grid, the most
  double part_distance = 0;        // the greatest of a rigid vertex from its bone's place
  double part_distance_95 = 0;     // 95% of them are at most so far
  double seconds = 0;              // of the flow, without the measures
  std::vector<std::string> notes;  // what was odd, in sentences
};

// Returns one JSON object, indented, with a line end.
std::string to_json(const SkinReport& report);

// A pose that stretches or presses a triangle by more is spoiled.
inline constexpr double kMaxPosedStretch = 5;

// Returns the sentence that says why the result of a flow is spoiled and what to do; empty if it is sound: nothing
// crosses that did not at rest, and no triangle is stretched or pressed by more than kMaxPosedStretch.
std::string complaint_about(const SkinMeasures& flow);

// A posed shape.
struct SkinResult {
  std::vector<Stroke> strokes;   // take the shape at rest to the pose
  std::vector<Vec3d> positions;  // of its vertices after them
  SkinReport report;
};

// Poses a mesh by its skeleton. Bones are rigid parts, all joints of about one size turn at once, each about its own
// axis; the flesh between them is strained least. The result is strokes of the tool `grid`, and, where the skeleton
// moves as a whole, one that turns and one that moves everything: they can be replayed, resolved and inverted. A closed
// surface loses volume where flat triangles bend, although the flow keeps it; the last grid of a stage, with `growth`,
// gives this back.
// `measured`: whether the report compares with linear blend and dual quaternions. Time: about 1 s for a body of 14,000
// vertices on two cores, besides the measures. Throws InvalidInput for an invalid mesh, skin, pose or option, and where
// the equations cannot be solved; and Cancelled.
SkinResult pose_skin(const Mesh& mesh, const Skin& skin, const SkinPose& pose, const SkinOptions& options = {},
                     bool measured = true);

// Returns the positions at rest that linear_blend() takes to `posed`: each vertex by the inverse of its blended matrix.
// The difference from the rest positions is a corrective shape (a morph target). Where a matrix has hardly an inverse
// (below 0.05 of the rigid volume) the vertex stays at rest. Throws InvalidInput as validate().
std::vector<Vec3d> corrective_shape(std::span<const Vec3d> positions, std::span<const Vec3d> posed, const Skin& skin,
                                    const SkinPose& pose);

// A turn of a bone about its origin at rest, against its parent.
struct BoneTurn {
  std::uint32_t bone = 0;
  Vec3d axis;  // in the shape's coordinates at rest; not 0
  double angle_deg = 0;
};

// Returns the pose in which these bones turn, with all that hangs on them. Throws InvalidInput for a bone that the skin
// does not have.
SkinPose turned_pose(const Skin& skin, std::span<const BoneTurn> turns);

// Returns the pose in which each joint is as in that of the poses where it turns most. There is at least one pose.
SkinPose widest_pose(const Skin& skin, std::span<const SkinPose> poses);

// A corrective shape and the joints that drive it.
struct Corrective {
  std::vector<std::uint32_t> bones;  // the bone behind the joint; two: a combination of neighbours
  std::vector<Vec3d> axes;           // as many unit vectors, in the shape's coordinates at rest: what each turns about
  std::vector<double> angles_deg;    // as many: how far each turns at weight 1, against its parent; above 0
  std::vector<Vec3d> offsets;        // what is added to each vertex at rest
  SkinMeasures flow{};               // of the pose from which it was made
};

// Returns how strong each corrective is in a pose: for one joint the square of the part of its angle that it turns
// about its axis, from 0 to 1, since what linear blend loses grows with the square of the angle; for a combination the
// product. Throws InvalidInput as validate().
std::vector<double> corrective_weights(std::span<const Corrective> correctives, const Skin& skin, const SkinPose& pose);

// Returns correctives for a pose: one for each joint that turns by 5 degrees or more, made with all others at rest; and
// one for each such joint and the nearest turning joint before it: what is missing where both turn. Time: that of
// pose_skin for each. Throws as pose_skin.
std::vector<Corrective> make_correctives(const Mesh& mesh, const Skin& skin, const SkinPose& pose,
                                         const SkinOptions& options = {});

// Returns the positions by linear blend of the shape at rest with these correctives.
std::vector<Vec3d> corrected_blend(std::span<const Vec3d> positions, std::span<const Corrective> correctives,
                                   const Skin& skin, const SkinPose& pose);

// A skeleton of a file, and its animation.
struct SkinFile {
  Skin skin;
  SkinPose pose;                               // as the nodes of the file stand
  double duration = 0;                         // of the animation, seconds; 0: there is none
  std::vector<std::string> animations;         // names; the first one is used unless another is asked for
  std::function<SkinPose(double seconds)> at;  // the pose at a time
  std::vector<std::string> notes{};            // what was odd, in sentences
};

// Returns the skeleton of a glTF file (JOINTS_0, WEIGHTS_0, further sets, inverse bind matrices) for all vertices of
// the shape; those of meshes without a skin have no weights. `animation`: its number. Throws InvalidInput for a file
// without a skin, several skins that disagree, joints without weights, weights that are no numbers, and what is
// damaged.
SkinFile read_skin(const ShapeFile& shape, std::size_t animation = 0);

}  // namespace knead
