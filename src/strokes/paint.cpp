// The tool "paint": dabs along a path on the surface, and under a pointer.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "strokes/describe.h"
#include "strokes/suffix.h"
#include "strokes/surface_finder.h"

namespace knead {

namespace {

using namespace detail;

using Dabs = Growing<PaintStroke, &PaintStroke::samples>;

constexpr double kMaxPinch = 5;

constexpr std::size_t kPartsPerPiece = 16;
constexpr int kDabs = 6;                  // that add up to the full depth
constexpr double kProbe = 1e-3;           // of the radius: the distance of the points from which a normal follows
constexpr double kProbeTolerance = 1e-7;  // of the radius

// The curve through all points, in order: a cubic Hermite curve with centripetal parameters (Yuksel, Schaefer and
// Keyser 2011) and tangents of the parabolas through three neighbours, so that few points of a smooth curve give nearly
// the curve that many of them give (third order). A point that repeats the one before counts once.
class PathCurve {
 public:
  explicit PathCurve(std::span<const Vec3d> points);  // 1 or more

  double length() const { return lengths_.back(); }

  // The point at that arc length from the beginning, clamped to [0, length()].
  Vec3d at(double length) const;

 private:
  Vec3d on_piece(std::size_t piece, double fraction) const;

  std::vector<Vec3d> points_;
  std::vector<double> knots_;
  std::vector<Vec3d> tangents_;  // per unit of the knots
  std::vector<double> lengths_;  // at the ends of equal parts of every piece
};

// The derivative at the point i of the parabola through three neighbours among which it is; for two points, the line.
Vec3d parabola_tangent(const std::vector<Vec3d>& points, const std::vector<double>& knots, std::size_t i) {
  const std::size_t last = points.size() - 1;
  if (last == 0) return {0, 0, 0};
  if (last == 1) return (points[1] - points[0]) / (knots[1] - knots[0]);
  const std::size_t a = std::clamp<std::size_t>(i, 1, last - 1) - 1;
  const double h0 = knots[a + 1] - knots[a];
  const double h1 = knots[a + 2] - knots[a + 1];
  const Vec3d slope0 = (points[a + 1] - points[a]) / h0;
  const Vec3d slope1 = (points[a + 2] - points[a + 1]) / h1;
  const Vec3d half_curvature = (slope1 - slope0) / (h0 + h1);
  return slope0 + half_curvature * (2 * knots[i] - knots[a] - knots[a + 1]);
}

PathCurve::PathCurve(std::span<const Vec3d> points) : points_(points.begin(), points.end()) {
  points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
  knots_.push_back(0);
  for (std::size_t i = 1; i < points_.size(); ++i) {
    knots_.push_back(knots_.back() + std::sqrt(norm(points_[i] - points_[i - 1])));
  }
  for (std::size_t i = 0; i < points_.size(); ++i) tangents_.push_back(parabola_tangent(points_, knots_, i));
  lengths_.push_back(0);
  Vec3d previous = points_.front();
  for (std::size_t piece = 0; piece + 1 < points_.size(); ++piece) {
    for (std::size_t part = 1; part <= kPartsPerPiece; ++part) {
      const Vec3d p = on_piece(piece, static_cast<double>(part) / kPartsPerPiece);
      lengths_.push_back(lengths_.back() + norm(p - previous));
      previous = p;
    }
  }
}

Vec3d PathCurve::at(double length) const {
  if (points_.size() == 1 || length <= 0) return points_.front();
  if (length >= lengths_.back()) return points_.back();
  const auto after = std::upper_bound(lengths_.begin(), lengths_.end(), length);
  const auto part = static_cast<std::size_t>(after - lengths_.begin()) - 1;
  const double within = (length - lengths_[part]) / (lengths_[part + 1] - lengths_[part]);
  return on_piece(part / kPartsPerPiece, (static_cast<double>(part % kPartsPerPiece) + within) / kPartsPerPiece);
}

Vec3d PathCurve::on_piece(std::size_t piece, double fraction) const {
  const double h = knots_[piece + 1] - knots_[piece];
  const double s = fraction;
  const double rest = 1 - s;
  return points_[piece] * (rest * rest * (1 + 2 * s)) + points_[piece + 1] * (s * s * (3 - 2 * s)) +
         (tangents_[piece] * rest - tangents_[piece + 1] * s) * (h * s * rest);
}

bool is_wide(const PaintStroke& stroke) { return stroke.falloff == kWideFalloff; }

bool flattens(const PaintStroke& stroke) { return stroke.pinch < 0; }

constexpr double kMaxLift = 0.6;  // of the bump: a centre that is higher moves the surface no deeper
constexpr int kLiftSamples = 64;  // of a weight along a line
constexpr int kHalvings = 40;

// Returns the depth, in bumps and for each unit of pinch, of a row of pinching dabs whose centres are `lift` bumps
// above the surface. At x along the row a dab pushes with w + x^2 w' / (2 r), whose integral is half that of w; for a
// centre on the surface that is the length of a dab.
double depth_at(double lift, const Thresholds<double>& thresholds) {
  const double end = thresholds.outer / thresholds.bump;
  const auto weights_along = [&](double height) {
    double sum = 0;
    for (int i = 0; i < kLiftSamples; ++i) {
      const double x = end * (i + 0.5) / kLiftSamples;
      sum += wide_weight((x * x + height * height) * thresholds.bump * thresholds.bump, thresholds).value;
    }
    return sum;
  };
  return lift * weights_along(lift) / weights_along(0);
}

// Returns the height of the dabs' centres above the surface: above 0, outside, if they press in.
double lift_of(const PaintStroke& stroke) {
  if (stroke.depth == 0) return 0;
  const Thresholds<double> thresholds = thresholds_of(stroke);
  const double wanted = std::abs(stroke.depth / stroke.pinch) / thresholds.bump;
  double low = 0;
  double high = kMaxLift;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (depth_at(middle, thresholds) < wanted ? low : high) = middle;
  }
  return (stroke.depth / stroke.pinch > 0 ? low : -low) * thresholds.bump;
}

// Returns the radius of the part that moves along with a dab.
double radius_of(const PaintStroke& stroke) { return is_wide(stroke) ? stroke.bump : stroke.outer; }

std::vector<StrokeKey> keys(PaintStroke& s) {
  const bool wide = is_wide(s);
  return {{"outer", wide ? Quantity::other : Quantity::positive, &s.outer,
           wide ? Presence::optional : Presence::required, wide ? kOuterHelp : "radius of one dab"},
          {"bump", Quantity::positive, wide ? &s.bump : nullptr, Presence::required, "radius of one dab", kWide},
          {"depth", Quantity::other, &s.depth, s.pinch == 0 ? Presence::required : Presence::optional,
           "how far one dab moves the surface; negative pulls it out"},
          {"pinch", Quantity::other, wide ? &s.pinch : nullptr, Presence::optional,
           "draws the surface together, by that logarithm; negative flattens it", kWide},
          {"samples", Quantity::other, s.path.empty() ? &s.samples : nullptr},
          {"path", Quantity::finite, &s.path, Presence::not_empty}};
}

void prepare(PaintStroke& stroke, const HasKey& has) {
  if (has("pinch")) stroke.pinch = 1;  // so that "depth" may be left out
  if (!has("path")) return;
  if (has("samples")) throw InvalidInput(R"(a paint stroke has either "samples" or "path", not both)");
  stroke.path.resize(1);  // so that "samples" does not apply
}

void require_pinch(const PaintStroke& stroke) {
  if (!is_wide(stroke)) throw InvalidInput(R"("pinch" needs "falloff": "wide")");
  if (!(std::abs(stroke.pinch) <= kMaxPinch)) {
    throw InvalidInput(fmt::format("\"pinch\" must be a number from -{0} to {0}, got {1}", kMaxPinch, stroke.pinch));
  }
  const double most = std::abs(stroke.pinch) * stroke.bump * depth_at(kMaxLift, thresholds_of(stroke));
  if (std::abs(stroke.depth) <= most) return;
  throw InvalidInput(
      fmt::format("\"depth\" must be a number from -{0:.3g} to {0:.3g} with this \"bump\" and \"pinch\", "
                  "got {1}",
                  rounded_down(most), stroke.depth));
}

void validate(const PaintStroke& stroke) {
  if (!std::isfinite(stroke.depth) || (stroke.depth == 0 && stroke.pinch == 0)) {
    throw InvalidInput(fmt::format(
        "\"depth\" must be a number other than 0 (greater pushes in, less pulls out), got {}", stroke.depth));
  }
  if (is_wide(stroke)) require_wide_thresholds(thresholds_of(stroke));
  if (stroke.pinch != 0) require_pinch(stroke);
  if (stroke.path.empty()) require_count("samples", stroke.samples.size(), 1, "samples");
  for (const PaintSample& sample : stroke.samples) {
    require_finite("point", sample.point);
    require_direction("normal", sample.normal);
  }
}

bool reads_surface(const PaintStroke& stroke) { return !stroke.path.empty(); }

// pinch (3 n n^T - I) / 2
Flow pinching_flow(const PaintStroke& stroke) {
  const double lift = lift_of(stroke);
  Flow flow;
  for (const PaintSample& sample : stroke.samples) {
    const Vec3d n = unit(sample.normal);
    const Mat3d shape = outer_product(n, n) * 1.5 + Mat3d{} * -0.5;
    flow.segments.push_back(resting_segment(
        {sample.point + n * lift, Strain<double>{shape * stroke.pinch}, Ball<double>{}, thresholds_of(stroke)}));
  }
  return flow;
}

Flow flow_of(const PaintStroke& stroke) {
  if (stroke.pinch != 0) return pinching_flow(stroke);
  Flow flow;
  for (const PaintSample& sample : stroke.samples) {
    const Vec3d displacement = unit(sample.normal) * -stroke.depth;
    flow.segments.push_back(transported_segment(
        {sample.point, Translation<double>{displacement}, Ball<double>{}, thresholds_of(stroke)}, displacement));
  }
  return flow;
}

void prolong(PaintStroke& stroke, double strength) {
  stroke.depth *= strength;
  stroke.pinch *= strength;
}

void resolve(const PaintStroke& stroke, SurfaceRun& run) { paint_on(stroke, run.surface); }

std::size_t segments(const PaintStroke& stroke, const Mesh* /*mesh*/) {
  return stroke.path.empty() ? stroke.samples.size() : paint_dabs(stroke).aims.size();
}

const char* verb_of(const PaintStroke& stroke) {
  if (flattens(stroke)) return "Flatten";
  if (stroke.pinch == 0) return stroke.depth > 0 ? "Press in" : "Paint";
  if (stroke.depth == 0) return "Pinch";
  return stroke.depth > 0 ? "Crease" : "Ridge";
}

std::string words(const PaintStroke& stroke, const std::string& /*unit*/) {
  const std::size_t dabs = stroke.samples.size() + stroke.path.size();
  return fmt::format("{}, {}", verb_of(stroke), dabs == 1 ? "1 dab" : fmt::format("{} dabs", dabs));
}

bool continues(const PaintStroke& last, const PaintStroke& next) {
  return last.path.empty() && next.path.empty() && last.outer == next.outer && last.depth == next.depth &&
         last.falloff == next.falloff && last.bump == next.bump && last.pinch == next.pinch;
}

// Returns the sample of a place on the original surface, at its present position after the dabs so far.
PaintSample carried(const PaintSample& at, const PaintDrag& drag) {
  const double radius = radius_of(drag.stroke);
  const Vec3d u = any_orthogonal(at.normal);
  const Vec3d v = cross(at.normal, u);
  std::array<Vec3d, 3> points{at.point, at.point + u * (kProbe * radius), at.point + v * (kProbe * radius)};
  AdvectOptions options;
  options.tolerance = kProbeTolerance * radius;
  options.precision = Precision::float64;
  options.threads = 1;
  advect(drag.done, points, options);
  const Vec3d normal = cross(points[1] - points[0], points[2] - points[0]);
  return {points[0], norm(normal) > 0 ? normalized(normal) : at.normal};
}

// Continues with another radius; the depth of a dab is relative to it.
void set_radius(double radius, PaintDrag& drag) {
  PaintStroke& stroke = drag.stroke;
  if (radius_of(stroke) == radius) return;
  if (!stroke.samples.empty()) drag.earlier.push_back(stroke);
  stroke.samples.clear();
  const double factor = radius / radius_of(stroke);
  stroke.depth *= factor;
  drag.spacing *= factor;
  stroke.outer = is_wide(stroke) ? stroke.outer * factor : radius;
  if (is_wide(stroke)) stroke.bump = radius;
}

void add_dab(const PaintTouch& touch, PaintDrag& drag) {
  set_radius(touch.radius, drag);
  PaintStroke dab = drag.stroke;
  dab.samples = {carried(drag.plane ? drag.plane(touch.at, touch.radius) : touch.at, drag)};
  drag.stroke.samples.push_back(dab.samples.front());
  Flow flow = flow_of(dab);
  std::move(flow.segments.begin(), flow.segments.end(), std::back_inserter(drag.done.segments));
}

constexpr double kDefaultDab = 17.0 / 35;

// The dab_length() as a part of the radius.
double relative_dab(const PaintStroke& stroke) {
  constexpr std::array kLengths{81.0 / 140, kDefaultDab, 181.0 / 462, 47.0 / 143, 81.0 / 286};
  if (!is_wide(stroke)) return kLengths[static_cast<std::size_t>(stroke.falloff - kMinFalloff)];
  const double outer = thresholds_of(stroke).outer;
  return 16.0 / 15 * outer / (outer + stroke.bump);
}

}  // namespace

