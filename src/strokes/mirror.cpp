// Images of strokes that act at the same time: their sum.
#include "strokes/mirror.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "field/grid.h"
#include "flow/culling.h"
#include "flow/segment_map.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/vec.h"
#include "math/geometry.h"
#include "strokes/describe.h"

namespace knead {

namespace {

constexpr std::size_t kMaxPlanes = 3;
constexpr double kRightAngle = 1e-9;  // the greatest cosine of one
constexpr double kSameBox = 1e-6;     // of the same size, for the supports' boxes
constexpr std::size_t kMaxAnchors = 12;

// The axis to which the plane is at a right angle, exactly.
std::optional<std::size_t> axis_of(const MirrorPlane& plane) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d rest = plane.normal;
    rest[axis] = 0;
    if (rest == Vec3d{0, 0, 0}) return axis;
  }
  return std::nullopt;
}

std::optional<unsigned> coordinate_plane(const MirrorPlane& plane) {
  const std::optional<std::size_t> axis = axis_of(plane);
  return axis && plane.point[*axis] == 0 ? std::optional(1U << *axis) : std::nullopt;
}

// Returns for each axis the position of the mirror plane at a right angle to it, if there is one.
std::array<std::optional<double>, 3> planes_of(const Mirror& mirror) {
  std::array<std::optional<double>, 3> planes;
  for (const MirrorPlane& plane : mirror) {
    if (const std::optional<std::size_t> axis = axis_of(plane)) planes[*axis] = plane.point[*axis];
  }
  return planes;
}

// Places around a place that a field moves, at which its motion is compared with others; `directions`: columns of a
// rotation.
void add_places(const Vec3d& anchor, double size, std::vector<Vec3d>& places, const Mat3d& directions = {}) {
  for (const Vec3d& by :
       {Vec3d{0.31, 0.17, -0.23}, Vec3d{-0.29, 0.41, 0.13}, Vec3d{0.07, -0.53, 0.37}, Vec3d{-0.11, -0.19, -0.61}}) {
    places.push_back(anchor + directions * (by * size));
  }
}

void add_anchors(const PointSet<double>& set, const Vec3d& center, std::vector<Vec3d>& anchors) {
  for (const Vec3d& p : set.points) anchors.push_back(center + p);
  for (const auto& curve : set.curves) anchors.push_back(center + curve.front());
}

// Where a field moves points, and over which length it changes.
double find_anchors(const Field& field, std::vector<Vec3d>& anchors) {
  const Vec3d& c = field.center;
  anchors = {c};
  if (const auto* capsule = std::get_if<Capsule<double>>(&field.region)) {
    anchors = {c - capsule->half_axis, c + capsule->half_axis};
  } else if (const auto* space = std::get_if<HalfSpace<double>>(&field.region)) {
    anchors = {c + space->normal * (0.5 * (field.thresholds.inner + field.thresholds.outer))};
    return field.thresholds.outer - field.thresholds.inner;
  } else if (const auto* set = std::get_if<PointSet<double>>(&field.region)) {
    anchors.clear();
    add_anchors(*set, c, anchors);
  } else if (const auto* handles = std::get_if<Handles<double>>(&field.region)) {
    anchors.clear();
    add_anchors(handles->full, c, anchors);
    add_anchors(handles->zero, c, anchors);
    return norm(anchors.back() - anchors.front());
  }
  return field.thresholds.outer;
}

std::vector<Vec3d> places_in(const Segment& segment) {
  std::vector<Vec3d> places;
  if (!segment.grid.is_empty()) {
    const Box box = detail::box_in_use(segment.grid);
    if (box.empty()) return places;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const auto share = [&](unsigned axis) { return (corner >> axis & 1U) != 0 ? 0.75 : 0.25; };
      const Vec3d at{share(0), share(1), share(2)};
      const Vec3d by = box.max - box.min;
      add_places(box.min + Vec3d{at.x * by.x, at.y * by.y, at.z * by.z}, 0.3 * norm(by), places);
    }
    return places;
  }
  for (std::size_t i = 0; i < segment.fields.size(); i += segment.fields.size() / kMaxAnchors + 1) {
    std::vector<Vec3d> anchors;
    const double size = find_anchors(segment.fields[i], anchors);
    for (std::size_t k = 0; k < anchors.size(); k += anchors.size() / kMaxAnchors + 1) {
      add_places(anchors[k], size, places);
    }
  }
  return places;
}

