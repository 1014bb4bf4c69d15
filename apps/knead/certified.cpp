// Bounds on certificates, requirements on shapes, and sessions that are replayed until they meet bounds.
#include "certified.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "command.h"
#include "output.h"

namespace knead::command {

namespace {

constexpr int kMaxRefinements = 3;
constexpr int kMaxRounds = 100;
constexpr std::string_view kDistance = "distance";
constexpr double kDefaultDistance = 1e-3;

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

void certify(const Mesh& mesh, bool quiet, std::size_t max_points, Certified& certified) {
  CertificateBuilder builder(mesh, certified.options, max_points);
  ReplayOptions watched = certified.options;
  watched.on_stroke = [&](const AppliedStroke& stroke) { builder.add(stroke); };
  certified.result = replay_watched(mesh, certified.session, watched, quiet);
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

// A certified result with remeshing is near the exact image, even without a bound on it.
std::vector<Bound> with_distance(std::vector<Bound> bounds, const Inputs& inputs, const ReplayOptions& options) {
  const bool is_bounded =
      std::any_of(bounds.begin(), bounds.end(), [](const Bound& bound) { return bound.name.starts_with(kDistance); });
  if (options.must_follow && inputs.remeshes && !is_bounded)
    bounds.push_back({std::string(kDistance), kDefaultDistance});
  return bounds;
}

// --- bounds

using Complaint = std::optional<std::string>;

Complaint complain_if(bool bad, const std::string& text) { return bad ? Complaint(text) : std::nullopt; }

Complaint volume_changed(const Certificate& c, double limit) {
  return complain_if(!(std::abs(*c.volume_error) <= limit),
                     fmt::format("the volume changed by a fraction of {:.2g}, more than {:g}", *c.volume_error, limit));
}

Complaint crosses(const Certificate& c, double limit) {
  return complain_if(static_cast<double>(c.crossings_after) > limit,
                     fmt::format("{} of triangles cross ({} did before), more than {:g}",
                                 counted(c.crossings_after, "pair"), c.crossings_before, limit));
}

Complaint is_flipped(const Certificate& c, double limit) {
  return complain_if(static_cast<double>(c.flipped_triangles) > limit,
                     fmt::format("{} flipped, more than {:g}", counted(c.flipped_triangles, "triangle"), limit));
}

Complaint is_narrow(const Certificate& c, double limit) {
  if (!c.touched_angle_after) return std::nullopt;  // nothing was touched
  return complain_if(*c.touched_angle_after < limit, fmt::format("a triangle has an angle of {:.3g} degrees, less than "
                                                                 "{:g}",
                                                                 *c.touched_angle_after, limit));
}

Complaint is_far(const char* which, double distance, double limit) {
  return complain_if(!(distance <= limit),
                     fmt::format("the {} distance to the exact image is {:.2g} of the box diagonal, more than {:g}",
                                 which, distance, limit));
}

constexpr std::string_view kNoInvertedCells = "no-inverted-cells";
constexpr const char* kNoCells = "no cells; give a volume mesh of gmsh, SU2 or OpenFOAM";

Complaint has_inverted_cells(const Certificate& certificate, double) {
  if (!certificate.inverted_cells_after) return kNoCells;
  const std::size_t count = *certificate.inverted_cells_after;
  return complain_if(count > 0, fmt::format("{} inverted; deform less", counted(count, "cell")));
}

struct BoundKind {
  std::string_view name;
  std::string_view placeholder;
  double greatest;  // the largest limit that is accepted
  bool whole;       // the limit is a whole number
  Cure cure;
  Complaint (*unmet)(const Certificate& certificate, double limit);
};

constexpr std::string_view kVolume = "volume";

constexpr std::array kBoundKinds{
    BoundKind{kVolume, "FRACTION", 1, false, Cure::shorter_chords, volume_changed},
    BoundKind{kCrossingsBound, "N", 1e9, true, Cure::shorter_chords, crosses},
    BoundKind{"flipped", "N", 1e9, true, Cure::shorter_chords, is_flipped},
    BoundKind{"min-angle", "DEGREES", 60, false, Cure::more_rounds, is_narrow},
    BoundKind{kDistance, "FRACTION", 1, false, Cure::shorter_chords,
              [](const Certificate& c, double limit) { return is_far("root-mean-square", c.distance_rms, limit); }},
    BoundKind{"distance-max", "FRACTION", 1, false, Cure::shorter_chords,
              [](const Certificate& c, double limit) { return is_far("greatest", c.distance_max, limit); }},
    BoundKind{kNoInvertedCells, "", 0, true, Cure::none, has_inverted_cells},
};

const BoundKind& kind_named(std::string_view name, std::string_view item) {
  const auto* const kind =
      std::find_if(kBoundKinds.begin(), kBoundKinds.end(), [&](const BoundKind& each) { return each.name == name; });
  if (kind == kBoundKinds.end()) {
    throw UsageError(fmt::format("--require: no bound '{}'; choose from {}", item, known_bounds()));
  }
  return *kind;
}

Bound parse_bound(std::string_view item) {
  const std::size_t equals = item.find('=');
  const BoundKind& kind = kind_named(item.substr(0, equals), item);
  Bound bound{std::string(kind.name), 0};
  if (item == kNoInvertedCells) return bound;
  const std::string_view number = equals == std::string_view::npos ? "" : item.substr(equals + 1);
  const char* const end = number.data() + number.size();
  const auto [stop, error] = std::from_chars(number.data(), end, bound.limit);
  const bool good = error == std::errc() && stop == end && bound.limit >= 0 && bound.limit <= kind.greatest &&
                    (!kind.whole || bound.limit == std::floor(bound.limit));
  if (good) return bound;
  throw UsageError(
      fmt::format("--require {}: say {}={}, {}", item, kind.name, kind.placeholder,
                  kind.whole ? "a whole number, 0 or more" : fmt::format("a number from 0 to {:g}", kind.greatest)));
}

// --- requirements

Complaint not_closed(const Measures& m) {
  if (m.faces == 0) return "not closed: it has no faces; give a mesh";
  return complain_if(
      !m.closed(), fmt::format("not closed: {} with one face only; fill the holes", counted(m.boundary_edges, "edge")));
}

Complaint not_manifold(const Measures& m) {
  return complain_if(
      !m.manifold(),
      fmt::format("not manifold: {} with more than two faces, {} where surfaces only touch; split them",
                  counted(m.nonmanifold_edges, "edge"),
                  m.nonmanifold_vertices == 1 ? "1 vertex" : fmt::format("{} vertices", m.nonmanifold_vertices)));
}

Complaint not_oriented(const Measures& m) {
  return complain_if(!m.oriented(), fmt::format("not oriented: {} whose faces disagree about which side is outside; "
                                                "turn some of them over",
                                                counted(m.misoriented_edges, "edge")));
}

Complaint not_one_component(const Measures& m) {
  return complain_if(m.components != 1,
                     fmt::format("{}, not one; join or remove some", counted(m.components, "component")));
}

Complaint intersects(const SelfIntersections& found) {
  return complain_if(found.count > 0, fmt::format("{}{} of triangles intersect; move them apart",
                                                  found.complete ? "" : "more than ", counted(found.count, "pair")));
}

Complaint angle_below(double bound, const std::optional<double>& angle) {
  if (!angle) return "no triangle with an area, so no smallest angle; give a mesh";
  return complain_if(*angle < bound, fmt::format("a triangle has an angle of {:.3g} degrees, less than {}; collapse or "
                                                 "flip its edges",
                                                 *angle, bound));
}

Complaint cells_above(const std::optional<CellCheck>& cells, double CellCheck::*value, double bound, const char* what) {
  if (!cells) return kNoCells;
  return complain_if(!((*cells).*value <= bound),
                     fmt::format("a cell has the {} {:.4g}, more than {}", what, (*cells).*value, bound));
}

struct RequirementKind {
  std::string_view word;
  Complaint (*unmet)(const SurfaceCheck& check, double bound);
  std::string_view number{};  // what follows "="; empty: nothing does
  double most = kInfinity;    // what it may be at most; it is above 0
};

constexpr std::string_view kNoFlipped = "no-flipped";

constexpr std::array kRequirementKinds{
    RequirementKind{"closed", [](const SurfaceCheck& f, double) { return not_closed(f.info.measures); }},
    RequirementKind{"manifold", [](const SurfaceCheck& f, double) { return not_manifold(f.info.measures); }},
    RequirementKind{"oriented", [](const SurfaceCheck& f, double) { return not_oriented(f.info.measures); }},
    RequirementKind{"one-component", [](const SurfaceCheck& f, double) { return not_one_component(f.info.measures); }},
    RequirementKind{"no-self-intersections",
                    [](const SurfaceCheck& f, double) { return intersects(f.self_intersections); }},
    RequirementKind{"no-degenerate",
                    [](const SurfaceCheck& f, double) {
                      const std::size_t count = f.info.measures.degenerate_triangles;
                      return complain_if(count > 0,
                                         fmt::format("{} without area; collapse them", counted(count, "triangle")));
                    }},
    RequirementKind{"no-folded",
                    [](const SurfaceCheck& f, double) {
                      return complain_if(f.folded_edges > 0, fmt::format("the surface is folded at {}; smooth it there",
                                                                         counted(f.folded_edges, "edge")));
                    }},
    RequirementKind{kNoFlipped,
                    [](const SurfaceCheck& f, double) {
                      const std::size_t count = f.flipped_triangles.value_or(0);
                      return complain_if(count > 0, fmt::format("{} flipped; refine the shape or deform it less",
                                                                counted(count, "triangle")));
                    }},
    RequirementKind{
        "min-angle",
        [](const SurfaceCheck& f, double bound) { return angle_below(bound, f.info.measures.smallest_angle_deg); },
        "DEGREES", 60},
    RequirementKind{kNoInvertedCells,
                    [](const SurfaceCheck& f, double) {
                      if (!f.cells) return Complaint(kNoCells);
                      return complain_if(f.cells->inverted > 0,
                                         fmt::format("{} inverted; deform less", counted(f.cells->inverted, "cell")));
                    }},
    RequirementKind{"max-non-orthogonality",
                    [](const SurfaceCheck& f, double bound) {
                      return cells_above(f.cells, &CellCheck::max_non_orthogonality_deg, bound, "non-orthogonality");
                    },
                    "DEGREES", 180},
    RequirementKind{"max-skewness",
                    [](const SurfaceCheck& f, double bound) {
                      return cells_above(f.cells, &CellCheck::max_skewness, bound, "skewness");
                    },
                    "NUMBER"},
    RequirementKind{"max-aspect-ratio",
                    [](const SurfaceCheck& f, double bound) {
                      return cells_above(f.cells, &CellCheck::max_aspect_ratio, bound, "aspect ratio");
                    },
                    "NUMBER"},
};

const RequirementKind* find_kind(std::string_view word) {
  const auto* const kind = std::find_if(kRequirementKinds.begin(), kRequirementKinds.end(),
                                        [&](const RequirementKind& each) { return each.word == word; });
  return kind == kRequirementKinds.end() ? nullptr : kind;
}

Requirement parse_requirement(std::string_view item, bool has_before) {
  const std::size_t equals = item.find('=');
  const std::string_view word = item.substr(0, equals);
  const RequirementKind* const kind = find_kind(word);
  if (kind == nullptr || (equals != std::string_view::npos && kind->number.empty())) {
    throw UsageError(fmt::format("--require: no requirement '{}'; choose from {}", item, known_requirements()));
  }
  if (word == kNoFlipped && !has_before) {
    throw UsageError("--require no-flipped: compares two shapes; give the other with --before FILE");
  }
  Requirement requirement{std::string(word), 0};
  if (!kind->number.empty()) {
    const std::string_view number = equals == std::string_view::npos ? "" : item.substr(equals + 1);
    const char* const end = number.data() + number.size();
    const auto [stop, error] = std::from_chars(number.data(), end, requirement.bound);
    if (error != std::errc() || stop != end || !(requirement.bound > 0 && requirement.bound <= kind->most)) {
      throw UsageError(fmt::format("--require {}: say {}={}, above 0{}", item, word, kind->number,
                                   kind->most < kInfinity ? fmt::format(" and at most {}", kind->most) : ""));
    }
  }
  return requirement;
}

}  // namespace

Certified replay_certified(const Inputs& inputs, const ReplayOptions& options, bool check,
                           const std::vector<Bound>& asked, bool quiet, std::size_t max_points) {
  const std::vector<Bound> bounds =
      check || !asked.empty() ? with_distance(asked, inputs, options) : std::vector<Bound>{};
  Certified certified{{}, {}, options, inputs.session};
  if (bounds.empty()) {
    if (check) {
      certify(inputs.mesh(), quiet, max_points, certified);
    } else {
      certified.result = replay_watched(inputs.mesh(), inputs.session, options, quiet);
    }
    return certified;
  }
  certified.options.frames.count = 0;
  std::optional<std::size_t> crossings;  // of the attempt before
  for (int refinements = 0;; ++refinements) {
    certify(inputs.mesh(), quiet || refinements > 0, max_points, certified);
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
  if (options.frames.count > 0) replay_watched(inputs.mesh(), certified.session, certified.options, true);
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
  if (c.det_least && c.det_greatest) {
    text += fmt::format("volume changed on purpose{}, det J from {:.3g} to {:.3g}; ",
                        c.volume_error ? fmt::format(" by a fraction of {:.3g}", *c.volume_error) : "", *c.det_least,
                        *c.det_greatest);
  } else if (c.volume_error) {
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

std::string known_bounds() {
  std::string names;
  for (const BoundKind& kind : kBoundKinds) {
    names += fmt::format("{}{}{}", names.empty() ? "" : ", ", kind.name,
                         kind.placeholder.empty() ? "" : fmt::format("={}", kind.placeholder));
  }
  return names;
}

std::vector<Bound> parse_bounds(const std::string& list) {
  std::vector<Bound> bounds;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    bounds.push_back(parse_bound(std::string_view(list).substr(begin, end - begin)));
    begin = end + 1;
  }
  return bounds;
}

std::optional<Unmet> unmet(const Bound& bound, const Certificate& certificate) {
  if (bound.name == kVolume && !certificate.volume_error) {
    return Unmet{"the shape has no volume because it is not closed and oriented; leave this bound out"};
  }
  const BoundKind& kind = kind_named(bound.name, bound.name);
  const Complaint complaint = kind.unmet(certificate, bound.limit);
  if (!complaint) return std::nullopt;
  return Unmet{*complaint, kind.cure};
}

std::string known_requirements() {
  std::string words;
  for (const RequirementKind& kind : kRequirementKinds) {
    words += fmt::format("{}{}{}", words.empty() ? "" : ", ", kind.word,
                         kind.number.empty() ? "" : fmt::format("={}", kind.number));
  }
  return words;
}

std::vector<Requirement> parse_requirements(const std::string& list, bool has_before) {
  std::vector<Requirement> requirements;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    requirements.push_back(parse_requirement(std::string_view(list).substr(begin, end - begin), has_before));
    begin = end + 1;
  }
  return requirements;
}

std::optional<std::string> unmet(const Requirement& requirement, const SurfaceCheck& check) {
  return find_kind(requirement.word)->unmet(check, requirement.bound);
}

}  // namespace knead::command
