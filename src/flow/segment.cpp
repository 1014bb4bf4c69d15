// Checks of flows, parts and inverses of flows, and the coefficients of Runge-Kutta methods.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "field/grid.h"
#include "flow/segment_map.h"
#include "knead/error.h"
#include "knead/flow.h"

namespace knead {

namespace {

constexpr double kUnitTolerance = 1e-9;

// Throws InvalidInput with the message unless `good`.
void require(bool good, const char* message) {
  if (!good) throw InvalidInput(message);
}

bool is_unit(const Vec3d& v) { return is_finite(v) && std::abs(norm2(v) - 1) < kUnitTolerance; }

void check(const Translation<double>& m) {
  require(is_finite(m.velocity) && is_finite(m.axis) && std::isfinite(m.gauge),
          "a translation has a number that is not finite");
  require(m.gauge == 1 || is_unit(m.axis), "a translation with a gauge other than 1 needs an axis of unit length");
}

void check(const Rotation<double>& m) {
  require(std::isfinite(m.rate) && std::isfinite(m.gauge), "a rotation has a number that is not finite");
  require(is_unit(m.axis), "a rotation's axis must be of unit length");
}

void check(const Twist<double>& m) {
  require(std::isfinite(m.rate) && std::isfinite(m.gauge), "a twist has a number that is not finite");
  require(is_unit(m.axis), "a twist's axis must be of unit length");
}

void check(const Strain<double>& m) {
  const double size = row_sum_norm(m.matrix);
  require(std::isfinite(size), "a strain has a number that is not finite");
  require(std::abs(trace(m.matrix)) <= kUnitTolerance * size, "a strain's matrix must be traceless");
}

void check(const CustomMotion& m) { require(m.evaluate != nullptr, "a custom motion has no function"); }

void check(const Ball<double>& /*r*/) {}

void check(const Capsule<double>& r) { require(is_finite(r.half_axis), "a capsule's half axis is not finite"); }

void check(const HalfSpace<double>& r) {
  require(std::isfinite(r.turn_angle), "a half-space has a number that is not finite");
  require(is_unit(r.normal), "a half-space's normal must be of unit length");
  require(r.turn_angle == 0 || is_unit(r.turn_axis), "a turning half-space's axis must be of unit length");
}

void check(const PointSet<double>& r) {
  require(!r.points.empty() || !r.curves.empty(), "a point set is empty");
  require(r.exponent >= 2 && r.exponent % 2 == 0, "a point set's exponent must be an even number of at least 2");
  require(std::all_of(r.points.begin(), r.points.end(), is_finite), "a point set has a number that is not finite");
  for (const std::vector<Vec3d>& curve : r.curves) {
    require(curve.size() >= 2, "a curve needs two or more points");
    require(std::all_of(curve.begin(), curve.end(), is_finite), "a curve has a number that is not finite");
    require(std::adjacent_find(curve.begin(), curve.end()) == curve.end(), "a curve repeats a point");
  }
}

void check(const Handles<double>& r) {
  check(r.full);
  check(r.zero);
  require(is_finite(r.sweep) && std::isfinite(r.turn_angle), "handles have a number that is not finite");
  require(r.turn_angle == 0 || is_unit(r.turn_axis), "the axis of turning handles must be of unit length");
}

void check(const CustomRegion& r) {
  require(r.evaluate != nullptr, "a custom region has no function");
  require(r.slope > 0 && r.speed >= 0, "a custom region needs a positive bound of its slope");
}

void check_pin(const Field& field, const Segment& segment) {
  const auto* motion = std::get_if<Translation<double>>(&field.motion);
  require(motion != nullptr && motion->gauge == 1 && std::holds_alternative<Ball<double>>(field.region),
          "a pin must be the translation of a ball");
  require(field.thresholds == Thresholds<double>{0, segment.fields.front().thresholds.outer, kPinFalloff},
          "pins must have inner = 0, the falloff of pins, and the same outer");
  require(segment.displacement == Vec3d{} && !segment.limit_cylinder,
          "a segment of pins has no displacement and no limit cylinder");
}

void check_wide(const Field& field) {
  const auto& [inner, outer, falloff, bump] = field.thresholds;
  require(std::holds_alternative<Ball<double>>(field.region), "only a ball has the wide falloff");
  require(inner >= 0 && inner < bump && bump < outer, "a wide ball needs 0 <= inner < bump < outer");
}

void check(const Field& field, const Segment& segment) {
  require(is_finite(field.center), "a field's centre is not finite");
  require(field.thresholds.inner < field.thresholds.outer, "a field's inner threshold must be below its outer one");
  const bool is_pin = segment.time_law == TimeLaw::pinned;
  if (is_pin) check_pin(field, segment);
  const int falloff = field.thresholds.falloff;
  if (falloff == kWideFalloff) check_wide(field);
  require(is_pin || falloff == kWideFalloff || (falloff >= kMinFalloff && falloff <= kGreatestFalloff),
          "a field's falloff must be a whole number from 3 to 7, or wide");
  std::visit([](const auto& motion) { check(motion); }, field.motion);
  std::visit([](const auto& region) { check(region); }, field.region);
  if (const auto* handles = std::get_if<Handles<double>>(&field.region)) {
    require(handles->sweep == segment.displacement, "the sweep of handles must be the segment's displacement");
  }
  if (segment.time_law == TimeLaw::blended) {
    const bool region =
        std::holds_alternative<Ball<double>>(field.region) || std::holds_alternative<Capsule<double>>(field.region);
    require(region && std::holds_alternative<Translation<double>>(field.motion),
            "only a translation of a ball or capsule can be blended in time");
  }
}

void check(const PotentialGrid& grid) {
  require(is_finite(grid.origin) && std::isfinite(grid.spacing), "a grid has a number that is not finite");
  require(grid.spacing > 0, "a grid's spacing must be greater than 0");
  const std::optional<std::size_t> nodes = detail::node_count(grid.counts);
  require(nodes.has_value(), "a grid has 1 or more nodes along each axis, and 16 million at most");
  const auto fits = [&](const SharedVectors& list) { return list.size() == *nodes; };
  require(fits(grid.coefficients) && (grid.end_coefficients.empty() || fits(grid.end_coefficients)) &&
              (grid.growth.empty() || grid.growth.size() == *nodes),
          "a grid has one coefficient for each node");
  for (const SharedVectors& list : {grid.coefficients, grid.end_coefficients}) {
    require(std::all_of(list.begin(), list.end(), is_finite), "a grid has a coefficient that is not finite");
  }
  require(std::all_of(grid.growth.begin(), grid.growth.end(), [](double g) { return std::isfinite(g); }),
          "a grid has a coefficient that is not finite");
}

void check(const CurveMotion& curve) {
  const Mat3d& frame = curve.frame;
  const bool is_right = is_unit(frame.row0) && is_unit(frame.row1) && std::abs(determinant(frame) - 1) < kUnitTolerance;
  require(curve.length > 0 && std::isfinite(curve.length), "a curve's length must be greater than 0");
  require(curve.anchor >= 0 && curve.anchor <= curve.intervals(), "a curve's anchor must lie on it");
  require(is_finite(curve.place) && is_finite(curve.shift) && is_finite(curve.turn),
          "a curve has a number that is not finite");
  require(is_right && norm(cross(frame.row0, frame.row1) - frame.row2) < kUnitTolerance,
          "a curve's frame must be right-handed, of unit vectors at right angles");
  require(!curve.radius || *curve.radius > 0, "a curve's radius must be greater than 0");
  require(curve.part[0] < curve.part[1] && curve.part[0] < curve.length && curve.part[1] > 0,
          "the part of a curve must lie on it");
  for (const CurveNode& node : curve.nodes) {
    const std::array<double, 5> numbers{node.rest[0], node.rest[1], node.bent[0], node.bent[1], node.twist};
    require(std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); }),
            "a curve has a number that is not finite");
    require(node.stretch > -1 && std::isfinite(node.stretch), "a curve's stretch must be above -1");
    require(node.twist == 0 || !curve.one_across, "a curve that twists stretches alike in both directions across");
  }
  require(curve.end_stretch > -1 && std::isfinite(curve.end_stretch), "a curve's stretch must be above -1");
}

