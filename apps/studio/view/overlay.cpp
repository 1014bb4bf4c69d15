// Lines and colours over the shape: regions of tools, gizmo, pins, parts, masks.
#include "view/overlay.h"

#include <algorithm>
#include <utility>

#include "gestures/gesture.h"
#include "gestures/gesture_kinds.h"
#include "gestures/tools.h"
#include "knead/editor/render.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::studio {

namespace {

constexpr double kNominalAngle = 40;  // degrees of turn, or percent of stretch, that a placed tool is drawn with
constexpr render::Color kLayerPath{0.16f, 0.45f, 0.80f, 1};
constexpr render::Color kMirrorPlane{0.45f, 0.50f, 0.60f, 0.10f};
constexpr render::Color kMirrorLine{0.25f, 0.45f, 0.85f, 1};
constexpr render::Color kRadialAxis{0.30f, 0.35f, 0.45f, 1};
constexpr float kFaded = 0.4F;  // of the opacity of a region, while it is dragged
constexpr double kInArrowRadius = 0.03;
constexpr double kDrawnPoints = 2.5;              // half the width of a line that is drawn on the surface
constexpr double kSameImage = 1e-9;               // of the radius: images that differ by less are one
constexpr std::size_t kStretchedAtOnce = 60'000;  // vertices of a shape that is coloured at every step of a drag
// Of the parts of a pose: the selected one, and in turn those that hold; free ones are fainter.
constexpr float kSelectedShade = 1;
constexpr std::array kPartShades{0.30f, 0.50f, 0.40f, 0.60f};
constexpr float kFreePart = 0.6f;

Box box_of(const DocumentState& shown) {
  Box box;
  const Vec3d half{0.5 * shown.diagonal, 0.5 * shown.diagonal, 0.5 * shown.diagonal};
  if (shown.state.positions.size() == 0) return box;
  box = shape_box(*shown.state.mesh);
  box.min -= half * 0.2;
  box.max += half * 0.2;
  return box;
}

std::optional<Stroke> hovering_implicit(const Studio& studio, const GestureContext& around) {
  const ToolSettings& settings = studio.tools().settings();
  const auto hit = hit_at(studio.pointer(), around);
  if (!hit && settings.start != PullStart::plane) return std::nullopt;
  ImplicitGesture gesture = begin_implicit(studio.pointer(), around);
  Vec3d direction = hit ? hit->normal : render::camera_frame(around.screen.camera).up;
  if (settings.drag == DragMode::axis) direction = settings.axis;
  gesture.stroke.path.push_back(gesture.stroke.path.front() + normalized(direction) * (0.5 * settings.radius));
  return gesture.stroke;
}

std::optional<Stroke> hovering_paint(const Studio& studio, const GestureContext& around) {
  const auto hit = hit_at(studio.pointer(), around);
  if (!hit) return std::nullopt;
  PaintStroke stroke = brush_of(studio.tools().settings(), studio.pointer());
  stroke.samples = {{hit->point, hit->normal}};
  return stroke;
}

// What is placed, about to be moved a little up in the picture.
std::optional<Stroke> placed_points(const Studio& studio, const GestureContext& around) {
  const PlacedTools& placed = studio.tools().placed();
  if (placed.points.empty() && placed.curves.empty()) return std::nullopt;
  PointsStroke stroke;
  stroke.points = placed.points;
  stroke.curves = placed.curves;
  stroke.outer = studio.tools().settings().radius;
  stroke.exponent = studio.tools().settings().exponent;
  stroke.falloff = studio.tools().settings().falloff;
  stroke.displacements = {render::camera_frame(around.screen.camera).up * (0.3 * stroke.outer)};
  return stroke;
}

// Returns the strokes whose tools are drawn: during a drag the latest piece of each side, else the tool at the pointer.
std::vector<Stroke> strokes_to_draw(const Studio& studio) {
  if (studio.document().shown().looked_at) {
    const auto& history = studio.document().shown().history;
    const std::size_t entry = *studio.document().shown().looked_at;
    if (entry >= history.size()) return {};
    std::vector<Stroke> strokes;
    for (const SessionStroke& stroke : history[entry]->strokes) {
      if (!reads_surface(stroke.stroke) && strokes.size() < 8) strokes.push_back(stroke.stroke);
    }
    return strokes;
  }
  const ToolUse use = studio.tools().settings().tool->use;
  const bool poses = use == ToolUse::pose && !has_exact_pins(studio.tools().settings());
  // They are seen by their pins, the line, or the control points.
  if (poses || use == ToolUse::bend_along || use == ToolUse::lattice) return {};
  std::vector<Stroke> strokes = studio.preview();
  if (strokes.empty()) return hovering(studio);
  const std::size_t sides = images_of(studio.tools().settings()).size() + 1;
  if (strokes.size() > sides) strokes.erase(strokes.begin(), strokes.end() - static_cast<std::ptrdiff_t>(sides));
  return strokes;
}

// A stroke in progress is drawn where its tool is now: of a path only the last piece.
Stroke last_piece(const Stroke& stroke) {
  const std::vector<Stroke> pieces = pieces_of(stroke);
  Stroke result = pieces.empty() ? stroke : pieces.back();
  auto* const samples = find_value<std::vector<PaintSample>>(result, "samples");
  if (samples != nullptr && samples->size() > 1) samples->erase(samples->begin(), samples->end() - 1);
  return result;
}

// What is drawn on, and how.
struct Sheet {
  const Box& around;
  render::Scene& scene;
  render::ToolDrawing how;
};

// Which mirror image of a stamp's tool a file holds.
unsigned planes_of_file(const std::string& file, const std::string& original) {
  for (unsigned planes = 1; planes < 8; ++planes) {
    if (image_file(original, planes) == file) return planes;
  }
  return 0;
}

void draw_stroke(const Studio& studio, const Stroke& stroke, const Sheet& sheet) {
  if (!is_flow(stroke)) return;
  render::DrawnTool tool;
  if (const auto* stamp = std::get_if<StampStroke>(&stroke)) {
    const std::optional<StampShape>& shape = studio.tools().placed().stamp;
    if (!shape) return;
    Mesh mesh = mirrored_mesh(*shape->mesh, planes_of_file(stamp->mesh, shape->file));
    for (Vec3d& p : mesh.positions) p = stamp->pose * p;
    tool.stamp = render::StampTool{std::move(mesh), {stamp->path.back(), stamp->path.back()}};
  } else if (reads_surface(stroke)) {
    return;
  } else {
    tool.stroke = flow_of(stroke);
    const bool is_under_hand = studio.gesture().has_value();
    if (!studio.document().shown().looked_at)
      tool.moment = is_under_hand ? static_cast<double>(tool.stroke.segments.size()) : 0.0;
  }
  render::draw_tool(tool, sheet.around, sheet.scene, sheet.how);
}

void add_placed_points(const PlacedTools& placed, double radius, std::vector<render::Line>& lines) {
  const auto add = [&](const std::vector<Vec3d>& points) {
    lines.push_back({.points = points, .radius = radius, .color = kPlaced});
  };
  for (const Vec3d& p : placed.points) add({p, p + Vec3d{0, 1e-3 * radius, 0}});
  for (const auto& curve : placed.curves) add(curve);
}

// The paths of the selected entry, with its handles; the one under the pointer lighter.
void add_layer_handles(const Studio& studio, double radius, std::vector<render::Line>& lines) {
  if (!studio.history().editor().entry || studio.document().shown().looked_at) return;
  const std::vector<LayerPath>& paths = studio.history().editor().paths;
  const bool is_free = !studio.gesture();
  const auto lit = is_free ? studio.history().pointed_handle(studio.view().screen(), studio.pointer()) : std::nullopt;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].points.size() > 1) {
      lines.push_back({.points = paths[i].points, .radius = 0.35 * radius, .color = kLayerPath});
    }
    for (std::size_t k = 0; k < paths[i].handles.size(); ++k) {
      const Vec3d place = paths[i].points[paths[i].handles[k]];
      const bool is_lit = lit == LayerHandle{i, k};
      lines.push_back({.points = {place, place + Vec3d{0, 1e-3 * radius, 0}},
                       .radius = (is_lit ? 1.6 : 1.2) * radius,
                       .color = is_lit ? kLitHandle : kLayerPath});
    }
  }
}

