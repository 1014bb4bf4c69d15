// Strokes: one plain struct for each tool, and the flow that a stroke becomes (method, section 4). `tool` is the
// library's own description of the tool (others: knead/editor/tools.h).
//
// A stroke holds exactly the numbers of its line in a session file: lengths in the mesh's own units, angles in degrees,
// axes and normals as given (any length but zero). It contains no mesh. `falloff` is the shape of the blend
// (knead/field.h), a whole number from 3 to 7, or kWideFalloff for strokes with a `bump`. Then `bump` is the radius of
// the part that moves along, `outer` the radius of the part that flows back (0: 4 times the bump), and `inner` has no
// meaning.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "knead/field.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead {

namespace detail {
template <class S>
struct ToolRow;
}

// The region of the implicit tool.
enum class ImplicitRegion { ball, capsule };

// The implicit tool (paper, section 4.1): moves a ball or capsule along a path, one segment for each piece. Pieces of
// length zero are skipped. inner > 0. With a taper the tool's radii fall evenly along the path, to 1 - taper times
// their value, and at least to a twentieth. Pieces are cut so that the radii change by about a tenth from one to the
// next.
struct ImplicitStroke {
  std::vector<Vec3d> path;  // 2 or more points
  double inner = 0;
  double outer = 0;
  ImplicitRegion region = ImplicitRegion::ball;
  Vec3d half_axis{0, 0, 0};  // capsule only: the segment is [c - half_axis, c + half_axis]
  double gauge = 0;          // capsule only
  TimeLaw time = TimeLaw::swept;
  int falloff = kDefaultFalloff;  // wide: ball only
  double bump = 0;
  std::optional<double> core = std::nullopt;  // of the wide ball: the fraction of the bump that moves rigidly; 0 to 0.8
  double taper = 0;                           // 0 to 1

  static const detail::ToolRow<ImplicitStroke> tool;
  friend bool operator==(const ImplicitStroke&, const ImplicitStroke&) = default;
};

// A place on the surface and its normal.
struct PaintSample {
  Vec3d point;
  Vec3d normal;

  friend bool operator==(const PaintSample&, const PaintSample&) = default;
};

// Painting (paper, section 4.2): moves the surface at each sample by depth against the normal; a negative depth pulls
// it out. Has either samples or a path of 1 or more points, which reads the surface (knead/editor/tools.h).
//
// `pinch`, from -5 to 5, needs the wide falloff. Each dab then is a strain: it stretches along the normal by the factor
// exp(pinch), and shrinks across it. A positive pinch draws the surface together: into a crease if the depth is
// positive, into a ridge if it is negative. A negative pinch flattens the surface towards the plane through the sample
// across the normal; along a path, towards mean planes.
struct PaintStroke {
  double outer = 0;
  double depth = 0;
  std::vector<PaintSample> samples;
  std::vector<Vec3d> path{};
  int falloff = kDefaultFalloff;
  double bump = 0;
  double pinch = 0;

  static const detail::ToolRow<PaintStroke> tool;
  friend bool operator==(const PaintStroke&, const PaintStroke&) = default;
};

// The centre of a moving point set. parts: each connected part has its own; barycentre: one for all, as in the paper.
enum class PointsCenter { parts, barycentre };

// A moving point set (paper, section 4.3): one segment per displacement; the points and polylines move along.
struct PointsStroke {
  std::vector<Vec3d> points;
  std::vector<std::vector<Vec3d>> curves;  // polylines of 2 or more points
  double outer = 0;
  std::vector<Vec3d> displacements;
  int exponent = 8;
  double inner = 0;
  PointsCenter center = PointsCenter::parts;
  int falloff = kDefaultFalloff;

  static const detail::ToolRow<PointsStroke> tool;
  friend bool operator==(const PointsStroke&, const PointsStroke&) = default;
};

// A translation of the moving set.
struct HandlesTranslation {
  Vec3d by;

