// The tool "bend": bends a part about an axis; by large angles its body.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/vec.h"
#include "mesh/edges.h"
#include "strokes/curve.h"
#include "strokes/describe.h"
#include "strokes/pose.h"

namespace knead {

namespace {

using namespace detail;

constexpr double kEnd = 0.03;           // of the zone's width, at both its ends, stays straight
constexpr double kSpacing = 0.06;       // of the grids, of the diagonal; less where the zone is short
constexpr double kMinSpacing = 0.02;    // of the diagonal
constexpr double kSpacingOfZone = 0.5;  // of the zone's width, at most
constexpr double kMaxBending = 0.45;    // the half thickness over the arc's radius
constexpr double kStraight = 1e-9;      // radians below which there is no arc
constexpr double kMaxDistance = 0.02;   // of the diagonal: of the part from its place

Thresholds<double> bend_thresholds(const BendStroke& stroke) {
  if (const auto* given = std::get_if<BendThresholds>(&stroke.extent)) {
    return {given->inner, given->outer, stroke.falloff};
  }
  const auto& extent = std::get<BendWidth>(stroke.extent);
  const double fraction = extent.center_fraction.value_or(falloff_facts(stroke.falloff).half);
  return {-fraction * extent.width, (1 - fraction) * extent.width, stroke.falloff};
}

// The coordinates of a bend, and the arc that its zone becomes.
class Arc {
 public:
  explicit Arc(const BendStroke& stroke)
      : between_(bend_thresholds(stroke)),
        normal_(unit(stroke.normal)),
        angle_(stroke.angle_deg * kRadiansPerDegree),
        root_(stroke.center) {
    const double end = kEnd * (between_.outer - between_.inner);
    between_.inner += end;
    between_.outer -= end;
    root_ += normal_ * between_.outer;
    axis_ = normalized(stroke.axis - normal_ * dot(normal_, stroke.axis));
    side_ = cross(normal_, axis_);
  }

  double inner() const { return between_.inner; }
  double outer() const { return between_.outer; }
  double width() const { return between_.outer - between_.inner; }
  double angle() const { return angle_; }
  const Vec3d& axis() const { return axis_; }
  double height(const Vec3d& p) const { return between_.outer + dot(normal_, p - root_); }
  double offset(const Vec3d& p) const { return dot(side_, p - root_); }
  double from_line(const Vec3d& p) const {
    const Vec3d d = p - root_;
    return norm(d - normal_ * dot(normal_, d));
  }

  Vec3d point(double height) const { return root_ + normal_ * (height - between_.outer); }

  // Moves the arc from the centre to the middle of the part's points. Returns the thickness of the part.
  double center_on(std::span<const Vec3d> points) {
    double least = kInfinity;
    double most = -least;
    for (const Vec3d& p : points) {
      least = std::min(least, offset(p));
      most = std::max(most, offset(p));
    }
    root_ += side_ * (0.5 * (least + most));
    return most - least;
  }

  // Returns the place of a point of the moving part at a time from 0 to 1.
  Vec3d place(const Vec3d& start, double time) const {
    const Vec3d d = start - root_;
    const SinCos<double> turn = sincos(angle_ * time);
    const double curvature = angle_ * time / width();
    const bool is_straight = std::abs(angle_ * time) < kStraight;
    const double ahead = is_straight ? width() : turn.sin / curvature;
    const double aside = is_straight ? 0 : (1 - turn.cos) / curvature;
    return root_ - normal_ * ahead + side_ * aside +
           (side_ * turn.sin - normal_ * turn.cos) * (-dot(normal_, d) - width()) +
           (side_ * turn.cos + normal_ * turn.sin) * dot(side_, d) + axis_ * dot(axis_, d);
  }

 private:
  Thresholds<double> between_;
  Vec3d normal_;  // a unit vector, from the part that moves to the rest
  double angle_;  // radians
  Vec3d root_;    // where the arc begins
  Vec3d axis_;    // unit vectors across the normal; a positive angle bends towards the side
  Vec3d side_;
};

enum class Role : std::uint8_t { rests, bends, moves, none };  // none: no triangle uses the vertex

std::vector<Role> roles_by_radius(const BendStroke& stroke, const Arc& arc, std::span<const Vec3d> positions) {
  std::vector<Role> roles(positions.size(), Role::rests);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double height = arc.height(positions[i]);
    if (height >= arc.outer() || (stroke.radius && arc.from_line(positions[i]) > *stroke.radius)) continue;
    roles[i] = height <= arc.inner() ? Role::moves : Role::bends;
  }
  return roles;
}

// Joins the vertices of edges whose two ends are chosen.
DisjointSets pieces_of(const LiveSurface& surface, const std::vector<bool>& chosen) {
  DisjointSets sets(surface.positions.size());
  for (const Triangle& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (chosen[t[i]] && chosen[t[(i + 1) % 3]]) sets.join(t[i], t[(i + 1) % 3]);
    }
  }
  return sets;
}

