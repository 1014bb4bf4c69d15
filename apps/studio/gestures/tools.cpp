// The tools of Studio, a row each; and how strokes are repeated in mirrors and about an axis.
#include "gestures/tools.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "knead/error.h"

namespace knead::studio {

namespace {

using enum IconShape;

constexpr float kPiFloat = std::numbers::pi_v<float>;
constexpr const char* kPullHint = "Drag the shape, or start beside it. Type a distance while you drag; Ctrl snaps it.";
constexpr const char* kTurnHint = "Click on the shape to place the tool.";
constexpr const char* kTurnAgain = "Ctrl snaps; the arrows move the gizmo, its rings turn it.";
constexpr const char* kBendAlongHint =
    "Drag a handle of the line, or draw a new line: the shape follows. Escape: a straight line again.";
constexpr const char* kLatticeHint =
    "Drag a control point. Shift+click or a line round several selects them: they move together. Escape: a new "
    "lattice.";
constexpr double kOnPlane = 1e-9;     // of the radius: what counts as in a plane
constexpr double kHalfOfBump = 0.54;  // of the bump of the wide falloff: its velocity along the motion is half there
constexpr double kSizeOfLines = 0.4;  // StudioTool::size of tools that draw fine lines

double inner_of(const ToolSettings& settings) { return settings.inner_ratio * settings.radius; }

Stroke rotated(const ToolSettings& settings, const Placement& at, double amount,
               const CylinderPlacement* /*limit cylinder*/) {
  return RotateStroke{at.center, at.z, amount, inner_of(settings), settings.radius};
}

Stroke stretched(const ToolSettings& settings, const Placement& at, double amount,
                 const CylinderPlacement* /*limit cylinder*/) {
  return StretchStroke{at.center, at.z, std::exp(amount / 100), inner_of(settings), settings.radius};
}

Stroke twisted(const ToolSettings& settings, const Placement& at, double amount,
               const CylinderPlacement* limit_cylinder) {
  TwistStroke stroke{at.center, at.z, 0, -0.5 * settings.radius, 0.5 * settings.radius};
  stroke.normal = -at.z;
  if (limit_cylinder != nullptr) {
    stroke.center = limit_cylinder->center;
    stroke.axis = -limit_cylinder->normal;
    stroke.normal = limit_cylinder->normal;
    stroke.inner = limit_cylinder->inner;
    stroke.outer = limit_cylinder->outer;
    stroke.radius = limit_cylinder->radius;
  }
  stroke.rate_deg = -amount / (stroke.outer - stroke.inner);
  return stroke;
}

Stroke bent(const ToolSettings& settings, const Placement& at, double amount, const CylinderPlacement* limit_cylinder) {
  BendStroke stroke;
  stroke.center = at.center;
  stroke.normal = -at.z;
  stroke.angle_deg = amount;
  stroke.extent = BendWidth{settings.radius};
  if (limit_cylinder != nullptr) {
    stroke.center = limit_cylinder->center;
    stroke.normal = limit_cylinder->normal;
    stroke.extent = BendThresholds{limit_cylinder->inner, limit_cylinder->outer};
    stroke.radius = limit_cylinder->radius;
  }
  const Vec3d across = at.x - stroke.normal * dot(stroke.normal, at.x);
  stroke.axis = norm(across) > 1e-6 ? normalized(across) : any_orthogonal(stroke.normal);
  return stroke;
}

const std::vector<StudioTool> kTools{
    {.name = "Move",
     .key = "Q",
     .use = ToolUse::pull,
     .group = ToolGroup::move,
     .tip = "Pulls the surface along with the pointer, and fills it up from far around.",
     .also = "grab snakehook elastic extrude pull",
     .brush = &brush_named("move"),
     .hint = kPullHint,
     .second_hint = kPullHint,
     .icon = {{wave, {-1, 0.8F, -0.2F, 0.8F, -0.35F, -0.1F, 0, -0.1F}},
              {wave, {0, -0.1F, 0.35F, -0.1F, 0.2F, 0.8F, 1, 0.8F}},
              {arrow, {0, 0.5F, 0, -0.95F}}}},
    {.name = "Snakehook",
     .key = "K",
     .use = ToolUse::pull,
     .group = ToolGroup::move,
     .tip = "Pulls out a horn or a tail that ends in a point.",
     .also = "horn tail tentacle spike extrude snake hook pull",
     .brush = &brush_named("snakehook"),
     .hint = kPullHint,
     .second_hint = kPullHint,
     .icon = {{wave, {-1, 0.8F, -0.1F, 0.8F, -0.5F, -0.5F, 0.75F, -0.85F}},
              {wave, {0.75F, -0.85F, 0.15F, -0.3F, 0.1F, 0.8F, 1, 0.8F}}}},
    {.name = "Ball",
     .key = "1",
     .use = ToolUse::pull,
     .group = ToolGroup::move,
     .tip = "Pulls a round piece of the surface along with the pointer.",
     .also = "grab extrude pull",
     .has_inner = true,
     .hint = kPullHint,
     .second_hint = kPullHint,
     .icon = {{halo, {-0.2F, 0.2F, 0.75F}}, {circle, {-0.2F, 0.2F, 0.42F}}, {arrow, {-0.2F, 0.2F, 0.85F, -0.85F}}}},
    {.name = "Capsule",
     .key = "2",
     .use = ToolUse::pull,
     .group = ToolGroup::move,
     .tip = "Pulls a long piece of the surface, as wide as you set it.",
     .also = "grab move ridge pull",
     .has_inner = true,
     .is_long = true,
     .sliders = {"capsule_length"},
     .hint = kPullHint,
     .second_hint = kPullHint,
     .icon = {{arc, {-0.45F, 0.25F, 0.42F, 0.5F * kPiFloat, 1.5F * kPiFloat}},
              {arc, {0.45F, 0.25F, 0.42F, -0.5F * kPiFloat, 0.5F * kPiFloat}},
              {line, {-0.45F, -0.17F, 0.45F, -0.17F}},
              {line, {-0.45F, 0.67F, 0.45F, 0.67F}},
              {arrow, {0, 0.25F, 0, -0.9F}}}},
    {.name = "Paint",
     .key = "3",
     .use = ToolUse::paint,
     .group = ToolGroup::shape,
     .tip = "Paints the surface outwards, or with Ctrl inwards.",
     .also = "clay draw layer brush build groove carve",
     .brush = &brush_named("paint"),
     .sliders = {"depth"},
     .hint = "Paint on the shape to pull it out; Ctrl presses it in.",
     .second_hint = "Paint on the shape to press it in; Ctrl pulls it out.",
     .icon = {{wave, {-1, 0.8F, -0.3F, 0.8F, -0.5F, 0.1F, 0, 0.1F}},
              {wave, {0, 0.1F, 0.5F, 0.1F, 0.3F, 0.8F, 1, 0.8F}},
              {line, {0.1F, -0.25F, 0.7F, -0.95F}},
              {disc, {0.03F, -0.17F, 0.2F}}}},
    {.name = "Crease",
     .key = "Shift+C",
     .use = ToolUse::paint,
     .group = ToolGroup::shape,
     .tip = "Draws a sharp crease, or with Ctrl a sharp ridge.",
     .also = "groove wrinkle ridge carve line sharpen",
     .size = kSizeOfLines,
     .brush = &brush_named("crease"),
     .strength = "pinch",
     .hint = "Paint a crease on the shape; Ctrl makes a ridge.",
     .second_hint = "Paint a ridge on the shape; Ctrl makes a crease.",
     .icon = {{wave, {-1, 0.05F, -0.4F, 0.05F, -0.1F, 0.1F, 0, 0.9F}},
              {wave, {0, 0.9F, 0.1F, 0.1F, 0.4F, 0.05F, 1, 0.05F}},
              {arrow, {-0.95F, -0.5F, -0.3F, -0.5F}},
              {arrow, {0.95F, -0.5F, 0.3F, -0.5F}}}},
    {.name = "Pinch",
     .key = "Shift+P",
     .use = ToolUse::paint,
     .group = ToolGroup::shape,
     .tip = "Draws the surface together, so that edges grow sharp; with Ctrl apart.",
     .also = "sharpen edge crease magnify",
     .size = kSizeOfLines,
     .brush = &brush_named("pinch"),
     .strength = "pinch",
     .hint = "Paint along an edge to sharpen it; Ctrl draws the surface apart.",
     .second_hint = "Paint to draw the surface apart; Ctrl sharpens.",
     .icon = {{wave, {-1, 0.75F, -0.3F, 0.75F, -0.08F, 0.4F, 0, -0.35F}},
              {wave, {0, -0.35F, 0.08F, 0.4F, 0.3F, 0.75F, 1, 0.75F}},
              {arrow, {-0.95F, 0.1F, -0.35F, 0.1F}},
              {arrow, {0.95F, 0.1F, 0.35F, 0.1F}}}},
    {.name = "Flatten",
     .key = "Shift+O",
     .use = ToolUse::paint,
     .group = ToolGroup::shape,
     .tip = "Presses bumps and dents to a plane; with Ctrl it makes them stronger.",
     .also = "scrape plane level trim polish",
     .brush = &brush_named("flatten"),
     .strength = "pinch",
     .hint = "Paint over bumps to level them; Ctrl makes them stronger.",
     .second_hint = "Paint over bumps to make them stronger; Ctrl levels them.",
     .icon = {{line, {-1, 0.5F, 1, 0.5F}}, {arc, {0, 0.5F, 0.5F, -kPiFloat, 0}}, {arrow, {0, -0.95F, 0, -0.15F}}}},
    {.name = "Inflate",
     .key = "J",
     .use = ToolUse::inflate,
     .group = ToolGroup::shape,
     .tip = "Makes the shape grow along a line, or with Ctrl shrink.",
     .also = "blob swell puff grow shrink",
     .sliders = {"depth"},
     .hint = "Draw a line on the shape, or click: it grows there. Type how far while you draw.",
     .second_hint = "Draw a line on the shape, or click: it shrinks there; Ctrl makes it grow.",
     .icon = {{wave, {-1, 0.8F, -0.4F, 0.8F, -0.75F, -0.2F, 0, -0.2F}},
              {wave, {0, -0.2F, 0.75F, -0.2F, 0.4F, 0.8F, 1, 0.8F}},
              {arrow, {0, 0.5F, 0, 0.05F}},
              {arrow, {-0.25F, 0.6F, -0.62F, 0.2F}},
              {arrow, {0.25F, 0.6F, 0.62F, 0.2F}}}},
    {.name = "Smooth",
     .key = "O",
     .use = ToolUse::smooth,
     .group = ToolGroup::shape,
     .tip = "Smooths bumps away, as Shift and a drag do with every tool.",
     .also = "relax blur soften polish",
     .strength = "smoothing",
     .hint = "Paint over what is rough; Ctrl evens out the triangles only.",
     .second_hint = "Paint over what is rough; Ctrl evens out the triangles only.",
     .icon = {{wave, {-0.95F, 0.3F, -0.75F, -0.7F, -0.5F, 1.1F, -0.2F, 0.25F}},
              {wave, {-0.2F, 0.25F, 0.1F, -0.1F, 0.5F, 0.35F, 0.95F, 0.25F}},
              {arrow, {-0.35F, -0.6F, 0.75F, -0.6F}}}},
    {.name = "Points",
     .key = "4",
     .use = ToolUse::points,
     .group = ToolGroup::move,
     .tip = "Moves several points of the surface together.",
     .also = "grab vertices",
     .hint = "Click points on the shape, then drag one of them.",
     .second_hint = "Drag one of the points, or click more. Escape removes them.",
     .icon = {{disc, {-0.55F, 0.45F, 0.2F}},
              {disc, {0.1F, 0.65F, 0.2F}},
              {disc, {0.6F, 0.3F, 0.2F}},
              {arrow, {0, 0.15F, 0, -0.9F}}}},
    {.name = "Curve",
     .key = "5",
     .use = ToolUse::curve,
     .group = ToolGroup::move,
     .tip = "Moves a line that you draw on the surface.",
     .also = "line wrinkle",
     .hint = "Draw a curve on the shape, then drag it.",
     .second_hint = "Drag the curve, or draw more. Escape removes them.",
     .icon = {{wave, {-0.9F, 0.3F, -0.4F, 1.1F, 0.3F, -0.1F, 0.9F, 0.6F}}, {arrow, {0, 0.2F, 0, -0.9F}}}},
    {.name = "Stamp",
     .key = "6",
     .use = ToolUse::stamp,
     .group = ToolGroup::shape,
     .tip = "Presses a solid into the shape.",
     .also = "emboss engrave press",
     .drag = DragMode::normal,
     .sliders = {"stamp_size"},
     .hint = "Click on the shape to place the stamp.",
     .second_hint = "Drag the stamp by its middle into the shape; its arrows move it and its rings turn it.",
     .icon = {{box, {-0.35F, -0.9F, 0.35F, 0}},
              {wave, {-1, 0.2F, -0.4F, 0.2F, -0.7F, 0.8F, 0, 0.8F}},
              {wave, {0, 0.8F, 0.7F, 0.8F, 0.4F, 0.2F, 1, 0.2F}}}},
    {.name = "Print",
     .key = "U",
     .use = ToolUse::print,
     .group = ToolGroup::shape,
     .tip = "Raises a text or a picture out of the surface, or with Ctrl presses it in.",
     .also = "text letter word font alpha logo emboss engrave picture",
     .sliders = {"depth"},
     .hint = "Press on the shape, drag the text to its place, and let go: it is raised; Ctrl presses it in.",
     .second_hint = "Press on the shape, drag the text to its place, and let go: it is pressed in; Ctrl raises it.",
     .icon = {{line, {-0.6F, 0.85F, 0, -0.85F}},
              {line, {0, -0.85F, 0.6F, 0.85F}},
              {line, {-0.36F, 0.2F, 0.36F, 0.2F}}}},
    {.name = "Rotate",
     .key = "7",
     .use = ToolUse::turn,
     .group = ToolGroup::move,
     .tip = "Turns everything within a ball.",
     .also = "turn spin",
     .has_inner = true,
     .hint = kTurnHint,
     .second_hint = kTurnAgain,
     .icon = {{disc, {0, 0, 0.16F}},
              {arc, {0, 0, 0.75F, -0.3F * kPiFloat, 1.3F * kPiFloat}},
              {arrow_head, {0.44F, -0.61F, -0.75F * kPiFloat}}},
     .turning = {.facing = Facing::viewer, .stroke = rotated}},
    {.name = "Stretch",
     .key = "8",
     .use = ToolUse::turn,
     .group = ToolGroup::move,
     .tip = "Makes a part longer and thinner, or shorter and thicker.",
     .also = "scale resize longer shorter squash",
     .has_inner = true,
     .hint = kTurnHint,
     .second_hint = kTurnAgain,
     .icon = {{box, {-0.3F, -0.3F, 0.3F, 0.3F}}, {arrow, {0.45F, 0, 0.98F, 0}}, {arrow, {-0.45F, 0, -0.98F, 0}}},
     .turning = {.facing = Facing::surface, .is_percent = true, .stroke = stretched}},
    {.name = "Twist",
     .key = "9",
     .use = ToolUse::turn,
     .group = ToolGroup::pose,
     .tip = "Turns a finger, an arm or a leg about its length.",
     .also = "screw wring",
     .hint = kTurnHint,
     .second_hint = kTurnAgain,
     .icon = {{wave, {-0.5F, 0.95F, -0.5F, 0.1F, 0.5F, -0.1F, 0.5F, -0.95F}},
              {wave, {0.5F, 0.95F, 0.5F, 0.1F, -0.5F, -0.1F, -0.5F, -0.95F}},
              {line, {-0.5F, 0.95F, 0.5F, 0.95F}},
              {line, {-0.5F, -0.95F, 0.5F, -0.95F}}},
     .turning = {.facing = Facing::up, .takes_limit_cylinder = true, .stroke = twisted}},
    {.name = "Bend",
     .key = "0",
     .use = ToolUse::turn,
     .group = ToolGroup::pose,
     .tip = "Bends a finger, an arm or a leg at a joint.",
     .also = "arc fold knee elbow",
     .hint = kTurnHint,
     .second_hint = kTurnAgain,
     .icon = {{wave, {-0.7F, 0.95F, -0.7F, -0.1F, -0.4F, -0.75F, 0.5F, -0.85F}},
              {wave, {-0.05F, 0.95F, -0.05F, 0.3F, 0.1F, -0.1F, 0.75F, -0.25F}},
              {line, {0.5F, -0.85F, 0.75F, -0.25F}},
              {line, {-0.7F, 0.95F, -0.05F, 0.95F}}},
     .turning = {.facing = Facing::up, .axis = &Placement::x, .takes_limit_cylinder = true, .stroke = bent}},
    {.name = "Bend along",
     .key = "A",
     .use = ToolUse::bend_along,
     .group = ToolGroup::pose,
     .tip = "Bends the whole shape along a line, which you draw or move by its handles.",
     .also = "path spline wrap arc spine snake",
     .hint = kBendAlongHint,
     .second_hint = kBendAlongHint,
     .icon = {{wave, {-0.85F, 0.6F, -0.75F, -0.95F, 0.75F, -0.95F, 0.85F, 0.6F}},
              {disc, {-0.85F, 0.6F, 0.2F}},
              {disc, {0, -0.56F, 0.2F}},
              {disc, {0.85F, 0.6F, 0.2F}}}},
    {.name = "Lattice",
     .key = "Shift+L",
     .use = ToolUse::lattice,
     .group = ToolGroup::pose,
     .tip = "Moves the whole shape by the control points of a box about it.",
     .also = "ffd free-form cage box control points warp",
     .hint = kLatticeHint,
     .second_hint = kLatticeHint,
     .icon = {{line, {-0.7F, 0.7F, 0.7F, 0.7F}},
              {line, {-0.7F, 0, 0.75F, -0.1F}},
              {line, {-0.7F, -0.7F, 0.85F, -0.85F}},
              {line, {-0.7F, 0.7F, -0.7F, -0.7F}},
              {line, {0, 0.7F, 0.05F, -0.75F}},
              {line, {0.7F, 0.7F, 0.85F, -0.85F}},
              {disc, {0.85F, -0.85F, 0.2F}}}},
    {.name = "Pose",
     .key = "P",
     .use = ToolUse::pose,
     .group = ToolGroup::pose,
     .tip = "Moves some places while others hold, as if the shape had bones.",
     .also = "armature rig bones skeleton pins ik",
     .hint = "Click to set pins that hold, then drag one; Ctrl and a drag draws round a part that holds.",
     .second_hint =
         "Drag a pin: the others hold. Alt+click removes, Shift+click selects, a double click frees or holds it.",
     .icon = {{line, {-0.7F, 0.85F, 0.05F, 0.1F}},
              {circle, {0.35F, -0.25F, 0.5F}},
              {disc, {0.35F, -0.25F, 0.22F}},
              {disc, {-0.7F, 0.85F, 0.12F}}}},
    {.name = "Mask",
     .key = "M",
     .use = ToolUse::mask,
     .group = ToolGroup::mask,
     .tip = "Protects a part of the shape from all other tools.",
     .also = "protect freeze lock",
     .has_inner = true,
     .sliders = {"mask_width"},
     .hint = "Paint what stays as it is; Ctrl erases.",
     .second_hint = "Draw round what stays as it is; with Ctrl what is free.",
     .icon = {{wave, {-0.8F, -0.4F, -0.2F, -0.75F, 0.2F, -0.75F, 0.8F, -0.4F}},
              {wave, {-0.8F, -0.4F, -0.8F, 0.3F, -0.4F, 0.8F, 0, 0.3F}},
              {wave, {0, 0.3F, 0.4F, 0.8F, 0.8F, 0.3F, 0.8F, -0.4F}},
              {disc, {-0.35F, -0.1F, 0.17F}},
              {disc, {0.35F, -0.1F, 0.17F}}}}};

std::string turning_hint(const StudioTool& tool, TurnDrag turning) {
  if (tool.turning.is_percent) {
    return std::string("Drag right or up beside the gizmo to stretch, left or down to shorten. ") + tool.second_hint;
  }
  switch (turning) {
    case TurnDrag::round:
      return std::string("Drag beside the gizmo, round its middle. ") + tool.second_hint;
    case TurnDrag::sideways:
      return std::string("Drag right or left beside the gizmo. ") + tool.second_hint;
    case TurnDrag::upright:
      return std::string("Drag up or down beside the gizmo. ") + tool.second_hint;
  }
  return {};
}

// Empty: as the tool says.
std::string pose_hint(PoseMode mode, const PlacedTools& placed) {
  if (mode == PoseMode::exact && placed.pins.empty()) {
    return "Click to set pins on the shape, or drag at once; Ctrl and a drag sets pins within a line.";
  }
  if (mode == PoseMode::exact) return {};
  if (mode == PoseMode::lasso)
    return "Draw round a part, then drag it or its gizmo; Ctrl frees what is within the line.";
  if (mode == PoseMode::brush) return "Paint a part; Ctrl frees. Escape, then paint: the next one. The gizmo moves it.";
  if (placed.parts.selected) return "Drag the part about its joint, or its gizmo: arrows move it, rings turn it.";
  return {};
}

double distance_to(const Symmetry::Plane& plane, const Vec3d& p) { return dot(p - plane.point, plane.normal); }

// Exact in the coordinate planes.
Vec3d in_plane(const Symmetry::Plane& plane, Vec3d p) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(plane.normal[axis]) == 1) {
      p[axis] = plane.point[axis];
      return p;
    }
  }
  return p - plane.normal * distance_to(plane, p);
}

