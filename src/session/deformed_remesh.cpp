// The mesh of a deformed shape follows its strokes.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "flow/block_mover.h"
#include "flow/masked.h"
#include "flow/segment_map.h"
#include "flow/segment_mover.h"
#include "knead/editor/shape_state.h"
#include "knead/flow.h"
#include "remesh/patch.h"
#include "session/deformed_shape_detail.h"

namespace knead {

namespace {

constexpr const char* kNormals = "knead carried normal";  // the vertex attribute that carries normals through a remesh

// Limits on the work of a remesh: evaluations for each vertex that the mesh may have (a few seconds by default), or a
// multiple of the work of the stroke itself. That is measured on some of the vertices, so that it does not depend on
// how often the stroke was begun and undone in a drag. kElements points of a set, or pins, cost as much as a field.
constexpr double kEvaluationsPerVertex = 350;
constexpr double kMoreThanStroke = 10;
constexpr double kElements = 4;
constexpr std::size_t kElementsOfGrid = 12;
constexpr double kMinEach = 0.1;          // evaluations for each segment: to find that a point rests is work, too
constexpr double kFewPoints = 100;        // too few to estimate the cost of others
constexpr std::size_t kCostSamples = 64;  // vertices

// Returns the cost of an evaluation relative to one of a ball.
double cost_of(const Flow& flow) {
  std::size_t elements = 0;
  const auto add = [&](const PointSet<double>& set) {
    elements += set.points.size();
    for (const auto& curve : set.curves) elements += curve.size();
  };
  const Flow parts = detail::each_part(flow);
  for (const Segment& segment : parts.segments) {
    if (!segment.grid.is_empty() || detail::is_map(segment)) elements += kElementsOfGrid;
    if (segment.time_law == TimeLaw::pinned) elements += segment.fields.size();
    for (const Field& field : segment.fields) {
      if (const auto* set = std::get_if<PointSet<double>>(&field.region)) add(*set);
      if (const auto* handles = std::get_if<Handles<double>>(&field.region)) {
        add(handles->full);
        add(handles->zero);
      }
    }
  }
  return 1 + static_cast<double>(elements) / (kElements * static_cast<double>(flow.segments.size()));
}

// The cost of carrying the points of a remesh, and its limit for a stroke.
struct CarryBudget {
  double most = 0;           // evaluations, in those of a ball
  double points = 0;         // carried
  double spent = 0;          // evaluations on them
  double of_the_stroke = 0;  // for each vertex
  double least = 0;          // for each point

