// Characters: shapes posed by their skeleton with a flow. Bones move rigidly, the flesh between them follows, the
// volume stays, and parts that a pose presses together flatten without crossing (docs/characters.md).
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

// The transform of a bone: maps its own coordinates x to linear x + offset. Finite and invertible.
struct BoneTransform {
  Mat3d linear;
  Vec3d offset;

  friend bool operator==(const BoneTransform&, const BoneTransform&) = default;
};

// The weight of a bone at a vertex.
struct BoneWeight {
  std::uint32_t bone = 0;
  double weight = 0;  // 0 or more
};

// A skeleton and the weights of its bones at the vertices of a mesh.
struct Skin {
  std::vector<BoneTransform> rest;    // of each bone, in the shape's coordinates
  std::vector<std::int32_t> parents;  // the number of each bone's parent, or -1; empty: derived from the weights
  std::vector<std::size_t> begin;     // vertex v has the weights [begin[v], begin[v + 1]); one more than vertices
  std::vector<BoneWeight> weights;    // those of a vertex are divided by their sum
  std::vector<std::string> names{};   // of the bones, for messages; or empty
};

// A pose: the transform of each bone of a skin.
using SkinPose = std::vector<BoneTransform>;

// Throws InvalidInput with the number of the bone or vertex: lists of different lengths, parents in a circle, bones
// that do not exist, weights below 0 or not finite, transforms that are not finite or have no inverse.
void validate(const Skin& skin, std::size_t vertices);
void validate(const Skin& skin, const SkinPose& pose);

// Returns the positions by linear blend skinning: the weighted mean of the bones' matrices moves each vertex. Vertices
// without weights stay.
std::vector<Vec3d> linear_blend(std::span<const Vec3d> positions, const Skin& skin, const SkinPose& pose);

// Returns the positions by dual quaternions (Kavan, Collins, Zara, O'Sullivan, "Skinning with Dual Quaternions", 2007).
// Of bones that scale or shear only the nearest rotation counts.
std::vector<Vec3d> dual_quaternion_blend(std::span<const Vec3d> positions, const Skin& skin, const SkinPose& pose);

// How a pose is computed.
struct SkinOptions {
  double rigid_weight = 0.9;  // vertices with a greater weight of a bone move rigidly with it; in [0.5, 1)
  double detail = 0;          // the spacing of the grids as a fraction of the limb's radius at a joint, from 0.5 to 4;
                              // 0: 2, and 1.5 for fingers
  int threads = 0;            // 0: all; does not change a bit of the result
  Progress* progress = nullptr;  // counts up to its total, from 0 for each pose; cancels the work
};

// The effect of one method of posing on a shape.
struct SkinMeasures {
  std::optional<double> volume_error;  // relative to the volume at rest; nothing unless closed and oriented
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
  std::size_t stages = 0;  // groups of joints of similar size that move at once; the smallest first
  std::size_t segments = 0;
  std::size_t unknowns = 0;        // of the largest grid
  double part_distance = 0;        // the greatest distance of a rigid vertex from where its bone takes it
  double part_distance_95 = 0;     // 95% of these distances are at most this
  double seconds = 0;              // to compute the flow, without the measures
  double reached = 1;              // the smallest fraction of its turn that a joint made, from 0 to 1
  std::string shortfall;           // how far the joints turned that fell short, and why; empty if none did
  std::vector<std::string> notes;  // about the input, in sentences
};

// Returns one JSON object, indented, with a line end.
std::string to_json(const SkinReport& report);

// A pose that stretches or compresses a triangle by a greater factor is spoiled.
inline constexpr double kMaxPosedStretch = 5;

// Returns the sentence that says why the result of a flow is spoiled and what to do; empty if it is sound: it has no
// new crossings, and no triangle is stretched or compressed by more than kMaxPosedStretch.
std::string complaint_about(const SkinMeasures& flow);

// Returns the sentence that says where a pose fell short, or why its result is spoiled; empty if all is well.
std::string complaint_about(const SkinReport& report);

// A posed shape.
struct SkinResult {
  std::vector<Stroke> strokes;   // take the shape at rest to the pose
  std::vector<Vec3d> positions;  // of its vertices after them
  SkinReport report;
};

