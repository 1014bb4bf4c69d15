// Poses step by step: parts and pins ask for their rates, and the body follows as rigidly as it can.
#include "pose/pose_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/region.h"
#include "knead/vec.h"
#include "pose/sound_steps.h"

namespace knead::detail {

namespace {

constexpr double kMaxAngle = std::numbers::pi / 22;  // of a part in one segment
// The greatest motion of a part in one segment: a fraction of the diagonal, within bounds in spacings.
constexpr double kStepFraction = 0.03;
constexpr double kMinStep = 0.5;
constexpr double kMaxStep = 1.5;
// Weights of rows, in units of the mean diagonal of the strain times spacing^2.
constexpr double kPinWeight = 600;  // of all its points together
constexpr double kHoldWeight = 500;
constexpr double kPartWeight = 5600;  // of all its points together, for 150 unknowns; grows with their number
constexpr double kMinWeightUnknowns = 150;
constexpr double kMaxWeightUnknowns = 2000;
constexpr double kAcrossWeight = 200;
constexpr double kMargin = 0.25;  // around all points, in spacings
constexpr int kMaxSegments = 2000;
constexpr int kCorrections = 2;          // of the wanted velocities, by where the points arrive
constexpr double kMaxCorrection = 0.25;  // in spacings
constexpr double kTolerance = 1e-6;      // of the diagonal, for the body's own points

double length_of(const std::vector<Vec3d>& path) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) length += norm(path[i + 1] - path[i]);
  return length;
}

// Returns the position on a path after a fraction of its length, from 0 to 1.
Vec3d place_by_length(const std::vector<Vec3d>& path, double part) {
  double rest = part * length_of(path);
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const double piece = norm(path[i + 1] - path[i]);
    if (rest <= piece && piece > 0) return path[i] + (path[i + 1] - path[i]) * (rest / piece);
    rest -= piece;
  }
  return path.back();
}

Vec3d place_of(const PosedPart& part, const Vec3d& start, double t) {
  if (part.way) return part.way(start, t);
  return part.center + rotate(start - part.center, part.axis, sincos(part.angle * t)) + part.translation * t;
}

// The velocities of a rigid body.
struct RigidRate {
  Vec3d middle;
  Vec3d velocity;  // of the middle
  Vec3d turn{0, 0, 0};

  Vec3d at(const Vec3d& x) const { return velocity + cross(turn, x - middle); }
};

// Returns the rate nearest to the velocities at the points. Points on a line leave the turn about it undetermined; a
// little inertia makes it 0.
RigidRate rigid_rate(const std::vector<Vec3d>& points, const std::vector<Vec3d>& velocities) {
  constexpr double kExtraInertia = 1e-6;  // relative to the moment of inertia
  const auto count = static_cast<double>(points.size());
  RigidRate rate{{0, 0, 0}, {0, 0, 0}};
  for (const Vec3d& p : points) rate.middle += (p - points.front()) / count;
  rate.middle += points.front();
  for (const Vec3d& v : velocities) rate.velocity += v / count;
  Mat3d inertia{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  Vec3d momentum{0, 0, 0};
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d d = points[i] - rate.middle;
    const double square = dot(d, d);
    inertia.row0 += Vec3d{square - d.x * d.x, -d.x * d.y, -d.x * d.z};
    inertia.row1 += Vec3d{-d.y * d.x, square - d.y * d.y, -d.y * d.z};
    inertia.row2 += Vec3d{-d.z * d.x, -d.z * d.y, square - d.z * d.z};
    momentum += cross(d, velocities[i]);
    sum += square;
  }
  if (!(sum > 0)) return rate;
  inertia.row0.x += kExtraInertia * sum;
  inertia.row1.y += kExtraInertia * sum;
  inertia.row2.z += kExtraInertia * sum;
  const double determinant = dot(inertia.row0, cross(inertia.row1, inertia.row2));
  rate.turn = (cross(inertia.row1, inertia.row2) * momentum.x + cross(inertia.row2, inertia.row0) * momentum.y +
               cross(inertia.row0, inertia.row1) * momentum.z) /
              determinant;
  return rate;
}

