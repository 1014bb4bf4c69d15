// What is drawn at the pointer and on the shape: rings, pins, pairs, numbers, the colours of influence and stretch.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "gestures/gesture_kinds.h"
#include "gestures/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "view/overlay.h"

namespace knead::studio {

namespace {

constexpr int kPoints = 64;         // of a ring; a multiple of 2 kDash
constexpr std::size_t kDash = 2;    // steps of a dash, and of a gap
constexpr double kThickness = 1.1;  // half, in points
constexpr double kThickest = 3;     // of that: the inner ring of a tool at full strength
constexpr double kDotPoints = 4.5;  // radius of the dot at a mirror image
constexpr double kNearest = 0.5;    // of the way to the eye: rings come no nearer
constexpr std::size_t kMaxImages = 32;
constexpr double kHalfOfGrowth = 0.363;  // of the radius: there a body inflates half as fast (docs/mathematics.md)
constexpr double kArrowPoints = 70;
constexpr double kPointing = 0.5;  // of Drag::depth, above which the arrow is shown
// Vertices that an estimate looks at, and those of them that it follows: 3 ms on two cores.
constexpr std::size_t kLookedAt = 40'000;
constexpr std::size_t kFollowed = 192;
constexpr double kMinPart = 0.9 / 2.4;  // of the safe width of a bend
constexpr std::size_t kVerticesAtOnce = 4096;
constexpr double kShadeError = 1e-3;   // of a displacement
constexpr double kNominalPart = 0.05;  // of the radius: how far a pin is moved to show what it takes along
constexpr double kPinPoints = 5;
constexpr double kLinePoints = 1.6;  // half the width of the line of bend_along
constexpr double kHandlePoints = 6;  // the radius of its handles
constexpr std::size_t kPiecesOfLine = 64;
constexpr double kLatticeLinePoints = 0.8;
constexpr double kControlPoints = 4.5;  // the radius of one, in points
constexpr render::Color kLatticeLine{0.35f, 0.40f, 0.48f, 1};
constexpr double kFitPoints = 6;
constexpr render::Color kHeldPin{0.16f, 0.40f, 0.78f, 1};
constexpr render::Color kFreePin{0.92f, 0.92f, 0.90f, 1};

// The radii of the rings, and how strong the tool is, from 0 to 1.
struct Radii {
  double outer = 0;
  double inner = 0;
  double strength = 0;
};

std::optional<Radii> radii_of(const Studio& studio) {
  const ToolSettings& settings = studio.tools().settings();
  switch (settings.tool->use) {
    case ToolUse::mask:
      if (settings.mask_mode != MaskMode::paint) return std::nullopt;
      return Radii{settings.radius, settings.inner_ratio * settings.radius};
    case ToolUse::pull:
      return Radii{settings.radius, half_radius(settings, settings.inner_ratio)};
    case ToolUse::paint: {
      const bool is_pressed = studio.gesture() && settings.pressure == PenPressure::depth;
      const double pressure = is_pressed ? studio.pointer().pressure : 1;
      const double amount = settings.tool->brush->pinch == 0 ? settings.depth : settings.pinch;
      return Radii{settings.radius, half_radius(settings, 0), std::clamp(amount * pressure, 0.0, 1.0)};
    }
    case ToolUse::inflate:
      return Radii{settings.radius, kHalfOfGrowth * settings.radius};
    case ToolUse::smooth:
      return Radii{settings.radius, 0, settings.smoothing};
    case ToolUse::points:
    case ToolUse::curve:
      return Radii{settings.radius, half_radius(settings, 0)};
    case ToolUse::pose:
      if (settings.pose == PoseMode::brush) return Radii{0.5 * settings.radius};
      if (settings.auto_radius || !has_exact_pins(settings)) return std::nullopt;
      return Radii{settings.radius};
    case ToolUse::print:
      return Radii{settings.radius};
    case ToolUse::stamp:
    case ToolUse::bend_along:
    case ToolUse::lattice:
    case ToolUse::turn:
      return std::nullopt;
  }
  return std::nullopt;
}

// The middle of the rings and the direction that they face.
struct CursorPlace {
  Vec3d center;
  Vec3d normal;
};

// On the surface; beside the shape in the plane through the view's target, where a drag begins.
std::optional<CursorPlace> cursor_place(const Studio& studio) {
  const auto* const pull = studio.gesture() ? std::get_if<ImplicitGesture>(&studio.gesture()->kind) : nullptr;
  if (pull != nullptr) {
    const std::vector<Vec3d>& path = pull->stroke.path;
    const Vec3d center = pull->touched + (path.back() - path.front());
    return CursorPlace{kept_in_symmetry(center, path.front(), studio.tools().settings()), pull->normal};
  }
  const DocumentState& shown = studio.document().shown();
  if (!studio.pointer_is_over_view() || !shown.picker || !shown.picker->fits(shown.state)) return std::nullopt;
  const Screen screen = studio.view().screen();
  const Ray ray = ray_through(screen, studio.pointer().x, studio.pointer().y);
  if (const auto hit = shown.picker->pick(ray, shown.state)) return CursorPlace{hit->point, hit->normal};
  const Vec3d forward = render::camera_frame(screen.camera).forward;
  const auto beside = on_plane(ray, screen.camera.target, forward);
  return beside ? std::optional(CursorPlace{*beside, -forward}) : std::nullopt;
}

// Moves lines towards the eye by `by`, so that they are seen as before but no hollow of the shape hides a part of them.
void lift(const Screen& screen, const Vec3d& center, double by, std::vector<render::Line>& lines) {
  const render::Camera& camera = screen.camera;
  if (camera.projection != render::Projection::perspective) {
    const Vec3d nearer = render::camera_frame(camera).forward * -by;
    for (render::Line& line : lines) {
      for (Vec3d& p : line.points) p += nearer;
    }
    return;
  }
  const double scale = std::max(1 - by / norm(center - camera.eye), kNearest);
  for (render::Line& line : lines) {
    line.radius *= scale;
    for (Vec3d& p : line.points) p = camera.eye + (p - camera.eye) * scale;
  }
}

void add_dashes(const std::vector<Vec3d>& ring, render::Line line, std::vector<render::Line>& lines) {
  for (std::size_t i = 0; i < ring.size(); i += 2 * kDash) {
    line.points.assign(ring.begin() + static_cast<std::ptrdiff_t>(i),
                       ring.begin() + static_cast<std::ptrdiff_t>(i + kDash + 1));
    lines.push_back(line);
  }
}

// The drag that would begin at the pointer, of tools that go along a line.
std::optional<Drag> next_drag(const Studio& studio) {
  const ToolSettings& settings = studio.tools().settings();
  const PlacedTools& placed = studio.tools().placed();
  const GestureContext around = next_context(studio);
  if (studio.document().shown().opened == 0 || studio.document().shown().looked_at) return std::nullopt;
  if (settings.tool->use == ToolUse::stamp && placed.stamp && placed.placement) {
    return begin_stamp(studio.pointer(), around, placed).drag;
  }
  if (settings.tool->use != ToolUse::pull || !studio.pointer_is_over_view()) return std::nullopt;
  if (!hit_at(studio.pointer(), around)) return std::nullopt;
  return begin_implicit(studio.pointer(), around).drag;
}

const char* word_of(const Amount& amount, bool is_adjusting) {
  switch (amount.kind) {
    case AmountKind::length:
      return is_adjusting ? "Radius" : "Distance";
    case AmountKind::angle:
      return "Angle";
    case AmountKind::percent:
      return is_adjusting ? "Inner ratio" : "Stretch";
  }
  return "";
}

std::string with_sign(const std::string& number, AmountKind kind, LengthUnit unit) {
  const bool is_apart = kind == AmountKind::length && unit != LengthUnit::none;
  return number + (is_apart ? " " : "") + sign_of(kind, unit);
}

// Nothing for pins whose stroke is impossible.
std::optional<double> radius_of_gesture(const Studio& studio) {
  const auto* const pins = std::get_if<PinsGesture>(&studio.gesture()->kind);
  if (std::holds_alternative<BendAlongGesture>(studio.gesture()->kind) ||
      std::holds_alternative<LatticeGesture>(studio.gesture()->kind)) {
    return std::nullopt;
  }
  if (pins == nullptr) return studio.tools().settings().radius;
  if (!has_exact_pins(studio.tools().settings())) return std::nullopt;
  return radius_of(pins_stroke(pins->pins, pins->dragged, pins->to, studio.tools().settings()));
}

// The places of the vertices from which the shape is stretched.
std::optional<std::vector<Vec3d>> places_before(const DocumentState& shown, StretchView since) {
  const ShapeState& now = shown.state;
  const bool is_past = shown.looked_at.has_value();
  if (since == StretchView::since_start) {
    return now.provenance == nullptr ? shown.start.positions.copy() : now.provenance->rest;
  }
  if (is_past || !shown.before_stroke) return std::nullopt;
  if (shown.before_stroke->mesh == now.mesh) return shown.before_stroke->positions.copy();
  return now.provenance == nullptr ? std::nullopt : std::optional(now.provenance->before_stroke);
}

std::vector<Vec3d> some_of(const Snapshot& positions) {
  const std::size_t stride = positions.size() / kLookedAt + 1;
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < positions.size(); i += stride) result.push_back(positions[i]);
  return result;
}

// Path lines of such a bend may run to infinity (method, section 10).
bool is_crushed(const Stroke& stroke, const ZoneProfile& profile) {
  const std::optional<ZoneCheck> check = check_zone(stroke, profile);
  return check && check->stretch == 0 && check->width < kMinPart * check->safe;
}

bool is_within(const LimitCylinder& limit_cylinder, const Vec3d& p) {
  const Vec3d d = p - limit_cylinder.center;
  return norm2(d - limit_cylinder.axis * dot(d, limit_cylinder.axis)) <= limit_cylinder.radius * limit_cylinder.radius;
}

double weight_at(const Segment& segment, const Vec3d& p) {
  if (segment.limit_cylinder && !is_within(*segment.limit_cylinder, p)) return 0;
  double most = 0;
  for (const Field& field : segment.fields) {
    most = std::max(most, blend_weight(region_value(field, p - field.center).value, field.thresholds).value);
  }
  return most;
}

// A print's outline where the print would be.
void add_outline(const Studio& studio, const CursorPlace& place, std::span<const PlaneLine> outline, double thickness,
                 std::vector<render::Line>& lines) {
  const Vec3d to_up = print_up(studio.view().screen(), place.normal);
  const Vec3d up = normalized(to_up - place.normal * dot(to_up, place.normal)) * studio.tools().settings().radius;
  const Vec3d right = cross(up, place.normal);
  for (const auto& [from, to] : outline) {
    lines.push_back(
        {.points = {place.center + right * from[0] + up * from[1], place.center + right * to[0] + up * to[1]},
         .radius = thickness,
         .color = studio.preferences().outer_ring,
         .round = false});  // a thousand of them are drawn for every place of the pointer
  }
}

}  // namespace

