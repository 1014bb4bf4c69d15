// remesh(): refines a surface after a deformation, improves it, and ends the crossings that this causes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/vec.h"
#include "remesh/crossings.h"
#include "remesh/facets.h"
#include "remesh/improve.h"
#include "remesh/improver.h"
#include "remesh/patch.h"
#include "remesh/refine.h"
#include "remesh/surface.h"

namespace knead {

namespace {

using namespace detail;

constexpr int kMaxRefinements = 8;  // rounds of splitting crossing faces
constexpr int kMaxRepairRounds = 4;
constexpr double kMaxRestShare = 1e-3;     // of the missing volume that compensation may leave
constexpr double kNoVolume = 1e-9;         // of the cube of the diagonal: near rounding
constexpr double kMaxMissing = 2;          // of what all chords together can miss
constexpr std::size_t kFewPairs = 5;       // that improving can often end where splitting does not
constexpr double kPlaceMargin = 0.1;       // by which the box of a crossing face is widened, in diagonals
constexpr int kSteps = 2 + kRepairLevels;  // compensate, improve, then the levels of repair_triangles()
constexpr int kGuardedSteps = 2 + kGuardedLevels;
constexpr int kMaxGuards = 3;            // attempts to improve with a guard
constexpr int kMaxAttempts = 5;          // attempts to move all vertices without new crossings
constexpr std::size_t kMaxThin = 2000;   // triangles with an angle below 3 degrees
constexpr std::size_t kMaxPairs = 5000;  // with more, refining crossing faces diverges (method, section 5)

class Remesher {
 public:
  Remesher(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
           const RemeshOptions& options, Improve improve, MorePlaces& places)
      : deadline_(options.seconds),
        before_(before),
        after_(after),
        options_(options),
        improve_(std::move(improve)),
        places_(places),
        patch_(extract_patch(before, after, deformation, options, places)),
        flat_(improve_before(deformation)),
        search_(before, patch_, options.single_precision, options.threads, options.progress),
        refinement_(patch_.surface, deformation, options, before.vertex_count() - patch_.vertex_source.size(),
                    deadline_) {}

  Remeshed run() {
    counts_steps_ = options_.progress != nullptr && options_.progress->total == 0;
    begin_steps(2 + kSteps);
    counts_.complete = refinement_.refine();
    end_step();
    improve_without_crossings();
    counts_.splits += refinement_.splits();
    counts_.flips += refinement_.flips();
    count(flat_);
    limit_edges_of_result();
    stop_if_cancelled(options_.progress);
    normalise_normals(before_, patch_.surface);
    counts_.out_of_time = deadline_.has_ended_work();
    Remeshed result = merge_patch(before_, after_, patch_, places_, options_.progress);
    result.counts = counts_;
    result.crossing_places = std::move(crossing_places_);
    return result;
  }

 private:
  // Improves the flat faces of parts in the surface before, and carries the vertices that have changed. The thin
  // faces that remain are those of the part itself.
  ImprovementCounts improve_before(const Deformation& deformation) {
    Surface& s = surface();
    if (improve_ || (options_.targets.iterations == 0 && !options_.exact) ||
        std::count(s.of_part.begin(), s.of_part.end(), 1) == 0) {
      return {};
    }
    const std::vector<Vec3d> before = s.before;
    const std::vector<Vec3d> after = std::exchange(s.after, s.before);
    const Improvement task{options_.targets, options_.progress, nullptr, &deadline_, nullptr, options_.threads};
    const double max_edge = options_.exact ? options_.targets.max_edge : kInfinity;
    const ImprovementCounts done = divide_flat_faces(s, task, max_edge);
    s.before = s.after;
    if (!options_.whole) keep_part_quality(s);
    std::vector<std::uint32_t> changed;
    std::vector<Vec3d> points;
    for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
      if (v < before.size() && s.before[v] == before[v]) {
        s.after[v] = after[v];
      } else {
        changed.push_back(v);
        points.push_back(s.before[v]);
      }
    }
    deformation.carry(points);
    for (std::size_t i = 0; i < changed.size(); ++i) s.after[changed[i]] = points[i];
    return done;
  }

  // Splits edges that improving has made longer than the limit. Undoes this if triangles then cross, which the rounding
  // of new vertices can cause.
  void limit_edges_of_result() {
    if (!counts_.complete || deadline_.is_over()) return;
    std::optional<Surface> saved;
    const std::size_t outside = before_.vertex_count() - patch_.vertex_source.size();
    const LimitedEdges done = limit_edges(surface(), options_, outside, saved);
    counts_.complete = done.met;
    if (!saved) return;
    const bool crosses = search_.find(patch_, changed_since(*saved)).pairs > 0;
    if (crosses && search_.find(patch_).pairs > counts_.crossings) {
      surface() = *std::move(saved);
      counts_.complete = false;
    } else {
      counts_.splits += done.splits;
    }
  }