void add_placed_stamp(const Studio& studio, const Sheet& sheet) {
  const PlacedTools& placed = studio.tools().placed();
  StampStroke stroke = stamp_at(studio.tools().settings(), *placed.stamp, *placed.placement);
  stroke.path = {placed.placement->center, placed.placement->center};
  const ToolSettings& settings = studio.tools().settings();
  for (const Stroke& image : with_images(stroke, images_of(settings), kSameImage * settings.radius, image_file)) {
    draw_stroke(studio, image, sheet);
  }
}

// A square in the plane, as wide as the shape.
Mesh square_in(const Symmetry::Plane& plane, const Box& box) {
  const Vec3d u = any_orthogonal(plane.normal);
  const Vec3d v = cross(plane.normal, u);
  const Vec3d center = box.center() - plane.normal * dot(box.center() - plane.point, plane.normal);
  const double half = 0.5 * box.diagonal();
  Mesh mesh;
  for (const auto& [a, b] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
    mesh.positions.push_back(center + u * (a * half) + v * (b * half));
  }
  mesh.add_face(std::array<std::uint32_t, 4>{0, 1, 2, 3});
  return mesh;
}

// The part of a mirror's plane that the shape is about.
Mesh sheet_in(const Symmetry::Plane& plane, const Box& box) {
  std::size_t axis = 0;
  while (axis < 3 && plane.normal[axis] != 1) ++axis;
  if (axis == 3) return square_in(plane, box);
  Mesh mesh;
  for (std::size_t i = 0; i < 4; ++i) {
    Vec3d p = plane.point;
    p[(axis + 1) % 3] = i == 1 || i == 2 ? box.max[(axis + 1) % 3] : box.min[(axis + 1) % 3];
    p[(axis + 2) % 3] = i >= 2 ? box.max[(axis + 2) % 3] : box.min[(axis + 2) % 3];
    mesh.positions.push_back(p);
  }
  mesh.add_face(std::array<std::uint32_t, 4>{0, 1, 2, 3});
  return mesh;
}