  friend bool operator==(const HandlesTranslation&, const HandlesTranslation&) = default;
};
// A rotation of the moving set about the axis through the centre.
struct HandlesRotation {
  Vec3d axis;
  Vec3d center;
  double angle_deg = 0;

  friend bool operator==(const HandlesRotation&, const HandlesRotation&) = default;
};

using HandlesMotion = std::variant<HandlesTranslation, HandlesRotation>;  // of the moving set

// Handles (the paper's future work): the moving set `full` follows the motion exactly, the fixed set `zero` stays. Each
// set is given either as points or as vertices of the shape, which are looked up when the stroke begins.
struct HandlesStroke {
  std::vector<Vec3d> full;
  std::vector<Vec3d> zero;
  std::vector<std::uint32_t> full_vertices;
  std::vector<std::uint32_t> zero_vertices;
  HandlesMotion motion;
  int exponent = 8;
  int falloff = kDefaultFalloff;

  static const detail::ToolRow<HandlesStroke> tool;
  friend bool operator==(const HandlesStroke&, const HandlesStroke&) = default;
};

// How the surface moves where a stamp touches it. stick: with the tool. slip: only as far as the tool pushes it out, so
// that the tool slides along it and its print keeps its walls. automatic: stick if `outer`, `exponent` or `falloff` is
// given, as in older sessions; otherwise slip.
enum class StampContact { automatic, stick, slip };

// Stamping (paper, section 4.4): moves a closed tool mesh along the path; at every step its contacts with the surface
// become moving point sets, or pins (strokes/stamp.h).
struct StampStroke {
  std::string mesh;                             // the tool's file, relative to the session file
  std::vector<Vec3d> path;                      // 2 or more positions of the tool's origin
  Mat3d pose{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // rotation and scale, applied to the tool before it is moved
  // Let h be half the tool's largest extent across the motion. Default for an automatic contact: 3 times the width of
  // the tool's narrowest strokes, but 0.9 h to 1.5 h; for others: 1.5 h.
  std::optional<double> outer = std::nullopt;
  // Longest motion between two collision tests. Default: outer / 25, or outer / 50 if `outer` has the default for an
  // automatic contact.
  std::optional<double> step = std::nullopt;
  StampContact contact = StampContact::automatic;
  int exponent = 16;              // of stick
  int falloff = kDefaultFalloff;  // of stick

  static const detail::ToolRow<StampStroke> tool;
  friend bool operator==(const StampStroke&, const StampStroke&) = default;
};

// Returns stick or slip: what `automatic` stands for in this stroke.
StampContact contact_of(const StampStroke& stroke);

// Turns the inner region of a ball about its centre by the angle.
struct RotateStroke {
  Vec3d center;
  Vec3d axis;
  double angle_deg = 0;
  double inner = 0;
  double outer = 0;
  double gauge = 0;
  int falloff = kDefaultFalloff;

  static const detail::ToolRow<RotateStroke> tool;
  friend bool operator==(const RotateStroke&, const RotateStroke&) = default;
};

// Stretches the inner region of a ball along the axis by the factor and thins it across the axis by 1 / sqrt(factor).
struct StretchStroke {
  Vec3d center;
  Vec3d axis;
  double factor = 1;
  double inner = 0;
  double outer = 0;
  int falloff = kDefaultFalloff;

  static const detail::ToolRow<StretchStroke> tool;
  friend bool operator==(const StretchStroke&, const StretchStroke&) = default;
};

// Twist (paper, section 4.5): with r = normal.(x - center), material of the inner region at height h turns about the
// axis by rate_deg h.
struct TwistStroke {
  Vec3d center;
  Vec3d axis;
  double rate_deg = 0;  // degrees per length
  double inner = 0;
  double outer = 0;
  std::optional<Vec3d> normal = std::nullopt;  // by default the axis
  double gauge = 0;
  // Of the limit cylinder about {center + s normal} that moves; without it everything below outer moves.
  std::optional<double> radius = std::nullopt;
  bool radius_auto = false;  // use the radius that propose_limit_cylinder finds on the shape (knead/editor/tools.h)
  int falloff = kDefaultFalloff;
  std::optional<double> angle_deg = std::nullopt;  // from outer to inner, in the place of the rate

