// The subcommands of `knead`. Each has a file, which parses, calls the library and prints.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "options.h"

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

// A quality that the user asked for was not reached.
class QualityError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The user ended the program while it worked.
struct Interrupted {};

// The reader of standard output has enough. Ends the command without a message.
struct ClosedPipe {};

Subcommand deform_command();
Subcommand resolve_command();
Subcommand fit_command();
Subcommand info_command();
Subcommand check_command();
Subcommand make_command();
Subcommand remesh_command();
Subcommand render_command();
// Starts knead-bench with these words.
Subcommand bench_command(const std::vector<std::string>& words);
Subcommand studio_command();

// The options of `knead bench`.
struct BenchOptions {
  std::vector<std::string> meshes;
  bool integrators = false;
  std::string backend = "cpu";
  std::optional<std::size_t> vertices;  // of a procedural knot
  CommonOptions common;
};

// Returns the subcommand `bench`, which calls `run` with the options. `knead` and `knead-bench` read the same ones.
Subcommand bench_subcommand(std::function<void(const BenchOptions&)> run);

// Throws UsageError unless the name is cpu, or gpu in a build that has that backend.
void check_backend(const std::string& name);

// Runs the subcommand that argv names, with its options. Returns the exit code; every failure is one line on standard
// error.
int run_program(int argc, char** argv, const std::vector<Subcommand>& subcommands);

}  // namespace knead::command
