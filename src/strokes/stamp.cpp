// The tool "stamp": a closed mesh that is pressed along a path.
#include "strokes/stamp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/error.h"
#include "knead/region.h"
#include "strokes/describe.h"
#include "strokes/suffix.h"

namespace knead::detail {

namespace {

// Closer pins follow the tool no better, and their equations take longer.
constexpr double kPinsPerRadius = 5;
// Of a step's motion: places less deep inside the tool count as outside.
constexpr double kShallow = 0.01;
// The greatest displacement of a pin in a round, of the distance between pins: so two pins cannot meet. Deeper places
// come out step by step. It is twice the default step.
constexpr double kLongest = 0.4;
// The greatest number of pins in a round; further places move in the next one, or are not held. A pins stroke may have
// 2000.
constexpr std::size_t kMaxMoving = 1000;
constexpr std::size_t kMaxPinsOfStamp = 1900;

}  // namespace

void SlippingContacts::hold_what_touches(const LiveSurface& surface, const StampStep& step, double distance) {
  Thinned pressed(radius_ / kPinsPerRadius / 2);
  for (const StampPlace& place : find_touching(tool_, surface, step, distance)) {
    if (pressed.take(place.at(surface.positions))) pressed_.push_back(place);
  }
}

std::optional<PinsStroke> SlippingContacts::pins(const LiveSurface& surface, const StampStep& step) {
  const double spacing = radius_ / kPinsPerRadius;
  const double length = norm(step.motion);
  const StampStep sampled{step.to, step.motion, spacing, step.threads};
  const std::vector<Penetration> found = find_intrusions(tool_, surface, sampled);
  if (found.empty() || norm(found.front().way) < kShallow * length) return std::nullopt;
  PinsStroke stroke;
  stroke.radius = radius_;
  Thinned pinned(spacing);
  std::vector<Penetration> moving;
  for (const Penetration& penetration : found) {
    if (moving.size() == kMaxMoving) break;
    if (!pinned.take(penetration.point)) continue;
    const double part = std::min(1.0, kLongest * spacing / norm(penetration.way));
    stroke.points.push_back(penetration.point);
    stroke.to.push_back(penetration.point + penetration.way * part);
    moving.push_back(penetration);
  }
  Thinned pressed(spacing / 2);
  std::erase_if(pressed_, [&](const StampPlace& place) {
    const Vec3d point = place.at(surface.positions);
    if (is_near(point, moving) && stroke.points.size() < kMaxPinsOfStamp && pinned.take(point)) {
      stroke.points.push_back(point);
      stroke.to.push_back(point);
    }
    return !pressed.take(point);
  });
  for (const Penetration& penetration : moving) {
    if (pressed.take(penetration.point)) pressed_.push_back(penetration.place);
  }
  return stroke;
}

bool SlippingContacts::is_near(const Vec3d& point, const std::vector<Penetration>& moving) const {
  return std::any_of(moving.begin(), moving.end(),
                     [&](const Penetration& each) { return norm2(each.point - point) < radius_ * radius_; });
}

}  // namespace knead::detail