  static const detail::ToolRow<TwistStroke> tool;
  friend bool operator==(const TwistStroke&, const TwistStroke&) = default;
};

// The fraction of the width at which the weight of the default falloff is one half.
inline constexpr double kCenterFraction = falloff_facts(kDefaultFalloff).half;

// Thresholds inner = -center_fraction width, outer = (1 - center_fraction) width. By default center_fraction is where
// the weight is one half, which makes a bend symmetric about its centre.
struct BendWidth {
  double width = 0;
  std::optional<double> center_fraction = std::nullopt;

  friend bool operator==(const BendWidth&, const BendWidth&) = default;
};

// The same as lengths along the normal, from the centre: everything below inner moves with the tool, everything above
// outer rests. Valid: inner < outer.
struct BendThresholds {
  double inner = 0;
  double outer = 1;

  friend bool operator==(const BendThresholds&, const BendThresholds&) = default;
};

// Bend (paper, section 4.5): r = normal.(x - center), the normal turning by half the angle; the inner region, on the
// side that the normal points away from, turns about the axis by the angle.
struct BendStroke {
  Vec3d center;
  Vec3d axis;
  Vec3d normal;
  double angle_deg = 0;
  std::variant<BendWidth, BendThresholds> extent;
  double gauge = 1;
  // Of the limit cylinder about {center + s normal} that moves; without it everything below outer moves.
  std::optional<double> radius = std::nullopt;
  bool radius_auto = false;  // use the radius that propose_limit_cylinder finds on the shape (knead/editor/tools.h)
  int falloff = kDefaultFalloff;

  static const detail::ToolRow<BendStroke> tool;
  friend bool operator==(const BendStroke&, const BendStroke&) = default;
};

// The length of a shape along a curve. keep: the shape keeps its length; it lies on a part of the curve, or continues
// straight beyond its ends. fit: the shape is stretched to the ends of the curve, and its thickness changes by the
// inverse square root of the stretch.
enum class CurveLength { keep, fit };

// The place of a curve that does not move, or that moves to the same place of the other curve.
enum class CurveFixed { middle, start, end };

// The measure of a curve's surroundings that does not change. volume: that of every piece, exactly; the outer side of a
// bend grows thinner. thickness: distances from the curve across it, so that walls and reliefs keep their height; the
// volume changes: det J = 1 - (curvature vector) . (place across the curve). length: lengths along the curve, while the
// thickness changes, and the volume with it.
enum class CurveKeeps { volume, thickness, length };

// Curve: a line through the shape becomes another curve, and the shape follows; the volume is kept exactly
// (docs/mathematics.md, "Curves"), or the thickness. The line is straight or smooth through its points, and straight
// beyond its ends. It becomes the curve through the points of `to`; or an arc: bent by an angle about an axis, or
// around a cylinder; and it is twisted. Or the shape gets thicker or thinner across the line.
struct CurveStroke {
  std::vector<Vec3d> from;                         // 2 or more points; empty: the longest axis of the shape's box
  std::vector<Vec3d> to;                           // 2 or more points; or empty
  std::optional<double> angle_deg = std::nullopt;  // of the arc, counterclockwise seen from the tip of the axis
  std::optional<double> around = std::nullopt;     // the arc's radius; below 0: clockwise
  std::optional<Vec3d> axis = std::nullopt;        // of both: any length but 0; across the line. Of a thickness: the
                                                   // only direction in which it changes
  double twist_deg = 0;                            // turn of the end relative to the start, counterclockwise seen from
                                                   // the end
  double longer_by = 0;                            // the line keeps its direction and grows by this length
  double thicker_by = 0;                           // the shape grows across the line by this length; or
  std::optional<double> thickness = std::nullopt;  // becomes so thick there
  std::optional<double> thickness_before = std::nullopt;  // what it was; left out: measured on the shape
  bool taper = false;  // the thickness changes from the line's start to its end, and all beyond keeps the new one;
                       // else the shape gets thicker between the ends
  CurveLength length = CurveLength::keep;  // of `to`
  CurveFixed fixed = CurveFixed::middle;
  CurveKeeps keep = CurveKeeps::volume;
  std::optional<double> radius = std::nullopt;  // only points nearer to the line move; else everything
  bool radius_auto = false;  // use the radius that propose_limit_cylinder finds on the shape (knead/editor/tools.h)