// A mirror's plane is a line on the surface; points have none, so they get a sheet.
void add_symmetry(const Studio& studio, const Box& box, render::LiveScene& scene) {
  const ToolSettings& settings = studio.tools().settings();
  const bool has_faces = studio.document().shown().state.mesh->face_count() > 0;
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    if (has_faces && scene.sections.size() < render::kMaxSections) {
      scene.sections.push_back({plane.normal, dot(plane.normal, plane.point), kMirrorLine});
    } else {
      scene.surfaces.push_back({sheet_in(plane, box), kMirrorPlane});
    }
  }
  if (settings.symmetry.turns < 2) return;
  const Vec3d half = normalized(settings.symmetry.axis) * (0.6 * box.diagonal());
  scene.lines.push_back({.points = {settings.symmetry.center - half, settings.symmetry.center + half},
                         .radius = 0.0015 * box.diagonal(),
                         .color = kRadialAxis});
}

// The tools at the pointer and in a drag are seen by the cursor; their regions only on demand, and fainter in a drag.
bool shows_region(const Studio& studio) {
  const ToolUse use = studio.tools().settings().tool->use;
  const bool has_cursor = use == ToolUse::pull || has_two_signs(use) || use == ToolUse::smooth || use == ToolUse::pose;
  return !has_cursor || studio.view().settings().region || studio.document().shown().looked_at.has_value();
}