  // Returns a flag for each face: true if it is new or has other vertices than it had.
  std::vector<bool> changed_since(const Surface& saved) const {
    const Surface& s = patch_.surface;
    std::vector<bool> changed(s.face_count(), true);
    for (std::size_t f = 0; f < saved.face_count(); ++f) changed[f] = s.triangle(f) != saved.triangle(f);
    return changed;
  }

  Surface& surface() { return patch_.surface; }

  // Restarts the progress with this number of steps: there are more of them where crossings must be avoided.
  void begin_steps(std::uint64_t steps) const {
    if (!counts_steps_) return;
    options_.progress->done = 0;
    options_.progress->total = steps;
  }
  void end_step() const {
    if (counts_steps_) ++options_.progress->done;
  }

  // Runs all steps, then searches for crossings. If there are new ones that repairs do not end, starts again from the
  // refined surface: splits the faces that cross there, then runs the steps with a guard.
  void improve_without_crossings() {
    const bool is_last_try = cannot_succeed();
    const Surface refined = surface();
    const int steps = is_last_try || options_.targets.iterations == 0 ? 1 : kSteps;
    start();
    if (options_.exact && options_.targets.iterations == 0) return;  // splits alone move nothing
    if (options_.stop_where_thousands_cross && stops_where_crossed(refined)) return;
    SurfaceMemory memory;
    for (int step = 0; step < steps; ++step) {
      improve_once(step, nullptr, memory);
      end_step();
      if (deadline_.is_over()) break;
    }
    spread(std::exchange(volume_, 0), {});
    Crossings found = search_.find(patch_);
    end_step();
    if (found.pairs > 0) {
      const Crossings before = crossings_before(refined);
      counts_.crossings_before = before.pairs;
      counts_.curves_before = before.curves;
    }
    if (!is_last_try && found.pairs > counts_.crossings_before) found = end_crossings(std::move(found), refined);
    counts_.crossings = found.pairs;
    counts_.curves = found.curves;
    for (const std::uint32_t f : found.faces) crossing_places_.push_back(centre_of(f));
  }

  // Returns true, and counts the crossings, if so many pairs cross in the refined surface that improving is in vain.
  bool stops_where_crossed(const Surface& refined) {
    const Crossings found = search_.find(patch_);
    if (found.pairs <= kMaxPairs) return false;
    counts_.crossings_before = crossings_before(refined).pairs;
    counts_.stopped = found.pairs > kMaxPairs + counts_.crossings_before;
    if (counts_.stopped) counts_.crossings = found.pairs;
    return counts_.stopped;
  }

  // Repairs crossings. If more pairs still cross than before the deformation, starts again from the refined surface.
  Crossings end_crossings(Crossings found, const Surface& refined) {
    if (deadline_.is_over()) return fewest_of(std::move(found), refined);
    std::vector<Box> places = places_of(found);
    found = repair_faces(std::move(found));
    if (found.pairs <= counts_.crossings_before) return give_volume_back(std::move(found));
    return deadline_.is_over() ? fewest_of(std::move(found), refined) : improve_guarded(refined, std::move(places));
  }

  // Goes back to the refined surface if fewer triangles cross there; for when no time is left.
  Crossings fewest_of(Crossings found, const Surface& refined) {
    const Surface improved = std::exchange(surface(), refined);
    const RemeshCounts counts = counts_;
    start();
    Crossings before = search_.find(patch_);
    if (before.pairs < found.pairs) return before;
    surface() = improved;
    counts_ = counts;
    return found;
  }