namespace knead {

namespace {

using namespace detail;

constexpr double kDefaultOuter = 1.5;    // of the tool's half width
constexpr double kNarrowestPrint = 0.9;  // of the half width: the least `outer` for an automatic contact
constexpr double kStrokesPerPrint = 3;   // of the narrowest width, clamped to these two
constexpr double kNarrowOuter = 1.1;     // below that the return flow bends the side walls into the tool
constexpr double kStepsPerOuter = 25;    // by default
constexpr double kStepsPerPrint = 50;    // of a print
constexpr double kCoarsestSpacing = 20;  // of the contacts, in the outer threshold
constexpr double kFinestSpacing = 200;   // however narrow the tool
constexpr std::size_t kMaxDirections = 8;
constexpr int kQuarters = 4;      // of a step
constexpr double kLatest = 0.25;  // of a quarter: places that are hit later wait for the next quarter
constexpr int kMaxStepsOfStamp = 1'000'000;
constexpr int kSlipRounds = 2;  // of a step

// The thresholds of a point set whose points lie `spacing` apart on a plane, for which r = outer at the distance
// `outer` from the plane. (The sum of |x - p_i|^-m over the plane is 2 pi / (m - 2) outer^(2 - m) / spacing^2.)
double reading_at(double outer, double spacing, int exponent) {
  const double density = outer / spacing;
  const double sum = 2 * std::numbers::pi / (exponent - 2) * density * density;
  return sum > 1 ? outer * inverse_root(sum, exponent) : outer;
}

// The lengths of a stroke, with the defaults that its tool determines.
struct Lengths {
  double half_width = 0;  // the tool's greatest over all directions of the path
  double outer = 0;
  double step = 0;
  double tolerated = 0;  // penetration at the end without a warning; half of it at the beginning
  double spacing = 0;    // of the contacts
};

// Returns the directions of some of a path's pieces, evenly spread over it; any direction for a path without length.
std::vector<Vec3d> directions_of(std::span<const Vec3d> path) {
  std::vector<Vec3d> directions;
  const std::size_t stride = 1 + (path.size() - 2) / kMaxDirections;
  for (std::size_t i = 0; i + 1 < path.size(); i += stride) {
    if (path[i + 1] != path[i]) directions.push_back(detail::unit(path[i + 1] - path[i]));
  }
  if (directions.empty()) directions.push_back({0, 0, 1});
  return directions;
}

Lengths choose_lengths(const StampStroke& stroke, const StampTool& tool) {
  Lengths lengths;
  const std::vector<Vec3d> directions = directions_of(stroke.path);
  for (const Vec3d& direction : directions) {
    lengths.half_width = std::max(lengths.half_width, tool.half_width(direction));
  }
  const bool prints = stroke.contact == StampContact::automatic && contact_of(stroke) == StampContact::slip;
  lengths.outer = stroke.outer.value_or(kDefaultOuter * lengths.half_width);
  const double below = lengths.outer / kCoarsestSpacing;
  double narrowest = kInfinity;
  for (const Vec3d& direction : directions) narrowest = std::min(narrowest, tool.narrowest_width(direction, below));
  if (prints) {
    lengths.outer = std::clamp(kStrokesPerPrint * narrowest, kNarrowestPrint * lengths.half_width, lengths.outer);
  }
  lengths.step = stroke.step.value_or(lengths.outer / (prints ? kStepsPerPrint : kStepsPerOuter));
  lengths.tolerated = prints ? lengths.step : lengths.step / 2;
  const double coarsest = lengths.outer / kCoarsestSpacing;
  lengths.spacing = std::clamp(narrowest / 2, lengths.outer / kFinestSpacing, coarsest);
  return lengths;
}

std::size_t steps_between(const Vec3d& from, const Vec3d& to, double step) {
  return static_cast<std::size_t>(std::ceil(norm(to - from) / step * (1 - 1e-12)));
}

std::size_t count_steps(const StampStroke& stroke, double step) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) length += norm(stroke.path[i + 1] - stroke.path[i]);
  if (!(length / step <= kMaxStepsOfStamp)) {
    throw InvalidInput(
        fmt::format("\"step\" must be larger: the path is {:.3g} long, which with steps of {:.3g} takes "
                    "more than {} collision tests",
                    length, step, kMaxStepsOfStamp));
  }
  std::size_t steps = 0;
  for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) {
    steps += steps_between(stroke.path[i], stroke.path[i + 1], step);
  }
  return steps;
}

class Stamper {
 public:
  Stamper(const StampStroke& stroke, const Mesh& tool, const LiveSurface& surface, int threads)
      : stroke_(stroke),
        tool_(tool, stroke.pose),
        surface_(surface),
        threads_(threads),
        slips_(contact_of(stroke) == StampContact::slip),
        lengths_(choose_lengths(stroke, tool_)),
        slipping_(tool_, lengths_.outer) {
    result_.outer = lengths_.outer;
    result_.step = lengths_.step;
    result_.steps = count_steps(stroke, lengths_.step);
  }

