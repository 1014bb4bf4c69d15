// pose_skin(): stages of near-rigid flows, and the volume that flat triangles lose.
#include "knead/fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "mesh/body_points.h"
#include "mesh/edges.h"
#include "skin/joints.h"
#include "skin/stage_motion.h"
#include "strokes/pose.h"

namespace knead {

using namespace detail;

namespace {

using detail::BodySamples;

constexpr double kMaxRigidDistance = 0.25;  // of the diagonal, for 95% of the rigid vertices
constexpr double kMaxStep = 1.5;            // spacings that a limb moves in a step
constexpr double kShorterSteps = 1.5;       // as many, where a stage falls short
constexpr double kMinLostShare = 0.1;       // of the volume lost and gained at edges: less is not restored
constexpr double kTrialGrowth = 0.02;       // of the volume, the greatest at a sample
constexpr double kMaxGrowth = 0.5;          // more is not restored: the triangles are too coarse
constexpr double kStageRadius = 4;          // spacings: a stage does not include the body farther from moving limbs
constexpr std::size_t kInsideSamples = 3000;
constexpr double kBoneStiffness = 3;  // of samples in moving limbs, relative to flesh

double time_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Returns a flag for each vertex of a closed piece: each side of its triangles has one neighbour, with the opposite
// direction. A body is closed; clothes on it may be open.
std::vector<bool> closed_pieces(std::span<const Triangle> triangles, std::size_t vertices) {
  using Side = std::pair<std::uint32_t, std::uint32_t>;
  std::vector<Side> sides;
  DisjointSets pieces(vertices);
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sides.emplace_back(t[k], t[(k + 1) % 3]);
      pieces.join(t[k], t[(k + 1) % 3]);
    }
  }
  std::sort(sides.begin(), sides.end());
  std::vector<bool> is_open(vertices, false);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool is_twice = i > 0 && sides[i] == sides[i - 1];
    const bool has_other = std::binary_search(sides.begin(), sides.end(), Side{sides[i].second, sides[i].first});
    if (is_twice || !has_other) is_open[pieces.find(sides[i].first)] = true;
  }
  std::vector<bool> is_closed(vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) is_closed[v] = !is_open[pieces.find(v)];
  return is_closed;
}

double extent_of(const Mesh& mesh) {
  const double diagonal = shape_box(mesh).diagonal();
  if (!(diagonal > 0)) throw InvalidInput("the shape has no extent, so that nothing can be posed");
  return diagonal;
}

class Poser {
 public:
  Poser(const Mesh& mesh, const Skin& skin, const SkinPose& pose, const SkinOptions& options)
      : options_(options),
        triangles_(triangulate(mesh)),
        rest_(mesh.positions),
        positions_(mesh.positions),
        is_closed_(closed_pieces(triangles_, mesh.positions.size())),
        names_(skin.names),
        has_volume_(
            std::any_of(triangles_.begin(), triangles_.end(), [&](const Triangle& t) { return is_closed_[t[0]]; })),
        diagonal_(extent_of(mesh)),
        sound_(rest_, triangles_, kMaxPosedStretch, motion_options()) {
    joints_ = find_joints(rest_, triangles_, skin, pose, options.detail);
  }

  SkinResult run() {
    const auto start = std::chrono::steady_clock::now();
    SkinReport& report = result_.report;
    if (options_.progress != nullptr) {
      options_.progress->done = 0;
      options_.progress->total = kWorkOfStage * joints_.stages;
    }
    for (std::size_t stage = 0; stage < joints_.stages; ++stage) {
      run_stage(stage);
      if (options_.progress != nullptr) options_.progress->done = kWorkOfStage * (stage + 1);
    }
    find_distances();
    move_whole();
    report.notes.insert(report.notes.end(), joints_.notes.begin(), joints_.notes.end());
    report.bones = joints_.limbs.size() - 1;
    report.stages = joints_.stages;
    result_.positions = std::move(positions_);
    report.seconds = time_since(start);
    return std::move(result_);
  }

