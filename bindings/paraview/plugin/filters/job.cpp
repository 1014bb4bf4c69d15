// Runs a session on all blocks and ranks, and adds the arrays that were asked for.
#include "job.h"

#include <vtkPointSet.h>
#include <vtkTimerLog.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <optional>

#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"

namespace knead::paraview {
namespace {

constexpr const char* kVolumeRatio = "KneadVolumeRatio";
constexpr const char* kScaledJacobian = "KneadScaledJacobian";
constexpr const char* kNonOrthogonality = "KneadNonOrthogonality";
constexpr const char* kSkewness = "KneadSkewness";
constexpr const char* kStretch = "KneadStretch";

// Returns a number in the fewest digits that give it back. Not by fmt, of which ParaView 6 brings a copy of its own.
std::string text(auto number) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}

std::string cells_are(std::int64_t count) { return count == 1 ? "1 cell is" : text(count) + " cells are"; }

std::vector<double> greatest_stretches(std::span<const Mat3d> jacobians) {
  constexpr std::size_t points_at_a_time = 1024;
  std::vector<double> stretches(jacobians.size());
  parallel_for(stretches.size(), points_at_a_time, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) stretches[i] = stretches_of(jacobians[i]).greatest;
  });
  return stretches;
}

class Job {
 public:
  Job(std::vector<Block>& blocks, const Settings& settings, const Ranks& ranks, const Watch& watch)
      : blocks_(blocks), settings_(settings), ranks_(ranks), watch_(watch) {}

  Findings run() {
    ranks_.together([&] { prepare(); });
    read_cells();
    find_length();
    ranks_.together([&] { move_points(); });
    judge_cells();
    ranks_.together([&] { derive_arrays(); });
    require_vectors();
    store_all_points();
    return std::move(findings_);
  }

 private:
  void prepare() {
    session_ = read_flow_session(settings_.session_file);
    findings_.notes = session_.warnings;
    const auto strokes = static_cast<double>(session_.strokes.size());
    if (!(settings_.until >= 0)) {
      throw InvalidInput("Until must be a number of strokes, 0 or more, got " + text(settings_.until));
    }
    until_ = std::min(settings_.until, strokes);
    flow_ = flow_until(until_);
    if (settings_.diagonal < 0) {
      throw InvalidInput("Diagonal must be a length, or 0, got " + text(settings_.diagonal));
    }
  }

  Flow flow_until(double until) const {
    return flow_of(session_, {settings_.inverse ? Direction::backwards : Direction::forwards, until});
  }

  // Collective: thin cells need double precision, on all ranks where one has some.
  void read_cells() {
    const vtkTimerLogScope timed("Knead: cells");
    std::int64_t volumes = 0;
    std::int64_t unresolved = 0;
    ranks_.together([&] {
      for (const Block& block : blocks_) {
        cells_.push_back(volume_cells(*block.set));
        if (!cells_.back().empty()) ++volumes;
        if (!stores_floats(block)) continue;
        unresolved += static_cast<std::int64_t>(unresolved_cells(cells_.back(), block.before));
      }
    });
    precision_ = settings_.precision.value_or(ranks_.sum(volumes) > 0 ? Precision::float64 : Precision::float32);
    unresolved = ranks_.sum(unresolved);
    if (unresolved == 0) return;
    findings_.notes.push_back(cells_are(unresolved) +
                              " so thin that the float coordinates of the data set hardly resolve " +
                              (unresolved == 1 ? "it" : "them") +
                              " (an edge below 0.0012 of its coordinates); read it with doubles (OpenFOAM reader: "
                              "Use 64-bit Floats)");
  }

  // Collective: the box is that of all ranks.
  void find_length() {
    const vtkTimerLogScope timed("Knead: box");
    Box box;
    for (const Block& block : blocks_) {
      for (const Vec3d& p : block.before) box.extend(p);
    }
    box = ranks_.united(box);
    ranks_.together([&] {
      MotionOptions motion;
      motion.relative_tolerance = settings_.relative_tolerance;
      motion.precision = precision_;
      const std::vector<Vec3d> corners = box.empty() ? std::vector<Vec3d>(1) : std::vector<Vec3d>{box.min, box.max};
      options_ = advect_options(motion, settings_.diagonal > 0 ? settings_.diagonal : reference_length(corners));
    });
  }