// Returns the vertex in the zone that is nearest to its centre; vertices without triangles do not count.
std::optional<std::uint32_t> middle_of_zone(const BendStroke& stroke, const LiveSurface& surface,
                                            const std::vector<bool>& in_zone) {
  std::optional<std::uint32_t> nearest;
  double least = kInfinity;
  for (const Triangle& t : surface.triangles) {
    for (const std::uint32_t v : t) {
      const double distance = norm(surface.positions[v] - stroke.center);
      if (!in_zone[v] || !(distance < least)) continue;
      least = distance;
      nearest = v;
    }
  }
  return nearest;
}

struct Parts {
  std::vector<Role> roles;
  bool is_joined_twice = false;  // the part that moves is also joined to the rest elsewhere
};

// Finds the parts by connectivity: the zone's piece nearest to the centre bends, and the vertices connected to it on
// the side of `inner` move. Returns nothing if the zone has no vertex.
std::optional<Parts> parts_by_pieces(const BendStroke& stroke, const Arc& arc, const LiveSurface& surface) {
  const std::size_t count = surface.positions.size();
  std::vector<bool> bends(count);
  for (std::size_t v = 0; v < count; ++v) {
    const double height = arc.height(surface.positions[v]);
    bends[v] = height > arc.inner() && height < arc.outer();
  }
  const std::optional<std::uint32_t> middle = middle_of_zone(stroke, surface, bends);
  if (!middle) return std::nullopt;
  DisjointSets zones = pieces_of(surface, bends);
  for (std::uint32_t v = 0; v < count; ++v) bends[v] = bends[v] && zones.find(v) == zones.find(*middle);
  std::vector<bool> others = bends;
  others.flip();
  DisjointSets pieces = pieces_of(surface, others);
  constexpr std::uint8_t kMoves = 1;
  constexpr std::uint8_t kRests = 2;
  std::vector<std::uint8_t> touches(count, 0);  // at a piece's number: the ends of the zone that it is joined to
  for (const Triangle& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (const std::uint32_t other : {t[(i + 1) % 3], t[(i + 2) % 3]}) {
        if (!bends[t[i]] || bends[other]) continue;
        touches[pieces.find(other)] |= arc.height(surface.positions[other]) <= arc.inner() ? kMoves : kRests;
      }
    }
  }
  Parts parts{std::vector<Role>(count, Role::rests)};
  for (std::uint32_t v = 0; v < count; ++v) {
    const std::uint8_t touched = bends[v] ? 0 : touches[pieces.find(v)];
    if (bends[v]) parts.roles[v] = Role::bends;
    if (touched == kMoves) parts.roles[v] = Role::moves;
    parts.is_joined_twice = parts.is_joined_twice || touched == (kMoves | kRests);
  }
  return parts;
}

std::vector<Role> without_strays(const std::vector<Role>& roles, const LiveSurface& surface) {
  std::vector<Role> result(roles.size(), Role::none);
  for (const Triangle& t : surface.triangles) {
    for (const std::uint32_t v : t) result[v] = roles[v];
  }
  return result;
}

std::vector<Role> roles_of(const BendStroke& stroke, const Arc& arc, const LiveSurface& surface) {
  if (surface.triangles.empty()) return roles_by_radius(stroke, arc, surface.positions);
  if (!stroke.radius_auto) return without_strays(roles_by_radius(stroke, arc, surface.positions), surface);
  std::optional<Parts> parts = parts_by_pieces(stroke, arc, surface);
  if (!parts) return {};
  if (parts->is_joined_twice) {
    throw InvalidInput(
        "\"radius\": the part that would move is also joined to the rest elsewhere, so it cannot bend away from it; "
        "choose another place, or give \"radius\" as a number");
  }
  return without_strays(parts->roles, surface);
}

std::vector<Vec3d> where(std::span<const Vec3d> positions, const std::vector<Role>& roles, Role role) {
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    if (roles[i] == role) result.push_back(positions[i]);
  }
  return result;
}