  // Returns about how many more points may be carried, given the evaluations spent for the stroke.
  double points_left(double spent_for_the_stroke) const {
    const double each = std::max(least, points < kFewPoints ? of_the_stroke : spent / points);
    return std::max(0.0, most - spent_for_the_stroke) / each;
  }
};

// A flow after which triangles cross is halved at most kMaxHalvings times. All halves together may have at most
// kMoreThanWhole times the faces of the whole. None is begun if more than kMaxPairsPerFace pairs cross for each face,
// because halves do not help then.
constexpr int kMaxHalvings = 3;
constexpr std::size_t kMoreThanWhole = 4;
constexpr double kMaxPairsPerFace = 0.5;
constexpr double kTimeOfHalves = 0.5;  // of the remaining time

// A mask's border is narrow if the stroke moves a vertex farther than twice its width. Places along it then drift apart
// exponentially, and with them grows the mesh that a whole flow needs; halves, remeshed in between, need far less. So
// these fractions limit the work of each part of the flow, before its halves are tried, and of all parts. The last
// number is the cost of a remeshed face, in evaluations.
constexpr double kNarrow = 0.5;
constexpr double kWorkOfPart = 1.0 / 64;
constexpr double kWorkOfNarrow = 1.0 / 8;
constexpr double kWorkOfFace = 1000;
constexpr int kMaxHalvingsOfNarrow = 8;
constexpr double kRoundedUp = 1.05;  // a width in a message, so that its two digits suffice

using Moment = std::chrono::steady_clock::time_point;

constexpr double kLongest = 1e9;  // seconds, 30 years: no limit above that

Moment after(double seconds) {
  if (seconds > kLongest) return Moment::max();
  return std::chrono::steady_clock::now() +
         std::chrono::duration_cast<Moment::duration>(std::chrono::duration<double>(seconds));
}

double seconds_until(Moment end) {
  if (end == Moment::max()) return kInfinity;
  return std::chrono::duration<double>(end - std::chrono::steady_clock::now()).count();
}

bool has_new_crossings(const RemeshCounts& counts) { return counts.crossings > counts.crossings_before; }

// The width from which on the mask's border is not narrow for a stroke that has moved the vertices so far; 0 if the
// flow does not reach the mask.
double sufficient_width(const Flow& flow, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  double farthest2 = 0;
  for (std::size_t i = 0; i < before.size(); ++i) farthest2 = std::max(farthest2, norm2(after[i] - before[i]));
  const auto acts = [](const Segment& segment) { return detail::mask_on(segment).acts; };
  const bool is_reached = std::any_of(flow.segments.begin(), flow.segments.end(), acts);
  return is_reached ? kNarrow * std::sqrt(farthest2) : 0;
}

std::pair<Flow, Flow> halves_of(const Flow& flow) {
  const std::size_t half = flow.segments.size() / 2;
  const auto middle = flow.segments.begin() + static_cast<std::ptrdiff_t>(half);
  std::pair<Flow, Flow> halves{{{flow.segments.begin(), middle}}, {{middle, flow.segments.end()}}};
  if (flow.segments.size() % 2 == 0) return halves;
  halves.first.segments.push_back(*middle);
  double& cut = halves.first.segments.back().end;
  cut = 0.5 * (middle->begin + cut);
  halves.second.segments.front().begin = cut;
  return halves;
}

// Ends a remesh whose points could not be carried.
struct Stopped {
  AdvectStatus status;
};
struct TooMuchWork {};

// The remaining budget is an estimate, because path lines differ: the work ends at this multiple of the budget.
constexpr double kMoreThanBudget = 2;
constexpr std::uint64_t kAnyNumber = std::numeric_limits<std::uint64_t>::max();

// Returns a number of evaluations; 0 if it is below that.
std::uint64_t whole_number(double evaluations) {
  constexpr double kMax = 1e18;
  return static_cast<std::uint64_t>(std::clamp(evaluations, 0.0, kMax));
}

void add(const RemeshCounts& more, RemeshCounts& counts) {
  counts.splits += more.splits;
  counts.collapses += more.collapses;
  counts.flips += more.flips;
  counts.crossings = more.crossings;
  counts.crossings_before = more.crossings_before;
  counts.curves = more.curves;
  counts.curves_before = more.curves_before;
  counts.missing_volume += more.missing_volume;
  counts.compensated_volume += more.compensated_volume;
  counts.complete = counts.complete && more.complete;
  counts.out_of_time = counts.out_of_time || more.out_of_time;
}

// Sets the functions of a deformation that say what a flow may move, and the size of its details, which for grids
// depends on the place.
void set_support(const FlowSupport& support, const Flow& flow, Deformation& deformation) {
  deformation.may_move = [&](const Vec3d& center, double radius) { return support.may_move(center, radius); };
  deformation.feature = support.smallest_feature();
  const auto has_grid = [](const Segment& s) { return !(s.parts.empty() ? s : s.parts.front()).grid.is_empty(); };
  if (std::none_of(flow.segments.begin(), flow.segments.end(), has_grid)) return;
  deformation.feature_near = [&](const Vec3d& center, double radius) {
    return support.smallest_feature(center, radius);
  };
}

// Combines two remeshes: makes the second one, of the result of the first, a remesh of the mesh before both.
void join(const Remeshed& first, Remeshed& second) {
  for (std::uint32_t& face : second.face_source) face = first.face_source[face];
  for (std::size_t v = 0; v < second.vertex_source.size(); ++v) {
    std::uint32_t& source = second.vertex_source[v];
    second.moved[v] = second.moved[v] || source == kNewVertex || first.moved[source];
    if (source != kNewVertex) source = first.vertex_source[source];
  }
  RemeshCounts counts = first.counts;
  add(second.counts, counts);
  second.counts = counts;
}

Provenance unchanged(const Mesh& mesh) {
  Provenance result;
  result.face_source.resize(mesh.face_count());
  std::iota(result.face_source.begin(), result.face_source.end(), 0U);
  result.vertex_source.resize(mesh.vertex_count());
  std::iota(result.vertex_source.begin(), result.vertex_source.end(), 0U);
  result.touched.resize(mesh.vertex_count());
  result.rest = mesh.positions;
  return result;
}

std::vector<std::uint32_t> labels_of(const Provenance& provenance, const std::vector<std::uint32_t>& at_start) {
  std::vector<std::uint32_t> labels;
  if (at_start.empty()) return labels;
  labels.reserve(provenance.face_source.size());
  for (const std::uint32_t face : provenance.face_source) labels.push_back(at_start[face]);
  return labels;
}

// With their lengths, so that unit normals stay unit normals between vertices.
void add_normals(const std::vector<Vec3d>& normals, Mesh& mesh) {
  if (normals.empty()) return;
  Attribute attribute{kNormals, Domain::vertex, NumberType::float64, 4, {}};
  attribute.values.reserve(4 * normals.size());
  for (const Vec3d& n : normals) attribute.values.insert(attribute.values.end(), {n.x, n.y, n.z, norm(n)});
  mesh.attributes.push_back(std::move(attribute));
}

// Takes them out of the mesh again.
std::vector<Vec3d> take_normals(Mesh& mesh) {
  const Attribute attribute = std::move(mesh.attributes.back());
  mesh.attributes.pop_back();
  std::vector<Vec3d> normals(attribute.values.size() / 4);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double* const value = attribute.values.data() + 4 * i;
    const Vec3d n{value[0], value[1], value[2]};
    normals[i] = norm(n) > 0 ? n * (value[3] / norm(n)) : n;
  }
  return normals;
}

// Returns the mesh with the vertices at these positions and, where there are normals, with an attribute that carries
// them.
std::shared_ptr<const Mesh> mesh_at(const std::shared_ptr<const Mesh>& mesh, std::span<const Vec3d> positions,
                                    const std::vector<Vec3d>& normals) {
  const auto& now = mesh->positions;
  const bool is_there = std::equal(positions.begin(), positions.end(), now.begin(), now.end(), same_bits);
  if (is_there && normals.empty()) return mesh;
  Mesh result;
  result.positions.assign(positions.begin(), positions.end());
  result.face_begin = mesh->face_begin;
  result.corner_vertex = mesh->corner_vertex;
  result.attributes = mesh->attributes;
  add_normals(normals, result);
  return std::make_shared<const Mesh>(std::move(result));
}

// Hands on the data of the vertices and faces before a remesh to those after it.
Provenance after_remesh(const Provenance& before, const Remeshed& remeshed, const std::vector<bool>& touched_before,
                        std::span<const Vec3d> positions_before) {
  const std::size_t count = remeshed.vertex_source.size();
  Provenance after;
  after.vertex_source.assign(count, kNewVertex);
  after.touched = remeshed.moved;
  after.is_renumbered = before.is_renumbered || count != before.vertex_source.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t source = remeshed.vertex_source[i];
    after.is_renumbered = after.is_renumbered || source != i;
    if (source == kNewVertex) {
      after.touched[i] = true;
      continue;
    }
    after.vertex_source[i] = before.vertex_source[source];
    if (touched_before[source] || remeshed.mesh.positions[i] != positions_before[source]) after.touched[i] = true;
  }
  after.face_source.resize(remeshed.face_source.size());
  std::transform(remeshed.face_source.begin(), remeshed.face_source.end(), after.face_source.begin(),
                 [&](std::uint32_t face) { return before.face_source[face]; });
  after.creases = remeshed.creases;
  after.counts = before.counts;
  add(remeshed.counts, after.counts);
  return after;
}