void check(const LatticeMotion& lattice) {
  const Mat3d& axes = lattice.axes;
  require(is_finite(lattice.origin) && is_finite(lattice.lengths), "a lattice has a number that is not finite");
  require(is_unit(axes.row0) && is_unit(axes.row1) && is_unit(axes.row2) &&
              std::abs(std::abs(determinant(axes)) - 1) < kUnitTolerance,
          "a lattice's axes must be unit vectors at right angles");
  std::size_t points = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require(lattice.lengths[axis] > 0, "a lattice's edges must be longer than 0");
    const int count = lattice.counts[axis];
    require(count >= 2 && count <= LatticeMotion::kMaxCount, "a lattice has 2 to 64 control points along each edge");
    const int degree = lattice.degrees[axis];
    require(degree >= 1 && degree < count && degree <= LatticeMotion::kMaxDegree,
            "a lattice's degrees are from 1 to 15, and below its counts");
    points *= static_cast<std::size_t>(count);
  }
  require(lattice.displacements.size() == points, "a lattice has a displacement for each control point");
  require(std::all_of(lattice.displacements.begin(), lattice.displacements.end(), is_finite),
          "a lattice has a number that is not finite");
}

void check_turns(const Segment& segment) {
  require(segment.turns.empty() || segment.time_law == TimeLaw::pinned, "only a segment of pins has turns");
  for (std::size_t i = 0; i < segment.turns.size(); ++i) {
    const PinTurn& turn = segment.turns[i];
    require(turn.pin < segment.fields.size(), "a turn is none of a pin's");
    require(i == 0 || segment.turns[i - 1].pin < turn.pin, "the pins of turns must ascend");
    require(is_finite(turn.rate), "a turn has a number that is not finite");
  }
}

