// A curve that bends, with its frame, and the map of its surroundings: there and back, with Jacobians and velocities.
#include "flow/curve_map.h"

#include <algorithm>
#include <cmath>

#include "field/dual.h"
#include "flow/kernels/kernel.h"

namespace knead::detail {

namespace {

constexpr int kMaxCells = 1 << 16;
constexpr int kNewtonSteps = 30;
constexpr std::size_t kCellsPerStation = 3;
constexpr std::size_t kStationsPerLook = 16;  // of a first search
constexpr double kBelowRounding = 1 - 1e-6;
// u^2 below which the correction that keeps the volume is rounded away, and its divisor may vanish.
constexpr double kFlat = 1e-40;

// The dual number of one variable.
using TimeDual = DualOf<double, double>;

double value_of(double x) { return x; }
template <class T, class G>
auto value_of(const DualOf<T, G>& x) {
  return x.v;
}

// The coefficients of the powers of f in [0, 1] of the basis functions that are not 0 in an interval, the first node's
// first.
constexpr std::array<std::array<double, 4>, 4> kBasis{
    {{1.0 / 6, -0.5, 0.5, -1.0 / 6}, {4.0 / 6, 0, -1, 0.5}, {1.0 / 6, 0.5, 0.5, -0.5}, {0, 0, 0, 1.0 / 6}}};

// Cells are so short that what the polynomials leave out is below 1e-13: the curve turns by at most kMaxTurn in one,
// and its curvature changes by the square of that.
int cells_per_interval(const CurveMotion& curve) {
  constexpr double kMaxTurn = 1.0 / 12;
  double most = 0;
  std::array<double, 4> before{};
  const auto step_to = [&](const std::array<double, 4>& now) {
    for (const std::size_t i : {0, 2}) {
      const double turn = std::sqrt(now[i] * now[i] + now[i + 1] * now[i + 1]) * curve.spacing();
      const double x = now[i] - before[i];
      const double y = now[i + 1] - before[i + 1];
      const double root = std::sqrt(std::sqrt(x * x + y * y) * curve.spacing());
      most = std::max({most, turn, root, std::sqrt(root)});
    }
    before = now;
  };
  for (const CurveNode& node : curve.nodes) step_to({node.rest[0], node.rest[1], node.bent[0], node.bent[1]});
  step_to({});
  const double parts = std::ceil(most / kMaxTurn);
  const int most_parts = std::max<int>(1, static_cast<int>(kMaxCells / curve.intervals()));
  return static_cast<int>(std::clamp(parts, 1.0, static_cast<double>(most_parts)));
}

bool begins_straight(const Segment& segment) {
  return segment.begin == 0 &&
         std::all_of(segment.curve.nodes.begin(), segment.curve.nodes.end(), [](const CurveNode& n) {
           return n.rest == std::array{0.0, 0.0};
         });
}

// Without fused operations, which take a call on some machines; these give the same bits on all.
double inner(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

template <class T>
Vec3<T> rotated(const Vec3<T>& v, const Vec3<T>& axis, const SinCos<T>& turn) {
  const Vec3<T> along = axis * dot(axis, v);
  return along + (v - along) * turn.cos + cross(axis, v) * turn.sin;
}

// By the chain rule: sincos() is for numbers.
SinCos<double> sincos_of(double x) { return sincos(x); }
template <class T, class G>
SinCos<DualOf<T, G>> sincos_of(const DualOf<T, G>& x) {
  const SinCos<T> at = sincos(x.v);
  return {{at.sin, x.g * at.cos}, {at.cos, x.g * -at.sin}};
}

}  // namespace

template <class S>
CurveTable<S>::CurveTable(const CurveMotion& curve, const S& time)
    : length_(curve.length),
      stretches_(curve.end_stretch != 0),
      keeps_thickness_(curve.keeps_thickness),
      keeps_length_(curve.keeps_length),
      one_across_(curve.one_across),
      part_(curve.part) {
  const int parts = cells_per_interval(curve);
  const int count = curve.intervals() * parts;
  per_cell_ = count / length_;
  origin_cell_ = curve.anchor * parts;
  for (const CurveNode& node : curve.nodes) {
    twists_ = twists_ || node.twist != 0;
    stretches_ = stretches_ || node.stretch != 0;
  }
  cells_.resize(static_cast<std::size_t>(count));
  End border{Vec3<S>(curve.shift) * time,
             {Vec3<S>(curve.frame.row0), Vec3<S>(curve.frame.row1), Vec3<S>(curve.frame.row2)}};
  const double angle = norm(curve.turn);
  if (angle > 0) {
    const SinCos<S> turn = sincos_of(S(angle) * time);
    for (Vec3<S>& v : border.frame) v = rotated(v, Vec3<S>(curve.turn / angle), turn);
  }
  for (const int step : {1, -1}) {
    End at = border;
    S twist{0};
    for (int cell = step > 0 ? origin_cell_ : origin_cell_ - 1; cell >= 0 && cell < count; cell += step) {
      fill_nodes(curve, time, cell, parts, step > 0 ? 0 : 1, cells_[static_cast<std::size_t>(cell)]);
      integrate(cells_[static_cast<std::size_t>(cell)], at, twist);
    }
    const SinCos<S> turn = sincos_of(twist);
    at.frame = {at.frame[0], at.frame[1] * turn.cos + at.frame[2] * turn.sin,
                at.frame[2] * turn.cos - at.frame[1] * turn.sin};
    if (step > 0 && curve.end_stretch != 0) {
      const S stretch = S(1) + time * S(curve.end_stretch);
      at.along = along(stretch);
      at.narrow = narrowing(stretch);
    }
    ends_[step > 0 ? 1 : 0] = at;
  }
  for (std::size_t i = 0; i < cells_.size(); i += kCellsPerStation) {
    const Powers& at = cells_[i][0];
    stations_.push_back({value_of(at[kPlace]), value_of(at[kPlace + 1]), value_of(at[kPlace + 2])});
    if (i > 0) station_gap_ = std::max(station_gap_, norm(stations_.back() - stations_[stations_.size() - 2]));
  }
}

// The polynomials of the splines in a cell, in z from its border `origin` (0: its first, 1: its last); those per length
// by the length of a cell.
template <class S>
void CurveTable<S>::fill_nodes(const CurveMotion& curve, const S& time, int cell, int parts, double origin,
                               Cell& to) const {
  const double size = 1.0 / parts;
  const double f = (cell % parts + origin) * size;
  const double h = 1 / per_cell_;
  for (int k = 0; k < 4; ++k) {
    const int node = cell / parts + k - 3;
    if (node < 0) continue;
    const bool is_beyond = node >= static_cast<int>(curve.nodes.size());
    const CurveNode n =
        is_beyond ? CurveNode{{}, {}, 0, curve.end_stretch} : curve.nodes[static_cast<std::size_t>(node)];
    const std::array<double, 4>& b = kBasis[static_cast<std::size_t>(k)];
    const double powers[4] = {b[0] + f * (b[1] + f * (b[2] + f * b[3])), size * (b[1] + f * (2 * b[2] + f * 3 * b[3])),
                              size * size * (b[2] + f * 3 * b[3]), size * size * size * b[3]};
    for (std::size_t p = 0; p < 4; ++p) {
      for (std::size_t i = 0; i < 2; ++i) {
        to[p][kBend + i] = to[p][kBend + i] + (S(n.rest[i]) + time * S(n.bent[i] - n.rest[i])) * S(h * powers[p]);
      }
      to[p + 1][kTwistAngle] = to[p + 1][kTwistAngle] + time * S(n.twist * h * powers[p] / static_cast<double>(p + 1));
      to[p][kStretch] = to[p][kStretch] + time * S(n.stretch * powers[p]);
    }
  }
  to[0][kStretch] = to[0][kStretch] + S(1);
}

template <class S>
template <std::size_t kCount, class T>
auto CurveTable<S>::value_at(const Cell& cell, const T& z) -> Section<T> {
  Section<T> sum;
  for (std::size_t i = 0; i < kCount; ++i) sum[i] = T(cell[kCurvePowers - 1][i]);
  for (std::size_t p = kCurvePowers - 1; p-- > 0;) {
    for (std::size_t i = 0; i < kCount; ++i) sum[i] = sum[i] * z + T(cell[p][i]);
  }
  return sum;
}

// Power series of C' = sigma' T, T' = w1 M1 + w2 M2, M1' = -w1 T, M2' = -w2 T, from the cell's origin; `border` and
// `twist` are there, and then at its other border.
template <class S>
void CurveTable<S>::integrate(Cell& cell, End& border, S& twist) const {
  const double h = 1 / per_cell_;
  std::array<std::array<Vec3<S>, 3>, kCurvePowers> frame{};
  std::array<Vec3<S>, kCurvePowers> place{};
  frame[0] = border.frame;
  place[0] = border.place;
  for (std::size_t m = 0; m + 1 < kCurvePowers; ++m) {
    std::array<Vec3<S>, 3> sum{};
    Vec3<S> along{};
    for (std::size_t j = 0; j <= std::min<std::size_t>(m, 3); ++j) {
      const auto& [t, m1, m2] = frame[m - j];
      sum[0] += m1 * cell[j][kBend] + m2 * cell[j][kBend + 1];
      sum[1] += t * -cell[j][kBend];
      sum[2] += t * -cell[j][kBend + 1];
      if (j == 0 || !keeps_length_) along += t * this->along(cell[j][kStretch]);
    }
    const S share(1.0 / static_cast<double>(m + 1));
    for (std::size_t i = 0; i < 3; ++i) frame[m + 1][i] = sum[i] * share;
    place[m + 1] = along * S(h / static_cast<double>(m + 1));
  }
  cell[0][kTwistAngle] = twist;
  for (std::size_t p = 0; p < kCurvePowers; ++p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell[p][kPlace + axis] = place[p][axis];
      cell[p][kTangent + axis] = frame[p][0][axis];
      cell[p][kFirst + axis] = frame[p][1][axis];
      cell[p][kSecond + axis] = frame[p][2][axis];
    }
  }
  const S z(&cell - cells_.data() >= origin_cell_ ? 1.0 : -1.0);
  const Section<S> sum = value_at(cell, z);
  border.place = sum.vector(kPlace);
  const Vec3<S> t = normalized(sum.vector(kTangent));
  const Vec3<S> m1 = sum.vector(kFirst);
  border.frame[0] = t;
  border.frame[1] = normalized(m1 - t * dot(t, m1));
  border.frame[2] = cross(t, border.frame[1]);
  twist = sum[kTwistAngle];
}

template <class S>
template <std::size_t kCount, class T>
auto CurveTable<S>::section(const T& s) const -> Section<T> {
  const int last = static_cast<int>(cells_.size()) - 1;
  const int cell = std::clamp(static_cast<int>(value_of(s) * per_cell_), 0, last);
  const T z = s * T(per_cell_) - T(static_cast<double>(cell < origin_cell_ ? cell + 1 : cell));
  return value_at<kCount>(cells_[static_cast<std::size_t>(cell)], z);
}

template <class S>
template <class T>
std::array<T, 2> CurveTable<S>::narrowing(const T& stretch) const {
  using std::sqrt;
  if (keeps_thickness_) return {T(1), T(1)};
  if (one_across_) return {T(1), stretch};
  const T root = sqrt(stretch);
  return {root, root};
}

template <class S>
template <class T>
bool CurveTable<S>::place(const CurvePoint<T>& at, Vec3<T>& x) const {
  const double s = value_of(at.s);
  if (s <= 0 || s >= length_) {
    const End& end = ends_[s <= 0 ? 0 : 1];
    const T beyond = (s <= 0 ? at.s : at.s - T(length_)) * T(end.along);
    x = Vec3<T>(end.place) + Vec3<T>(end.frame[0]) * beyond +
        Vec3<T>(end.frame[1]) * (at.across[0] / T(end.narrow[0])) +
        Vec3<T>(end.frame[2]) * (at.across[1] / T(end.narrow[1]));
    return true;
  }
  const Section<T> here = section<kTangent>(at.s);
  T y[2] = {at.across[0], at.across[1]};
  if (twists_) {
    const SinCos<T> turn = sincos_of(here[kTwistAngle]);
    const T turned = y[0] * turn.cos - y[1] * turn.sin;
    y[1] = y[0] * turn.sin + y[1] * turn.cos;
    y[0] = turned;
  }
  T k[2] = {here[kBend] * T(per_cell_), here[kBend + 1] * T(per_cell_)};
  if (stretches_) {
    const std::array<T, 2> narrow = narrowing(here[kStretch]);
    for (std::size_t i = 0; i < 2; ++i) {
      y[i] = y[i] / narrow[i];
      k[i] = k[i] / along(here[kStretch]);
    }
  }
  const T u = k[0] * y[0] + k[1] * y[1];
  const T k2 = k[0] * k[0] + k[1] * k[1];
  if (!(value_of(u) < 0.5)) return false;
  if (!keeps_thickness_ && value_of(k2) * value_of(y[0] * y[0] + y[1] * y[1]) > kFlat) {
    using std::sqrt;
    const T root = sqrt(T(1) - u - u) + T(1);
    const T more = (u + u) * u / (root * root * k2);
    for (std::size_t i = 0; i < 2; ++i) y[i] = y[i] + more * k[i];
  }
  x = here.vector(kPlace) + here.vector(kFirst) * y[0] + here.vector(kSecond) * y[1];
  return true;
}

// Returns the two places from which the nearest place to x may be found, the nearer first: stations of the curve's part
// at which the distance is least, as on two turns of a spring, and places beyond the ends.
template <class S>
auto CurveTable<S>::starts_near(const Vec3d& x) const -> std::array<Start, 2> {
  const double per_station = per_cell_ / kCellsPerStation;
  const auto last_station = static_cast<double>(stations_.size() - 1);
  const auto first = static_cast<std::size_t>(std::clamp(std::ceil(part_[0] * per_station), 0.0, last_station));
  const auto end = static_cast<std::size_t>(std::clamp(std::floor(part_[1] * per_station), 0.0, last_station)) + 1;
  const auto begin = static_cast<double>(first);
  std::array<Start, 2> starts{Start{begin}, Start{begin}};
  const auto add = [&](const Start& start) {
    if (start.distance < starts[0].distance) {
      starts = {start, starts[0]};
    } else if (start.distance < starts[1].distance) {
      starts[1] = start;
    }
  };
  const auto distance_at = [&](std::size_t i) {
    const Vec3d d = i < end ? x - stations_[i] : Vec3d{kInfinity, 0, 0};
    return inner(d, d);
  };
  double nearest = kInfinity;
  for (std::size_t i = first; i < end; i += kStationsPerLook) nearest = std::min(nearest, distance_at(i));
  nearest = std::sqrt(nearest);
  const double near = (nearest + 4 * station_gap_) * (nearest + 4 * station_gap_);
  double before = kInfinity;
  bool was_nearer = false;
  for (std::size_t i = first; i <= end; ++i) {
    const double distance = distance_at(i);
    const bool is_nearer = distance < before;
    if (was_nearer && !is_nearer) add({static_cast<double>(i - 1), before});
    was_nearer = is_nearer;
    before = distance;
    if (!(distance > near)) continue;
    // find() uses no station that is farther than the nearest one by more than the gap, as the next stations are.
    const double farther = kBelowRounding * (std::sqrt(distance) - nearest) / station_gap_ - 1;
    if (!(farther < static_cast<double>(end - i))) break;
    i += static_cast<std::size_t>(farther);
    before = distance_at(i);
    was_nearer = false;
  }
  for (Start& start : starts) {
    const auto cell = static_cast<std::size_t>(start.s) * kCellsPerStation;
    const bool at_last = static_cast<int>(cell) < origin_cell_;
    start.s = (static_cast<double>(cell) + (at_last ? 1 : 0)) / per_cell_;
    start.s += step_from(Section<double>{cells_[cell][0]}, x).value_or(0);
  }
  for (const bool last : {false, true}) {
    const double s = beyond(last, x).s;
    if (last ? s > length_ : s < 0) add({s, distance_to(x, s)});
  }
  return starts;
}

// Returns the squared distance of x from the curve's place at s, where x has no component along the curve. Beyond the
// part it is greater: beside the gap of a ring both ends are near.
template <class S>
double CurveTable<S>::distance_to(const Vec3d& x, double s) const {
  const double farther = std::max({s - part_[1], part_[0] - s, 0.0});
  if (s > 0 && s < length_) {
    const Vec3d d = x - section<kFirst>(s).vector(kPlace);
    return inner(d, d) + farther * farther;
  }
  const End& end = ends_[s > 0 ? 1 : 0];
  const double y1 = inner(x - end.place, end.frame[1]);
  const double y2 = inner(x - end.place, end.frame[2]);
  return y1 * y1 + y2 * y2 + farther * farther;
}

// By projection on the tangent at an end.
template <class S>
CurvePoint<double> CurveTable<S>::beyond(bool last, const Vec3d& x) const {
  const auto& [place, frame, along, narrow] = end(last);
  const Vec3d d = x - place;
  return {(last ? length_ : 0) + inner(d, frame[0]) / along,
          {inner(d, frame[1]) * narrow[0], inner(d, frame[2]) * narrow[1]}};
}

template <class S>
std::optional<double> CurveTable<S>::step_from(const Section<double>& here, const Vec3d& x) const {
  const Vec3d d = x - here.vector(kPlace);
  const double turn = here[kBend] * inner(d, here.vector(kFirst)) + here[kBend + 1] * inner(d, here.vector(kSecond));
  const double slope = along(here[kStretch]) - turn * per_cell_;
  if (!(slope > 0)) return std::nullopt;
  return std::clamp(inner(d, here.vector(kTangent)) / slope, -4 / per_cell_, 4 / per_cell_);
}

// Newton's method from a length along the curve. Returns nothing if it does not converge.
template <class S>
std::optional<double> CurveTable<S>::length_at(const Vec3d& x, double s) const {
  constexpr double kLast = 1e-7;  // of the length: the next step is rounded away
  double by = length_;
  for (int step = 0; step < kNewtonSteps && std::abs(by) > kLast * length_; ++step) {
    if (s <= 0 || s >= length_) {
      s = beyond(s > 0, x).s;
      if (s <= 0 || s >= length_) break;
      by = length_;
      continue;
    }
    const std::optional<double> next = step_from(section(s), x);
    if (!next) return std::nullopt;
    by = *next;
    s += by;
  }
  const bool is_found = s <= 0 || s >= length_ || std::abs(by) <= kLast * length_;
  return is_found ? std::optional(s) : std::nullopt;
}

template <class S>
auto CurveTable<S>::find(const Vec3d& x) const -> std::optional<CurvePoint<double>> {
  const auto& [nearest, second] = starts_near(x);
  std::optional<double> s = length_at(x, nearest.s);
  if (std::sqrt(second.distance) < std::sqrt(nearest.distance) + station_gap_) {
    const std::optional<double> beside = length_at(x, second.s);
    if (beside && !(s && distance_to(x, *s) <= distance_to(x, *beside))) s = beside;
  }
  if (!s) return std::nullopt;
  return on_section(x, *s);
}

// Undoes place().
template <class S>
auto CurveTable<S>::on_section(const Vec3d& x, double s) const -> std::optional<CurvePoint<double>> {
  if (s <= 0 || s >= length_) return beyond(s > 0, x);
  const Section<double> here = section(s);
  const Vec3d d = x - here.vector(kPlace);
  double y[2] = {inner(d, here.vector(kFirst)), inner(d, here.vector(kSecond))};
  const double per_length = per_cell_ / along(here[kStretch]);
  const double k[2] = {here[kBend] * per_length, here[kBend + 1] * per_length};
  const double u = k[0] * y[0] + k[1] * y[1];
  const double k2 = k[0] * k[0] + k[1] * k[1];
  if (!(u < (keeps_thickness_ ? 0.5 : 1))) return std::nullopt;
  const double less = !keeps_thickness_ && k2 * (y[0] * y[0] + y[1] * y[1]) > kFlat ? 0.5 * u * u / k2 : 0;
  const std::array<double, 2> narrow = narrowing(stretches_ ? here[kStretch] : 1.0);
  for (std::size_t i = 0; i < 2; ++i) y[i] = (y[i] - less * k[i]) * narrow[i];
  if (!twists_) return CurvePoint<double>{s, {y[0], y[1]}};
  const SinCos<double> turn = sincos(here[kTwistAngle]);
  return CurvePoint<double>{s, {y[0] * turn.cos + y[1] * turn.sin, y[1] * turn.cos - y[0] * turn.sin}};
}

template class CurveTable<double>;
template bool CurveTable<double>::place<double>(const CurvePoint<double>&, Vec3d&) const;

CurveSupport::CurveSupport(const Segment& segment)
    : tangent_(segment.curve.frame.row0),
      length_(segment.curve.length),
      radius_(segment.curve.radius),
      is_straight_(begins_straight(segment)) {
  const CurveMotion& curve = segment.curve;
  const bool is_held = curve.shift == Vec3d{0, 0, 0} && curve.turn == Vec3d{0, 0, 0};
  rests_ = {is_held && curve.anchor == 0, is_held && curve.anchor == curve.intervals() && curve.end_stretch == 0};
  first_ = curve.place - tangent_ * (curve.anchor * curve.spacing());
}

bool CurveSupport::misses(const Vec3d& center, double radius) const {
  if (!is_straight_) return false;
  const Vec3d d = center - first_;
  const double s = dot(d, tangent_);
  const double rounding = 1e-9 * (norm(d) + radius + length_);
  if (rests_[0] && s + radius < -rounding) return true;
  if (rests_[1] && s - radius > length_ + rounding) return true;
  return radius_ && norm(cross(d, tangent_)) - radius > *radius_ + rounding;
}

CurveMap::CurveMap(const Segment& segment)
    : origin_(segment.curve.place),
      begin_(segment.curve, segment.begin),
      end_(segment.curve, segment.end),
      radius_(segment.curve.radius),
      is_straight_(begins_straight(segment)) {
  rest_ = {begin_.end(false) == end_.end(false), begin_.end(true) == end_.end(true)};
}

std::optional<CurvePoint<double>> CurveMap::find(const Vec3d& x) const {
  return is_straight_ ? begin_.beyond(false, x - origin_) : begin_.find(x - origin_);
}

CurveMap::Status CurveMap::move(Vec3d& x) const {
  const std::optional<CurvePoint<double>> at = find(x);
  if (!at) return radius_ ? Status::rests : Status::impossible;
  const auto& [y1, y2] = at->across;
  if (rests(at->s) || (radius_ && !(y1 * y1 + y2 * y2 <= *radius_ * *radius_))) return Status::rests;
  Vec3d to;
  if (!end_.place(*at, to)) return Status::impossible;
  x += to - (x - origin_);
  return Status::moved;
}

CurveMap::Status CurveMap::move(Vec3d& x, Mat3d& jacobian) const {
  const Vec3d from = x;
  const Status status = move(x);
  jacobian = {};
  if (status != Status::moved) return status;
  const CurvePoint<double> at = *find(from);
  const auto by_place = [&](const CurveTable<double>& table) {
    const Vec3<Dual> v = variables(Vec3d{at.s, at.across[0], at.across[1]});
    Vec3<Dual> place;
    table.place(CurvePoint<Dual>{v.x, {v.y, v.z}}, place);
    return Mat3d{place.x.g, place.y.g, place.z.g};
  };
  const Mat3d before = by_place(begin_);
  const Vec3d c0 = cross(before.column(1), before.column(2));
  const Vec3d c1 = cross(before.column(2), before.column(0));
  const Vec3d c2 = cross(before.column(0), before.column(1));
  jacobian = by_place(end_) * (Mat3d{c0, c1, c2} * (1 / dot(before.column(0), c0)));
  return status;
}

std::vector<Vec3d> curve_velocities(const CurveMotion& curve, std::span<const Vec3d> points, double t) {
  const CurveTable<double> table(curve, t);
  const CurveTable<TimeDual> moving(curve, TimeDual(t, 1));
  std::vector<Vec3d> result;
  result.reserve(points.size());
  for (const Vec3d& x : points) {
    Vec3<TimeDual> v{};
    if (const std::optional<CurvePoint<double>> at = table.find(x - curve.place)) {
      const auto& [y1, y2] = at->across;
      if (!curve.radius || y1 * y1 + y2 * y2 <= *curve.radius * *curve.radius) {
        moving.place(CurvePoint<TimeDual>{TimeDual(at->s), {TimeDual(y1), TimeDual(y2)}}, v);
      }
    }
    result.push_back({v.x.g, v.y.g, v.z.g});
  }
  return result;
}

}  // namespace knead::detail
