// Work without the GIL that calls a progress function and can be interrupted.
#include "work.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "knead/error.h"

namespace knead::python {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kBetweenSignals = std::chrono::milliseconds(20);
constexpr auto kBetweenCalls = std::chrono::milliseconds(200);

double fraction_of(const Progress& progress) {
  const std::uint64_t total = progress.total;
  if (total == 0) return 0;
  return std::min(1.0, static_cast<double>(progress.done) / static_cast<double>(total));
}

// A thread that does the work, and how it ends.
class Worker {
 public:
  explicit Worker(const std::function<void()>& work) : thread_([this, &work] { run(work); }) {}
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() { thread_.join(); }

  bool wait_for(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    return ended_.wait_for(lock, time, [&] { return has_ended_; });
  }
  void wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return has_ended_; });
  }
  const std::exception_ptr& thrown() const { return thrown_; }

 private:
  void run(const std::function<void()>& work) {
    try {
      work();
    } catch (...) {
      thrown_ = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
    ended_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
  std::exception_ptr thrown_;
  std::thread thread_;
};

// Returns false where the callback wants the work to end. Throws error_already_set.
bool ask(const py::object& callback, const Progress& progress, Clock::time_point& next) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (callback.is_none() || Clock::now() < next) return true;
  next = Clock::now() + kBetweenCalls;
  const py::object answer = callback(fraction_of(progress));
  return !(py::isinstance<py::bool_>(answer) && !answer.cast<bool>());
}

}  // namespace

bool run_watched(const py::object& callback, Progress& progress, const std::function<void()>& work) {
  if (!callback.is_none() && PyCallable_Check(callback.ptr()) == 0) {
    throw py::type_error("progress must be a function of one number, or None");
  }
  std::optional<py::error_already_set> raised;
  bool goes_on = true;
  Clock::time_point next = Clock::now();
  std::exception_ptr thrown;
  {
    const py::gil_scoped_release released;
    Worker worker(work);
    while (!worker.wait_for(kBetweenSignals)) {
      const py::gil_scoped_acquire acquired;
      try {
        goes_on = ask(callback, progress, next);
      } catch (py::error_already_set& error) {
        raised.emplace(std::move(error));
        goes_on = false;
      }
      if (goes_on) continue;
      progress.cancel = true;
      const py::gil_scoped_release again;
      worker.wait();
      break;
    }
    thrown = worker.thrown();
  }
  if (raised) throw std::move(*raised);
  if (!goes_on) return false;
  if (thrown) std::rethrow_exception(thrown);
  if (callback.is_none()) return true;
  const py::object answer = callback(1.0);
  return !(py::isinstance<py::bool_>(answer) && !answer.cast<bool>());
}

void warn(const std::vector<std::string>& sentences) {
  for (const std::string& sentence : sentences) {
    if (PyErr_WarnEx(PyExc_UserWarning, sentence.c_str(), 2) != 0) throw py::error_already_set();
  }
}

void require_done(AdvectStatus status, const Session& session, std::size_t failed_line) {
  if (status != AdvectStatus::step_limit) return;
  throw AccuracyError(to_string(Place{session.name, failed_line}) + ": " + kStepLimitAdvice);
}

std::optional<ReplayResult> replay_watched(const py::object& callback, const Mesh& mesh, const Session& session,
                                           ReplayOptions options) {
  Progress progress;
  options.progress = &progress;
  ReplayResult result;
  if (!run_watched(callback, progress, [&] { result = replay(borrow(mesh), session, options); })) return std::nullopt;
  require_done(result.status, session, result.failed_line);
  warn(result.shortfalls);
  return result;
}

}  // namespace knead::python
