// The tool "pins": points that move exactly to their places, or hold.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "strokes/describe.h"
#include "strokes/mirror.h"

namespace knead {

namespace {

using namespace detail;

constexpr std::size_t kMaxPins = 2000;
// The greatest number of pairs of pins within the radius of each other: their equations take about 15 s and 300 MB.
constexpr std::size_t kMaxPairs = 200'000;
// Two pins nearer than this fraction of the radius count as one place; different motions of these are a contradiction.
constexpr double kOnePlace = 1e-6;
constexpr double kContradiction = 1e-3;
// Of the radius "auto": the factor of the median distance to the third nearest pin, and of the longest displacement.
constexpr double kSpacings = 2;
constexpr double kDisplacements = 2;
constexpr std::size_t kNeighbor = 3;
// The stretch is measured before the flow is used, and in every batch of a drag. So only as many pins as a pack holds
// are measured: the pin that differs most from others, and those nearest to it. Near the first of them the flow of the
// pack is close enough to that of all pins.
constexpr std::size_t kPack = 200;
constexpr std::size_t kCore = 40;
constexpr double kStrongStretchOfPins = 10;

Vec3d motion_of(const PinsStroke& stroke, std::size_t i) { return stroke.to[i] - stroke.points[i]; }

// Radians over the stroke.
Vec3d rate_of(const PinsStroke& stroke, std::size_t i) {
  if (stroke.turn.empty() || !stroke.turn[i]) return {0, 0, 0};
  return unit(stroke.turn[i]->axis) * (stroke.turn[i]->angle_deg * kRadiansPerDegree);
}

// Returns the distance of the third nearest other pin, or of the farthest if there are fewer.
double distance_to_neighbor(const PinsStroke& stroke, std::size_t i) {
  std::vector<double> square;
  for (std::size_t j = 0; j < stroke.points.size(); ++j) {
    if (j != i) square.push_back(norm2(stroke.points[j] - stroke.points[i]));
  }
  if (square.empty()) return 0;
  const auto chosen = square.begin() + static_cast<std::ptrdiff_t>(std::min(kNeighbor, square.size()) - 1);
  std::nth_element(square.begin(), chosen, square.end());
  return std::sqrt(*chosen);
}

double automatic_radius(const PinsStroke& stroke) {
  std::vector<double> spacings;
  double longest = 0;
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    spacings.push_back(distance_to_neighbor(stroke, i));
    longest = std::max(longest, norm(motion_of(stroke, i)));
  }
  const auto median = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), median, spacings.end());
  return std::max(kSpacings * *median, kDisplacements * longest);
}

double radius_of(const PinsStroke& stroke) { return stroke.radius ? *stroke.radius : automatic_radius(stroke); }

// The time at which two pins are nearest to each other, and their distance then.
struct Approach {
  double t = 0;
  double distance = 0;
};

Approach approach_of(const PinsStroke& stroke, std::size_t i, std::size_t j) {
  const Vec3d d = stroke.points[i] - stroke.points[j];
  const Vec3d u = motion_of(stroke, i) - motion_of(stroke, j);
  const double t = norm2(u) > 0 ? std::clamp(-dot(d, u) / norm2(u), 0.0, 1.0) + 0.0 : 0.0;  // no -0
  return {t, norm(d + u * t)};
}

// Calls body with every two pins, the first numbers first.
template <class Body>
void for_pairs(const PinsStroke& stroke, const Body& body) {
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    for (std::size_t j = i + 1; j < stroke.points.size(); ++j) body(i, j);
  }
}

std::vector<StrokeKey> keys(PinsStroke& s) {
  return {{"points", Quantity::finite, &s.points},
          {"to", Quantity::finite, &s.to},
          {"radius", Quantity::positive, AutoNumber{&s.radius, &s.radius_auto}, Presence::required,
           "everything farther from all pins stays"},
          {"turn", Quantity::other, &s.turn, Presence::optional}};
}

// Returns the number of vectors of unknowns of a pin.
std::size_t unknowns_of(const PinsStroke& stroke, std::size_t i) {
  return !stroke.turn.empty() && stroke.turn[i] ? 4 : 1;
}

