#include "options.h"

namespace knead::command {

void add_common_options(std::vector<Option>& options, CommonOptions& common) {
  options.push_back({"-q,--quiet", &common.quiet, "Print only errors, and what --json or --report ask for"});
  options.push_back({"--json", &common.json, "Print the result as one JSON object on standard output"});
}

}  // namespace knead::command
