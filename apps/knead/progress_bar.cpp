#include "progress_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <string>
#include <string_view>

#include "program.h"

namespace knead::command {
namespace {

using namespace std::chrono_literals;

constexpr int kWidth = 40;

std::string bar_line(std::uint64_t done, std::uint64_t total) {
  const double part = total == 0 ? 1.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const std::string marks(static_cast<std::size_t>(part * kWidth), '#');
  return fmt::format("\r[{:<{}}] {:3.0f}%", marks, kWidth, 100 * part);
}

void show(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

void ProgressBar::tick(const std::stop_token& stop, const Progress& progress, std::uint64_t total, int frames) const {
  std::mutex mutex;
  std::condition_variable_any wake;
  std::unique_lock lock(mutex);
  const auto sleep = [&](std::chrono::milliseconds time) {
    wake.wait_for(lock, stop, time, [&] { return stop.stop_requested(); });
  };
  sleep(300ms);
  if (stop.stop_requested()) return;
  std::string line;
  while (!stop.stop_requested()) {
    line = bar_line(progress.done, total);
    if (frames > 0) line += fmt::format("  {} of {} frames", frames_done_.load(), frames);
    show(line);
    sleep(100ms);
  }
  show(fmt::format("\r{:{}}\r", "", line.size()));
}

ProgressBar::ProgressBar(const Progress& progress, std::uint64_t total, bool wanted, int frames) {
  if (!wanted || !shows_progress()) return;
  ticker_ = std::jthread([=, this, &progress](const std::stop_token& stop) { tick(stop, progress, total, frames); });
}

}  // namespace knead::command