void add_cursor(const Studio& studio, std::span<const PlaneLine> outline, std::vector<render::Line>& lines) {
  const DocumentState& shown = studio.document().shown();
  const std::optional<Radii> radii = radii_of(studio);
  if (!radii || shown.opened == 0 || shown.looked_at) return;
  const std::optional<CursorPlace> place = cursor_place(studio);
  if (!place) return;
  const Preferences& preferences = studio.preferences();
  const double point = point_size(studio.view().screen(), place->center);
  const auto ring = [&](double radius) { return render::ring(place->center, place->normal, radius, kPoints); };
  std::vector<render::Line> cursor;
  if (outline.empty()) {
    cursor.push_back(
        {.points = ring(radii->outer), .radius = kThickness * point, .closed = true, .color = preferences.outer_ring});
  }
  add_outline(studio, *place, outline, kThickness * point, cursor);
  const double thickness = kThickness * (1 + (kThickest - 1) * radii->strength) * point;
  if (radii->inner > 0) {
    add_dashes(ring(radii->inner), {.points = {}, .radius = thickness, .color = preferences.inner_ring}, cursor);
  }
  std::vector<SymmetryImage> images = images_of(studio.tools().settings());
  if (images.size() > kMaxImages) images.resize(kMaxImages);
  for (const SymmetryImage& image : images) {
    const Vec3d at = image.motion(place->center);
    const double radius = kDotPoints * point_size(studio.view().screen(), at);
    cursor.push_back(
        {.points = {at, at + Vec3d{0, 1e-3 * radius, 0}}, .radius = radius, .color = preferences.outer_ring});
  }
  lift(studio.view().screen(), place->center, radii->outer, cursor);
  lines.insert(lines.end(), cursor.begin(), cursor.end());
}