 private:
  void run_stage(std::size_t stage) {
    stop_if_cancelled(options_.progress);
    bodies_ = joints_.bodies(stage);
    const std::vector<bool> moving = moving_limbs(stage);
    StageProblem problem;
    problem.spacing = joints_.spacing[stage];
    problem.diagonal = diagonal_;
    problem.rest_gives = joints_.is_thin[stage];  // a palm deforms under fingers, a chest does not under an arm
    problem.threads = options_.threads;
    problem.progress = options_.progress;
    problem.motions = [this, stage](double part) { return joints_.motions(stage, part); };
    const std::vector<Triangle> near = near_triangles(stage, moving, kStageRadius * problem.spacing);
    LiveSurface surface;
    surface.positions = positions_;
    surface.triangles = near;
    std::vector<std::string> warnings;
    problem.body = detail::body_of(surface, problem.spacing, kInsideSamples, options_.threads, warnings);
    mark_held(moving, problem.body);
    if (!joints_.is_thin[stage]) stiffen_bones(moving, problem.body);  // fingers beside each other must deform
    add_limbs(stage, moving, near, problem);
    problem.steps = steps_of(stage, problem);
    const double volume = enclosed_volume();
    problem.judge = [this](const PotentialGrid& grid) { return sound_.take(grid); };
    const Flow flow = flow_of_stage(stage, problem);
    const std::vector<EdgeLoss> losses = has_volume_ ? lost_at_edges(flow, near) : std::vector<EdgeLoss>{};
    positions_ = sound_.positions();
    result_.report.segments += flow.segments.size();
    for (const Segment& segment : flow.segments) result_.strokes.emplace_back(GridStroke{segment.grid});
    give_back(losses, volume - enclosed_volume(), moving, problem);
  }

  // Returns the flow of a stage. One that falls short is tried once more in shorter steps, and the farther one counts.
  Flow flow_of_stage(std::size_t stage, StageProblem& problem) {
    const detail::SoundSurface start = sound_;
    StageProblem shorter = problem;
    detail::SoundReach reach;
    Flow flow = stage_flow(problem, result_.report.unknowns, reach);
    if (reach.time < 1) {
      if (options_.progress != nullptr) options_.progress->done = kWorkOfStage * stage;
      shorter.steps = static_cast<std::size_t>(std::ceil(kShorterSteps * static_cast<double>(shorter.steps)));
      detail::SoundSurface reached = std::exchange(sound_, start);
      detail::SoundReach second;
      Flow other = stage_flow(shorter, result_.report.unknowns, second);
      if (second.time > reach.time) {
        problem = std::move(shorter);
        reach = std::move(second);
        flow = std::move(other);
      } else {
        sound_ = std::move(reached);
      }
    }
    note_reach(stage, reach);
    return flow;
  }

  // Joints that fell short stay where they came to.
  void note_reach(std::size_t stage, const detail::SoundReach& reach) {
    if (reach.time >= 1) return;
    for (SkinLimb& limb : joints_.limbs) {
      if (limb.stage == stage) limb.reached = reach.time;
    }
    SkinReport& report = result_.report;
    report.reached = std::min(report.reached, reach.time);
    if (!report.shortfall.empty()) report.shortfall += "; ";
    report.shortfall += fmt::format("{} came {:.0f}% of their way: beyond that {}", joints_in(stage),
                                    std::floor(100 * reach.time), reach.problem);
  }