void add_in_arrow(const Studio& studio, std::vector<render::Arrow>& arrows) {
  const std::optional<InArrow> arrow = in_arrow(studio);
  if (!arrow) return;
  const double radius = kInArrowRadius * norm(arrow->to - arrow->from);
  arrows.push_back({.from = arrow->from, .to = arrow->to, .radius = radius, .color = studio.preferences().outer_ring});
}

void fade(render::Scene& parts) {
  for (render::TranslucentSurface& surface : parts.surfaces) surface.color.alpha *= kFaded;
}

// The line that is being drawn: on the surface, or as a curve in front of the shape round a part.
void add_drawn_line(const Studio& studio, std::vector<render::Line>& lines) {
  if (studio.gesture()) {
    const auto* const inflate = std::get_if<InflateGesture>(&studio.gesture()->kind);
    const auto* const draw = std::get_if<DrawGesture>(&studio.gesture()->kind);
    std::vector<Vec3d> points;
    if (inflate != nullptr) points = inflate->stroke.points;
    if (draw != nullptr) points = draw->points;
    if (points.size() > 1) {
      const double radius = kDrawnPoints * point_size(studio.view().screen(), points.back());
      lines.push_back({.points = std::move(points), .radius = radius, .color = kPlaced});
    }
  }
  std::vector<Pixel> line = studio.masks().line();
  const auto* const lasso = studio.gesture() ? std::get_if<LassoGesture>(&studio.gesture()->kind) : nullptr;
  if (lasso != nullptr) line = lasso->line;
  if (line.size() < 2) return;
  const Screen screen = studio.view().screen();
  const Vec3d forward = render::camera_frame(screen.camera).forward;
  const Vec3d before = screen.camera.target - forward * studio.document().shown().diagonal;
  render::Line drawn{.points = {}, .radius = 1.2 * point_size(screen, before), .color = kPlaced};
  for (std::size_t i = 0; i <= line.size(); ++i) {
    const Pixel& at = line[i % line.size()];
    if (const auto p = on_plane(ray_through(screen, at.x, at.y), before, forward)) drawn.points.push_back(*p);
  }
  if (drawn.points.size() > 1) lines.push_back(std::move(drawn));
}

bool poses_parts(const Studio& studio) {
  return studio.tools().settings().tool->use == ToolUse::pose && !has_exact_pins(studio.tools().settings()) &&
         !studio.document().shown().looked_at &&
         studio.tools().placed().parts.at.mesh == studio.document().shown().state.mesh &&
         !studio.tools().placed().parts.of_vertex.empty();
}

bool shows_parts(const Studio& studio) {
  return poses_parts(studio) && studio.view().settings().stretch == StretchView::off;
}

// Nothing, seen and shaded as the person chose.
render::LiveScene empty_scene(const Studio& studio) {
  const ViewSettings& view = studio.view().settings();
  render::LiveScene scene;
  scene.camera = studio.view().screen().camera;
  scene.material = view.look.material;
  scene.matcap = view.look.matcap;
  scene.relief = view.look.relief;
  if (const auto background = render::background_named(view.look.background)) {
    scene.background_top = background->top;
    scene.background_bottom = background->bottom;
  }
  scene.wireframe = view.wireframe;
  scene.show_stretch = view.stretch != StretchView::off;
  if (studio.fit().is_open()) {
    scene.show_stretch = true;
    return scene;
  }
  scene.show_influence = view.influence || shows_parts(studio);
  return scene;
}

void add_part_gizmo(const Studio& studio, render::LiveScene& scene) {
  const auto* const drag = studio.gesture() ? std::get_if<PartGesture>(&studio.gesture()->kind) : nullptr;
  const std::optional<Placement>& placement = studio.tools().placed().parts.placement;
  if (!poses_parts(studio) || !placement || (studio.gesture() && drag == nullptr)) return;
  const Pointer& at = studio.pointer();
  std::optional<GizmoPart> lit = gizmo_part_at(studio.view().screen(), *placement, at.x, at.y);
  Placement shown = *placement;
  if (drag != nullptr) {
    lit = drag->handle;
    shown = moved(*placement, drag->motion);
  }
  draw_gizmo(studio.view().screen(), shown, lit, scene.arrows, scene.lines);
}

}  // namespace

