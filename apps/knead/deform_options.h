// The command line of `knead deform`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "knead/session/replay.h"
#include "remesh_options.h"

namespace knead::command {

struct DeformOptions {
  std::string shape;
  std::string session;
  std::string output;
  double tolerance = 1e-5;
  std::string integrator = "tsit5";
  std::string precision = "float";
  std::string backend = "cpu";
  std::optional<int> threads;
  bool inverse = false;
  bool check = false;
  std::optional<std::string> require;
  RemeshFlags remesh;
  std::optional<double> until;
  std::optional<int> frames;
  std::string report;
  CommonOptions common;
};

// The options of the subcommand, whose values go to `options`.
std::vector<Option> describe(DeformOptions& options);

// Throws UsageError for values out of range.
ReplayOptions replay_options(const DeformOptions& options);

}  // namespace knead::command