void require_solvable(const PinsStroke& stroke, double radius) {
  std::size_t pairs = 0;
  for_pairs(stroke, [&](std::size_t i, std::size_t j) {
    const Approach nearest = approach_of(stroke, i, j);
    if (nearest.distance < radius) pairs += unknowns_of(stroke, i) * unknowns_of(stroke, j);
    const bool together = motion_of(stroke, i) == motion_of(stroke, j);
    if (nearest.distance > (together ? kOnePlace : kContradiction) * radius) return;
    throw InvalidInput(together ? fmt::format("\"points\": pins {} and {} are at the same place; remove one", i, j)
                                : fmt::format("\"to\": pins {} and {} meet at the time {:.3g} of the stroke's 0 to 1, "
                                              "and move apart; move one of them another way, or remove it",
                                              i, j, nearest.t));
  });
  if (pairs > kMaxPairs) {
    throw InvalidInput(fmt::format(
        "\"radius\": {} pairs of pins are nearer than {:.4g} to each other, and {} at most can be solved; make "
        "it smaller, or give fewer pins{}",
        pairs, radius, kMaxPairs, stroke.turn.empty() ? "" : " or turns (two pins that turn count 16 times)"));
  }
}

void validate_turn(const PinsStroke& stroke) {
  if (stroke.turn.empty()) return;
  if (stroke.turn.size() != stroke.points.size()) {
    throw InvalidInput(fmt::format("\"turn\" must hold as many rotations or nulls as \"points\", {}, got {}",
                                   stroke.points.size(), stroke.turn.size()));
  }
  for (const std::optional<PinRotation>& rotation : stroke.turn) {
    if (!rotation) continue;
    require_direction("axis", rotation->axis);
    require_angle("angle_deg", rotation->angle_deg);
  }
}

// A pin that moves through more of its radii takes long, and the equations have no digits left for the others.
void require_near(const PinsStroke& stroke, double radius) {
  constexpr double most = 1e6;
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    const double distance = norm(motion_of(stroke, i));
    if (distance <= most * radius) continue;
    throw InvalidInput(
        fmt::format("\"to\": pin {} moves by {:.3g}, {:.2g} times \"radius\", and at most {:g} are possible; "
                    "correct its place, or make \"radius\" larger",
                    i, distance, distance / radius, most));
  }
}

void validate(const PinsStroke& stroke) {
  require_count("points", stroke.points.size(), 1, "points");
  if (stroke.points.size() > kMaxPins) {
    throw InvalidInput(fmt::format("\"points\" must hold at most {} pins, got {}", kMaxPins, stroke.points.size()));
  }
  if (stroke.to.size() != stroke.points.size()) {
    throw InvalidInput(fmt::format("\"to\" must hold as many places as \"points\", {}, got {}", stroke.points.size(),
                                   stroke.to.size()));
  }
  validate_turn(stroke);
  if (!stroke.radius && !stroke.radius_auto) throw InvalidInput("\"radius\" must be a number above 0, or \"auto\"");
  const double radius = radius_of(stroke);
  if (!(radius > 0)) {
    throw InvalidInput("\"radius\" cannot be \"auto\" for one pin that is held, got \"auto\"; give a number");
  }
  require_finite("radius", radius);
  require_near(stroke, radius);
  require_solvable(stroke, radius);
}

Flow flow_of(const PinsStroke& stroke) {
  Segment segment;
  segment.time_law = TimeLaw::pinned;
  const double radius = radius_of(stroke);
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    segment.fields.push_back(
        {stroke.points[i], Translation<double>{motion_of(stroke, i)}, Ball<double>{}, {0, radius, kPinFalloff}});
  }
  for (std::size_t i = 0; i < stroke.turn.size(); ++i) {
    if (stroke.turn[i]) segment.turns.push_back({static_cast<std::uint32_t>(i), rate_of(stroke, i)});
  }
  return {{std::move(segment)}};
}

