// Applies a session to a shape.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "session/deformed_shape_detail.h"
#include "session/point_constraint.h"
#include "session/replay_detail.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

// Below it single precision does not resolve a relative tolerance.
constexpr double kFloatNoise = 1e-6;

constexpr std::size_t kManyVertices = 20'000;

// The greatest twist over one edge without a warning: a square prism of one ring of triangles loses up to 21% of its
// volume when it is twisted by 30 degrees, 46% by 60.
constexpr double kMaxTurnOfAnEdgeDeg = 30;

constexpr std::size_t kMaxPairsOfOldCurves = 2;  // times the pairs before may cross along a curve that crossed before

void require_flow(const SessionStroke& stroke) {
  if (!is_applied(stroke)) return;
  if (!is_flow(stroke.stroke)) {
    throw InvalidInput("a relax reads the faces, and is no flow; give the faces too, or remove this line");
  }
  if (reads_surface(stroke.stroke)) {
    throw InvalidInput(
        "this stroke reads the surface; give the faces too, or resolve the session on the shape first and use that "
        "session");
  }
}

std::optional<std::string> precision_warning(const MotionOptions& motion) {
  if (motion.precision == Precision::float64 || motion.relative_tolerance >= kFloatNoise) return std::nullopt;
  return fmt::format("a tolerance of {} is below what single precision resolves ({}); use double precision",
                     motion.relative_tolerance, kFloatNoise);
}

std::optional<std::string> ignored_remesh(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  if (!detail::has_settings(session, options)) return std::nullopt;
  if (is_backwards(options)) {
    return "a session that is applied backwards does not remesh: the shape keeps its vertices and faces";
  }
  if (mesh.face_count() > 0) return std::nullopt;
  return "a point cloud has no faces to remesh; only its points move";
}

void add_warnings(const Session& session, const SessionStroke& source, std::vector<std::string>& all) {
  if (!is_applied(source)) return;
  const Stroke stroke = source.strength > 1 ? prolonged(source.stroke, source.strength) : source.stroke;
  for (const std::string& warning : warnings(stroke)) {
    all.push_back(to_string(Place{session.name, source.line}) + ": " + warning);
  }
}

// Returns the shape whose surface strokes read.
DeformedShape reference_shape(const std::shared_ptr<const Mesh>& mesh, const ReplayOptions& options) {
  MotionOptions motion;
  motion.threads = options.motion.threads;
  RemeshPolicy remesh = options.remesh;
  remesh.single_precision = true;
  return DeformedShape(mesh, std::move(motion), std::move(remesh), options.normals);
}

// Returns whether a stroke paints on splats that have no normals of their own.
bool paints_splats(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  const auto paints = [](const SessionStroke& stroke) {
    return is_applied(stroke) && std::holds_alternative<PaintStroke>(stroke.stroke) && reads_surface(stroke.stroke);
  };
  return options.normals.empty() && are_splats(mesh) &&
         std::any_of(session.strokes.begin(), session.strokes.end(), paints);
}

// Carries out a plan.
class PlanRun {
 public:
  PlanRun(const std::shared_ptr<const Mesh>& mesh, const Session& session, const ReplayOptions& options, Plan plan)
      : mesh_(mesh),
        session_(session),
        options_(options),
        plan_(std::move(plan)),
        shape_(mesh, options.motion, options.remesh, options.normals),
        image_(mesh) {
    if (const std::vector<IndexRange> splats = detail::splats_of(*mesh, options); !splats.empty()) {
      shape_.carry_splats(splats);
    }
    if (plan_.strokes_on_reference > 0) reference_ = reference_shape(mesh, options);
    if (session.constraint) constrain(*mesh);
    for (const PlannedStroke& planned : plan_.strokes) {
      const SessionStroke& source = *planned.stroke.source;
      const std::optional<RemeshSettings> settings = shape_.settings_of(source);
      if (settings && !is_backwards(options)) at_line(session, source, [&] { shape_.targets_of(*settings); });
    }
    if (std::optional<std::string> warning = precision_warning(options.motion)) {
      result_.warnings.push_back(std::move(*warning));
    }
  }

  ReplayResult run() {
    for (PlannedStroke& planned : plan_.strokes) {
      const SessionStroke& source = *planned.stroke.source;
      apply(planned);
      if (result_.status == AdvectStatus::step_limit) result_.failed_line = source.line;
      if (result_.status != AdvectStatus::done) return std::move(result_);
    }
    compare_with_image();
    for (std::size_t i = 0; i < plan_.last_frames; ++i) deliver(shape_, plain_, done_);
    if (options_.frames.count == 0) {
      keep_quality(plain_, shape_);
      keep_cells(done_, shape_);
    }
    if (session_.constraint) result_.cells = session_.constraint->cells();
    result_.strokes = plan_.strokes.size();
    shape_.free_layout();
    result_.shape = std::move(shape_);
    return std::move(result_);
  }

