// Curves through points, drawn lines, frames, and the splines of a curve stroke.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "knead/error.h"
#include "math/elementary.h"
#include "strokes/curve.h"
#include "strokes/describe.h"

namespace knead::detail {

namespace {

constexpr std::size_t kSteps = 16;  // of a piece between two points
constexpr int kSamplesPerInterval = 4;
constexpr int kInversionSteps = 4;
constexpr double kMaxShortening = 0.9;  // of a piece of the line

// A smooth curve through points, by its length: the natural cubic spline over the lengths of its chords, whose
// curvature is 0 at both ends. Straight beyond them.
class SmoothCurve {
 public:
  // Two or more points, of which no two neighbours are equal.
  explicit SmoothCurve(const std::vector<Vec3d>& points);

  struct Place {
    Vec3d point;
    Vec3d tangent;    // a unit vector
    Vec3d curvature;  // dT/ds
  };

  double length() const { return lengths_.back(); }
  Place at(double s) const;

 private:
  double speed(std::size_t piece, double u) const { return norm(derivative(piece, u)); }
  Vec3d point(std::size_t piece, double u) const;
  Vec3d derivative(std::size_t piece, double u) const;
  double length_between(std::size_t piece, double from, double to) const;

  std::vector<Vec3d> points_;
  std::vector<Vec3d> second_;    // derivatives at the points
  std::vector<double> chords_;   // of the pieces
  std::vector<double> lengths_;  // from the beginning to the steps of the pieces
};

SmoothCurve::SmoothCurve(const std::vector<Vec3d>& points) : points_(points), second_(points.size()) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) chords_.push_back(norm(points[i + 1] - points[i]));
  // Thomas' algorithm for the second derivatives, which are 0 at both ends.
  std::vector<double> above(points.size());
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double a = chords_[i - 1];
    const double c = chords_[i];
    const double pivot = 2 * (a + c) - a * above[i - 1];
    above[i] = c / pivot;
    const Vec3d right = ((points[i + 1] - points[i]) / c - (points[i] - points[i - 1]) / a) * 6.0;
    second_[i] = (right - second_[i - 1] * a) / pivot;
  }
  for (std::size_t i = points.size() - 1; i-- > 1;) second_[i] = second_[i] - second_[i + 1] * above[i];
  lengths_.push_back(0);
  for (std::size_t piece = 0; piece < chords_.size(); ++piece) {
    const double step = chords_[piece] / kSteps;
    for (std::size_t k = 0; k < kSteps; ++k) {
      const double from = static_cast<double>(k) * step;
      lengths_.push_back(lengths_.back() + length_between(piece, from, from + step));
    }
  }
}

Vec3d SmoothCurve::point(std::size_t piece, double u) const {
  const double h = chords_[piece];
  const double a = (h - u) / h;
  const double b = u / h;
  return points_[piece] * a + points_[piece + 1] * b +
         (second_[piece] * (a * a * a - a) + second_[piece + 1] * (b * b * b - b)) * (h * h / 6);
}

Vec3d SmoothCurve::derivative(std::size_t piece, double u) const {
  const double h = chords_[piece];
  const double a = (h - u) / h;
  const double b = u / h;
  return (points_[piece + 1] - points_[piece]) / h +
         (second_[piece + 1] * (3 * b * b - 1) - second_[piece] * (3 * a * a - 1)) * (h / 6);
}

// By Gauss' rule with three places.
double SmoothCurve::length_between(std::size_t piece, double from, double to) const {
  const double half = 0.5 * (to - from);
  const double middle = from + half;
  const double by = half * 0.7745966692414834;
  return half * (5 * (speed(piece, middle - by) + speed(piece, middle + by)) + 8 * speed(piece, middle)) / 9;
}