  bool needs_jacobians(const Block& block) const {
    return settings_.quality || !settings_.vectors.empty() || has_point_normals(block);
  }

  void move_points() {
    const vtkTimerLogScope timed("Knead: kernel");
    Progress progress;
    std::uint64_t points = 0;
    for (const Block& block : blocks_) points += block.before.size() * (needs_jacobians(block) ? 2 : 1);
    progress.total = points * flow_.segments.size();
    watch_(progress, [&] {
      for (Block& block : blocks_) {
        block.after = moved(block, flow_, progress);
        if (needs_jacobians(block)) jacobians_.push_back(jacobians_of(block, progress));
        if (!needs_jacobians(block)) jacobians_.emplace_back();
      }
    });
  }

  std::vector<Vec3d> moved(const Block& block, const Flow& flow, Progress& progress) const {
    std::vector<Vec3d> points = block.before;
    move(points, flow, progress);
    round_points(block, points);
    return points;
  }

  void move(std::vector<Vec3d>& points, const Flow& flow, Progress& progress) const {
    AdvectOptions options = options_;
    options.progress = &progress;
    if (!points.empty() && advect(flow, points, options).status == AdvectStatus::step_limit) {
      throw InvalidInput(settings_.session_file + ": " + kStepLimitAdvice);
    }
    stop_if_cancelled(&progress);
  }

  std::vector<Mat3d> jacobians_of(const Block& block, Progress& progress) const {
    AdvectOptions options = options_;
    options.progress = &progress;
    return block.before.empty() ? std::vector<Mat3d>() : jacobians(flow_, block.before, options);
  }