// Returns places around the first pins at which the flow may stretch a shape most: at the pins, between each and its
// nearest one, and in front of, behind and beside moving ones.
std::vector<Vec3d> places_about(const PinsStroke& stroke, std::size_t count, double radius) {
  std::vector<Vec3d> places(stroke.points.begin(), stroke.points.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d& place = stroke.points[i];
    const Vec3d* nearest = nullptr;
    for (const Vec3d& other : stroke.points) {
      if (&other == &place) continue;
      if (nearest == nullptr || norm2(other - place) < norm2(*nearest - place)) nearest = &other;
    }
    if (nearest != nullptr) places.push_back((place + *nearest) * 0.5);
    const Vec3d by = motion_of(stroke, i) + rate_of(stroke, i) * radius;
    if (by == Vec3d{0, 0, 0}) continue;
    const Vec3d along = unit(by);
    const Vec3d beside = any_orthogonal(along);
    for (const double part : {0.15, 0.4, 0.7}) {
      for (const Vec3d& way : {along, -along, beside, -beside}) places.push_back(place + way * (part * radius));
    }
  }
  return places;
}

// Returns a lower bound of the rate of stretch between each pin and another one: their relative velocity divided by
// their least distance, or the pin's own velocity divided by the radius.
std::vector<double> strain_rates(const PinsStroke& stroke, double radius) {
  std::vector<double> rates;
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    rates.push_back(std::max(norm(motion_of(stroke, i)) / radius, norm(rate_of(stroke, i))));
  }
  for_pairs(stroke, [&](std::size_t i, std::size_t j) {
    const double apart = approach_of(stroke, i, j).distance;
    if (!(apart < radius)) return;
    const double rate = norm(motion_of(stroke, i) - motion_of(stroke, j)) / std::max(apart, kOnePlace * radius);
    rates[i] = std::max(rates[i], rate);
    rates[j] = std::max(rates[j], rate);
  });
  return rates;
}

// Returns the numbers of the pins that come nearest to a pin, the nearest first, beginning with the pin itself.
std::vector<std::size_t> pack_about(const PinsStroke& stroke, std::size_t pin) {
  std::vector<std::pair<double, std::size_t>> distances;
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    distances.emplace_back(i == pin ? -1 : approach_of(stroke, pin, i).distance, i);
  }
  std::partial_sort(distances.begin(), distances.begin() + kPack, distances.end());
  std::vector<std::size_t> result;
  for (std::size_t k = 0; k < kPack; ++k) result.push_back(distances[k].second);
  return result;
}

GreatestStretch stretch_about(const PinsStroke& stroke, std::size_t count, double radius) {
  const StrainOptions options{.length = radius, .step = 0.01};
  return greatest_stretch(flow_of(stroke), places_about(stroke, count, radius), options);
}

GreatestStretch stretch_of_pack(const PinsStroke& stroke, double radius) {
  const std::vector<double> rates = strain_rates(stroke, radius);
  const auto worst = std::max_element(rates.begin(), rates.end());
  PinsStroke pack;
  pack.radius = radius;
  for (const std::size_t i : pack_about(stroke, static_cast<std::size_t>(worst - rates.begin()))) {
    pack.points.push_back(stroke.points[i]);
    pack.to.push_back(stroke.to[i]);
    if (!stroke.turn.empty()) pack.turn.push_back(stroke.turn[i]);
  }
  return stretch_about(pack, kCore, radius);
}

void warn(const PinsStroke& stroke, Warnings& warnings) {
  const double radius = radius_of(stroke);
  const std::size_t count = stroke.points.size();
  const GreatestStretch found = count <= kPack ? stretch_about(stroke, count, radius) : stretch_of_pack(stroke, radius);
  const double stretch = std::max(found.greatest, 1 / found.least);
  if (!(stretch > kStrongStretchOfPins)) return;
  const auto nearest =
      std::min_element(stroke.points.begin(), stroke.points.end(),
                       [&](const Vec3d& a, const Vec3d& b) { return norm2(a - found.where) < norm2(b - found.where); });
  warnings.push_back(fmt::format(
      "the flow stretches what is near pin {} about {:.2g} times; make \"radius\" larger, move the pin less, or let "
      "pins near it come along",
      nearest - stroke.points.begin(), stretch));
}

void prolong(PinsStroke& stroke, double strength) {
  for (std::size_t i = 0; i < stroke.to.size(); ++i) stroke.to[i] = stroke.points[i] + motion_of(stroke, i) * strength;
  for (std::optional<PinRotation>& rotation : stroke.turn) {
    if (rotation) rotation->angle_deg *= strength;
  }
}

