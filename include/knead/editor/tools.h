// The description of each tool: its name, the keys of its strokes, and what a stroke becomes. Session files, the
// command, Studio and the check of the documentation all read it, so that a tool is described in one place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/stroke.h"
#include "knead/vec.h"

namespace knead {

// A number, or "auto" in its place.
struct AutoNumber {
  std::optional<double>* value = nullptr;
  bool* is_auto = nullptr;
};

// One of several words; the first is the default.
struct Choice {
  std::vector<std::string_view> words;
  std::size_t chosen = 0;
  std::function<void(std::size_t)> choose;  // makes words[i] the choice
};

// Points at the member of a stroke that a key stands for. Null: the key does not apply to this stroke.
using KeyValue =
    std::variant<double*, std::optional<double>*, AutoNumber, int*, Vec3d*, std::optional<Vec3d>*, std::vector<Vec3d>*,
                 std::vector<std::vector<Vec3d>>*, std::vector<std::uint32_t>*, std::vector<PaintSample>*,
                 std::vector<VertexRange>*, std::vector<double>*, std::vector<std::optional<PinRotation>>*, Mat3d*,
                 HandlesMotion*, std::vector<PoseItem>*, std::vector<PoseStiffness>*, bool*, std::array<int, 3>*,
                 SharedVectors*, SharedNumbers*, std::string*, Choice>;

// What a value means, and so how it is checked and mirrored. A vector is a place unless this says otherwise.
enum class Quantity {
  finite,        // a number or a place: any finite value
  positive,      // a number greater than 0
  angle,         // degrees; changes its sign in a mirror
  rate,          // degrees for a length, of any size; changes its sign in a mirror
  direction,     // a vector of any length but 0
  displacement,  // a difference of two places: any finite vector
  outer,         // a distance from the tool beyond which nothing moves; checked by the tool itself
  falloff,       // a whole number from 3 to 7
  wide_falloff,  // the same, or "wide": kWideFalloff; decides which other keys apply
  other,         // checked by the tool itself
};

// Says whether a line must give a key.
enum class Presence {
  required,
  optional,   // left out, the value is that of a stroke without it
  not_empty,  // optional, but an empty list is an error
};

// One key of a stroke in a session file.
struct StrokeKey {
  std::string_view name;
  Quantity quantity = Quantity::other;
  KeyValue value;
  Presence presence = Presence::required;
  std::string_view help{};   // what a person may want to know before changing the number; empty: not offered for that
  std::string_view needs{};  // the key and value without which this one does not apply, for messages
};

// Returns false for a key whose value is a null pointer.
bool applies(const StrokeKey& key);

// One tool. The strokes given to its functions are its own.
struct Tool {
  std::string_view name;  // in session files
  Stroke start;           // a stroke with every key at its default
  bool is_flow = true;    // false: its strokes are no flows
  // An event of the session: its line is {"NAME": {...}}, and {"NAME": null} for `start`. Else {"tool": "NAME", ...}.
  bool is_event = false;

  // Returns the keys, in the order of the session file. The pointers are valid as long as the stroke.
  std::function<std::vector<StrokeKey>(Stroke&)> keys;