GestureContext next_context(const Studio& studio) {
  const DocumentState& shown = studio.document().shown();
  const bool fits = shown.picker && shown.picker->fits(shown.state);
  return {studio.view().screen(), shown.state, fits ? shown.picker.get() : nullptr, studio.tools().settings()};
}

std::vector<Stroke> hovering(const Studio& studio) {
  const DocumentState& shown = studio.document().shown();
  if (shown.opened == 0 || shown.looked_at) return {};
  const GestureContext around = next_context(studio);
  const ToolSettings& settings = studio.tools().settings();
  std::optional<Stroke> stroke;
  switch (settings.tool->use) {
    case ToolUse::pull:
      if (studio.pointer_is_over_view()) stroke = hovering_implicit(studio, around);
      break;
    case ToolUse::paint:
      if (studio.pointer_is_over_view()) stroke = hovering_paint(studio, around);
      break;
    case ToolUse::points:
    case ToolUse::curve:
      stroke = placed_points(studio, around);
      break;
    case ToolUse::pose:
      if (has_exact_pins(settings)) stroke = hovering_pins(studio);
      return stroke ? std::vector<Stroke>{*stroke} : std::vector<Stroke>{};
    case ToolUse::turn:
      if (const auto& at = studio.tools().placed().placement) stroke = turning_stroke(settings, *at, kNominalAngle);
      break;
    case ToolUse::inflate:
    case ToolUse::print:
    case ToolUse::bend_along:
    case ToolUse::lattice:
    case ToolUse::smooth:
    case ToolUse::stamp:
    case ToolUse::mask:
      break;
  }
  if (!stroke) return {};
  return with_images(*stroke, images_of(settings), kSameImage * settings.radius, image_file);
}

std::optional<std::vector<float>> Overlay::mask(const Studio& studio) {
  const ShapeState& state = studio.document().shown().state;
  if (studio.document().shown().opened == 0) return std::nullopt;
  const bool is_new_shape = mask_mesh_ != state.mesh;
  const bool is_same = !is_new_shape && mask_version_ == studio.document().shown().version && !was_masking_;
  if (is_same && !studio.masks().is_drawing()) return std::nullopt;
  // A drag moves what the mask leaves free: the shades there can wait.
  if (studio.gesture() && !is_new_shape && state.mask.shares(mask_)) return std::nullopt;
  mask_version_ = studio.document().shown().version;
  was_masking_ = studio.masks().is_drawing();
  mask_ = state.mask;
  mask_mesh_ = state.mesh;
  const bool has_shades = std::exchange(has_mask_, false) && !is_new_shape;
  if (!was_masking_ && state.mask.is_empty() && !has_shades) return std::nullopt;
  std::vector<float> shades(state.positions.size());
  const MaskValues& painted = studio.masks().values();
  for (std::size_t v = 0; v < shades.size(); ++v) {
    if (was_masking_ && v < painted.size()) shades[v] = static_cast<float>(painted[v]) / 255.0F;
    if (!was_masking_ && !state.mask.is_empty()) {
      shades[v] = static_cast<float>(1 - state.mask.at(state.positions[v]).value);
    }
  }
  has_mask_ = std::any_of(shades.begin(), shades.end(), [](float shade) { return shade > 0; });
  return shades;
}

const std::vector<PlaneLine>& Overlay::outline(const Studio& studio) {
  const ToolSettings& settings = studio.tools().settings();
  const std::optional<PrintPicture>& picture = studio.tools().placed().picture;
  PrintStroke stroke;
  stroke.height = stroke.depth = 1;  // a text's outline does not depend on these
  if (settings.tool->use == ToolUse::print) {
    if (picture) return picture->outline;
    stroke.text = settings.text;
    stroke.font = settings.font;
  }
  if (stroke == outlined_) return outline_;
  outline_.clear();
  try {
    if (!stroke.text.empty()) outline_ = print_outline(stroke, {});
  } catch (const InvalidInput&) {
    outline_.clear();  // the stroke says why it cannot be printed
  }
  outlined_ = std::move(stroke);
  return outline_;
}