SmoothCurve::Place SmoothCurve::at(double s) const {
  const double inside = std::clamp(s, 0.0, length());
  const auto above = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, inside);
  const auto step = static_cast<std::size_t>(above - lengths_.begin()) - 1;
  const std::size_t piece = step / kSteps;
  const double begin = static_cast<double>(step % kSteps) * chords_[piece] / kSteps;
  double u = begin;
  for (int i = 0; i < kInversionSteps; ++i) {
    u += (inside - lengths_[step] - length_between(piece, begin, u)) / std::max(speed(piece, u), 1e-300);
  }
  const Vec3d along = derivative(piece, u);
  const double b = u / chords_[piece];
  const Vec3d second = second_[piece] * (1 - b) + second_[piece + 1] * b;
  Place place{point(piece, u), normalized(along), {}};
  place.point += place.tangent * (s - inside);
  if (s == inside) place.curvature = (second - place.tangent * dot(place.tangent, second)) / norm2(along);
  return place;
}

// A frame: tangent, and two vectors across.
struct Frame {
  Vec3d tangent;
  Vec3d first;
  Vec3d second;
};

// Takes a frame along a curve without turning it about the tangent: the double reflection (Wang et al. 2008), whose
// error falls with the fourth power of the step.
Frame carried(const Frame& frame, const Vec3d& by, const Vec3d& tangent) {
  const auto reflected = [](const Vec3d& v, const Vec3d& normal) {
    const double square = norm2(normal);
    return square > 0 ? v - normal * (2 * dot(normal, v) / square) : v;
  };
  const Vec3d first = reflected(frame.first, by);
  const Vec3d mirrored = reflected(frame.tangent, by);
  const Vec3d turned = reflected(first, tangent - mirrored);
  const Vec3d across = normalized(turned - tangent * dot(tangent, turned));
  return {tangent, across, cross(tangent, across)};
}

// A place of a curve with the length that a unit of the other curve's length becomes there.
struct Sample {
  SmoothCurve::Place place;
  double stretch = 1;
  std::array<double, 2> bend{};  // the curvature in the frame, by the other curve's length
};

// Finds the curvature in the frame that is given at one sample.
void find_bends(std::vector<Sample>& samples, std::size_t anchor, const Frame& frame) {
  for (const bool forwards : {true, false}) {
    Frame at = frame;
    for (std::size_t i = anchor;;) {
      Sample& sample = samples[i];
      sample.bend = {dot(sample.place.curvature, at.first) * sample.stretch,
                     dot(sample.place.curvature, at.second) * sample.stretch};
      if (forwards ? i + 1 == samples.size() : i == 0) break;
      i += forwards ? 1 : std::size_t(-1);
      at = carried(at, samples[i].place.point - sample.place.point, samples[i].place.tangent);
    }
  }
}

// The coefficient of a spline's node by quasi-interpolation, exact for cubic functions.
std::array<double, 2> node_of(const std::vector<Sample>& samples, int interval) {
  const auto at = [&](int i) { return samples[static_cast<std::size_t>(i) * kSamplesPerInterval].bend; };
  const auto [before, here, after] = std::array{at(interval - 1), at(interval), at(interval + 1)};
  return {(8 * here[0] - before[0] - after[0]) / 6, (8 * here[1] - before[1] - after[1]) / 6};
}

// Returns the smallest rotation that takes one unit vector to another, as an axis whose length is the angle.
Vec3d least_turn(const Frame& from, const Vec3d& to) {
  const Vec3d axis = cross(from.tangent, to);
  const double sine = norm(axis);
  const double angle = elementary::atan2(sine, dot(from.tangent, to));
  if (sine > 0) return axis * (angle / sine);
  return from.second * angle;  // 0, or half a turn
}