// Returns the greatest distance that a point of the part moves in the whole pose.
double distance_of(const PosedPart& part) {
  constexpr int kPieces = 16;
  double greatest = 0;
  for (const Vec3d& start : part.points) {
    double distance = 0;
    for (int i = 0; i < kPieces && part.way; ++i) {
      distance += norm(part.way(start, (i + 1.0) / kPieces) - part.way(start, static_cast<double>(i) / kPieces));
    }
    if (!part.way) distance = std::abs(part.angle) * norm(cross(part.axis, start - part.center));
    greatest = std::max(greatest, distance);
  }
  return greatest + norm(part.translation);
}

// Returns the rate of a part in the middle of a step, times the step's duration.
RigidRate rate_of(const PosedPart& part, double begin, double end) {
  const double middle = 0.5 * (begin + end);
  const double time = end - begin;
  if (!part.way) {
    const Vec3d center = part.center + part.translation * middle;
    return {center, part.translation * time, part.axis * (part.angle * time)};
  }
  constexpr double kStep = 1e-5;
  std::vector<Vec3d> places;
  std::vector<Vec3d> velocities;
  for (const Vec3d& start : part.points) {
    places.push_back(part.way(start, middle));
    velocities.push_back((part.way(start, middle + kStep) - part.way(start, middle - kStep)) * (0.5 * time / kStep));
  }
  return rigid_rate(places, velocities);
}

// The times at which the steps of a pose begin and end: piece i of the paths lies between i and i + 1. Parts that have
// moved get one more step of no duration, in which they settle at their targets.
class Schedule {
 public:
  explicit Schedule(const PoseProblem& problem)
      : problem_(problem),
        longest_(std::clamp(kStepFraction * problem.diagonal, kMinStep * problem.spacing, kMaxStep * problem.spacing)) {
    for (const PosedPin& pin : problem.pins) {
      if (pin.path.size() < 2) continue;
      const std::size_t own = pin.path.size() - 1;
      if (pieces_ != 0 && pieces_ != own) together_ = false;
      pieces_ = std::max(pieces_, own);
    }
    if (pieces_ == 0 || !together_) pieces_ = 1;
    times_.push_back(0);
    for (std::size_t piece = 0; piece < pieces_; ++piece) {
      const double count = segments_in(piece);
      if (count + static_cast<double>(times_.size()) > kMaxSegments) {
        throw InvalidInput(
            fmt::format("\"parts\" move so far that the pose takes more than {} steps; move the parts less, or give a "
                        "larger \"detail\"",
                        kMaxSegments));
      }
      for (double k = 1; k <= count; ++k) times_.push_back(static_cast<double>(piece) + k / count);
    }
    const bool parts_move = problem.settles && std::any_of(problem.parts.begin(), problem.parts.end(),
                                                           [](const PosedPart& part) { return !part.holds(); });
    if (parts_move) times_.push_back(times_.back());
  }

  const std::vector<double>& times() const { return times_; }

  // Returns the fraction of the whole pose, from 0 to 1.
  double part_at(double time) const { return time / static_cast<double>(pieces_); }

  Vec3d place_of(const PosedPin& pin, double time) const {
    if (pin.path.size() == 1) return pin.path.front();
    if (!together_) return place_by_length(pin.path, time);
    const auto piece = std::min(static_cast<std::size_t>(time), pieces_ - 1);
    const double rest = time - static_cast<double>(piece);
    return pin.path[piece] * (1 - rest) + pin.path[piece + 1] * rest;
  }

 private:
  // Returns the number of segments of a piece: a whole number, 1 or more.
  double segments_in(std::size_t piece) const {
    const double share = 1 / static_cast<double>(pieces_);
    double count = 1;
    for (const PosedPart& part : problem_.parts) {
      const double distance = distance_of(part);
      count = std::max({count, share * std::abs(part.angle) / kMaxAngle, share * distance / longest_});
    }
    for (const PosedPin& pin : problem_.pins) {
      if (pin.turn) count = std::max(count, share * norm(*pin.turn) / kMaxAngle);
      if (pin.path.size() < 2) continue;
      const double distance = together_ ? norm(pin.path[piece + 1] - pin.path[piece]) : length_of(pin.path);
      count = std::max(count, distance / longest_);
    }
    return std::ceil(count * (1 - 1e-9));
  }

