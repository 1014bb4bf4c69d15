// The document at work: strokes, undo, remeshing, checks.
#include "document/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <exception>
#include <new>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include "gestures/gesture.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::studio {

namespace {

constexpr std::size_t kMeasuredAtOnce = 60'000;  // vertices of a shape whose volume is measured at every step of a drag
constexpr double kMeasuredEvery = 0.3;           // seconds between measurements of a larger one

// Of poor triangles. One among kFewOf deformed ones is not visible.
constexpr double kThinAngle = 5;      // degrees
constexpr double kAngularAngle = 30;  // degrees
constexpr std::size_t kFewOf = 500;
constexpr double kDeformed = 1.1;  // a stretch: less counts as not deformed, as far from a wide stroke

double seconds_since(std::chrono::steady_clock::time_point began) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

bool ends_with_article(std::string_view text) {
  const std::array articles{"a ", "the ", "this ", "its ", "'s ", "same "};
  return std::any_of(articles.begin(), articles.end(), [&](const char* end) { return text.ends_with(end); });
}

bool is_remeshed(const HistoryEntry& entry) {
  return std::all_of(entry.strokes.begin(), entry.strokes.end(),
                     [](const SessionStroke& stroke) { return stroke.remesh.has_value(); });
}

// By the cosines: an angle is below the bound where the cosine is above.
bool has_thin_angle(const std::array<Vec3d, 3>& p) {
  const double bound = std::cos(kThinAngle * std::numbers::pi / 180);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d a = p[(i + 1) % 3] - p[i];
    const Vec3d b = p[(i + 2) % 3] - p[i];
    if (!(dot(a, b) <= bound * norm(a) * norm(b))) return true;
  }
  return false;
}

// Returns whether a triangle is visible as a facet. The normals at its corners have length 1.
bool is_angular(const std::array<Vec3d, 3>& p, const std::array<Vec3d, 3>& normals) {
  const Vec3d normal = cross(p[1] - p[0], p[2] - p[0]);
  const double bound = std::cos(kAngularAngle * std::numbers::pi / 180) * norm(normal);
  return std::any_of(normals.begin(), normals.end(), [&](const Vec3d& n) { return dot(n, normal) < bound; });
}

}  // namespace

std::string word_for_key(std::string key) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 13> words{{{"outer", "radius"},
                                                                                 {"from", "line"},
                                                                                 {"inner", "inner part"},
                                                                                 {"bump", "soft edge"},
                                                                                 {"angle_deg", "angle"},
                                                                                 {"rate_deg", "angle"},
                                                                                 {"width", "border"},
                                                                                 {"max_edge", "longest edge"},
                                                                                 {"detail", "finest motion"},
                                                                                 {"full", "moving set"},
                                                                                 {"zero", "fixed set"},
                                                                                 {"to", "goals"},
                                                                                 {"auto", "automatic radius"}}};
  for (const auto& [from, to] : words) {
    if (key == from) return std::string(to);
  }
  std::replace(key.begin(), key.end(), '_', ' ');
  return key;
}

std::string in_words(const std::string& line) {
  const auto is_in_key = [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; };
  std::string text;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t end = line[at] == '"' ? line.find('"', at + 1) : std::string::npos;
    const std::string key = end == std::string::npos ? "" : line.substr(at + 1, end - at - 1);
    if (key.empty() || !std::all_of(key.begin(), key.end(), is_in_key)) {
      text += line[at++];
      continue;
    }
    const bool has_colon = line.compare(end + 1, 1, ":") == 0;
    const bool is_subject = at == 0 && has_colon;  // what the rest is about
    if (!is_subject) text += (ends_with_article(text) ? "" : "the ") + word_for_key(key) + (has_colon ? " " : "");
    at = end + 1 + (line.compare(end + 1, 2, ": ") == 0 ? 2 : has_colon ? 1 : 0);
  }
  if (text.empty()) return text;
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text.ends_with('.') ? text : text + ".";
}

Document::Document(DocumentOptions options) : options_(std::move(options)) {}

bool Document::guarded(Subject subject, const std::function<void()>& work) const {
  if (subject != Subject::other) options_.tell({false, {}, subject});
  try {
    work();
    return true;
  } catch (const Cancelled&) {
    options_.tell({false, "Stopped."});
  } catch (const std::bad_alloc&) {
    options_.tell({true, "There is not enough memory: close other programs, or open a smaller shape.", subject});
  } catch (const std::exception& error) {
    options_.tell({true, subject == Subject::strokes ? in_words(error.what()) : error.what(), subject});
  }
  return false;
}