// Returns sigma(s) at all samples; sigma' is 1 plus a spline with equal coefficients. Simpson's rule is exact for it.
std::vector<double> stretched_lengths(int intervals, double spacing, double coefficient, std::vector<double>& stretch) {
  const int count = intervals * kSamplesPerInterval;
  const auto sigma = [&](double at) {  // in intervals
    double sum = 1;
    for (int node = 2; node <= intervals - 2; ++node) {
      const double d = std::abs(at - node);
      if (d >= 2) continue;
      const double rest = 2 - d;
      sum += coefficient * (d >= 1 ? rest * rest * rest / 6 : (4 - 3 * d * d * rest) / 6);
    }
    return sum;
  };
  std::vector<double> lengths{0};
  for (int i = 0; i <= count; ++i) {
    const double at = static_cast<double>(i) / kSamplesPerInterval;
    stretch.push_back(sigma(at));
    if (i == count) break;
    const double step = 1.0 / kSamplesPerInterval;
    lengths.push_back(lengths.back() +
                      spacing * step / 6 * (sigma(at) + 4 * sigma(at + 0.5 * step) + sigma(at + step)));
  }
  return lengths;
}

// The interval at whose beginning the line stays. The shape lies between the ramps, which have this many intervals.
int anchor_of(CurveFixed fixed, int intervals, int ramp) {
  return fixed == CurveFixed::start ? ramp : fixed == CurveFixed::end ? intervals - ramp : intervals / 2;
}

// The place on the other curve of the first curve's begin, if both keep their lengths.
double offset_of(CurveFixed fixed, double by) {
  return fixed == CurveFixed::start ? 0 : fixed == CurveFixed::end ? by : 0.5 * by;
}

// Returns the samples of the curve `to` to which those of the motion's curve move; the frame at the anchor is given.
// Also finds the motion of the anchor and the coefficients of the stretch. The curve `to` begins where the ramp ends.
std::vector<Sample> on_path(const CurveStroke& stroke, const Frame& frame, int ramp, CurveMotion& motion,
                            double& stretch) {
  const SmoothCurve to(stroke.to);
  const double spacing = motion.length / kPathIntervals;
  const double longer = to.length() - (kPathIntervals - 2 * ramp) * spacing;
  const bool fits = stroke.length == CurveLength::fit;
  if (fits) stretch = longer / ((kPathIntervals - (ramp > 0 ? 2 * ramp : 3)) * spacing);
  std::vector<double> growth;
  const std::vector<double> lengths = stretched_lengths(kPathIntervals, spacing, stretch, growth);
  const double offset =
      (fits ? 0 : offset_of(stroke.fixed, longer)) - lengths[static_cast<std::size_t>(ramp) * kSamplesPerInterval];
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < lengths.size(); ++i) samples.push_back({to.at(lengths[i] + offset), growth[i]});
  const auto anchor = static_cast<std::size_t>(motion.anchor) * kSamplesPerInterval;
  const auto& [place, tangent, curvature] = samples[anchor].place;
  motion.shift = place - motion.place;
  motion.turn = least_turn(frame, tangent);
  const double angle = norm(motion.turn);
  const Vec3d first = angle > 0 ? rotate(frame.first, motion.turn / angle, sincos(angle)) : frame.first;
  find_bends(samples, anchor, {tangent, first, cross(tangent, first)});
  return samples;
}

// Returns places at equal lengths along a polyline, its ends among them.
std::vector<Vec3d> along_polyline(const std::vector<Vec3d>& points, std::size_t intervals) {
  std::vector<double> lengths{0};
  for (std::size_t i = 1; i < points.size(); ++i) lengths.push_back(lengths.back() + norm(points[i] - points[i - 1]));
  std::vector<Vec3d> places;
  std::size_t piece = 1;
  for (std::size_t i = 0; i <= intervals; ++i) {
    const double at = lengths.back() * static_cast<double>(i) / static_cast<double>(intervals);
    while (piece + 1 < points.size() && lengths[piece] < at) ++piece;
    const double chord = lengths[piece] - lengths[piece - 1];
    const double share = chord > 0 ? std::clamp((at - lengths[piece - 1]) / chord, 0.0, 1.0) : 0;
    places.push_back(points[piece - 1] * (1 - share) + points[piece] * share);
  }
  return places;
}

