// Long work beside Python: the GIL is released, Ctrl-C and a callback end it.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/replay.h"

namespace knead::python {

namespace py = pybind11;

// A quality that was asked for was not reached; and what this machine or build lacks.
class AccuracyError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};
class UnavailableError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Runs the work in a thread of its own, without the GIL, and waits. Meanwhile handles signals, which may raise
// KeyboardInterrupt, and calls callback(fraction) a few times a second unless it is None. Sets progress.cancel, and
// waits until the work has ended, where either of them raises, or the callback returns False. Returns false in the
// latter case, else true. Rethrows what the work throws, but not Cancelled where it was asked for.
bool run_watched(const py::object& callback, Progress& progress, const std::function<void()>& work);

// Gives each sentence as a UserWarning, which may raise an error.
void warn(const std::vector<std::string>& sentences);

// Throws AccuracyError for the status step_limit.
void require_done(AdvectStatus status, const Session& session, std::size_t failed_line);

// Returns replay() of the session, run by run_watched(); nothing where that returns false. Replaces options.progress.
// Throws AccuracyError for the status step_limit. The mesh must outlive the result.
std::optional<ReplayResult> replay_watched(const py::object& callback, const Mesh& mesh, const Session& session,
                                           ReplayOptions options);

}  // namespace knead::python
