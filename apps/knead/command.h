// The subcommands of `knead`, which parse, call the library and print; and their options as data, from which the
// parser, the help, completions and manual pages are made.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace knead::command {

// Where the value of an option goes. An std::optional stays empty if the option is not given.
using OptionTarget = std::variant<bool*, double*, std::string*, std::vector<std::string>*, std::optional<int>*,
                                  std::optional<double>*, std::optional<std::size_t>*, std::optional<std::string>*>;

enum class OptionKind {
  optional,
  required,
  with_default,  // the value before parsing is shown in the help
};

struct Option {
  std::string name;     // "-o,--output", or "SHAPE" for an argument without a name
  OptionTarget target;  // a bool makes it a flag, which takes no value
  std::string help;
  std::string value_name = {};  // stands for the value in the help, e.g. "FILE"
  OptionKind kind = OptionKind::optional;
  std::vector<std::string> choices = {};  // empty: every value is accepted
};

// A subcommand and what it does once its options are parsed. run throws UsageError, QualityError, Interrupted, or what
// the library throws.
struct Subcommand {
  std::string name;
  std::string help;
  std::vector<Option> options;
  std::string examples;  // printed below the help
  std::function<void()> run;
};

// Returns the number of threads, 0 for all. Throws UsageError for a number that is none or too large.
int threads_of(const std::optional<int>& threads);

// The options that nearly every subcommand has.
struct CommonOptions {
  bool quiet = false;
  bool json = false;
};
void add_common_options(std::vector<Option>& options, CommonOptions& common);

// --- the subcommands of `knead`

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
Subcommand skin_command();
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
