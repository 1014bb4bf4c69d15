// Fits one shape to another, and poses characters by their skeleton, by flows that strain the body least.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/stroke.h"
#include "knead/vec.h"

namespace knead {

struct ShapeFile;  // io.h

// Fits (docs/decisions/0033-near-rigid-fits.md).

// A point of the source and its position on the target. Coordinates are finite.
struct FitPair {
  Vec3d source;
  Vec3d target;
  double tolerance = 0;  // a length, 0 or more: the allowed distance of the moved point from the target
};

// Whether the source is moved as a whole before it is fitted.
enum class FitAlign {
  automatic,  // if that brings it much nearer to the target
  always,
  never,
};

// What becomes of the volume.
enum class FitVolume {
  keep,   // it stays that of the source
  total,  // the source is scaled to the target's volume first
  free,   // it follows the target, and changes smoothly over the body
};

// How one shape is fitted to another.
struct BodyFitOptions {
  std::vector<FitPair> landmarks{};  // at most 2000
  // Approximate pairs, of any number: the start for matching the surfaces. Empty: if both shapes have the same faces,
  // vertices of the same number are pairs, unless these contradict the landmarks, max_stretch or a volume that is kept.
  std::vector<FitPair> map{};
  bool surface = true;  // matches the whole surface; false: landmarks and map alone
  // Matches only the parts that both surfaces have; parts opposite a hole or a cut of the other surface are not
  // matched.
  bool partial = false;
  FitAlign align = FitAlign::automatic;
  FitVolume volume = FitVolume::keep;
  double max_stretch = 5;        // above 1: a triangle with a greater stretch makes the fit unsound (is_sound)
  int threads = 0;               // 0: all; does not change a bit of the result
  Progress* progress = nullptr;  // counts up to its total, and cancels within 0.5 s
};

// Distances between two surfaces, as fractions of the source's diagonal. They are those of the vertices of each surface
// from the other one, taken together.
struct FitDistance {
  double mean = 0;
  double percentile_95 = 0;  // 95% are at most this
  double max = 0;
  Vec3d farthest{};  // the vertex of either surface with this distance
};

// What a fit did. Lengths are fractions of the source's diagonal, after scaling.
struct BodyFitReport {
  std::size_t landmarks = 0;
  std::size_t map_pairs = 0;
  std::size_t tips = 0;  // ends of limbs that were used as landmarks because none were given
  std::size_t strokes = 0;
  std::size_t unknowns = 0;      // of the largest grid
  double scale = 1;              // of the source, about the middle of its box, before all strokes
  bool is_aligned = false;       // the first strokes move the source as a whole
  double landmark_distance = 0;  // the greatest distance of a landmark from its target
  double landmark_rms = 0;       // root mean square of these distances
  double landmark_excess = 0;    // the greatest part of such a distance beyond its tolerance
  double reached = 1;            // the fraction of their paths that landmarks and map moved while the shape was sound
  std::string obstacle;          // why they stopped there; empty if they reached their targets
  double map_distance = 0;       // the median distance of the map's pairs after the fit
  FitDistance before;            // of the source from the target before the fit
  FitDistance after;
  // For an open target: the mean distance of its vertices from the fitted source. With `partial`: this, or the mean
  // distance of the fitted source's vertices from the target if that is smaller.
  std::optional<double> after_covered;
  std::optional<double> matched;  // with `partial`: the fraction of the source's surface that was matched last
  double after_landmarks = 0;     // the mean distance before the surfaces were matched
  // The relative change of the source's volume; nothing unless closed and oriented. An error, except with
  // FitVolume::free.
  std::optional<double> volume_error;
  // With FitVolume::free: the least and greatest det J of the whole flow at evenly spread vertices. Above 0.
  std::optional<double> det_least;
  std::optional<double> det_greatest;
  std::optional<double> volume_difference;  // target / source - 1, before the fit; nothing unless both are closed
  std::size_t crossings_before = 0;         // pairs of triangles of the source
  std::size_t crossings_after = 0;
  std::size_t crossings_new = 0;   // pairs that did not cross before
  double greatest_stretch = 1;     // of a triangle, its greatest singular value or the inverse of its least
  double stretch_99 = 1;           // 99% of the triangles are stretched by at most this
  double rms_log_stretch = 0;      // root mean square of the logarithms of their singular values
  std::string stage;               // the stage that gave the result: "landmarks" or "surface"
  std::vector<std::string> notes;  // about the input, in sentences
  bool is_sound = true;            // no new crossing, stretch and landmarks within their bounds
};

// A fit: strokes, and their result.
struct BodyFit {
  std::vector<Stroke> strokes;   // for the source, scaled by BodyFitReport::scale if that is not 1
  std::vector<Vec3d> positions;  // of the source's vertices after them, as replaying the strokes gives them
  BodyFitReport report;
};

// Landmarks within this fraction of the diagonal count as met.
inline constexpr double kFitExact = 2e-5;

// Returns the strokes that move the source to the target:
// 1. strokes that align it as a whole;
// 2. `grid` strokes that move the landmarks (and the map) to their targets, on paths on which limbs turn about joints;
// 3. `grid` strokes that bring the surfaces together, from coarse to fine. They are kept only if they improve the fit.
// The volume stays, except with FitVolume::free, and nothing crosses along exact path lines; the report says what the
// flat triangles do. Time: about 5 to 15 s of processor time for 5,000 vertices. Memory: about 100 MB, and 200 bytes a
// vertex. Throws InvalidInput for invalid meshes, coordinates or tolerances; for a surface without triangles that must
// be matched; for FitVolume::total if a shape has no volume; for landmarks that are the target's mirror image; and if
// the equations cannot be solved. Throws Cancelled.
BodyFit fit_body(const Mesh& source, const Mesh& target, const BodyFitOptions& options);

// Returns the first value of progress->total, approximately. The total grows when a stage is repeated.
std::uint64_t fit_work(const Mesh& source, const BodyFitOptions& options);

// Returns the sentence that says which bound a fit misses and what to do; empty if it is sound.
std::string complaint_about(const BodyFitReport& report, const BodyFitOptions& options);

// Characters (docs/characters.md). Bones move rigidly, and the flesh between them follows. The volume stays, and parts
// that a pose presses together flatten without crossing.

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