double dab_length(const PaintStroke& stroke) { return relative_dab(stroke) * radius_of(stroke); }

PaintDabs paint_dabs(const PaintStroke& stroke) {
  constexpr double kSpacing =
      1.0 / 8;  // of the radius: of the dabs of the default falloff, and the greatest depth of one
  constexpr double kMaxDabs = 1e6;
  const PathCurve curve(stroke.path);
  const double radius = radius_of(stroke);
  const double doses = std::max(curve.length() / dab_length(stroke), 1.0);
  const double spacing = kSpacing * (relative_dab(stroke) / kDefaultDab);
  const double by_length = std::ceil(curve.length() / (spacing * radius));
  const double by_depth = std::ceil(doses * std::abs(stroke.depth) / (kSpacing * radius));
  const double by_pinch = std::ceil(doses * std::abs(stroke.pinch) / kSpacing);
  const double count = curve.length() > 0 ? std::max({by_length, by_depth, by_pinch}) : 1;
  if (!(count <= kMaxDabs)) {
    throw InvalidInput(
        fmt::format("\"path\" is {:.3g} long and would need {:.3g} dabs, more than {:.0f}; make \"{}\" "
                    "larger, or \"depth\" smaller",
                    curve.length(), count, kMaxDabs, is_wide(stroke) ? "bump" : "outer"));
  }
  PaintDabs dabs{{}, doses};
  for (double i = 0; i < count; ++i) dabs.aims.push_back(curve.at(curve.length() * ((i + 0.5) / count)));
  return dabs;
}

