// The subcommands of `knead`, a file each: parse, call the library, print.
#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <stdexcept>
#include <string>

namespace knead::command {

// The exit codes of the command.
enum ExitCode : int {
  kDone = 0,
  kInternalError = 1,
  kWrongUsage = 2,
  kInvalidInput = 3,
  kQualityNotMet = 4,
  kOutputFailed = 5,
  kInterrupted = 130,
};

// Wrong usage of the command line; the message is followed by a pointer to --help.
class UsageError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

// A quality that was asked for could not be had.
class QualityError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The user ended the program while it worked.
struct Interrupted {};

// A subcommand on the command line, and what it does once that is parsed. run throws UsageError, QualityError,
// Interrupted, or what the library throws.
struct Subcommand {
  CLI::App* app = nullptr;
  std::function<void()> run;
};

Subcommand add_deform(CLI::App& parent);
Subcommand add_resolve(CLI::App& parent);
Subcommand add_info(CLI::App& parent);
Subcommand add_check(CLI::App& parent);
Subcommand add_make(CLI::App& parent);
Subcommand add_remesh(CLI::App& parent);
Subcommand add_render(CLI::App& parent);
Subcommand add_bench(CLI::App& parent);
Subcommand add_studio(CLI::App& parent);

// The options that every subcommand has.
struct CommonOptions {
  bool quiet = false;
  bool json = false;
};
void add_common_options(CLI::App& app, CommonOptions& options);

// The examples under the help of a subcommand.
void add_examples(CLI::App& app, const std::string& examples);

}  // namespace knead::command
