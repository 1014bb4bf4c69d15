#include "platform/worker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace knead::studio {
namespace {

// Begins a job that waits until it is cancelled, or for two seconds.
struct Waits {
  std::atomic<bool> has_begun = false;
  std::atomic<bool> was_cancelled = false;

  Worker::Job job() {
    return [this](Progress& progress) {
      has_begun = true;
      const auto begin = std::chrono::steady_clock::now();
      while (!progress.cancel && std::chrono::steady_clock::now() - begin < std::chrono::seconds(2)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      was_cancelled = progress.cancel.load();
    };
  }
  void wait_for_it() const {
    while (!has_begun) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
};

TEST(Worker, ALatestJobGivesWayToTheNextWhichIsNotCancelled) {
  Worker worker(true, [](Progress&) {});
  Waits first;
  worker.post_latest(first.job(), "first", true);
  first.wait_for_it();
  bool second_was_cancelled = true;
  worker.post_latest([&](Progress& progress) { second_was_cancelled = progress.cancel; });
  worker.wait();
  EXPECT_TRUE(first.was_cancelled);
  EXPECT_FALSE(second_was_cancelled);
}

TEST(Worker, AKeptJobDoesNotGiveWay) {
  for (const bool gives_way : {true, false}) {
    Worker worker(true, [](Progress&) {});
    Waits first;
    worker.post_latest(first.job(), "first", gives_way);
    first.wait_for_it();
    worker.keep_latest();
    worker.post_latest([](Progress&) {});
    worker.wait();
    EXPECT_FALSE(first.was_cancelled);
  }
}

}  // namespace
}  // namespace knead::studio