void Document::show() {
  ++shown_.version;
  shown_.picker_is_behind = picker_is_stale_;
  options_.show(shown_);
}

void Document::show_state() {
  shown_.state = history_->state();
  shown_.start = history_->base();
  shown_.before_stroke = history_->state_before();
  shown_.looked_at.reset();
  motion_.reset();
  shown_.history = history_->done();
  shown_.redoable = history_->redoable();
  if (!shown_.history.empty()) shown_.live_steps = shown_.history.back()->steps;
  show();
}

void Document::limit_undo_memory(std::size_t bytes) {
  undo_memory_ = bytes;
  if (history_) history_->limit_memory(bytes);
}

void Document::close() {
  if (journal_) journal_->discard();
  journal_.reset();
  history_.reset();
  parameters_.clear();
}

void Document::journal(const LineChange& now) {
  const LineChange change = joined_changes(std::exchange(dragged_lines_, {}), now);
  is_dragging_layers_ = false;
  if (!journal_ || change.empty()) return;
  const auto began = std::chrono::steady_clock::now();
  if (change.undone == 0) {
    journal_->append(change.appended);
  } else if (change.appended.empty()) {
    journal_->undo(change.undone);
  } else {
    journal_->replace(change.undone, change.appended);
  }
  shown_.journal_seconds = seconds_since(began);
  shown_.journal_trouble = journal_->trouble().value_or("");
  shown_.is_changed = true;
}

bool Document::take(const WorkResult& result, const char* what) {
  journal(result.lines);
  return tell_failure(result, what);
}

// Tells why a call failed. Returns true if it succeeded.
bool Document::tell_failure(const WorkResult& result, const char* what) const {
  if (result.is_done()) return true;
  if (!result.refusal.empty()) {
    options_.tell({true, in_words(result.refusal), Subject::strokes});
  } else if (result.status == AdvectStatus::step_limit) {
    options_.tell(
        {true, fmt::format("{}: a point needs too many steps there; make the stroke weaker.", what), Subject::strokes});
  } else {
    options_.tell({false, fmt::format("{}: cancelled.", what)});
  }
  return false;
}

void Document::set_live(std::vector<SessionStroke> strokes, Progress& progress, bool follows) {
  if (!history_) return;
  const bool is_told = guarded([&] {
    const auto began = std::chrono::steady_clock::now();
    const WorkResult result = history_->set_live(std::move(strokes), &progress, follows);
    shown_.live_seconds = seconds_since(began);
    shown_.refusal = in_words(result.refusal);
    shown_.contacts = result.part;
    journal(result.lines);
    volume_is_stale_ = history_->state().positions.size() > kMeasuredAtOnce;
    if (!volume_is_stale_) measure_volume();
    show_state();
  });
  if (!is_told) show();
}

// Tells only the last warning of a stamp that was pressed in pieces: at the start of a piece the surface touches the
// tool at the end of the piece before.
void Document::tell_warnings(const HistoryEntry& entry) const {
  const auto is_stamp = [](const SessionStroke& stroke) { return !file_of(stroke.stroke).empty(); };
  const bool is_pressed = std::all_of(entry.strokes.begin(), entry.strokes.end(), is_stamp);
  const std::vector<std::string>& warnings = entry.notes.warnings;
  const std::size_t first = is_pressed && !warnings.empty() ? warnings.size() - 1 : 0;
  for (std::size_t i = first; i < warnings.size(); ++i) options_.tell({false, in_words(warnings[i])});
}

void Document::finish(Progress& progress) {
  ++shown_.ended;
  if (!history_) return;
  const std::string refusal = std::exchange(shown_.refusal, {});
  const bool is_told = guarded([&] {
    if (!history_->live().empty()) {
      end_gesture(progress);
    } else if (!refusal.empty()) {
      options_.tell({true, refusal, Subject::strokes});
    }
    show_state();
  });
  if (!is_told) show();
}

void Document::end_gesture(Progress& progress) {
  const std::size_t before = history_->done().size();
  if (!take(history_->finish_later(&progress), "The stroke")) journal(history_->set_live({}).lines);
  const auto done = history_->done();
  if (done.size() > before && history_->is_settled()) tell_warnings(*done.back());
  picker_is_stale_ = true;
}