 private:
  void constrain(const Mesh& mesh) {
    if (session_.walls.empty()) return;  // the constraint consists of cells only
    const Place place{session_.name, 1};
    if (mesh.face_count() > 0) throw InvalidInput(place, "walls need a mesh without faces");
    if (mesh.vertex_count() < session_.constraint->points()) {
      throw InvalidInput(place, "the points are not those of the mesh that has the walls");
    }
    shape_.constrain(session_.constraint);
    if (reference_) reference_->constrain(session_.constraint);
    if (const auto others = session_.constraint->without_layers()) {
      plain_ = shape_;
      plain_->constrain(others);
    }
  }

  // Reduces the layers that would make cells worse. `plain`: the shape without layers; nothing if no wall keeps them.
  void keep_quality(const std::optional<DeformedShape>& plain, DeformedShape& shape) const {
    if (!plain || result_.status != AdvectStatus::done) return;
    shape.set_positions(session_.constraint->no_worse(mesh_->positions, shape.positions(), plain->positions(),
                                                      options_.motion.threads));
  }

  // Returns the positions to which the flow has moved the shape.
  void keep_cells(const Flow& flow, DeformedShape& shape) {
    const bool has_cells = session_.constraint && session_.constraint->points() <= mesh_->vertex_count();
    if (!has_cells || shape.is_remeshed() || result_.status != AdvectStatus::done) return;
    AdvectOptions motion = advect_options(options_.motion, shape.reference_length());
    motion.precision = Precision::float64;
    const auto carry = [&](double from, double to, std::span<Vec3d> points) {
      const auto length = static_cast<double>(flow.segments.size());
      advect(flow_between(flow, from * length, to * length), points, motion);
    };
    std::optional<KeptCells> kept;
    try {
      kept = session_.constraint->keep_cells(mesh_->positions, shape.positions(), carry, session_.name,
                                             options_.motion.threads, options_.progress);
    } catch (const Cancelled&) {
      result_.status = AdvectStatus::cancelled;
    }
    if (!kept) return;
    shape.set_positions(std::move(kept->points));
    if (!std::exchange(has_freed_, true)) {
      warn(0,
           fmt::format("{} of the mesh's points, all inside, leave the flow so that no cell is inverted", kept->freed));
    }
  }

  void warn(std::size_t line, const std::string& text) {
    result_.warnings.push_back(to_string(Place{session_.name, line}) + ": " + text);
  }

  void apply(PlannedStroke& planned) {
    const std::size_t work = planned.work();
    const std::size_t expected = planned.stroke.expected_segments;
    const SessionStroke& source = *planned.stroke.source;
    if (planned.stroke.relax != nullptr) compare_with_image();
    if (reference_) at_line(session_, source, [&] { apply_to_reference(planned.stroke); });
    StrokeRun run(std::move(planned.stroke), planned.run, shape_, options_.progress);
    const DeformedShape before = options_.on_stroke ? shape_ : DeformedShape();
    if (result_.status == AdvectStatus::done) at_line(session_, source, [&] { run.begin(); });
    std::optional<StrokeRun> plain;
    if (plain_ && result_.status == AdvectStatus::done)
      plain.emplace(run.stroke(), planned.run, *plain_, options_.progress);
    if (result_.status == AdvectStatus::done && !is_backwards(options_)) warn_of_zones(run);
    count(run, expected);
    for (const double moment : planned.frames) {
      if (result_.status != AdvectStatus::done) return;
      const DeformedShape& frame = run.frame(moment);
      if (run.status() == AdvectStatus::done) {
        at_line(session_, source, [&] { refuse_crossings(source, frame); });
        deliver(frame, plain ? std::optional(plain->frame(moment)) : std::nullopt, flow_until(run, moment));
      }
      count(run, 1);
    }
    if (result_.status != AdvectStatus::done) return;
    at_line(session_, source, [&] {
      run.finish();
      if (plain) plain->finish();
      if (run.status() == AdvectStatus::done) refuse_crossings(source, shape_);
    });
    count(run, work);
    done_ = flow_until(run, 1);
    if (run.status() == AdvectStatus::done) report(run, before);
    take(run);
  }