// A zone that is too short for the part that bends in it.
struct ShortZone {
  double width = 0;
  double thickness = 0;     // of the part
  double angle_deg = 0;     // the greatest for this zone
  double enough_width = 0;  // for the angle and this part; a wider zone may hold a thicker one
};

std::optional<ShortZone> short_zone(const BendStroke& stroke, const LiveSurface& surface) {
  Arc arc(stroke);
  const std::vector<Vec3d> bending = where(surface.positions, roles_of(stroke, arc, surface), Role::bends);
  if (bending.empty()) return std::nullopt;
  const double thickness = arc.center_on(bending);
  const double turn = std::abs(arc.angle());
  if (arc.width() * kMaxBending >= 0.5 * thickness * turn) return std::nullopt;
  constexpr double kRound = 1.011;  // the number is rounded down to three digits
  return ShortZone{arc.width() / (1 - 2 * kEnd), thickness,
                   std::floor(2 * arc.width() * kMaxBending / thickness / kRadiansPerDegree),
                   rounded_down(0.5 * thickness * turn / kMaxBending * kRound / (1 - 2 * kEnd))};
}

// Returns advice to make the zone so wide that it is not too short; nothing where that leaves nothing to move.
std::string wider_zone(BendStroke stroke, double width, const LiveSurface& surface) {
  constexpr int kMaxTries = 8;
  const Thresholds<double> zone = bend_thresholds(stroke);
  for (int i = 0; i < kMaxTries; ++i) {
    const double by = width / (zone.outer - zone.inner);
    stroke.extent = BendThresholds{zone.inner * by, zone.outer * by};
    try {
      if (const std::optional<ShortZone> found = short_zone(stroke, surface)) {
        width = found->enough_width;
        continue;
      }
      if (where(surface.positions, roles_of(stroke, Arc(stroke), surface), Role::moves).empty()) return {};
      return fmt::format(", or make the zone {:.3g} wide or wider", width);
    } catch (const InvalidInput&) {
      return {};
    }
  }
  return {};
}

// Returns the problem of the bend. The middle of the zone is free: it follows with the least strain.
PoseProblem problem_of(const BendStroke& stroke, const LiveSurface& surface, int threads,
                       std::vector<std::string>& warnings) {
  Arc arc(stroke);
  const std::vector<Role> roles = roles_of(stroke, arc, surface);
  const std::vector<Vec3d> bending = where(surface.positions, roles, Role::bends);
  if (bending.empty()) {
    throw InvalidInput(
        "\"width\": no vertex of the shape lies in the zone that would bend; make the zone wider, move \"center\" "
        "into the part, or remesh the shape");
  }
  arc.center_on(bending);
  PoseProblem problem;
  problem.threads = threads;
  problem.progress = surface.progress;
  problem.diagonal = diagonal_of(surface);
  problem.spacing =
      std::max(kMinSpacing * problem.diagonal, std::min(kSpacing * problem.diagonal, kSpacingOfZone * arc.width()));
  problem.across = arc.axis();
  problem.body = body_of(surface, problem.spacing, kSamplesInside, threads, warnings);
  problem.body.stiffness.clear();  // one stiffness everywhere keeps the volume of a bar with few vertices better
  std::vector<Vec3d> rests;
  std::vector<Vec3d> moves;
  const auto assign = [&](const Vec3d& p, Role role) {
    const bool bends = role == Role::bends;
    const double height = arc.height(p);
    if (role == Role::rests || (bends && height >= arc.outer())) rests.push_back(p);
    if (role == Role::moves || (bends && height <= arc.inner())) moves.push_back(p);
  };
  for (std::size_t i = 0; i < roles.size(); ++i) assign(surface.positions[i], roles[i]);
  if (moves.empty()) {
    throw InvalidInput(
        "\"center\": nothing of the shape lies where the bend would move it; move the zone towards "
        "what should stay");
  }
  // If vertices are few, the body's samples represent its parts better.
  const std::vector<std::uint32_t> nearest = nearest_of(surface.positions, problem.body.points);
  for (std::size_t i = 0; i < nearest.size(); ++i) assign(problem.body.points[i], roles[nearest[i]]);
  if (!rests.empty()) problem.parts.push_back(part_of(rests, problem.spacing));
  PosedPart& part = problem.parts.emplace_back(part_of(moves, problem.spacing));
  part.angle = arc.angle();
  part.way = [arc](const Vec3d& start, double time) { return arc.place(start, time); };
  return problem;
}

