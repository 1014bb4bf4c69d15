// The tool "pose": its numbers, its images, and a pose that follows a pointer.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "knead/error.h"
#include "knead/region.h"
#include "knead/vec.h"
#include "strokes/describe.h"
#include "strokes/mirror.h"
#include "strokes/pose.h"

namespace knead {

namespace {

using namespace detail;

constexpr std::size_t kSamples = 2500;  // inside the body: each advance must be quick
constexpr double kMinDetailOfStroke = 0.05;
constexpr double kStepAngle = 8;     // degrees
constexpr double kStepOfDrag = 0.5;  // of the grid's spacing

// Returns the pose without the targets of its parts and pins.
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

// The motion of a part so far.
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

constexpr std::size_t kMaxPinsOfPose = 1000;
constexpr std::size_t kMaxPlacesOfPose = 10'000;  // of a pin's path
constexpr double kFinest = 0.01;
constexpr double kCoarsest = 0.5;
constexpr double kFinestTolerance = 1e-4;
constexpr double kMaxStiffness = 100;

std::vector<StrokeKey> keys(PoseStroke& s) {
  return {{"detail", Quantity::finite, &s.detail, Presence::optional,
           "the finest motion, as a fraction of the shape's size; smaller numbers take longer; 0: from the thickness"},
          {"tolerance", Quantity::positive, &s.tolerance, Presence::optional,
           "how far parts and pins may end from their places, as a fraction of the shape's size"},
          {"parts", Quantity::other, &s.parts},
          {"stiffness", Quantity::other, &s.stiffness, Presence::optional},
          {"exact", Quantity::other, &s.exact, Presence::optional}};
}

// A range of vertices and its part.
struct OwnedRange {
  VertexRange range;
  std::size_t part = 0;
};

void append(const std::vector<VertexRange>& ranges, std::size_t part, std::vector<OwnedRange>& list) {
  for (const VertexRange& range : ranges) {
    if (range.last < range.first) {
      throw InvalidInput(fmt::format("\"vertices\" has the range [{}, {}], whose last number is below its first",
                                     range.first, range.last));
    }
    list.push_back({range, part});
  }
}

// Refuses parts that have a vertex in common.
void require_apart(const PoseStroke& stroke) {
  std::vector<OwnedRange> ranges;
  for (std::size_t i = 0; i < stroke.parts.size(); ++i) {
    if (const auto* part = std::get_if<PosePart>(&stroke.parts[i])) {
      append(part->vertices, i, ranges);
    } else if (const auto& vertex = std::get<PosePin>(stroke.parts[i]).vertex) {
      ranges.push_back({{*vertex, *vertex}, i});
    }
  }
  std::sort(ranges.begin(), ranges.end(),
            [](const OwnedRange& a, const OwnedRange& b) { return a.range.first < b.range.first; });
  const OwnedRange* farthest = nullptr;  // of the parts before
  for (const OwnedRange& owned : ranges) {
    if (farthest != nullptr && owned.range.first <= farthest->range.last && owned.part != farthest->part) {
      throw InvalidInput(fmt::format("\"parts\": vertex {} is in part {} and in part {}; take it out of one of them",
                                     owned.range.first, farthest->part + 1, owned.part + 1));
    }
    if (farthest == nullptr || owned.range.last > farthest->range.last) farthest = &owned;
  }
}

void validate(const PosePart& part) {
  if (part.vertices.empty() == part.points.empty()) {
    throw InvalidInput(part.points.empty() ? "it has no vertices; give \"vertices\", or \"points\""
                                           : "it has both \"vertices\" and \"points\"; give one of them");
  }
  require_finite("points", part.points);
  const bool moves = part.rotation || part.translation;
  if (moves == part.hold) {
    throw InvalidInput(moves ? "it holds and moves; leave out \"hold\", or \"rotate\" and \"translate\""
                             : "it neither holds nor moves; give \"hold\": true, \"rotate\" or \"translate\"");
  }
  if (part.rotation) {
    require_direction("rotate", part.rotation->axis);
    require_finite("center", part.rotation->center);
    require_angle("angle_deg", part.rotation->angle_deg);
  }
  if (part.translation) require_finite("translate", *part.translation);
}

void validate(const PosePin& pin) {
  if (pin.vertex.has_value() == pin.point.has_value()) {
    throw InvalidInput("a pin needs either \"pin\", the number of a vertex, or \"pin_point\"");
  }
  if (pin.point) require_finite("pin_point", *pin.point);
  require_finite("path", pin.path);
  if (pin.path.empty() != pin.hold) {
    throw InvalidInput(pin.hold ? "the pin holds and moves; leave out \"hold\", or \"to\" and \"path\""
                                : "the pin neither holds nor moves; give \"hold\": true, \"to\" or \"path\"");
  }
  if (pin.path.size() > kMaxPlacesOfPose) {
    throw InvalidInput(fmt::format("\"path\" must hold at most {} places, got {}", kMaxPlacesOfPose, pin.path.size()));
  }
  if (!(pin.size > 0 && pin.size <= kCoarsest)) {
    throw InvalidInput(fmt::format("\"size\" must be above 0 and at most {}, got {}", kCoarsest, pin.size));
  }
  if (pin.rotation) {
    require_direction("axis", pin.rotation->axis);
    require_angle("angle_deg", pin.rotation->angle_deg);
  }
}

bool moves(const PoseItem& item) {
  if (const auto* pin = std::get_if<PosePin>(&item)) return !pin->hold || pin->rotation;
  const auto& part = std::get<PosePart>(item);
  const bool turns = part.rotation && part.rotation->angle_deg != 0;
  return turns || (part.translation && *part.translation != Vec3d{0, 0, 0});
}

void validate_stiffness(const PoseStroke& stroke) {
  std::vector<OwnedRange> ranges;
  for (const PoseStiffness& region : stroke.stiffness) {
    if (region.vertices.empty()) throw InvalidInput("\"stiffness\" names a region without vertices");
    append(region.vertices, 0, ranges);
    if (!(region.value >= 1 / kMaxStiffness && region.value <= kMaxStiffness)) {
      throw InvalidInput(fmt::format("\"value\" of \"stiffness\" must be from {} to {}, got {}", 1 / kMaxStiffness,
                                     kMaxStiffness, region.value));
    }
  }
}

void validate(const PoseStroke& stroke) {
  if (stroke.detail != 0 && !(stroke.detail >= kFinest && stroke.detail <= kCoarsest)) {
    throw InvalidInput(
        fmt::format("\"detail\" must be from {} to {} of the shape's size, or 0 for the usual one, got {}", kFinest,
                    kCoarsest, stroke.detail));
  }
  if (!(stroke.tolerance >= kFinestTolerance && stroke.tolerance <= kCoarsest)) {
    throw InvalidInput(fmt::format("\"tolerance\" must be from {} to {} of the shape's size, got {}", kFinestTolerance,
                                   kCoarsest, stroke.tolerance));
  }
  require_count("parts", stroke.parts.size(), 1, "parts or pins");
  std::size_t pins = 0;
  for (std::size_t i = 0; i < stroke.parts.size(); ++i) {
    try {
      std::visit([](const auto& item) { validate(item); }, stroke.parts[i]);
    } catch (const InvalidInput& error) {
      throw InvalidInput(fmt::format("\"parts\": part {}: {}", i + 1, error.what()));
    }
    pins += std::holds_alternative<PosePin>(stroke.parts[i]) ? 1 : 0;
  }
  if (pins > kMaxPinsOfPose)
    throw InvalidInput(fmt::format("\"parts\" must hold at most {} pins, got {}", kMaxPinsOfPose, pins));
  if (std::none_of(stroke.parts.begin(), stroke.parts.end(), moves)) {
    throw InvalidInput("\"parts\": none of the parts and pins moves; give one \"rotate\", \"translate\" or \"to\"");
  }
  require_apart(stroke);
  validate_stiffness(stroke);
}

// Moves the last place of the path in its last direction; the number of places does not change.
void go_on(PosePin& pin, double strength) {
  if (!pin.point && pin.path.size() < 2) {
    throw InvalidInput("a pin that is a vertex cannot go on beyond its only place; give \"pin_point\", or a \"path\"");
  }
  std::vector<Vec3d> path = pin.path;
  if (pin.point) path.insert(path.begin(), *pin.point);
  prolong_path(path, strength);
  pin.path.back() = path.back();
}

// Prolongs a pose: multiplies angles and translations, and extends paths in their last directions.
void prolong(PoseStroke& stroke, double strength) {
  for (PoseItem& item : stroke.parts) {
    if (auto* part = std::get_if<PosePart>(&item)) {
      if (part->rotation) part->rotation->angle_deg *= strength;
      if (part->translation) *part->translation *= strength;
      continue;
    }
    auto& pin = std::get<PosePin>(item);
    if (pin.hold) continue;
    go_on(pin, strength);
    if (pin.rotation) pin.rotation->angle_deg *= strength;
  }
}

// The parts and pins of a pose and of its images.
class MirroredPose {
 public:
  MirroredPose(PoseStroke stroke, const Mirror& mirror, std::span<const Vec3d> positions)
      : result_(std::move(stroke)), images_(images_in(mirror)), same_(kSameImage * bounding_box(positions).diagonal()) {
    for (PoseItem& item : result_.parts) {
      std::visit([&](auto& own) { look_up(own, positions); }, item);
    }
  }