bool have_same_limit_cylinder(const std::optional<LimitCylinder>& a, const std::optional<LimitCylinder>& b) {
  if (!a || !b) return !a && !b;
  const Vec3d by = b->center - a->center;
  return std::abs(a->radius - b->radius) <= kSameImage * a->radius && norm(cross(a->axis, b->axis)) <= kSameImage &&
         norm(cross(a->axis, by)) <= kSameImage * a->radius;
}

// Returns whether two images of a segment move every point alike, up to rounding.
bool are_same(const Segment& a, const Segment& b) {
  if (a == b) return true;
  if (!have_same_limit_cylinder(a.limit_cylinder, b.limit_cylinder)) return false;
  const Box of_a = detail::support_of(a);
  const Box of_b = detail::support_of(b);
  const double size = of_a.diagonal();
  if (std::isfinite(size) && !of_a.empty() &&
      !(are_near(of_a.min, of_b.min, kSameBox * size) && are_near(of_a.max, of_b.max, kSameBox * size))) {
    return false;
  }
  const std::vector<Vec3d> places = places_in(a);
  double greatest = 0;
  double difference = 0;
  for (const double time : {0.0, 0.5, 1.0}) {
    const std::vector<Vec3d> by_a = velocities(Flow{{a}}, places, time);
    const std::vector<Vec3d> by_b = velocities(Flow{{b}}, places, time);
    for (std::size_t i = 0; i < places.size(); ++i) {
      greatest = std::max({greatest, norm(by_a[i]), norm(by_b[i])});
      difference = std::max(difference, norm(by_a[i] - by_b[i]));
    }
    if (difference > kSameImage * greatest) return false;
  }
  return true;
}

// Multiplies the speed of a motion.
struct Slow {
  double factor;

  void operator()(Translation<double>& motion) const { motion.velocity = motion.velocity * factor; }
  void operator()(Rotation<double>& motion) const { motion.rate *= factor; }
  void operator()(Twist<double>& motion) const { motion.rate *= factor; }
  void operator()(Strain<double>& motion) const { motion.matrix = motion.matrix * factor; }
  void operator()(CustomMotion& /*motion*/) const {}  // no stroke has one
};

// Returns the sum of one segment of the stroke and those of its images. If they overlap, the sum is slowed down, so
// that nothing moves much faster than by one of them alone.
Segment sum_of(const std::vector<Segment>& images, const Mirror& mirror) {
  Segment sum;
  for (const Segment& image : images) {
    const auto is_it = [&](const Segment& other) { return are_same(other, image); };
    if (std::none_of(sum.parts.begin(), sum.parts.end(), is_it)) sum.parts.push_back(image);
  }
  if (sum.parts.size() == 1) return images.front();
  sum.mirrored_at = planes_of(mirror);
  const double speed = speed_of_images(sum);
  if (!(speed > 1)) return sum;
  for (Segment& part : sum.parts) {
    for (Field& field : part.fields) std::visit(Slow{1 / speed}, field.motion);
  }
  return sum;
}

// Returns the directions in which places lie about tools without an end, such as a twist: they turn with the tool and
// its image. About other tools add_overlaps() finds more places, so these are the axes.
Mat3d directions_about(const Segment& sum) {
  const std::vector<Field>& own = sum.parts.front().fields;
  const std::vector<Field>& others = sum.parts.back().fields;
  if (own.empty() || others.empty()) return {};
  std::vector<Vec3d> anchors;
  std::vector<Vec3d> images;
  const double size = find_anchors(own.front(), anchors);
  find_anchors(others.front(), images);
  Vec3d along{0, 0, 0};
  if (const auto* space = std::get_if<HalfSpace<double>>(&own.front().region)) along = space->normal;
  if (std::holds_alternative<Handles<double>>(own.front().region)) along = anchors.back() - anchors.front();
  if (!(norm(along) > 0)) return {};
  const Vec3d x = normalized(along);
  Vec3d axis{0, 0, 0};
  if (const auto* rotation = std::get_if<Rotation<double>>(&own.front().motion)) axis = rotation->axis * size;
  if (const auto* twist = std::get_if<Twist<double>>(&own.front().motion)) axis = twist->axis * size;
  Vec3d y = any_orthogonal(x);
  for (const Vec3d& towards : {axis, images.front() - anchors.front()}) {
    const Vec3d across = towards - x * dot(x, towards);
    constexpr double kMinAcross = 1e-6;  // of the size; a shorter one is rounding
    if (norm(across) > kMinAcross * size) y = normalized(across);
  }
  return transposed(Mat3d{x, y, cross(x, y)});
}