  const PoseProblem& problem_;
  double longest_ = 0;  // motion in a segment
  std::size_t pieces_ = 0;
  bool together_ = true;  // the paths advance piece by piece
  std::vector<double> times_;
};

}  // namespace

void find_surroundings(BodySamples& body, std::vector<Vec3d>& before, std::span<const VelocityRows> rows,
                       double spacing) {
  body.around.clear();
  const auto add = [&](const Vec3d& p) {
    const double off = kMargin * spacing;
    for (const double x : {-off, off}) {
      for (const double y : {-off, off}) {
        for (const double z : {-off, off}) body.around.push_back(p + Vec3d{x, y, z});
      }
    }
  };
  for (std::size_t i = 0; i < body.points.size(); ++i) {
    if (!body.held.empty() && body.held[i]) continue;
    add(body.points[i]);
    if (!before.empty()) add(body.points[i] * 2.0 - before[i]);
  }
  for (const VelocityRows& list : rows) {
    for (std::size_t k = 0; k < list.points.size() && !list.rests; ++k) add(list.points[k] + list.wanted[k]);
  }
  before = body.points;
}

std::vector<Vec3d> patch_about(const Vec3d& p, double size) {
  constexpr double kRadius = 0.7;  // of the size: half of a ball's points are farther out than 0.79
  const double golden = std::numbers::phi;
  const double by = kRadius * size / std::sqrt(1 + golden * golden);
  std::vector<Vec3d> points{p};
  for (const double a : {-by, by}) {
    for (const double b : {-by * golden, by * golden}) {
      points.push_back(p + Vec3d{0, a, b});
      points.push_back(p + Vec3d{a, b, 0});
      points.push_back(p + Vec3d{b, 0, a});
    }
  }
  return points;
}

class PoseRun::Motion {
 public:
  explicit Motion(PoseProblem problem) : problem_(std::move(problem)) {
    lattice_ = {problem_.body.points.front(), problem_.spacing};
    for (const PosedPart& part : problem_.parts) {
      starts_.push_back(part.points);
      checked_.push_back(part.checked);
      rows_.push_back({part.points, part.points, kHoldWeight});
    }
    for (const PosedPin& pin : problem_.pins) {
      std::vector<Vec3d> patch = patch_about(pin.path.front(), pin.size);
      const double weight = kPinWeight / static_cast<double>(patch.size());
      rows_.push_back({patch, patch, weight, !pin.turn});
    }
    if (problem_.across) {
      const std::size_t count = problem_.body.points.size();
      rows_.push_back({problem_.body.points, std::vector<Vec3d>(count), kAcrossWeight, false,
                       std::vector<Vec3d>(count, *problem_.across), true});
    }
    for (std::size_t i = 0; i < problem_.parts.size(); ++i) rows_[i].rests = problem_.parts[i].holds();
    limit_unknowns(problem_.max_unknowns);
  }

  PoseOutcome go(const std::function<bool(const PotentialGrid&)>& apply) {
    const Schedule schedule(problem_);
    schedule_ = &schedule;
    PoseOutcome begun;
    begun.unknowns = outcome_.unknowns;
    outcome_ = std::move(begun);
    SteppedMotion motion;
    motion.solve = [this](double from, double to) { return solve(from, to); };
    motion.take = [&](const PotentialGrid& grid) { return take(grid, apply); };
    motion.set_spacing = [this, first = problem_.spacing](double factor) { set_spacing(factor * first); };
    const SoundReach reach = step_soundly(schedule.times(), in_parts(motion));
    outcome_.reached = schedule.part_at(reach.time);
    outcome_.problem = outcome_.stopped ? std::string() : reach.problem;
    settle(reach.time, motion);
    schedule_ = nullptr;
    return std::move(outcome_);
  }

  void set_ways(std::vector<PosedPart> parts, std::vector<PosedPin> pins) {
    problem_.parts = std::move(parts);
    problem_.pins = std::move(pins);
  }

