#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include "math/elementary.h"

#include "field/grid.h"
#include "knead/error.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(ImplicitStroke& s) {
  constexpr std::string_view kCapsule = R"("region": "capsule")";
  const bool capsule = s.region == ImplicitRegion::capsule;
  return {{"path", Quantity::finite, &s.path},
          {"inner", Quantity::positive, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp},
          {"region", Quantity::other, choice(s.region, {"ball", "capsule"}), Presence::optional},
          {"half_axis", Quantity::direction, capsule ? &s.half_axis : nullptr, Presence::required, {}, kCapsule},
          {"gauge", Quantity::finite, capsule ? &s.gauge : nullptr, Presence::optional, {}, kCapsule},
          {"time", Quantity::other, choice(s.time, {"swept", "blended"}), Presence::optional}};
}

void validate(const ImplicitStroke& stroke) {
  require_count("path", stroke.path.size(), 2, "points");
  require_distance_thresholds(stroke.inner, stroke.outer);
  if (stroke.time == TimeLaw::pinned) throw InvalidInput("\"time\" must be \"swept\" or \"blended\"");
  if (stroke.region == ImplicitRegion::ball && (stroke.half_axis != Vec3d{0, 0, 0} || stroke.gauge != 0)) {
    throw InvalidInput("\"half_axis\" and \"gauge\" belong to \"region\": \"capsule\" only");
  }
}

Flow flow_of(const ImplicitStroke& stroke) {
  const bool capsule = stroke.region == ImplicitRegion::capsule;
  Flow flow;
  for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) {
    const Vec3d displacement = stroke.path[i + 1] - stroke.path[i];
    if (displacement == Vec3d{0, 0, 0}) continue;
    Field field{stroke.path[i], Translation<double>{displacement}, Ball<double>{}, {stroke.inner, stroke.outer}};
    if (capsule) {
      field.motion = Translation<double>{displacement, unit(stroke.half_axis), stroke.gauge};
      field.region = Capsule<double>{stroke.half_axis};
    }
    flow.segments.push_back(transported_segment(std::move(field), displacement, stroke.time));
  }
  return flow;
}

void warn(const ImplicitStroke& stroke, Warnings& warnings) {
  warn_of_thin_shell({stroke.inner, stroke.outer, stroke.falloff}, warnings);
}

void prolong(ImplicitStroke& stroke, double strength) { prolong_path(stroke.path, strength); }

}  // namespace

const Tool& ImplicitStroke::tool() {
  static const Tool kTool =
      describe<ImplicitStroke>("implicit", {keys, validate, flow_of, warn, nullptr, nullptr, prolong});
  return kTool;
}

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(RotateStroke& s) {
  return {{"center", Quantity::finite, &s.center},
          {"axis", Quantity::direction, &s.axis},
          {"angle_deg", Quantity::angle, &s.angle_deg, Presence::required, "rotation of the inner region"},
          {"inner", Quantity::other, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp},
          {"gauge", Quantity::finite, &s.gauge, Presence::optional}};
}

void validate(const RotateStroke& stroke) { require_distance_thresholds(stroke.inner, stroke.outer); }

Flow flow_of(const RotateStroke& stroke) {
  const Rotation<double> motion{unit(stroke.axis), stroke.angle_deg * kRadiansPerDegree, stroke.gauge,
                                RotationGauge::radial};
  return {{resting_segment({stroke.center, motion, Ball<double>{}, {stroke.inner, stroke.outer}})}};
}

// With gauge 0 nothing turns back.
void warn(const RotateStroke& stroke, Warnings& warnings) {
  if (stroke.gauge != 0) warn_of_thin_shell({stroke.inner, stroke.outer, stroke.falloff}, warnings);
}

}  // namespace

const Tool& RotateStroke::tool() {
  static const Tool kTool = describe<RotateStroke>("rotate", {keys, validate, flow_of, warn});
  return kTool;
}

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(StretchStroke& s) {
  return {{"center", Quantity::finite, &s.center},
          {"axis", Quantity::direction, &s.axis},
          {"factor", Quantity::other, &s.factor, Presence::required, "longer along the axis; below 1 shorter"},
          {"inner", Quantity::other, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp}};
}

void validate(const StretchStroke& stroke) {
  require_factor("factor", stroke.factor);
  require_distance_thresholds(stroke.inner, stroke.outer);
}

// ln(factor) (a a^T - (I - a a^T) / 2)
Flow flow_of(const StretchStroke& stroke) {
  const Vec3d a = unit(stroke.axis);
  const Mat3d shape = outer_product(a, a) * 1.5 + Mat3d{} * -0.5;
  const Strain<double> motion{shape * elementary::log(stroke.factor)};
  return {{resting_segment({stroke.center, motion, Ball<double>{}, {stroke.inner, stroke.outer}})}};
}

