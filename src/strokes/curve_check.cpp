// Whether a shape can follow a curve: slices of the shape across the curve are moved, and must not meet.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "flow/curve_map.h"
#include "knead/error.h"
#include "strokes/curve.h"

namespace knead::detail {

namespace {

constexpr int kSlices = 96;        // along the curve
constexpr int kSlicesBeyond = 24;  // at most, beyond an end
constexpr int kBetween = 4;        // places from slice to slice at which the curve may be too tight
constexpr int kTimes = 16;         // at which the slices are checked
constexpr int kBisections = 6;     // for the last time without a problem
constexpr std::size_t kSides = 8;  // of the outline of a slice

// The directions of an outline's sides.
std::array<Vec3d, kSides> sides() {
  const double half = std::sqrt(0.5);
  return {{{1, 0, 0},
           {half, half, 0},
           {0, 1, 0},
           {-half, half, 0},
           {-1, 0, 0},
           {-half, -half, 0},
           {0, -1, 0},
           {half, -half, 0}}};
}

// The shape near a plane across the curve, within straight sides at these distances.
struct Slice {
  double s = 0;
  std::array<double, kSides> reach{};
  bool is_empty = true;

  void add(const CurvePoint<double>& at) {
    static const std::array<Vec3d, kSides> directions = sides();
    for (std::size_t i = 0; i < kSides; ++i) {
      const double far = directions[i].x * at.across[0] + directions[i].y * at.across[1];
      reach[i] = is_empty ? far : std::max(reach[i], far);
    }
    is_empty = false;
  }

  // The corner after a side: where the neighbours' lines meet, or on the side that lies within.
  CurvePoint<double> corner(std::size_t i) const {
    static const std::array<Vec3d, kSides> directions = sides();
    const Vec3d& a = directions[i];
    const Vec3d& b = directions[(i + 1) % kSides];
    const double h = reach[i];
    const double k = reach[(i + 1) % kSides];
    const double area = a.x * b.y - a.y * b.x;
    return {s, {(h * b.y - k * a.y) / area, (k * a.x - h * b.x) / area}};
  }
};

// A slice at a time.
struct MovedSlice {
  std::size_t number = 0;
  std::array<Vec3d, kSides> corners;
  Vec3d middle;
  Vec3d normal{0, 0, 0};
  double radius = 0;
};

// Returns the part of two planes' common line that lies in a slice; nothing if the other plane misses the slice.
std::optional<std::pair<double, double>> part_of(const MovedSlice& slice, const MovedSlice& other, const Vec3d& line) {
  double low = kInfinity;
  double high = -kInfinity;
  for (std::size_t i = 0; i < kSides; ++i) {
    const Vec3d& a = slice.corners[i];
    const Vec3d& b = slice.corners[(i + 1) % kSides];
    const double from = dot(other.normal, a - other.middle);
    const double to = dot(other.normal, b - other.middle);
    if ((from < 0) == (to < 0)) continue;
    const double at = dot(line, a + (b - a) * (from / (from - to)));
    low = std::min(low, at);
    high = std::max(high, at);
  }
  if (low > high) return std::nullopt;
  return std::pair(low, high);
}

bool meet(const MovedSlice& a, const MovedSlice& b) {
  constexpr double kNoLine = 1e-9;
  if (norm(a.middle - b.middle) > a.radius + b.radius) return false;
  const Vec3d line = cross(a.normal, b.normal);
  if (norm(line) < kNoLine) return false;
  const auto of_a = part_of(a, b, line);
  if (!of_a) return false;
  const auto of_b = part_of(b, a, line);
  return of_b && of_a->first < of_b->second && of_b->first < of_a->second;
}

// Whether a point lies between two neighbouring slices.
bool lies_between(const Vec3d& p, const MovedSlice& a, const MovedSlice& b) {
  const double from = dot(a.normal, p - a.middle);
  const double to = dot(b.normal, p - b.middle);
  if (!(from > 0 && to < 0)) return false;
  const double share = from / (from - to);
  const Vec3d normal = a.normal + (b.normal - a.normal) * share;
  constexpr double kRounding = 1e-9;  // sides of no length are on no side
  for (std::size_t i = 0; i < kSides; ++i) {
    const std::size_t k = (i + 1) % kSides;
    const Vec3d first = a.corners[i] + (b.corners[i] - a.corners[i]) * share;
    const Vec3d next = a.corners[k] + (b.corners[k] - a.corners[k]) * share;
    if (dot(cross(next - first, p - first), normal) < -kRounding * a.radius * a.radius) return false;
  }
  return true;
}

// Returns whether a slice enters the space between two neighbouring slices, as in a ring that goes round twice.
bool reaches_into(const MovedSlice& slice, const MovedSlice& a, const MovedSlice& b) {
  if (norm(slice.middle - a.middle) > slice.radius + a.radius + norm(b.middle - a.middle)) return false;
  if (lies_between(slice.middle, a, b)) return true;
  constexpr double kWithin = 0.99;  // of the distance to a corner: slices that only touch do not meet
  return std::any_of(slice.corners.begin(), slice.corners.end(), [&](const Vec3d& corner) {
    const Vec3d by = corner - slice.middle;
    return lies_between(slice.middle + by * kWithin, a, b) || lies_between(slice.middle + by * 0.5, a, b);
  });
}

bool rests(const CurveMotion& curve, const CurvePoint<double>& at) {
  const auto& [y1, y2] = at.across;
  return curve.radius && y1 * y1 + y2 * y2 > *curve.radius * *curve.radius;
}

// Returns the lengths along a moved curve until places at equal distances at t = 0.
std::vector<double> lengths_of(const CurveTable<double>& table) {
  constexpr int kPlaces = kSlices * kBetween;
  std::vector<double> lengths{0};
  Vec3d before = table.end(false).place;
  for (int i = 1; i <= kPlaces; ++i) {
    Vec3d at;
    table.place(CurvePoint<double>{table.length() * i / kPlaces, {}}, at);
    lengths.push_back(lengths.back() + norm(at - before));
    before = at;
  }
  return lengths;
}

enum class Trouble { none, too_tight, meets };

// The slices of a shape about a curve.
class Body {
 public:
  Body(const CurveMotion& curve, const LiveSurface& surface) : curve_(curve) {
    const std::vector<std::optional<CurvePoint<double>>> places = places_of(surface.positions);
    double first = 0;
    double last = curve.length;
    for (const auto& place : places) {
      if (place) first = std::min(first, place->s), last = std::max(last, place->s);
    }
    lay_slices(first, last);
    for (const auto& place : places) {
      if (place) add(*place);
    }
    for (const Triangle& t : surface.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& a = places[t[i]];
        const auto& b = places[t[(i + 1) % 3]];
        if (a && b) add_between(*a, *b);
      }
    }
    fill_ends();
  }

