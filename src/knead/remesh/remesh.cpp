#include "knead/remesh/remesh.h"

#include <algorithm>
#include <utility>

#include "knead/math/error.h"
#include "knead/remesh/carried_normals.h"
#include "knead/remesh/compensate.h"
#include "knead/remesh/crossings.h"
#include "knead/remesh/patch.h"
#include "knead/remesh/refine.h"
#include "knead/remesh/remesh_with.h"
#include "knead/remesh/shape.h"

namespace knead {

namespace {

using namespace remesh_detail;

constexpr int kMostRefinements = 8;      // rounds of splitting crossing faces
constexpr std::size_t kManyPairs = 300;  // if more pairs than these remain, later steps do not try to avoid crossings
constexpr double kMostSearched = 8e6;    // sum of face counts over all searches for crossings after the first
constexpr int kMostUntanglings = 4;
constexpr int kSteps = 2 + kMendLevels;  // compensate, improve, then the levels of mend
constexpr int kGuardedSteps = 2 + kGuardedLevels;
constexpr int kMostAttempts = 5;          // attempts to improve without new crossings
constexpr std::size_t kManyThin = 2000;   // triangles with an angle below 3 degrees
constexpr std::size_t kMostPairs = 5000;  // with more, refining crossing faces diverges (method, section 5)

class Remesher {
 public:
  Remesher(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
           const RemeshOptions& options, Improve improve)
      : before_(before),
        after_(after),
        options_(options),
        improve_(std::move(improve)),
        patch_(take_patch(before, after, deformation, options)),
        search_(before, patch_, options.single_precision, options.threads, options.progress),
        refinement_(patch_.surface, deformation, options.targets, options.whole,
                    before.vertex_count() - patch_.vertex_source.size(), options.progress) {}

  Remeshed run() {
    counts_steps_ = options_.progress != nullptr && options_.progress->total == 0;
    begin_steps(2 + kSteps);
    counts_.complete = refinement_.refine();
    end_step();
    improve_without_crossings();
    counts_.splits += refinement_.splits();
    stop_if_cancelled(options_.progress);
    normalise_normals(before_, patch_.surface);
    Remeshed result = put_back(before_, after_, patch_, options_.progress);
    result.counts = counts_;
    return result;
  }

 private:
  Surface& surface() { return patch_.surface; }

  // More steps are counted where crossings must be avoided: the fraction then begins again.
  void begin_steps(std::uint64_t steps) const {
    if (!counts_steps_) return;
    options_.progress->done = 0;
    options_.progress->total = steps;
  }
  void end_step() const {
    if (counts_steps_) ++options_.progress->done;
  }

  // Runs all steps, then searches for crossings. If there are new ones, starts again from the refined surface: splits
  // the faces that cross there, then runs the steps one by one; each leaves out the faces that would cross after it.
  void improve_without_crossings() {
    if (is_hopeless()) {
      start();
      improve_once(0, {});
      counts_.crossings = search().pairs;
      return;
    }
    const Surface refined = surface();
    const int steps = options_.targets.iterations > 0 ? kSteps : 1;
    start();
    for (int step = 0; step < steps; ++step) {
      improve_once(step, {});
      end_step();
    }
    Crossings found = find_and_untangle({});
    end_step();
    if (found.pairs > 0 && found.pairs > crossings_before(refined)) {
      const std::size_t improved_pairs = found.pairs;
      Surface improved = std::exchange(surface(), refined);
      const RemeshCounts improved_counts = counts_;
      begin_steps(1 + 2 * kGuardedSteps - (kSteps - 1));
      found.pairs = refine_crossings();
      end_step();
      if (found.pairs > kManyPairs && surface().face_count() == refined.face_count()) {
        surface() = std::move(improved);  // nothing was split: running all steps again would give the same surface
        counts_ = improved_counts;
        counts_.crossings = improved_pairs;
        return;
      }
      start();
      if (found.pairs > kManyPairs) {
        for (int step = 0; step < steps; ++step) improve_once(step, {});
        counts_.crossings = search_.find(patch_).pairs;
        return;
      }
      const int guarded_steps = steps > 1 ? kGuardedSteps : 1;
      for (int step = 0; step < guarded_steps; ++step) found.pairs = improve_guarded(step, found.pairs);
      // Faces that were left out may be mended now, because others have changed.
      for (int step = kSteps - 1; step < guarded_steps; ++step) found.pairs = improve_guarded(step, found.pairs);
    }
    counts_.crossings = found.pairs;
  }

  // Returns true if most of the many triangles are so thin that improving them would take long and not help.
  bool is_hopeless() {
    const Surface& s = surface();
    std::size_t touched = 0;
    std::size_t thin = 0;
    for (std::size_t f = 0; f < s.face_count(); ++f) {
      const Triangle t = s.triangle(f);
      if (!std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return s.has(v, kMoved); })) continue;
      ++touched;
      if (quality(s, f, s.after) < kThin) ++thin;
    }
    const bool found = thin > kManyThin && 2 * thin > touched;
    counts_.complete = counts_.complete && !found;
    return found;
  }

  // Repeats one step, each time leaving out the faces that crossed, until no more than `unavoidable` pairs cross.
  // Undoes the step if that fails. Returns the number of pairs that cross.
  std::size_t improve_guarded(int step, std::size_t unavoidable) {
    const std::size_t left = avoid_crossings(step, unavoidable);
    end_step();
    return left;
  }

