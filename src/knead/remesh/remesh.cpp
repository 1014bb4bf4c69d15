#include "knead/remesh/remesh.h"

#include <algorithm>

#include "knead/math/error.h"
#include "knead/remesh/carried_normals.h"
#include "knead/remesh/compensate.h"
#include "knead/remesh/crossings.h"
#include "knead/remesh/improve.h"
#include "knead/remesh/patch.h"
#include "knead/remesh/refine.h"

namespace knead {

namespace {

using namespace remesh_detail;

constexpr int kMostRefinements = 5;  // of crossing faces
constexpr int kMostUntanglings = 4;
constexpr int kMostAttempts = 6;          // at improving without a crossing
constexpr std::size_t kMostPairs = 3000;  // with more, refining crossing faces diverges (method, section 5)

class Remesher {
 public:
  Remesher(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
           const RemeshOptions& options)
      : before_(before),
        after_(after),
        options_(options),
        patch_(take_patch(before, after, deformation, options)),
        search_(before, patch_, options.single_precision, options.threads),
        refinement_(patch_.surface, deformation, options.targets, options.whole) {}

  Remeshed run() {
    counts_.complete = refinement_.refine();
    improve_without_crossings();
    counts_.splits = refinement_.splits();
    normalise_normals(before_, patch_.surface);
    Remeshed result = put_back(before_, after_, patch_);
    result.counts = counts_;
    return result;
  }

 private:
  Surface& surface() { return patch_.surface; }

  // Improves all at once, and looks whether anything crosses. If so: first splits where the refined surface crosses by
  // itself, then improves again and again, each time leaving out what crossed.
  void improve_without_crossings() {
    Surface refined = surface();
    std::vector<bool> locked;
    improve_once(locked);
    Crossings found = find_and_untangle(locked);
    if (found.pairs > 0) {
      lock_around(found, locked);
      surface() = std::move(refined);
      const std::size_t unavoidable = refine_crossings();
      refined = surface();
      for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
        improve_once(locked);
        found = find_and_untangle(locked);
        if (found.pairs <= unavoidable) break;
        lock_around(found, locked);
        surface() = refined;
      }
      if (found.pairs > unavoidable) found = search_.find(patch_);
    }
    counts_.crossings = found.pairs;
  }

  // What crosses after a few rounds of changes to the faces that do.
  Crossings find_and_untangle(const std::vector<bool>& locked) {
    Crossings found = search_.find(patch_);
    for (int round = 0; round < kMostUntanglings && found.pairs > 0 && found.pairs <= kMostPairs; ++round) {
      const ImprovementCounts done = untangle(surface(), {options_.targets, locked}, found.faces);
      counts_.flips += done.flips;
      counts_.collapses += done.collapses;
      const std::size_t was = found.pairs;
      found = search_.find(patch_);
      if (found.pairs >= 2 * was) break;
    }
    return found;
  }

  // Splits faces that cross until none does; how many pairs remain.
  std::size_t refine_crossings() {
    Crossings found = search_.find(patch_);
    for (int round = 0; round < kMostRefinements && found.pairs > 0 && found.pairs <= kMostPairs; ++round) {
      counts_.complete = refinement_.refine_faces(found.faces) && counts_.complete;
      found = search_.find(patch_);
    }
    return found.pairs;
  }

  void improve_once(const std::vector<bool>& locked) {
    Surface& s = surface();
    turn_normals(before_, s);
    const bool keep = options_.volume == VolumeTreatment::keep;
    counts_.missing_volume = missing_volume();
    counts_.compensated_volume = 0;
    if (keep) counts_.compensated_volume = compensate(s, refinement_.deviations(), locked, counts_.missing_volume);
    const Improvement improvement{options_.targets, locked};
    const ImprovementCounts done = keep ? improve(s, improvement) : improve_as_in_the_paper(s, improvement);
    counts_.flips = done.flips;
    counts_.collapses = done.collapses;
  }

  // Exactly what the flow, which keeps volume, says, where the patch's border rests; else by the chords.
  double missing_volume() {
    const Surface& s = surface();
    for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
      if (s.opposite[h] == kNone && (s.has(s.origin(h), kMoved) || s.has(s.target(h), kMoved))) {
        return estimate_missing_volume(s, refinement_.deviations());
      }
    }
    return enclosed_volume(s, s.before) - enclosed_volume(s, s.after);
  }

  // Nothing is to be changed at the corners of crossing faces and their neighbours.
  void lock_around(const Crossings& crossings, std::vector<bool>& locked) {
    const Surface& s = surface();
    locked.resize(std::max(locked.size(), s.vertex_count()), false);
    std::vector<std::uint32_t> ring;
    for (const std::uint32_t f : crossings.faces) {
      for (const std::uint32_t v : s.triangle(f)) ring.push_back(v);
    }
    for (int rings = 0; rings < 2; ++rings) {
      const std::vector<std::uint32_t> last = std::move(ring);
      ring.clear();
      for (const std::uint32_t v : last) {
        if (locked[v] && rings == 0) continue;
        locked[v] = true;
        if (rings > 0) continue;
        s.for_each_outgoing(v, [&](std::uint32_t h) {
          ring.push_back(s.target(h));
          ring.push_back(s.apex(h));
        });
      }
    }
  }

  const Mesh& before_;
  std::span<const Vec3d> after_;
  const RemeshOptions& options_;
  Patch patch_;
  CrossingSearch search_;
  Refinement refinement_;
  RemeshCounts counts_;
};

}  // namespace

Remeshed remesh(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                const RemeshOptions& options) {
  if (after.size() != before.vertex_count()) {
    throw InvalidInput("give as many positions after the deformation as the mesh has vertices");
  }
  if (!options.face_labels.empty() && options.face_labels.size() != before.face_count()) {
    throw InvalidInput("give a label for each face, or none");
  }
  return Remesher(before, after, deformation, options).run();
}

}  // namespace knead