  Trouble at(double time) const {
    const CurveTable<double> table(curve_, time);
    if (is_too_tight(table)) return Trouble::too_tight;
    std::vector<MovedSlice> moved;
    for (const Slice& slice : slices_) {
      if (slice.is_empty) continue;
      MovedSlice& to = moved.emplace_back();
      to.number = static_cast<std::size_t>(&slice - slices_.data());
      for (std::size_t i = 0; i < kSides; ++i) {
        table.place(slice.corner(i), to.corners[i]);
        to.middle += to.corners[i] / static_cast<double>(kSides);
      }
      for (std::size_t i = 0; i < kSides; ++i) {
        to.normal += cross(to.corners[i] - to.middle, to.corners[(i + 1) % kSides] - to.middle);
        to.radius = std::max(to.radius, norm(to.corners[i] - to.middle));
      }
      // The normal of a slice that is almost a point or a line would be rounding.
      constexpr double kThinnest = 1e-9;  // of the curve's length
      const double area = norm(to.normal);
      if (!(area > kThinnest * curve_.length * to.radius))
        moved.pop_back();
      else
        to.normal = to.normal / area;
    }
    return have_meeting(moved) ? Trouble::meets : Trouble::none;
  }

 private:
  // What is between two slices lies within the means of their sides.
  bool is_too_tight(const CurveTable<double>& table) const {
    for (std::size_t i = 0; i < slices_.size(); ++i) {
      const Slice& next = slices_[std::min(i + 1, slices_.size() - 1)];
      for (int k = 0; k < (next.is_empty ? 1 : kBetween) && !slices_[i].is_empty; ++k) {
        const double share = static_cast<double>(k) / kBetween;
        Slice between = slices_[i];
        between.s += (next.s - between.s) * share;
        for (std::size_t side = 0; side < kSides; ++side) {
          between.reach[side] += (next.reach[side] - between.reach[side]) * share;
        }
        for (std::size_t side = 0; side < kSides; ++side) {
          Vec3d place;
          if (!table.place(between.corner(side), place)) return true;
        }
      }
    }
    return false;
  }

  static bool have_meeting(const std::vector<MovedSlice>& moved) {
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const bool has_next = i + 1 < moved.size() && moved[i + 1].number == moved[i].number + 1;
      for (std::size_t j = 0; j < moved.size(); ++j) {
        if (j > i && meet(moved[i], moved[j])) return true;
        const bool is_neighbour = j == i || j == i + 1;
        if (has_next && !is_neighbour && reaches_into(moved[j], moved[i], moved[i + 1])) return true;
      }
    }
    return false;
  }