  std::size_t avoid_crossings(int step, std::size_t unavoidable) {
    const Surface saved = surface();
    const RemeshCounts counts = counts_;
    std::vector<bool> locked;
    for (int attempt = 0; attempt < kMostAttempts && searched_ < kMostSearched; ++attempt) {
      improve_once(step, locked);
      const Crossings found = find_and_untangle(locked);
      if (found.pairs <= unavoidable) return found.pairs;
      lock_around(found, attempt, locked);
      surface() = saved;
      counts_ = counts;
    }
    return unavoidable;
  }

  // Returns the number of pairs that cross on the undeformed surface.
  std::size_t crossings_before(const Surface& refined) {
    Surface improved = std::move(surface());
    surface() = refined;
    surface().after = refined.before;
    const std::size_t pairs = search().pairs;
    surface() = std::move(improved);
    return pairs;
  }

  Crossings search() {
    searched_ += static_cast<double>(surface().face_count());
    return search_.find(patch_);
  }

  // Finds crossings and changes the faces that cross, for a few rounds. Returns the crossings that remain.
  Crossings find_and_untangle(const std::vector<bool>& locked) {
    Crossings found = search();
    for (int round = 0; round < kMostUntanglings && found.pairs > 0 && found.pairs <= kMostPairs; ++round) {
      const ImprovementCounts done = untangle(surface(), {options_.targets, locked, options_.progress}, found.faces);
      counts_.flips += done.flips;
      counts_.collapses += done.collapses;
      const std::size_t was = found.pairs;
      found = search();
      if (found.pairs >= 2 * was) break;
    }
    return found;
  }

  // Splits faces that cross until none does or splitting does not help. Returns the number of pairs that remain.
  std::size_t refine_crossings() {
    Crossings found = search_.find(patch_);
    std::size_t fewest = found.pairs;
    Surface best = surface();
    std::vector<Vec3d> deviations = refinement_.deviations();
    for (int round = 0; round < kMostRefinements && found.pairs > 0 && found.pairs <= 2 * fewest; ++round) {
      if (found.pairs > kMostPairs) break;
      counts_.complete = refinement_.refine_faces(found.faces) && counts_.complete;
      found = search_.find(patch_);
      if (found.pairs >= fewest) continue;
      fewest = found.pairs;
      best = surface();
      deviations = refinement_.deviations();
    }
    surface() = std::move(best);
    refinement_.put_back(std::move(deviations));
    return fewest;
  }

  // Prepares the refined surface for the first step.
  void start() {
    turn_normals(before_, surface());
    counts_.missing_volume = missing_volume();
    counts_.compensated_volume = 0;
    counts_.splits = 0;
    counts_.flips = 0;
    counts_.collapses = 0;
  }

  void improve_once(int step, const std::vector<bool>& locked) {
    Surface& s = surface();
    stop_if_cancelled(options_.progress);
    const Improvement improvement{options_.targets, locked, options_.progress};
    ImprovementCounts done;
    if (improve_) {
      if (step == 1) done = improve_(s, improvement);
    } else if (step == 0) {
      counts_.compensated_volume = compensate(s, refinement_.deviations(), locked, counts_.missing_volume);
    } else {
      done = step == 1 ? improve(s, improvement) : mend(s, improvement, step - 2);
    }
    counts_.splits += done.splits;
    counts_.flips += done.flips;
    counts_.collapses += done.collapses;
  }

  // Returns the exact difference of volumes if the border of the patch rests (the flow keeps volume); else an estimate
  // from the chords.
  double missing_volume() {
    const Surface& s = surface();
    for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
      if (s.opposite[h] == kNone && (s.has(s.origin(h), kMoved) || s.has(s.target(h), kMoved))) {
        return estimate_missing_volume(s, refinement_.deviations());
      }
    }
    return enclosed_volume(s, s.before) - enclosed_volume(s, s.after);
  }

  // Locks the corners of crossing faces; from the second attempt on, also the vertices around them.
  void lock_around(const Crossings& crossings, int attempt, std::vector<bool>& locked) {
    const Surface& s = surface();
    locked.resize(std::max(locked.size(), s.vertex_count()), false);
    for (const std::uint32_t f : crossings.faces) {
      for (const std::uint32_t v : s.triangle(f)) {
        locked[v] = true;
        if (attempt == 0) continue;
        s.for_each_outgoing(v, [&](std::uint32_t h) {
          locked[s.target(h)] = true;
          locked[s.apex(h)] = true;
        });
      }
    }
  }

  const Mesh& before_;
  std::span<const Vec3d> after_;
  const RemeshOptions& options_;
  Improve improve_;  // empty: the compensation and improvement of this room
  Patch patch_;
  CrossingSearch search_;
  Refinement refinement_;
  RemeshCounts counts_;
  double searched_ = 0;
  bool counts_steps_ = false;
};

}  // namespace

Remeshed remesh_detail::remesh_with(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                                    const RemeshOptions& options, const Improve& improve) {
  validate(before);
  if (after.size() != before.vertex_count()) {
    throw InvalidInput("give as many positions after the deformation as the mesh has vertices");
  }
  if (!std::all_of(after.begin(), after.end(), [](const Vec3d& p) { return is_finite(p); })) {
    throw InvalidInput("a position after the deformation is not finite");
  }
  if (!options.face_labels.empty() && options.face_labels.size() != before.face_count()) {
    throw InvalidInput("give a label for each face, or none");
  }
  return Remesher(before, after, deformation, options, improve).run();
}

Remeshed remesh(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                const RemeshOptions& options) {
  return remesh_with(before, after, deformation, options, {});
}

}  // namespace knead