  // Warns of zones that are too thin, before the shape moves. Edges are measured only if vertices are few.
  void warn_of_zones(const StrokeRun& run) {
    for (const SessionStroke& part : run.stroke().outcome.parts) {
      if (!detail::has_zone(part.stroke)) continue;
      const bool is_coarse = shape_.positions().size() < kManyVertices;
      const std::span<const Triangle> triangles = is_coarse ? shape_.triangles() : std::span<const Triangle>{};
      const ZoneProfile profile = zone_profile(part.stroke, shape_.positions(), triangles);
      const std::optional<std::string> warning = zone_warning(part.stroke, profile);
      if (warning) {
        warn(part.line, *warning);
      } else if (is_coarse && !shape_.settings_of(*run.stroke().source)) {
        warn_of_long_edges(part, triangles);
      }
    }
  }

  void warn_of_long_edges(const SessionStroke& part, std::span<const Triangle> triangles) {
    const double turn = most_turn_of_an_edge_deg(part.stroke, shape_.positions(), triangles);
    if (!(turn > kMaxTurnOfAnEdgeDeg)) return;
    warn(
        part.line,
        fmt::format("an edge reaches over {:.0f} degrees of this motion, which triangles so long cannot follow; remesh "
                    "the shape (knead deform --remesh, or a remesh line before this one), or use a finer one",
                    turn));
  }

  // Refuses a stroke whose remesh has left triangles that cross and did not before. Along a curve in which the shape
  // crossed before, there are other triangles now, and they may have more pairs.
  void refuse_crossings(const SessionStroke& stroke, const DeformedShape& shape) const {
    if (options_.may_cross || !shape.is_remeshed() || !shape.settings_of(stroke)) return;
    const RemeshCounts& counts = shape.provenance()->counts;
    if (counts.crossings <= counts.crossings_before || counts.out_of_time) return;
    if (counts.curves <= counts.curves_before && counts.crossings <= kMaxPairsOfOldCurves * counts.crossings_before)
      return;
    const std::size_t more = counts.crossings - counts.crossings_before;
    throw RemeshLimit(fmt::format(
        "{} after this stroke, which remeshing cannot end; deform less, {}or use a finer mesh",
        more == 1 ? "1 more pair of triangles crosses" : fmt::format("{} more pairs of triangles cross", more),
        shape.mask().is_empty() ? "" : "make the mask's \"width\" larger, "));
  }

  // Lets a stroke read the reference surface. After the last of these, that surface is released.
  void apply_to_reference(PreparedStroke& stroke) {
    StrokeRun run(stroke, {}, *reference_, options_.progress);
    run.read();
    if (stroke.reads_surface) stroke = run.stroke();
    if (++strokes_read_ < plan_.strokes_on_reference) run.finish();
    result_.status = run.status();
    if (strokes_read_ == plan_.strokes_on_reference) reference_.reset();
  }

  void report(const StrokeRun& run, const DeformedShape& before) const {
    if (!options_.on_stroke) return;
    const Flow flow = run.flow();
    options_.on_stroke({run.stroke().source->line, flow, before, shape_, run.remeshed() ? &*run.remeshed() : nullptr,
                        run.stroke().relax});
  }

  // Compares the shape with its exact image under the strokes since the last comparison.
  void compare_with_image() {
    std::optional<std::string> error;
    try {
      error = image_.compare(shape_, options_);
    } catch (const QualityLimit& limit) {
      throw QualityLimit(Place{session_.name}, limit.what());
    }
    if (error) warn(0, *error);
  }

  void take(StrokeRun& run) {
    const SessionStroke& source = *run.stroke().source;
    if (!is_backwards(options_)) image_.add(run, shape_);
    result_.segments += run.segments();
    if (options_.strokes_warn) add_warnings(session_, source, result_.warnings);
    StrokeOutcome outcome = run.take_outcome();
    for (const std::string& warning : outcome.warnings) warn(source.line, warning);
    if (!outcome.shortfall.empty()) {
      result_.shortfalls.push_back(to_string(Place{session_.name, source.line}) + ": " + outcome.shortfall);
    }
    if (outcome.penetration) result_.penetration = std::max(*outcome.penetration, result_.penetration.value_or(0));
    const auto where = is_backwards(options_) ? result_.resolved.begin() : result_.resolved.end();
    result_.resolved.insert(where, std::make_move_iterator(outcome.parts.begin()),
                            std::make_move_iterator(outcome.parts.end()));
  }

  // Returns the flow that has moved the mesh until a moment of the stroke; nothing without cells.
  Flow flow_until(const StrokeRun& run, double moment) const {
    if (!session_.constraint) return {};
    Flow all = done_;
    Flow last = run.flow(moment);
    std::move(last.segments.begin(), last.segments.end(), std::back_inserter(all.segments));
    return all;
  }