// Completes the postponed work of finished strokes. Returns false if it was stopped. Do not call it during a gesture.
bool Document::settle(Progress& progress) {
  if (history_->is_settled()) return true;
  if (!history_->live().empty()) return false;
  if (options_.name_work) options_.name_work(history_->base().splats ? "Deforming splats" : "Remeshing");
  const auto before = history_->done();
  WorkResult result = history_->settle(&progress);
  journal(result.lines);
  if (!result.refusal.empty()) options_.tell({true, in_words(result.refusal)});
  if (result.status == AdvectStatus::step_limit) {
    options_.tell({true, "A point needs too many steps there; make the stroke weaker."});
  }
  const auto after = history_->done();
  for (std::size_t i = 0; i < after.size(); ++i) {
    const bool is_new = i >= before.size() || before[i] != after[i];
    if (is_new && result.status == AdvectStatus::done) tell_warnings(*after[i]);
  }
  picker_is_stale_ = true;
  show_state();
  return history_->is_settled();
}

void Document::give_up(Progress& progress) {
  ++shown_.ended;
  set_live({}, progress);
}

void Document::undo(Progress& progress) {
  if (!history_) return;
  guarded([&] {
    take(history_->undo(&progress), "Undo");
    picker_is_stale_ = true;
    show_state();
  });
}

void Document::redo(Progress& progress) {
  if (!history_) return;
  guarded([&] {
    take(history_->redo(&progress), "Redo");
    picker_is_stale_ = true;
    show_state();
  });
}

void Document::arrange(const LayerChange& change, bool is_step, Progress& progress) {
  Layers layers;
  for (const auto& entry : history_->done()) layers.push_back(entry->strokes);
  change(layers);
  WorkResult result = history_->arrange(layers, is_step && is_dragging_layers_, &progress);
  if (is_step) {
    if (!tell_failure(result, "The change")) return;
    dragged_lines_ = joined_changes(std::move(dragged_lines_), std::move(result.lines));
    is_dragging_layers_ = is_dragging_layers_ || !dragged_lines_.empty();
    shown_.is_changed = shown_.is_changed || is_dragging_layers_;
  } else {
    take(result, "The change");
  }
  picker_is_stale_ = true;
  show_state();
}

void Document::change_layers(const LayerChange& change, Progress& progress) {
  if (!history_) return;
  guarded([&] { arrange(change, false, progress); });
}

void Document::drag_layers(const LayerChange& change, Progress& progress) {
  if (!history_) return;
  guarded([&] { arrange(change, true, progress); });
}

// Giving a drag up takes no work that could be cancelled, because the states before it are known.
void Document::end_layer_drag(bool is_kept) {
  if (!history_ || !is_dragging_layers_) return;
  guarded([&] {
    journal(is_kept ? LineChange{} : history_->undo().lines);
    picker_is_stale_ = true;
    show_state();
  });
}

void Document::look_at(std::optional<std::size_t> entries, Progress& progress) {
  if (!history_) return;
  guarded([&] {
    if (!entries || *entries >= history_->done().size()) {
      show_state();
      return;
    }
    const std::optional<ShapeState> state = history_->state_after(*entries, &progress);
    if (!state) return;
    shown_.state = *state;
    shown_.looked_at = entries;
    show();
  });
}

void Document::measure_volume() {
  if (!is_measurable_) return;
  shown_.volume = measure_volume_and_area(*history_->state().mesh, history_->state().positions.copy()).volume;
}

// Measures when there is no other work, not at every step of a drag.
void Document::measure_large_volume() {
  if (!volume_is_stale_ || seconds_since(measured_) < kMeasuredEvery) return;
  volume_is_stale_ = false;
  measured_ = std::chrono::steady_clock::now();
  measure_volume();
  show();
}