  PoseStroke find() {
    const std::vector<PoseItem> own = result_.parts;
    for (std::size_t i = 0; i < own.size(); ++i) {
      for (const SymmetryImage& image : images_) {
        PoseStroke one = result_;
        one.parts = {own[i]};
        one.stiffness.clear();
        add(std::get<PoseStroke>(image_of(one, image, {})).parts.front(), i);
      }
    }
    return std::move(result_);
  }

 private:
  static void look_up(PosePart& part, std::span<const Vec3d> positions) {
    for (const VertexRange& range : part.vertices) {
      require_vertex("parts", positions, range.last);
      part.points.insert(part.points.end(), positions.begin() + range.first, positions.begin() + range.last + 1);
    }
    part.vertices.clear();
  }
  static void look_up(PosePin& pin, std::span<const Vec3d> positions) {
    if (!pin.vertex) return;
    require_vertex("parts", positions, *pin.vertex);
    pin.point = positions[*pin.vertex];
    pin.vertex.reset();
  }

  // Adds the image of item i. A holding part gets the image's points; an item that is its own image is not repeated.
  void add(const PoseItem& image, std::size_t i) {
    if (const auto* pin = std::get_if<PosePin>(&image)) return add(*pin, std::get<PosePin>(result_.parts[i]));
    const auto& part = std::get<PosePart>(image);
    auto& own = std::get<PosePart>(result_.parts[i]);
    std::vector<Vec3d> apart;
    for (const Vec3d& p : part.points) {
      const auto is_it = [&](const Vec3d& q) { return are_near(p, q, same_); };
      if (std::none_of(own.points.begin(), own.points.end(), is_it)) apart.push_back(p);
    }
    if (own.hold) {
      own.points.insert(own.points.end(), apart.begin(), apart.end());
    } else if (!apart.empty()) {
      result_.parts.emplace_back(part);
    }
  }
  void add(const PosePin& image, PosePin& own) {
    if (!are_near(*image.point, *own.point, same_)) {
      result_.parts.emplace_back(image);
      return;
    }
    for (std::size_t k = 0; k < own.path.size(); ++k) own.path[k] = (own.path[k] + image.path[k]) * 0.5;
  }

