// The subcommands of `knead`. Each has a file, which parses, calls the library and prints.
#pragma once

#include <stdexcept>

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
Subcommand bench_command();
Subcommand studio_command();

}  // namespace knead::command