// Poses a mesh by its skeleton. Bones move rigidly; all joints of about one size turn at once, each about its own axis;
// the flow strains the flesh between them least. The result is strokes of the tool `grid`; if the skeleton moves as a
// whole, also one stroke that turns and one that moves everything. They can be replayed, resolved and inverted. A
// closed surface loses volume where flat triangles bend, although the flow keeps it; the last grid of a stage, with
// `growth`, restores this volume.
//
// A step is refused if triangles cross that did not at rest, or if one is stretched by more than kMaxPosedStretch. It
// is then halved, or solved on other grids. If nothing helps, the joints of its stage stop there; see `shortfall`.
//
// `measured`: the report compares with linear blend and dual quaternions. Time: about 1 s for a body of 14,000 vertices
// on two cores, without these measures. Throws InvalidInput for an invalid mesh, skin, pose or option, and if the
// equations cannot be solved. Throws Cancelled.
SkinResult pose_skin(const Mesh& mesh, const Skin& skin, const SkinPose& pose, const SkinOptions& options = {},
                     bool measured = true);

// Returns the positions at rest that linear_blend() maps to `posed`, by the inverse of each vertex's blended matrix.
// The difference from the rest positions is a corrective shape (a morph target). If the determinant of a matrix is
// below 0.05 of the rigid one, the vertex stays at rest. Throws InvalidInput as validate().
std::vector<Vec3d> corrective_shape(std::span<const Vec3d> positions, std::span<const Vec3d> posed, const Skin& skin,
                                    const SkinPose& pose);

// A turn of a bone about its origin at rest, against its parent.
struct BoneTurn {
  std::uint32_t bone = 0;
  Vec3d axis;  // in the shape's coordinates at rest; not 0
  double angle_deg = 0;
};

// Returns the pose in which these bones turn, and their descendants with them. Throws InvalidInput for a bone that the
// skin does not have.
SkinPose turned_pose(const Skin& skin, std::span<const BoneTurn> turns);

// Returns the pose in which each joint has its greatest turn among the poses. There must be at least one pose.
SkinPose widest_pose(const Skin& skin, std::span<const SkinPose> poses);

// A corrective shape and the joints that drive it.
struct Corrective {
  std::vector<std::uint32_t> bones;  // the bone behind the joint; two: a combination of neighbours
  std::vector<Vec3d> axes;           // of each bone: its axis at rest, a unit vector in the shape's coordinates
  std::vector<double> angles_deg;    // of each bone: its turn at weight 1, against its parent; above 0
  std::vector<Vec3d> offsets;        // added to each vertex at rest
  SkinMeasures flow{};               // of the pose from which it was made
  std::string problem{};             // complaint_about() that pose
};

// Returns the weight of each corrective in a pose. For one joint: the square of the fraction of its angle that it turns
// about its axis, from 0 to 1, since the error of linear blend grows with the square of the angle; for a combination:
// the product. Throws InvalidInput as validate().
std::vector<double> corrective_weights(std::span<const Corrective> correctives, const Skin& skin, const SkinPose& pose);

// Returns correctives for a pose: one for each joint that turns by 5 degrees or more, made with all other joints at
// rest; and one for each such joint together with the nearest turning joint before it, for the rest of the error when
// both turn. Time: that of pose_skin() for each. Throws as pose_skin().
std::vector<Corrective> make_correctives(const Mesh& mesh, const Skin& skin, const SkinPose& pose,
                                         const SkinOptions& options = {});

// Returns the positions by linear blend of the shape at rest to which the weighted correctives were added.
std::vector<Vec3d> corrected_blend(std::span<const Vec3d> positions, std::span<const Corrective> correctives,
                                   const Skin& skin, const SkinPose& pose);

// A skeleton of a file, and its animation.
struct SkinFile {
  Skin skin;
  SkinPose pose;                               // of the file's nodes without animation
  double duration = 0;                         // of the animation, seconds; 0: there is none
  std::vector<std::string> animations;         // names; the first one is used unless another is asked for
  std::function<SkinPose(double seconds)> at;  // the pose at a time
  std::vector<std::string> notes{};            // about the file, in sentences
};

// Returns the skeleton of a glTF file (JOINTS_0, WEIGHTS_0, further sets, inverse bind matrices) for all vertices of
// the shape; vertices of meshes without a skin have no weights. `animation`: its number. Throws InvalidInput for a file
// without a skin, for several skins that disagree, joints without weights, weights that are no numbers, and damaged
// data.
SkinFile read_skin(const ShapeFile& shape, std::size_t animation = 0);

}  // namespace knead