void add_bend_line(const Studio& studio, std::vector<render::Line>& lines) {
  if (studio.tools().settings().tool->use != ToolUse::bend_along || studio.document().shown().looked_at) return;
  const Screen screen = studio.view().screen();
  const auto* const drag = studio.gesture() ? std::get_if<BendAlongGesture>(&studio.gesture()->kind) : nullptr;
  const bool is_drawn = drag != nullptr && !drag->handle;
  const PlacedTools& placed = studio.tools().placed();
  const std::vector<Vec3d>& path = drag != nullptr && !drag->to.empty() ? drag->to : placed.line;
  const auto pointed = [&] { return handle_at(studio.pointer(), screen, path, placed.line_stride); };
  const auto lit = drag != nullptr ? drag->handle : pointed();
  std::vector<Vec3d> line = is_drawn ? drag->drawn : points_on_line(path, kPiecesOfLine + 1);
  if (line.size() < 2) return;
  const Vec3d middle = line[line.size() / 2];
  std::vector<render::Line> shown{
      {.points = std::move(line), .radius = kLinePoints * point_size(screen, middle), .color = kPlaced}};
  for (std::size_t i = 0; i < path.size() && !is_drawn; i += placed.line_stride) {
    const bool is_lit = lit == i / placed.line_stride;
    const double size = (is_lit ? 1.3 : 1) * kHandlePoints * point_size(screen, path[i]);
    shown.push_back({.points = {path[i], path[i] + Vec3d{0, 1e-3 * size, 0}},
                     .radius = size,
                     .color = is_lit ? kLitHandle : kPlaced});
  }
  lift(screen, middle, studio.document().shown().diagonal, shown);
  lines.insert(lines.end(), shown.begin(), shown.end());
}