  StampResult run() {
    warn_of_start();
    if (slips_ && !stroke_.outer) slipping_.hold_what_touches(surface_, at(stroke_.path.front()), lengths_.step);
    for (std::size_t i = 0; i + 1 < stroke_.path.size() && !result_.stopped; ++i) {
      move(stroke_.path[i], stroke_.path[i + 1]);
    }
    if (!result_.stopped) measure_end();
    return std::move(result_);
  }

 private:
  void warn(std::string what) { result_.warnings.push_back(std::move(what)); }

  StampStep at(const Vec3d& place) const { return {place, {0, 0, 0}, lengths_.spacing, threads_}; }

  double penetration(const Vec3d& place) const { return deepest_penetration(tool_, surface_, at(place)); }

  void warn_of_start() {
    const double least = kNarrowOuter * lengths_.half_width;
    if (!slips_ && lengths_.outer < least) {
      warn(fmt::format(
          "\"outer\" is {:.3g}, but below {:.3g} the flow back around a tool that is {:.3g} wide bends the side walls "
          "into it; make \"outer\" larger",
          lengths_.outer, least, 2 * lengths_.half_width));
    }
    const double depth = penetration(stroke_.path.front());
    if (depth > lengths_.tolerated / 2) {
      warn(fmt::format(
          "the surface is {:.3g} deep inside the tool where the path begins: that part {}; begin the path outside the "
          "shape",
          depth, slips_ ? "is pushed out step by step, by the shortest way" : "moves along, but is not pushed out"));
    }
  }

  void measure_end() {
    result_.penetration = penetration(stroke_.path.back());
    if (result_.penetration > lengths_.tolerated) {
      warn(fmt::format(
          "at the path's end the surface is {:.3g} deep inside the tool; make \"step\" smaller or \"outer\" "
          "larger, or refine the shape",
          result_.penetration));
    }
  }

  void move(const Vec3d& from, const Vec3d& to) {
    const std::size_t steps = steps_between(from, to, lengths_.step);
    for (std::size_t k = 1; k <= steps && !result_.stopped; ++k) {
      const auto done = static_cast<double>(k) / static_cast<double>(steps);
      const StampStep step{from + (to - from) * done, (to - from) / static_cast<double>(steps), lengths_.spacing,
                           threads_};
      if (slips_) {
        slide(step);
      } else {
        push(step);
      }
    }
  }

  // The quarters begin when the first place is hit. A place joins in the quarter in whose beginning the tool hits it,
  // which is later than was found where the field has carried it ahead meanwhile.
  void push(const StampStep& step) {
    std::vector<Contact> waiting = find_contacts(tool_, surface_, step);
    if (waiting.empty()) return;
    const double first = std::max(waiting.front().tau, 0.0);
    const double quarter = (1 - first) / kQuarters;
    const Vec3d displacement = step.motion * quarter;
    PointsStroke stroke;
    stroke.outer = reading_at(lengths_.outer, lengths_.spacing, stroke_.exponent);
    stroke.exponent = stroke_.exponent;
    stroke.falloff = stroke_.falloff;
    stroke.displacements = {displacement};
    for (int j = 0; j < kQuarters && !result_.stopped; ++j) {
      std::erase_if(waiting, [&](const Contact& contact) {
        const Vec3d now = contact.place.at(surface_.positions);
        const double carried = dot(now - contact.point, step.motion) / norm2(step.motion);
        if (contact.tau + carried > first + quarter * (j + kLatest)) return false;
        stroke.points.push_back(now);
        return true;
      });
      result_.stopped = !surface_.apply(stroke);
      for (Vec3d& p : stroke.points) p += displacement;
    }
  }

  void slide(const StampStep& step) {
    for (int round = 0; round < kSlipRounds && !result_.stopped; ++round) {
      const std::optional<PinsStroke> pins = slipping_.pins(surface_, step);
      if (!pins) return;
      result_.stopped = !surface_.apply(*pins);
    }
  }