  // Prepares an empty stroke for the keys that a line has, where these decide which others apply. Throws InvalidInput
  // for keys that exclude each other.
  std::function<void(Stroke&, const std::function<bool(std::string_view)>& has)> prepare;
};

// Returns the tools in the order of the alternatives of Stroke.
std::span<const Tool* const> tools();

// Returns the tool of a stroke.
const Tool& tool_of(const Stroke& stroke);

// Returns the tool with this name in session files, or a null pointer.
const Tool* find_tool(std::string_view name);

// Returns the member that a key of the stroke stands for; null if the tool has no such key of that type, or the key
// does not apply.
template <class T>
T* find_value(Stroke& stroke, std::string_view key) {
  for (const StrokeKey& each : tool_of(stroke).keys(stroke)) {
    auto* const* value = std::get_if<T*>(&each.value);
    if (each.name == key && value != nullptr) return *value;
  }
  return nullptr;
}

// Returns the file that a stroke names, as a stamp or print does; empty: it names none.
inline std::string file_of(Stroke stroke) {
  for (const char* const key : {"mesh", "file"}) {
    if (const auto* const file = find_value<std::string>(stroke, key)) return *file;
  }
  return {};
}

// Returns what a stroke does, in a few words: "Pull 0.2 mm". `unit`: of its lengths; empty: none is named.
std::string words_of(const Stroke& stroke, const std::string& unit);

// A straight line in the plane of a print's pattern: from its middle to the right, and upwards; of the pattern's
// height.
using PlaneLine = std::array<std::array<double, 2>, 2>;

// Returns the outline of what a print presses, where that is half as deep as at its deepest place. Its file is relative
// to the folder. Throws InvalidInput as a replay of the print.
std::vector<PlaneLine> print_outline(const PrintStroke& stroke, const std::filesystem::path& folder);

// Returns the fonts in this system's usual folders: their names, as a print takes them, and their files.
std::map<std::string, std::filesystem::path> font_files();

// The extensions, in lower case, of the pictures that a print reads; its other files are meshes.
inline constexpr std::array<std::string_view, 5> kPictureExtensions{".png", ".jpg", ".jpeg", ".pgm", ".ppm"};

// Returns whether a file's name ends in one of them, in lower or upper case.
bool is_picture(const std::filesystem::path& file);

// Lines through a shape under a pointer, for the tool "curve".

// Returns `count` points at equal lengths on the smooth line through points, as the tool takes the points of a line;
// straight between two. Repeated neighbours count once. count: 2 or more; fewer points than two are returned as they
// are.
std::vector<Vec3d> points_on_line(std::vector<Vec3d> points, std::size_t count);

// Returns `count` points, 2 or more, at equal lengths on the line of an arc without `from`: the longest axis of the
// shape's box, and a little beyond its ends, so that all of the shape bends. None for a box without a length.
std::vector<Vec3d> longest_axis(const Box& box, std::size_t count);

// The line through a shape has this many points at equal lengths, and a handle at some of them: at its ends, its
// middle, and for a long shape also at the quarters.
inline constexpr std::size_t kPointsOfLine = 17;

// Returns a smooth line along one that was drawn by hand, in the direction that suits the line `from`. It is smoothed
// over a twenty-fourth of its length, and up to a fifth, until the shape about `from` can follow its bends. It has
// kPointsOfLine points; none if the drawn line has no length.
std::vector<Vec3d> smoothed_line(const std::vector<Vec3d>& drawn, const std::vector<Vec3d>& from,
                                 std::span<const Vec3d> positions);

// Returns how many points there are from one handle of the line to the next. Handles are farther apart on a thick
// shape, so that it can follow them.
std::size_t points_between_handles(const std::vector<Vec3d>& line, std::span<const Vec3d> positions);

// Returns the line after one of its handles has moved by `by`. The other handles stay, and the line between them
// follows smoothly. `stride`: of points_between_handles(); `handle`: its number, from 0.
std::vector<Vec3d> with_handle_moved(std::vector<Vec3d> line, std::size_t stride, std::size_t handle, const Vec3d& by);

// Returns the stroke that takes the smooth line through the points `from` to the one through the points `to`, each 2 or
// more. An end of the line that moves less than half as far as the other one is fixed, else the middle.
CurveStroke curve_between(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to);

// A box of control points about a shape under a pointer, for the tool "lattice".

// Returns a lattice at rest about a box, and a little beyond it. A flat box gets a height. counts: as those of the
// stroke. Throws InvalidInput for a box that is empty or one point.
LatticeStroke lattice_about(const Box& box, const std::array<int, 3>& counts);

// Returns the places of the control points, with their displacements, in the order of the displacements.
std::vector<Vec3d> control_points(const LatticeStroke& stroke);

// A surface that a stroke reads and moves at the same time.

// The current positions and triangles of a shape, and how to move them.
struct LiveSurface {
  std::span<const Vec3d> positions;     // the current ones: apply moves them in place
  std::span<const Triangle> triangles;  // empty: a point cloud
  // Returns the current normal of a point of a cloud; null: there are none.
  std::function<Vec3d(std::uint32_t)> normal;
  std::function<bool(const Stroke&)> apply;  // applies a stroke that reads no surface; false: stop
  Progress* progress = nullptr;              // of long work between two calls of apply: says when to stop
  double part = 1;                           // of the stroke that takes place, from 0 to 1: its strength
};

// Returns the iterations of a relax whose effect is seen at once: with an amount of 1, ten dabs at one place remove
// nine tenths of a bump that is half as wide as their radius. `vertices_within`: how many the radius holds; a surface
// with more of them takes more iterations, up to 100 (at 67,000 vertices).
int relax_iterations(std::size_t vertices_within);

// Throws InvalidInput, with the key in quotes, unless the vertex is one of the shape's.
void require_vertex(std::string_view key, std::span<const Vec3d> positions, std::uint32_t vertex);

// The limit cylinder that limits a twist or bend: the velocity jumps there, so no triangle may cross it where something
// moves.

// The limit cylinder at the start of a stroke. The stroke moves the points within `radius` of the line {center + s
// normal} that have normal.(x - center) < outer. normal is a unit vector.
struct StrokeCylinder {
  Vec3d center;
  Vec3d normal;
  double radius = 0;
  double outer = 0;
  Vec3d last_normal;  // a bend's normal at the stroke's end

