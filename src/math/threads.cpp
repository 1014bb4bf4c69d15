// Loops over many threads: on oneTBB, or on threads of our own for ThreadSanitizer, which does not see oneTBB's
// synchronisation, and for systems without oneTBB. The chunks of a loop are the same.
#include <algorithm>

#include "knead/error.h"

#ifdef KNEAD_STD_THREADS
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#else
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <map>
#include <mutex>
#endif

namespace knead {

namespace {

#ifdef KNEAD_STD_THREADS

// One call of parallel_for: every idle thread takes its next chunk.
struct Loop {
  std::size_t chunks = 0;
  const std::function<void(std::size_t)>& run_chunk;
  std::size_t wanted = 0;  // threads that may still join
  std::atomic<std::size_t> next{0};
  std::size_t active = 0;  // threads that have joined and are not done
  std::exception_ptr failure{};

  bool is_open() const { return wanted > 0 && next < chunks; }
};

// Threads that wait for loops. The caller of a loop does all chunks that no other thread takes, so loops may nest.
class Pool {
 public:
  explicit Pool(int threads) {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { serve(); });
  }
  ~Pool() {
    {
      const std::scoped_lock lock(mutex_);
      is_ending_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  void run(Loop& loop) {
    {
      const std::scoped_lock lock(mutex_);
      loops_.push_back(&loop);
    }
    changed_.notify_all();
    work(loop);
    std::unique_lock lock(mutex_);
    loops_.erase(std::find(loops_.begin(), loops_.end(), &loop));
    done_.wait(lock, [&] { return loop.active == 0; });
  }

 private:
  void work(Loop& loop) {
    try {
      for (std::size_t chunk = loop.next++; chunk < loop.chunks; chunk = loop.next++) loop.run_chunk(chunk);
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!loop.failure) loop.failure = std::current_exception();
    }
  }

  Loop* open_loop() const {
    const auto found = std::find_if(loops_.begin(), loops_.end(), [](const Loop* loop) { return loop->is_open(); });
    return found == loops_.end() ? nullptr : *found;
  }

  void serve() {
    std::unique_lock lock(mutex_);
    while (true) {
      Loop* open = nullptr;  // looked up once: other threads take chunks meanwhile, and a loop may close at any time
      changed_.wait(lock, [&] { return is_ending_ || (open = open_loop()) != nullptr; });
      if (is_ending_) return;
      Loop& loop = *open;
      --loop.wanted;
      ++loop.active;
      lock.unlock();
      work(loop);
      lock.lock();
      --loop.active;
      done_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::condition_variable done_;
  std::vector<Loop*> loops_;
  bool is_ending_ = false;
  std::vector<std::thread> threads_;
};

#else

// Each arena that oneTBB 2021.8 has ever made slows down all others, so there is one for each number of threads.
tbb::task_arena& arena_of(int threads) {
  static std::mutex mutex;
  static std::map<int, tbb::task_arena> arenas;
  const std::lock_guard lock(mutex);
  return arenas.try_emplace(threads, threads).first->second;
}

// Loops may nest. A failure of the outer loop leaves the inner ones complete, as oneTBB would end these in silence; and
// who waits for an inner loop takes no chunk of an outer one, so that no stack grows and no lock is met twice.
void run_alone(std::size_t chunks, const std::function<void(std::size_t)>& run_chunk) {
  tbb::task_group_context context(tbb::task_group_context::isolated);
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, chunks, run_chunk, context); });
}

#endif

}  // namespace

int hardware_threads() {
#if defined(__EMSCRIPTEN__) && !defined(__EMSCRIPTEN_PTHREADS__)
  return 1;  // a page cannot start others
#elif defined(__EMSCRIPTEN__)
  constexpr int kMaxThreads = 8;  // each takes memory; web.cmake starts them
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
#elif defined(KNEAD_STD_THREADS)
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
#else
  return tbb::this_task_arena::max_concurrency();
#endif
}

void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t chunks = (count + grain - 1) / grain;
  const auto run_chunk = [&](std::size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); };
  const int available = threads > 0 ? std::min(threads, hardware_threads()) : hardware_threads();
  if (chunks <= 1 || available == 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
    return;
  }
#ifdef KNEAD_STD_THREADS
  static Pool pool(hardware_threads() - 1);
  const std::function<void(std::size_t)> function = run_chunk;
  Loop loop{chunks, function, std::min(chunks, static_cast<std::size_t>(available)) - 1};
  pool.run(loop);
  if (loop.failure) std::rethrow_exception(loop.failure);
#else
  if (available == hardware_threads()) {
    run_alone(chunks, run_chunk);
  } else {
    arena_of(available).execute([&] { run_alone(chunks, run_chunk); });
  }
#endif
}

}  // namespace knead