  PoseStroke result_;
  std::vector<SymmetryImage> images_;
  double same_;
};

void resolve(const PoseStroke& stroke, SurfaceRun& run) {
  PoseResult result = pose_on(stroke, run.surface, run.threads);
  run.remarks = std::move(result.warnings);
  run.shortfall = std::move(result.shortfall);
  run.reached = result.reached;
}

std::size_t segments(const PoseStroke& /*stroke*/, const Mesh* /*mesh*/) { return 10; }

std::string words(const PoseStroke& stroke, const std::string& unit) {
  double most = 0;
  for (const PoseItem& item : stroke.parts) {
    const auto* const part = std::get_if<PosePart>(&item);
    if (part != nullptr && part->rotation) return "Pose " + degrees_text(part->rotation->angle_deg);
    if (part != nullptr && part->translation) most = std::max(most, norm(*part->translation));
    const auto* const pin = std::get_if<PosePin>(&item);
    if (pin != nullptr && pin->path.size() > 1) most = std::max(most, norm(pin->path.back() - pin->path.front()));
  }
  return most > 0 ? "Pose " + length_text(most, unit) : "Pose";
}

PoseStroke with_images(const PoseStroke& stroke, const Mirror& mirror, std::span<const Vec3d> positions) {
  if (stroke.exact) throw InvalidInput("\"exact\" and \"mirror\" do not go together; leave one of them out");
  return MirroredPose(stroke, mirror, positions).find();
}

}  // namespace

struct PoseDrag::State {
  PoseStroke pose;               // without targets
  std::vector<PosedPart> parts;  // at the beginning
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

  // Returns the number of steps to the targets.
  double steps_to(const std::vector<Way>& to, const std::vector<Vec3d>& pins_to) const {
    double steps = 1;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      steps = std::max(steps, std::abs(to[i].angle_deg - ways[i].angle_deg) / kStepAngle);
      for (const Vec3d& start : parts[i].points) {
        steps = std::max(steps, norm(place(i, start, to[i]) - place(i, start, ways[i])) / (kStepOfDrag * spacing));
      }
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      steps = std::max(steps, norm(pins_to[i] - places[i]) / (kStepOfDrag * spacing));
    }
    return steps;
  }
};

PoseDrag::PoseDrag(const PoseStroke& stroke, const LiveSurface& surface, int threads) {
  validate(stroke);
  std::vector<std::string> warnings;
  PoseStroke live = stroke;
  if (live.detail == 0) live.detail = std::max(kMinDetailOfStroke, usual_detail(stroke, surface));
  PoseProblem problem = problem_of(live, surface, kSamples, kMinDetailOfStroke, threads, warnings);
  problem.settles = false;
  problem.tolerance = 0;
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

// The description of the tool "pose".

constinit const detail::ToolRow<PoseStroke> PoseStroke::tool{.name = "pose",
                                                             .keys = keys,
                                                             .validate = validate,
                                                             .resolve = resolve,
                                                             .segments = segments,
                                                             .words = words,
                                                             .prolong = prolong,
                                                             .with_images = with_images};

}  // namespace knead