// One of the kinds that are a segment of their own: a grid, a curve or a lattice.
void check_whole(const Segment& segment) {
  if (!segment.curve.is_empty()) check(segment.curve);
  if (!segment.grid.is_empty()) check(segment.grid);
  if (!segment.lattice.is_empty()) check(segment.lattice);
  const int kinds =
      (segment.curve.is_empty() ? 0 : 1) + (segment.grid.is_empty() ? 0 : 1) + (segment.lattice.is_empty() ? 0 : 1);
  require(kinds == 1, "a segment has a grid, a curve or a lattice, not two of them");
  require(segment.fields.empty() && segment.displacement == Vec3d{} && segment.time_law == TimeLaw::swept &&
              !segment.limit_cylinder && segment.turns.empty(),
          "a segment with a grid of potentials, a curve or a lattice has no fields, no displacement, no limit cylinder "
          "and no turns");
}

void check(const Segment& segment);

void check_parts(const Segment& segment) {
  require(segment.parts.size() >= 2 && segment.parts.size() <= kMaxParts, "a sum has 2 to 8 parts");
  require(segment.fields.empty() && segment.grid.is_empty() && !detail::is_map(segment) &&
              segment.displacement == Vec3d{} && !segment.limit_cylinder && segment.time_law == TimeLaw::swept &&
              segment.turns.empty(),
          "a sum has no fields, no grid, no displacement, no limit cylinder and no turns of its own");
  for (const Segment& part : segment.parts) {
    require(part.parts.empty() && part.time_law != TimeLaw::pinned && !detail::is_map(part),
            "a part of a sum is neither a sum nor pinned, a curve or a lattice");
    require(part.mask.is_empty() && part.begin == 0 && part.end == 1,
            "a part of a sum has the mask, the beginning and the end of the whole");
    check(part);
  }
}

void check(const Segment& segment) {
  if (!segment.parts.empty()) check_parts(segment);
  for (const std::optional<double>& at : segment.mirrored_at) {
    require(!at || (std::isfinite(*at) && (!segment.parts.empty() || segment.time_law == TimeLaw::pinned)),
            "only a sum and pins are mirrored, at a finite coordinate");
  }
  const bool is_whole = !segment.grid.is_empty() || detail::is_map(segment);
  if (is_whole) check_whole(segment);
  require(is_whole || !segment.fields.empty() || !segment.parts.empty(), "it has no field");
  require(is_finite(segment.displacement), "its displacement is not finite");
  const auto in_unit = [](double t) { return t >= 0 && t <= 1; };
  require(in_unit(segment.begin) && in_unit(segment.end), "begin and end must lie in [0, 1]");
  if (segment.limit_cylinder) {
    require(is_finite(segment.limit_cylinder->center) && is_unit(segment.limit_cylinder->axis) &&
                segment.limit_cylinder->radius > 0,
            "its limit cylinder needs a direction of unit length and a positive radius");
  }
  for (const Field& field : segment.fields) check(field, segment);
  check_turns(segment);
}

using Row = std::vector<double>;

Tableau make_tableau(int order, int error_order, bool fsal, const std::vector<Row>& a, const Row& b, const Row& lower) {
  Tableau t;
  t.stages = static_cast<int>(b.size());
  t.order = order;
  t.error_order = error_order;
  t.first_same_as_last = fsal;
  for (std::size_t i = 0; i < a.size(); ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < a[i].size(); ++j) {
      t.a[i + 1][j] = a[i][j];
      sum += a[i][j];
    }
    t.c[i + 1] = sum;
  }
  for (std::size_t i = 0; i < b.size(); ++i) {
    t.b[i] = b[i];
    t.e[i] = b[i] - lower[i];
  }
  return t;
}

