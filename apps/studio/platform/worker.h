// One thread that does what takes time, so that the window never waits.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "knead/flow.h"

namespace knead::studio {

// What a thread is doing.
struct WorkStatus {
  std::string what;                // "Remeshing"; empty: nothing worth a name
  double seconds = 0;              // since it began
  std::optional<double> fraction;  // of it that is done, from 0 to 1; std::nullopt if it is not known
};

// Jobs are done one after the other, in the order in which they were posted. They do not throw.
class Worker {
 public:
  using Job = std::function<void(Progress&)>;

  // Without a thread every job is done where it is posted, for tests and scripts. `when_idle` is called whenever
  // nothing is left to be done; it is cancelled when another job is posted, and called again after that.
  explicit Worker(bool has_thread, Job when_idle);
  ~Worker();  // what was posted is done first
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // `what` names the job for people.
  void post(Job job, std::string what = {});

  // Posts a job that replaces the last job posted here if that has not begun: of a drag, only the latest place counts.
  // A job that gives way is also cancelled after it has begun. Returns the number of the job; numbers grow.
  std::uint64_t post_latest(Job job, std::string what = {}, bool gives_way = false);

  // No job posted so far gives way from now on.
  void keep_latest();

  // Returns the number of the last job of post_latest() that has begun. Those before it are done or replaced.
  std::uint64_t begun() const;

  bool is_busy() const;
  // Returns whether a job with a name is running or waiting.
  bool has_named_work() const;

  // Returns the job that is running; nothing if none is.
  std::optional<WorkStatus> status() const;

  // Renames the running job. For jobs that know their name only after they have begun.
  void name(std::string what);

  // Asks the running job and the waiting ones to stop as soon as they can.
  void cancel();

  // Waits until no job is left.
  void wait() const;

 private:
  struct Waiting {
    Job job;
    std::uint64_t latest = 0;  // 0: not to be replaced
    std::string what{};
    bool gives_way = false;
  };

  void run();
  void perform(const Waiting& waiting);
  void begin(std::string what);

  Job when_idle_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<Waiting> queue_;
  bool is_performing_ = false;
  bool is_idling_ = false;      // performing when_idle_
  bool may_give_way_ = false;   // what is being done gives way
  bool is_giving_way_ = false;  // it was cancelled for the next
  std::string what_;
  std::chrono::steady_clock::time_point began_;
  bool is_ending_ = false;
  bool idle_is_due_ = false;
  std::uint64_t posted_latest_ = 0;
  std::uint64_t begun_latest_ = 0;
  Progress progress_;
  bool has_thread_ = false;
  std::thread thread_;
};

}  // namespace knead::studio
