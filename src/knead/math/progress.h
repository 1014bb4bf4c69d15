// How far a long call is, and how to stop it.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>

namespace knead {

// Progress of a running call, for other threads: set `cancel` to stop it.
struct Progress {
  std::atomic<bool> cancel{false};
  std::atomic<std::uint64_t> done{0};   // of work that moves points: points times segments
  std::atomic<std::uint64_t> total{0};  // what `done` grows to; 0: not known
};

// Thrown by a call whose Progress::cancel was set, where its result has no status to say so.
class Cancelled : public std::exception {
 public:
  // Returns "cancelled".
  const char* what() const noexcept override { return "cancelled"; }
};

// Throws Cancelled if `cancel` is set. Null: never.
inline void stop_if_cancelled(const Progress* progress) {
  if (progress != nullptr && progress->cancel.load(std::memory_order_relaxed)) throw Cancelled();
}

}  // namespace knead
