#include "options.h"

#include <fmt/format.h>

#include "command.h"

namespace knead::command {

void add_common_options(std::vector<Option>& options, CommonOptions& common) {
  options.push_back({"-q,--quiet", &common.quiet, "Print only errors, and what --json or --report ask for"});
  options.push_back({"--json", &common.json, "Print the result as one JSON object on standard output"});
}

int threads_of(const std::optional<int>& threads) {
  constexpr int most = 1024;  // as many as the largest machines have
  if (!threads) return 0;
  if (*threads >= 1 && *threads <= most) return *threads;
  throw UsageError(fmt::format("--threads {}: give 1 to {}, or leave it out to use all", *threads, most));
}

}  // namespace knead::command