void Document::count_poor_triangles() {
  shown_.poor_triangles = 0;
  const std::vector<std::shared_ptr<const HistoryEntry>> done = history_->done();
  const std::optional<ShapeState> before = history_->state_before();
  const ShapeState& now = history_->state();
  if (done.empty() || is_remeshed(*done.back()) || !before || before->mesh != now.mesh) return;
  const std::vector<IndexRange> changes = now.positions.changes_since(before->positions);
  std::vector<bool> moved(now.positions.size());
  for (const IndexRange& range : changes) std::fill(moved.begin() + range.begin, moved.begin() + range.end, true);
  const std::vector<Vec3d> after = now.positions.copy();
  const std::vector<Vec3d> old = before->positions.copy();
  const std::vector<Vec3d> normals = vertex_normals(*now.mesh, after, moved);
  const std::vector<Vec3d> old_normals = vertex_normals(*now.mesh, old, moved);
  std::size_t deformed = 0;
  for_each_triangle(*now.mesh, after, [&](const Triangle& t) {
    if (!moved[t[0]] && !moved[t[1]] && !moved[t[2]]) return;
    const auto at = [&](const std::vector<Vec3d>& from) { return std::array{from[t[0]], from[t[1]], from[t[2]]}; };
    const std::array<Vec3d, 3> here = at(after);
    const std::array<Vec3d, 3> there = at(old);
    const double stretch = triangle_stretch(there, here).value_or(1);
    if (stretch > kDeformed) ++deformed;
    const bool is_stretched = stretch > kStrongStretch;
    const bool is_thin = has_thin_angle(here) && !has_thin_angle(there);
    const bool is_facet = is_angular(here, at(normals)) && !is_angular(there, at(old_normals));
    if (is_stretched || is_thin || is_facet) ++shown_.poor_triangles;
  });
  if (shown_.poor_triangles * kFewOf < deformed) shown_.poor_triangles = 0;
}

// A stroke that took long is not applied again for this.
void Document::find_coarse(Progress& progress) {
  constexpr double kMissed = 0.25;
  constexpr double kMaxSeconds = 1;
  const std::vector<std::shared_ptr<const HistoryEntry>> done = history_->done();
  if (done.empty() || done.back()->seconds > kMaxSeconds) return;
  shown_.is_coarse = history_->missed_motion(&progress) > kMissed;
  if (shown_.is_coarse) show();
}

void Document::when_idle(Progress& progress) {
  if (!history_) return;
  if (!picker_is_stale_ && history_->is_settled()) return measure_large_volume();
  guarded(Subject::other, [&] {
    if (picker_is_stale_) get_ready(progress);
    const bool was_settled = history_->is_settled();
    if (settle(progress) && !was_settled) get_ready(progress);
  });
}

void Document::get_ready(Progress& progress) {
  picker_is_stale_ = false;
  history_->prepare();
  measure_volume();
  count_poor_triangles();
  shown_.is_coarse = false;
  if (journal_) journal_->sync();
  shown_.picker = pickers_.make(history_->state(), met_faces(shown_.objects, history_->state()));
  show();
  find_coarse(progress);
}

void Document::count_crossings(Progress& progress) {
  if (!history_) return;
  guarded(Subject::other, [&] {
    if (!settle(progress)) throw Cancelled();
    const ShapeState& state = history_->state();
    SelfIntersectionOptions options;
    options.threads = options_.threads;
    options.progress = &progress;
    const SelfIntersections found =
        self_intersections(triangulate(WeldedMesh(*state.mesh).mesh()), state.positions.copy(), options);
    std::string text =
        found.count == 1 ? "1 pair of triangles crosses" : fmt::format("{} pairs of triangles cross", found.count);
    if (shown_.objects.joined != nullptr && found.complete) {
      std::vector<std::uint32_t> sources = triangle_faces(*state.mesh);
      for (std::uint32_t& face : sources) {
        if (state.provenance != nullptr) face = state.provenance->face_source[face];
      }
      text += fmt::format(", {} between objects", count_between(found, *shown_.objects.joined, sources));
    }
    options_.tell({false, text + "."});
  });
}

std::shared_ptr<const ZoneProfile> Document::profile(const ToolSettings& settings, const Placement& placement) const {
  return history_ ? profile_at(settings, placement, history_->state()) : nullptr;
}

Placement Document::with_limit_cylinder(const Placement& placement, bool bends, bool may_turn,
                                        const Progress& progress) const {
  Placement result = placement;
  result.limit_cylinder.emplace();
  result.limit_cylinder->problem = "No shape is open.";
  if (!history_ || !shown_.picker) return result;
  const ShapeState& state = history_->state();
  const std::vector<Vec3d> positions = state.positions.copy();
  // After remeshing, the picker is that of the mesh before until there is time for another.
  const bool fits = shown_.picker->fits(state);
  const std::vector<Triangle> triangles = fits ? shown_.picker->triangles() : triangulate(*state.mesh);
  return on_part(placement, bends, may_turn, positions, triangles, &progress);
}

}  // namespace knead::studio