render::LiveScene Overlay::scene(const Studio& studio) {
  const ViewSettings& view = studio.view().settings();
  const DocumentState& shown = studio.document().shown();
  render::LiveScene scene = empty_scene(studio);
  if (shown.opened == 0) return scene;
  if (view.references) scene.images = placed_images(studio.view().references(), studio.view().navigation().view);
  const Box box = box_of(shown);
  if (view.cut) {
    const Vec3d normal = normalized(view.cut_normal);
    scene.clip = render::Clip{normal, dot(normal, box.center()) + view.cut_offset};
  }
  if (studio.view().turntable()) return scene;
  if (studio.fit().is_open()) {
    add_fit_points(studio, false, studio.view().screen(), scene.lines);
    return scene;
  }
  add_symmetry(studio, box, scene);
  add_layer_handles(studio, 0.006 * shown.diagonal, scene.lines);
  add_drawn_line(studio, scene.lines);
  add_bend_line(studio, scene.lines);
  add_lattice(studio, scene.lines);
  if (!view.tool) return scene;
  const render::ToolDrawing how{render::kLiveDetail, &surfaces_};
  std::vector<Stroke> strokes = shows_region(studio) ? strokes_to_draw(studio) : std::vector<Stroke>{};
  const bool stamps = studio.gesture() && std::holds_alternative<StampGesture>(studio.gesture()->kind);
  if (stamps && shown.contacts) strokes.push_back(*shown.contacts);
  for (Stroke& stroke : strokes) stroke = last_piece(stroke);
  if (strokes != drawn_) {
    parts_ = {};
    try {
      for (const Stroke& stroke : strokes) draw_stroke(studio, stroke, {box, parts_, how});
    } catch (const InvalidInput&) {
      parts_ = {};  // what cannot be drawn cannot be done either, and the document says so
    }
    if (studio.gesture() && !stamps) fade(parts_);
    drawn_ = std::move(strokes);
  }
  const auto add = [](const auto& from, auto& to) { to.insert(to.end(), from.begin(), from.end()); };
  add(parts_.surfaces, scene.surfaces);
  add(parts_.arrows, scene.arrows);
  add(parts_.lines, scene.lines);
  add_cursor(studio, outline(studio), scene.lines);
  add_in_arrow(studio, scene.arrows);
  const PlacedTools& placed = studio.tools().placed();
  add_placed_points(placed, 0.004 * shown.diagonal, scene.lines);
  add_pins(studio, scene.lines);
  add_part_gizmo(studio, scene);
  const ToolUse use = studio.tools().settings().tool->use;
  if (placed.placement && (use == ToolUse::turn || use == ToolUse::stamp)) {
    const Pointer& at = studio.pointer();
    const auto lit = gizmo_part_at(studio.view().screen(), *placed.placement, at.x, at.y);
    if (use == ToolUse::stamp && placed.stamp && !studio.gesture()) {
      render::Scene stamp;
      add_placed_stamp(studio, {box, stamp, how});
      add(stamp.surfaces, scene.surfaces);
    }
    draw_gizmo(studio.view().screen(), *placed.placement, lit, scene.arrows, scene.lines);
  }
  return scene;
}

render::LiveScene Overlay::target_scene(const Studio& studio) {
  render::LiveScene scene = empty_scene(studio);
  scene.camera = studio.fit().screen().camera;
  scene.show_stretch = false;
  add_fit_points(studio, true, studio.fit().screen(), scene.lines);
  return scene;
}

std::optional<std::vector<float>> Overlay::distances(const Studio& studio) {
  const StudioFit& fit = studio.fit();
  const std::size_t vertices = studio.document().shown().state.positions.size();
  const bool fits = fit.distances().empty() || fit.distances().size() == vertices;
  if (!fits || fit.measured() == measured_) return std::nullopt;
  measured_ = fit.measured();
  influencing_.clear();
  part_mesh_.reset();
  has_influence_ = true;
  return fit.distances();
}

