#include <algorithm>

#include "knead/error.h"
#include "math/system.h"

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

#include <map>
#endif

namespace knead {

int hardware_threads() {
#if defined(__EMSCRIPTEN__) && !defined(__EMSCRIPTEN_PTHREADS__)
  return 1;  // no other can be started
#elif defined(__EMSCRIPTEN__)
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                    8);  // each takes memory; web.cmake starts them
#elif defined(KNEAD_STD_THREADS)
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
#else
  return tbb::this_task_arena::max_concurrency();
#endif
}

#ifdef KNEAD_STD_THREADS

namespace {

// One call of parallel_for: whoever has time takes its next chunk.
struct Loop {
  std::size_t count = 0;
  std::size_t grain = 0;
  std::size_t chunks = 0;
  const std::function<void(std::size_t, std::size_t)>* body = nullptr;
  std::atomic<std::size_t> next{0};
  std::size_t wanted = 0;  // threads that may still join
  std::size_t active = 0;  // that have joined and are not done
  std::exception_ptr failure;

  bool is_open() const { return wanted > 0 && next < chunks; }
};

// Threads that wait for loops. The caller of a loop does all chunks that no other takes, so loops may lie in loops.
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

  void work(Loop& loop) {
    try {
      for (std::size_t chunk = loop.next++; chunk < loop.chunks; chunk = loop.next++) {
        (*loop.body)(chunk * loop.grain, std::min(loop.count, (chunk + 1) * loop.grain));
      }
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!loop.failure) loop.failure = std::current_exception();
    }
  }

 private:
  Loop* open_loop() const {
    const auto found = std::find_if(loops_.begin(), loops_.end(), [](const Loop* loop) { return loop->is_open(); });
    return found == loops_.end() ? nullptr : *found;
  }

  void serve() {
    std::unique_lock lock(mutex_);
    while (true) {
      Loop* open = nullptr;  // asked for once: others take chunks meanwhile, and a loop may close at any time
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

}  // namespace

// For ThreadSanitizer, which does not see oneTBB's synchronisation, and where oneTBB is not: the same chunks on threads
// of our own.
void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t chunks = (count + grain - 1) / grain;
  const auto most = static_cast<std::size_t>(threads > 0 ? std::min(threads, hardware_threads()) : hardware_threads());
  const std::size_t workers = std::min(chunks, most);
  if (workers <= 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) body(chunk * grain, std::min(count, (chunk + 1) * grain));
    return;
  }
  static Pool pool(hardware_threads() - 1);
  Loop loop;
  loop.count = count;
  loop.grain = grain;
  loop.chunks = chunks;
  loop.body = &body;
  loop.wanted = workers - 1;
  pool.run(loop);
  if (loop.failure) std::rethrow_exception(loop.failure);
}

#else

namespace {

// Each arena that oneTBB 2021.8 has ever made slows down all others, so there is one for each number of threads.
tbb::task_arena& arena_of(int threads) {
  static std::mutex mutex;
  static std::map<int, tbb::task_arena> arenas;
  const std::lock_guard lock(mutex);
  return arenas.try_emplace(threads, threads).first->second;
}

}  // namespace

void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t chunks = (count + grain - 1) / grain;
  const auto run_chunk = [&](std::size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); };
  if (chunks <= 1 || threads == 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
  } else if (threads <= 0 || threads >= hardware_threads()) {
    tbb::parallel_for(std::size_t{0}, chunks, run_chunk);
  } else {
    arena_of(threads).execute([&] { tbb::parallel_for(std::size_t{0}, chunks, run_chunk); });
  }
}

#endif

}  // namespace knead

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

#include <cstdint>

namespace knead {

void prefer_large_pages([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t page = std::uintptr_t{1} << 21;  // of x86-64 and most of arm64
  const std::uintptr_t skipped = (page - reinterpret_cast<std::uintptr_t>(begin) % page) % page;
  if (bytes < skipped + page) return;
  ::madvise(static_cast<char*>(begin) + skipped, (bytes - skipped) / page * page, MADV_HUGEPAGE);
#endif
}

}  // namespace knead
