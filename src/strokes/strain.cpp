// Stretches of a surface, or of the space around points, by a flow.
#include "knead/editor/tools.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "field/grid.h"
#include "flow/lattice_map.h"
#include "flow/segment_mover.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/vec.h"
#include "math/elementary.h"
#include "math/geometry.h"

namespace knead {

namespace {

// As for carried normals: they leave about 1e-5 of a stretch to the errors of the path lines.
constexpr double kTolerance = 1e-5;  // of the step
constexpr std::size_t kPathLines = 7;
// The greatest difference of two opposite neighbours where the map is smooth, relative to their mean displacement. The
// flow of a tool bends by less over 1e-4 of the shape.
constexpr double kTorn = 0.5;
constexpr std::size_t kMaxWeights = 4'000'000;
constexpr std::size_t kPointsAtOnce = 1024;

// One column of the Jacobian from a point's image and those of its neighbours on both sides. Near a limit cylinder's
// border one of them may have been torn off.
Vec3d column_of(const Vec3d& before, const Vec3d& here, const Vec3d& after, double step) {
  const Vec3d back = here - before;
  const Vec3d forth = after - here;
  const double least = std::min(norm(back), norm(forth));
  if (norm(forth - back) <= kTorn * (norm(back) + norm(forth))) return (after - before) / (2 * step);
  return (least == norm(back) ? back : forth) / step;
}

Stretches stretches_at(std::span<const Vec3d> images, double step) {
  const bool is_finite =
      std::all_of(images.begin(), images.end(), [](const Vec3d& p) { return std::isfinite(norm2(p)); });
  if (!is_finite) return {kInfinity, 1, 0};
  const Vec3d x = column_of(images[1], images[0], images[2], step);
  const Vec3d y = column_of(images[3], images[0], images[4], step);
  const Vec3d z = column_of(images[5], images[0], images[6], step);
  return stretches_of(Mat3d{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}});
}

// Whether the inner motion deforms, so that the inner region is stretched too.
bool deforms(const Motion& motion) {
  return !std::holds_alternative<Translation<double>>(motion) && !std::holds_alternative<Rotation<double>>(motion);
}

// Returns the change of r at a point while a half-space turns: the inner region turns as much against it.
double turn_slack(const Region& region, const Vec3d& d) {
  const auto* half_space = std::get_if<HalfSpace<double>>(&region);
  if (half_space == nullptr || half_space->turn_angle == 0) return 0;
  const double turn = std::min(std::abs(half_space->turn_angle), 0.5 * std::numbers::pi);
  return std::abs(dot(cross(half_space->turn_axis, half_space->normal), d)) * sincos(turn).sin;
}

// Whether a field deforms a point at the beginning, or where the tool passes over it.
bool is_deformed(const Segment& segment, const Field& field, const Vec3d& p) {
  const Vec3d d = p - field.center;
  const Vec3d by = displacement_of(segment, field);
  const double slack = turn_slack(field.region, d);
  for (const double t : {0.0, 0.5, 1.0}) {
    const double r = region_value(field, d - by * t).value;
    const double most = blend_weight(r - slack, field.thresholds).value;
    const double least = blend_weight(r + slack, field.thresholds).value;
    if (most > 0 && (least < 1 || deforms(field.motion))) return true;
    if (by == Vec3d{0, 0, 0}) break;
  }
  return false;
}

bool is_deformed(const Segment& segment, const Vec3d& p) {
  if (!segment.parts.empty()) {
    return std::any_of(segment.parts.begin(), segment.parts.end(),
                       [&](const Segment& part) { return is_deformed(part, p); });
  }
  if (!segment.curve.is_empty()) return true;
  if (!segment.lattice.is_empty()) return !detail::LatticeSupport(segment).misses(p, 0);
  if (!segment.grid.is_empty()) return detail::is_used(segment.grid, p);
  if (segment.limit_cylinder && !detail::is_within(*segment.limit_cylinder, p)) return false;
  return std::any_of(segment.fields.begin(), segment.fields.end(),
                     [&](const Field& field) { return is_deformed(segment, field, p); });
}

// The numbers of the candidates of greatest_stretch, ascending.
std::vector<std::size_t> candidates(const Flow& flow, std::span<const Vec3d> positions, int threads) {
  const std::size_t weights = flow.segments.size() * positions.size();
  const std::size_t stride = weights / kMaxWeights + 1;
  const std::size_t count = (positions.size() + stride - 1) / stride;
  std::vector<std::uint8_t> is_candidate(count);
  parallel_for(count, kPointsAtOnce, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto deformed = [&](const Segment& segment) { return is_deformed(segment, positions[i * stride]); };
      is_candidate[i] = std::any_of(flow.segments.begin(), flow.segments.end(), deformed) ? 1 : 0;
    }
  });
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < count; ++i) {
    if (is_candidate[i] != 0) result.push_back(i * stride);
  }
  return result;
}

double badness(const Stretches& s) { return s.least > 0 ? std::max(s.greatest, 1 / s.least) : HUGE_VAL; }

}  // namespace

Stretches stretches_of(const Mat3d& gradient) {
  std::array<Vec3d, 3> columns{gradient.column(0), gradient.column(1), gradient.column(2)};
  detail::orthogonalise(columns);
  std::array<double, 3> values{norm(columns[0]), norm(columns[1]), norm(columns[2])};
  std::sort(values.begin(), values.end());
  return {values[2], values[1], values[0]};
}

std::vector<Stretches> stretches_of(const Flow& flow, std::span<const Vec3d> points, const StrainOptions& options) {
  AdvectOptions advecting;
  advecting.tolerance = absolute_tolerance(kTolerance * options.step, options.length);
  advecting.precision = Precision::float64;
  advecting.threads = options.threads;
  const double step = options.step * options.length;
  std::vector<Vec3d> lines;
  lines.reserve(kPathLines * points.size());
  for (const Vec3d& p : points) {
    lines.push_back(p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3d d{0, 0, 0};
      d[axis] = step;
      lines.insert(lines.end(), {p - d, p + d});
    }
  }
  std::vector<Stretches> result(points.size());
  const bool is_done = advect(flow, lines, advecting).status == AdvectStatus::done;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::span<const Vec3d> images = std::span(lines).subspan(kPathLines * i, kPathLines);
    result[i] = is_done ? stretches_at(images, step) : Stretches{kInfinity, 1, 0};
  }
  return result;
}

GreatestStretch greatest_stretch(const Flow& flow, std::span<const Vec3d> positions, const StrainOptions& options) {
  const std::vector<std::size_t> found = candidates(flow, positions, options.threads);
  std::vector<Vec3d> sample;
  const std::size_t count = std::min(found.size(), options.samples);
  for (std::size_t i = 0; i < count; ++i) sample.push_back(positions[found[i * found.size() / count]]);
  GreatestStretch result;
  double worst = 1;
  result.samples = count;
  const std::vector<Stretches> stretches = stretches_of(flow, sample, options);
  for (std::size_t i = 0; i < count; ++i) {
    result.greatest = std::max(result.greatest, stretches[i].greatest);
    result.least = std::min(result.least, stretches[i].least);
    if (i > 0 && badness(stretches[i]) <= worst) continue;
    worst = badness(stretches[i]);
    result.where = sample[i];
  }
  return result;
}

}  // namespace knead
