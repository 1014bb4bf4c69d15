// The tools of Studio: their names, buttons, placement and drags; the settings of a tool, and what is placed for it.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/replay.h"
#include "knead/stroke.h"
#include "knead/vec.h"

namespace knead::studio {

// The plane or line along which a drag moves the tool.
enum class DragMode { view, surface, normal, axis };

// The start of a ball or capsule.
//   inside   under the surface, as deep as its inner region: the end of the pulled part is round
//   surface  on the surface: the end is flat
//   plane    in the plane through the view's target
// Beside the shape every drag begins in that plane.
enum class PullStart { inside, surface, plane };

// The setting of paint that the pressure of a pen changes.
enum class PenPressure { none, radius, depth };

// paint: a brush; lasso: a closed line; box: a rectangle.
enum class MaskMode { paint, lasso, box };

// The effect of clicks and drags on the pose.
//   pins   set and drag pins; the surface near a pin turns with the shape, which stays as rigid as it can
//   lasso  draw a line round a part of the shape, which then holds or moves rigidly
//   brush  paint such a part
//   exact  set and drag pins, each to its exact place; everything within their radius follows
enum class PoseMode { pins, lasso, brush, exact };

struct PlacedTools;
struct ToolSettings;

// Repeats everything that a tool does, in addition to ToolSettings::mirror.
struct Symmetry {
  Vec3d center{0, 0, 0};  // of the mirror's planes x, y and z, and on the axis
  struct Plane {
    Vec3d point;
    Vec3d normal{1, 0, 0};  // a unit vector

    friend bool operator==(const Plane&, const Plane&) = default;
  };
  std::optional<Plane> plane{};  // one more mirror
  int turns = 1;                 // about the axis, 1 to kMaxTurns; 1: none
  Vec3d axis{0, 1, 0};           // of any length but 0

  friend bool operator==(const Symmetry&, const Symmetry&) = default;
};
inline constexpr int kMaxTurns = 32;

// The shape of a stamp.
struct StampShape {
  std::string name;                  // for people
  std::string file;                  // in the document's folder of stamps
  std::shared_ptr<const Mesh> mesh;  // about its origin
};

// A picture that is printed.
struct PrintPicture {
  std::string file;              // in the document's folder of stamps
  std::filesystem::path source;  // where it came from
  std::vector<PlaneLine> outline{};
};

// The placement of rotate, stretch, twist, bend and stamp. x, y and z are unit vectors, perpendicular to each other. A
// bend turns about x; all other tools act along z.
struct Placement {
  Vec3d center;
  Vec3d x{1, 0, 0};
  Vec3d y{0, 1, 0};
  Vec3d z{0, 0, 1};
  // For twist and bend, on the shape at the time of the placement: the limit cylinder, or why there is none.
  std::optional<CylinderPlacement> limit_cylinder{};
  // For twist and bend, on the shape at the time of the placement: its extent around their line. Null: not known yet.
  std::shared_ptr<const ZoneProfile> profile{};

  friend bool operator==(const Placement& a, const Placement& b) {
    return a.center == b.center && a.x == b.x && a.y == b.y && a.z == b.z;
  }
};

// The use of a tool.
enum class ToolUse {
  pull,        // a drag carries it along a path
  paint,       // a drag sets dabs on the surface
  inflate,     // a drag draws a line on the surface, along which the shape then grows by a volume
  print,       // a drag lays a text or a picture on the surface, which is then raised or pressed in
  smooth,      // a drag smooths the surface, as Shift and a drag do with every tool
  points,      // clicks set points on the surface; a drag of one moves all
  curve,       // a drag draws a curve on the surface; another drag moves it
  stamp,       // a click places it; a drag of its middle presses it in
  turn,        // a click places it; a drag beside it turns it
  bend_along,  // a drag of a handle, or a drawn line, moves the line through the shape
  lattice,     // a drag moves control points of a box about the shape, or draws a line round those that it selects
  pose,        // a click sets a pin on the surface; a drag moves one or all that are selected, and the others hold
  mask,        // drags paint or enclose the part that is fixed
};

// The purpose of a tool: tools of one group stand together and have one colour.
enum class ToolGroup { move, shape, pose, mask };
inline constexpr std::array kToolGroups{ToolGroup::move, ToolGroup::shape, ToolGroup::pose, ToolGroup::mask};
const char* name_of(ToolGroup group);

// The direction of a placement's z axis after a click.
enum class Facing {
  viewer,   // towards the viewer
  surface,  // out of the surface
  up,       // up in the picture; the centre is in the middle of the shape
};

// The turning of a tool of ToolUse::turn.
struct Turning {
  Facing facing = Facing::viewer;
  Vec3d Placement::*axis = &Placement::z;  // about which it turns
  bool is_percent = false;                 // a drag gives percent of a logarithm; else degrees
  bool takes_limit_cylinder = false;       // it can move one part alone