  friend bool operator==(const StrokeCylinder&, const StrokeCylinder&) = default;
};

// Returns the limit cylinder of a twist or bend with a radius, else nothing, as for bends that read the surface. The
// stroke is valid.
std::optional<StrokeCylinder> limit_cylinder_of(const Stroke& stroke);

// The triangles that cross a limit cylinder, and radii that would be crossed by none.
struct CylinderCheck {
  std::size_t crossing = 0;  // triangles that cross the limit cylinder where r < outer
  std::size_t later = 0;     // triangles that cross it only where a bend's turning normal brings r below outer
  // If crossing > 0: the nearest radii that no triangle crosses and within which something moves, rounded to about 6
  // digits and verified. There may be no smaller one.
  std::optional<double> smaller;
  std::optional<double> larger;
};

// Counts the triangles that cross the limit cylinder. A triangle crosses if its part with r < outer has points within
// the radius (or at it) and points beyond it; the deformation would tear exactly these. Time: linear, and a sort of the
// triangles if some cross.
CylinderCheck check_limit_cylinder(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                   std::span<const Triangle> triangles);

// Returns the one of the two radii that is nearer to `radius`, or nothing.
std::optional<double> nearest_radius(const CylinderCheck& check, double radius);

// Finding the limb of a shape that a person points at: a finger, an arm, a leg.

// A limb of a shape, such as a finger or an arm, and its joint.
struct Limb {
  std::vector<std::uint32_t> vertices;  // what can move rigidly: beyond the joint, in ascending order
  std::vector<std::uint32_t> bending;   // what is about the joint, and bends with the limb
  std::vector<std::uint32_t> body;      // what can hold while the limb bends: all else that is joined to it
  Vec3d joint;                          // the middle of the cross-section where the limb begins
  Vec3d direction{0, 0, 1};             // along the limb, from the joint: a unit vector
  double girth = 0;                     // round the joint
  bool has_neck = false;                // the shape widens behind the joint; else the limb begins at the given vertex
};

// Returns the limb on which a vertex lies, from the first place behind the vertex where the shape widens: where the
// girth grows by a third or more within one thickness of the limb. A cross-section is all that is equally far from the
// limb's tip, along the surface; the tip is where the surface rises to from the vertex, away from the core, which is
// about equally far from the ends of the shape. What no triangle joins to the vertex is not of the limb, which has no
// vertices where the given one has no triangle. Time: about 2 us a vertex. Throws
// std::out_of_range for a vertex that there is not.
Limb find_limb(std::span<const Vec3d> positions, std::span<const Triangle> triangles, std::uint32_t vertex);

// Returns the vertices about the border of a part that bend when the part moves rigidly and all else holds: so much
// that the shape is neither torn nor creased, in ascending order. None if the part has no border. Throws
// std::out_of_range for a vertex that there is not.
std::vector<std::uint32_t> bending_about(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                         std::span<const std::uint32_t> part);

// Places strokes: where on a shape a twist or bend moves one part and nothing else, and images of strokes in mirrors
// and about an axis.

// A radius for a limit cylinder. The part is the connected piece of the shape with r < outer at the start of the stroke
// that has the vertex nearest to the limit cylinder's centre.
struct CylinderProposal {
  std::optional<double> radius;  // with it only the part moves; a short number near the middle of the gap
  double part = 0;               // the part's greatest distance from the axis
  double others = kInfinity;     // least distance of anything else from the axis beyond that
  std::size_t within = 0;        // triangles of other pieces that are entirely nearer than `part`: they move along
  std::string problem;           // if there is no radius, one sentence: why, and what to do
};

// Returns a radius for the limit cylinder; its own radius is ignored. The radius is the geometric mean of `part` and
// `others`, or 1.25 times `part` if there is nothing else. check_limit_cylinder counts no crossing triangle for it, and
// no later one if the gap allows. There is no radius if the shape has nothing below outer, or if another piece is
// partly nearer to the axis than the part's farthest point. Time: linear; about 25 times that to explain why there is
// no radius.
CylinderProposal propose_limit_cylinder(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                        std::span<const Triangle> triangles);

// Returns a twist or bend with its radius "auto" replaced by the one of propose_limit_cylinder, and any other stroke
// unchanged. Adds notes to `remarks`. Throws InvalidInput if there is no radius; the message begins with the key in
// quotes.
Stroke with_found_radius(const Stroke& stroke, std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                         std::vector<std::string>& remarks);

// A line along a part of a shape, such as a finger or an arm.
struct CylinderQuery {
  Vec3d point;           // inside the part
  Vec3d direction;       // along the part, towards its tip; any length but 0
  Vec3d axis{0, 0, 0};   // of a bend whose sweep must reach nothing else, if possible; 0 disables this
  double angle_deg = 0;  // of that bend
};

// The numbers of a twist or bend that moves the part alone; r = normal.(x - center).
struct CylinderPlacement {
  Vec3d center;
  Vec3d normal;  // unit, away from the tip
  double inner = 0;
  double outer = 0;
  double radius = 0;
  double thickness = 0;  // greatest distance of the part from the line, in the plane through the point
  std::string problem;   // why there is no such place, one sentence; the numbers are then undefined
};

// Returns the place nearest to the point, towards the tip, where a limit cylinder holds the part and nothing else: the
// part is joined to the rest in one place only, the plane r = outer cuts it about as thick as it is at the point, and
// everything else is at least 1.1 times as far from the line as the part. The zone from inner to outer is twice as wide
// as the part is thick, or 1.2 times where the part is short; r = 0 is where a bend is symmetric (kCenterFraction).
// check_limit_cylinder accepts the radius. Time: linear for each place tried, 5 ms for 100,000 triangles; the places
// are a quarter of the thickness apart. Throws InvalidInput for a direction or axis that is 0 or not finite; Cancelled
// if `progress` is cancelled.
CylinderPlacement place_limit_cylinder(const CylinderQuery& query, std::span<const Vec3d> positions,
                                       std::span<const Triangle> triangles, const Progress* progress = nullptr);

// One image of what a tool does.
struct SymmetryImage {
  RigidMotion motion;
  // Bit mask of the coordinate planes through the origin (1: x, 2: y, 4: z), if the motion is only these; then images
  // are exact. 0: any other motion.
  unsigned planes = 0;
};

// Returns the file with the mirror image of a stamp's tool in the planes of a bit mask.
using ImageFile = std::function<std::string(const std::string& file, unsigned planes)>;

// Returns the image of a stroke. `image_file` is called for the reflection of a stamp only.
Stroke image_of(const Stroke& stroke, const SymmetryImage& image, const ImageFile& image_file);

// Returns the stroke and its images. Images that are the stroke itself or each other, up to `tolerance` in each number,
// count once.
std::vector<Stroke> with_images(const Stroke& stroke, std::span<const SymmetryImage> images, double tolerance,
                                const ImageFile& image_file);

// Returns strokes that do the same one after the other: one for each piece of the path of a ball, capsule or stamp and
// for each displacement of points; any other stroke as it is.
std::vector<Stroke> pieces_of(const Stroke& stroke);

// Returns the strokes of a gesture with all images, so that the sides grow together: the pieces of a stroke and of its
// images take turns, and so do the samples of paint and the points of relaxing. Images as in with_images. Without
// images, the strokes as they are.
std::vector<Stroke> symmetric_strokes(std::span<const Stroke> strokes, std::span<const SymmetryImage> images,
                                      double tolerance, const ImageFile& image_file);

// Painting along a path on the surface, and under a pointer (paper, section 4.2).

// Returns the length over which a path spreads one dab of full depth: the integral of the blend's weight over its own
// range, 17/35 outer for the default falloff. Along a straight path the dabs' displacements then add up to the depth.
double dab_length(const PaintStroke& stroke);

// The dabs of a stroke with a path: their places before they are moved to the surface, and how many times the stroke's
// depth and pinch they have in all, each as much.
struct PaintDabs {
  std::vector<Vec3d> aims;
  double doses = 0;
};

// Returns the dabs of a stroke with a path. A smooth curve (centripetal, third order) goes through the path's points;
// the dabs lie evenly along it, close enough that the result does not depend on their number. Every dab_length() of
// the path gets one dab of full depth in all; a shorter path also gets one. Throws InvalidInput for a path that
// needs more than a million dabs.
PaintDabs paint_dabs(const PaintStroke& stroke);

// Applies one dab after the other: each at the point of the current surface that is closest to the dab's place, against
// the normal there. Stops when apply returns false. The stroke is valid and has a path. Throws InvalidInput for a point
// cloud without normals, and at a place where the surface has no normal.
void paint_on(const PaintStroke& stroke, const LiveSurface& surface);

// Returns the mean plane of a surface within the radius of a place on it: the middle of the triangles that lie there
// and face the same way, by their areas, and their mean normal. The place itself where there are none. Costs a look at
// every triangle.
PaintSample mean_plane(std::span<const Triangle> triangles, const std::function<Vec3d(std::uint32_t)>& position,
                       const PaintSample& at, double radius);

// A brush of a sculptor: a pull, or paint, with the wide falloff.
struct Brush {
  std::string_view name;  // "move", "snakehook", "paint", "crease", "pinch" or "flatten"
  bool pulls = false;     // along a path that begins on the surface; else it paints
  double taper = 0;       // of a pull
  double pinch = 0;       // of paint, by the amount: above 0 it draws together, below 0 it flattens
  double sink = 0;        // of paint that pinches: the depth by the amount, relative to the radius
  double amount = 0;      // that suits as a rule: what stroke_of() takes
};

// Throws InvalidInput for another name.
const Brush& brush_named(std::string_view name);

// Returns the stroke of a brush, without a path. radius: of the bump, > 0. amount, of paint: how high a layer is,
// relative to the radius, or the logarithm by which it pinches; below 0 it does the contrary: it presses in, draws a
// ridge in place of a crease, draws apart, makes bumps higher.
Stroke stroke_of(const Brush& brush, double radius, double amount);

// What a pointer touches while it paints.
struct PaintTouch {
  PaintSample at;       // of the surface as it was before the painting began
  double radius = 0;    // outer threshold of a dab here, or its bump if it is wide; above 0
  double pressure = 1;  // how much each length of the way counts, above 0
};

// The plane to which a dab flattens the surface about a place.
using PaintPlane = std::function<PaintSample(const PaintSample& at, double radius)>;

// Painting with a pointer: dabs at even distances along the places that it touches, each where the dabs before it have
// moved that place of the surface. So the result does not depend on the speed of the person or the machine.
struct PaintDrag {
  PaintStroke stroke;                // the dabs with the radius and depth of now
  std::vector<PaintStroke> earlier;  // those with others
  Flow done;                         // of all dabs so far
  double spacing = 0;                // of dabs at full pressure, along the surface
  // Returns the plane of the surface as it was before the painting, for a dab of a radius that flattens; null: the one
  // through the place that is touched.
  PaintPlane plane;
  double travelled = 0;  // since the last dab
  Vec3d last;            // the place that was touched last