  // Returns the names of the bones whose joints turn in a stage, the first three of them.
  std::string joints_in(std::size_t stage) const {
    constexpr std::size_t kMaxNamed = 3;
    std::vector<std::string> names;
    for (std::size_t i = 1; i < joints_.limbs.size(); ++i) {
      const SkinLimb& limb = joints_.limbs[i];
      if (limb.stage == stage)
        names.push_back(limb.bone < names_.size() ? names_[limb.bone] : fmt::format("bone {}", limb.bone));
    }
    const std::size_t more = names.size() - std::min(names.size(), kMaxNamed);
    names.resize(names.size() - more);
    return fmt::format("{}{}", fmt::join(names, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
  }

  // The volume between the flat triangles at an edge and the curved surface that the flow makes of them. The flow keeps
  // the volume of the curved surface, so this part is missing: a quarter as much where edges are half as long.
  struct EdgeLoss {
    Vec3d place;
    double volume = 0;
  };

  // Returns the volume lost at the edges of triangles that bend in the flow of a stage, after which sound_ is. The
  // surface is a quadric through the images of the edges' middles.
  std::vector<EdgeLoss> lost_at_edges(const Flow& flow, const std::vector<Triangle>& near) {
    std::vector<Triangle> bending;
    std::vector<Vec3d> middles;
    for (const Triangle& t : near) {
      const auto is_rigid = [&](std::uint32_t v) { return rigid_body(v).has_value(); };
      if (!is_closed_[t[0]] || std::all_of(t.begin(), t.end(), is_rigid)) continue;
      bending.push_back(t);
      for (std::size_t k = 0; k < 3; ++k) middles.push_back((positions_[t[k]] + positions_[t[(k + 1) % 3]]) * 0.5);
    }
    move(flow, middles);
    const std::vector<Vec3d>& now = sound_.positions();
    std::vector<EdgeLoss> losses;
    for (std::size_t i = 0; i < middles.size(); ++i) {
      const Triangle& t = bending[i / 3];
      const std::array<Vec3d, 3> p{now[t[0]], now[t[1]], now[t[2]]};
      const Vec3d area = cross(p[1] - p[0], p[2] - p[0]) * 0.5;
      const Vec3d away = middles[i] - (p[i % 3] + p[(i + 1) % 3]) * 0.5;
      losses.push_back({middles[i], dot(away, area) / 3});
    }
    return losses;
  }

  // Lets the flesh grow where volume was lost, to restore it.
  void give_back(const std::vector<EdgeLoss>& losses, double missing, const std::vector<bool>& moving,
                 StageProblem& problem) {
    double sum = 0;
    for (const EdgeLoss& loss : losses) sum += std::abs(loss.volume);
    if (!(std::abs(missing) > kMinLostShare * sum) || problem.body.points.empty()) return;
    std::vector<Vec3d> places;
    places.reserve(losses.size());
    for (const EdgeLoss& loss : losses) places.push_back(loss.place);
    const std::vector<std::uint32_t> nearest = detail::nearest_of(problem.body.points, places);
    std::vector<double> growth(problem.body.points.size(), 0.0);
    for (std::size_t i = 0; i < losses.size(); ++i) growth[nearest[i]] += losses[i].volume;
    const double most = usual_size(growth);
    for (double& rate : growth) rate = std::clamp(rate / most, -1.0, 1.0) * kTrialGrowth;
    problem.body.held.clear();
    mark_held(std::vector<bool>(joints_.limbs.size(), false), problem.body);
    if (grow(growing_grid(problem, std::move(growth)), missing)) return;
    // There is too little room between the limbs, as in a fist: everything that moved grows a little.
    problem.body.held.clear();
    mark_held(moving, problem.body);
    std::erase_if(problem.limbs, [](const LimbPoints& limb) { return limb.moves; });
    growth.clear();
    for (const bool is_held : problem.body.held) growth.push_back(is_held ? 0 : kTrialGrowth);
    grow(growing_grid(problem, std::move(growth)), missing);
  }

  // Moves everything by the grid, scaled to restore the missing volume. Returns false if that would exceed kMaxGrowth.
  bool grow(PotentialGrid grid, double missing) {
    const std::vector<Vec3d> before = positions_;
    const double volume = enclosed_volume();
    Flow flow;
    flow.segments.emplace_back().grid = grid;
    move(flow);
    const double strength = missing / (enclosed_volume() - volume);  // the volume is nearly linear in it
    positions_ = before;
    if (!(std::abs(strength) * kTrialGrowth < kMaxGrowth)) return false;
    grid = multiplied(std::move(grid), strength);
    if (!sound_.take(grid).empty()) return false;
    positions_ = sound_.positions();
    result_.strokes.emplace_back(GridStroke{std::move(grid)});
    ++result_.report.segments;
    return true;
  }

  // Returns the 95th percentile of the sizes of the numbers other than 0, so that one deep fold does not dominate.
  static double usual_size(const std::vector<double>& numbers) {
    std::vector<double> sizes;
    for (const double number : numbers) {
      if (number != 0) sizes.push_back(std::abs(number));
    }
    std::sort(sizes.begin(), sizes.end());
    return sizes.empty() ? 1.0 : sizes[sizes.size() - 1 - sizes.size() / 20];
  }

  // Returns the volume within the closed pieces.
  double enclosed_volume() const {
    double sum = 0;
    if (!has_volume_) return sum;
    const Vec3d& middle = positions_.front();
    for (const Triangle& t : triangles_) {
      if (!is_closed_[t[0]]) continue;
      sum += dot(positions_[t[0]] - middle, cross(positions_[t[1]] - middle, positions_[t[2]] - middle)) / 6;
    }
    return sum;
  }

  // Returns the number of steps: no limb turns by more than 15 degrees, or moves by more than kMaxStep, in one.
  std::size_t steps_of(std::size_t stage, const StageProblem& problem) const {
    constexpr double kMaxTurn = std::numbers::pi / 12;
    constexpr int kPathPieces = 16;
    double steps = std::max(1.0, greatest_turn(stage) / kMaxTurn);
    std::vector<std::vector<Rigid>> motions;
    for (int i = 0; i <= kPathPieces; ++i) motions.push_back(problem.motions(static_cast<double>(i) / kPathPieces));
    for (const LimbPoints& limb : problem.limbs) {
      for (const Vec3d& p : limb.points) {
        if (!limb.moves) break;
        const Vec3d start = inverse(motions.front()[limb.limb])(p);
        double way = 0;
        for (std::size_t i = 0; i < kPathPieces; ++i)
          way += norm(motions[i + 1][limb.limb](start) - motions[i][limb.limb](start));
        steps = std::max(steps, way / (kMaxStep * problem.spacing));
      }
    }
    return static_cast<std::size_t>(std::ceil(steps));
  }

  // Finds the limbs that move in a stage: they turn, or a limb before them does.
  std::vector<bool> moving_limbs(std::size_t stage) const {
    std::vector<bool> moving(joints_.limbs.size(), false);
    for (std::size_t i = 1; i < moving.size(); ++i) {
      moving[i] = joints_.limbs[i].stage == stage || moving[*joints_.limbs[i].before];
    }
    return moving;
  }

  // Returns the body that a vertex moves rigidly with in the present stage. Flesh at a joint that turns in another
  // stage is rigid, too: free flesh on a grid for thinner joints would flow.
  std::optional<std::size_t> rigid_body(std::size_t v) const {
    return joints_.rigid_body(bodies_, v, options_.rigid_weight);
  }

  // Returns the weight of moving limbs at a vertex.
  double moving_weight(const std::vector<bool>& moving, std::size_t v) const {
    double sum = 0;
    for (std::size_t i = joints_.begin[v]; i < joints_.begin[v + 1]; ++i) {
      if (moving[joints_.weights[i].bone]) sum += joints_.weights[i].weight;
    }
    return sum;
  }

  // Returns the triangles that move, or are near the path of a vertex.
  std::vector<Triangle> near_triangles(std::size_t stage, const std::vector<bool>& moving, double distance) const {
    constexpr int kMoments = 8;
    std::vector<Vec3d> places;
    std::vector<bool> is_near(positions_.size(), false);
    const std::vector<Rigid> first = joints_.motions(stage, 0);
    for (int i = 0; i <= kMoments; ++i) {
      const std::vector<Rigid> now = joints_.motions(stage, static_cast<double>(i) / kMoments);
      std::vector<Vec3d> of_moment;
      for (std::size_t v = 0; v < positions_.size(); ++v) {
        if (!(moving_weight(moving, v) > 0)) continue;
        is_near[v] = true;
        const std::size_t limb = joints_.main_limb(v);
        of_moment.push_back(now[limb](inverse(first[limb])(positions_[v])));
      }
      for (const std::uint32_t p : points_apart(of_moment, 0.5 * distance)) places.push_back(of_moment[p]);
    }
    std::vector<Triangle> points;
    for (std::uint32_t p = 0; p < places.size(); ++p) points.push_back({p, p, p});
    const SurfaceTree tree(points, places);
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      is_near[v] = is_near[v] || tree.closest(positions_[v], 1.5 * distance).has_value();
    }
    std::vector<Triangle> result;
    for (const Triangle& t : triangles_) {
      if (is_near[t[0]] || is_near[t[1]] || is_near[t[2]]) result.push_back(t);
    }
    return result;
  }

  // Adds the points of each moving limb, and those of all resting ones.
  void add_limbs(std::size_t stage, const std::vector<bool>& moving, const std::vector<Triangle>& near,
                 StageProblem& problem) const {
    std::vector<bool> used(positions_.size(), false);
    for (const Triangle& t : near) {
      for (const std::uint32_t v : t) used[v] = true;
    }
    std::vector<std::vector<Vec3d>> points(joints_.limbs.size());
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      const std::optional<std::size_t> body = rigid_body(v);
      if (used[v] && body && !bends(stage, moving, v)) points[*body].push_back(positions_[v]);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i].empty()) continue;
      problem.limbs.push_back({i, moving[i], detail::part_of(points[i], problem.spacing).points});
    }
  }

  // Returns true if a vertex is so near to a turning joint that the flesh must bend there.
  bool bends(std::size_t stage, const std::vector<bool>& moving, std::size_t v) const {
    for (std::size_t i = 1; i < joints_.limbs.size(); ++i) {
      const SkinLimb& limb = joints_.limbs[i];
      if (limb.stage != stage || !moving[i]) continue;
      const Vec3d from = rest_[v] - limb.center;
      const double half = 0.5 * limb.bending_length();
      if (std::abs(dot(from, limb.direction)) < half && norm(from) < half + 2 * limb.radius) return true;
    }
    return false;
  }

  // Returns the greatest turn of a limb in a stage: against the limb before it, or by all joints of a chain together.
  double greatest_turn(std::size_t stage) const {
    double most = 0;
    const std::vector<Rigid> first = joints_.motions(stage, 0);
    std::vector<double> turns(joints_.limbs.size(), 0.0);
    std::vector<Rigid> before = first;
    constexpr int kPieces = 16;
    for (int i = 1; i <= kPieces; ++i) {
      const std::vector<Rigid> now = joints_.motions(stage, static_cast<double>(i) / kPieces);
      for (std::size_t k = 1; k < turns.size(); ++k) turns[k] += angle_of((now[k] * inverse(before[k])).turn);
      before = now;
    }
    for (std::size_t i = 1; i < turns.size(); ++i) {
      const SkinLimb& limb = joints_.limbs[i];
      most = std::max({most, turns[i], limb.stage == stage ? limb.screw.angle : 0.0});
    }
    return most;
  }

  // Marks the samples whose nearest vertex rests.
  void mark_held(const std::vector<bool>& moving, BodySamples& body) const {
    const std::vector<std::uint32_t> nearest = detail::nearest_of(positions_, body.points);
    for (const std::uint32_t v : nearest) {
      const std::optional<std::size_t> own = rigid_body(v);
      body.held.push_back(own && !moving[*own]);
    }
  }

  // Makes moving limbs stiffer than flesh, so that other limbs do not flatten them.
  void stiffen_bones(const std::vector<bool>& moving, BodySamples& body) const {
    const std::vector<std::uint32_t> nearest = detail::nearest_of(positions_, body.points);
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      const std::optional<std::size_t> own = rigid_body(nearest[i]);
      if (own && moving[*own]) body.stiffness[i] *= kBoneStiffness;
    }
  }

  void move(const Flow& flow) { move(flow, positions_); }

  void move(const Flow& flow, std::vector<Vec3d>& points) const {
    if (advect(flow, points, motion_options()).status == AdvectStatus::cancelled) throw Cancelled();
  }

  AdvectOptions motion_options() const {
    AdvectOptions options;
    options.tolerance = absolute_tolerance(kDefaultRelativeTolerance, diagonal_);
    options.threads = options_.threads;
    options.progress = options_.progress;
    return options;
  }

  // Finds the distances of rigid vertices from where their limbs take them.
  void find_distances() {
    const std::vector<Rigid> motions = joints_.motions(joints_.stages, 1);
    std::vector<double> distances;
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      const std::optional<std::size_t> limb = joints_.rigid_limb(v, options_.rigid_weight);
      if (limb) distances.push_back(norm(positions_[v] - motions[*limb](rest_[v])) / diagonal_);
    }
    if (distances.empty()) return;
    std::sort(distances.begin(), distances.end());
    result_.report.part_distance = distances.back();
    result_.report.part_distance_95 = distances[(distances.size() * 95 + 99) / 100 - 1];
    if (result_.report.part_distance_95 <= kMaxRigidDistance || !result_.report.shortfall.empty()) return;
    result_.report.shortfall =
        fmt::format("limbs end {:.0f}% of the shape's size from their bones: there is no room for them",
                    100 * result_.report.part_distance_95);
  }

  // Adds the turn and the shift of the skeleton as a whole.
  void move_whole() {
    constexpr double kNoMotion = 1e-12;
    const Vec3d center = bounding_box(positions_).center();
    double radius = 0;
    for (const Vec3d& p : positions_) radius = std::max(radius, norm(p - center));
    const Screw turn = screw_of(joints_.base, center);
    const auto add = [&](const Stroke& stroke) {
      move(flow_of(stroke));
      result_.strokes.push_back(stroke);
    };
    if (turn.angle > kNoMotion) {
      RotateStroke stroke;
      stroke.center = center;
      stroke.axis = turn.axis;
      stroke.angle_deg = turn.angle * 180 / std::numbers::pi;
      stroke.inner = 1.05 * radius;
      stroke.outer = 2 * radius;
      add(stroke);
    }
    const Vec3d shift = joints_.base(center) - center;
    if (norm(shift) > kNoMotion * diagonal_) {
      ImplicitStroke stroke;
      stroke.path = {center, center + shift};
      stroke.inner = 1.05 * radius;
      stroke.outer = 2 * radius;
      add(stroke);
    }
  }

  const SkinOptions& options_;
  std::vector<Triangle> triangles_;
  std::vector<Vec3d> rest_;
  std::vector<Vec3d> positions_;    // the present ones
  std::vector<bool> is_closed_;     // for each vertex: its piece of the surface is closed
  std::vector<std::string> names_;  // of the bones, or empty
  bool has_volume_ = false;         // a piece is closed
  double diagonal_ = 0;
  detail::SoundSurface sound_;  // moved by all grids so far
  Joints joints_;
  std::vector<std::size_t> bodies_;  // of the limbs in the present stage
  SkinResult result_;
};