  static const detail::ToolRow<CurveStroke> tool;
  friend bool operator==(const CurveStroke&, const CurveStroke&) = default;
};

// How a lattice moves what is in its box. volume: by a divergence-free flow, the nearest to its displacements. rigid:
// the same, but the body strains as little as possible. spline: by the displacements themselves (LatticeMotion), which
// must not fold the box.
enum class LatticeMode { volume, rigid, spline };

// Lattice: a box of control points whose displacements move what is in the box (docs/mathematics.md, "Lattices"). All
// numbers come from a file, or from the stroke.
struct LatticeStroke {
  std::string file{};                // relative to the session file: PyGeM's parameters (.prm)
  Vec3d origin{0, 0, 0};             // the corner with control point (0, 0, 0)
  Mat3d axes{};                      // rows: directions of the edges, of any length but 0, at right angles
  Vec3d lengths{0, 0, 0};            // of the edges, above 0
  std::array<int, 3> counts{};       // of control points along the edges, 2 to 64
  std::vector<Vec3d> displacements;  // of control point (i, j, k): number k + counts[2] (j + counts[1] i)
  LatticeMode mode = LatticeMode::volume;
  int degree = 0;  // of the splines, at most; 0: Bernstein's polynomials, for counts up to 16

  static const detail::ToolRow<LatticeStroke> tool;
  friend bool operator==(const LatticeStroke&, const LatticeStroke&) = default;
};

// A rotation about an axis through a pin; with the angle 0 the pin holds the shape's orientation.
struct PinRotation {
  Vec3d axis;  // of any length but 0
  double angle_deg = 0;

  friend bool operator==(const PinRotation&, const PinRotation&) = default;
};

// Pins (method, section 9): every point moves exactly to its place, in a straight line, or is held if both are equal.
// Everything within the radius of a pin follows. No two pins meet while they move. 1 to 2000 pins.
struct PinsStroke {
  std::vector<Vec3d> points;
  std::vector<Vec3d> to;                        // a place for each point
  std::optional<double> radius = std::nullopt;  // > 0
  // Use twice the median distance of a pin from its third nearest pin (the farthest if there are fewer), or twice the
  // greatest displacement of a pin if that is more.
  bool radius_auto = false;
  // Empty, or for each pin the rotation of the shape about it, as a rigid body there; std::nullopt: as the flow turns
  // it.
  std::vector<std::optional<PinRotation>> turn{};

  static const detail::ToolRow<PinsStroke> tool;
  friend bool operator==(const PinsStroke&, const PinsStroke&) = default;
};

// The vertices from first to last, both included.
struct VertexRange {
  std::uint32_t first = 0;
  std::uint32_t last = 0;

  friend bool operator==(const VertexRange&, const VertexRange&) = default;
};

// A part of a shape that holds, or moves rigidly: by the rotation and the translation at the same time, as a screw. It
// is given by vertices or by points.
struct PosePart {
  std::vector<VertexRange> vertices{};  // of the shape when the stroke begins
  std::vector<Vec3d> points{};
  bool hold = false;  // false: `rotation` or `translation` is set, or both
  std::optional<HandlesRotation> rotation{};
  std::optional<Vec3d> translation{};