  const StampStroke& stroke_;
  StampTool tool_;
  const LiveSurface& surface_;
  int threads_;
  bool slips_;
  Lengths lengths_;
  detail::SlippingContacts slipping_;
  StampResult result_;
};

}  // namespace

StampContact contact_of(const StampStroke& stroke) {
  if (stroke.contact != StampContact::automatic) return stroke.contact;
  const StampStroke plain;
  const bool is_plain = !stroke.outer && stroke.exponent == plain.exponent && stroke.falloff == plain.falloff;
  return is_plain ? StampContact::slip : StampContact::stick;
}

StampResult stamp(const StampStroke& stroke, const Mesh& tool, const LiveSurface& surface, int threads) {
  validate(Stroke(stroke));
  return Stamper(stroke, tool, surface, threads).run();
}

std::size_t stamp_segments(const StampStroke& stroke, const Mesh& tool) {
  validate(Stroke(stroke));
  const StampTool posed(tool, stroke.pose);
  const int parts = contact_of(stroke) == StampContact::slip ? kSlipRounds : kQuarters;
  return parts * count_steps(stroke, choose_lengths(stroke, posed).step);
}

namespace {

std::vector<StrokeKey> keys(StampStroke& s) {
  return {{"mesh", Quantity::other, &s.mesh},
          {"path", Quantity::finite, &s.path},
          {"pose", Quantity::finite, &s.pose, Presence::optional},
          {"outer", Quantity::positive, &s.outer, Presence::optional, "how far below the contact the motion reaches"},
          {"step", Quantity::positive, &s.step, Presence::optional},
          {"contact", Quantity::other, choice(s.contact, {"auto", "stick", "slip"}), Presence::optional},
          {"exponent",
           Quantity::other,
           s.contact != StampContact::slip ? &s.exponent : nullptr,
           Presence::optional,
           {},
           "\"contact\": \"stick\""}};
}

void validate_stamp(const StampStroke& stroke) {
  require_count("path", stroke.path.size(), 2, "positions");
  const double volume = determinant(stroke.pose);
  const double size = norm(stroke.pose.row0) * norm(stroke.pose.row1) * norm(stroke.pose.row2);
  if (!(volume > 1e-9 * size)) {
    throw InvalidInput(fmt::format("\"pose\" must turn and scale the tool, and this {} it (determinant {:.3g})",
                                   volume < -1e-9 * size ? "mirrors" : "flattens", volume));
  }
  require_even("exponent", stroke.exponent, 4);
  if (stroke.contact == StampContact::slip && stroke.falloff != kDefaultFalloff) {
    throw InvalidInput("\"falloff\" has no meaning where \"contact\" is \"slip\"; remove it");
  }
}

void prolong(StampStroke& stroke, double strength) { prolong_path(stroke.path, strength); }

std::size_t segments(const StampStroke& stroke, const Mesh* mesh) {
  constexpr std::size_t kStepsOfAPiece = 20;
  return mesh != nullptr ? stamp_segments(stroke, *mesh) : kStepsOfAPiece * stroke.path.size();
}

void resolve(const StampStroke& stroke, SurfaceRun& run) {
  StampResult result = stamp(stroke, *run.mesh, run.surface, run.threads);
  run.remarks = std::move(result.warnings);
  run.penetration = result.penetration;
}

std::string words(const StampStroke& stroke, const std::string& unit) {
  return "Stamp " + length_text(norm(stroke.path.back() - stroke.path.front()), unit);
}

bool blends(const StampStroke& stroke) { return contact_of(stroke) == StampContact::stick; }

using StampedPath = Growing<StampStroke, &StampStroke::path, 1>;

}  // namespace

constinit const detail::ToolRow<StampStroke> StampStroke::tool{.name = "stamp",
                                                               .keys = keys,
                                                               .validate = validate_stamp,
                                                               .resolve = resolve,
                                                               .segments = segments,
                                                               .words = words,
                                                               .prolong = prolong,
                                                               .blends = blends,
                                                               .path = &StampStroke::path,
                                                               .continues = StampedPath::continues,
                                                               .pieces = StampedPath::pieces};

}  // namespace knead