std::string words(const PinsStroke& stroke, const std::string& unit) {
  double most = 0;
  for (std::size_t i = 0; i < stroke.points.size(); ++i) most = std::max(most, norm(motion_of(stroke, i)));
  return "Pose " + length_text(most, unit);
}

// The pins of a stroke and of its images.
class MirroredPins {
 public:
  MirroredPins(const PinsStroke& stroke, const Mirror& mirror)
      : result_(stroke), images_(images_in(mirror)), same_(kSameImage * size_of(stroke)) {
    result_.turn.resize(stroke.points.size());
  }

  PinsStroke find() {
    const std::size_t count = result_.points.size();
    for (std::size_t i = 0; i < count; ++i) keep_in_planes(i);
    for (std::size_t i = 0; i < count; ++i) {
      for (const SymmetryImage& image : images_) add_image(i, image);
    }
    const auto is_none = [](const auto& turn) { return !turn; };
    if (std::all_of(result_.turn.begin(), result_.turn.end(), is_none)) result_.turn.clear();
    return std::move(result_);
  }

 private:
  static double size_of(const PinsStroke& stroke) {
    Box box = bounding_box(stroke.points);
    for (const Vec3d& p : stroke.to) box.extend(p);
    return std::max({box.diagonal(), norm(box.min), norm(box.max)});
  }

  PinsStroke one(std::size_t i) const {
    PinsStroke pin;
    pin.points = {result_.points[i]};
    pin.to = {result_.to[i]};
    pin.radius = 1;
    if (result_.turn[i]) pin.turn = {result_.turn[i]};
    return pin;
  }
  PinsStroke image(std::size_t i, const SymmetryImage& image) const {
    return std::get<PinsStroke>(image_of(one(i), image, {}));
  }

  static Vec3d vector_of(const PinRotation& turn) { return normalized(turn.axis) * turn.angle_deg; }

  // A pin that is its own image gets the mean of its images' targets and rotations.
  void keep_in_planes(std::size_t i) {
    Vec3d to = result_.to[i];
    Vec3d turn = result_.turn[i] ? vector_of(*result_.turn[i]) : Vec3d{};
    double count = 1;
    for (const SymmetryImage& each : images_) {
      const PinsStroke other = image(i, each);
      if (!are_near(other.points[0], result_.points[i], same_)) continue;
      to += other.to[0];
      if (!other.turn.empty()) turn += vector_of(*other.turn[0]);
      ++count;
    }
    if (count == 1) return;
    if (!are_near(to / count, result_.to[i], same_)) result_.to[i] = to / count;
    if (!result_.turn[i] || are_near(turn / count, vector_of(*result_.turn[i]), kSameImage)) return;
    result_.turn[i] = PinRotation{result_.turn[i]->axis, 0};
    if (norm(turn) > 0) result_.turn[i] = PinRotation{turn, norm(turn) / count};
  }

  void add_image(std::size_t i, const SymmetryImage& each) {
    const PinsStroke other = image(i, each);
    for (std::size_t k = 0; k < result_.points.size(); ++k) {
      if (!are_near(result_.points[k], other.points[0], same_)) continue;
      if (are_near(result_.to[k], other.to[0], same_)) return;
      throw InvalidInput(fmt::format(
          "\"points\": pin {} is the mirror image of pin {}, but goes elsewhere; leave one of them out", k + 1, i + 1));
    }
    result_.points.push_back(other.points[0]);
    result_.to.push_back(other.to[0]);
    result_.turn.push_back(other.turn.empty() ? std::nullopt : other.turn[0]);
  }

  PinsStroke result_;
  std::vector<SymmetryImage> images_;
  double same_;
};

PinsStroke with_images(const PinsStroke& stroke, const Mirror& mirror, std::span<const Vec3d> /*positions*/) {
  return MirroredPins(stroke, mirror).find();
}

}  // namespace

constinit const detail::ToolRow<PinsStroke> PinsStroke::tool{.name = "pins",
                                                             .keys = keys,
                                                             .validate = validate,
                                                             .flow = flow_of,
                                                             .warn = warn,
                                                             .words = words,
                                                             .prolong = prolong,
                                                             .with_images = with_images};

}  // namespace knead
