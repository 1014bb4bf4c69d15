#include "work.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "command.h"
#include "interrupt.h"
#include "knead/error.h"
#include "output.h"
#include "progress_bar.h"

namespace knead::command {

namespace {

constexpr std::size_t kMaxKeptBytes = std::size_t{64} << 20;  // of a file that can be read again

}  // namespace

Inputs read_inputs(const std::string& shape, const StreamFormat& format, const std::string& session, bool quiet) {
  Inputs inputs;
  inputs.session = without_off(read_session(session));  // first: it is the shorter, and the one that people mistype
  inputs.shape = read_shape_or_stream(shape, format, {.most_kept_bytes = kMaxKeptBytes});
  if (!quiet) {
    print_notes(inputs.session.warnings);
    for (const std::string& note : inputs.shape.notes) print_message(fmt::format("note: {}: {}", shape, note));
  }
  return inputs;
}

ReplayResult replay_watched(const Mesh& mesh, const Session& session, ReplayOptions options, bool quiet) {
  Progress progress;
  options.progress = &progress;
  options.strokes_warn = false;
  if (!quiet) print_notes(stroke_warnings(session, options.part));
  ReplayResult result;
  {
    std::optional<CancelOnInterruption> cancel(std::in_place, progress);
    progress.total = total_work(mesh, session, options);
    const int frames = frame_count(options.frames);
    ProgressBar bar(progress, progress.total, !quiet, frames);
    if (const auto deliver = options.frames.deliver) {
      // From the last frame on, an interruption that comes when all files are in place is none.
      options.frames.deliver = [&, deliver](const ReplayFrame& frame) {
        if (frame.index + 1 == frames) cancel.reset();
        if (progress.cancel) throw Interrupted{};
        deliver(frame);
        bar.count_frame();
      };
    }
    result = replay(borrow(mesh), session, options);
  }
  if (progress.cancel) throw Interrupted{};
  if (result.status == AdvectStatus::step_limit) {
    throw QualityError(to_string(Place{session.name, result.failed_line}) + ": " + kStepLimitAdvice);
  }
  if (!quiet) print_notes(result.warnings);
  return result;
}

}  // namespace knead::command
