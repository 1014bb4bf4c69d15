#include "knead/session/workbench.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <unordered_set>
#include <utility>

#include "knead/math/error.h"
#include "knead/session/live_change.h"
#include "knead/session/live_shape.h"

namespace knead {

Mesh ShapeState::to_mesh() const {
  Mesh result = *mesh;
  positions.copy_to(result.positions);
  return result;
}

std::span<const std::uint32_t> ShapeState::face_source() const { return trail->face_source; }

namespace session_detail {

namespace {

constexpr std::size_t kDefaultMemory = std::size_t{2} << 30;
constexpr std::size_t kKeptStates = 8;  // of the latest entries, whatever they take

struct Entry {
  HistoryEntry info;
  std::optional<ShapeState> after;  // nothing: dropped, and found by doing the strokes again
  std::size_t bytes = 0;            // of that, beyond the state before
};
using History = std::vector<std::shared_ptr<Entry>>;

std::vector<SessionStroke> without_remesh(std::vector<SessionStroke> strokes) {
  for (SessionStroke& stroke : strokes) stroke.remesh = std::nullopt;
  return strokes;
}

bool is_remeshed(const std::vector<SessionStroke>& strokes) {
  return std::any_of(strokes.begin(), strokes.end(), [](const SessionStroke& s) { return s.remesh.has_value(); });
}

}  // namespace

class Bench {
 public:
  Bench(Mesh mesh, const std::filesystem::path& folder, std::vector<std::uint32_t> face_labels, int threads)
      : shape_(std::move(mesh), folder, std::move(face_labels), threads), live_state_(shape_.base()) {}

  const ShapeState& base() const { return shape_.base(); }
  const ShapeState& state() const { return live_.empty() ? head() : live_state_; }
  const std::vector<SessionStroke>& live() const { return live_; }
  const History& now() const { return now_; }
  const std::vector<History>& undoable() const { return undo_; }
  const std::vector<History>& redoable() const { return redo_; }
  void limit_memory(std::size_t bytes) { memory_ = bytes; }

  WorkResult set_live(std::vector<SessionStroke> strokes, Progress* progress) {
    WorkResult result;
    if (strokes.empty()) {
      result.lines.taken_back = std::exchange(live_lines_, 0);
      live_.clear();
      return result;
    }
    const LiveChange what = live_change(live_, strokes);
    const auto began = std::chrono::steady_clock::now();
    const std::uint64_t steps = shape_.steps();
    result = guarded([&] {
      shape_.rest_at(what.from_start ? head() : state(), what.from_start && !live_.empty());
      AdvectStatus status = AdvectStatus::done;
      if (what.rest) status = shape_.apply(*what.rest, progress);
      for (std::size_t i = what.first_new; i < strokes.size() && status == AdvectStatus::done; ++i) {
        status = shape_.apply(SessionStroke{strokes[i].stroke}, progress);
      }
      return status;
    });
    if (!result.is_done()) return result;
    if (live_.empty() || what.from_start) live_seconds_ = 0;
    if (live_.empty()) live_steps_ = steps;
    live_state_ = shape_.state(state());
    live_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    result.lines = live_lines(what, strokes);
    result.part = shape_.take_part();
    live_ = std::move(strokes);
    return result;
  }

  void prepare() {
    shape_.rest_at(state());
    shape_.prepare();
  }