  friend bool operator==(const PosePart&, const PosePart&) = default;
};

// A point of a shape that holds, or follows a path. The surface near it moves as a rigid patch. It is given by a vertex
// or by a point.
struct PosePin {
  std::optional<std::uint32_t> vertex{};  // of the shape when the stroke begins
  std::optional<Vec3d> point{};
  bool hold = false;                      // false: it follows `path`
  std::vector<Vec3d> path{};              // the places that it moves to, in straight lines
  double size = 0.025;                    // radius of the patch, as a fraction of the shape's diagonal; above 0
  bool turns_freely = true;               // the patch turns with the body around it; false: by `rotation`
  std::optional<PinRotation> rotation{};  // of the patch while the pin moves; std::nullopt: it keeps its direction

  friend bool operator==(const PosePin&, const PosePin&) = default;
};

// What a pose is made of.
using PoseItem = std::variant<PosePart, PosePin>;

// The stiffness of some vertices, and of the inside of the shape next to them.
struct PoseStiffness {
  std::vector<VertexRange> vertices;
  double value = 1;  // from 0.01 to 100; elsewhere the stiffness is 1

  friend bool operator==(const PoseStiffness&, const PoseStiffness&) = default;
};

// Pose: parts and pins move to their places, others stay, and the body between follows as rigidly as a flow that keeps
// the volume can (docs/mathematics.md). It reads the surface, and becomes grid strokes.
struct PoseStroke {
  // Greatest spacing of the field's grid, as a fraction of the shape's diagonal; from 0.01 to 0.5. It is smaller, down
  // to 0.025, where a part moves close past one that holds. 0: a quarter of the thickness of the thinnest part that
  // moves, from 0.02 to 0.075.
  double detail = 0;
  double tolerance = 0.005;  // greatest distance of parts and pins from their places, as a fraction of the diagonal
  std::vector<PoseItem> parts;
  std::vector<PoseStiffness> stiffness{};
  bool exact = false;  // a last stroke of pins takes parts and pins exactly to their places

  static const detail::ToolRow<PoseStroke> tool;
  friend bool operator==(const PoseStroke&, const PoseStroke&) = default;
};

// The flow of a potential grid over one unit of time: numbers only. A pose becomes such strokes.
struct GridStroke {
  PotentialGrid grid;

  static const detail::ToolRow<GridStroke> tool;
  friend bool operator==(const GridStroke&, const GridStroke&) = default;
};

// Inflate: the shape grows or shrinks, most along the path through the points: by a volume, or as far as the surface
// shall move. Nothing farther from the path than the radius moves. It reads the surface, and becomes grid strokes that
// change volume on purpose.
struct InflateStroke {
  std::vector<Vec3d> points;                   // 1 or more, on the surface or near it
  double radius = 0;                           // > 0
  double volume = 0;                           // added to the shape; below 0: removed
  std::optional<double> depth = std::nullopt;  // in its place: how far the surface moves at most; below 0: inwards

  static const detail::ToolRow<InflateStroke> tool;
  friend bool operator==(const InflateStroke&, const InflateStroke&) = default;
};

// Print: presses text, a grey picture or the face of a mesh into the surface, against its normal, or raises it. The
// pattern consists of pushes with the wide falloff, so its volume goes far around. It reads the surface, and becomes
// grid strokes. Has either a text or a file.
struct PrintStroke {
  std::string text{};  // one line of UTF-8
  std::string font{};  // a font's file, relative to the session file, or its name; empty: a default font
  // Relative to the session file. A picture: white is pressed to the full depth. A mesh: its lowest face is printed as
  // seen from above, with everything that lies less than the depth above it.
  std::string file{};
  // The middle of the pattern, on the surface or near it; by default the middle of the shape's top.
  std::optional<Vec3d> point = std::nullopt;
  std::optional<Vec3d> up = std::nullopt;         // of the pattern; by default z, or y where the surface looks along z
  std::optional<Vec3d> direction = std::nullopt;  // of all pushes; by default against the normal at each letter
  double height = 0;                              // of a capital letter, or of the file's pattern; > 0
  double depth = 0;                               // below 0: raises
  // Radius over which edges are soft: by default half the width of the thinnest strokes, at most height / 12.
  std::optional<double> bump = std::nullopt;
  std::optional<double> outer = std::nullopt;  // radius of the part that flows back; by default 2 heights
  bool flip = false;                           // left and right change places