PaintSample mean_plane(std::span<const Triangle> triangles, const std::function<Vec3d(std::uint32_t)>& position,
                       const PaintSample& at, double radius) {
  Vec3d middle{0, 0, 0};
  Vec3d normal{0, 0, 0};
  double areas = 0;
  for (const Triangle& t : triangles) {
    const Vec3d a = position(t[0]);
    const Vec3d b = position(t[1]);
    const Vec3d c = position(t[2]);
    const Vec3d place = (a + b + c) / 3;
    if (!(norm2(place - at.point) < radius * radius)) continue;
    const Vec3d twice = cross(b - a, c - a);
    if (!(dot(twice, at.normal) > 0)) continue;
    const double area = norm(twice);
    middle += place * area;
    normal += twice;
    areas += area;
  }
  return areas > 0 && norm(normal) > 0 ? PaintSample{middle / areas, normalized(normal)} : at;
}

void paint_on(const PaintStroke& stroke, const LiveSurface& surface) {
  if (surface.triangles.empty() && !surface.normal) {
    throw InvalidInput(
        "\"path\" needs a surface, or a point cloud with normals; give \"samples\" with normals instead");
  }
  constexpr double kMoreThanRounding = 1.001;  // a float's rounding of a distance, in which vertices may move as well
  const PaintDabs dabs = paint_dabs(stroke);
  SurfaceFinder finder(surface);
  const auto position = [&](std::uint32_t vertex) { return surface.positions[vertex]; };
  PaintStroke dab = stroke;
  dab.path.clear();
  dab.depth = stroke.depth * dabs.doses / static_cast<double>(dabs.aims.size());
  dab.pinch = stroke.pinch * dabs.doses / static_cast<double>(dabs.aims.size());
  const double beyond = std::abs(stroke.pinch == 0 ? dab.depth : lift_of(stroke));
  for (const Vec3d& aim : dabs.aims) {
    std::optional<PaintSample> sample = finder.closest(aim);
    if (!sample)
      throw InvalidInput("\"path\" leads to a place where the surface has no normal; give \"samples\" instead");
    if (flattens(stroke)) sample = mean_plane(surface.triangles, position, *sample, radius_of(stroke));
    dab.samples = {*sample};
    if (!surface.apply(dab)) return;
    finder.follow(sample->point, kMoreThanRounding * (thresholds_of(stroke).outer + beyond));
  }
}