Vec3d on_axis(const Symmetry& symmetry, const Vec3d& p) {
  const Vec3d axis = normalized(symmetry.axis);
  return symmetry.center + axis * dot(p - symmetry.center, axis);
}

}  // namespace

std::span<const StudioTool> studio_tools() { return kTools; }

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string word_of(const StudioTool& tool) {
  std::string word = lower(tool.name);
  std::replace(word.begin(), word.end(), ' ', '_');
  return word;
}

const StudioTool* studio_tool(std::string_view word) {
  const auto found =
      std::find_if(kTools.begin(), kTools.end(), [&](const auto& tool) { return word_of(tool) == word; });
  return found == kTools.end() ? nullptr : &*found;
}

void choose_tool(const StudioTool& tool, ToolSettings& settings) {
  const auto place = [](const StudioTool& of) { return static_cast<std::size_t>(&of - kTools.data()); };
  settings.kept.resize(kTools.size());
  settings.kept[place(*settings.tool)] = settings;
  const OwnSettings first{.radius = tool.size * settings.first_radius, .drag = tool.drag};
  static_cast<OwnSettings&>(settings) = settings.kept[place(tool)].value_or(first);
  settings.tool = &tool;
}

bool blends(const ToolSettings& settings) {
  const ToolUse use = settings.tool->use;
  return use != ToolUse::mask && use != ToolUse::pose && use != ToolUse::inflate && use != ToolUse::smooth &&
         use != ToolUse::print && use != ToolUse::bend_along && use != ToolUse::lattice &&
         (use != ToolUse::stamp || settings.stamp_contact == StampContact::stick) && settings.tool->brush == nullptr;
}