  void deliver(const DeformedShape& shape, const std::optional<DeformedShape>& plain, const Flow& flow) {
    std::optional<DeformedShape> kept;
    if (session_.constraint) {
      keep_quality(plain, kept.emplace(shape));
      keep_cells(flow, *kept);
    }
    if (result_.status == AdvectStatus::done && options_.frames.deliver) {
      options_.frames.deliver({frame_++, kept ? *kept : shape});
    }
  }

  void count(const StrokeRun& run, std::size_t segments) {
    if (result_.status == AdvectStatus::done) result_.status = run.status();
    work_ += segments;
    if (options_.progress == nullptr) return;
    if (options_.progress->cancel) result_.status = AdvectStatus::cancelled;
    if (result_.status == AdvectStatus::done) options_.progress->done = work_ * plan_.points;
  }

  std::shared_ptr<const Mesh> mesh_;
  const Session& session_;
  const ReplayOptions& options_;
  Plan plan_;
  DeformedShape shape_;
  std::optional<DeformedShape> reference_;  // at the standard accuracy, if strokes read that surface
  std::size_t strokes_read_ = 0;            // by the reference
  detail::ExactImage image_;
  std::uint64_t work_ = 0;              // segments done
  std::optional<DeformedShape> plain_;  // the shape without layers kept, if a wall keeps them
  int frame_ = 0;
  Flow done_;               // the flow that has moved the mesh so far, if it has cells
  bool has_freed_ = false;  // points of the mesh from the flow
  ReplayResult result_;
};

// Refuses sessions whose vertices cannot be taken back: those with strokes that are no flow. `until` needs the applied
// strokes to be those of the session, one for one.
void require_inverse(const Session& session, const ReplayOptions& options) {
  for (const SessionStroke& stroke : session.strokes) {
    if (!is_applied(stroke) || is_flow(stroke.stroke)) continue;
    throw InvalidInput(Place{session.name, stroke.line},
                       "a relax is no flow, so the frames before it cannot have the faces of the result; remove this "
                       "line, or write a file for each frame");
  }
  const bool is_one_for_one = std::all_of(
      session.strokes.begin(), session.strokes.end(),
      [](const SessionStroke& stroke) { return stroke.off || (is_applied(stroke) && !reads_surface(stroke.stroke)); });
  if (options.part.until && !is_one_for_one) {
    throw InvalidInput(Place{session.name},
                       "where frames have the faces of the result, \"until\" cannot cut a session with strokes of "
                       "strength 0 or that read the surface; resolve the session first (knead resolve)");
  }
}

ReplayResult run_forthwith(const std::shared_ptr<const Mesh>& mesh, const Session& session,
                           const ReplayOptions& options) {
  return PlanRun(mesh, session, options, detail::make_plan(*mesh, session, options)).run();
}

Plan without_frames(Plan plan) {
  plan.last_frames = 0;
  for (PlannedStroke& stroke : plan.strokes) {
    stroke.frames.clear();
    stroke.run.has_frames = false;
  }
  return plan;
}

// Replays once for the result, takes its vertices back to the start, and follows them from there.
ReplayResult run_with_same_faces(const std::shared_ptr<const Mesh>& mesh, const Session& session,
                                 const ReplayOptions& options, Plan plan) {
  ReplayOptions once = options;
  once.frames = {};
  ReplayResult result = PlanRun(mesh, session, once, without_frames(std::move(plan))).run();
  if (result.status != AdvectStatus::done) return result;
  Session flows;
  flows.name = session.name;
  flows.strokes = result.resolved;
  for (SessionStroke& stroke : flows.strokes) stroke.remesh.reset();
  ReplayOptions plain = options;
  plain.remesh = {};
  plain.normals = {};
  plain.splats = {};
  plain.on_stroke = {};
  plain.frames = {};
  plain.part.direction = Direction::backwards;
  plain.motion.diagonal = options.motion.diagonal.value_or(reference_length(*mesh));
  const auto last = std::make_shared<const Mesh>(result.shape.to_mesh());
  const ReplayResult back = run_forthwith(last, flows, plain);
  result.status = back.status;
  result.failed_line = back.failed_line;
  if (back.status != AdvectStatus::done) return result;
  Mesh first = *last;
  first.positions = back.shape.positions();
  plain.part.direction = Direction::forwards;
  plain.frames = options.frames;
  const int end = frame_count(options.frames) - 1 - options.frames.hold;
  const std::shared_ptr<const Provenance> provenance = result.shape.state().provenance;
  plain.frames.deliver = [&](const ReplayFrame& frame) {
    if (frame.index >= end) return options.frames.deliver({frame.index, result.shape});
    DeformedShape shape = frame.shape;
    ShapeState state = shape.state();
    state.provenance = provenance;  // its faces are those of the result
    shape.restore(state);
    options.frames.deliver({frame.index, shape});
  };
  result.status = run_forthwith(std::make_shared<const Mesh>(std::move(first)), flows, plain).status;
  return result;
}

}  // namespace

