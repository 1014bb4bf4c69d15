// The tool "handles": one set of points moves, another one stays.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include "knead/error.h"
#include "knead/vec.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

// A warning says if the distance between the moving and the fixed set falls below this fraction of that at the start.
constexpr double kClosePass = 0.1;
// The numbers of points of a set, and of moments of its motion, that warnings check.
constexpr std::size_t kMaxLookedAt = 300;
constexpr int kMoments = 64;

void validate_set(std::string_view key, const std::vector<Vec3d>& points, const std::vector<std::uint32_t>& vertices) {
  if (!points.empty() && !vertices.empty()) {
    throw InvalidInput(fmt::format("\"{}\" must not be given together with \"{}_vertices\"", key, key));
  }
  if (vertices.empty()) require_count(key, points.size(), 1, "points");
}

void validate_motion(const HandlesTranslation& motion) { require_finite("translate", motion.by); }

void validate_motion(const HandlesRotation& motion) {
  require_direction("rotate", motion.axis);
  require_finite("center", motion.center);
  require_angle("angle_deg", motion.angle_deg);
}

// Returns a member of both sets, if there is one.
template <class T, class Less>
const T* common(const std::vector<T>& a, std::vector<T> b, Less less) {
  std::sort(b.begin(), b.end(), less);
  const auto in_b = [&](const T& x) { return std::binary_search(b.begin(), b.end(), x, less); };
  const auto found = std::find_if(a.begin(), a.end(), in_b);
  return found == a.end() ? nullptr : &*found;
}

void require_apart(const HandlesStroke& stroke) {
  if (const std::uint32_t* both = common(stroke.full_vertices, stroke.zero_vertices, std::less<>())) {
    throw InvalidInput(
        fmt::format("\"zero_vertices\" must have nothing in common with \"full_vertices\", but vertex {} is in both; "
                    "leave a gap between the sets",
                    *both));
  }
  const auto before = [](const Vec3d& p, const Vec3d& q) { return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z); };
  if (const Vec3d* both = common(stroke.full, stroke.zero, before)) {
    throw InvalidInput(fmt::format(
        "\"zero\" must have nothing in common with \"full\", but the point [{}, {}, {}] is in both; leave a "
        "gap between the sets",
        both->x, both->y, both->z));
  }
}

PointSet<double> set_about(const std::vector<Vec3d>& points, const Vec3d& c, int exponent) {
  PointSet<double> set;
  set.exponent = exponent;
  set.points.reserve(points.size());
  for (const Vec3d& p : points) set.points.push_back(p - c);
  return set;
}

// Relative to the first point, so that nothing is lost far from the origin.
Vec3d mean(const std::vector<Vec3d>& points) {
  Vec3d sum{0, 0, 0};
  for (const Vec3d& p : points) sum += p - points.front();
  return points.front() + sum / static_cast<double>(points.size());
}

Segment segment_of(const HandlesStroke& stroke, const HandlesTranslation& motion) {
  const Vec3d c = mean(stroke.full);
  Handles<double> region{set_about(stroke.full, c, stroke.exponent), set_about(stroke.zero, c, stroke.exponent)};
  region.sweep = motion.by;
  return transported_segment({c, Translation<double>{motion.by}, std::move(region), {0, 1}}, motion.by);
}

Segment segment_of(const HandlesStroke& stroke, const HandlesRotation& motion) {
  const Vec3d& c = motion.center;
  Handles<double> region{set_about(stroke.full, c, stroke.exponent), set_about(stroke.zero, c, stroke.exponent)};
  region.turn_axis = unit(motion.axis);
  region.turn_angle = motion.angle_deg * kRadiansPerDegree;
  const Rotation<double> rotation{region.turn_axis, region.turn_angle};
  return resting_segment({c, rotation, std::move(region), {0, 1}});
}

// At most kMaxLookedAt of the points, evenly through the list.
std::vector<Vec3d> thinned(const std::vector<Vec3d>& points) {
  const std::size_t stride = (points.size() + kMaxLookedAt - 1) / kMaxLookedAt;
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < points.size(); i += stride) result.push_back(points[i]);
  return result;
}

// Returns the least distance between the sets. They are sorted along their longest extent, so that a point is compared
// only with points that are near along it.
double gap(std::vector<Vec3d> full, std::vector<Vec3d> zero) {
  Box box = bounding_box(full);
  for (const Vec3d& p : zero) box.extend(p);
  const Vec3d size = box.max - box.min;
  const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  const auto before = [axis](const Vec3d& p, const Vec3d& q) { return p[axis] < q[axis]; };
  std::sort(full.begin(), full.end(), before);
  std::sort(zero.begin(), zero.end(), before);
  double least = kInfinity;
  for (const Vec3d& p : full) {
    auto q = std::lower_bound(zero.begin(), zero.end(), p[axis] - least,
                              [axis](const Vec3d& other, double bound) { return other[axis] < bound; });
    for (; q != zero.end() && (*q)[axis] < p[axis] + least; ++q) least = std::min(least, norm(p - *q));
  }
  return least;
}

std::vector<Vec3d> at_moment(const std::vector<Vec3d>& points, const HandlesTranslation& motion, double t) {
  std::vector<Vec3d> result = points;
  for (Vec3d& p : result) p += motion.by * t;
  return result;
}

std::vector<Vec3d> at_moment(const std::vector<Vec3d>& points, const HandlesRotation& motion, double t) {
  const SinCos<double> turn = sincos(motion.angle_deg * kRadiansPerDegree * t);
  std::vector<Vec3d> result = points;
  for (Vec3d& p : result) p = motion.center + rotate(p - motion.center, unit(motion.axis), turn);
  return result;
}