// Returns means of places with their neighbours, weighted by a Gaussian of this width. Beyond an end the line is
// mirrored at the end, which stays.
std::vector<Vec3d> blurred(const std::vector<Vec3d>& places, double width) {
  const auto last = static_cast<int>(places.size()) - 1;
  const auto place = [&](int i) {
    if (i < 0) return places.front() * 2 - places[static_cast<std::size_t>(-i)];
    if (i > last) return places.back() * 2 - places[static_cast<std::size_t>(2 * last - i)];
    return places[static_cast<std::size_t>(i)];
  };
  const int reach = std::min(static_cast<int>(3 * width), last);
  std::vector<Vec3d> means;
  for (int i = 0; i <= last; ++i) {
    Vec3d sum{0, 0, 0};
    double weights = 0;
    for (int k = -reach; k <= reach; ++k) {
      const double weight = elementary::exp(-0.5 * k * k / (width * width));
      sum += place(i + k) * weight;
      weights += weight;
    }
    means.push_back(sum / weights);
  }
  return means;
}

// Returns how thick a shape is about a line: the distance within which nine tenths of its points are, of a sample.
double thickness_about(const std::vector<Vec3d>& line, std::span<const Vec3d> positions) {
  constexpr std::size_t kMeasured = 4096;
  constexpr double kShare = 0.9;
  std::vector<double> distances;
  for (std::size_t i = 0; i < positions.size(); i += positions.size() / kMeasured + 1) {
    double& least = distances.emplace_back(kInfinity);
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
      least = std::min(least, distance_to_segment(positions[i], line[k], line[k + 1]));
    }
  }
  if (distances.empty()) return 0;
  const auto at = distances.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(distances.size()));
  std::nth_element(distances.begin(), at, distances.end());
  return *at;
}

double greatest_curvature(const std::vector<Vec3d>& points) {
  constexpr int kPlaces = 256;
  const SmoothCurve curve(points);
  double most = 0;
  for (int i = 0; i <= kPlaces; ++i) most = std::max(most, norm(curve.at(curve.length() * i / kPlaces).curvature));
  return most;
}

// Sets the stretch of all nodes for a thickness, with ramps at both ends. A taper of a prism is straight.
void set_thickness(const CurveStroke& stroke, CurveMotion& motion, std::vector<CurveNode>& nodes) {
  constexpr double kMaxFactor = 10;
  const double before = *stroke.thickness_before;
  const double factor = stroke.thickness.value_or(before + stroke.thicker_by) / before;
  if (!(factor >= 1 / kMaxFactor && factor <= kMaxFactor)) {
    throw InvalidInput(
        fmt::format("\"{}\": where the shape is {:.4g} thick, it can get a thickness from {:.4g} to {:.4g}",
                    stroke.thickness ? "thickness" : "thicker_by", before, before / kMaxFactor, before * kMaxFactor));
  }
  motion.keeps_length = stroke.keep == CurveKeeps::length;
  motion.one_across = stroke.axis.has_value();
  const double power = motion.one_across ? 1 : 2;
  const auto stretch_for = [&](double f) { return (motion.one_across ? 1 / f : 1 / (f * f)) - 1; };
  const double end = stretch_for(factor);
  if (stroke.taper) motion.end_stretch = end;
  const double p = motion.keeps_length ? 1 : power + 1;  // factor^p is linear in the length before
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(nodes.size() + 1);
    const double here = elementary::pow(1 + (elementary::pow(factor, p) - 1) * share, 1 / p);
    nodes[i].stretch = stroke.taper ? stretch_for(here) : end;
  }
}

bool has_ramps(const CurveStroke& stroke) {
  constexpr double kRounding = 1e-9;
  const Vec3d half = (stroke.from.back() - stroke.from.front()) * 0.5;
  const std::vector<Vec3d> line = line_with_ramps(stroke.from.front() + half, half, !stroke.to.empty());
  return std::equal(line.begin(), line.end(), stroke.from.begin(), stroke.from.end(),
                    [&](const Vec3d& a, const Vec3d& b) { return norm(a - b) <= kRounding * norm(half); });
}

}  // namespace

