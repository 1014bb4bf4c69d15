#include "certified.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "command.h"
#include "output.h"

namespace knead::command {
namespace {

constexpr int kMaxRefinements = 3;
constexpr int kMaxRounds = 100;

struct Complaints {
  std::string text;  // of the first
  bool chords = false;
  bool rounds = false;
  bool beyond_remeshing = false;  // remeshing cannot meet one of the bounds
};

std::optional<Complaints> complaints_of(const std::vector<Bound>& bounds, const Certificate& certificate) {
  std::optional<Complaints> complaints;
  for (const Bound& bound : bounds) {
    const std::optional<Unmet> found = unmet(bound, certificate);
    if (!found) continue;
    if (!complaints || found->cure == Cure::none) complaints = Complaints{found->text};
    if (found->cure == Cure::none) complaints->beyond_remeshing = true;
    if (complaints->beyond_remeshing) break;
    complaints->chords = complaints->chords || found->cure == Cure::shorter_chords;
    complaints->rounds = complaints->rounds || found->cure == Cure::more_rounds;
  }
  return complaints;
}

void refine(const Complaints& complaints, std::optional<RemeshSettings>& settings) {
  if (!settings) return;
  if (complaints.chords) settings->max_chord = 0.5 * settings->max_chord.value_or(kDefaultMaxChord);
  if (complaints.rounds) {
    settings->iterations =
        std::min(kMaxRounds, 2 * std::max(1, settings->iterations.value_or(kDefaultRemeshIterations)));
  }
}

void refine(const Complaints& complaints, Certified& certified) {
  refine(complaints, certified.options.remesh.settings);
  for (SessionStroke& stroke : certified.session.strokes) refine(complaints, stroke.remesh);
}

void certify(const ShapeFile& shape, bool quiet, Certified& certified) {
  CertificateBuilder builder(shape.mesh, certified.options);
  ReplayOptions watched = certified.options;
  watched.on_stroke = [&](const AppliedStroke& stroke) { builder.add(stroke); };
  certified.result = replay_watched(shape.mesh, certified.session, watched, quiet);
  certified.certificate = builder.finish(certified.result, certified.options.remesh.single_precision);
}

bool is_out_of_time(const Certified& certified) {
  const Provenance* const remeshed = certified.result.shape.provenance();
  return remeshed != nullptr && remeshed->counts.out_of_time;
}

[[noreturn]] void refuse(const std::string& shape, const std::string& complaint, int refinements, bool remeshed) {
  if (!remeshed) {
    throw QualityError(fmt::format("{}: {}; add --remesh, or give a finer mesh", shape, complaint));
  }
  throw QualityError(fmt::format("{}: {}, even after {}; deform less, or give a finer mesh", shape, complaint,
                                 counted(static_cast<std::size_t>(refinements), "refinement")));
}

}  // namespace

Certified replay_certified(const Inputs& inputs, const ReplayOptions& options, bool check,
                           const std::vector<Bound>& bounds, bool quiet) {
  Certified certified{{}, {}, options, inputs.session};
  if (bounds.empty()) {
    if (check) {
      certify(inputs.shape, quiet, certified);
    } else {
      certified.result = replay_watched(inputs.shape.mesh, inputs.session, options, quiet);
    }
    return certified;
  }
  certified.options.frames.count = 0;
  std::optional<std::size_t> crossings;  // of the attempt before
  for (int refinements = 0;; ++refinements) {
    certify(inputs.shape, quiet || refinements > 0, certified);
    const std::optional<Complaints> complaints = complaints_of(bounds, *certified.certificate);
    if (!complaints) break;
    if (complaints->beyond_remeshing) throw QualityError(fmt::format("{}: {}", inputs.session.name, complaints->text));
    const bool remeshed = certified.result.shape.is_remeshed();
    if (!remeshed || refinements == kMaxRefinements) {
      refuse(inputs.session.name, complaints->text, refinements, remeshed);
    }
    const std::size_t now = certified.certificate->crossings_after;
    if (crossings && now > *crossings) {
      throw QualityError(
          fmt::format("{}: {}, and refining makes them more ({} before); the coordinates may be too coarse for so fine "
                      "a mesh: use --precision double, or move the shape to the origin",
                      inputs.session.name, complaints->text, *crossings));
    }
    if (is_out_of_time(certified)) {
      throw QualityError(fmt::format("{}: {}, and --remesh-seconds ended the remeshing; allow more, or deform less",
                                     inputs.session.name, complaints->text));
    }
    crossings = now;
    if (!quiet) print_message(fmt::format("note: {}; trying again with a finer mesh", complaints->text));
    refine(*complaints, certified);
  }
  certified.options.frames = options.frames;
  if (options.frames.count > 0) replay_watched(inputs.shape.mesh, certified.session, certified.options, true);
  return certified;
}

std::string line_of(const Certificate& c) {
  std::string text =
      fmt::format("{} crossing ({} before), {} flipped, {} without area; ", counted(c.crossings_after, "pair"),
                  c.crossings_before, c.flipped_triangles, c.degenerate_after);
  const bool kept = c.closed_before == c.closed_after && c.euler_before == c.euler_after;
  text +=
      fmt::format("{}, Euler {}{}; ", c.closed_after ? "closed" : "open", c.euler_after,
                  kept ? "" : fmt::format(" (before: {}, {})", c.closed_before ? "closed" : "open", c.euler_before));
  if (c.volume_error) {
    text += fmt::format("volume error {:.2g} ({:.2g} of it from integration); ", *c.volume_error,
                        c.volume_error_integration);
  }
  if (c.touched_angle_before && c.touched_angle_after) {
    text += fmt::format("smallest angle {:.3g} degrees ({:.3g} before) where touched; ", *c.touched_angle_after,
                        *c.touched_angle_before);
  }
  text += c.motion_outside == 0 ? "no motion beyond the tools; "
                                : fmt::format("motion of {:.2g} beyond the tools; ", c.motion_outside);
  return text + fmt::format("distance to the exact image {:.2g} (root mean square), {:.2g} at most", c.distance_rms,
                            c.distance_max);
}

}  // namespace knead::command
