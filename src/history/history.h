// The parts of the history that its sources share: the files of a journal, joined strokes, and the states kept for
// undo.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "knead/editor/shape_state.h"
#include "knead/session.h"

namespace knead::detail {

inline constexpr const char* kSessionFile = "session.knead";
// Two lines: the length of kSessionFile in bytes when the work was saved, 0 if it has changed since; and the session
// file that it was saved to, or opened from.
inline constexpr const char* kSavedFile = "saved";

// Returns the complete batches of the journal in this folder. Throws IoError(read), and InvalidInput if the header is
// incomplete.
std::string read_journal(const std::filesystem::path& folder);

// Returns true if a stroke with the same mirror planes as the one before it may be joined to that.
using MayJoin = bool (*)(const SessionStroke& before, const SessionStroke& stroke);

// Joins strokes to those that they continue, where may_join() allows it.
std::vector<SessionStroke> joined_where(std::vector<SessionStroke> strokes, MayJoin may_join);

// Counts the memory of states that share parts. One thread at a time.
class MemoryAccount {
 public:
  // The parts of `base` do not count, because they exist in any case.
  explicit MemoryAccount(const ShapeState& base);

  void add(const ShapeState& state);
  void remove(const ShapeState& state);
  std::size_t bytes() const { return bytes_; }
  std::size_t states() const { return states_; }

 private:
  void count(const void* part, std::size_t bytes, bool is_added);
  void count(const ShapeState& state, bool is_added);

  std::unordered_map<const void*, std::size_t> uses_;
  std::size_t bytes_ = 0;
  std::size_t states_ = 0;
};

// A state that counts as long as it is held.
class KeptState {
 public:
  KeptState(ShapeState state, std::shared_ptr<MemoryAccount> account);
  ~KeptState();
  KeptState(const KeptState&) = delete;
  KeptState& operator=(const KeptState&) = delete;

  const ShapeState& state() const { return state_; }

 private:
  ShapeState state_;
  std::shared_ptr<MemoryAccount> account_;
};

}  // namespace knead::detail