  // Returns the strokes so far; a later call returns more of them, or more samples in the last one.
  std::vector<Stroke> strokes() const;
};

// Begins with a dab. `stroke` has the outer threshold at full pressure, the depth and pinch of a whole layer, and no
// samples. `plane` as in PaintDrag.
PaintDrag begin_paint(const PaintStroke& stroke, const PaintTouch& touch, PaintPlane plane = nullptr);

// Goes on to a place near the last one, and adds a dab where the way since the last dab is long enough.
void drag_paint(PaintDrag& drag, const PaintTouch& touch);

// Ends the painting. One that is a single dab gets the full depth.
void end_paint(PaintDrag& drag);

// How strongly a flow or a deformation stretches a shape, and how wide the zone of a bend or twist must be to keep that
// small (method, section 10).

// The singular values of a deformation gradient. A small ball becomes an ellipsoid with half axes of so many times its
// radius. Their product is 1 where volume is kept.
struct Stretches {
  double greatest = 1;
  double middle = 1;
  double least = 1;

  friend bool operator==(const Stretches&, const Stretches&) = default;
};

// A stretch above this, or below its inverse, is worth a warning.
inline constexpr double kStrongStretch = 4;

// Returns the singular values of a matrix, the greatest first. Relative error about 1e-15 for well-conditioned
// matrices. Method: one-sided Jacobi rotations (Hestenes 1958).
Stretches stretches_of(const Mat3d& gradient);

// How stretches of a flow are measured.
struct StrainOptions {
  double length = 0;          // that distances refer to, such as the diagonal of the shape's box; above 0
  double step = 1e-4;         // of the length, between the path lines that are compared; above 0
  std::size_t samples = 512;  // at most so many points
  int threads = 0;            // 0: as many as the machine has
};

// Returns the stretches of the map that moves points from the flow's beginning to its end, at each of the points.
// Differences of seven path lines at each point, 1e-4 of the length apart by default, are right to about 1e-5. At a
// limit cylinder's border, where the map is torn, the side counts that is stretched less. Throws InvalidInput where
// validate(flow) does, or if the length is not above 0. A point whose path line cannot be followed gets infinity and 0.
std::vector<Stretches> stretches_of(const Flow& flow, std::span<const Vec3d> points, const StrainOptions& options);

// The greatest and the least stretch of a sample of points; they need not be at the same point.
struct GreatestStretch {
  double greatest = 1;
  double least = 1;
  Vec3d where;              // the point that is deformed most, before the flow
  std::size_t samples = 0;  // points that were looked at; 0: the flow deforms none