  static const detail::ToolRow<PrintStroke> tool;
  friend bool operator==(const PrintStroke&, const PrintStroke&) = default;
};

// Relaxing (remesh/relax.h): makes the triangles even and the surface smooth, and keeps its volume. At each point in
// turn a dab moves the vertices within the radius. This is no flow: a session's line is {"relax": {...}}.
struct RelaxStroke {
  std::vector<Vec3d> points;  // 1 or more
  double radius = 0;          // of a dab, > 0
  double amount = 0.5;        // of the distance to the smooth position, for each iteration; in (0, 1]
  double surface = 1;         // of that amount, across the surface; 0: the triangles alone; in [0, 1]
  int iterations = 2;         // of each dab, 1 to 100

  static const detail::ToolRow<RelaxStroke> tool;
  friend bool operator==(const RelaxStroke&, const RelaxStroke&) = default;
};

// The mask of the strokes after it (knead/field.h). It replaces the mask before; without points and vertices it ends
// that. It moves nothing itself. The masked places are given as points, or as vertices of the shape when the mask
// begins.
struct MaskStroke {
  std::vector<Vec3d> points;
  std::vector<VertexRange> vertices;
  std::vector<double> values;                  // for each point or range, from 0 (free) to 1 (fixed); empty: all 1
  std::optional<double> width = std::nullopt;  // of the border between fixed and free places

  static const detail::ToolRow<MaskStroke> tool;
  friend bool operator==(const MaskStroke&, const MaskStroke&) = default;
};

// Returns whether the stroke gives no mask.
inline bool is_empty(const MaskStroke& stroke) { return stroke.points.empty() && stroke.vertices.empty(); }

// Returns the mask of a stroke that reads no surface. Throws InvalidInput as validate(stroke), and as Mask.
Mask mask_of(const MaskStroke& stroke, int threads = 0);

// A stroke of any tool.
using Stroke = std::variant<ImplicitStroke, PaintStroke, PointsStroke, HandlesStroke, StampStroke, RotateStroke,
                            StretchStroke, TwistStroke, BendStroke, CurveStroke, LatticeStroke, PinsStroke, PoseStroke,
                            GridStroke, InflateStroke, PrintStroke, RelaxStroke, MaskStroke>;

// Returns the tool's name in session files: "implicit", "paint", "points", ...
std::string tool_name(const Stroke& stroke);

// Throws InvalidInput for a value that the tool cannot use. The message begins with the key in quotes and says what was
// expected and what was got.
void validate(const Stroke& stroke);

// Returns true if the stroke must be resolved on a surface before it becomes a flow: paint with a path, stamp, handles
// with vertices, an automatic radius. Also true for a relax stroke, which is no flow.
bool reads_surface(const Stroke& stroke);

// Returns false for a relax stroke, which has no flow and can be neither resolved nor inverted.
bool is_flow(const Stroke& stroke);

// Returns the segments, in order, of a stroke that reads no surface; none for a mask. Throws InvalidInput as
// validate(stroke), and for strokes that read the surface. Time: linear; for a point set n log n.
Flow flow_of(const Stroke& stroke);

// A plane in which a stroke is mirrored.
struct MirrorPlane {
  Vec3d normal{1, 0, 0};  // of any length but 0
  Vec3d point{0, 0, 0};

