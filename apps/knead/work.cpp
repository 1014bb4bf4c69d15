#include "work.h"

#include <fmt/format.h>

#include "command.h"
#include "interrupt.h"
#include "knead/math/error.h"
#include "output.h"
#include "progress_bar.h"

namespace knead::command {

Inputs read_inputs(const std::string& shape, const StreamFormat& format, const std::string& session, bool quiet) {
  Inputs inputs;
  inputs.session = without_off(read_session(session));  // first: it is the shorter, and the one that people mistype
  inputs.shape = read_shape_or_stream(shape, format);
  if (!quiet) {
    print_notes(inputs.session.warnings);
    for (const std::string& note : inputs.shape.notes) print_message(fmt::format("note: {}: {}", shape, note));
  }
  return inputs;
}

ReplayResult replay_watched(const Mesh& mesh, const Session& session, ReplayOptions options, bool quiet) {
  Progress progress;
  options.progress = &progress;
  ReplayResult result;
  {
    const CancelOnInterruption cancel(progress);
    const ProgressBar bar(progress, total_work(mesh, session, options), !quiet);
    result = replay(borrow(mesh), session, options);
  }
  if (progress.cancel) throw Interrupted{};
  if (result.status == AdvectStatus::step_limit) {
    throw QualityError(
        to_string(Place{session.name, result.failed_line}) +
        ": a path line runs to infinity or needs over a million steps here; use a wider transition, a smaller angle, "
        "another gauge, or a larger --tolerance");
  }
  if (!quiet) print_notes(result.warnings);
  return result;
}

}  // namespace knead::command