void require_options(const SkinOptions& options) {
  if (!(options.rigid_weight >= 0.5 && options.rigid_weight < 1)) {
    throw InvalidInput(fmt::format("rigid_weight must be from 0.5 to below 1, got {}", options.rigid_weight));
  }
  if (options.detail != 0 && !(options.detail >= 0.5 && options.detail <= 4)) {
    throw InvalidInput(fmt::format("detail must be from 0.5 to 4, or 0 for the usual one, got {}", options.detail));
  }
}

// Compares poses with the shape at rest.
class RestShape {
 public:
  RestShape(const Mesh& mesh, int threads, const Progress* progress)
      : mesh_(mesh), triangles_(triangulate(mesh)), options_{.threads = threads, .progress = progress} {
    const Measures m = knead::measure(mesh, threads);
    has_volume_ = m.closed() && m.oriented() && m.volume != 0;
    volume_ = m.volume;
    crossings_ = self_intersections(triangles_, mesh.positions, options_);
  }

  SkinMeasures measure(std::span<const Vec3d> posed) const {
    SkinMeasures result;
    if (has_volume_) result.volume_error = measure_volume_and_area(mesh_, posed).volume / volume_ - 1;
    const SelfIntersections now = self_intersections(triangles_, posed, options_);
    result.crossings = now.count;
    result.crossings_new = count_new(now, crossings_);
    const SurfaceStretch stretch = surface_stretch(triangles_, mesh_.positions, posed);
    result.least_stretch = stretch.least;
    result.greatest_stretch = stretch.greatest;
    result.rms_log_stretch = stretch.rms_log;
    return result;
  }

 private:
  const Mesh& mesh_;
  std::vector<Triangle> triangles_;
  SelfIntersectionOptions options_;
  bool has_volume_ = false;
  double volume_ = 0;
  SelfIntersections crossings_;
};

}  // namespace

SkinResult pose_skin(const Mesh& mesh, const Skin& skin, const SkinPose& pose, const SkinOptions& options,
                     bool measured) {
  knead::validate(mesh);
  validate(skin, mesh.positions.size());
  validate(skin, pose);
  require_options(options);
  const WeldedMesh welded(mesh);
  SkinResult result = Poser(welded.mesh(), skin, pose, options).run();
  SkinReport& report = result.report;
  const RestShape rest(welded.mesh(), options.threads, options.progress);
  report.flow = rest.measure(result.positions);
  if (!measured) return result;
  report.linear = rest.measure(linear_blend(mesh.positions, skin, pose));
  report.dual = rest.measure(dual_quaternion_blend(mesh.positions, skin, pose));
  return result;
}

}  // namespace knead