  friend bool operator==(const MirrorPlane&, const MirrorPlane&) = default;
};

// Up to three planes at right angles to each other; empty: no mirror.
using Mirror = std::vector<MirrorPlane>;

// Throws InvalidInput for more than three planes, a number that is not finite, a normal of length 0, and planes that
// are not at right angles.
void validate(const Mirror& mirror);

// Returns the coordinate planes through the origin that the letters name: "x" is the plane x = 0; "xz" names two
// planes, x = 0 and z = 0. Throws InvalidInput for another letter, and for a letter that is there twice.
Mirror coordinate_mirror(std::string_view names);

// Returns the segments of a stroke that reads no surface, with its mirror images. There are as many as for the stroke
// alone; each is the sum of one of the stroke's segments and its images. Images that do the same to every point count
// once. For pins, the images are further pins, so that all move exactly to their places; a pin in a plane stays in it,
// and moves to the place in the plane that is nearest to its target. Throws InvalidInput as flow_of(stroke), for a
// mirror that is not valid, for a mask or relax, for a grid unless the normals are along axes, and for pins that are
// each other's images if their targets are not.
Flow flow_of(const Stroke& stroke, const Mirror& mirror);

// Returns the falloff of a stroke, from 3 to 7; std::nullopt for the wide falloff, and for strokes without a blend:
// relax, mask, and a stamp that slips.
std::optional<int> falloff_of(const Stroke& stroke);

// Sets the falloff of a stroke that has one. A bend with given thresholds keeps its zone, and its centre moves along
// the normal with the place where the weight is one half. Throws InvalidInput for a falloff that is not 3 to 7.
void set_falloff(Stroke& stroke, int falloff);

// Returns one sentence, with advice, for each property of a valid stroke that is likely to disappoint, such as strong
// flow back beside the tool. Does not judge handles given by vertices.
std::vector<std::string> warnings(const Stroke& stroke);

// Returns the stroke, prolonged to `strength` times its effect, strength >= 1. It begins as `stroke` does.
// - A path or a list of displacements is extended in its last direction, to `strength` times its length. A tapered path
//   keeps its end.
// - An angle, a rate, a depth and the motion of handles are multiplied; a factor is raised to that power.
// - The amount of a relax is multiplied, up to 1.
// Throws InvalidInput for a tool that cannot be prolonged, and for values that its tool cannot use.
Stroke prolonged(const Stroke& stroke, double strength);

// Returns the mirror image of a stroke, in the plane where the coordinate `axis` (0: x, 1: y, 2: z) is zero: it takes
// the mirror image of a shape to the mirror image of the result, up to rounding. A stamp's pose is mirrored so that it
// fits the mirror image of the tool, which its `mesh` must then name. Throws InvalidInput for handles given by
// vertices: their mirror images need not be vertices.
Stroke mirrored(const Stroke& stroke, int axis);

// x -> turn x + shift. turn is orthogonal: a rotation, or a rotation of a mirror image. By default the identity.
struct RigidMotion {
  Mat3d turn{};
  Vec3d shift{0, 0, 0};

  Vec3d operator()(const Vec3d& x) const { return turn * x + shift; }
  friend bool operator==(const RigidMotion&, const RigidMotion&) = default;
};

// Returns whether the motion makes mirror images.
bool is_reflection(const RigidMotion& motion);

// Returns the motion that does `first`, then `second`.
RigidMotion operator*(const RigidMotion& second, const RigidMotion& first);

// Returns the reflection in the plane through a point. The normal has any length but 0.
RigidMotion reflection_in(const Vec3d& point, const Vec3d& normal);

// Returns the rotation about the axis through a point, counterclockwise seen from the tip of the axis. The axis has any
// length but 0.
RigidMotion rotation_about(const Vec3d& point, const Vec3d& axis, double angle_rad);

// Returns the stroke, moved by the motion: it takes the moved shape to the moved result, up to rounding. After a
// reflection a stamp's pose fits the mirror image of its tool in the plane x = 0, which its `mesh` must then name.
// Throws as mirrored(), and for a grid unless `turn` only mirrors along axes.
Stroke transformed(const Stroke& stroke, const RigidMotion& motion);

}  // namespace knead