 private:
  // Returns the grid of a step from the present state, which stays.
  PotentialGrid solve(double from, double to) {
    if (outcome_.stopped) return {};
    stop_if_cancelled(problem_.progress);
    for (std::size_t i = 0; i < rows_.size(); ++i) want(i, from, to);
    std::vector<Vec3d> before = before_;
    find_surroundings(problem_.body, before, rows_, problem_.spacing);
    limit_unknowns(problem_.max_unknowns / 3 * 4);
    const NearRigidSystem system(lattice_, problem_.body, rows_, problem_.threads, problem_.progress);
    outcome_.unknowns = std::max(outcome_.unknowns, system.unknowns());
    PotentialGrid grid = system.solve(rows_);
    for (int round = 0; round < kCorrections && !problem_.pins.empty(); ++round) {
      correct(grid, to);
      grid = system.solve(rows_);
    }
    return grid;
  }

  std::string take(const PotentialGrid& grid, const std::function<bool(const PotentialGrid&)>& apply) {
    if (outcome_.stopped) return {};
    if (std::string problem = problem_.judge ? problem_.judge(grid) : std::string(); !problem.empty()) return problem;
    ++outcome_.segments;
    outcome_.stopped = !apply(grid);
    before_ = problem_.body.points;
    move(grid, problem_.body.points);
    for (VelocityRows& list : rows_) move(grid, list.points);
    for (std::vector<Vec3d>& points : checked_) move(grid, points);
    return {};
  }

  void set_spacing(double spacing) {
    problem_.spacing = spacing;
    problem_.most_spacing = std::max(problem_.most_spacing, spacing);
    lattice_.spacing = spacing;
  }

  // Moves parts and pins that ended too far from their targets nearer to these.
  void settle(double time, const SteppedMotion& motion) {
    constexpr int kMaxRounds = 5;
    find_misses(time);
    for (int round = 0; round < kMaxRounds && problem_.tolerance > 0 && !outcome_.stopped; ++round) {
      if (outcome_.part_distance <= problem_.tolerance || !motion.take(motion.solve(time, time)).empty()) return;
      find_misses(time);
    }
  }

  // Widens the spacing until there are at most `max_unknowns` unknowns.
  void limit_unknowns(std::size_t max_unknowns) {
    constexpr double kWider = 1.2;
    while (problem_.spacing < problem_.most_spacing && count_unknowns(lattice_, problem_.body, rows_) > max_unknowns) {
      problem_.spacing = std::min(problem_.most_spacing, kWider * problem_.spacing);
      lattice_.spacing = problem_.spacing;
    }
  }

  bool is_part(std::size_t list) const { return list < problem_.parts.size(); }
  bool is_pin(std::size_t list) const { return !is_part(list) && list < problem_.parts.size() + problem_.pins.size(); }

  // Sets the wanted rate of a list: from its present position to its target.
  void want(std::size_t i, double from, double to) {
    const double begin = schedule_->part_at(from);
    const double end = schedule_->part_at(to);
    if (is_part(i)) {
      const PosedPart& part = problem_.parts[i];
      rows_[i].rests = part.holds();
      part.holds() ? hold(i) : want(part, starts_[i], begin, end, rows_[i]);
    } else if (is_pin(i)) {
      VelocityRows& list = rows_[i];
      const PosedPin& pin = problem_.pins[i - problem_.parts.size()];
      const Vec3d by = schedule_->place_of(pin, to) - list.points.front();
      for (std::size_t k = 0; k < list.points.size(); ++k) {
        list.wanted[k] = by;
        if (pin.turn) list.wanted[k] += cross(*pin.turn * (end - begin), list.points[k] - list.points.front());
      }
    }
  }

  void hold(std::size_t i) {
    for (std::size_t k = 0; k < starts_[i].size(); ++k) {
      rows_[i].wanted[k] = clipped(starts_[i][k] - rows_[i].points[k]);
    }
  }