  // Returns nothing for a place beyond the radius, which rests.
  std::vector<std::optional<CurvePoint<double>>> places_of(std::span<const Vec3d> positions) const {
    const CurveTable<double> table(curve_, 0.0);
    std::vector<std::optional<CurvePoint<double>>> places;
    places.reserve(positions.size());
    for (const Vec3d& x : positions) {
      std::optional<CurvePoint<double>>& place = places.emplace_back(table.find(x - curve_.place));
      if (!place && !curve_.radius) {
        throw InvalidInput(fmt::format(
            "\"from\": the shape reaches to the curve's centre of curvature at [{:.4g}, {:.4g}, {:.4g}]; give a line "
            "that is straighter there",
            x.x, x.y, x.z));
      }
      if (place && rests(curve_, *place)) place.reset();
    }
    return places;
  }

  void lay_slices(double first, double last) {
    const auto lay = [&](double from, double to, int count) {
      for (int i = 0; i < count; ++i) slices_.emplace_back().s = from + (to - from) * i / count;
    };
    const double step = curve_.length / kSlices;
    const auto beyond = [&](double length) {
      return length > 0 ? std::clamp(static_cast<int>(std::ceil(length / step)), 1, kSlicesBeyond) : 0;
    };
    lay(first, 0, beyond(-first));
    lay(0, curve_.length, kSlices);
    lay(curve_.length, last, beyond(last - curve_.length));
    slices_.emplace_back().s = last;
  }

  // Where the curve is longer than the shape, the inverse of the motion still looks for points about it, unless it
  // knows the part that the shape is about.
  void fill_ends() {
    if (std::isfinite(curve_.part[0])) return;
    const auto has_shape = [](const Slice& slice) { return !slice.is_empty; };
    const auto first = std::find_if(slices_.begin(), slices_.end(), has_shape);
    const auto last = std::find_if(slices_.rbegin(), slices_.rend(), has_shape);
    if (first == slices_.end()) return;
    const auto fill = [](Slice& slice, const Slice& from) {
      slice.reach = from.reach;
      slice.is_empty = false;
    };
    for (auto i = slices_.begin(); i != first; ++i) fill(*i, *first);
    for (auto i = slices_.rbegin(); i != last; ++i) fill(*i, *last);
  }

  std::size_t slice_after(double s) const {
    const auto above = [](double at, const Slice& slice) { return at < slice.s; };
    return static_cast<std::size_t>(std::upper_bound(slices_.begin(), slices_.end(), s, above) - slices_.begin());
  }

  void add(const CurvePoint<double>& at) {
    const std::size_t after = slice_after(at.s);
    if (after < slices_.size()) slices_[after].add(at);
    if (after > 0) slices_[after - 1].add(at);
  }

  void add_between(const CurvePoint<double>& a, const CurvePoint<double>& b) {
    if (a.s > b.s) return add_between(b, a);
    for (std::size_t i = slice_after(a.s); i < slices_.size() && slices_[i].s < b.s; ++i) {
      const double f = (slices_[i].s - a.s) / (b.s - a.s);
      slices_[i].add({slices_[i].s,
                      {a.across[0] + (b.across[0] - a.across[0]) * f, a.across[1] + (b.across[1] - a.across[1]) * f}});
    }
  }

  const CurveMotion& curve_;
  std::vector<Slice> slices_;
};

// Returns advice with a number that works: a smaller angle, a greater radius, or a part of the motion.
std::string advice(const CurveStroke& stroke, double share) {
  constexpr double kMinShare = 0.01;
  if (share < kMinShare) return "give a \"from\" that is straighter";
  constexpr double kRounded = 0.994;  // to three digits
  const auto down = [&](double degrees) { return degrees * share * kRounded; };
  std::string twist;
  if (stroke.twist_deg != 0) twist = fmt::format("twist by at most {:.3g} degrees", down(stroke.twist_deg));
  const std::string too = twist.empty() ? "" : " and " + twist;
  if (stroke.angle_deg) return fmt::format("bend by at most {:.3g} degrees{}", down(*stroke.angle_deg), too);
  if (stroke.around)
    return fmt::format("wrap it round a radius of at least {:.3g}{}", *stroke.around / (share * kRounded), too);
  if (stroke.to.empty() && !twist.empty()) return twist;
  return fmt::format("give a line that bends at most {0:.2g} times as much (\"strength\" {0:.2g})",
                     std::floor(share * 100) / 100);
}

[[noreturn]] void refuse(const CurveStroke& stroke, Trouble trouble, double share) {
  const char* key = stroke.angle_deg         ? "angle_deg"
                    : stroke.around          ? "around"
                    : !stroke.to.empty()     ? "to"
                    : stroke.twist_deg != 0  ? "twist_deg"
                    : stroke.thickness       ? "thickness"
                    : stroke.thicker_by != 0 ? "thicker_by"
                                             : "longer_by";
  const char* const what =
      trouble == Trouble::meets
          ? "the shape would meet itself"
          : "the shape is too thick for so tight a bend: it reaches farther to the inner side than half the radius";
  throw InvalidInput(fmt::format("\"{}\": {}; {}", key, what, advice(stroke, share)));
}

