#include "pose/pose_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/region.h"
#include "knead/vec.h"

namespace knead::detail {

namespace {

constexpr double kMaxAngle = std::numbers::pi / 22;  // of a part in one segment
// How far it moves there at most: so far of the diagonal, but within these bounds, of the spacing.
constexpr double kUsualStep = 0.03;
constexpr double kMinStep = 0.5;
constexpr double kMaxStep = 1.5;
// Weights of rows, in units of the mean diagonal of the strain times spacing^2.
constexpr double kWeightOfPin = 600;  // by the number of its points
constexpr double kWeightOfHold = 500;
constexpr double kWeightOfPart = 5600;  // by the number of points, and for 150 unknowns
constexpr double kUsualUnknowns = 150;
constexpr double kMostUnknowns = 2000;  // that count for that
constexpr double kWeightAcross = 200;
constexpr double kMargin = 0.25;  // of the spacing, about all points
constexpr int kMaxSegments = 2000;
constexpr int kCorrections = 2;              // of the wanted velocities, by where the points arrive
constexpr double kMaxCorrection = 0.25;      // of the spacing
constexpr std::size_t kManyUnknowns = 9000;  // more than that are not begun with, and
constexpr std::size_t kMaxInAStep = 12'000;  // more than that not gone on with, where a wider spacing is allowed
constexpr double kTolerance = 1e-6;          // of the diagonal, for the body's own points

double length_of(const std::vector<Vec3d>& path) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) length += norm(path[i + 1] - path[i]);
  return length;
}

// The place on a path after a part of its length, from 0 to 1.
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

// The rate that is nearest to the velocities at points; points on a line do not say how they turn about it.
RigidRate rigid_rate(const std::vector<Vec3d>& points, const std::vector<Vec3d>& velocities) {
  constexpr double kLine = 1e-6;  // of the moment of inertia
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
  inertia.row0.x += kLine * sum;
  inertia.row1.y += kLine * sum;
  inertia.row2.z += kLine * sum;
  // Cramer's rule
  const double determinant = dot(inertia.row0, cross(inertia.row1, inertia.row2));
  rate.turn = (cross(inertia.row1, inertia.row2) * momentum.x + cross(inertia.row2, inertia.row0) * momentum.y +
               cross(inertia.row0, inertia.row1) * momentum.z) /
              determinant;
  return rate;
}

// How far it goes at most in the whole pose.
double distance_of(const PosedPart& part) {
  constexpr int kPieces = 16;
  double most = 0;
  for (const Vec3d& start : part.points) {
    double distance = 0;
    for (int i = 0; i < kPieces && part.way; ++i) {
      distance += norm(part.way(start, (i + 1.0) / kPieces) - part.way(start, static_cast<double>(i) / kPieces));
    }
    if (!part.way) distance = std::abs(part.angle) * norm(cross(part.axis, start - part.center));
    most = std::max(most, distance);
  }
  return most + norm(part.translation);
}

// The rate at which a part goes its way in the middle of a step, times the step's time.
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