  // Returns whether a warning is due.
  bool is_strong() const { return greatest > kStrongStretch || least * kStrongStretch < 1; }
};

// Estimates the greatest stretch of a flow on a shape: the greatest of at most options.samples of its vertices. The
// candidates are the vertices that a segment deforms and not only moves, at its beginning or where it passes; of more
// candidates than samples, evenly spaced ones of the list are taken. The result is the same for every number of
// threads. Cost: about a weight for each vertex and segment, at most 4 million of these (then only every n-th vertex is
// a candidate), and seven path lines for each sample. Throws as stretches_of.
GreatestStretch greatest_stretch(const Flow& flow, std::span<const Vec3d> positions, const StrainOptions& options);

// How far a shape reaches from the line {center + s normal} of a bend or twist, in slices of equal height.
struct ZoneProfile {
  Vec3d center;
  Vec3d normal;                    // a unit vector
  Vec3d side{0, 0, 0};             // of a bend: distances count along it, across its axis; zero: all around the line
  std::optional<double> radius{};  // of the limit cylinder beyond which nothing counts
  double first = 0;                // r = normal.(x - center) where the first slice begins
  double height = 0;               // of a slice
  std::vector<double> extents{};   // for each slice the greatest distance; below 0: the slice is empty
  std::vector<double> along{};     // of a bend: for each slice the greatest distance along its axis