std::vector<Vec3d> line_with_ramps(const Vec3d& center, const Vec3d& half, bool has_aim) {
  constexpr double kOfShape = 1 - 2.0 * kArcRamp / kPathIntervals;
  if (!has_aim) return {center - half, center, center + half};
  return {center - half, center - half * kOfShape, center, center + half * kOfShape, center + half};
}

bool changes_thickness(const CurveStroke& stroke) { return stroke.thickness || stroke.thicker_by != 0; }

CurveMotion motion_of(const CurveStroke& stroke) {
  const SmoothCurve from(stroke.from);
  const bool is_path = stroke.from.size() > 2 || !stroke.to.empty();
  const int intervals = is_path ? kPathIntervals : kArcIntervals;
  const int nodes = intervals - 3;
  const int ramp = has_ramps(stroke) ? kArcRamp : 0;
  CurveMotion motion;
  motion.length = from.length();
  motion.radius = stroke.radius;
  motion.keeps_thickness = stroke.keep == CurveKeeps::thickness;
  motion.anchor = anchor_of(stroke.fixed, intervals, ramp);
  const double spacing = motion.length / intervals;
  const auto anchor = static_cast<std::size_t>(motion.anchor) * kSamplesPerInterval;
  std::vector<Sample> rest(static_cast<std::size_t>(intervals) * kSamplesPerInterval + 1);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    rest[i].place = from.at(static_cast<double>(i) * spacing / kSamplesPerInterval);
  }
  const auto& [place, tangent, curvature] = rest[anchor].place;
  const Vec3d across = stroke.axis ? normalized(cross(unit(*stroke.axis), tangent)) : any_orthogonal(tangent);
  const Frame frame{tangent, across, cross(tangent, across)};
  find_bends(rest, anchor, frame);
  motion.place = place;
  motion.frame = {frame.tangent, frame.first, frame.second};

  if (ramp > 0) motion.part = {ramp * spacing, motion.length - ramp * spacing};
  double stretch = stroke.longer_by / (nodes * spacing);
  if (stretch < -kMaxShortening) {
    throw InvalidInput(fmt::format("\"longer_by\": the line can lose {:.3g} of its length {:.3g} at most",
                                   kMaxShortening * nodes * spacing, motion.length));
  }
  const std::vector<Sample> bent = stroke.to.empty() ? rest : on_path(stroke, frame, ramp, motion, stretch);
  double more = stroke.around ? 1 / *stroke.around : 0;  // curvature
  if (stroke.angle_deg) more = *stroke.angle_deg * kRadiansPerDegree / (nodes * spacing);
  std::vector<CurveNode> list;
  for (int i = 0; i < nodes; ++i) {
    CurveNode& node = list.emplace_back();
    node.rest = node_of(rest, i + 2);
    node.bent = node_of(bent, i + 2);
    node.bent[0] += more;
    node.twist = stroke.twist_deg * kRadiansPerDegree / (nodes * spacing);
    node.stretch = stretch;
  }
  if (changes_thickness(stroke)) set_thickness(stroke, motion, list);
  motion.nodes = SharedList<CurveNode>(std::move(list));
  return motion;
}

}  // namespace knead::detail

namespace knead {

std::vector<Vec3d> points_on_line(std::vector<Vec3d> points, std::size_t count) {
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 2) return points;
  const detail::SmoothCurve curve(points);
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < count; ++i) {
    result.push_back(curve.at(curve.length() * static_cast<double>(i) / static_cast<double>(count - 1)).point);
  }
  return result;
}