bool has_two_signs(ToolUse use) { return use == ToolUse::paint || use == ToolUse::inflate || use == ToolUse::print; }

const StudioTool& studio_tool(ToolUse use) {
  return *std::find_if(kTools.begin(), kTools.end(), [&](const StudioTool& tool) { return tool.use == use; });
}

const char* name_of(ToolGroup group) {
  return std::array{"Move", "Shape", "Pose", "Mask"}[static_cast<std::size_t>(group)];
}

std::string hint_of(const ToolSettings& settings, const PlacedTools& placed, TurnDrag turning) {
  const StudioTool& tool = *settings.tool;
  if (tool.use == ToolUse::pose) {
    std::string hint = pose_hint(settings.pose, placed);
    if (!hint.empty()) return hint;
  }
  const bool is_placed = (has_two_signs(tool.use) && settings.paint_in) ||
                         (tool.use == ToolUse::points && !placed.points.empty()) ||
                         (tool.use == ToolUse::curve && !placed.curves.empty()) ||
                         ((tool.use == ToolUse::stamp || tool.use == ToolUse::turn) && placed.placement) ||
                         (tool.use == ToolUse::pose && !placed.pins.empty()) ||
                         (tool.use == ToolUse::mask && settings.mask_mode != MaskMode::paint);
  if (is_placed && tool.use == ToolUse::turn) return turning_hint(tool, turning);
  return is_placed ? tool.second_hint : tool.hint;
}