bool is_spoiled(const PoseResult& result) {
  return std::max(result.greatest_stretch, 1 / result.least_stretch) > kStrongStretch ||
         result.part_distance > kMaxDistance;
}

// A bend that was solved.
struct SolvedBend {
  Flow flow;
  PoseResult result;
  double diagonal = 0;
};

SolvedBend solved(const BendStroke& stroke, const LiveSurface& surface, int threads) {
  SolvedBend solved;
  PoseProblem problem = problem_of(stroke, surface, threads, solved.result.warnings);
  solved.diagonal = problem.diagonal;
  const PoseOutcome outcome = find_flow(std::move(problem), solved.flow);
  solved.result.part_distance = outcome.part_distance / solved.diagonal;
  solved.result.unknowns = outcome.unknowns;
  solved.result.segments = outcome.segments;
  measure_stretch(solved.flow, surface, solved.diagonal, threads, solved.result);
  return solved;
}

// Returns the fraction of a bend's segments that spoil nothing.
double sound_share(const SolvedBend& bend, const LiveSurface& surface, int threads) {
  const std::size_t count = bend.flow.segments.size() - 1;  // the last one takes no time
  std::size_t sound = 0;
  std::size_t spoiled = count;
  while (sound + 1 < spoiled) {
    const std::size_t middle = (sound + spoiled) / 2;
    PoseResult result;
    measure_stretch(prefix(bend.flow, static_cast<double>(middle)), surface, bend.diagonal, threads, result);
    (is_spoiled(result) ? spoiled : sound) = middle;
  }
  return static_cast<double>(sound) / static_cast<double>(count);
}

// Refuses a bend, with advice to use an angle that was tried, at most this one. One that needs no body needs no trial.
[[noreturn]] void refuse(BendStroke stroke, double angle, const LiveSurface& surface, int threads,
                         const std::string& what, const std::string& or_else) {
  constexpr double kLess = 0.92;
  const double sign = stroke.angle_deg < 0 ? -1 : 1;
  // Ever larger steps: each trial takes seconds.
  for (double less = kLess; angle >= 1; angle = std::floor(less * angle), less *= kLess) {
    stroke.angle_deg = sign * angle;
    if (!reads_surface(stroke) || !is_spoiled(solved(stroke, surface, threads).result)) break;
  }
  if (angle < 1) throw InvalidInput(fmt::format("{}; choose another \"center\"{}", what, or_else));
  throw InvalidInput(fmt::format("{}; bend by at most {:.0f} degrees{}", what, sign * angle, or_else));
}

[[noreturn]] void refuse(const BendStroke& stroke, double angle, const LiveSurface& surface, int threads) {
  refuse(stroke, angle, surface, threads, "\"angle_deg\": the part would meet itself or the rest",
         ", or make the zone wider");
}

void require_long_zone(const BendStroke& stroke, const LiveSurface& surface, int threads) {
  const std::optional<ShortZone> zone = short_zone(stroke, surface);
  if (!zone) return;
  refuse(stroke, zone->angle_deg, surface, threads,
         fmt::format("\"angle_deg\": a zone {:.3g} wide is too short for {:.4g} degrees and a part {:.3g} thick",
                     zone->width, std::abs(stroke.angle_deg), zone->thickness),
         wider_zone(stroke, zone->enough_width, surface));
}

// The surface of a part of few triangles, with vertices in the zone of a bend.
struct SplitSurface {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;

  // Divides each triangle into four.
  void split() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(positions.size()));
      if (is_new) positions.push_back((positions[a] + positions[b]) * 0.5);
      return at->second;
    };
    std::vector<Triangle> parts;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b);
      const std::uint32_t bc = middle(b, c);
      const std::uint32_t ca = middle(c, a);
      parts.insert(parts.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(parts);
  }
};

// Returns nothing if a vertex lies in the zone.
std::optional<SplitSurface> split_for(const BendStroke& stroke, const LiveSurface& surface) {
  constexpr std::size_t most = 50'000;
  const Arc arc(stroke);
  const auto is_in_zone = [&](const Vec3d& p) { return arc.height(p) > arc.inner() && arc.height(p) < arc.outer(); };
  if (std::any_of(surface.positions.begin(), surface.positions.end(), is_in_zone)) return std::nullopt;
  SplitSurface result{{surface.positions.begin(), surface.positions.end()},
                      {surface.triangles.begin(), surface.triangles.end()}};
  const auto is_long = [&](const Triangle& t) {
    const double limit = 0.25 * arc.width();
    const auto& p = result.positions;
    return std::max({norm(p[t[1]] - p[t[0]]), norm(p[t[2]] - p[t[1]]), norm(p[t[0]] - p[t[2]])}) > limit;
  };
  const auto any_long = [&] { return std::any_of(result.triangles.begin(), result.triangles.end(), is_long); };
  while (result.triangles.size() < most && any_long()) result.split();
  return result;
}

