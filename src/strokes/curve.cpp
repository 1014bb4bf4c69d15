// The tool "curve": takes a line through a shape to another curve, and the shape with it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/vec.h"
#include "strokes/curve.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

std::vector<StrokeKey> keys(CurveStroke& s) {
  return {
      {"from", Quantity::other, &s.from, Presence::optional, "a line through the shape"},
      {"to", Quantity::other, &s.to, Presence::optional, "where the line goes"},
      {"twist_deg", Quantity::rate, &s.twist_deg, Presence::optional, "of the end against the start"},
      {"longer_by", Quantity::finite, &s.longer_by, Presence::optional, "length that the line gains; below 0: loses"},
      {"thicker_by", Quantity::finite, &s.thicker_by, Presence::optional, "across the line; below 0: thinner"},
      {"thickness", Quantity::positive, &s.thickness, Presence::optional, "that the shape gets across the line"},
      {"thickness_before", Quantity::positive, &s.thickness_before, Presence::optional, "left out: measured"},
      {"taper", Quantity::other, &s.taper, Presence::optional, "from the line's start to its end and beyond"},
      {"angle_deg", Quantity::angle, &s.angle_deg, Presence::optional, "of the arc that the line becomes"},
      {"around", Quantity::rate, &s.around, Presence::optional, "the arc's radius; below 0: clockwise"},
      {"axis", Quantity::direction, &s.axis, Presence::optional, "of the arc"},
      {"length", Quantity::other, choice(s.length, {"keep", "fit"}), Presence::optional},
      {"fixed", Quantity::other, choice(s.fixed, {"middle", "start", "end"}), Presence::optional},
      {"keep", Quantity::other, choice(s.keep, {"volume", "thickness", "length"}), Presence::optional},
      {"radius", Quantity::positive, AutoNumber{&s.radius, &s.radius_auto}, Presence::optional,
       "only what is nearer to the line moves"}};
}

bool is_arc(const CurveStroke& stroke) { return stroke.angle_deg || stroke.around; }

void require_line(std::string_view key, const std::vector<Vec3d>& points) {
  if (points.empty()) return;
  require_finite(key, points);
  require_count(key, points.size(), 2, "points");
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    if (points[i] == points[i + 1]) {
      throw InvalidInput(fmt::format("\"{}\" repeats the point [{:g}, {:g}, {:g}]; give each once", key, points[i].x,
                                     points[i].y, points[i].z));
    }
  }
}

void require_thickness_alone(const CurveStroke& stroke) {
  if (!changes_thickness(stroke)) {
    if (stroke.taper) throw InvalidInput(R"("taper" needs "thickness" or "thicker_by")");
    if (stroke.keep == CurveKeeps::length) {
      throw InvalidInput(R"("keep" "length" needs "thickness" or "thicker_by"; give "volume" or "thickness")");
    }
    return;
  }
  const char* const key = stroke.thickness ? "thickness" : "thicker_by";
  if (stroke.thickness && stroke.thicker_by != 0) {
    throw InvalidInput(R"("thickness" and "thicker_by" exclude each other; give one of them)");
  }
  if (is_arc(stroke) || !stroke.to.empty() || stroke.twist_deg != 0 || stroke.longer_by != 0) {
    throw InvalidInput(
        fmt::format("\"{}\" goes with no bend, twist or \"longer_by\"; give these in another stroke", key));
  }
  if (stroke.keep == CurveKeeps::thickness) {
    throw InvalidInput(fmt::format("\"keep\" must be \"volume\" or \"length\" with \"{}\", not \"thickness\"", key));
  }
}

