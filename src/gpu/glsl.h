// The source text of the compute shaders, and the layout of their buffers. Internal to gpu.
#pragma once

#include <cstddef>
#include <string>

#include "knead/flow.h"

namespace knead::gpu {

extern const char* const kGlslField;
extern const char* const kGlslPins;
extern const char* const kGlslGrid;
extern const char* const kGlslSphereContact;
extern const char* const kGlslPowers;
extern const char* const kGlslTrees;
extern const char* const kGlslSets;
extern const char* const kGlslVelocity;
extern const char* const kGlslContact;
extern const char* const kGlslClosedForm;
extern const char* const kGlslPath;

// The places of numbers in the buffers, which packed.h fills. The shaders get #defines of the same names.
namespace layout {
// Of a field, in n[].
inline constexpr int kOuter = 3;  // after the offset of its centre from the first field's
inline constexpr int kInner = 4;
inline constexpr int kInverseWidth = 5;
inline constexpr int kMotion = 6;
inline constexpr int kRegion = 18;
inline constexpr int kFalloff = 25;
inline constexpr int kPerBump = 26;       // 1 / bump of the wide falloff
inline constexpr int kFieldNumbers = 28;  // a multiple of four, as the shaders read fours
// Of a field, in table[].
inline constexpr int kFieldBegin = 0;  // its first number in n[]
inline constexpr int kMotionKind = 1;
inline constexpr int kRegionKind = 2;
inline constexpr int kBounds = 3;  // its bounds in e[]
inline constexpr int kFirstSet = 4;
inline constexpr int kFieldEntries = 20;
// Of a set's tree: a node's numbers in n[], which follow one for all nodes, and its entries in table[].
inline constexpr int kNodeNumbers = 5;  // centroid, radius, m(m+1)/2 times the mean squared distance from the centroid
inline constexpr int kNodeEntries = 4;  // the node after its children, where its points begin and end, its right child
// Of a segment, in table[].
inline constexpr int kSegmentEntries = 4;  // how many fields, where their entries begin, flags, where n[] begins
inline constexpr int kCarries = 1;         // flags
inline constexpr int kHasCylinder = 2;
inline constexpr int kClosedForm = 4;  // from here on
// Of a segment, in n[]: displacement, its length, and these.
inline constexpr int kReach = 4;
inline constexpr int kTolerance = 5;
inline constexpr int kMin = 6;
inline constexpr int kStrain = 7;
inline constexpr int kBegin = 16;
inline constexpr int kEnd = 17;
inline constexpr int kSegmentNumbers = 20;
// Of a part of a pinned segment's time, instead of a strain: 1 / radius, the part's middle, 1 / half of its length.
inline constexpr int kPerRadius = 7;
inline constexpr int kMiddle = 8;
inline constexpr int kPerHalf = 9;
// Of a pin, in n[]: its place in radii at t = 0 from the segment's centre, its displacement, and from here on the
// powers of its velocity.
inline constexpr int kPowers = 6;
// Of a pin, in table[], instead of a set: the degree of the powers, the numbers of the part's turns in n[], and the
// number of turns.
inline constexpr int kDegree = 4;
inline constexpr int kFirstTurn = 5;
inline constexpr int kTurns = 6;
// Of a grid, whose nodes have four numbers each in n[], in table[], instead of a set: the numbers of GridView; the
// cells' least and greatest indices; the nodes' numbers at t = 1 in n[]; the bits of the cells in use in table[].
inline constexpr int kRow = 4;
inline constexpr int kPlane = 5;
inline constexpr int kFirstNode = 6;
inline constexpr int kFirstCell = 7;
inline constexpr int kLastCell = 10;
inline constexpr int kEndNumbers = 13;
inline constexpr int kUsed = 14;
// Of a segment, in e[]: centre, displacement; the limit cylinder's point, direction, squared radius; of a grid
// 1 / spacing instead of the limit cylinder.
inline constexpr int kSegmentPlaces = 16;
// Of a field's bounds, in e[]: a point, its path or a normal, the radius, and 1 / |path|^2 or -1 for a normal. Of a
// grid's: the box of the cells in use.
inline constexpr int kFieldBounds = 8;

inline constexpr int kGroup = 64;         // points that share a bound
inline constexpr int kCountStripes = 64;  // of the counters, so that threads seldom collide
inline constexpr int kCounters = 8;  // of a stripe: accepted, rejected, evaluations of two words each, incomplete, cut
}  // namespace layout

enum MotionKind : int { kTranslation, kRotation, kTwist, kStrainMotion };
enum RegionKind : int { kBall, kCapsule, kHalfSpace, kSet };

// The closed forms of a segment's path lines.
enum ClosedForm : int { kNoClosedForm, kTurningBall, kParallelTwist, kTurningSpace, kStretchedCore };

// The kind of a segment: one shader moves all segments of a kind.
struct ShaderKind {
  unsigned motions = 0;  // one bit for each MotionKind
  unsigned regions = 0;
  bool curves = false;
  bool trees = false;
  bool single = false;
  bool blended = false;
  bool pins = false;          // motions and regions are empty
  bool turns = false;         // some of the pins turn
  bool grid = false;          // motions and regions are empty
  bool grid_changes = false;  // in time
  bool limit_cylinder = false;
  bool falloff = false;  // that of some field is not the default
  bool in_double = false;
  Integrator integrator = Integrator::tsitouras;

  friend bool operator==(const ShaderKind&, const ShaderKind&) = default;
};

// Returns the source of a shader that moves points through segments of this kind.
std::string shader_source(const ShaderKind& kind);

// The shaders of surfaces.
inline constexpr std::size_t kSurfaceRanges = 4;             // of points, bound to the places from 0 on
inline constexpr std::size_t kTrianglesPlace = 4;            // the binding of the triangles
inline constexpr std::size_t kResultPlace = 5;               // the binding of the result
inline constexpr std::size_t kTrianglesToAWorkGroup = 1024;  // of 64 threads

// Writes a sum for each work group to the result, from first_group on.
std::string volume_source();

// Writes the sum of `count` numbers at place 0 to the result.
std::string sum_source();

// Finds the triangles that a ray may meet.
std::string candidates_source();

}  // namespace knead::gpu
