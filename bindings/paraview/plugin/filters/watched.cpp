// Runs work in a thread, and passes progress and aborts on.
#include "watched.h"

#include <vtkAlgorithm.h>

#include <algorithm>
#include <chrono>
#include <future>

namespace knead::paraview {
namespace {

double fraction_of(const Progress& progress) {
  const std::uint64_t total = progress.total;
  return total == 0 ? 0 : std::min(1.0, static_cast<double>(progress.done) / static_cast<double>(total));
}

}  // namespace

void run_watched(vtkAlgorithm& filter, Progress& progress, const std::function<void()>& work) {
  std::future<void> done = std::async(std::launch::async, work);
  while (done.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
    filter.UpdateProgress(fraction_of(progress));
    if (filter.GetAbortExecute() != 0) progress.cancel = true;
  }
  done.get();
  stop_if_cancelled(&progress);
}

}  // namespace knead::paraview