std::optional<std::vector<float>> Overlay::stretch(const Studio& studio) {
  const DocumentState& shown = studio.document().shown();
  const StretchView since = studio.view().settings().stretch;
  const bool is_new = influenced_version_ != shown.version || stretched_ != since || !has_influence_;
  const bool waits = studio.gesture() && shown.state.positions.size() > kStretchedAtOnce && stretched_ == since;
  if (!is_new || waits) return std::nullopt;
  influenced_version_ = shown.version;
  stretched_ = since;
  has_influence_ = true;
  std::optional<std::vector<float>> values = stretches_shown(shown, since);
  knows_stretch_ = values.has_value();
  if (!values) return std::vector<float>{};
  for (float& value : *values) value = shade_of_stretch(value);
  return values;
}

std::optional<std::vector<float>> Overlay::parts(const Studio& studio) {
  const PartMarks& parts = studio.tools().placed().parts;
  std::vector<float> of_part{0};
  for (std::size_t part = 0; part < parts.holds.size(); ++part) {
    const float shade = kPartShades[part % kPartShades.size()] * (parts.holds[part] ? 1 : kFreePart);
    of_part.push_back(parts.selected == part ? kSelectedShade : shade);
  }
  std::vector<float> shades;
  shades.reserve(parts.of_vertex.size());
  for (const std::uint8_t number : parts.of_vertex) shades.push_back(of_part[number]);
  const bool is_same = has_influence_ && part_mesh_ == studio.document().shown().state.mesh && shades == part_shades_;
  if (is_same) return std::nullopt;
  part_mesh_ = studio.document().shown().state.mesh;
  part_shades_ = shades;
  has_influence_ = true;
  return shades;
}

std::optional<std::vector<float>> Overlay::influence(const Studio& studio) {
  if (studio.fit().is_open()) return distances(studio);
  if (std::exchange(measured_, 0) != 0) {
    influencing_.clear();
    influenced_version_ = 0;
    stretched_ = StretchView::off;
  }
  if (shows_parts(studio)) {
    influencing_.clear();
    stretched_ = StretchView::off;
    return parts(studio);
  }
  part_mesh_.reset();
  if (studio.view().settings().stretch != StretchView::off) return stretch(studio);
  if (std::exchange(stretched_, StretchView::off) != StretchView::off) {
    influencing_.clear();
    influenced_version_ = 0;
  }
  if (!studio.view().settings().influence || studio.gesture() || studio.document().shown().opened == 0) {
    if (!std::exchange(has_influence_, false)) return std::nullopt;
    influencing_.clear();
    return std::vector<float>{};
  }
  std::vector<Stroke> strokes = hovering(studio);
  if (has_influence_ && strokes == influencing_ && influenced_version_ == studio.document().shown().version)
    return std::nullopt;
  influencing_ = std::move(strokes);
  influenced_version_ = studio.document().shown().version;
  has_influence_ = true;
  const Snapshot& positions = studio.document().shown().state.positions;
  const bool are_pins = !influencing_.empty() && std::holds_alternative<PinsStroke>(influencing_.front());
  if (are_pins) return influence_of(std::get<PinsStroke>(influencing_.front()), positions);
  std::vector<Flow> flows;
  for (const Stroke& stroke : influencing_) {
    if (!reads_surface(stroke)) flows.push_back(flow_of(stroke));
  }
  return influence_of(flows, positions);
}

std::string Overlay::placement_problem(const Studio& studio) {
  const std::optional<Placement>& placement = studio.tools().placed().placement;
  if (!studio.tools().settings().tool->turning.takes_limit_cylinder || !studio.tools().settings().uses_limit_cylinder ||
      !placement || !placement->limit_cylinder)
    return {};
  return placement->limit_cylinder->problem;
}

}  // namespace knead::studio
