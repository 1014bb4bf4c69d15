// The options of a subcommand as data, from which the parser, the help, completions and a manual page can be made.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
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

}  // namespace knead::command