void warn(const StretchStroke& stroke, Warnings& warnings) {
  warn_of_thin_shell({stroke.inner, stroke.outer, stroke.falloff}, warnings);
}

void prolong(StretchStroke& stroke, double strength) { stroke.factor = elementary::pow(stroke.factor, strength); }

}  // namespace

const Tool& StretchStroke::tool() {
  static const Tool kTool =
      describe<StretchStroke>("stretch", {keys, validate, flow_of, warn, nullptr, nullptr, prolong});
  return kTool;
}

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(TwistStroke& s) {
  return {{"center", Quantity::finite, &s.center},
          {"axis", Quantity::direction, &s.axis},
          {"rate_deg", Quantity::rate, &s.rate_deg, Presence::required, "degrees for one unit of length"},
          {"inner", Quantity::other, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp},
          {"normal", Quantity::direction, &s.normal, Presence::optional},
          {"gauge", Quantity::finite, &s.gauge, Presence::optional},
          {"radius", Quantity::positive, AutoNumber{&s.radius, &s.radius_auto}, Presence::optional,
           "of the limit cylinder"}};
}

// The rate has the unit of an angle for one of length, so the angle between the thresholds has the limit.
void validate(const TwistStroke& stroke) {
  require_thresholds(stroke.inner, stroke.outer);
  const double degrees = std::abs(stroke.rate_deg) * std::min(1.0, stroke.outer - stroke.inner);
  if (degrees <= kMaxDegrees) return;
  throw InvalidInput(fmt::format(
      "\"rate_deg\" turns by {:g} degrees from \"inner\" to \"outer\"; at most 360000 are possible", degrees));
}

bool reads_surface(const TwistStroke& stroke) { return stroke.radius_auto; }

Flow flow_of(const TwistStroke& stroke) {
  const Vec3d axis = unit(stroke.axis);
  const Vec3d normal = stroke.normal ? unit(*stroke.normal) : axis;
  const Twist<double> motion{axis, stroke.rate_deg * kRadiansPerDegree, stroke.gauge};
  Segment segment = resting_segment({stroke.center, motion, HalfSpace<double>{normal}, {stroke.inner, stroke.outer}});
  if (stroke.radius) segment.limit_cylinder = LimitCylinder{stroke.center, normal, *stroke.radius};
  return {{std::move(segment)}};
}

}  // namespace

const Tool& TwistStroke::tool() {
  static const Tool kTool = describe<TwistStroke>("twist", {keys, validate, flow_of, nullptr, reads_surface});
  return kTool;
}

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(GridStroke& s) {
  return {{"origin", Quantity::finite, &s.grid.origin},
          {"spacing", Quantity::positive, &s.grid.spacing},
          {"counts", Quantity::other, &s.grid.counts},
          {"coefficients", Quantity::other, &s.grid.coefficients},
          {"end_coefficients", Quantity::other, &s.grid.end_coefficients, Presence::optional},
          {"growth", Quantity::other, &s.grid.growth, Presence::optional}};
}

void require_coefficients(std::string_view key, const SharedVectors& coefficients, std::size_t nodes) {
  if (coefficients.size() != nodes) {
    throw InvalidInput(
        fmt::format("\"{}\" must hold three numbers for each of the {} nodes that \"counts\" gives, got {}", key, nodes,
                    3 * coefficients.size()));
  }
  for (const Vec3d& coefficient : coefficients) require_finite(key, coefficient);
}

void validate(const GridStroke& stroke) {
  const auto& [nx, ny, nz] = stroke.grid.counts;
  const std::optional<std::size_t> nodes = detail::node_count(stroke.grid.counts);
  if (!nodes) {
    throw InvalidInput(fmt::format(
        "\"counts\" must be three whole numbers of at least 1, of at most 16 million nodes together, got [{}, {}, {}]",
        nx, ny, nz));
  }
  require_coefficients("coefficients", stroke.grid.coefficients, *nodes);
  if (!stroke.grid.end_coefficients.empty()) {
    require_coefficients("end_coefficients", stroke.grid.end_coefficients, *nodes);
  }
  const SharedNumbers& growth = stroke.grid.growth;
  if (!growth.empty() && growth.size() != *nodes) {
    throw InvalidInput(
        fmt::format("\"growth\" must hold one number for each of the {} nodes that \"counts\" gives, got {}", *nodes,
                    growth.size()));
  }
  for (const double g : growth) require_finite("growth", g);
}

Flow flow_of(const GridStroke& stroke) {
  Segment segment;
  segment.grid = stroke.grid;
  return {{std::move(segment)}};
}

// The flow of v over the time `strength` is that of strength v over the unit of time.
void prolong(GridStroke& stroke, double strength) { stroke.grid = multiplied(std::move(stroke.grid), strength); }

}  // namespace

const Tool& GridStroke::tool() {
  static const Tool kTool = describe<GridStroke>("grid", {keys, validate, flow_of, nullptr, nullptr, nullptr, prolong});
  return kTool;
}