  friend bool operator==(const ZoneProfile&, const ZoneProfile&) = default;
};

// Returns the profile of a shape for a bend or twist; an empty one for other strokes. The stroke is valid. Without
// triangles the points count alone. Time: linear, about 10 ns a triangle.
ZoneProfile zone_profile(const Stroke& stroke, std::span<const Vec3d> positions, std::span<const Triangle> triangles);

// The zone of a bend or twist between its inner and its outer region, and the zone that the shape wants.
// A bend by phi radians of a part that reaches rho from its axis wants a width of 2.4 phi rho; it stretches the part
// about 2 times then. Below 1.6 phi rho it stretches it 3 times and more. A twist of tau radians per length shears the
// part by gamma = tau rho, and stretches it by gamma / 2 + sqrt(1 + gamma^2 / 4).
struct ZoneCheck {
  double extent = 0;         // rho: of the part in the zone, or of the part that enters it while a bend turns
  double width = 0;          // outer - inner
  double safe = 0;           // the least width that the stroke wants; of a twist by the same angle over the zone
  double stretch = 0;        // of a twist; 0 for a bend
  bool is_too_thin = false;  // a warning is due: a bend of less than 1.6 phi rho, a twist that stretches over 4 times
  double gauge = 0;          // of a bend: from 1, for a part about as wide as thick, to 0, for one 4 times as wide
};

// Returns the check, or nothing for strokes without such a zone, and where the profile is empty or of another line.
std::optional<ZoneCheck> check_zone(const Stroke& stroke, const ZoneProfile& profile);

// Returns the stroke with its zone widened to ZoneCheck::safe if it is thinner; a twist turns the same angle over it. A
// zone with a limit cylinder keeps its outer border and grows away from it; other zones grow about the centre. A bend
// with the default gauge 1 gets ZoneCheck::gauge.
Stroke with_safe_zone(const Stroke& stroke, const ZoneProfile& profile);

// Returns the most degrees of a bend or twist that one edge of the triangles reaches over; 0 for other strokes. The
// flow turns the ends of an edge, which stays straight: from 30 degrees on the triangles may lose a fifth of the
// volume. Time: linear, about 10 ns a triangle.
double most_turn_of_an_edge_deg(const Stroke& stroke, std::span<const Vec3d> positions,
                                std::span<const Triangle> triangles);

// Returns one sentence with the figure that would do if is_too_thin, or if a gauge is far from the check's, or nothing.
std::optional<std::string> zone_warning(const Stroke& stroke, const ZoneProfile& profile);

// Returns the greatest `outer` with which an implicit, points, rotate or stretch stroke moves none of the points that
// it leaves at rest now, to three digits: with the points on the boundary of a volume mesh, the widest transition that
// fits into it. Strain falls with the width. Returns nothing for other tools, where no point rests, and where less than
// 5% can be gained. Cost: about 20 times that of FlowSupport for each point. Throws InvalidInput as flow_of(stroke).
std::optional<double> widest_outer(const Stroke& stroke, std::span<const Vec3d> boundary, int threads = 0);

}  // namespace knead