void require_one_aim(const CurveStroke& stroke) {
  const int aims = (stroke.to.empty() ? 0 : 1) + (stroke.angle_deg ? 1 : 0) + (stroke.around ? 1 : 0);
  if (aims > 1) throw InvalidInput(R"("to", "angle_deg" and "around" exclude each other; give one of them)");
  if (aims == 0 && stroke.twist_deg == 0 && stroke.longer_by == 0 && !changes_thickness(stroke)) {
    throw InvalidInput(
        R"("to" is missing; give it, or "angle_deg", "around", "twist_deg", "longer_by", "thicker_by" or "thickness")");
  }
  if (stroke.longer_by != 0 && (stroke.around || !stroke.to.empty())) {
    throw InvalidInput(R"("longer_by" goes with "angle_deg" or "twist_deg", not with "to" or "around")");
  }
  if (stroke.length == CurveLength::fit && stroke.to.empty()) {
    throw InvalidInput(R"("length" "fit" needs a curve "to", to whose ends the shape is stretched)");
  }
  if (stroke.radius && stroke.from.size() > 2) {
    throw InvalidInput(R"("radius" needs a straight line "from" of two points)");
  }
  if (stroke.axis && !is_arc(stroke) && !changes_thickness(stroke)) {
    throw InvalidInput(R"("axis" needs "angle_deg", "around", "thickness" or "thicker_by")");
  }
  require_thickness_alone(stroke);
}

void validate(const CurveStroke& stroke) {
  require_line("from", stroke.from);
  require_line("to", stroke.to);
  require_one_aim(stroke);
  require_angle("twist_deg", stroke.twist_deg);
  if (stroke.angle_deg) require_angle("angle_deg", *stroke.angle_deg);
  if (stroke.around && *stroke.around == 0) throw InvalidInput("\"around\" must be a radius other than 0, got 0");
  if (stroke.from.empty()) return;
  if (is_arc(stroke) && !stroke.axis) {
    throw InvalidInput(R"("axis" is missing; the arc of a given line "from" turns about it)");
  }
  if (!stroke.axis) return;
  const Vec3d axis = unit(*stroke.axis);
  const Vec3d along = unit(stroke.from.back() - stroke.from.front());
  constexpr double kAlongside = 1e-3;
  if (norm(cross(axis, along)) < kAlongside) {
    throw InvalidInput(R"("axis" must lie across the line "from", not along it)");
  }
}

bool reads_surface(const CurveStroke& stroke) {
  return stroke.from.empty() || stroke.radius_auto || (changes_thickness(stroke) && !stroke.thickness_before);
}

Flow flow_of(const CurveStroke& stroke) {
  Segment segment;
  segment.curve = motion_of(stroke);
  return {{std::move(segment)}};
}

// The directions of the coordinate axes along the shape's box, the longest first; the first of equal ones.
std::array<std::size_t, 3> by_extent(const Vec3d& extent) {
  std::array<std::size_t, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return extent[a] > extent[b]; });
  return order;
}

Vec3d unit_vector(std::size_t axis) {
  Vec3d v{0, 0, 0};
  v[axis] = 1;
  return v;
}

// Places a stroke without "from" by the shape's box. The line is its longest axis across the arc's axis; the arc turns
// towards the side on which the shape is thinnest. The line begins beyond the box, so that all of the shape has the
// same curvature, twist and stretch; a cylinder touches the shape from outside.
CurveStroke placed(CurveStroke stroke, const Box& box) {
  const Vec3d extent = box.max - box.min;
  const bool has_radius = stroke.radius || stroke.radius_auto;
  std::array<std::size_t, 3> order = by_extent(extent);
  if (stroke.axis) {
    const Vec3d a = unit(*stroke.axis);
    if (std::abs(a[order[0]]) > 0.9) std::swap(order[0], order[1]);
  }
  const Vec3d along = unit_vector(order[0]);
  if (!(extent[order[0]] > 0)) throw InvalidInput(R"("from" is missing; this shape has no length, so give the line)");
  if (is_arc(stroke) && !stroke.axis) {
    const Vec3d thin = unit_vector(order[2]);
    stroke.axis = stroke.around ? cross(thin, along) : cross(along, thin);
  }
  Vec3d center = box.center();
  double half = 0.5 * extent[order[0]];
  if (stroke.around) {
    const Vec3d inwards = normalized(cross(unit(*stroke.axis), along)) * (*stroke.around > 0 ? 1.0 : -1.0);
    for (std::size_t axis = 0; axis < 3; ++axis) center[axis] += 0.5 * extent[axis] * inwards[axis];
  }
  if (stroke.taper) {
    stroke.from = {center - along * half, center + along * half};
    return stroke;
  }
  // A line of two points, as a radius needs, has long ramps, or none in which a curve could begin.
  if (!has_radius || stroke.to.empty()) {
    const int intervals = has_radius ? kArcIntervals : kPathIntervals;
    const double longer = static_cast<double>(intervals) / (intervals - 2 * kArcRamp);
    const double turned = static_cast<double>(intervals - 3) / (intervals - 2 * kArcRamp);
    half *= longer;
    stroke.twist_deg *= turned;
    stroke.longer_by *= turned;
    if (stroke.angle_deg) *stroke.angle_deg *= turned;
  }
  const Vec3d by = along * half;
  stroke.from = has_radius ? std::vector{center - by, center + by} : line_with_ramps(center, by, !stroke.to.empty());
  return stroke;
}