// The tube in which a straight line moves something.
StrokeCylinder cylinder_of(const CurveStroke& stroke, const LiveSurface& surface, double radius) {
  const Vec3d along = normalized(stroke.from.back() - stroke.from.front());
  StrokeCylinder cylinder{stroke.from.front(), along, radius, 0, along};
  if (stroke.fixed == CurveFixed::start) cylinder.normal = -along;
  if (stroke.fixed == CurveFixed::end) cylinder.center = stroke.from.back();
  if (stroke.fixed == CurveFixed::middle) {
    for (const Vec3d& p : surface.positions) cylinder.outer = std::max(cylinder.outer, norm(p - cylinder.center));
    cylinder.outer *= 2;
  }
  cylinder.last_normal = cylinder.normal;
  return cylinder;
}

}  // namespace

void check_curve(const CurveStroke& stroke, const CurveStroke& given, const LiveSurface& surface) {
  if (stroke.radius && !surface.triangles.empty()) {
    const StrokeCylinder cylinder = cylinder_of(stroke, surface, *stroke.radius);
    const CylinderCheck found = check_limit_cylinder(cylinder, surface.positions, surface.triangles);
    if (found.crossing > 0) {
      const std::optional<double> other = nearest_radius(found, *stroke.radius);
      throw InvalidInput(fmt::format("\"radius\" {:g} would tear {} triangles; {}", *stroke.radius, found.crossing,
                                     other ? fmt::format("{} tears none", *other) : "leave it out"));
    }
  }
  const CurveMotion motion = motion_of(stroke);
  const Body body(motion, surface);
  double sound = 0;
  for (int i = 1; i <= kTimes; ++i) {
    double failing = surface.part * i / kTimes;
    Trouble trouble = body.at(failing);
    if (trouble == Trouble::none) {
      sound = failing;
      continue;
    }
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (sound + failing);
      const Trouble there = body.at(middle);
      if (there != Trouble::none) trouble = there;
      (there == Trouble::none ? sound : failing) = middle;
    }
    refuse(given, trouble, sound);
  }
}

void check_inverse_of_curve(const CurveStroke& stroke, const LiveSurface& surface) {
  // An edge inside half a turn at half its radius is shorter than the curve by pi.
  constexpr double kMaxLengthPerEdge = 4;
  const CurveMotion motion = motion_of(stroke);
  const CurveTable<double> table(motion, surface.part);
  const std::vector<double> lengths = lengths_of(table);
  const auto length_at = [&](double s) {
    const double at = std::clamp(s / table.length(), 0.0, 1.0) * static_cast<double>(lengths.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(at), lengths.size() - 2);
    return std::lerp(lengths[i], lengths[i + 1], at - static_cast<double>(i)) + std::min(s, 0.0) +
           std::max(s - table.length(), 0.0) * table.end(true).along;
  };
  std::vector<std::optional<double>> along;
  along.reserve(surface.positions.size());
  for (const Vec3d& x : surface.positions) {
    const std::optional<CurvePoint<double>> place = table.find(x - motion.place);
    along.push_back(place && !rests(motion, *place) ? std::optional(length_at(place->s)) : std::nullopt);
  }
  for (const Triangle& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i];
      const std::uint32_t b = t[(i + 1) % 3];
      if (!along[a] || !along[b]) continue;
      const Vec3d edge = surface.positions[b] - surface.positions[a];
      if (!(std::abs(*along[b] - *along[a]) > kMaxLengthPerEdge * norm(edge))) continue;
      const Vec3d& at = surface.positions[a];
      throw InvalidInput(fmt::format(
          "the stroke has no inverse for this shape: near [{:.4g}, {:.4g}, {:.4g}] the next turn of the curve is "
          "nearer than the shape's own; keep the shape from before the stroke",
          at.x, at.y, at.z));
    }
  }
}

void find_radius(CurveStroke& stroke, const LiveSurface& surface, std::vector<std::string>& remarks) {
  const CylinderProposal proposal =
      propose_limit_cylinder(cylinder_of(stroke, surface, 1), surface.positions, surface.triangles);
  if (!proposal.radius) throw InvalidInput("\"radius\": \"auto\" finds none: " + proposal.problem);
  if (std::isinf(proposal.others)) {
    remarks.push_back(fmt::format(
        "\"radius\": \"auto\" is {}: all that moves lies within it, so that it restricts nothing", *proposal.radius));
  }
  stroke.radius = proposal.radius;
  stroke.radius_auto = false;
}

}  // namespace knead::detail