// Returns places in and around the tool at a time; those of all images have the same order.
std::vector<Vec3d> places_in_tool(const Segment& segment, double time, const Mat3d& directions) {
  std::vector<Vec3d> places;
  for (std::size_t i = 0; i < segment.fields.size(); i += segment.fields.size() / kMaxAnchors + 1) {
    const Field& field = segment.fields[i];
    std::vector<Vec3d> anchors;
    const double size = find_anchors(field, anchors);
    for (std::size_t k = 0; k < anchors.size(); k += anchors.size() / kMaxAnchors + 1) {
      const Vec3d place = anchors[k] + displacement_of(segment, field) * time;
      places.push_back(place);
      for (const double reach : {field.thresholds.inner, field.thresholds.bump, size}) {
        add_places(place, reach, places, directions);
      }
    }
  }
  return places;
}

// Returns places throughout the overlap of the first part with other ones; elsewhere it acts alone.
void add_overlaps(const Segment& sum, std::vector<Vec3d>& places) {
  constexpr int along = 11;  // odd: some places lie in the plane
  const Box first = detail::support_of(sum.parts.front());
  for (std::size_t i = 1; i < sum.parts.size(); ++i) {
    Box both = detail::support_of(sum.parts[i]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      both.min[axis] = std::max(both.min[axis], first.min[axis]);
      both.max[axis] = std::min(both.max[axis], first.max[axis]);
    }
    if (both.empty() || !std::isfinite(both.diagonal())) continue;
    const Vec3d cell = (both.max - both.min) / along;
    for (int k = 0; k < along * along * along; ++k) {
      const Vec3d at{k % along + 0.5, k / along % along + 0.5, k / (along * along) + 0.5};
      places.push_back(both.min + Vec3d{at.x * cell.x, at.y * cell.y, at.z * cell.z});
    }
  }
}

// Places in the tools of all parts, and between them.
std::vector<Vec3d> places_in_tools(const Segment& sum, double time) {
  std::vector<Vec3d> places;
  const Mat3d directions = directions_about(sum);
  for (const Segment& part : sum.parts) {
    const std::vector<Vec3d> own = places_in_tool(part, time, directions);
    const std::size_t count = std::min(own.size(), places.size());
    for (std::size_t i = 0; i < count; ++i) places.push_back((own[i] + places[i]) * 0.5);
    places.insert(places.begin(), own.begin(), own.end());
  }
  add_overlaps(sum, places);
  return places;
}

bool do_overlap(std::span<const Segment> parts) {
  std::vector<Box> supports;
  for (const Segment& part : parts) {
    const Box support = detail::support_of(part);
    const auto meets = [&](const Box& other) { return overlap(support, other); };
    if (std::any_of(supports.begin(), supports.end(), meets)) return true;
    supports.push_back(support);
  }
  return false;
}

double greatest_speed(const Segment& segment, std::span<const Vec3d> places, double time) {
  double greatest = 0;
  for (const Vec3d& v : velocities(Flow{{segment}}, places, time)) greatest = std::max(greatest, norm(v));
  return greatest;
}

}  // namespace

void validate(const Mirror& mirror) {
  if (mirror.size() > kMaxPlanes) {
    throw InvalidInput(fmt::format("\"mirror\" must be 1 to {} planes, got {}", kMaxPlanes, mirror.size()));
  }
  for (std::size_t i = 0; i < mirror.size(); ++i) {
    if (!is_finite(mirror[i].point)) throw InvalidInput("\"mirror\" must have a finite \"point\"");
    const double length = norm(mirror[i].normal);
    if (!(std::isfinite(length) && length > 0)) {
      throw InvalidInput("\"mirror\" must have a \"normal\" of a finite length above 0");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (std::abs(dot(normalized(mirror[k].normal), normalized(mirror[i].normal))) > kRightAngle) {
        throw InvalidInput(
            fmt::format("\"mirror\" must have planes at right angles; planes {} and {} are not", k + 1, i + 1));
      }
    }
  }
}

Mirror coordinate_mirror(std::string_view names) {
  Mirror mirror;
  for (const auto& [name, normal] : {std::pair{'x', Vec3d{1, 0, 0}}, {'y', {0, 1, 0}}, {'z', {0, 0, 1}}}) {
    if (names.find(name) != std::string_view::npos) mirror.push_back({normal});
  }
  if (mirror.empty() || mirror.size() != names.size()) {
    throw InvalidInput(
        fmt::format(R"("mirror" must be some of the letters x, y and z, such as "x" or "xz", got "{}")", names));
  }
  return mirror;
}