// 1 for each vertex that the mask holds; empty without a mask.
std::vector<std::uint8_t> held_vertices(const Mask& mask, std::span<const Vec3d> positions) {
  std::vector<std::uint8_t> held;
  if (mask.is_empty()) return held;
  held.reserve(positions.size());
  for (const Vec3d& p : positions) held.push_back(mask.holds(p) ? 1 : 0);
  return held;
}

}  // namespace

std::optional<RemeshSettings> DeformedShape::settings_of(const SessionStroke& stroke) const {
  if (mesh_->face_count() == 0) return std::nullopt;
  return stroke.remesh ? stroke.remesh : policy_->settings;
}

const RemeshTargets& DeformedShape::targets_of(const RemeshSettings& settings) const {
  if (!targets_ || targets_->first != settings) {
    validate(settings);
    targets_ = {settings, detail::resolve_on(settings, *start_, motion_.threads)};
  }
  return targets_->second;
}

namespace detail {

// Makes the mesh of a shape follow the flow of one stroke.
class MeshFollower {
 public:
  // A part of the stroke.
  struct Part {
    std::span<const Vec3d> before;         // the vertices before the part
    std::span<const Vec3d> before_stroke;  // and before the stroke
    const Flow& flow;
  };

  // The state that all parts of the stroke share.
  struct Halving {
    int left = 0;                // how often the flow may still be halved
    bool is_narrow = false;      // a mask's border is: halves are tried, too, where the whole is much work
    double spent = 0;            // evaluations on the points of all remeshes of the stroke
    double narrow_most = 0;      // the limit on `spent` if the border is narrow
    double narrow_done = 0;      // the fraction of the flow that has been remeshed then
    std::size_t faces = 0;       // of the whole and of the halves that have been begun
    std::size_t most_faces = 0;  // that all of them may have together; 0 before the whole
    Moment end = Moment::max();  // of the time for them
  };