void add_lattice(const Studio& studio, std::vector<render::Line>& lines) {
  if (studio.tools().settings().tool->use != ToolUse::lattice || studio.document().shown().looked_at) return;
  const Screen screen = studio.view().screen();
  const auto* const drag = studio.gesture() ? std::get_if<LatticeGesture>(&studio.gesture()->kind) : nullptr;
  const PlacedLattice& placed = studio.tools().placed().lattice;
  const std::vector<Vec3d> points = control_points(drag != nullptr ? drag->moved() : placed.stroke);
  if (points.empty()) return;
  const auto pointed = studio.gesture() ? std::nullopt : control_point_at(studio.pointer(), screen, points);
  const std::size_t lit = pointed.value_or(points.size());
  std::vector<render::Line> shown;
  const std::array<int, 3>& counts = placed.stroke.counts;
  std::size_t stride = points.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto count = static_cast<std::size_t>(counts[axis]);
    const std::size_t along = stride;
    stride /= count;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i % along >= stride) continue;  // not the first of its line
      render::Line line{
          .points = {}, .radius = kLatticeLinePoints * point_size(screen, points[i]), .color = kLatticeLine};
      for (std::size_t k = 0; k < count; ++k) line.points.push_back(points[i + k * stride]);
      shown.push_back(std::move(line));
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double size = (lit == i ? 1.3 : 1) * kControlPoints * point_size(screen, points[i]);
    shown.push_back({.points = {points[i], points[i] + Vec3d{0, 1e-3 * size, 0}},
                     .radius = size,
                     .color = lit == i || placed.selected[i] ? kLitHandle : kPlaced});
  }
  lift(screen, points.front(), studio.document().shown().diagonal, shown);
  lines.insert(lines.end(), shown.begin(), shown.end());
}