  // Collective.
  void judge_cells() {
    ranks_.together([&] {
      const vtkTimerLogScope timed("Knead: cells");
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        damages_.push_back(damage_of(cells_[i], blocks_[i].before, blocks_[i].after,
                                     settings_.quality ? CellValues::all : CellValues::inversions));
      }
    });
    std::int64_t own = 0;
    for (const Damage& damage : damages_) own += damage.inverted;
    findings_.inverted = ranks_.sum(own);
    if (findings_.inverted == 0) return;
    const std::string what = cells_are(findings_.inverted) + " inverted, " + ranks_.first(first_inverted());
    if (!settings_.fail_on_inversion) {
      findings_.notes.push_back(what);
      return;
    }
    const SafeUntil safe = safe_until(until_, [&](double until) { return inverts_nothing(until); });
    throw Failure(settings_.session_file + ": " + what + "; no cell is inverted up to Until = " + text(safe.until) +
                  ". Use that, finer cells, or strokes with a wider transition" + wider_transition(safe) +
                  "; or move the mesh with knead.deform_mesh(least_scaled_jacobian=0.05) in Python, which repairs "
                  "cells; or switch FailOnInversion off");
  }

  // Collective.
  std::string wider_transition(const SafeUntil& safe) const {
    std::vector<double> faces;
    ranks_.together([&] {
      for (std::size_t i = 0; i < blocks_.size(); ++i) add_boundary_faces(cells_[i], blocks_[i].before, faces);
    });
    faces = ranks_.gathered(std::move(faces));
    std::optional<double> outer;
    const std::size_t number = strokes_before(safe);
    ranks_.together([&] {
      const Flow flow = flow_until(settings_.inverse ? 0 : static_cast<double>(number));
      std::vector<Vec3d> boundary = corners_of_single_faces(faces);
      Progress progress;
      watch_(progress, [&] {
        move(boundary, flow, progress);
        outer = widest_outer(session_.strokes[number].stroke, boundary);
      });
    });
    if (!outer) return {};
    return " (line " + text(session_.strokes[number].line) + ": an \"outer\" of " + text(*outer) +
           " fits into this mesh)";
  }

  std::string first_inverted() const {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (damages_[i].inverted == 0) continue;
      const std::string block = blocks_[i].name.empty() ? "" : " of block \"" + blocks_[i].name + "\"";
      const std::string rank = ranks_.count() > 1 ? " on rank " + text(ranks_.rank()) : "";
      return "the first is cell " + text(damages_[i].first) + block + rank;
    }
    return {};
  }

  // Collective.
  bool inverts_nothing(double until) const {
    std::int64_t inverted = 0;
    ranks_.together([&] {
      const Flow flow = flow_until(until);
      Progress progress;
      watch_(progress, [&] {
        for (std::size_t i = 0; i < blocks_.size(); ++i) {
          const std::vector<Vec3d> points = moved(blocks_[i], flow, progress);
          inverted += damage_of(cells_[i], blocks_[i].before, points, CellValues::inversions).inverted;
        }
      });
    });
    return ranks_.sum(inverted) == 0;
  }

  void derive_arrays() {
    const vtkTimerLogScope timed("Knead: arrays");
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      Block& block = blocks_[i];
      found_vectors_ += carry_vectors(block, settings_.vectors, jacobians_[i]);
      carry_normals(block, jacobians_[i]);
      if (!settings_.quality) continue;
      add_point_array(block, kStretch, greatest_stretches(jacobians_[i]));
      add_cell_array(block, kVolumeRatio, damages_[i].volume_ratio);
      add_cell_array(block, kScaledJacobian, damages_[i].scaled_jacobian);
      add_cell_array(block, kNonOrthogonality, damages_[i].non_orthogonality_deg);
      add_cell_array(block, kSkewness, damages_[i].skewness);
    }
  }

  // Collective. A part without points need not have the arrays.
  void require_vectors() {
    std::int64_t points = 0;
    for (const Block& block : blocks_) points += static_cast<std::int64_t>(block.before.size());
    const bool is_missing = ranks_.sum(static_cast<std::int64_t>(found_vectors_)) == 0 && !settings_.vectors.empty();
    if (ranks_.sum(points) == 0 || !is_missing) return;
    throw Failure("VectorsToTransform: there is no array \"" + settings_.vectors.front() +
                  "\" with three components at the points");
  }

  void store_all_points() {
    const vtkTimerLogScope timed("Knead: copy");
    for (Block& block : blocks_) store_points(block);
  }

  std::vector<Block>& blocks_;
  const Settings& settings_;
  const Ranks& ranks_;
  const Watch& watch_;
  Session session_;
  double until_ = 0;
  Precision precision_ = Precision::float64;
  Flow flow_;
  AdvectOptions options_;
  std::vector<std::vector<Mat3d>> jacobians_;  // of the points of each block; empty where they are not needed
  std::vector<VolumeCells> cells_;
  std::vector<Damage> damages_;
  std::size_t found_vectors_ = 0;
  Findings findings_;
};

std::string resolved_name(const std::string& path) {
  std::filesystem::path name(path);
  return name.replace_extension(".resolved.knead").string();
}

}  // namespace

Session read_flow_session(const std::string& path) {
  if (path.empty()) throw InvalidInput("SessionFile is empty; name a file of strokes (.knead)");
  Session session = without_off(read_session(path));
  for (const SessionStroke& stroke : session.strokes) {
    if (!is_applied(stroke)) continue;
    if (!is_flow(stroke.stroke)) {
      throw InvalidInput({path, stroke.line}, "a relax is no flow, so it cannot be applied here; remove this line");
    }
    if (!reads_surface(stroke.stroke)) continue;
    throw InvalidInput({path, stroke.line},
                       "this stroke reads the surface, of which a rank has only a part; resolve the session first: "
                       "knead resolve " +
                           session.mesh.value_or("SHAPE") + " " + path + " -o " + resolved_name(path));
  }
  const bool remeshes =
      std::ranges::any_of(session.strokes, [](const SessionStroke& s) { return s.remesh.has_value(); });
  if (remeshes) session.warnings.push_back(path + ": the remesh events are ignored; points and cells stay as they are");
  return session;
}

Findings knead_blocks(std::vector<Block>& blocks, const Settings& settings, const Ranks& ranks, const Watch& watch) {
  return Job(blocks, settings, ranks, watch).run();
}

}  // namespace knead::paraview