  // Returns the stroke for an amount. `limit cylinder` is null if nothing limits it.
  Stroke (*stroke)(const ToolSettings& settings, const Placement& placement, double amount,
                   const CylinderPlacement* limit_cylinder) = nullptr;
};

enum class IconShape { line, circle, disc, halo, box, wave, arc, arrow, arrow_head };

// A part of an icon, in a square from -1 to 1, y downwards. line, box, arrow: two points; circle, disc, halo: centre
// and radius; wave: the four points of a Bezier curve; arc: centre, radius, first and last angle; arrow_head: point,
// angle.
struct IconPart {
  IconShape shape;
  std::array<float, 8> numbers;
};

// The row of a tool in Studio. Everything that Studio shows of it or does with it comes from here.
struct StudioTool {
  std::string name;  // for people; word_of() in scripts, and after "tool_" in the preferences
  const char* key;   // the default key that chooses it
  ToolUse use;
  ToolGroup group;
  const char* tip;                 // one sentence: what it does
  const char* also = "";           // other words for the search
  double size = 1;                 // the radius at first, relative to that of other tools
  bool has_inner = false;          // its inner ratio can be set
  bool is_long = false;            // of ToolUse::pull: a capsule across the view instead of a ball
  const Brush* brush = nullptr;    // of ToolUse::paint, and of a ToolUse::pull with the wide falloff
  DragMode drag = DragMode::view;  // the default
  // The settings (setting.h) that are lengths relative to the radius, or a volume relative to its cube. Sliders show
  // the length or the volume itself.
  std::vector<std::string_view> sliders{};
  std::string_view strength{};  // the setting that is the strength of the tool, a plain number
  const char* hint;             // what to do first
  const char* second_hint;      // once something is placed; for tools with paint_in, when that is set
  std::vector<IconPart> icon;
  Turning turning{};  // of ToolUse::turn
};

// Returns the tools in the order of the tool bar.
std::span<const StudioTool> studio_tools();

// Returns the text in lower case.
std::string lower(std::string text);

// Returns the name of a tool in lower case, with "_" in the place of a space.
std::string word_of(const StudioTool& tool);

// Returns the tool with this word_of(), or a null pointer.
const StudioTool* studio_tool(std::string_view word);

// Returns whether the chosen tool moves the shape with a falloff.
bool blends(const ToolSettings& settings);

// Returns whether the tool adds or takes away, as paint_in says.
bool has_two_signs(ToolUse use);

// Returns the first tool with this use.
const StudioTool& studio_tool(ToolUse use);

// The rule by which a drag beside the gizmo turns a tool of ToolUse::turn; it depends on the view of the axis.
enum class TurnDrag {
  round,     // round the gizmo's middle: the axis faces the viewer, or away
  sideways,  // to the right or left
  upright,   // up or down
};

// Returns one line: what to do with the tool now.
std::string hint_of(const ToolSettings& settings, const PlacedTools& placed, TurnDrag turning);

// The settings that each tool keeps while others are used.
struct OwnSettings {
  double radius = 1;              // the outer threshold, > 0
  double inner_ratio = 0.35;      // inner over outer threshold, in [0.01, 0.95]
  int falloff = kDefaultFalloff;  // the shape of the blend, from 3 to 7 (knead/field.h)
  DragMode drag = DragMode::view;
  Vec3d axis{0, 0, 1};  // of DragMode::axis
  PullStart start = PullStart::inside;
  double pinch = 0.7;     // of tools that pinch or flatten: the logarithm by which a layer thins the surface, > 0
  bool paint_in = false;  // paint and print press in, inflate shrinks; Ctrl inverts
};

inline constexpr double kMaxInflateDepth = 0.6;  // relative to the radius: more would not fit into it

// The settings of panels and keys. Lengths are in the mesh's own units.
struct ToolSettings : OwnSettings {
  const StudioTool* tool = &studio_tools().front();
  bool auto_radius = true;    // of exact pins: from their distances, instead of `radius`
  double capsule_length = 1;  // half of it, relative to the radius
  double depth = 0.15;        // of paint, print and inflate, relative to the radius, > 0
  double smoothing = 0.5;     // of smooth: the fraction of the distance to the smooth surface, in (0, 1]
  int exponent = 8;           // of points and curves; even, 4 or more
  double stamp_size = 0.5;    // the tool's half extent, relative to the radius
  StampContact stamp_contact = StampContact::automatic;
  std::string text = "Text";  // of print, where no picture is chosen; its capital letters are as high as the radius
  std::string font;           // as a print names it; empty: a usual one
  CurveLength bend_length = CurveLength::keep;  // of bend_along
  CurveKeeps bend_keep = CurveKeeps::volume;    // of bend_along
  LatticeMode lattice_mode = LatticeMode::volume;
  std::array<int, 3> lattice_counts{3, 3, 3};  // of control points along x, y and z
  bool lasso_selects = false;                  // a drag beside the pins draws a line round those that it selects
  PoseMode pose = PoseMode::pins;
  double pose_detail = 0;  // of the shape's size; 0: from the thickness of the moving parts
  PenPressure pressure = PenPressure::depth;
  MaskMode mask_mode = MaskMode::paint;
  double mask_width = 0.5;          // of a mask's border, relative to the radius, > 0
  bool uses_limit_cylinder = true;  // twist and bend move one part that Studio finds; false: all below the plane
  std::array<bool, 3> mirror{};     // in x, y and z, through symmetry.center
  Symmetry symmetry;
  bool widens_zone = true;  // of twist and bend, where it is too thin for the angle
  bool remesh = false;      // when a drag ends; a shape that Studio made begins with true
  RemeshSettings remesh_settings;
  double first_radius = 1;                         // of a tool that has not been used yet
  std::vector<std::optional<OwnSettings>> kept{};  // of the other tools, in the order of studio_tools()
};

// Chooses a tool, with its own settings of its last use.
void choose_tool(const StudioTool& tool, ToolSettings& settings);

// Returns whether the tool poses with exact pins, which have a radius.
inline bool has_exact_pins(const ToolSettings& settings) {
  return settings.tool->use == ToolUse::pose && settings.pose == PoseMode::exact;
}

// A place on the surface that can be moved: a vertex, so that a pin moves with the surface.
struct Pin {
  // The vertex on one mesh. Remeshing gives the shape another mesh, and undo the one before.
  struct PinVertex {
    std::weak_ptr<const Mesh> mesh;
    std::uint32_t vertex = 0;
  };
  Vec3d place;
  bool holds = true;  // while another pin is dragged; false: it is free, and moves with the surface
  std::vector<PinVertex> vertices{};
  bool is_selected = false;  // a drag of a selected pin moves all selected pins
};

// The parts of a pose, with numbers (gestures/parts.cpp). A part holds while another one, or a pin, is dragged, or it
// is free, and moves with the surface.
struct PartMarks {
  std::vector<std::uint8_t> of_vertex;    // for each vertex the number of its part, from 1; 0: none; empty: none has
  std::vector<bool> holds;                // of each part
  std::vector<double> stiffness;          // of each part; 1: as everything else
  std::optional<std::size_t> selected{};  // from 0
  std::optional<Placement> placement{};   // of the gizmo of the selected part
  bool is_ahead = false;                  // a drag has moved the gizmo, and the shape has not followed yet
  ShapeState at{};                        // the shape whose vertices these are
  // The same on meshes that the shape has had.
  struct OnMesh {
    std::weak_ptr<const Mesh> mesh;
    std::vector<std::uint8_t> of_vertex;
  };
  std::vector<OnMesh> on_meshes{};
};

inline constexpr int kMaxLatticePoints = 8;  // control points along an edge

// The lattice about the shape.
struct PlacedLattice {
  LatticeStroke stroke;        // with the displacements so far; without control points: not laid yet
  std::vector<bool> selected;  // of each control point
  std::size_t entry = 0;       // of the history: its own, or the one that its first drag makes
  bool is_ahead = false;       // a drag has moved it, and the shape has not followed yet
};

// The things that are placed for the next drag.
struct PlacedTools {
  std::vector<Vec3d> points;
  std::vector<std::vector<Vec3d>> curves;
  std::vector<Vec3d> line;      // of bend_along, through the shape
  std::size_t line_stride = 1;  // from one handle of it to the next
  PlacedLattice lattice;
  std::optional<Placement> placement;
  std::optional<StampShape> stamp;
  std::optional<PrintPicture> picture;
  std::vector<Pin> pins;
  PartMarks parts;
  std::optional<std::size_t> lit_pin;  // the pin that the panel points to
  std::vector<Vec3d> plane_points;     // the first points of a mirror's plane through three
};

// Strokes repeated in mirrors and about an axis.

// Returns all images but the original. The number of images of a stroke with mirrors and turns is at most
// turns * 2^mirrors - 1.
std::vector<SymmetryImage> images_of(const ToolSettings& settings);

// Returns the planes of the mirrors if they are at right angles and there are no other images; else nothing.
std::optional<Mirror> mirror_of(const ToolSettings& settings);

// Returns the radius at which the motion has fallen to its half.
double half_radius(const ToolSettings& settings, double inner_ratio);

// Returns the start of a drag that touches the surface at a place and has this motion. It is moved into a mirror's
// plane or onto the axis if these are nearer than half of the inner region; for a motion along them, nearer than half
// of half_radius(). Images that are nearer to each other would move the surface between them farther than themselves,
// and tear it into lobes.
Vec3d snapped_to_symmetry(Vec3d p, const Vec3d& touched, const Vec3d& motion, const ToolSettings& settings);

// Returns p in the planes and on the axis in which the first point of the path lies.
Vec3d kept_in_symmetry(Vec3d p, const Vec3d& first, const ToolSettings& settings);

// Returns the planes of the mirrors.
std::vector<Symmetry::Plane> mirror_planes(const ToolSettings& settings);

}  // namespace knead::studio
