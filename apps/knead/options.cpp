#include "options.h"

namespace knead::command {

void add_common_options(std::vector<Option>& options, CommonOptions& common) {
  options.push_back({"-q,--quiet", &common.quiet, "Only errors, and what was asked for with --json or --report"});
  options.push_back({"--json", &common.json, "The result as one JSON object on standard output"});
}

}  // namespace knead::command