std::vector<Symmetry::Plane> mirror_planes(const ToolSettings& settings) {
  std::vector<Symmetry::Plane> planes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!settings.mirror[axis]) continue;
    Vec3d normal{0, 0, 0};
    normal[axis] = 1;
    planes.push_back({settings.symmetry.center, normal});
  }
  if (settings.symmetry.plane) planes.push_back(*settings.symmetry.plane);
  return planes;
}

std::optional<Mirror> mirror_of(const ToolSettings& settings) {
  if (settings.symmetry.turns > 1) return std::nullopt;
  Mirror mirror;
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    // Of an axis plane only where it is on its axis counts, so that planes through the origin are written as their
    // names.
    Vec3d point = plane.point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(plane.normal[axis]) == 1) point = plane.normal * dot(plane.normal, plane.point);
    }
    mirror.push_back({plane.normal, point + Vec3d{0, 0, 0}});
  }
  try {
    validate(mirror);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  return mirror;
}

std::vector<SymmetryImage> images_of(const ToolSettings& settings) {
  const Symmetry& symmetry = settings.symmetry;
  const std::vector<Symmetry::Plane> planes = mirror_planes(settings);
  const bool is_exact = symmetry.center == Vec3d{0, 0, 0} && !symmetry.plane;
  std::vector<SymmetryImage> images;
  for (int turn = 0; turn < std::clamp(symmetry.turns, 1, kMaxTurns); ++turn) {
    const double angle = 2 * std::numbers::pi * turn / symmetry.turns;
    const RigidMotion turned = turn == 0 ? RigidMotion{} : rotation_about(symmetry.center, symmetry.axis, angle);
    for (unsigned mask = 0; mask < 1U << planes.size(); ++mask) {
      if (turn == 0 && mask == 0) continue;
      SymmetryImage image{turned};
      for (std::size_t i = 0; i < planes.size(); ++i) {
        if ((mask >> i & 1U) == 0) continue;
        image.motion = image.motion * reflection_in(planes[i].point, planes[i].normal);
        const Vec3d& n = planes[i].normal;
        if (turn == 0 && is_exact) image.planes |= n.x == 1 ? 1U : n.y == 1 ? 2U : 4U;
      }
      images.push_back(image);
    }
  }
  return images;
}

