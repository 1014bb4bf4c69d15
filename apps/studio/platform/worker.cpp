// The worker's thread and its queue of jobs.
#include "platform/worker.h"

#include <algorithm>
#include <utility>

namespace knead::studio {

Worker::Worker(bool has_thread, Job when_idle) : when_idle_(std::move(when_idle)), has_thread_(has_thread) {
  if (has_thread_) thread_ = std::thread([this] { run(); });
}

Worker::~Worker() {
  if (!has_thread_) return;
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Worker::post(Job job, std::string what) {
  if (!has_thread_) {
    perform({std::move(job), 0, std::move(what)});
    when_idle_(progress_);
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back({std::move(job), 0, std::move(what)});
    if (is_idling_) progress_.cancel = true;
  }
  changed_.notify_all();
}

std::uint64_t Worker::post_latest(Job job, std::string what, bool gives_way) {
  std::unique_lock lock(mutex_);
  const std::uint64_t number = ++posted_latest_;
  if (!has_thread_) {
    lock.unlock();
    perform({std::move(job), number, std::move(what)});
    return number;
  }
  if (!queue_.empty() && queue_.back().latest != 0) queue_.pop_back();
  queue_.push_back({std::move(job), number, std::move(what), gives_way});
  is_giving_way_ = is_giving_way_ || may_give_way_;
  if (is_idling_ || is_giving_way_) progress_.cancel = true;
  lock.unlock();
  changed_.notify_all();
  return number;
}

void Worker::keep_latest() {
  const std::lock_guard lock(mutex_);
  may_give_way_ = false;
  for (Waiting& waiting : queue_) waiting.gives_way = false;
}

void Worker::perform(const Waiting& waiting) {
  begin(waiting.what);
  if (waiting.latest != 0) {
    const std::lock_guard lock(mutex_);
    begun_latest_ = waiting.latest;
  }
  waiting.job(progress_);
}

void Worker::begin(std::string what) {
  progress_.done = 0;
  progress_.total = 0;
  const std::lock_guard lock(mutex_);
  what_ = std::move(what);
  began_ = std::chrono::steady_clock::now();
}

void Worker::name(std::string what) {
  const std::lock_guard lock(mutex_);
  what_ = std::move(what);
}

std::optional<WorkStatus> Worker::status() const {
  const std::lock_guard lock(mutex_);
  if (!is_performing_) return std::nullopt;
  WorkStatus status{what_, std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count(), {}};
  const auto total = static_cast<double>(progress_.total.load());
  if (total > 0) status.fraction = std::min(static_cast<double>(progress_.done.load()) / total, 1.0);
  return status;
}

void Worker::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return !queue_.empty() || idle_is_due_ || is_ending_; });
    if (queue_.empty() && is_ending_) return;
    is_performing_ = true;
    if (queue_.empty()) {
      idle_is_due_ = false;
      progress_.cancel = false;
      is_idling_ = true;
      lock.unlock();
      begin({});
      when_idle_(progress_);
    } else {
      const Waiting waiting = std::move(queue_.front());
      queue_.pop_front();
      idle_is_due_ = true;
      may_give_way_ = waiting.gives_way;
      lock.unlock();
      perform(waiting);
    }
    lock.lock();
    is_performing_ = false;
    may_give_way_ = false;
    if (std::exchange(is_giving_way_, false)) progress_.cancel = false;
    if (std::exchange(is_idling_, false) || (queue_.empty() && !idle_is_due_)) progress_.cancel = false;
    changed_.notify_all();
  }
}

std::uint64_t Worker::begun() const {
  const std::lock_guard lock(mutex_);
  return begun_latest_;
}

bool Worker::is_busy() const {
  const std::lock_guard lock(mutex_);
  return is_performing_ || !queue_.empty();
}

bool Worker::has_named_work() const {
  const std::lock_guard lock(mutex_);
  return (is_performing_ && !what_.empty()) ||
         std::any_of(queue_.begin(), queue_.end(), [](const Waiting& waiting) { return !waiting.what.empty(); });
}

void Worker::cancel() {
  const std::lock_guard lock(mutex_);
  if (is_performing_ || !queue_.empty()) progress_.cancel = true;
}

void Worker::wait() const {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return queue_.empty() && !is_performing_ && !(has_thread_ && idle_is_due_); });
}

}  // namespace knead::studio