  MeshFollower(DeformedShape& shape, const RemeshSettings& settings, Halving& halving, Progress* progress)
      : shape_(shape), settings_(settings), halving_(halving), progress_(progress) {}

  RemeshOutcome follow(const Part& part) {
    const std::shared_ptr<const Mesh> mesh = mesh_at(shape_.mesh_, part.before, shape_.normals());
    if (!shape_.provenance_ || !shape_.provenance_->creases) {
      const auto provenance =
          std::make_shared<Provenance>(shape_.provenance_ ? *shape_.provenance_ : unchanged(*shape_.mesh_));
      try {
        if (!part.flow.segments.empty()) {
          provenance->creases =
              detail::find_creases_unless_cancelled(*mesh, kDefaultCreaseDeg, shape_.motion_.threads, progress_);
        }
      } catch (const Cancelled&) {
        return {AdvectStatus::cancelled, std::nullopt};
      }
      shape_.provenance_ = provenance;
    }
    if (part.flow.segments.empty()) return {};
    return halving_.is_narrow ? remesh_narrow(*mesh, part) : remesh(*mesh, part);
  }

 private:
  // Moves points as the vertices were moved, without a count in progress->done: how many points a remesh carries is not
  // known beforehand. Returns the number of evaluations; more than `most` end it.
  std::uint64_t carry(detail::ReadyFlow& flow, std::span<Vec3d> points, std::uint64_t most) {
    const KeptCount kept(progress_, true);
    const Backend& backend = shape_.motion_.backend;
    const AdvectResult result =
        backend ? backend(flow.flow(), points, flow.options()) : detail::advect_within(flow, points, most);
    shape_.work_ += result;
    if (result.status == AdvectStatus::done) return result.evaluations;
    shape_.work_.status = AdvectStatus::done;
    if (result.status == AdvectStatus::step_limit && result.evaluations > most) throw TooMuchWork();
    throw Stopped{result.status};
  }

