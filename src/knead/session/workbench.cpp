#include "knead/session/workbench.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <unordered_set>
#include <utility>

#include "knead/math/error.h"

namespace knead {

namespace {

constexpr std::size_t kKeptStates = 8;  // of the latest entries, whatever they take

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

std::shared_ptr<const Mesh> checked(Mesh mesh) {
  if (mesh.vertex_count() == 0) throw InvalidInput("the shape has no vertices; open another one");
  return std::make_shared<const Mesh>(std::move(mesh));
}

MotionOptions on_threads(int threads) {
  MotionOptions motion;
  motion.threads = threads;
  return motion;
}

}  // namespace

Workbench::Workbench(Mesh mesh, std::filesystem::path folder, std::vector<std::uint32_t> face_labels, int threads)
    : folder_(std::move(folder)),
      shape_(checked(std::move(mesh)), on_threads(threads), {std::nullopt, std::move(face_labels)}),
      base_(shape_.state()),
      at_(base_),
      live_state_(base_) {}

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

// Does the work on the shape from a state on. A refusal that came before anything moved leaves the shape there.
template <class Work>
WorkResult Workbench::compute(const ShapeState& from, bool again, const Work& work) {
  const ShapeState shared = again ? state() : from;  // the latest, which the next is most like
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
    std::move(outcome.warnings.begin(), outcome.warnings.end(), std::back_inserter(warnings_));
    if (reads_surface(stroke.stroke) && !outcome.parts.empty()) part_ = std::move(outcome.parts.back().stroke);
    if (outcome.status != AdvectStatus::done) return outcome.status;
  }
  return AdvectStatus::done;
}

WorkResult Workbench::set_live(std::vector<SessionStroke> strokes, Progress* progress) {
  WorkResult result;
  if (strokes.empty()) {
    result.lines.taken_back = std::exchange(live_lines_, 0);
    live_.clear();
    return result;
  }
  const GestureChange change = gesture_change(live_, strokes);
  const auto began = std::chrono::steady_clock::now();
  const std::uint64_t steps = steps_;
  part_.reset();
  result = compute(change.from_start ? last_state() : state(), change.from_start && !live_.empty(), [&] {
    const AdvectStatus status = change.rest ? shape_.move(*change.rest, progress) : AdvectStatus::done;
    if (status != AdvectStatus::done) return status;
    std::vector<SessionStroke> added =
        without_remesh({strokes.begin() + static_cast<std::ptrdiff_t>(change.first_new), strokes.end()});
    if (change.rest_as_line && !change.rest) added.insert(added.begin(), {*change.rest_as_line});
    return apply(added, progress);
  });
  if (!result.is_done()) return result;
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
  auto entry = std::make_shared<Entry>();
  std::vector<SessionStroke> joined = joined_strokes(live_);
  std::size_t lines = live_lines_;
  if (is_remeshed(joined)) {
    result = make_entry(joined, last_state(), *entry, progress);
    if (!result.is_done()) return result;
    result.lines = {live_lines_, joined};
    lines = joined.size();
  } else {
    entry->after = live_state_;
    entry->info.seconds = live_seconds_;
    entry->info.steps = steps_ - live_steps_;
    entry->info.warnings = std::exchange(warnings_, {});
    entry->bytes = live_state_.positions.bytes_beyond(last_state().positions);
  }
  entry->info.strokes = std::move(joined);
  History next = now_;
  next.push_back(std::move(entry));
  live_.clear();
  live_lines_ = 0;
  change_to(std::move(next));
  lines_.push_back(lines);
  return result;
}

WorkResult Workbench::undo(Progress* progress) {
  if (!live_.empty()) return set_live({}, progress);
  return undo_.empty() ? WorkResult{} : step(undo_, redo_, progress);
}

WorkResult Workbench::redo(Progress* progress) {
  LineChange given_up = set_live({}, progress).lines;
  if (redo_.empty()) return {AdvectStatus::done, {}, std::move(given_up), {}};
  WorkResult result = step(redo_, undo_, progress);
  result.lines.taken_back += given_up.taken_back;
  return result;
}

WorkResult Workbench::edit(std::size_t index, std::vector<SessionStroke> strokes, Progress* progress) {
  if (index >= now_.size()) throw std::out_of_range("there is no such entry in the history");
  const std::size_t given_up = set_live({}, progress).lines.taken_back;
  History next(now_.begin(), now_.begin() + static_cast<std::ptrdiff_t>(index));
  std::vector<std::vector<SessionStroke>> anew;
  if (!strokes.empty()) anew.push_back(std::move(strokes));
  for (std::size_t i = index + 1; i < now_.size(); ++i) anew.push_back(now_[i]->info.strokes);
  WorkResult result = add_entries(anew, next, progress);
  result.lines.taken_back = given_up;
  if (!result.is_done()) return result;
  const LineChange change = lines_to(next);
  result.lines.taken_back += change.taken_back;
  result.lines.appended = change.appended;
  change_to(std::move(next));
  return result;
}

WorkResult Workbench::append(const std::vector<SessionStroke>& strokes, Progress* progress) {
  WorkResult result = set_live({}, progress);
  for (const std::vector<SessionStroke>& group : strokes_of_gestures(strokes)) {
    History next = now_;
    WorkResult added = add_entries({joined_strokes(group)}, next, progress);
    result.status = added.status;
    result.refusal = std::move(added.refusal);
    if (!result.is_done()) return result;
    const LineChange change = lines_to(next);
    result.lines.appended.insert(result.lines.appended.end(), change.appended.begin(), change.appended.end());
    change_to(std::move(next));
  }
  return result;
}