// Two half steps of classical RK4 (stages 0 to 3 and 4 to 7) against one whole step (stages 0, 8, 9, 10); the
// difference divided by 2^4 - 1 estimates the error of the half steps.
Tableau make_rk4() {
  const double s = 1.0 / 6.0;
  const std::vector<Row> a = {{0.25},
                              {0, 0.25},
                              {0, 0, 0.5},
                              {s / 2, s, s, s / 2},
                              {s / 2, s, s, s / 2, 0.25},
                              {s / 2, s, s, s / 2, 0, 0.25},
                              {s / 2, s, s, s / 2, 0, 0, 0.5},
                              {0.5},
                              {0, 0, 0, 0, 0, 0, 0, 0, 0.5},
                              {0, 0, 0, 0, 0, 0, 0, 0, 0, 1}};
  const Row halves = {s / 2, s, s, s / 2, s / 2, s, s, s / 2, 0, 0, 0};
  const Row whole = {s, 0, 0, 0, 0, 0, 0, 0, 2 * s, 2 * s, s};
  Tableau t = make_tableau(4, 4, false, a, halves, whole);
  for (double& e : t.e) e /= 15.0;
  return t;
}

// C. Tsitouras, Runge-Kutta pairs of order 5(4) satisfying only the first column simplifying assumption, 2011, Table 1.
Tableau make_tsitouras() {
  const Row b = {0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081,
                 2.324710524099774};
  const std::vector<Row> a = {
      {0.161},
      {-0.008480655492356989, 0.335480655492357},
      {2.8971530571054935, -6.359448489975075, 4.3622954328695815},
      {5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525},
      {5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383},
      b};
  const Row error = {-0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629,
                     0.5823571654525552,      -0.45808210592918697,   0.015151515151515152};
  Row lower = {b[0], b[1], b[2], b[3], b[4], b[5], 0};
  for (std::size_t i = 0; i < lower.size(); ++i) lower[i] -= error[i];
  return make_tableau(5, 4, true, a, {b[0], b[1], b[2], b[3], b[4], b[5], 0}, lower);
}

}  // namespace

bool changes_volume(const Segment& segment) {
  return !segment.grid.growth.empty() || segment.curve.keeps_thickness || segment.curve.keeps_length ||
         !segment.lattice.is_empty() || std::any_of(segment.parts.begin(), segment.parts.end(), changes_volume);
}

Vec3d displacement_of(const Segment& segment, const Field& field) {
  return segment.time_law == TimeLaw::pinned ? std::get<Translation<double>>(field.motion).velocity
                                             : segment.displacement;
}

Flow masked(Flow flow, const Mask& mask) {
  for (Segment& segment : flow.segments) segment.mask = mask;
  return flow;
}

Flow inverse(const Flow& flow) {
  Flow result = flow;
  std::reverse(result.segments.begin(), result.segments.end());
  for (Segment& segment : result.segments) std::swap(segment.begin, segment.end);
  return result;
}

Flow prefix(const Flow& flow, double segments) {
  const double clamped = std::clamp(segments, 0.0, static_cast<double>(flow.segments.size()));
  const auto whole = static_cast<std::size_t>(clamped);
  Flow result{{flow.segments.begin(), flow.segments.begin() + static_cast<std::ptrdiff_t>(whole)}};
  const double rest = clamped - static_cast<double>(whole);
  if (rest > 0) {
    Segment part = flow.segments[whole];
    part.end = part.begin + rest * (part.end - part.begin);
    result.segments.push_back(part);
  }
  return result;
}

Flow flow_between(const Flow& flow, double from, double to) {
  const auto length = static_cast<double>(flow.segments.size());
  for (const double moment : {from, to}) {
    require(moment >= 0 && moment <= length, "a part of a flow must lie between 0 and its number of segments");
  }
  if (from == to) return {};
  if (to < from) return inverse(flow_between(flow, to, from));
  Flow result = prefix(flow, to);
  const double whole = std::floor(from);
  result.segments.erase(result.segments.begin(), result.segments.begin() + static_cast<std::ptrdiff_t>(whole));
  const Segment& first = flow.segments[static_cast<std::size_t>(whole)];
  if (from > whole) result.segments.front().begin = first.begin + (from - whole) * (first.end - first.begin);
  return result;
}

void validate(const Flow& flow) {
  for (std::size_t i = 0; i < flow.segments.size(); ++i) {
    try {
      check(flow.segments[i]);
    } catch (const InvalidInput& error) {
      throw InvalidInput("segment " + std::to_string(i + 1) + " of the flow: " + error.what());
    }
  }
}

const Tableau& tableau(Integrator integrator) {
  static const Tableau rk4 = make_rk4();
  static const Tableau tsitouras = make_tsitouras();
  return integrator == Integrator::rk4 ? rk4 : tsitouras;
}

std::optional<Integrator> integrator_named(std::string_view name) {
  if (name == "rk4" || name == "runge-kutta") return Integrator::rk4;
  if (name == "tsit5" || name == "tsitouras") return Integrator::tsitouras;
  return std::nullopt;
}

}  // namespace knead