namespace {

using namespace tool_detail;

constexpr int kMaxIterations = 100;

std::vector<StrokeKey> keys(RelaxStroke& s) {
  return {{"points", Quantity::finite, &s.points},
          {"radius", Quantity::positive, &s.radius, Presence::required, "everything farther from each point stays"},
          {"amount", Quantity::other, &s.amount, Presence::optional, "how far vertices move towards the smooth shape"},
          {"surface", Quantity::other, &s.surface, Presence::optional,
           "of the amount, across the surface; 0 moves the vertices in the surface only"},
          {"iterations", Quantity::other, &s.iterations, Presence::optional, "at each point"}};
}

void validate(const RelaxStroke& stroke) {
  require_count("points", stroke.points.size(), 1, "points");
  if (!(stroke.amount > 0 && stroke.amount <= 1)) {
    throw InvalidInput(fmt::format("\"amount\" must be greater than 0 and at most 1, got {}", stroke.amount));
  }
  if (!(stroke.surface >= 0 && stroke.surface <= 1)) {
    throw InvalidInput(fmt::format("\"surface\" must be from 0 to 1, got {}", stroke.surface));
  }
  if (stroke.iterations < 1 || stroke.iterations > kMaxIterations) {
    throw InvalidInput(fmt::format("\"iterations\" must be from 1 to {}, got {}", kMaxIterations, stroke.iterations));
  }
}

// More than all of the distance is not smoother.
void prolong(RelaxStroke& stroke, double strength) { stroke.amount = std::min(stroke.amount * strength, 1.0); }

}  // namespace

const Tool& RelaxStroke::tool() {
  static const Tool kTool = [] {
    Tool tool = describe<RelaxStroke>("relax", {keys, validate, nullptr, nullptr, nullptr, nullptr, prolong});
    tool.is_flow = false;
    tool.is_event = true;
    return tool;
  }();
  return kTool;
}

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(MaskStroke& s) {
  return {{"points", Quantity::finite, &s.points, Presence::not_empty},
          {"vertices", Quantity::other, &s.vertices, Presence::not_empty},
          {"values", Quantity::finite, &s.values, Presence::optional},
          {"width", Quantity::positive, &s.width, Presence::optional, "from what stays to what is free"}};
}

void prepare(MaskStroke& /*stroke*/, const HasKey& has) {
  const bool is_null = !has("points") && (has("name") || has("off") || has("strength") || has("duration") ||
                                          has("new_entry"));  // with these
  if (has("points") != has("vertices") || is_null) return;
  throw InvalidInput(fmt::format(R"(a mask has either "points" or "vertices", {})",
                                 has("points") ? "not both" : "got neither; {\"mask\": null} removes it"));
}

void validate(const MaskStroke& stroke) {
  if (!stroke.points.empty() && !stroke.vertices.empty()) {
    throw InvalidInput("\"points\" must not be given together with \"vertices\"");
  }
  if (is_empty(stroke)) {
    if (stroke.width || !stroke.values.empty()) {
      throw InvalidInput("\"points\" or \"vertices\" is missing; without them there is no mask");
    }
    return;
  }
  if (!stroke.width) throw InvalidInput("\"width\" is missing; it must be a length greater than 0");
  for (const VertexRange& range : stroke.vertices) {
    if (range.last >= range.first) continue;
    throw InvalidInput(fmt::format("\"vertices\" must hold ranges [first, last] with first <= last, got [{}, {}]",
                                   range.first, range.last));
  }
  const std::size_t items = stroke.points.size() + stroke.vertices.size();
  if (!stroke.values.empty() && stroke.values.size() != items) {
    throw InvalidInput(fmt::format("\"values\" must hold a number for each of the {} items of \"{}\", got {}", items,
                                   stroke.points.empty() ? "vertices" : "points", stroke.values.size()));
  }
  for (const double value : stroke.values) {
    if (value >= 0 && value <= 1) continue;
    throw InvalidInput(fmt::format("\"values\" must hold numbers from 0 (free) to 1 (stays), got {}", value));
  }
}

Flow flow_of(const MaskStroke& /*stroke*/) { return {}; }

bool reads_surface(const MaskStroke& stroke) { return !stroke.vertices.empty(); }

}  // namespace

Mask mask_of(const MaskStroke& stroke, int threads) {
  validate(stroke);
  if (reads_surface(stroke)) throw InvalidInput("this mask reads the surface, so resolve it first");
  return is_empty(stroke) ? Mask() : Mask(stroke.points, stroke.values, *stroke.width, threads);
}

const Tool& MaskStroke::tool() {
  static const Tool kTool = [] {
    Tool tool = describe<MaskStroke>("mask", {keys, validate, flow_of, nullptr, reads_surface, prepare});
    tool.is_event = true;
    return tool;
  }();
  return kTool;
}

}  // namespace knead
