// Choosing tools, and placing what they need.
#include "studio_tools.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <span>
#include <string>
#include <utility>

#include "document/layers.h"
#include "gestures/gesture_kinds.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "setting.h"

namespace knead::studio {

namespace {

constexpr double kFirstRadius = 0.1;  // of the diagonal
constexpr double kSnapParts = 100;    // of the diagonal
constexpr double kKeyFactor = 1.15;   // of [ and ]
constexpr double kKeyRatio = 0.05;

}  // namespace

double snap_length(double diagonal) {
  const double step = diagonal / kSnapParts;
  const double power = std::pow(10, std::floor(std::log10(step)));
  double best = power;
  for (const double factor : {2.0, 5.0, 10.0}) {
    if (std::abs(std::log(factor * power / step)) < std::abs(std::log(best / step))) best = factor * power;
  }
  return best;
}

bool StudioTools::perform(Action action) {
  const std::vector<Setting> rows = settings_of(settings_);
  if (step(find_setting(rows, action == Action::drag_mode ? "drag" : name_of(action)))) return true;
  switch (action) {
    case Action::larger:
      fix_radius();
      settings_.radius *= kKeyFactor;
      return true;
    case Action::smaller:
      fix_radius();
      settings_.radius /= kKeyFactor;
      return true;
    case Action::rounder:
      settings_.inner_ratio = std::max(settings_.inner_ratio - kKeyRatio, 0.01);
      return true;
    case Action::sharper:
      settings_.inner_ratio = std::min(settings_.inner_ratio + kKeyRatio, 0.95);
      return true;
    case Action::mirror_x:
    case Action::mirror_y:
    case Action::mirror_z: {
      bool& mirror = settings_.mirror[static_cast<std::size_t>(action) - static_cast<std::size_t>(Action::mirror_x)];
      mirror = !mirror;
      return true;
    }
    default:
      return false;
  }
}

void StudioTools::begin_document() {
  const std::optional<StampShape> stamp = placed_.stamp;
  const std::optional<PrintPicture> picture = placed_.picture;
  placed_ = {};
  line_version_ = lattice_version_ = 0;
  first_bend_ = first_lattice_ = 0;
  settings_.first_radius = kFirstRadius * document_.shown().diagonal;
  settings_.radius = settings_.tool->size * settings_.first_radius;
  settings_.kept.clear();
  settings_.remesh = document_.shown().shape_path.empty();
  if (stamp) set_stamp([stamp](Document& document) { return document.add_stamp(stamp->name, *stamp->mesh); });
  if (picture) set_picture(picture->source);
}

void StudioTools::follow(bool has_gesture) {
  const bool has_limit_cylinder = placed_.placement && placed_.placement->limit_cylinder;
  const bool is_new_mesh = document_.shown().state.mesh != limit_cylinder_mesh_;
  if (has_limit_cylinder && is_new_mesh && !has_gesture && !document_.worker().is_busy()) find_limit_cylinder(false);
}

void StudioTools::follow_line() {
  const DocumentState& shown = document_.shown();
  if (settings_.tool->use != ToolUse::bend_along || shown.opened == 0 || line_version_ == shown.version) return;
  line_version_ = shown.version;
  const std::vector<Vec3d> positions = shown.state.positions.copy();
  placed_.line = bent_line().value_or(longest_axis(bounding_box(positions), kPointsOfLine));
  placed_.line_stride = points_between_handles(placed_.line, positions);
}

// Returns the line after the last stroke that has bent it; nothing if none has since it was last laid straight.
std::optional<std::vector<Vec3d>> StudioTools::bent_line() {
  const DocumentState& shown = document_.shown();
  first_bend_ = std::min(first_bend_, shown.history.size());
  for (std::size_t entry = shown.history.size(); entry-- > first_bend_;) {
    for (const SessionStroke& stroke : shown.history[entry]->strokes) {
      const auto* const curve = std::get_if<CurveStroke>(&stroke.stroke);
      if (curve == nullptr || reads_surface(stroke.stroke) || !is_applied(stroke)) continue;
      std::vector<Vec3d> line = points_on_line(curve->from, kPointsOfLine);
      advect(flow_of(stroke), line, advect_options(MotionOptions(), shown.diagonal));
      return line;
    }
  }
  return std::nullopt;
}

// Returns the lattice that is the last entry of the history, unless another one was laid since.
const LatticeStroke* StudioTools::last_lattice() {
  const auto& history = document_.shown().history;
  first_lattice_ = std::min(first_lattice_, history.size());
  if (history.size() == first_lattice_ || history.back()->strokes.size() != 1) return nullptr;
  const SessionStroke& last = history.back()->strokes.front();
  const auto* const lattice = std::get_if<LatticeStroke>(&last.stroke);
  const bool is_whole = lattice != nullptr && lattice->file.empty() && is_applied(last) && last.strength == 1;
  return is_whole && last.mirror.empty() ? lattice : nullptr;
}

void StudioTools::follow_lattice() {
  const DocumentState& shown = document_.shown();
  if (settings_.tool->use != ToolUse::lattice || shown.opened == 0) return;
  if (document_.worker().has_named_work()) return;
  PlacedLattice& placed = placed_.lattice;
  const bool has_counts = placed.stroke.counts == settings_.lattice_counts;
  if (lattice_version_ == shown.version && has_counts && !placed.is_ahead) return;
  if (!placed.stroke.displacements.empty() && !has_counts) first_lattice_ = shown.history.size();
  lattice_version_ = shown.version;
  PlacedLattice next;
  next.entry = shown.history.size();
  if (const LatticeStroke* const last = last_lattice()) {
    next.stroke = *last;
    --next.entry;
    settings_.lattice_counts = last->counts;
    if (*last != placed.stroke) settings_.lattice_mode = last->mode;
  } else if (const Box box = bounding_box(shown.state.positions.copy()); box.diagonal() > 0) {
    next.stroke = lattice_about(box, settings_.lattice_counts);
  }
  next.selected = std::move(placed.selected);
  const std::size_t points = next.stroke.displacements.size();
  if (next.selected.size() != points) next.selected.assign(points, false);
  placed = std::move(next);
}

double StudioTools::radius() const {
  const std::vector<Pin>& pins = placed_.pins;
  const bool is_auto = has_exact_pins(settings_) && settings_.auto_radius && !pins.empty();
  if (!is_auto) return settings_.radius;
  return radius_of(pins_stroke(pins, 0, pins.front().place, settings_)).value_or(settings_.radius);
}

void StudioTools::fix_radius() {
  if (!has_exact_pins(settings_)) return;
  settings_.radius = radius();
  settings_.auto_radius = false;
}

void StudioTools::clear_placed() {
  PlacedTools kept;
  kept.stamp = std::move(placed_.stamp);
  kept.picture = std::move(placed_.picture);
  select_pins(false);
  select_part(std::nullopt, placed_.parts);
  kept.pins = std::move(placed_.pins);
  kept.parts = std::move(placed_.parts);
  placed_ = std::move(kept);
  line_version_ = lattice_version_ = 0;
  if (settings_.tool->use == ToolUse::lattice) first_lattice_ = document_.shown().history.size();
  if (settings_.tool->use == ToolUse::bend_along) first_bend_ = document_.shown().history.size();
  picking_ = PlanePick::none;
}

Box StudioTools::placed_box() const {
  std::vector<Vec3d> places;
  double around = settings_.radius;
  switch (settings_.tool->use) {
    case ToolUse::stamp:
    case ToolUse::turn:
      if (placed_.placement) places = {placed_.placement->center};
      break;
    case ToolUse::points:
    case ToolUse::curve:
      places = placed_.points;
      for (const auto& curve : placed_.curves) places.insert(places.end(), curve.begin(), curve.end());
      break;
    case ToolUse::bend_along:
      places = placed_.line;
      break;
    case ToolUse::lattice:
      places = control_points(placed_.lattice.stroke);
      break;
    case ToolUse::pose:
      around = kFirstRadius * document_.shown().diagonal;
      for (const Pin& pin : placed_.pins) places.push_back(pin.place);
      if (!placed_.parts.selected || has_exact_pins(settings_)) break;
      for (const std::uint32_t v : vertices_of(placed_.parts, *placed_.parts.selected)) {
        places.push_back(document_.shown().state.positions[v]);
      }
      break;
    default:
      break;
  }
  Box box;
  for (const Vec3d& p : places) {
    box.extend(p - Vec3d{1, 1, 1} * around);
    box.extend(p + Vec3d{1, 1, 1} * around);
  }
  return box;
}

void StudioTools::take_stamp_back(std::span<const SessionStroke> strokes) {
  const auto way = stamp_way(strokes);
  if (way && placed_.placement && placed_.placement->center == way->to) placed_.placement->center = way->from;
}

void StudioTools::set_stamp(const std::function<StampShape(Document&)>& make) {
  load([this, make](Document& document, Progress& progress) {
    StampShape stamp = make(document);
    stop_if_cancelled(&progress);
    document_.deliver([this, stamp = std::move(stamp)] { placed_.stamp = stamp; });
  });
}

void StudioTools::set_picture(const std::filesystem::path& source) {
  load([this, source](Document& document, Progress& /*progress*/) {
    PrintStroke stroke;
    stroke.file = source.string();
    stroke.height = stroke.depth = 1;  // its outline does not depend on these
    const PrintPicture picture{document.keep_file(source), source, print_outline(stroke, {})};
    document_.deliver([this, picture] { placed_.picture = picture; });
  });
}

void StudioTools::load(const StudioDocument::Job& job) {
  const auto guarded = [this, job](Document& document, Progress& progress) {
    document_.withdraw(Subject::stamp);
    try {
      job(document, progress);
    } catch (const Cancelled&) {
      document_.tell({false, "The stamp was not loaded."});
    } catch (const std::exception& error) {
      document_.tell({true, error.what(), Subject::stamp});
    }
  };
  document_.post(guarded, "Loading the stamp");
}

void StudioTools::use_stamp(ShapeKind kind) {
  set_stamp([kind](Document& document) {
    return document.add_stamp(std::string(shape_names()[static_cast<std::size_t>(kind)]), make_shape(kind));
  });
}

void StudioTools::use_stamp(const std::filesystem::path& file) {
  interrupt_();
  if (is_picture(file)) {
    choose_tool(studio_tool(ToolUse::print), settings_);
    return set_picture(file);
  }
  choose_tool(studio_tool(ToolUse::stamp), settings_);
  set_stamp([file](Document& document) { return document.add_stamp(file.stem().string(), read_shape(file).mesh); });
}

void StudioTools::set_pins(std::vector<Pin> pins) {
  placed_.lit_pin.reset();
  placed_.pins = std::move(pins);
  studio::follow(placed_.pins, document_.shown().state);
}

void StudioTools::select_pins(bool are_selected) {
  for (Pin& pin : placed_.pins) pin.is_selected = are_selected;
}

void StudioTools::remove_pin(std::size_t pin) {
  placed_.pins.erase(placed_.pins.begin() + static_cast<std::ptrdiff_t>(pin));
  placed_.lit_pin.reset();
  set_pin_.reset();
}

void StudioTools::remove_selected() {
  std::erase_if(placed_.pins, [](const Pin& pin) { return pin.is_selected; });
  placed_.lit_pin.reset();
  set_pin_.reset();
  if (placed_.parts.selected && !has_exact_pins(settings_)) remove_part(*placed_.parts.selected, placed_.parts);
}

void StudioTools::find_limit_cylinder(bool may_turn) {
  const Turning& turning = settings_.tool->turning;
  if (!turning.takes_limit_cylinder || !placed_.placement) return;
  limit_cylinder_mesh_ = document_.shown().state.mesh;
  const Placement placement = *placed_.placement;
  const bool bends = turning.axis == &Placement::x;
  const auto find = [this, placement, bends, may_turn, settings = settings_](Document& document, Progress& progress) {
    try {
      Placement found =
          settings.uses_limit_cylinder ? document.with_limit_cylinder(placement, bends, may_turn, progress) : placement;
      found.profile = document.profile(settings, found);
      document_.deliver([this, placement, found] {
        if (placed_.placement == placement) placed_.placement = found;
      });
    } catch (const Cancelled&) {
      document_.tell({false, "The search for the part was stopped; the tool moves everything below its plane."});
    }
  };
  document_.post(find, "Looking for the part to move");
}

bool StudioTools::pick_plane(const Pointer& pointer, const GestureContext& context) {
  if (context.picker == nullptr) return false;
  const auto hit = context.picker->pick(ray_through(context.screen, pointer.x, pointer.y), context.state);
  if (!hit) return false;
  std::vector<Vec3d>& points = placed_.plane_points;
  points.push_back(hit->point);
  std::optional<Symmetry::Plane> plane;
  if (picking_ == PlanePick::face) plane = {hit->point, hit->normal};
  if (picking_ == PlanePick::three_points && points.size() == 3) {
    const Vec3d normal = cross(points[1] - points[0], points[2] - points[0]);
    const double least = 1e-9 * document_.shown().diagonal * document_.shown().diagonal;
    if (!(norm(normal) > least)) {
      points.pop_back();
      document_.tell({true, "The three points lie on a line; click the third one elsewhere."});
      return true;
    }
    plane = {points[0], normalized(normal)};
  }
  if (!plane) return true;
  settings_.symmetry.plane = plane;
  pick_mirror(PlanePick::none);
  return true;
}

void StudioTools::pick_mirror(PlanePick how) {
  picking_ = picking_ == how ? PlanePick::none : how;
  placed_.plane_points.clear();
}

void StudioTools::center_symmetry() {
  if (document_.shown().opened != 0) settings_.symmetry.center = shape_box(document_.shown().state.to_mesh()).center();
}

// --- masks -----------------------------------------------------------------------------------------------------------

StudioMasks::StudioMasks(StudioDocument& document, StudioTools& tools,
                         std::function<void(std::vector<SessionStroke>)> apply)
    : document_(document), tools_(tools), apply_(std::move(apply)) {}

void StudioMasks::follow() {
  const DocumentState& shown = document_.shown();
  if (shown.looked_at || drawing_) return;
  if (shown.state.mask.shares(values_mask_) && shown.state.mesh == values_mesh_) return;
  values_mask_ = shown.state.mask;
  values_mesh_ = shown.state.mesh;
  values_ = mask_values(shown.history, shown.state);
}

std::vector<Pixel> StudioMasks::line() const { return drawing_ ? drawing_->line : std::vector<Pixel>{}; }

void StudioMasks::begin(const Pointer& pointer, const GestureContext& context) {
  drawing_ = Drawing{values_, pointer.modifiers.ctrl, {{pointer.x, pointer.y}}, context.screen};
  move(pointer, context);
}

void StudioMasks::move(const Pointer& pointer, const GestureContext& context) {
  std::vector<Pixel>& line = drawing_->line;
  switch (tools_.settings().mask_mode) {
    case MaskMode::paint:
      return paint(pointer, context);
    case MaskMode::lasso:
      return extend_line(pointer, line);
    case MaskMode::box: {
      const Pixel first = line.front();
      const Pixel here{pointer.x, pointer.y};
      line = {first, {here.x, first.y}, here, {first.x, here.y}};
      return;
    }
  }
}

void StudioMasks::paint(const Pointer& pointer, const GestureContext& context) {
  const auto hit = hit_at(pointer, context);
  if (!hit) return;
  const ToolSettings& settings = tools_.settings();
  const Snapshot& positions = document_.shown().state.positions;
  MaskBrush brush{hit->point, settings.inner_ratio * settings.radius, settings.radius, drawing_->erases};
  studio::paint(brush, positions, values_);
  for (const SymmetryImage& image : images_of(settings)) {
    brush.center = image.motion(hit->point);
    studio::paint(brush, positions, values_);
  }
}

void StudioMasks::end(bool is_kept) {
  const Drawing done = std::move(*drawing_);
  drawing_.reset();
  if (!is_kept) {
    values_ = done.before;
    return;
  }
  if (tools_.settings().mask_mode != MaskMode::paint) {
    fill(done.line, done.screen, done.erases, document_.shown().state.positions, values_);
  }
  if (values_ != done.before) apply();
}

void StudioMasks::change(MaskEdit edit) {
  const DocumentState& shown = document_.shown();
  if (drawing_ || shown.opened == 0 || shown.looked_at) return;
  const MaskValues before = values_;
  values_ = changed(std::move(values_), edit, *shown.state.mesh);
  if (values_ != before) apply();
}

void StudioMasks::apply() {
  const ToolSettings& settings = tools_.settings();
  apply_({{mask_stroke(values_, document_.shown().state, settings.mask_width * settings.radius)}});
}

}  // namespace knead::studio
