// The workbench of an editor: the current gesture, the history with its states, undo and redo.
#include <algorithm>
#include <chrono>
#include <utility>

#include "history/history.h"
#include "knead/editor/tools.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/replay.h"
#include "session/deformed_shape_detail.h"
#include "session/replay_detail.h"
#include "session/stroke_run.h"
#include "strokes/describe.h"
#include "strokes/pose.h"

namespace knead {

namespace {

using namespace detail;

constexpr std::size_t kNearStates = 100;    // next to the present entry, dropped last
constexpr std::size_t kFarStates = 16;      // farther away, from which dropped ones are computed again
constexpr double kThinnedFraction = 0.875;  // of the limit, so that states are not dropped after every stroke

double seconds_since(std::chrono::steady_clock::time_point began) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

std::vector<SessionStroke> without_remesh(std::vector<SessionStroke> strokes) {
  for (SessionStroke& stroke : strokes) stroke.remesh = std::nullopt;
  return strokes;
}

bool is_remeshed(const std::vector<SessionStroke>& strokes) {
  return std::any_of(strokes.begin(), strokes.end(), [](const SessionStroke& s) { return s.remesh.has_value(); });
}

// Returns about the amount by which applying the strokes to a shape of this size raises Progress::done.
std::uint64_t work_of(const std::vector<SessionStroke>& strokes, const ShapeState& shape) {
  std::uint64_t segments = 0;
  for (const SessionStroke& stroke : strokes) segments += detail::segments_of(stroke.stroke);
  return segments * shape.positions.size();
}

std::shared_ptr<const Mesh> checked(Mesh mesh) {
  if (mesh.vertex_count() == 0) throw InvalidInput("the shape has no vertices; open another one");
  return std::make_shared<const Mesh>(std::move(mesh));
}

MotionOptions on_threads(int threads) {
  MotionOptions motion;
  motion.threads = threads;
  return motion;
}

DeformedShape with_splats(DeformedShape shape) {
  const Mesh* const mesh = &shape.mesh();
  std::vector<IndexRange> splats = splats_among({&mesh, 1});
  if (!splats.empty()) shape.carry_splats(std::move(splats));
  return shape;
}

}  // namespace

Workbench::Workbench(Mesh mesh, std::filesystem::path folder, std::vector<std::uint32_t> face_labels, int threads)
    : folder_(std::move(folder)),
      shape_(with_splats(
          DeformedShape(checked(std::move(mesh)), on_threads(threads), {std::nullopt, std::move(face_labels)}))),
      base_(shape_.state()),
      at_(base_),
      live_state_(base_),
      account_(std::make_shared<MemoryAccount>(base_)) {}

const ShapeState& Workbench::last_state() const { return now_.empty() ? base_ : now_.back()->after->state(); }

void Workbench::limit_memory(std::size_t bytes) {
  memory_ = bytes;
  thin_out(now_.size());
}

UndoMemory Workbench::undo_memory() const { return {account_->bytes(), account_->states()}; }

void Workbench::keep(Entry& entry, const ShapeState& state) {
  entry.after = std::make_shared<const KeptState>(state, account_);
}

void Workbench::go_to(const ShapeState& state, bool again) {
  const bool is_kept = kept_ && kept_->state.is_same(state);
  if (!at_ || !at_->is_same(state)) {
    if (is_kept) {
      shape_ = kept_->shape;
    } else {
      shape_.restore(state);
      if (again) shape_.prepare();
    }
    at_ = state;
  }
  if (again && !is_kept) kept_ = Kept{state, shape_};
}

// Does the work on the shape, beginning at a state. A refusal before anything moved leaves the shape at that state.
template <class Work>
WorkResult Workbench::compute(const ShapeState& from, bool again, const Work& work) {
  const ShapeState shared = again ? state() : from;  // shares most with the next one
  go_to(from, again);
  const AdvectResult before = shape_.work();
  const std::uint64_t dabs = shape_.dabs();
  WorkResult result;
  try {
    result.status = work();
    at_.reset();
  } catch (const InvalidInput& error) {
    if (shape_.work().evaluations != before.evaluations || shape_.dabs() != dabs) at_.reset();
    result.refusal = error.what();
  }
  steps_ += shape_.work().accepted_steps - before.accepted_steps;
  if (result.is_done()) at_ = shape_.state(shared);
  return result;
}

AdvectStatus Workbench::apply(std::span<const SessionStroke> strokes, Progress* progress) {
  for (const SessionStroke& stroke : strokes) {
    StrokeOutcome outcome = shape_.apply(stroke, folder_, progress);
    if (!outcome.shortfall.empty()) notes_.shortfall = std::move(outcome.shortfall);
    notes_.reached = std::min(notes_.reached, outcome.reached);
    for (std::string& warning : outcome.warnings) {  // each piece of a growing stroke may give the same
      if (std::find(notes_.warnings.begin(), notes_.warnings.end(), warning) == notes_.warnings.end()) {
        notes_.warnings.push_back(std::move(warning));
      }
    }
    if (reads_surface(stroke.stroke) && !outcome.parts.empty()) part_ = std::move(outcome.parts.back().stroke);
    if (outcome.status != AdvectStatus::done) return outcome.status;
  }
  return AdvectStatus::done;
}

struct Workbench::Following {
  PoseDrag drag;
  ShapeState state;      // after its last step
  bool is_torn = false;  // the next step would tear the shape, which stays
};

// Continues the drag of a pose, or begins one.
WorkResult Workbench::follow(const PoseStroke& pose, Progress* progress) {
  constexpr double kMaxSteps = 3;
  constexpr double kMaxStretch = 8;  // of a triangle: more is not shown, and what follows is that of the whole pose
  const bool goes_on = following_ && following_->drag.takes(pose);
  std::shared_ptr<Following> following = std::exchange(following_, nullptr);
  const ShapeState from = goes_on ? following->state : last_state();
  WorkResult result = compute(from, !goes_on && !live_.empty(), [&] {
    AdvectStatus status = AdvectStatus::done;
    shape_.hold_splats(true);
    try {
      if (!goes_on) {
        LiveSurface surface;
        surface.positions = shape_.positions();
        surface.triangles = shape_.triangles();
        surface.progress = progress;
        following = std::make_shared<Following>(Following{PoseDrag(pose, surface, shape_.motion().threads), {}});
      }
      if (following->is_torn) return status;
      following->drag.advance(pose, goes_on ? kMaxSteps : kInfinity, [&](const Stroke& part) {
        status = shape_.move(masked(flow_of(part), shape_.mask()), progress);
        return status == AdvectStatus::done;
      });
      const std::vector<Vec3d> start = last_state().positions.copy();
      following->is_torn = status == AdvectStatus::done && shape_.positions().size() == start.size() &&
                           surface_stretch(shape_.triangles(), start, shape_.positions()).worst() > kMaxStretch;
      if (following->is_torn) shape_.restore(from);
    } catch (const Cancelled&) {
      status = AdvectStatus::cancelled;
    }
    return status;
  });
  if (!result.is_done()) return result;
  following->state = *at_;
  following_ = std::move(following);
  return result;
}

WorkResult Workbench::apply_change(const StrokeDelta& change, const std::vector<SessionStroke>& strokes,
                                   Progress* progress) {
  return compute(change.from_start ? last_state() : state(), change.from_start && !live_.empty(), [&] {
    shape_.hold_splats(true);
    const AdvectStatus status =
        change.rest ? shape_.move(masked(*change.rest, shape_.mask()), progress) : AdvectStatus::done;
    if (status != AdvectStatus::done) return status;
    std::vector<SessionStroke> added =
        without_remesh({strokes.begin() + static_cast<std::ptrdiff_t>(change.first_new), strokes.end()});
    if (change.rest_as_line && !change.rest) added.insert(added.begin(), {*change.rest_as_line});
    return apply(added, progress);
  });
}

WorkResult Workbench::set_live(std::vector<SessionStroke> strokes, Progress* progress, bool follows) {
  WorkResult result;
  if (strokes.empty()) {
    result.lines.undone = std::exchange(live_lines_, 0);
    live_.clear();
    following_.reset();
    is_approximate_ = false;
    return result;
  }
  follows = follows && strokes.size() == 1 && is_plain(strokes.front()) &&
            std::holds_alternative<PoseStroke>(strokes.front().stroke);
  const StrokeDelta change =
      follows || is_approximate_ ? StrokeDelta{true, 0, std::nullopt, std::nullopt} : stroke_delta(live_, strokes);
  const auto began = std::chrono::steady_clock::now();
  const std::uint64_t steps = steps_;
  part_.reset();
  StrokeNotes notes_before = change.from_start ? std::exchange(notes_, {}) : notes_;
  if (follows) {
    result = follow(std::get<PoseStroke>(strokes.front().stroke), progress);
  } else {
    result = apply_change(change, strokes, progress);
  }
  if (!result.is_done()) {
    notes_ = std::move(notes_before);
    return result;
  }
  is_approximate_ = follows;
  if (live_.empty() || change.from_start) live_seconds_ = 0;
  if (live_.empty()) live_steps_ = steps;
  live_state_ = *at_;
  live_seconds_ += seconds_since(began);
  result.lines = live_lines(change, strokes);
  result.part = std::move(part_);
  live_ = std::move(strokes);
  return result;
}

void Workbench::prepare() {
  go_to(state());
  shape_.prepare();
}

WorkResult Workbench::finish(Progress* progress) {
  if (live_.empty()) return {};
  WorkResult result;
  if (!is_settled()) {
    LineChange lines = finish_later(progress).lines;
    result = settle(progress);
    result.lines = joined_changes(std::move(lines), std::move(result.lines));
    return result;
  }
  std::vector<SessionStroke> joined = joined_strokes(live_);
  if (!is_remeshed(joined) && !is_approximate_ && !shape_.splats()) return finish_later(progress);
  auto entry = std::make_shared<Entry>();
  result = make_entry(joined, last_state(), *entry, progress);
  if (!result.is_done()) return result;
  result.lines = {live_lines_, lines_of(now_.size(), joined)};
  const std::size_t lines = joined.size();
  add_finished(std::move(joined), std::move(entry), lines);
  return result;
}

WorkResult Workbench::finish_later(Progress* /*progress*/) {
  if (live_.empty()) return {};
  WorkResult result;
  auto entry = std::make_shared<Entry>();
  std::vector<SessionStroke> joined = joined_strokes(live_);
  std::size_t lines = live_lines_;
  if (is_remeshed(joined)) {
    result.lines = {live_lines_, lines_of(now_.size(), joined)};
    lines = joined.size();
  }
  entry->is_provisional = !is_settled() || is_remeshed(joined) || is_approximate_ || shape_.splats();
  keep(*entry, live_state_);
  entry->info.seconds = live_seconds_;
  entry->info.steps = steps_ - live_steps_;
  entry->info.notes = std::exchange(notes_, {});
  add_finished(std::move(joined), std::move(entry), lines);
  return result;
}

// Makes the gesture an entry, which has `lines` lines of the session file.
void Workbench::add_finished(std::vector<SessionStroke> strokes, std::shared_ptr<Entry> entry, std::size_t lines) {
  entry->info.strokes = std::move(strokes);
  live_.clear();
  following_.reset();
  is_approximate_ = false;
  live_lines_ = 0;
  change_to({now_.size(), {std::move(entry)}});
  lines_.back() = lines;
}

WorkResult Workbench::settle(Progress* progress) {
  WorkResult result;
  if (is_settled()) return result;
  while (!now_.empty()) {
    std::string refusal;
    if (make_state(now_.size(), progress, &refusal)) break;
    if (refusal.empty()) {
      result.status = AdvectStatus::cancelled;
      break;
    }
    result.refusal = refusal;
    result.lines = joined_changes(std::move(result.lines), remove_refused());
  }
  return result;
}

// Removes the first provisional entry. Changes since it was added have added one entry each: edits settle first.
LineChange Workbench::remove_refused() {
  const auto refused = std::find_if(now_.begin(), now_.end(), [](const auto& entry) { return entry->is_provisional; });
  const auto index = static_cast<std::size_t>(refused - now_.begin());
  const auto later = static_cast<std::ptrdiff_t>(now_.size() - index);
  exchange({index, {refused + 1, now_.end()}});
  for (auto change = undo_.erase(undo_.end() - later); change != undo_.end(); ++change) --change->common;
  redo_.clear();
  return lines_from(index);
}

double Workbench::missed_motion(Progress* progress) const {
  const std::optional<ShapeState> before = state_before();
  if (!live_.empty() || now_.empty() || !before || is_remeshed(now_.back()->info.strokes)) return 0;
  DeformedShape shape = shape_;
  shape.restore(*before);
  detail::ExactImage image(std::make_shared<const Mesh>(shape.to_mesh()), shape.provenance());
  try {
    for (const SessionStroke& stroke : now_.back()->info.strokes) {
      detail::StrokeRun run(detail::prepare_stroke(stroke, folder_), {}, shape, progress);
      run.begin();
      run.finish();
      if (run.status() != AdvectStatus::done) return 0;
      image.add(run, shape);
    }
    return image.missed_motion(shape, progress);
  } catch (const InvalidInput&) {
    return 0;  // a file of the stroke is not there any more
  } catch (const Cancelled&) {
    return 0;
  }
}

WorkResult Workbench::undo(Progress* progress) {
  if (!live_.empty()) return set_live({}, progress);
  return undo_.empty() ? WorkResult{} : step(undo_, redo_, progress);
}

WorkResult Workbench::redo(Progress* progress) {
  LineChange given_up = set_live({}, progress).lines;
  if (redo_.empty()) return {AdvectStatus::done, {}, std::move(given_up), {}};
  WorkResult result = step(redo_, undo_, progress);
  result.lines.undone += given_up.undone;
  return result;
}

WorkResult Workbench::append(const std::vector<SessionStroke>& strokes, Progress* progress) {
  WorkResult result = set_live({}, progress);
  if (WorkResult settled = settle(progress); !settled.is_done()) {
    settled.lines.undone += result.lines.undone;
    return settled;
  }
  for (const std::vector<SessionStroke>& group : strokes_of_gestures(strokes)) {
    Change next{now_.size(), {}};
    WorkResult added = make_rest({joined_strokes(group)}, next, progress);
    result.status = added.status;
    result.refusal = std::move(added.refusal);
    if (!result.is_done()) return result;
    const LineChange change = change_to(std::move(next));
    result.lines.appended.insert(result.lines.appended.end(), change.appended.begin(), change.appended.end());
  }
  return result;
}

std::optional<ShapeState> Workbench::state_before() const {
  if (!live_.empty()) return last_state();
  if (now_.empty()) return std::nullopt;
  if (now_.size() == 1) return base_;
  const auto& kept = now_[now_.size() - 2]->after;
  return kept ? std::optional(kept->state()) : std::nullopt;
}

std::optional<ShapeState> Workbench::state_after(std::size_t entries, Progress* progress) {
  return make_state(std::min(entries, now_.size()), progress);
}

// Computes the state after `count` entries, and all states since the nearest kept one, which undo is likely to need
// next. Returns nothing if it was cancelled, or if a provisional entry cannot be applied: then `refusal` says why.
std::optional<ShapeState> Workbench::make_state(std::size_t count, Progress* progress, std::string* refusal) {
  return make_state(now_, count, progress, refusal);
}

std::optional<ShapeState> Workbench::make_state(History& history, std::size_t count, Progress* progress,
                                                std::string* refusal) {
  std::size_t known = count;
  while (known > 0 && (history[known - 1]->is_provisional || !history[known - 1]->after)) --known;
  ShapeState state = known == 0 ? base_ : history[known - 1]->after->state();
  std::uint64_t ahead = 0;
  for (std::size_t i = known; i < count; ++i) ahead += work_of(history[i]->info.strokes, base_);
  const bool is_one = count - known == 1;  // counts its own steps
  ScopedProgress counted(is_one ? nullptr : progress, ahead);
  for (; known < count; ++known) {
    auto made = std::make_shared<Entry>();
    const WorkResult result = make_entry(history[known]->info.strokes, state, *made, progress);
    if (!result.is_done()) {
      if (refusal != nullptr) *refusal = result.refusal;
      return std::nullopt;
    }
    state = made->after->state();
    counted.add(work_of(made->info.strokes, base_));
    if (history[known]->is_provisional) {
      history[known] = std::move(made);  // other threads may read the old one
    } else {
      history[known]->after = std::move(made->after);
    }
    thin_out(&history == &now_ ? known + 1 : now_.size());
  }
  return state;
}

std::vector<SessionStroke> Workbench::strokes() const {
  std::vector<SessionStroke> all;
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const std::vector<SessionStroke> own = lines_of(i, now_[i]->info.strokes);
    all.insert(all.end(), own.begin(), own.end());
  }
  const std::vector<SessionStroke> live = lines_of(now_.size(), joined_strokes(without_remesh(live_)));
  all.insert(all.end(), live.begin(), live.end());
  return all;
}