constinit const detail::ToolRow<PaintStroke> PaintStroke::tool{.name = "paint",
                                                               .keys = keys,
                                                               .prepare = prepare,
                                                               .validate = validate,
                                                               .reads_surface = reads_surface,
                                                               .resolve = resolve,
                                                               .flow = flow_of,
                                                               .segments = segments,
                                                               .words = words,
                                                               .prolong = prolong,
                                                               .grows = Dabs::grows,
                                                               .rest = Dabs::rest,
                                                               .continues = continues,
                                                               .join = Dabs::join,
                                                               .interleaved = Dabs::interleaved};

std::vector<Stroke> PaintDrag::strokes() const {
  std::vector<Stroke> all(earlier.begin(), earlier.end());
  all.emplace_back(stroke);
  return all;
}

PaintDrag begin_paint(const PaintStroke& stroke, const PaintTouch& touch, PaintPlane plane) {
  PaintDrag drag;
  drag.stroke = stroke;
  drag.plane = std::move(plane);
  drag.stroke.depth = stroke.depth / kDabs;
  drag.stroke.pinch = stroke.pinch / kDabs;
  drag.spacing = dab_length(stroke) / kDabs;
  drag.last = touch.at.point;
  add_dab(touch, drag);
  return drag;
}

void drag_paint(PaintDrag& drag, const PaintTouch& touch) {
  drag.travelled += norm(touch.at.point - drag.last) * touch.pressure;
  drag.last = touch.at.point;
  if (drag.travelled < drag.spacing) return;
  drag.travelled = std::min(drag.travelled - drag.spacing, drag.spacing);
  add_dab(touch, drag);
}

void end_paint(PaintDrag& drag) {
  if (drag.stroke.samples.size() + drag.earlier.size() > 1) return;
  drag.stroke.samples.resize(kDabs, drag.stroke.samples.front());
}

}  // namespace knead
