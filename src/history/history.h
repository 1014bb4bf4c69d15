// Inside of the history: the files in a journal's folder, and the states that are kept for undo.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <unordered_map>

#include "knead/shape_state.h"

namespace knead::session_detail {

inline constexpr const char* kSessionFile = "session.knead";
// Two lines: the length of kSessionFile in bytes when the work was saved, 0 if it has changed since; and the session
// file that it was saved to, or opened from.
inline constexpr const char* kSavedFile = "saved";

// The whole batches of the journal in this folder. Throws IoError(read), and InvalidInput where not even the header is
// whole.
std::string read_journal(const std::filesystem::path& folder);

// States that an editor keeps for undo, and the memory that they take together.

// Counts the memory of states that share parts. One thread at a time.
class MemoryAccount {
 public:
  // What `base` holds does not count: it is there anyway.
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

}  // namespace knead::session_detail