// |a x n| and |a.n| of unit vectors below which they count as parallel, and as perpendicular.
constexpr double kParallel = 1e-9;
constexpr double kPerpendicular = 1e-3;

std::vector<StrokeKey> keys(BendStroke& s) {
  auto* const width = std::get_if<BendWidth>(&s.extent);
  auto* const zone = std::get_if<BendThresholds>(&s.extent);
  return {
      {"center", Quantity::finite, &s.center},
      {"axis", Quantity::direction, &s.axis},
      {"normal", Quantity::direction, &s.normal},
      {"angle_deg", Quantity::angle, &s.angle_deg, Presence::required, "rotation of the part that moves"},
      {"width", Quantity::positive, width != nullptr ? &width->width : nullptr, Presence::required,
       "of the zone that bends"},
      {"center_fraction", Quantity::finite, width != nullptr ? &width->center_fraction : nullptr, Presence::optional},
      {"inner", Quantity::other, zone != nullptr ? &zone->inner : nullptr, Presence::required,
       "where the part that moves begins"},
      {"outer", Quantity::other, zone != nullptr ? &zone->outer : nullptr, Presence::required,
       "where the part that stays begins"},
      {"gauge", Quantity::finite, &s.gauge, Presence::optional},
      {"radius", Quantity::positive, AutoNumber{&s.radius, &s.radius_auto}, Presence::optional,
       "of the limit cylinder"}};
}

void prepare(BendStroke& stroke, const HasKey& has) {
  const bool by_width = has("width") || has("center_fraction");
  const bool by_thresholds = has("inner") || has("outer");
  if (by_width == by_thresholds) {
    throw InvalidInput(std::string(R"(a bend has either "width" (and "center_fraction") or "inner" and "outer", )") +
                       (by_width ? "not both" : "got neither"));
  }
  if (by_thresholds) stroke.extent = BendThresholds{};
}

void validate(const BendStroke& stroke) {
  if (norm(cross(unit(stroke.axis), unit(stroke.normal))) < kParallel) {
    throw InvalidInput("\"normal\" must not be parallel to \"axis\": a bend turns it about the axis");
  }
  const Thresholds<double> thresholds = bend_thresholds(stroke);
  require_thresholds(thresholds.inner, thresholds.outer);
}

bool reads_surface(const BendStroke& stroke) {
  return stroke.radius_auto || std::abs(stroke.angle_deg) > kMaxOfPlainBend;
}

Flow flow_of(const BendStroke& stroke) {
  const Vec3d axis = unit(stroke.axis);
  const Vec3d normal = unit(stroke.normal);
  const double angle = stroke.angle_deg * kRadiansPerDegree;
  const Rotation<double> motion{axis, angle, stroke.gauge, RotationGauge::axial};
  const HalfSpace<double> region{normal, axis, 0.5 * angle};
  Segment segment = resting_segment({stroke.center, motion, region, bend_thresholds(stroke)});
  if (stroke.radius) segment.limit_cylinder = LimitCylinder{stroke.center, normal, *stroke.radius};
  return {{std::move(segment)}};
}

void warn(const BendStroke& stroke, Warnings& warnings) {
  if (std::abs(dot(unit(stroke.axis), unit(stroke.normal))) > kPerpendicular) {
    warnings.push_back(
        "\"normal\" is not perpendicular to \"axis\", so the bend is skewed; make it perpendicular for a plain bend");
  }
}