std::vector<std::shared_ptr<const HistoryEntry>> Workbench::done() const {
  std::vector<std::shared_ptr<const HistoryEntry>> result;
  for (const auto& entry : now_) result.emplace_back(entry, &entry->info);
  return result;
}

std::vector<std::shared_ptr<const HistoryEntry>> Workbench::redoable() const {
  std::vector<std::shared_ptr<const HistoryEntry>> result;
  std::size_t size = now_.size();
  for (auto change = redo_.rbegin(); change != redo_.rend() && change->common + change->rest.size() > size; ++change) {
    size = change->common + change->rest.size();
    result.emplace_back(change->rest.back(), &change->rest.back()->info);
  }
  return result;
}

// The strokes of the entry with this number, as a session holds them.
std::vector<SessionStroke> Workbench::lines_of(std::size_t index, std::vector<SessionStroke> strokes) const {
  return strokes_of_entry(index == 0 ? std::vector<SessionStroke>{} : now_[index - 1]->info.strokes,
                          std::move(strokes));
}

LineChange Workbench::live_lines(const StrokeDelta& change, const std::vector<SessionStroke>& strokes) {
  LineChange lines;
  if (change.from_start) lines.undone = live_lines_;
  if (change.rest_as_line) {
    lines.appended.push_back(*change.rest_as_line);
    if (strokes[change.first_new - 1].remesh) {  // recover_journal joins the pieces, to be remeshed as one stroke
      lines.appended.back().remesh = strokes[change.first_new - 1].remesh;
      lines.appended.back().new_entry = false;
    }
  }
  std::size_t first = change.first_new;
  if (change.rest && !change.rest_as_line) {
    lines.undone = 1;
    --first;
  }
  if (first < strokes.size()) {
    const std::vector<SessionStroke> marked = lines_of(now_.size(), strokes);
    lines.appended.insert(lines.appended.end(), marked.begin() + static_cast<std::ptrdiff_t>(first), marked.end());
  }
  live_lines_ = live_lines_ - lines.undone + lines.appended.size();
  return lines;
}