std::vector<Vec3d> smoothed_line(const std::vector<Vec3d>& drawn, const std::vector<Vec3d>& from,
                                 std::span<const Vec3d> positions) {
  constexpr std::size_t kIntervals = 128;
  constexpr double kMinWidth = 1.0 / 24;  // of the length
  constexpr double kMaxWidth = 1.0 / 5;
  constexpr double kWider = 1.2;
  constexpr double kTightest = 0.4;  // of the thickness times the curvature: 0.5 is impossible
  double length = 0;
  for (std::size_t i = 1; i < drawn.size(); ++i) length += norm(drawn[i] - drawn[i - 1]);
  if (!(length > 0)) return {};
  const std::vector<Vec3d> even = detail::along_polyline(drawn, kIntervals);
  const double tightest = kTightest / detail::thickness_about(from, positions);
  std::vector<Vec3d> line;
  for (double width = kMinWidth; width < kMaxWidth; width *= kWider) {
    // Once more what the first time took away: so an arc keeps its radius.
    const std::vector<Vec3d> once = detail::blurred(even, width * kIntervals);
    const std::vector<Vec3d> twice = detail::blurred(once, width * kIntervals);
    line = once;
    for (std::size_t i = 0; i < line.size(); ++i) line[i] += once[i] - twice[i];
    line = points_on_line(std::move(line), kPointsOfLine);
    if (line.size() < 2) return {};
    if (detail::greatest_curvature(line) <= tightest) break;
  }
  const double there = norm2(line.front() - from.front()) + norm2(line.back() - from.back());
  const double back = norm2(line.back() - from.front()) + norm2(line.front() - from.back());
  if (back < there) std::reverse(line.begin(), line.end());
  return line;
}

std::size_t points_between_handles(const std::vector<Vec3d>& line, std::span<const Vec3d> positions) {
  constexpr double kLong = 10;  // of the thickness
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += norm(line[i] - line[i - 1]);
  const bool is_long = length > kLong * detail::thickness_about(line, positions);
  return (kPointsOfLine - 1) / (is_long ? 4 : 2);
}

std::vector<Vec3d> with_handle_moved(std::vector<Vec3d> line, std::size_t stride, std::size_t handle, const Vec3d& by) {
  const std::size_t last = (line.size() - 1) / stride;
  const auto value = [&](std::size_t i) { return i == handle ? 1.0 : 0.0; };
  // The natural cubic spline that is 1 at the handle and 0 at the others; Thomas' algorithm for its second derivatives.
  std::vector<double> second(last + 1);
  std::vector<double> above(last + 1);
  for (std::size_t i = 1; i < last; ++i) {
    const double pivot = 4 - above[i - 1];
    above[i] = 1 / pivot;
    second[i] = (6 * (value(i - 1) - 2 * value(i) + value(i + 1)) - second[i - 1]) / pivot;
  }
  for (std::size_t i = last; i-- > 1;) second[i] -= above[i] * second[i + 1];
  for (std::size_t k = 0; k < line.size(); ++k) {
    const std::size_t i = std::min(k / stride, last - 1);
    const double b = static_cast<double>(k - i * stride) / static_cast<double>(stride);
    const double a = 1 - b;
    const double curved = ((a * a * a - a) * second[i] + (b * b * b - b) * second[i + 1]) / 6;
    line[k] += by * (a * value(i) + b * value(i + 1) + curved);
  }
  return line;
}

CurveStroke curve_between(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to) {
  constexpr double kStraight = 1e-9;  // of the length
  CurveStroke stroke;
  const Vec3d& first = from.front();
  const Vec3d& last = from.back();
  const bool is_straight = std::all_of(from.begin(), from.end(), [&](const Vec3d& p) {
    return distance_to_segment(p, first, last) <= kStraight * norm(last - first);
  });
  stroke.from = is_straight ? std::vector{first, last} : from;
  stroke.to = to;
  const double of_first = norm(to.front() - first);
  const double of_last = norm(to.back() - last);
  if (of_first < 0.5 * of_last) stroke.fixed = CurveFixed::start;
  if (of_last < 0.5 * of_first) stroke.fixed = CurveFixed::end;
  return stroke;
}

}  // namespace knead