// Returns a strong bend of a whole shape as a curve, which needs no solve; nothing if the shape would meet itself or
// extend too far to the inner side.
std::optional<CurveStroke> as_curve(const BendStroke& stroke, const LiveSurface& surface) {
  if (std::abs(stroke.angle_deg) <= kMaxOfPlainBend || stroke.radius || stroke.radius_auto) return std::nullopt;
  Arc arc(stroke);
  std::vector<Vec3d> zone;
  for (const Vec3d& p : surface.positions) {
    if (arc.height(p) > arc.inner() && arc.height(p) < arc.outer()) zone.push_back(p);
  }
  arc.center_on(zone.empty() ? surface.positions : zone);
  CurveStroke curve;
  curve.from = {arc.point(bend_thresholds(stroke).outer), arc.point(bend_thresholds(stroke).inner)};
  curve.angle_deg = stroke.angle_deg;
  curve.axis = arc.axis();
  curve.fixed = CurveFixed::start;
  try {
    check_curve(curve, curve, surface);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  return curve;
}

void resolve(const BendStroke& stroke, SurfaceRun& run) {
  if (const std::optional<CurveStroke> curve = as_curve(stroke, run.surface)) {
    run.surface.apply(*curve);
    return;
  }
  if (!bends_body(stroke, run.surface)) return resolve_radius(stroke, run);
  run.remarks = bend_on(stroke, run.surface, run.threads).warnings;
}

std::string words(const BendStroke& stroke, const std::string& /*unit*/) {
  return "Bend " + degrees_text(stroke.angle_deg);
}

// A bend between given thresholds keeps them, and its centre moves with the place where the weight is one half.
void keep_zone(BendStroke& stroke, int falloff) {
  auto* const zone = std::get_if<BendThresholds>(&stroke.extent);
  if (zone == nullptr) return;
  const double moved = falloff_facts(falloff).half - falloff_facts(stroke.falloff).half;
  const double shift = moved * (zone->outer - zone->inner);
  stroke.center += unit(stroke.normal) * shift;
  zone->inner -= shift;
  zone->outer -= shift;
}

void zone(const BendStroke& stroke, StrokeZone& zone) {
  zone.center = stroke.center;
  zone.normal = unit(stroke.normal);
  zone.side = normalized(cross(zone.normal, unit(stroke.axis)));
  zone.radius = stroke.radius;
  zone.between = bend_thresholds(stroke);
  zone.angle = std::abs(stroke.angle_deg) * kRadiansPerDegree;
  zone.degrees = stroke.angle_deg;
  zone.gauge = stroke.gauge;
}

void set_zone(BendStroke& stroke, const StrokeZone& zone) {
  stroke.center = zone.center;
  stroke.gauge = zone.gauge;
  if (auto* const extent = std::get_if<BendWidth>(&stroke.extent)) {
    extent->width = zone.width();
  } else {
    stroke.extent = BendThresholds{zone.between.inner, zone.between.outer};
  }
}

}  // namespace

bool bends_body(const BendStroke& stroke, const LiveSurface& surface) {
  if (std::abs(stroke.angle_deg) > kMaxOfPlainBend) return true;
  if (!stroke.radius_auto || surface.triangles.empty()) return false;
  const Arc arc(stroke);
  const std::optional<Parts> parts = parts_by_pieces(stroke, arc, surface);
  if (!parts || parts->is_joined_twice) return false;
  for (std::size_t i = 0; i < parts->roles.size(); ++i) {
    if (parts->roles[i] == Role::moves && arc.height(surface.positions[i]) > arc.inner()) return true;
  }
  BendStroke any = stroke;
  any.radius_auto = false;
  any.radius = 1;
  return !propose_limit_cylinder(*limit_cylinder_of(any), surface.positions, surface.triangles).radius;
}

PoseResult bend_on(const BendStroke& stroke, const LiveSurface& live, int threads) {
  if (live.positions.empty()) return {};
  LiveSurface surface = live;
  const std::optional<SplitSurface> split = split_for(stroke, live);
  if (split) {
    surface.positions = split->positions;
    surface.triangles = split->triangles;
  }
  require_long_zone(stroke, surface, threads);
  constexpr double kFullTurn = 360;  // closes a ring
  constexpr double kMaxTurn = 345;
  if (std::abs(stroke.angle_deg) >= kFullTurn) refuse(stroke, kMaxTurn, surface, threads);
  SolvedBend bend = solved(stroke, surface, threads);
  if (is_spoiled(bend.result)) {
    refuse(stroke, std::floor(std::abs(stroke.angle_deg) * sound_share(bend, surface, threads)), surface, threads);
  }
  bend.result.stopped = !apply_grids(bend.flow, live);
  return std::move(bend.result);
}

constinit const detail::ToolRow<BendStroke> BendStroke::tool{.name = "bend",
                                                             .keys = keys,
                                                             .prepare = prepare,
                                                             .validate = validate,
                                                             .reads_surface = reads_surface,
                                                             .resolve = resolve,
                                                             .flow = flow_of,
                                                             .warn = warn,
                                                             .words = words,
                                                             .keep_zone = keep_zone,
                                                             .zone = zone,
                                                             .set_zone = set_zone};

}  // namespace knead