// Returns the least distance between the sets during the motion.
double least_gap(const HandlesStroke& stroke, const std::vector<Vec3d>& full, const std::vector<Vec3d>& zero) {
  double least = kInfinity;
  for (int i = 0; i <= kMoments; ++i) {
    const double t = static_cast<double>(i) / kMoments;
    const auto moved = std::visit([&](const auto& motion) { return at_moment(full, motion, t); }, stroke.motion);
    least = std::min(least, gap(moved, zero));
  }
  return least;
}

std::vector<StrokeKey> keys(HandlesStroke& s) {
  return {{"full", Quantity::finite, &s.full, Presence::optional},
          {"full_vertices", Quantity::other, &s.full_vertices, Presence::not_empty},
          {"zero", Quantity::finite, &s.zero, Presence::optional},
          {"zero_vertices", Quantity::other, &s.zero_vertices, Presence::not_empty},
          {"motion", Quantity::other, &s.motion, Presence::required, "angle of the rotation"},
          {"exponent", Quantity::other, &s.exponent, Presence::optional}};
}

void prepare(HandlesStroke& /*stroke*/, const HasKey& has) {
  for (const char* key : {"full", "zero"}) {
    const bool as_points = has(key);
    if (as_points != has(std::string(key) + "_vertices")) continue;
    throw InvalidInput(fmt::format(R"(a handles stroke has either "{}" or "{}_vertices", {})", key, key,
                                   as_points ? "not both" : "got neither"));
  }
}

void validate(const HandlesStroke& stroke) {
  validate_set("full", stroke.full, stroke.full_vertices);
  validate_set("zero", stroke.zero, stroke.zero_vertices);
  std::visit([](const auto& motion) { validate_motion(motion); }, stroke.motion);
  require_even("exponent", stroke.exponent, 2);
  require_apart(stroke);
}

bool reads_surface(const HandlesStroke& stroke) {
  return !stroke.full_vertices.empty() || !stroke.zero_vertices.empty();
}

Flow flow_of(const HandlesStroke& stroke) {
  return {{std::visit([&](const auto& motion) { return segment_of(stroke, motion); }, stroke.motion)}};
}

void warn(const HandlesStroke& stroke, Warnings& warnings) {
  if (stroke.full.empty() || stroke.zero.empty()) return;  // given by vertices, whose places are not known yet
  const std::vector<Vec3d> full = thinned(stroke.full);
  const std::vector<Vec3d> zero = thinned(stroke.zero);
  const double between = gap(stroke.full, stroke.zero);
  const double at_start = gap(full, zero);
  const double on_the_way = least_gap(stroke, full, zero);
  if (on_the_way < kClosePass * at_start) {
    warnings.push_back(fmt::format(
        "the full set comes within {:.2g} of the zero set along its path ({:.2g} at the start): the material "
        "between them is squeezed out sideways; move it less far, or around the zero set in several strokes",
        on_the_way, at_start));
  }
  const Vec3d c = mean(full);
  double radius2 = 0;
  for (const Vec3d& p : full) radius2 = std::max(radius2, norm2(p - c));
  const double back = 0.5 * std::sqrt(radius2) / between;
  if (std::holds_alternative<HandlesTranslation>(stroke.motion) && back > kStrongReturn) {
    warnings.push_back(fmt::format(
        "the full set is wide for the gap of {:.2g} to the zero set: between them the flow runs back at up to "
        "{:.2g} times the tool's speed; leave a wider gap",
        between, back));
  }
}

void prolong(HandlesStroke& stroke, double strength) {
  if (auto* translation = std::get_if<HandlesTranslation>(&stroke.motion)) translation->by *= strength;
  if (auto* rotation = std::get_if<HandlesRotation>(&stroke.motion)) rotation->angle_deg *= strength;
}

// Returns the points of a set that is given by its vertices.
void look_up(const char* key, std::span<const Vec3d> positions, std::vector<std::uint32_t>& vertices,
             std::vector<Vec3d>& points) {
  for (const std::uint32_t vertex : vertices) {
    require_vertex(key, positions, vertex);
    points.push_back(positions[vertex]);
  }
  vertices.clear();
}

void resolve(const HandlesStroke& stroke, SurfaceRun& run) {
  HandlesStroke named = stroke;
  look_up("full_vertices", run.surface.positions, named.full_vertices, named.full);
  look_up("zero_vertices", run.surface.positions, named.zero_vertices, named.zero);
  run.remarks = warnings(named);
  run.surface.apply(named);
}

std::string words(const HandlesStroke& stroke, const std::string& unit) {
  const auto* const rotation = std::get_if<HandlesRotation>(&stroke.motion);
  if (rotation != nullptr) return "Handles " + degrees_text(rotation->angle_deg);
  return "Handles " + length_text(norm(std::get<HandlesTranslation>(stroke.motion).by), unit);
}

}  // namespace

constinit const detail::ToolRow<HandlesStroke> HandlesStroke::tool{.name = "handles",
                                                                   .keys = keys,
                                                                   .prepare = prepare,
                                                                   .validate = validate,
                                                                   .reads_surface = reads_surface,
                                                                   .resolve = resolve,
                                                                   .flow = flow_of,
                                                                   .warn = warn,
                                                                   .words = words,
                                                                   .prolong = prolong};

}  // namespace knead
