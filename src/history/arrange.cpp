// Rearranges the history: entries are renamed, reordered, joined, split, switched off and made weaker or stronger.
#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "knead/editor/workbench.h"

namespace knead {

namespace {

// Returns true if two strokes have the same effect: names and lines do not matter.
bool does_same(const SessionStroke& a, const SessionStroke& b) {
  if (a.stroke != b.stroke) return false;
  SessionStroke other = b;
  other.name = a.name;
  other.line = a.line;
  return a == other;
}

}  // namespace

// Finds, entry by entry, how far a new history has the same effect as the present one.
class Workbench::Comparison {
 public:
  explicit Comparison(const History& before) : before_(before) {
    for (const auto& entry : before) {
      for (const SessionStroke& stroke : entry->info.strokes) {
        if (is_applied(stroke)) applied_.push_back(&stroke);
      }
      ends_.push_back(applied_.size());
    }
  }

  // Adds the strokes of an entry. Returns an entry of the present history after which the shape is the same, or null.
  std::shared_ptr<Entry> follow(const std::vector<SessionStroke>& strokes) {
    for (const SessionStroke& stroke : strokes) {
      if (!is_applied(stroke)) continue;
      is_same_ = is_same_ && done_ < applied_.size() && does_same(*applied_[done_], stroke);
      ++done_;
    }
    if (!is_same_) return nullptr;
    std::shared_ptr<Entry> found;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      if (ends_[i] != done_) continue;
      if (before_[i]->info.strokes == strokes) return before_[i];
      if (!found) found = before_[i];
    }
    return found;
  }

 private:
  const History& before_;
  std::vector<const SessionStroke*> applied_;
  std::vector<std::size_t> ends_;  // of each entry, in applied_
  std::size_t done_ = 0;
  bool is_same_ = true;
};

WorkResult Workbench::make_arrangement(const std::vector<std::vector<SessionStroke>>& entries, History& next,
                                       Progress* progress) {
  Comparison comparison(now_);
  for (const std::vector<SessionStroke>& strokes : entries) {
    if (strokes.empty()) continue;
    std::shared_ptr<Entry> same = comparison.follow(strokes);
    if (same && same->info.strokes == strokes) {
      next.push_back(std::move(same));
      continue;
    }
    auto entry = std::make_shared<Entry>();
    if (same && same->after) {
      *entry = *same;
      entry->info.strokes = strokes;
    } else {
      const std::optional<ShapeState> state = make_state(next, next.size(), progress, nullptr);
      if (!state) return {AdvectStatus::cancelled, {}, {}, {}};
      WorkResult result = make_entry(strokes, *state, *entry, progress);
      if (!result.is_done()) return result;
    }
    next.push_back(std::move(entry));
  }
  return {};
}

WorkResult Workbench::arrange(const std::vector<std::vector<SessionStroke>>& entries, bool again, Progress* progress) {
  const std::size_t given_up = set_live({}, progress).lines.undone;
  WorkResult result = settle(progress);
  result.lines.undone += given_up;
  if (!result.is_done()) return result;
  History next;
  result = make_arrangement(entries, next, progress);
  result.lines.undone = given_up;
  if (!result.is_done() || next == now_) return result;
  Change change = change_between(now_, next);
  if (again && !undo_.empty()) {
    const std::size_t common = change.common;
    History before(now_.begin(), now_.begin() + static_cast<std::ptrdiff_t>(undo_.back().common));
    before.insert(before.end(), undo_.back().rest.begin(), undo_.back().rest.end());
    exchange(std::move(change));
    undo_.back() = change_between(now_, before);
    redo_.clear();
    result.lines = joined_changes(std::move(result.lines), lines_from(common));
  } else {
    result.lines = joined_changes(std::move(result.lines), change_to(std::move(change)));
  }
  return result;
}

LineChange joined_changes(LineChange first, LineChange second) {
  const std::size_t dropped = std::min(second.undone, first.appended.size());
  first.appended.resize(first.appended.size() - dropped);
  first.undone += second.undone - dropped;
  std::move(second.appended.begin(), second.appended.end(), std::back_inserter(first.appended));
  return first;
}

WorkResult Workbench::edit(std::size_t entry, std::vector<SessionStroke> strokes, Progress* progress) {
  if (entry >= now_.size()) throw std::out_of_range("there is no such entry in the history");
  const std::size_t given_up = set_live({}, progress).lines.undone;
  if (WorkResult settled = settle(progress); !settled.is_done()) {
    settled.lines.undone += given_up;
    return settled;
  }
  Change next{entry, {}};
  std::vector<std::vector<SessionStroke>> anew;
  if (!strokes.empty()) anew.push_back(std::move(strokes));
  for (std::size_t i = entry + 1; i < now_.size(); ++i) anew.push_back(now_[i]->info.strokes);
  WorkResult result = make_rest(anew, next, progress);
  if (result.is_done()) result.lines = change_to(std::move(next));
  result.lines.undone += given_up;
  return result;
}

}  // namespace knead