  // Wants the same rate at the positions to which the part moves: otherwise each step bends a thin part a little more.
  void want(const PosedPart& part, const std::vector<Vec3d>& starts, double begin, double end, VelocityRows& list) {
    const std::size_t count = starts.size();
    list.weight = kPartWeight / static_cast<double>(count) *
                  std::clamp(static_cast<double>(outcome_.unknowns), kMinWeightUnknowns, kMaxWeightUnknowns) /
                  kMinWeightUnknowns;
    list.points.resize(count);
    list.wanted.resize(count);
    std::vector<Vec3d> misses;
    for (std::size_t k = 0; k < count; ++k) {
      misses.push_back(clipped(place_of(part, starts[k], begin) - list.points[k]));
    }
    const RigidRate rate = rate_of(part, begin, end);
    const RigidRate back = rigid_rate(list.points, misses);
    for (std::size_t k = 0; k < count; ++k) list.wanted[k] = rate.at(list.points[k]) + misses[k];
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3d ahead = list.points[k] + list.wanted[k];
      list.points.push_back(ahead);
      list.wanted.push_back(rate.at(ahead) + back.at(ahead));
    }
  }

  // Adds the distance that a pin misses its target by to its wanted rate.
  void correct(const PotentialGrid& grid, double to) {
    for (std::size_t i = 0; i < problem_.pins.size(); ++i) {
      VelocityRows& list = rows_[problem_.parts.size() + i];
      std::vector<Vec3d> arrived{list.points.front()};
      move(grid, arrived);
      const Vec3d miss = clipped(schedule_->place_of(problem_.pins[i], to) - arrived.front());
      for (Vec3d& wanted : list.wanted) wanted += miss;
    }
  }

  // Limits corrections, which would grow without end where parts contradict each other.
  Vec3d clipped(const Vec3d& miss) const {
    const double max_length = kMaxCorrection * problem_.spacing;
    const double length = norm(miss);
    return length > max_length ? miss * (max_length / length) : miss;
  }

  void find_misses(double time) {
    const double part = schedule_->part_at(time);
    outcome_.part_distance = 0;
    outcome_.reached_points.clear();
    outcome_.places.clear();
    for (std::size_t i = 0; i < checked_.size(); ++i) {
      for (std::size_t k = 0; k < checked_[i].size(); ++k) {
        const Vec3d place = place_of(problem_.parts[i], problem_.parts[i].checked[k], part);
        outcome_.part_distance = std::max(outcome_.part_distance, norm(place - checked_[i][k]));
      }
    }
    for (std::size_t i = 0; i < problem_.parts.size() + problem_.pins.size(); ++i) {
      for (std::size_t k = 0; k < (is_part(i) ? starts_[i].size() : 1); ++k) {
        outcome_.reached_points.push_back(rows_[i].points[k]);
        outcome_.places.push_back(is_part(i) ? place_of(problem_.parts[i], starts_[i][k], schedule_->part_at(time))
                                             : schedule_->place_of(problem_.pins[i - problem_.parts.size()], time));
        outcome_.part_distance =
            std::max(outcome_.part_distance, norm(outcome_.places.back() - outcome_.reached_points.back()));
      }
    }
  }

  void move(const PotentialGrid& grid, std::vector<Vec3d>& points) const {
    Segment segment;
    segment.grid = grid;
    AdvectOptions options;
    options.tolerance = kTolerance * problem_.diagonal;
    options.precision = Precision::float64;
    options.threads = problem_.threads;
    advect({{std::move(segment)}}, points, options);
  }

  PoseProblem problem_;
  const Schedule* schedule_ = nullptr;  // during go()
  Lattice lattice_;
  std::vector<std::vector<Vec3d>> starts_;   // of the parts' points
  std::vector<std::vector<Vec3d>> checked_;  // of the parts, moved along
  std::vector<VelocityRows> rows_;           // of all parts, then of all pins
  std::vector<Vec3d> before_;                // the body's points one step earlier
  PoseOutcome outcome_;
};

PoseRun::PoseRun(PoseProblem problem) : motion_(std::make_unique<Motion>(std::move(problem))) {}
PoseRun::PoseRun(PoseRun&&) noexcept = default;
PoseRun& PoseRun::operator=(PoseRun&&) noexcept = default;
PoseRun::~PoseRun() = default;

PoseOutcome PoseRun::go(const std::function<bool(const PotentialGrid&)>& apply) { return motion_->go(apply); }

void PoseRun::set_ways(std::vector<PosedPart> parts, std::vector<PosedPin> pins) {
  motion_->set_ways(std::move(parts), std::move(pins));
}

}  // namespace knead::detail