  WorkResult finish(Progress* progress) {
    if (live_.empty()) return {};
    WorkResult result;
    auto entry = std::make_shared<Entry>();
    std::vector<SessionStroke> joined = joined_strokes(live_);
    std::size_t lines = live_lines_;
    if (is_remeshed(joined)) {
      result = make_entry(joined, head(), *entry, progress);
      if (!result.is_done()) return result;
      result.lines = {live_lines_, joined};
      lines = joined.size();
    } else {
      entry->after = live_state_;
      entry->info.seconds = live_seconds_;
      entry->info.steps = shape_.steps() - live_steps_;
      entry->info.warnings = shape_.take_warnings();
      entry->bytes = live_state_.positions.bytes_beyond(head().positions);
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

  WorkResult undo(Progress* progress) {
    if (!live_.empty()) return set_live({}, progress);
    return undo_.empty() ? WorkResult{} : step(undo_, redo_, progress);
  }

  WorkResult redo(Progress* progress) {
    LineChange given_up = set_live({}, progress).lines;
    if (redo_.empty()) return {AdvectStatus::done, {}, std::move(given_up), {}};
    WorkResult result = step(redo_, undo_, progress);
    result.lines.taken_back += given_up.taken_back;
    return result;
  }

  WorkResult edit(std::size_t index, std::vector<SessionStroke> strokes, Progress* progress) {
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

  WorkResult append(const std::vector<SessionStroke>& strokes, Progress* progress) {
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

  // Empty where it was cancelled.
  std::optional<ShapeState> state_after(const History& history, std::size_t count, Progress* progress) {
    std::size_t known = count;
    while (known > 0 && !history[known - 1]->after) --known;
    ShapeState state = known == 0 ? shape_.base() : *history[known - 1]->after;
    for (; known < count; ++known) {
      Entry scratch;
      if (!make_entry(history[known]->info.strokes, state, scratch, progress).is_done()) return std::nullopt;
      state = *scratch.after;
    }
    return state;
  }

  std::vector<SessionStroke> strokes() const {
    std::vector<SessionStroke> all;
    for (const auto& entry : now_) {
      all.insert(all.end(), entry->info.strokes.begin(), entry->info.strokes.end());
    }
    const std::vector<SessionStroke> live = joined_strokes(without_remesh(live_));
    all.insert(all.end(), live.begin(), live.end());
    return all;
  }

 private:
  const ShapeState& head() const { return now_.empty() ? shape_.base() : *now_.back()->after; }

  template <class Work>
  WorkResult guarded(const Work& work) {
    try {
      return {work(), {}, {}, {}};
    } catch (const InvalidInput& error) {
      return {AdvectStatus::done, error.what(), {}, {}};
    }
  }

  LineChange live_lines(const LiveChange& what, const std::vector<SessionStroke>& strokes) {
    LineChange lines;
    if (what.from_start) lines.taken_back = live_lines_;
    if (what.rest && what.rest_as_line) lines.appended.push_back({*what.rest_as_line});
    if (what.rest && !what.rest_as_line) {
      lines.taken_back = 1;
      lines.appended.push_back({strokes[what.first_new - 1].stroke});
    }
    for (std::size_t i = what.first_new; i < strokes.size(); ++i) lines.appended.push_back({strokes[i].stroke});
    live_lines_ = live_lines_ - lines.taken_back + lines.appended.size();
    return lines;
  }

  // Does the strokes, with their remesh settings, from a state on.
  WorkResult make_entry(const std::vector<SessionStroke>& strokes, const ShapeState& from, Entry& entry,
                        Progress* progress) {
    const auto began = std::chrono::steady_clock::now();
    const std::uint64_t steps = shape_.steps();
    shape_.take_warnings();
    WorkResult result = guarded([&] {
      shape_.rest_at(from);
      AdvectStatus status = AdvectStatus::done;
      for (std::size_t i = 0; i < strokes.size() && status == AdvectStatus::done; ++i) {
        status = shape_.apply(strokes[i], progress);
      }
      return status;
    });
    if (!result.is_done()) return result;
    entry.after = shape_.state(from);
    entry.bytes = entry.after->positions.bytes_beyond(from.positions);
    entry.info.strokes = strokes;
    entry.info.steps = shape_.steps() - steps;
    entry.info.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    entry.info.warnings = shape_.take_warnings();
    return result;
  }

  WorkResult add_entries(const std::vector<std::vector<SessionStroke>>& gestures, History& history,
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
  WorkResult step(std::vector<History>& from, std::vector<History>& to, Progress* progress) {
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
  LineChange lines_to(const History& target) {
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

  void change_to(History next) {
    undo_.push_back(std::exchange(now_, std::move(next)));
    redo_.clear();
    thin_out();
  }

  // Drops every second state of those that are not among the latest, until what is kept is within the limit.
  void thin_out() {
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

  std::size_t kept_bytes() const {
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

  LiveShape shape_;
  History now_;
  std::vector<std::size_t> lines_;  // in the session file, of each entry of now_
  std::vector<History> undo_;
  std::vector<History> redo_;
  std::vector<SessionStroke> live_;
  ShapeState live_state_;
  std::size_t live_lines_ = 0;
  double live_seconds_ = 0;
  std::uint64_t live_steps_ = 0;
  std::size_t memory_ = kDefaultMemory;
};

}  // namespace session_detail

using session_detail::Bench;

Workbench::Workbench(Mesh mesh, const std::filesystem::path& folder, std::vector<std::uint32_t> face_labels,
                     int threads)
    : bench_(std::make_unique<Bench>(std::move(mesh), folder, std::move(face_labels), threads)) {}
Workbench::~Workbench() = default;
Workbench::Workbench(Workbench&&) noexcept = default;
Workbench& Workbench::operator=(Workbench&&) noexcept = default;

const ShapeState& Workbench::state() const { return bench_->state(); }
const ShapeState& Workbench::base() const { return bench_->base(); }
const std::vector<SessionStroke>& Workbench::live() const { return bench_->live(); }
std::vector<SessionStroke> Workbench::strokes() const { return bench_->strokes(); }
bool Workbench::can_undo() const { return !bench_->undoable().empty() || !bench_->live().empty(); }
bool Workbench::can_redo() const { return !bench_->redoable().empty(); }
void Workbench::limit_memory(std::size_t bytes) { bench_->limit_memory(bytes); }

WorkResult Workbench::set_live(std::vector<SessionStroke> strokes, Progress* progress) {
  return bench_->set_live(std::move(strokes), progress);
}
void Workbench::prepare() { bench_->prepare(); }
WorkResult Workbench::finish(Progress* progress) { return bench_->finish(progress); }
WorkResult Workbench::undo(Progress* progress) { return bench_->undo(progress); }
WorkResult Workbench::redo(Progress* progress) { return bench_->redo(progress); }
WorkResult Workbench::edit(std::size_t entry, std::vector<SessionStroke> strokes, Progress* progress) {
  return bench_->edit(entry, std::move(strokes), progress);
}
WorkResult Workbench::append(const std::vector<SessionStroke>& strokes, Progress* progress) {
  return bench_->append(strokes, progress);
}

std::optional<ShapeState> Workbench::state_after(std::size_t entries, Progress* progress) {
  return bench_->state_after(bench_->now(), std::min(entries, bench_->now().size()), progress);
}

std::vector<std::shared_ptr<const HistoryEntry>> Workbench::done() const {
  std::vector<std::shared_ptr<const HistoryEntry>> result;
  for (const auto& entry : bench_->now()) result.emplace_back(entry, &entry->info);
  return result;
}

std::vector<std::shared_ptr<const HistoryEntry>> Workbench::redoable() const {
  std::vector<std::shared_ptr<const HistoryEntry>> result;
  std::size_t size = bench_->now().size();
  const std::vector<session_detail::History>& histories = bench_->redoable();
  for (std::size_t i = histories.size(); i > 0; --i) {
    const session_detail::History& history = histories[i - 1];
    if (history.size() <= size) break;
    size = history.size();
    result.emplace_back(history.back(), &history.back()->info);
  }
  return result;
}

}  // namespace knead