  // Returns the evaluations of the part's flow for a vertex, on average.
  double evaluations_each(const Part& part, detail::ReadyFlow& flow) {
    const std::size_t stride = part.before.size() / kCostSamples + 1;
    std::vector<Vec3d> sample;
    for (std::size_t i = 0; i < part.before.size(); i += stride) sample.push_back(part.before[i]);
    if (sample.empty()) return 0;
    return static_cast<double>(carry(flow, sample, kAnyNumber)) / static_cast<double>(sample.size());
  }

  AdvectOptions path_options() const {
    AdvectOptions options = advect_options(shape_.motion_, shape_.reference_length_);
    options.progress = progress_;
    return options;
  }

  RemeshOptions remesh_options(const std::vector<std::uint32_t>& labels) const {
    RemeshOptions options;
    options.targets = shape_.targets_of(settings_);
    options.single_precision = shape_.policy_->single_precision;
    options.assume_valid = true;  // the mesh was checked at the start, and path lines end at finite places
    options.face_labels = labels;
    options.creases = *shape_.provenance_->creases;
    options.threads = shape_.motion_.threads;
    options.progress = progress_;
    return options;
  }

  // Tries halves if the whole is too much work. Returns no mesh if they are too much, too, or if the rest of the flow
  // would be, in parts of this length.
  RemeshOutcome remesh_narrow(const Mesh& mesh, const Part& part) {
    const double before = halving_.spent;
    const double parts = std::ldexp(1.0, kMaxHalvingsOfNarrow - halving_.left);
    try {
      return remesh(mesh, part);
    } catch (const RemeshLimit&) {
      const double needed = (halving_.spent - before) * parts * (1 - halving_.narrow_done);
      if (halving_.left == 0 || halving_.spent + needed > halving_.narrow_most) return {};
    }
    if (halving_.most_faces == 0) halving_.most_faces = std::numeric_limits<std::size_t>::max();
    return remesh_in_halves(part);
  }

  // Sets the limit on the cost of following a part. Returns the limit for the stroke as a whole.
  double set_budget(const Part& part, detail::ReadyFlow& flow, double cost, std::size_t max_vertices,
                    CarryBudget& budget) {
    budget.least = std::max(1.0, kMinEach * static_cast<double>(part.flow.segments.size()));
    budget.of_the_stroke = cost * evaluations_each(part, flow);
    const double of_strokes = kMoreThanStroke * budget.of_the_stroke * static_cast<double>(part.before.size());
    const double all = std::max(kEvaluationsPerVertex * static_cast<double>(max_vertices), of_strokes);
    halving_.narrow_most = std::max(kWorkOfNarrow * all, of_strokes);
    budget.most = halving_.is_narrow
                      ? std::min(halving_.narrow_most, halving_.spent + std::max(kWorkOfPart * all, of_strokes))
                      : all;
    return all;
  }