void resolve(const CurveStroke& given, SurfaceRun& run) {
  CurveStroke own = given;
  if (own.from.empty()) own = placed(std::move(own), bounding_box(run.surface.positions));
  if (own.radius_auto) find_radius(own, run.surface, run.remarks);
  if (changes_thickness(own)) find_thickness(own, run.surface, run.remarks);
  check_curve(own, given, run.surface);
  run.surface.apply(own);
}

void check(const CurveStroke& stroke, const LiveSurface& surface) { check_curve(stroke, stroke, surface); }

void prolong(CurveStroke& stroke, double strength) {
  if (!stroke.to.empty() || stroke.thickness) {
    throw InvalidInput(fmt::format("\"strength\" must be from 0 to 1 for a curve with \"{}\", got {}",
                                   stroke.thickness ? "thickness" : "to", strength));
  }
  stroke.twist_deg *= strength;
  stroke.longer_by *= strength;
  stroke.thicker_by *= strength;
  if (stroke.angle_deg) *stroke.angle_deg *= strength;
  if (stroke.around) *stroke.around /= strength;
}

std::string words(const CurveStroke& stroke, const std::string& unit) {
  std::vector<std::string> parts;
  if (stroke.angle_deg) parts.push_back("bend " + degrees_text(*stroke.angle_deg));
  if (stroke.around) parts.push_back("wrap round " + length_text(std::abs(*stroke.around), unit));
  if (!stroke.to.empty()) parts.push_back("bend along a curve");
  if (stroke.twist_deg != 0) parts.push_back("twist " + degrees_text(stroke.twist_deg));
  if (stroke.longer_by != 0) {
    parts.push_back((stroke.longer_by > 0 ? "stretch by " : "shorten by ") +
                    length_text(std::abs(stroke.longer_by), unit));
  }
  if (stroke.thicker_by != 0) {
    parts.push_back(fmt::format("{}{} by {}", stroke.taper ? "taper, " : "",
                                stroke.thicker_by > 0 ? "thicker" : "thinner",
                                length_text(std::abs(stroke.thicker_by), unit)));
  }
  if (stroke.thickness) {
    parts.push_back((stroke.taper ? "taper to " : "thickness of ") + length_text(*stroke.thickness, unit));
  }
  std::string text = fmt::format("{}", fmt::join(parts, ", "));
  text[0] = static_cast<char>(std::toupper(text[0]));
  return text;
}

}  // namespace

std::vector<Vec3d> longest_axis(const Box& box, std::size_t count) {
  if (!(box.diagonal() > 0)) return {};
  const std::vector<Vec3d> line = placed({}, box).from;
  return points_on_line({line.front(), line.back()}, count);
}

constinit const detail::ToolRow<CurveStroke> CurveStroke::tool{.name = "curve",
                                                               .keys = keys,
                                                               .validate = validate,
                                                               .reads_surface = reads_surface,
                                                               .resolve = resolve,
                                                               .reads_once = true,
                                                               .check = check,
                                                               .check_inverse = check_inverse_of_curve,
                                                               .flow = flow_of,
                                                               .words = words,
                                                               .prolong = prolong};

}  // namespace knead
