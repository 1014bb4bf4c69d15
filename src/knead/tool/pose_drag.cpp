// A pose that follows a pointer.
#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "knead/field/region.h"
#include "knead/math/sincos.h"
#include "knead/tool/describe.h"
#include "knead/tool/pose.h"

namespace knead {

namespace {

using namespace detail;
using namespace tool_detail;

constexpr std::size_t kSamples = 2500;  // inside the body: each advance must be quick
constexpr double kStepAngle = 8;        // degrees
constexpr double kStepLength = 0.5;     // of the grid's spacing

// The same pose with nothing said of how far parts and pins go.
PoseStroke without_ways(PoseStroke stroke) {
  for (PoseItem& item : stroke.parts) {
    if (auto* part = std::get_if<PosePart>(&item)) {
      if (part->rotation) part->rotation->angle_deg = 0;
      part->translation.reset();
    } else {
      std::get<PosePin>(item).path.clear();
    }
  }
  return stroke;
}

// How far a part has gone.
struct Way {
  double angle_deg = 0;
  Vec3d translation{0, 0, 0};
};

Way mixed(const Way& a, const Way& b, double t) {
  return {a.angle_deg + (b.angle_deg - a.angle_deg) * t, a.translation + (b.translation - a.translation) * t};
}

std::vector<Way> ways_of(const PoseStroke& stroke) {
  std::vector<Way> ways;
  for (const PoseItem& item : stroke.parts) {
    const auto* part = std::get_if<PosePart>(&item);
    if (part == nullptr) continue;
    ways.push_back({part->rotation ? part->rotation->angle_deg : 0, part->translation.value_or(Vec3d{0, 0, 0})});
  }
  return ways;
}

}  // namespace

struct PoseDrag::State {
  PoseStroke pose;               // without ways
  std::vector<PosedPart> parts;  // as they were at the beginning
  std::vector<PosedPin> pins;
  double spacing = 0;
  std::vector<Way> ways;      // that the parts have gone
  std::vector<Vec3d> places;  // of the pins
  PoseRun run;

  Vec3d place(std::size_t part, const Vec3d& start, const Way& way) const {
    const PosedPart& own = parts[part];
    return own.center + rotate(start - own.center, own.axis, sincos(way.angle_deg * kRadiansPerDegree)) +
           way.translation;
  }

  // How many steps it takes to get there.
  double steps_to(const std::vector<Way>& to, const std::vector<Vec3d>& pins_to) const {
    double steps = 1;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      steps = std::max(steps, std::abs(to[i].angle_deg - ways[i].angle_deg) / kStepAngle);
      for (const Vec3d& start : parts[i].points) {
        steps = std::max(steps, norm(place(i, start, to[i]) - place(i, start, ways[i])) / (kStepLength * spacing));
      }
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      steps = std::max(steps, norm(pins_to[i] - places[i]) / (kStepLength * spacing));
    }
    return steps;
  }
};

PoseDrag::PoseDrag(const PoseStroke& stroke, const LiveSurface& surface, int threads) {
  validate(stroke);
  std::vector<std::string> warnings;
  PoseProblem problem = problem_of(stroke, surface, kSamples, threads, warnings);
  problem.settles = false;
  problem.progress = nullptr;  // that of the surface may end before the drag
  std::vector<Vec3d> places;
  for (const PosedPin& pin : problem.pins) places.push_back(pin.path.front());
  state_ = std::make_unique<State>(State{without_ways(stroke), problem.parts, problem.pins, problem.spacing,
                                         std::vector<Way>(problem.parts.size()), std::move(places), PoseRun(problem)});
}

PoseDrag::PoseDrag(PoseDrag&&) noexcept = default;
PoseDrag& PoseDrag::operator=(PoseDrag&&) noexcept = default;
PoseDrag::~PoseDrag() = default;

bool PoseDrag::takes(const PoseStroke& stroke) const { return without_ways(stroke) == state_->pose; }

bool PoseDrag::advance(const PoseStroke& stroke, double most_steps, const std::function<bool(const Stroke&)>& apply) {
  State& s = *state_;
  const std::vector<Way> ends = ways_of(stroke);
  std::vector<Vec3d> pin_ends;
  for (const PoseItem& item : stroke.parts) {
    const auto* pin = std::get_if<PosePin>(&item);
    if (pin != nullptr) pin_ends.push_back(pin->path.empty() ? s.places[pin_ends.size()] : pin->path.back());
  }
  const double share = std::min(1.0, most_steps / s.steps_to(ends, pin_ends));
  std::vector<PosedPart> parts = s.parts;
  std::vector<Way> ways;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Way from = s.ways[i];
    const Way to = mixed(from, ends[i], share);
    parts[i].angle = (to.angle_deg - from.angle_deg) * kRadiansPerDegree;
    parts[i].translation = {0, 0, 0};
    if (!s.parts[i].holds()) {
      parts[i].way = [&s, i, from, to](const Vec3d& start, double t) { return s.place(i, start, mixed(from, to, t)); };
    }
    ways.push_back(to);
  }
  std::vector<PosedPin> pins = s.pins;
  std::vector<Vec3d> places;
  for (std::size_t i = 0; i < pins.size(); ++i) {
    places.push_back(s.places[i] + (pin_ends[i] - s.places[i]) * share);
    pins[i].path = {s.places[i]};
    if (places[i] != s.places[i]) pins[i].path.push_back(places[i]);
  }
  s.run.set_ways(std::move(parts), std::move(pins));
  const PoseOutcome outcome = s.run.go([&](const PotentialGrid& grid) { return apply(GridStroke{grid}); });
  s.ways = std::move(ways);
  s.places = std::move(places);
  return !outcome.stopped;
}

}  // namespace knead