// Applies the strokes, with their remesh settings, to a state.
WorkResult Workbench::make_entry(const std::vector<SessionStroke>& strokes, const ShapeState& from, Entry& entry,
                                 Progress* progress) {
  const auto began = std::chrono::steady_clock::now();
  const std::uint64_t steps = steps_;
  notes_ = {};
  WorkResult result = compute(from, false, [&] {
    shape_.hold_splats(false);
    return apply(strokes, progress);
  });
  if (!result.is_done()) return result;
  keep(entry, *at_);
  entry.info = {strokes, seconds_since(began), steps_ - steps, std::exchange(notes_, {})};
  return result;
}

// Makes the entries that come after the common ones.
WorkResult Workbench::make_rest(const std::vector<std::vector<SessionStroke>>& gestures, Change& change,
                                Progress* progress) {
  std::optional<ShapeState> state = make_state(change.common, progress);
  if (!state) return {AdvectStatus::cancelled, {}, {}, {}};
  std::uint64_t ahead = 0;
  for (const std::vector<SessionStroke>& strokes : gestures) ahead += work_of(strokes, base_);
  ScopedProgress counted(progress, ahead);
  for (const std::vector<SessionStroke>& strokes : gestures) {
    auto entry = std::make_shared<Entry>();
    WorkResult result = make_entry(strokes, *state, *entry, progress);
    if (!result.is_done()) return result;
    counted.add(work_of(strokes, base_));
    state = entry->after->state();
    change.rest.push_back(std::move(entry));
  }
  return {};
}