double half_radius(const ToolSettings& settings, double inner_ratio) {
  if (settings.tool->brush != nullptr) return kHalfOfBump * settings.radius;
  return settings.radius * (inner_ratio + (1 - inner_ratio) * falloff_facts(settings.falloff).half);
}

Vec3d snapped_to_symmetry(Vec3d p, const Vec3d& touched, const Vec3d& motion, const ToolSettings& settings) {
  const double across = 0.5 * settings.inner_ratio * settings.radius;
  const double along = half_radius(settings, settings.inner_ratio);
  const auto near = [&](double part) { return part < 0.5 * norm(motion) ? along : across; };
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    if (std::abs(distance_to(plane, touched)) < near(std::abs(dot(plane.normal, motion)))) p = in_plane(plane, p);
  }
  if (settings.symmetry.turns < 2) return p;
  const double apart = norm(touched - on_axis(settings.symmetry, touched));
  return apart < near(norm(cross(normalized(settings.symmetry.axis), motion))) ? on_axis(settings.symmetry, p) : p;
}

Vec3d kept_in_symmetry(Vec3d p, const Vec3d& first, const ToolSettings& settings) {
  const double near = kOnPlane * settings.radius;
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    if (std::abs(distance_to(plane, first)) <= near) p = in_plane(plane, p);
  }
  const bool is_on_axis = settings.symmetry.turns > 1 && norm(first - on_axis(settings.symmetry, first)) <= near;
  return is_on_axis ? on_axis(settings.symmetry, p) : p;
}

}  // namespace knead::studio