std::optional<InArrow> in_arrow(const Studio& studio) {
  const Drag* of_gesture = studio.gesture() ? drag_of(*studio.gesture()) : nullptr;
  const std::optional<Drag> next = studio.gesture() ? std::nullopt : next_drag(studio);
  const Drag* const drag = of_gesture != nullptr ? of_gesture : next ? &*next : nullptr;
  if (drag == nullptr || !(drag->depth > kPointing)) return std::nullopt;
  const Screen screen = studio.view().screen();
  const render::CameraFrame frame = render::camera_frame(screen.camera);
  const double away = dot(drag->direction, frame.forward) > 0 ? drag->up : -drag->up;  // upwards is in: 1
  const Vec3d beside = frame.right * (0.5 * kArrowPoints * point_size(screen, drag->start));
  const Vec3d along = frame.up * (away * kArrowPoints * point_size(screen, drag->start));
  const Vec3d from = drag->start + beside;
  return InArrow{from, from + along};
}

std::string sign_of(AmountKind kind, LengthUnit unit) {
  switch (kind) {
    case AmountKind::length:
      return text_of(unit);
    case AmountKind::angle:
      return "\u00b0";
    case AmountKind::percent:
      return "%";
  }
  return "";
}

std::string text_of(const Amount& amount, LengthUnit unit) {
  // No more digits than four, and no minus before zero.
  const double value = std::abs(amount.value) < 1e-12 ? 0 : amount.value;
  const std::string number =
      amount.kind == AmountKind::length ? fmt::format("{:.4g}", value) : fmt::format("{:.1f}", value);
  return with_sign(number, amount.kind, unit);
}

std::vector<std::string> numbers_at_pointer(const Studio& studio) {
  const LengthUnit unit = studio.preferences().unit;
  const bool is_painting = studio.gesture() && std::holds_alternative<PaintGesture>(studio.gesture()->kind);
  const std::optional<PointedNumber> number = studio.number();
  std::vector<std::string> lines;
  if (number) {
    const Amount& amount = number->amount;
    const std::string value =
        number->typed.empty() ? text_of(amount, unit) : with_sign(number->typed + "_", amount.kind, unit);
    lines.push_back(fmt::format("{} {}", word_of(amount, number->is_adjusting), value));
  }
  if (!studio.gesture() || (!number && !is_painting)) return lines;
  const ToolSettings& settings = studio.tools().settings();
  const std::optional<double> radius = radius_of_gesture(studio);
  if (radius) lines.push_back("Radius " + text_of({AmountKind::length, *radius}, unit));
  if (is_painting && settings.tool->brush->pinch != 0) lines.push_back(fmt::format("Strength {:.4g}", settings.pinch));
  if (is_painting && settings.tool->brush->pinch == 0) {
    lines.push_back("Depth " + text_of({AmountKind::length, settings.depth * settings.radius}, unit));
  }
  const DocumentState& shown = studio.document().shown();
  if (shown.volume && shown.volume_before && *shown.volume_before != 0) {
    lines.push_back(fmt::format("Volume {:+.5f}%", 100 * (*shown.volume / *shown.volume_before - 1)));
  }
  return lines;
}