  // The mesh is the one before the part.
  RemeshOutcome remesh(const Mesh& mesh, const Part& part) {
    const FlowSupport support(part.flow);
    const double cost = cost_of(part.flow);
    detail::ReadyFlow flow(part.flow, path_options());
    const std::vector<std::uint32_t> labels = labels_of(*shape_.provenance_, shape_.policy_->face_labels);
    RemeshOptions options = remesh_options(labels);
    const std::vector<std::uint8_t> held = held_vertices(shape_.mask_, mesh.positions);
    options.held = held;
    const std::shared_ptr<const Provenance> provenance = shape_.provenance_;
    detail::MorePlaces places{{provenance->rest, part.before_stroke}, {}};
    CarryBudget budget;
    Deformation deformation;
    deformation.points_left = [&] { return budget.points_left(halving_.spent); };
    deformation.carry = [&](std::span<Vec3d> points) {
      const double left = (kMoreThanBudget * budget.most - halving_.spent) / cost;
      const double spent = cost * static_cast<double>(carry(flow, points, whole_number(left)));
      budget.spent += spent;
      halving_.spent += spent;
      budget.points += static_cast<double>(points.size());
    };
    set_support(support, part.flow, deformation);
    const KeptCount kept(progress_);
    try {
      options.stop_where_crossed = true;
      options.stop_where_thousands_cross = halving_.is_narrow;
      options.seconds = seconds_until(halving_.end);
      const double all = set_budget(part, flow, cost, options.targets.max_vertices, budget);
      RemeshOutcome outcome{AdvectStatus::done,
                            detail::remesh_with(mesh, shape_.positions_, deformation, options, {}, places)};
      const bool is_whole = halving_.most_faces == 0;
      if (is_whole) halving_.most_faces = kMoreThanWhole * outcome.remeshed->counts.faces;
      halving_.faces += outcome.remeshed->counts.faces;
      if (halving_.is_narrow) halving_.spent += kWorkOfFace * static_cast<double>(outcome.remeshed->counts.faces);
      if (has_new_crossings(outcome.remeshed->counts)) {
        RemeshOutcome halves;
        const Moment end = halving_.end;
        if (is_whole) halving_.end = after(kTimeOfHalves * seconds_until(end));
        if (can_halve(outcome.remeshed->counts)) halves = remesh_in_halves(part);
        const bool is_in_vain = outcome.remeshed->counts.stopped && halving_.is_narrow;
        if (!is_whole || is_in_vain || halves.remeshed || halves.status == AdvectStatus::cancelled) return halves;
        halving_.spent = 0;
        halving_.left = 0;
        budget.most = all;
        options.stop_where_crossed = false;
        options.seconds = seconds_until(end);
        if (outcome.remeshed->counts.stopped) finish_stopped(mesh, deformation, options, *outcome.remeshed, places);
      }
      if (halving_.is_narrow) halving_.narrow_done += std::ldexp(1.0, halving_.left - kMaxHalvingsOfNarrow);
      adopt(*outcome.remeshed, places, part.before);
      return outcome;
    } catch (const Stopped& stopped) {
      return {stopped.status, std::nullopt};
    } catch (const TooMuchWork&) {
      throw RemeshLimit(
          fmt::format("some path lines of this stroke are so long that to follow it is more work than "
                      "\"max_vertices\" ({}) allows; deform less, or use a larger \"max_vertices\"",
                      options.targets.max_vertices));
    } catch (const Cancelled&) {
      return {AdvectStatus::cancelled, std::nullopt};
    }
  }

  bool can_halve(const RemeshCounts& counts) const {
    return halving_.left > 0 && halving_.faces < halving_.most_faces &&
           static_cast<double>(counts.crossings) <= kMaxPairsPerFace * static_cast<double>(counts.faces) &&
           seconds_until(halving_.end) > 0;
  }

  // Remeshes the whole completely, after a first remesh that stopped because many triangles crossed. If the time does
  // not suffice, keeps the result with fewer crossings.
  void finish_stopped(const Mesh& mesh, const Deformation& deformation, const RemeshOptions& options, Remeshed& stopped,
                      detail::MorePlaces& places) const {
    if (options.seconds > 0) {
      detail::MorePlaces others{places.before, {}};
      Remeshed whole = detail::remesh_with(mesh, shape_.positions_, deformation, options, {}, others);
      if (!whole.counts.out_of_time || whole.counts.crossings < stopped.counts.crossings) {
        stopped = std::move(whole);
        places = std::move(others);
        return;
      }
    }
    stopped.counts.out_of_time = true;
    stopped.counts.complete = false;
  }

  // Moves and remeshes the shape by the first half of the flow, then by the second. Does not change it if that fails.
  RemeshOutcome remesh_in_halves(const Part& part) {
    DeformedShape halves = shape_;
    --halving_.left;
    RemeshOutcome outcome;
    try {
      outcome = MeshFollower(halves, settings_, halving_, progress_).remesh_halves(part);
    } catch (const RemeshLimit&) {
      outcome = {};
    }
    ++halving_.left;
    if (outcome.remeshed) shape_ = std::move(halves);
    return outcome;
  }