std::optional<ShapeState> Workbench::state_before() const {
  if (!live_.empty()) return last_state();
  if (now_.empty()) return std::nullopt;
  return now_.size() == 1 ? base_ : now_[now_.size() - 2]->after;
}

std::optional<ShapeState> Workbench::state_after(std::size_t entries, Progress* progress) {
  return state_after(now_, std::min(entries, now_.size()), progress);
}

std::optional<ShapeState> Workbench::state_after(const History& history, std::size_t count, Progress* progress) {
  std::size_t known = count;
  while (known > 0 && !history[known - 1]->after) --known;
  ShapeState state = known == 0 ? base_ : *history[known - 1]->after;
  for (; known < count; ++known) {
    Entry scratch;
    if (!make_entry(history[known]->info.strokes, state, scratch, progress).is_done()) return std::nullopt;
    state = *scratch.after;
  }
  return state;
}

std::vector<SessionStroke> Workbench::strokes() const {
  std::vector<SessionStroke> all;
  for (const auto& entry : now_) {
    all.insert(all.end(), entry->info.strokes.begin(), entry->info.strokes.end());
  }
  const std::vector<SessionStroke> live = joined_strokes(without_remesh(live_));
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
  for (auto history = redo_.rbegin(); history != redo_.rend() && history->size() > size; ++history) {
    size = history->size();
    result.emplace_back(history->back(), &history->back()->info);
  }
  return result;
}

LineChange Workbench::live_lines(const GestureChange& change, const std::vector<SessionStroke>& strokes) {
  LineChange lines;
  if (change.from_start) lines.taken_back = live_lines_;
  if (change.rest_as_line) lines.appended.push_back({*change.rest_as_line});
  if (change.rest && !change.rest_as_line) {
    lines.taken_back = 1;
    lines.appended.push_back({strokes[change.first_new - 1].stroke});
  }
  for (std::size_t i = change.first_new; i < strokes.size(); ++i) lines.appended.push_back({strokes[i].stroke});
  live_lines_ = live_lines_ - lines.taken_back + lines.appended.size();
  return lines;
}

// Applies the strokes, with their remesh settings, to a state.
WorkResult Workbench::make_entry(const std::vector<SessionStroke>& strokes, const ShapeState& from, Entry& entry,
                                 Progress* progress) {
  const auto began = std::chrono::steady_clock::now();
  const std::uint64_t steps = steps_;
  warnings_.clear();
  WorkResult result = compute(from, false, [&] { return apply(strokes, progress); });
  if (!result.is_done()) return result;
  entry.after = *at_;
  entry.bytes = entry.after->positions.bytes_beyond(from.positions);
  entry.info = {strokes, seconds_since(began), steps_ - steps, std::exchange(warnings_, {})};
  return result;
}

WorkResult Workbench::add_entries(const std::vector<std::vector<SessionStroke>>& gestures, History& history,
                                  Progress* progress) {
  std::optional<ShapeState> state = state_after(history, history.size(), progress);
  if (!state) return {AdvectStatus::cancelled, {}, {}, {}};
  for (const std::vector<SessionStroke>& strokes : gestures) {
    auto entry = std::make_shared<Entry>();
    WorkResult result = make_entry(strokes, *state, *entry, progress);
    if (!result.is_done()) return result;
    state = entry->after;
    history.push_back(std::move(entry));
  }
  return {};
}

// Goes to the history on top of `from`, which then lies on `to`.
WorkResult Workbench::step(std::vector<History>& from, std::vector<History>& to, Progress* progress) {
  History& target = from.back();
  const std::optional<ShapeState> state = state_after(target, target.size(), progress);
  if (!state) return {AdvectStatus::cancelled, {}, {}, {}};
  if (!target.empty()) target.back()->after = *state;
  WorkResult result;
  result.lines = lines_to(target);
  to.push_back(std::exchange(now_, std::move(target)));
  from.pop_back();
  return result;
}

// How the session file's lines follow; keeps count of them.
LineChange Workbench::lines_to(const History& target) {
  const auto [a, b] = std::mismatch(now_.begin(), now_.end(), target.begin(), target.end());
  LineChange change;
  const auto common = static_cast<std::size_t>(a - now_.begin());
  for (std::size_t i = common; i < lines_.size(); ++i) change.taken_back += lines_[i];
  lines_.resize(common);
  for (auto entry = b; entry != target.end(); ++entry) {
    const std::vector<SessionStroke>& strokes = (*entry)->info.strokes;
    change.appended.insert(change.appended.end(), strokes.begin(), strokes.end());
    lines_.push_back(strokes.size());
  }
  return change;
}

void Workbench::change_to(History next) {
  undo_.push_back(std::exchange(now_, std::move(next)));
  redo_.clear();
  thin_out();
}

// Drops every second state of those that are not among the latest, until what is kept is within the limit.
void Workbench::thin_out() {
  while (kept_bytes() > memory_) {
    bool drop = false;
    bool dropped = false;
    for (std::size_t i = 0; i + kKeptStates < now_.size(); ++i) {
      if (!now_[i]->after) continue;
      if (drop) now_[i]->after.reset();
      dropped = dropped || drop;
      drop = !drop;
    }
    if (!dropped) break;
  }
}

std::size_t Workbench::kept_bytes() const {
  std::unordered_set<const Entry*> counted;
  std::size_t bytes = 0;
  const auto count = [&](const History& history) {
    for (const auto& entry : history) {
      if (counted.insert(entry.get()).second && entry->after) bytes += entry->bytes;
    }
  };
  count(now_);
  if (!undo_.empty()) count(undo_.back());
  for (const History& history : redo_) count(history);
  return bytes;
}

}  // namespace knead