Replay::Replay(std::shared_ptr<const Mesh> mesh, const Session& session, const ReplayOptions& options)
    : mesh_(std::move(mesh)), session_(session), options_(options) {}

Replay::~Replay() = default;

bool Replay::remeshes() const { return detail::remeshes(*mesh_, session_, options_); }

std::vector<std::string> Replay::warnings() const {
  std::vector<std::string> result;
  for (const SessionStroke* stroke : detail::strokes_in(session_, options_.part)) {
    add_warnings(session_, *stroke, result);
  }
  return result;
}

Plan& Replay::plan() {
  if (!plan_) plan_ = std::make_unique<Plan>(detail::make_plan(*mesh_, session_, options_));
  return *plan_;
}

std::uint64_t Replay::work() { return plan().work(); }

ReplayResult Replay::run() {
  if (options_.remesh.settings) validate(*options_.remesh.settings);
  if (!(options_.remesh.seconds > 0)) throw InvalidInput("the seconds of a remesh must be above 0");
  simd_name();  // refuses a wrong KNEAD_SIMD here, without naming a stroke
  const bool keeps_faces = options_.frames.same_faces && options_.frames.count > 0 && remeshes();
  if (keeps_faces) require_inverse(session_, options_);
  if (options_.progress != nullptr) options_.progress->total = work();
  Plan plan = std::move(this->plan());
  plan_.reset();
  std::optional<ReplayOptions> with_normals;
  if (paints_splats(*mesh_, session_, options_)) {
    with_normals = options_;
    with_normals->normals = splat_normals(*mesh_);
  }
  const ReplayOptions& options = with_normals ? *with_normals : options_;
  ReplayResult result = keeps_faces ? run_with_same_faces(mesh_, session_, options, std::move(plan))
                                    : PlanRun(mesh_, session_, options, std::move(plan)).run();
  const std::optional<std::string> ignored = ignored_remesh(*mesh_, session_, options_);
  if (ignored) result.warnings.push_back(*ignored);
  return result;
}

ReplayResult replay(const std::shared_ptr<const Mesh>& mesh, const Session& session, const ReplayOptions& options) {
  return Replay(mesh, session, options).run();
}

ReplayResult replay(Mesh mesh, const Session& session, const ReplayOptions& options) {
  return Replay(std::make_shared<const Mesh>(std::move(mesh)), session, options).run();
}

int frame_count(const FrameOptions& frames) { return frames.count == 0 ? 0 : frames.count + 2 * frames.hold; }

bool needs_faces(const Session& session) {
  return std::any_of(session.strokes.begin(), session.strokes.end(), [](const SessionStroke& stroke) {
    if (!is_applied(stroke)) return false;
    return !is_flow(stroke.stroke) || reads_surface(stroke.stroke) || stroke.remesh ||
           limit_cylinder_of(stroke.stroke) || std::holds_alternative<LatticeStroke>(stroke.stroke);
  });
}

Flow flow_of(const Session& session, const SessionPart& part, int threads) {
  detail::require_flow_alone(session);
  for (const SessionStroke& stroke : session.strokes) at_line(session, stroke, [&] { require_flow(stroke); });
  ReplayOptions options;
  options.part = part;
  options.motion.threads = threads;
  Plan plan = detail::make_plan({}, session, options);
  Flow flow;
  Mask mask;  // forwards; backwards the plan has it
  for (PlannedStroke& planned : plan.strokes) {
    PreparedStroke& stroke = planned.stroke;
    const double end = planned.run.part * stroke.part * static_cast<double>(stroke.flow.segments.size());
    const bool backwards = planned.run.backwards;
    Flow own = backwards ? flow_between(stroke.flow, end, 0) : prefix(stroke.flow, end);
    own = masked(std::move(own), backwards ? stroke.mask : mask);
    std::move(own.segments.begin(), own.segments.end(), std::back_inserter(flow.segments));
    const auto* masks = std::get_if<MaskStroke>(&stroke.source->stroke);
    if (!backwards && masks != nullptr && is_applied(*stroke.source)) mask = mask_of(*masks, threads);
  }
  return flow;
}

}  // namespace knead