// A time of the pose: piece i of the paths lies between i and i + 1, and the last one ends at `pieces`. Parts that have
// moved get one more step without time, in which they settle at their places.
class Schedule {
 public:
  explicit Schedule(const PoseProblem& problem)
      : problem_(problem),
        longest_(std::clamp(kUsualStep * problem.diagonal, kMinStep * problem.spacing, kMaxStep * problem.spacing)) {
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

  // From 0 to 1 over the whole pose.
  double part_at(double time) const { return time / static_cast<double>(pieces_); }

  Vec3d place_of(const PosedPin& pin, double time) const {
    if (pin.path.size() == 1) return pin.path.front();
    if (!together_) return place_by_length(pin.path, time);
    const auto piece = std::min(static_cast<std::size_t>(time), pieces_ - 1);
    const double rest = time - static_cast<double>(piece);
    return pin.path[piece] * (1 - rest) + pin.path[piece + 1] * rest;
  }

 private:
  // A whole number, 1 or more.
  double segments_in(std::size_t piece) const {
    const double share = 1 / static_cast<double>(pieces_);
    double most = 1;
    for (const PosedPart& part : problem_.parts) {
      const double distance = distance_of(part);
      most = std::max({most, share * std::abs(part.angle) / kMaxAngle, share * distance / longest_});
    }
    for (const PosedPin& pin : problem_.pins) {
      if (pin.turn) most = std::max(most, share * norm(*pin.turn) / kMaxAngle);
      if (pin.path.size() < 2) continue;
      const double distance = together_ ? norm(pin.path[piece + 1] - pin.path[piece]) : length_of(pin.path);
      most = std::max(most, distance / longest_);
    }
    return std::ceil(most * (1 - 1e-9));
  }

  const PoseProblem& problem_;
  double longest_ = 0;  // that anything moves in a segment
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
      rows_.push_back({part.points, part.points, kWeightOfHold});
    }
    for (const PosedPin& pin : problem_.pins) {
      std::vector<Vec3d> patch = patch_about(pin.path.front(), pin.size);
      const double weight = kWeightOfPin / static_cast<double>(patch.size());
      rows_.push_back({patch, patch, weight, !pin.turn});
    }
    if (problem_.across) {
      const std::size_t count = problem_.body.points.size();
      rows_.push_back({problem_.body.points, std::vector<Vec3d>(count), kWeightAcross, false,
                       std::vector<Vec3d>(count, *problem_.across), true});
    }
    for (std::size_t i = 0; i < problem_.parts.size(); ++i) rows_[i].rests = problem_.parts[i].holds();
    limit_unknowns(kManyUnknowns);
  }

  PoseOutcome go(const std::function<bool(const PotentialGrid&)>& apply) {
    const Schedule schedule(problem_);
    schedule_ = &schedule;
    PoseOutcome begun;
    begun.unknowns = outcome_.unknowns;
    outcome_ = std::move(begun);
    const std::vector<double>& times = schedule.times();
    for (std::size_t k = 0; k + 1 < times.size() && !outcome_.stopped; ++k) step(times[k], times[k + 1], apply);
    find_misses(times.back());
    schedule_ = nullptr;
    return std::move(outcome_);
  }

  void set_ways(std::vector<PosedPart> parts, std::vector<PosedPin> pins) {
    problem_.parts = std::move(parts);
    problem_.pins = std::move(pins);
  }

 private:
  void step(double from, double to, const std::function<bool(const PotentialGrid&)>& apply) {
    stop_if_cancelled(problem_.progress);
    for (std::size_t i = 0; i < rows_.size(); ++i) want(i, from, to);
    find_surroundings(problem_.body, before_, rows_, problem_.spacing);
    limit_unknowns(kMaxInAStep);
    const NearRigidSystem system(lattice_, problem_.body, rows_, problem_.threads, problem_.progress);
    outcome_.unknowns = std::max(outcome_.unknowns, system.unknowns());
    PotentialGrid grid = system.solve(rows_);
    for (int round = 0; round < kCorrections && !problem_.pins.empty(); ++round) {
      correct(grid, to);
      grid = system.solve(rows_);
    }
    ++outcome_.segments;
    outcome_.stopped = !apply(grid);
    move(grid, problem_.body.points);
    for (VelocityRows& list : rows_) move(grid, list.points);
    for (std::vector<Vec3d>& points : checked_) move(grid, points);
  }

  // Makes the spacing wider until the unknowns are no more than so many.
  void limit_unknowns(std::size_t most) {
    constexpr double kWider = 1.2;
    while (problem_.spacing < problem_.most_spacing && count_unknowns(lattice_, problem_.body, rows_) > most) {
      problem_.spacing = std::min(problem_.most_spacing, kWider * problem_.spacing);
      lattice_.spacing = problem_.spacing;
    }
  }

  bool is_part(std::size_t list) const { return list < problem_.parts.size(); }
  bool is_pin(std::size_t list) const { return !is_part(list) && list < problem_.parts.size() + problem_.pins.size(); }

  // The rate at which a list goes from where it is to where it should be.
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

  // The same rate is wanted where the part comes to: else a thin part is bent a little more by each step.
  void want(const PosedPart& part, const std::vector<Vec3d>& starts, double begin, double end, VelocityRows& list) {
    const std::size_t count = starts.size();
    list.weight = kWeightOfPart / static_cast<double>(count) *
                  std::clamp(static_cast<double>(outcome_.unknowns), kUsualUnknowns, kMostUnknowns) / kUsualUnknowns;
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

  // Adds to the wanted rates of the pins what is missing where they arrive.
  void correct(const PotentialGrid& grid, double to) {
    for (std::size_t i = 0; i < problem_.pins.size(); ++i) {
      VelocityRows& list = rows_[problem_.parts.size() + i];
      std::vector<Vec3d> arrived{list.points.front()};
      move(grid, arrived);
      const Vec3d miss = clipped(schedule_->place_of(problem_.pins[i], to) - arrived.front());
      for (Vec3d& wanted : list.wanted) wanted += miss;
    }
  }

  // Where parts contradict each other, corrections would grow without end.
  Vec3d clipped(const Vec3d& miss) const {
    const double most = kMaxCorrection * problem_.spacing;
    const double length = norm(miss);
    return length > most ? miss * (most / length) : miss;
  }

  void find_misses(double time) {
    const double part = schedule_->part_at(time);
    for (std::size_t i = 0; i < checked_.size(); ++i) {
      for (std::size_t k = 0; k < checked_[i].size(); ++k) {
        const Vec3d place = place_of(problem_.parts[i], problem_.parts[i].checked[k], part);
        outcome_.part_distance = std::max(outcome_.part_distance, norm(place - checked_[i][k]));
      }
    }
    for (std::size_t i = 0; i < problem_.parts.size() + problem_.pins.size(); ++i) {
      for (std::size_t k = 0; k < (is_part(i) ? starts_[i].size() : 1); ++k) {
        outcome_.reached.push_back(rows_[i].points[k]);
        outcome_.places.push_back(is_part(i) ? place_of(problem_.parts[i], starts_[i][k], schedule_->part_at(time))
                                             : schedule_->place_of(problem_.pins[i - problem_.parts.size()], time));
        outcome_.part_distance =
            std::max(outcome_.part_distance, norm(outcome_.places.back() - outcome_.reached.back()));
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
  const Schedule* schedule_ = nullptr;  // while it goes
  Lattice lattice_;
  std::vector<std::vector<Vec3d>> starts_;   // of the parts' points
  std::vector<std::vector<Vec3d>> checked_;  // of the parts, moved along
  std::vector<VelocityRows> rows_;           // of all parts, then of all pins
  std::vector<Vec3d> before_;                // where the body's points were a step ago
  PoseOutcome outcome_;
};

std::size_t pose_segments(const PoseProblem& problem) { return Schedule(problem).times().size() - 1; }

PoseRun::PoseRun(PoseProblem problem) : motion_(std::make_unique<Motion>(std::move(problem))) {}
PoseRun::PoseRun(PoseRun&&) noexcept = default;
PoseRun& PoseRun::operator=(PoseRun&&) noexcept = default;
PoseRun::~PoseRun() = default;

PoseOutcome PoseRun::go(const std::function<bool(const PotentialGrid&)>& apply) { return motion_->go(apply); }

void PoseRun::set_ways(std::vector<PosedPart> parts, std::vector<PosedPin> pins) {
  motion_->set_ways(std::move(parts), std::move(pins));
}

}  // namespace knead::detail