float shade_of_stretch(double stretch) {
  return static_cast<float>(std::clamp(std::log(stretch) / std::log(kGreatestShown), 0.0, 1.0));
}

std::optional<std::vector<float>> stretches_shown(const DocumentState& shown, StretchView since) {
  if (shown.opened == 0 || shown.state.mesh == nullptr) return std::nullopt;
  const std::optional<std::vector<Vec3d>> before = places_before(shown, since);
  if (!before || before->size() != shown.state.positions.size()) return std::nullopt;
  return vertex_stretches(triangulate(*shown.state.mesh), *before, shown.state.positions.copy());
}

const std::optional<GreatestStretch>& StretchEstimate::update(const Studio& studio) {
  const DocumentState& shown = studio.document().shown();
  std::vector<Stroke> strokes;
  if (studio.tools().settings().tool->use == ToolUse::turn && shown.opened != 0 && !shown.looked_at) {
    strokes = studio.gesture() ? studio.preview() : hovering(studio);
  }
  const ShapeState& state = studio.gesture() ? studio.gesture()->start : shown.state;
  const bool is_same = state_.mesh != nullptr && state_.is_same(state);
  if (is_same && strokes == strokes_) return estimate_;
  if (!is_same) positions_ = some_of(state.positions);
  state_ = state;
  strokes_ = std::move(strokes);
  estimate_.reset();
  const auto& placement = studio.tools().placed().placement;
  Flow flow;
  for (const Stroke& stroke : strokes_) {
    if (placement && placement->profile && is_crushed(stroke, *placement->profile)) {
      estimate_ = GreatestStretch{HUGE_VAL, 0, placement->center, 1};
      return estimate_;
    }
    if (reads_surface(stroke)) continue;
    const Flow one = flow_of(stroke);
    flow.segments.insert(flow.segments.end(), one.segments.begin(), one.segments.end());
  }
  if (flow.segments.empty()) return estimate_;
  StrainOptions options;
  options.length = shown.diagonal;
  options.samples = kFollowed;
  estimate_ = greatest_stretch(flow, positions_, options);
  return estimate_;
}

std::string zone_note(const Studio& studio) {
  const std::optional<Gesture>& gesture = studio.gesture();
  const auto* turn = gesture ? std::get_if<TurnGesture>(&gesture->kind) : nullptr;
  if (turn == nullptr || !turn->placement) return {};
  const std::optional<double> width = widened_zone(studio.tools().settings(), *turn->placement, turn->amount);
  if (!width) return {};
  return fmt::format("The zone is {:.3g} wide now: a thinner one would crush the shape at this angle.", *width);
}

std::vector<float> influence_of(std::span<const Flow> flows, const Snapshot& positions, int threads) {
  std::vector<float> result(positions.size());
  parallel_for(positions.size(), kVerticesAtOnce, threads, [&](std::size_t begin, std::size_t end) {
    for (const Flow& flow : flows) {
      if (flow.segments.empty()) continue;
      if (!flow.segments.front().grid.is_empty()) {
        const FlowSupport support(Flow{{flow.segments.front()}});
        for (std::size_t i = begin; i < end; ++i) {
          if (support.may_move(positions[i], 0)) result[i] = 1;
        }
        continue;
      }
      for (std::size_t i = begin; i < end; ++i) {
        result[i] = std::max(result[i], static_cast<float>(weight_at(flow.segments.front(), positions[i])));
      }
    }
  });
  return result;
}

std::vector<float> influence_of(const PinsStroke& stroke, const Snapshot& positions, int threads) {
  double longest = 0;
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    longest = std::max(longest, norm(stroke.to[i] - stroke.points[i]));
  }
  const std::vector<Vec3d> before = positions.copy();
  std::vector<Vec3d> after = before;
  AdvectOptions options;
  options.tolerance = kShadeError * longest;
  options.threads = threads;
  try {
    advect(flow_of(stroke), after, options);
  } catch (const InvalidInput&) {
    return {};
  }
  std::vector<float> result(before.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = static_cast<float>(std::min(norm(after[i] - before[i]) / longest, 1.0));
  }
  return result;
}