Workbench::Change Workbench::change_between(const History& from, const History& to) {
  const auto differ = std::mismatch(from.begin(), from.end(), to.begin(), to.end());
  return {static_cast<std::size_t>(differ.first - from.begin()), {differ.second, to.end()}};
}

// Changes the history; returns the change that undoes this.
Workbench::Change Workbench::exchange(Change change) {
  const auto end = now_.begin() + static_cast<std::ptrdiff_t>(change.common);
  Change back{change.common, {end, now_.end()}};
  now_.resize(change.common);
  now_.insert(now_.end(), change.rest.begin(), change.rest.end());
  return back;
}

// Moves the last change from `from` to `to`, inverted, and applies it.
WorkResult Workbench::step(std::vector<Change>& from, std::vector<Change>& to, Progress* progress) {
  Change back = exchange(from.back());
  const bool is_known = now_.empty() || now_.back()->after;  // perhaps provisional
  if (!is_known && !make_state(now_.size(), progress)) {
    exchange(std::move(back));
    return {AdvectStatus::cancelled, {}, {}, {}};
  }
  WorkResult result;
  result.lines = lines_from(back.common);
  to.push_back(std::move(back));
  from.pop_back();
  return result;
}

// Returns the change of the session file's lines for the entries from a number on, and updates lines_.
LineChange Workbench::lines_from(std::size_t common) {
  LineChange change;
  for (std::size_t i = common; i < lines_.size(); ++i) change.undone += lines_[i];
  lines_.resize(common);
  for (std::size_t i = common; i < now_.size(); ++i) {
    const std::vector<SessionStroke> strokes = lines_of(i, now_[i]->info.strokes);
    change.appended.insert(change.appended.end(), strokes.begin(), strokes.end());
    lines_.push_back(strokes.size());
  }
  return change;
}