  // Runs the steps on the refined surface again, with a guard at the places where triangles crossed. If others cross
  // afterwards, guards their places, too, and starts again.
  Crossings improve_guarded(const Surface& refined, std::vector<Box> places) {
    surface() = refined;
    Crossings found = refine_crossings();
    if (options_.stop_where_crossed && found.pairs > counts_.crossings_before + kFewPairs) {
      counts_.stopped = true;
      return found;
    }
    begin_steps(2 + kMaxGuards);
    end_step();
    start();
    if (!improve_) {
      found = move_all(std::move(found), [&](const std::vector<bool>& locked) { compensate_missing(locked); });
    }
    end_step();
    if (deadline_.is_over()) return found;
    Crossings unavoidable = found;
    const Surface compensated = surface();
    const RemeshCounts counts = counts_;
    const double volume = volume_;
    for (int attempt = 1;; ++attempt) {
      const std::vector<Box> more = places_of(found);
      places.insert(places.end(), more.begin(), more.end());
      const bool ended = improve_at_places(places, attempt == kMaxGuards);
      found = repair_faces(search_.find(patch_));
      end_step();
      if (found.pairs <= unavoidable.pairs || attempt == kMaxGuards) return give_volume_back(std::move(found));
      surface() = compensated;
      counts_ = counts;
      volume_ = volume;
      if (!ended || deadline_.is_over()) return unavoidable;
    }
  }

  // Runs all steps after the compensation with a guard. Returns false if the guard was spent before they ended.
  bool improve_at_places(std::span<const Box> places, bool everywhere) {
    CrossingGuard guard(surface(), search_);
    guard.watch(places);
    if (everywhere) guard.watch_everything();
    const int steps = options_.targets.iterations > 0 ? kGuardedSteps : 1;
    SurfaceMemory memory;
    for (int step = 1; step < steps; ++step) improve_once(step, &guard, memory);
    // Changes that were refused may succeed now, because other faces have changed.
    for (int step = kSteps - 1; step < steps; ++step) improve_once(step, &guard, memory);
    counts_.complete = counts_.complete && !guard.is_spent();
    return !guard.is_spent();
  }

  // Changes faces that cross, for a few rounds. Returns the crossings that remain.
  Crossings repair_faces(Crossings found) {
    if (found.pairs == 0 || found.pairs > kMaxPairs) return found;
    CrossingGuard guard(surface(), search_);
    guard.watch_everything();
    std::vector<std::uint32_t> faces = found.faces;
    const Improvement task{options_.targets, options_.progress, &guard, &deadline_, nullptr, 1, options_.exact};
    for (int round = 0; round < kMaxRepairRounds && !faces.empty(); ++round) {
      count(repair_crossings(surface(), task, faces));
      std::erase_if(faces, [&](std::uint32_t f) {
        stop_if_cancelled(options_.progress);
        return !guard.crosses(f);
      });
    }
    return search_.find(patch_);
  }

  // Restores the volume that the steps have lost. Returns the crossings.
  Crossings give_volume_back(Crossings found) {
    if (volume_ == 0) return found;
    return move_all(std::move(found), [&](const std::vector<bool>& locked) { spread(volume_, locked); });
  }

  void spread(double volume, const std::vector<bool>& locked) {
    spread_volume(surface(), volume, options_.targets.max_chord, locked);
  }

  // Compensates the missing volume. Where few vertices may move far enough, all share the rest after the other steps.
  void compensate_missing(const std::vector<bool>& locked) {
    const double missing = counts_.missing_volume;
    counts_.compensated_volume = compensate(surface(), refinement_.deviations(), locked, missing);
    const double rest = missing - counts_.compensated_volume;
    volume_ = std::abs(rest) > std::max(kMaxRestShare * std::abs(missing), no_volume()) ? rest : 0;
  }

  Vec3d centre_of(std::uint32_t f) const {
    const Surface& s = patch_.surface;
    const auto [a, b, c] = s.triangle(f);
    return (s.after[a] + s.after[b] + s.after[c]) * (1.0 / 3);
  }

  // Returns the widened boxes of the faces that cross.
  std::vector<Box> places_of(const Crossings& found) const {
    std::vector<Box> places;
    for (const std::uint32_t f : found.faces) {
      Box box = bounding_box(placed(patch_.surface, patch_.surface.triangle(f)).corners);
      const double margin = kPlaceMargin * box.diagonal();
      box.min -= Vec3d{margin, margin, margin};
      box.max += Vec3d{margin, margin, margin};
      places.push_back(box);
    }
    return places;
  }