std::vector<SymmetryImage> images_in(const Mirror& mirror) {
  // As Segment::mirrored_at has coordinate planes, in the order of their axes.
  Mirror planes = mirror;
  std::stable_sort(planes.begin(), planes.end(), [](const MirrorPlane& a, const MirrorPlane& b) {
    return axis_of(a).value_or(3) < axis_of(b).value_or(3);
  });
  std::vector<SymmetryImage> images;
  const auto is_coordinate = [](const MirrorPlane& plane) { return coordinate_plane(plane).has_value(); };
  const bool exact = std::all_of(planes.begin(), planes.end(), is_coordinate);
  for (unsigned mask = 1; mask < 1U << planes.size(); ++mask) {
    SymmetryImage image;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      if ((mask >> i & 1U) == 0) continue;
      image.motion = image.motion * reflection_in(planes[i].point, planes[i].normal);
      if (exact) image.planes |= *coordinate_plane(planes[i]);
    }
    images.push_back(image);
  }
  return images;
}

Flow flow_of(const Stroke& stroke, const Mirror& mirror) {
  if (mirror.empty()) return flow_of(stroke);
  validate(mirror);
  validate(stroke);
  if (tool_of(stroke).is_event) throw InvalidInput(fmt::format("a {} has no \"mirror\"", tool_name(stroke)));
  const std::optional<Stroke> whole = reads_surface(stroke) ? std::nullopt : with_images(stroke, mirror, {});
  if (whole) {
    Flow flow = flow_of(*whole);
    for (Segment& segment : flow.segments) segment.mirrored_at = planes_of(mirror);
    return flow;
  }
  std::vector<Flow> flows{flow_of(stroke)};
  if (std::any_of(flows[0].segments.begin(), flows[0].segments.end(), detail::is_map)) {
    throw InvalidInput(fmt::format(
        "\"mirror\": a {} and its image cannot act at the same time; make two strokes of them", tool_name(stroke)));
  }
  for (const SymmetryImage& image : images_in(mirror)) {
    flows.push_back(flow_of(image_of(stroke, image, {})));
    if (flows.back().segments.size() != flows.front().segments.size()) {
      throw InvalidInput("\"mirror\": two places of the stroke are too near to each other to be mirrored");
    }
  }
  Flow result;
  for (std::size_t i = 0; i < flows.front().segments.size(); ++i) {
    std::vector<Segment> images;
    images.reserve(flows.size());
    for (Flow& flow : flows) images.push_back(std::move(flow.segments[i]));
    result.segments.push_back(sum_of(images, mirror));
  }
  return result;
}

std::optional<Stroke> with_images(const Stroke& stroke, const Mirror& mirror, std::span<const Vec3d> positions) {
  return detail::with_row(stroke, [&](const auto& row, const auto& own) -> std::optional<Stroke> {
    if (row.with_images == nullptr) return std::nullopt;
    return row.with_images(own, mirror, positions);
  });
}

double speed_of_images(const Segment& segment) {
  if (!do_overlap(segment.parts)) return 1;
  double of_sum = 0;
  double of_one = 0;
  for (const double time : {0.0, 0.5, 1.0}) {
    const std::vector<Vec3d> places = places_in_tools(segment, time);
    of_sum = std::max(of_sum, greatest_speed(segment, places, time));
    // The places are not mirror images of each other, so that each part is seen at other ones.
    for (const Segment& part : segment.parts) of_one = std::max(of_one, greatest_speed(part, places, time));
  }
  return of_one > 0 ? of_sum / of_one : 1;
}

std::vector<StrokeCylinder> limit_cylinders_of(const Stroke& stroke, const Mirror& mirror) {
  std::vector<StrokeCylinder> limit_cylinders;
  std::vector<Segment> segments;
  const auto add = [&](const Stroke& image) {
    const std::optional<StrokeCylinder> limit_cylinder = limit_cylinder_of(image);
    if (!limit_cylinder) return;
    Segment segment = flow_of(image).segments.front();
    const auto is_it = [&](const Segment& other) { return are_same(other, segment); };
    if (std::any_of(segments.begin(), segments.end(), is_it)) return;
    segments.push_back(std::move(segment));
    limit_cylinders.push_back(*limit_cylinder);
  };
  add(stroke);
  if (limit_cylinders.empty()) return limit_cylinders;
  for (const SymmetryImage& image : images_in(mirror)) add(image_of(stroke, image, {}));
  return limit_cylinders;
}

}  // namespace knead