render::Color color_of_pair(std::size_t pair) {
  constexpr std::array<render::Color, 6> colors{{{0.90f, 0.30f, 0.20f, 1},
                                                 {0.20f, 0.50f, 0.90f, 1},
                                                 {0.25f, 0.70f, 0.30f, 1},
                                                 {0.95f, 0.75f, 0.15f, 1},
                                                 {0.65f, 0.35f, 0.80f, 1},
                                                 {0.20f, 0.75f, 0.75f, 1}}};
  return colors[pair % colors.size()];
}

void add_fit_points(const Studio& studio, bool of_target, const Screen& screen, std::vector<render::Line>& lines) {
  const StudioFit& fit = studio.fit();
  const Snapshot& positions = of_target ? fit.target().positions : studio.document().shown().state.positions;
  for (std::size_t i = 0; i < fit.pairs().size(); ++i) {
    const std::optional<std::uint32_t> vertex = of_target ? fit.pairs()[i].target : fit.pairs()[i].source;
    if (!vertex || *vertex >= positions.size()) continue;
    const Vec3d& place = positions[*vertex];
    const double radius = kFitPoints * point_size(screen, place);
    lines.push_back(
        {.points = {place, place + Vec3d{0, 1e-3 * radius, 0}}, .radius = radius, .color = color_of_pair(i)});
  }
}

void add_pins(const Studio& studio, std::vector<render::Line>& lines) {
  if (studio.tools().settings().tool->use != ToolUse::pose || studio.document().shown().looked_at) return;
  const auto* const drag = studio.gesture() ? std::get_if<PinsGesture>(&studio.gesture()->kind) : nullptr;
  std::vector<Pin> pins = drag != nullptr ? drag->pins : studio.tools().placed().pins;
  const std::optional<std::size_t> lit = studio.pointed_pin();
  const Screen screen = studio.view().screen();
  const auto add = [&](const Vec3d& place, double points, const render::Color& color) {
    const double radius = points * point_size(screen, place);
    lines.push_back({.points = {place, place + Vec3d{0, 1e-3 * radius, 0}}, .radius = radius, .color = color});
  };
  const std::vector<SymmetryImage> images = images_of(studio.tools().settings());
  if (drag != nullptr) {
    for (const PinGoal& goal : pin_goals(drag->pins, drag->dragged, drag->to, studio.tools().settings())) {
      const Vec3d from = std::exchange(pins[goal.pin].place, goal.to);
      pins[goal.pin].is_selected = true;
      const double radius = 0.25 * kPinPoints * point_size(screen, from);
      if (!(from == goal.to)) lines.push_back({.points = {from, goal.to}, .radius = radius, .color = kPlaced});
    }
  }
  for (std::size_t i = 0; i < pins.size(); ++i) {
    const bool is_lit = drag == nullptr && i == lit;
    const render::Color color = is_lit                ? kLitHandle
                                : pins[i].is_selected ? kPlaced
                                : pins[i].holds       ? kHeldPin
                                                      : kFreePin;
    add(pins[i].place, kPinPoints, color);
    for (const SymmetryImage& image : images) add(image.motion(pins[i].place), 0.6 * kPinPoints, color);
  }
}

std::optional<PinsStroke> hovering_pins(const Studio& studio) {
  const std::vector<Pin>& pins = studio.tools().placed().pins;
  if (pins.empty()) return std::nullopt;
  const std::size_t pin = studio.pointed_pin().value_or(pins.size() - 1);
  const Vec3d by = render::camera_frame(studio.view().screen().camera).up * (kNominalPart * studio.tools().radius());
  return pins_stroke(pins, pin, pins[pin].place + by, studio.tools().settings());
}

}  // namespace knead::studio