  // Returns true if many triangles, and most of those that moved, are so thin that improving them would not help.
  bool cannot_succeed() {
    const Surface& s = surface();
    std::size_t touched = 0;
    std::size_t thin = 0;
    for (std::size_t f = 0; f < s.face_count(); ++f) {
      const Triangle t = s.triangle(f);
      if (!std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return s.has(v, kMoved); })) continue;
      ++touched;
      if (quality(s, f, s.after) < kMinReliableQuality) ++thin;
    }
    const bool found = thin > kMaxThin && 2 * thin > touched;
    counts_.faces = touched;
    counts_.complete = counts_.complete && !found;
    return found;
  }

  // Calls move(locked), which moves all vertices but the locked ones a little. Locks more of them until no more pairs
  // cross than before; restores all positions if this fails. Returns the crossings.
  template <class Move>
  Crossings move_all(Crossings before, const Move& move) {
    const std::vector<Vec3d> saved = surface().after;
    const RemeshCounts counts = counts_;
    std::vector<bool> locked;
    for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
      move(locked);
      Crossings found = search_.find(patch_);
      if (found.pairs <= before.pairs) return found;
      lock_around(found, attempt, locked);
      surface().after = saved;
      counts_ = counts;
    }
    return before;
  }

  // Returns the crossings of the undeformed surface. If the original triangles there do not cross, none: new vertices
  // are rounded, which can make the refined ones cross.
  Crossings crossings_before(const Surface& refined) {
    Surface improved = std::move(surface());
    surface() = refined;
    surface().after = refined.before;
    Crossings found = search_.find(patch_);
    surface() = std::move(improved);
    return found.pairs > 0 && has_crossed() ? found : Crossings{};
  }

  // Returns true if an original triangle of the patch crossed another one of the mesh.
  bool has_crossed() const {
    std::vector<Vec3d> positions(before_.positions.begin(), before_.positions.end());
    for (Vec3d& p : positions) p = search_.as_written(p);
    std::vector<bool> is_of_patch;
    for (const std::uint32_t f : triangle_faces(before_)) is_of_patch.push_back(patch_.holds_face[f] != 0);
    const SelfIntersectionOptions any{
        .threads = options_.threads, .limit = 1, .progress = options_.progress, .chosen = &is_of_patch};
    return self_intersections(triangulate(before_), positions, any).count > 0;
  }

  // Splits faces that cross, until none crosses or splitting no longer helps. Returns the crossings that remain.
  Crossings refine_crossings() {
    Crossings found = search_.find(patch_);
    Crossings fewest = found;
    Surface best = surface();
    std::vector<Vec3d> deviations = refinement_.deviations();
    for (int round = 0; round < kMaxRefinements && found.pairs > 0 && found.pairs <= 2 * fewest.pairs; ++round) {
      if (found.pairs > kMaxPairs || deadline_.is_over()) break;
      counts_.complete = refinement_.refine_faces(found.faces) && counts_.complete;
      found = search_.find(patch_);
      if (found.pairs >= fewest.pairs) continue;
      fewest = found;
      best = surface();
      deviations = refinement_.deviations();
    }
    surface() = std::move(best);
    refinement_.restore(std::move(deviations));
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
    volume_ = 0;
  }

  void count(const ImprovementCounts& done) {
    counts_.splits += done.splits;
    counts_.flips += done.flips;
    counts_.collapses += done.collapses;
    volume_ += done.volume;
  }

  // `memory`: that of the surface since the first step after the compensation.
  void improve_once(int step, CrossingGuard* guard, SurfaceMemory& memory) {
    Surface& s = surface();
    stop_if_cancelled(options_.progress);
    const Improvement improvement{options_.targets, options_.progress, guard,         &deadline_,
                                  &memory,          options_.threads,  options_.exact};
    if (improve_) {
      if (step == 1) count(improve_(s, improvement));
    } else if (step == 0) {
      compensate_missing({});
    } else {
      count(step == 1 ? improve(s, improvement) : repair_triangles(s, improvement, step - 2));
    }
  }

  // Returns the exact difference of volumes if the border of the patch rests; an estimate from the chords if it does
  // not, or if the difference is so large that the deformation does not keep volume.
  double missing_volume() {
    const Surface& s = surface();
    const MissingVolume estimate = estimate_missing_volume(s, refinement_.deviations());
    for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
      const bool is_border = s.opposite[h] == kNone;
      if (is_border && (s.has(s.origin(h), kMoved) || s.has(s.target(h), kMoved))) return estimate.sum;
    }
    const double exact = enclosed_volume(s, s.before) - enclosed_volume(s, s.after);
    return std::abs(exact) > kMaxMissing * estimate.sum_of_sizes + no_volume() ? estimate.sum : exact;
  }

  double no_volume() const {
    const double size = options_.targets.diagonal;
    return kNoVolume * size * size * size;
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

  Deadline deadline_;
  const Mesh& before_;
  std::span<const Vec3d> after_;
  const RemeshOptions& options_;
  Improve improve_;  // empty: the compensation and improvement of this module
  MorePlaces& places_;
  Patch patch_;
  ImprovementCounts flat_;  // of improve_before()
  CrossingSearch search_;
  Refinement refinement_;
  RemeshCounts counts_;
  std::vector<Vec3d> crossing_places_;
  double volume_ = 0;  // that the steps have lost or left out
  bool counts_steps_ = false;
};