LineChange Workbench::change_to(Change change) {
  const std::size_t common = change.common;
  undo_.push_back(exchange(std::move(change)));
  redo_.clear();
  thin_out(now_.size());
  return lines_from(common);
}

// Returns the entries with states that may be dropped, the farthest from the present entry first. The distance is the
// number of steps of undo or redo.
std::vector<Workbench::Entry*> Workbench::kept_entries(std::size_t present) const {
  std::vector<std::pair<std::size_t, Entry*>> by_distance;
  const auto add = [&](const std::shared_ptr<Entry>& entry, std::size_t distance) {
    if (entry->after && (now_.empty() || entry != now_.back())) by_distance.emplace_back(distance, entry.get());
  };
  for (std::size_t i = 0; i < now_.size(); ++i) {
    if (i + 1 != present) add(now_[i], i + 1 < present ? present - i - 1 : i + 1 - present);
  }
  for (const std::vector<Change>* changes : {&undo_, &redo_}) {
    for (std::size_t i = 0; i < changes->size(); ++i) {
      const History& rest = (*changes)[i].rest;
      for (std::size_t k = 0; k < rest.size(); ++k) add(rest[k], changes->size() - i + rest.size() - 1 - k);
    }
  }
  std::stable_sort(by_distance.begin(), by_distance.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Entry*> entries;
  entries.reserve(by_distance.size());
  for (const auto& [distance, entry] : by_distance) entries.push_back(entry);
  return entries;
}

// Drops every second state that is not near the present, but keeps some to start from; then nearer ones; at last all
// but the present one.
void Workbench::thin_out(std::size_t present) {
  if (account_->bytes() <= memory_) return;
  const auto limit = static_cast<std::size_t>(kThinnedFraction * static_cast<double>(memory_));
  for (std::size_t near = kNearStates; account_->bytes() > limit; near /= 2) {
    const std::size_t kept = near > 0 ? near + kFarStates : 0;
    std::vector<Entry*> entries = kept_entries(present);
    while (entries.size() > kept && account_->bytes() > limit) {
      for (std::size_t i = 0; i < entries.size() - near && account_->bytes() > limit; i += 2) entries[i]->after.reset();
      std::erase_if(entries, [](const Entry* entry) { return entry->after == nullptr; });
    }
    if (near == 0) return;
  }
}

}  // namespace knead
