// The subcommands of `knead`, which parse, call the library and print; and their options as data, from which the
// parser, the help, completions and manual pages are made.
#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace knead::command {

// An enum whose values are 0, 1, ... in the order of the words.
struct WordTarget {
  std::vector<std::string> words;
  std::size_t chosen = 0;  // before parsing
  std::function<void(std::size_t)> choose;
};

template <class E>
WordTarget word_target(E& target, std::vector<std::string> words) {
  return {std::move(words), static_cast<std::size_t>(target),
          [&target](std::size_t chosen) { target = static_cast<E>(chosen); }};
}

// Where the value of an option goes. An std::optional stays empty if the option is not given.
using OptionTarget =
    std::variant<bool*, int*, double*, std::string*, std::vector<std::string>*, std::optional<int>*,
                 std::optional<double>*, std::optional<std::size_t>*, std::optional<std::string>*, WordTarget>;

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
  // Of a number: which ones are accepted, and what is said to others, as "give 0 to 100". Empty: all are.
  std::function<bool(double)> accepts = {};
  std::string advice = {};
};

// Which numbers an option accepts.
inline bool is_above_zero(double number) { return number > 0 && std::isfinite(number); }
inline bool is_not_negative(double number) { return number >= 0 && std::isfinite(number); }
inline auto from_to(double least, double most) {
  return [=](double number) { return number >= least && number <= most; };
}

// A subcommand and what it does once its options are parsed. run throws UsageError, QualityError, Interrupted, or what
// the library throws.
struct Subcommand {
  std::string name;
  std::string help;
  std::vector<Option> options;
  std::string examples;  // printed below the help
  std::function<void()> run;
};

// The options that nearly every subcommand has.
struct CommonOptions {
  bool quiet = false;
  bool json = false;
};
void add_common_options(std::vector<Option>& options, CommonOptions& common);
void add_threads_option(std::vector<Option>& options, int& threads);  // 0: all

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
Subcommand bend_command();
Subcommand twist_command();
Subcommand stretch_command();
Subcommand taper_command();
Subcommand wrap_command();
Subcommand print_command();
Subcommand lattice_command();
Subcommand resolve_command();
Subcommand fit_command();
Subcommand skin_command();
Subcommand info_command();
Subcommand check_command();
Subcommand make_command();
Subcommand remesh_command();
Subcommand refine_command();
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