  RemeshOutcome remesh_halves(const Part& part) {
    const auto [first, second] = halves_of(part.flow);
    if (shape_.has_normals() || shape_.splats()) {
      const AdvectStatus status = move_uncounted(inverse(part.flow));
      if (status != AdvectStatus::done) return {status, std::nullopt};
    }
    shape_.set_positions({part.before.begin(), part.before.end()});
    AdvectStatus status = move_uncounted(first);
    if (status != AdvectStatus::done) return {status, std::nullopt};
    RemeshOutcome half = follow({part.before, part.before_stroke, first});
    if (!half.remeshed) return half;
    const std::vector<Vec3d> middle = shape_.positions();
    const std::vector<Vec3d> places = shape_.provenance()->before_stroke;
    status = move_uncounted(second);
    if (status != AdvectStatus::done) return {status, std::nullopt};
    RemeshOutcome whole = follow({middle, places, second});
    if (whole.remeshed) join(*half.remeshed, *whole.remeshed);
    return whole;
  }

  // Gives the shape the remeshed mesh.
  void adopt(Remeshed& remeshed, detail::MorePlaces& places, std::span<const Vec3d> before) {
    std::vector<bool> touched_before = shape_.provenance_->touched;
    for (std::size_t i = 0; i < touched_before.size(); ++i) {
      if (before[i] != shape_.mesh_->positions[i]) touched_before[i] = true;
    }
    const std::vector<std::uint32_t> steps_before = shape_.steps();
    shape_.earlier_steps_.assign(remeshed.vertex_source.size(), 0);
    for (std::size_t i = 0; i < shape_.earlier_steps_.size(); ++i) {
      const std::uint32_t source = remeshed.vertex_source[i];
      if (source != kNewVertex) shape_.earlier_steps_[i] = steps_before[source];
    }
    Provenance provenance = after_remesh(*shape_.provenance_, remeshed, touched_before, before);
    provenance.rest = std::move(places.after[0]);
    provenance.before_stroke = std::move(places.after[1]);
    shape_.provenance_ = std::make_shared<const Provenance>(std::move(provenance));
    std::vector<Vec3d> normals;
    if (shape_.has_normals()) normals = take_normals(remeshed.mesh);
    shape_.mesh_ = std::make_shared<const Mesh>(std::move(remeshed.mesh));
    shape_.positions_ = shape_.mesh_->positions;
    shape_.blocks_.reset();
    shape_.triangles_.reset();
    shape_.start_normals(std::move(normals));
  }

  // Moves the shape without a count of the work, to which halves of a stroke add nothing.
  AdvectStatus move_uncounted(const Flow& flow) {
    const KeptCount kept(progress_, true);
    return shape_.move(flow, progress_);
  }

  DeformedShape& shape_;
  const RemeshSettings& settings_;
  Halving& halving_;
  Progress* progress_;
};

}  // namespace detail

RemeshOutcome DeformedShape::remesh(std::span<const Vec3d> before, const Flow& flow, const RemeshSettings& settings,
                                    Progress* progress) {
  const double width = mask_.is_empty() ? 0 : sufficient_width(flow, before, positions_);
  const bool is_narrow = width > mask_.width();
  detail::MeshFollower::Halving halving{is_narrow ? kMaxHalvingsOfNarrow : kMaxHalvings, is_narrow};
  halving.end = after(policy_->seconds);
  RemeshOutcome outcome = detail::MeshFollower(*this, settings, halving, progress).follow({before, before, flow});
  if (is_narrow && outcome.status == AdvectStatus::done && !outcome.remeshed) {
    throw RemeshLimit(
        fmt::format("the mesh cannot follow this stroke along the mask's border, which is narrow for so far a motion; "
                    "make the mask's \"width\" {:.2g} or more, or deform less",
                    kRoundedUp * width));
  }
  return outcome;
}

}  // namespace knead