// Returns the greatest distance of these points from the surface of a mesh.
double greatest_distance(std::span<const Vec3d> points, const Mesh& mesh, const RemeshOptions& options) {
  constexpr std::size_t grain = 256;
  if (points.empty() || mesh.face_count() == 0) return 0;
  const SurfaceTree tree(triangulate(mesh), mesh.positions);
  std::vector<double> greatest(points.size() / grain + 1, 0.0);
  parallel_for(points.size(), grain, options.threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(options.progress);
    for (std::size_t i = begin; i < end; ++i) {
      greatest[begin / grain] = std::max(greatest[begin / grain], tree.closest(points[i])->distance);
    }
  });
  return *std::max_element(greatest.begin(), greatest.end());
}

// Returns the greatest distance between the surfaces before and after, measured from vertices of only one of them and
// from the centres of the faces after.
double greatest_distance_between(const Mesh& before, const Remeshed& after, const RemeshOptions& options) {
  std::vector<std::uint8_t> stays(before.vertex_count(), 0);
  std::vector<Vec3d> of_after;
  for (std::size_t v = 0; v < after.mesh.vertex_count(); ++v) {
    const std::uint32_t source = after.vertex_source[v];
    const bool same = source != kNewVertex && same_bits(after.mesh.positions[v], before.positions[source]);
    if (same) stays[source] = 1;
    if (!same) of_after.push_back(after.mesh.positions[v]);
  }
  const bool has_changed = after.counts.flips + after.counts.collapses > 0;
  for (std::size_t f = 0; f < after.mesh.face_count() && has_changed; ++f) {
    const auto face = after.mesh.face(f);
    if (face.size() != 3) continue;
    const auto& p = after.mesh.positions;
    of_after.push_back((p[face[0]] + p[face[1]] + p[face[2]]) / 3.0);
  }
  std::vector<Vec3d> of_before;
  for (const std::uint32_t v : before.corner_vertex) {
    if (std::exchange(stays[v], std::uint8_t{1}) == 0) of_before.push_back(before.positions[v]);
  }
  return std::max(greatest_distance(of_after, before, options), greatest_distance(of_before, after.mesh, options));
}

}  // namespace

Remeshed detail::remesh_with(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                             const RemeshOptions& options, const Improve& improve, MorePlaces& places) {
  if (!options.assume_valid) validate(before);
  if (after.size() != before.vertex_count()) {
    throw InvalidInput("give as many positions after the deformation as the mesh has vertices");
  }
  const auto is_wrong = [](const Vec3d& p) { return !is_finite(p); };
  const auto wrong = options.assume_valid ? after.end() : std::find_if(after.begin(), after.end(), is_wrong);
  if (wrong != after.end()) {
    throw InvalidInput("position " + std::to_string(wrong - after.begin()) + " after the deformation is not finite");
  }
  if (!options.held.empty() && options.held.size() != before.vertex_count()) {
    throw InvalidInput("say for each vertex whether it is held");
  }
  if (std::isnan(options.seconds)) throw InvalidInput("give the seconds of a remesh as a number");
  if (!options.face_labels.empty() && options.face_labels.size() != before.face_count()) {
    throw InvalidInput("give a label for each face, or none");
  }
  return Remesher(before, after, deformation, options, improve, places).run();
}

Remeshed remesh(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                const RemeshOptions& options) {
  MorePlaces none;
  return remesh_with(before, after, deformation, options, {}, none);
}

Remeshed remesh(const Mesh& mesh, const RemeshSettings& settings, RemeshOptions options) {
  const std::vector<MeshEdge> creases = find_creases(mesh);
  options.targets = resolve(settings, mesh);
  options.whole = true;
  options.exact = !settings.min_edge && !settings.max_chord;
  options.creases = creases;
  Remeshed result = remesh(mesh, mesh.positions, {[](std::span<Vec3d>) {}}, options);
  result.counts.distance = greatest_distance_between(mesh, result, options);
  const double max_distance = kExactDistance * options.targets.diagonal + plane_tolerance(mesh.positions);
  if (options.exact && result.counts.distance > max_distance) {
    throw QualityLimit(
        fmt::format("the surface would move by {:.1g} of its size; where it may, say by how much: "
                    "\"max_chord\" of {:.1g}",
                    result.counts.distance / options.targets.diagonal, kDefaultMaxChord));
  }
  return result;
}

}  // namespace knead
