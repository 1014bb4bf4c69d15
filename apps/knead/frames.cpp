#include "frames.h"

#include <fmt/format.h>

#include <cmath>

#include "command.h"

namespace knead::command {
namespace {

[[noreturn]] void fail(const std::string& text) {
  throw UsageError(
      fmt::format("--output {}: with --frames, give a pattern with one %d or %04d for the number, as in F_%04d.ply; "
                  "write %% for a percent sign",
                  text));
}

// The length of the conversion after a percent sign, and its width; a length of 0: none.
struct Conversion {
  std::size_t length = 0;
  int width = 0;
};

Conversion conversion_at(std::string_view rest) {
  if (rest.starts_with('d')) return {1, 0};
  const bool padded = rest.size() >= 3 && rest[0] == '0' && rest[1] >= '1' && rest[1] <= '9' && rest[2] == 'd';
  if (padded) return {3, rest[1] - '0'};
  return {};
}

}  // namespace

void add_time_options(std::vector<Option>& options, FrameFlags& flags) {
  options.insert(
      options.end(),
      {{"--fps", &flags.fps, "Frames a second of an animation or film (default: 24)", "F"},
       {"--ease", &flags.ease, "How time runs over the frames: linear, or smooth (slowly at both ends)",
        "linear|smooth", OptionKind::with_default},
       {"--hold", &flags.hold, "So many more frames of the start at the beginning, and of the end at the end", "N"}});
}

void check_fps(const FrameFlags& flags) {
  if (const double fps = flags.frames_per_second(); !(fps > 0) || !std::isfinite(fps)) {
    throw UsageError(fmt::format("--fps {}: give a number above 0, such as 24", fps));
  }
}

FrameOptions frame_options(const FrameFlags& flags) {
  check_fps(flags);
  if (flags.ease != "linear" && flags.ease != "smooth") {
    throw UsageError(fmt::format("--ease {}: say linear or smooth", flags.ease));
  }
  FrameOptions frames;
  frames.count = flags.frames.value_or(0);
  frames.ease = flags.ease == "smooth" ? Ease::smooth : Ease::linear;
  frames.hold = flags.hold.value_or(0);
  if (flags.frames && (frames.count < 1 || frames.count > kMaxFrames)) {
    throw UsageError(fmt::format("--frames {}: give 1 to {}", frames.count, kMaxFrames));
  }
  if (frames.hold < 0 || frames.hold > kMaxFrames) {
    throw UsageError(fmt::format("--hold {}: give 0 to {} frames", frames.hold, kMaxFrames));
  }
  if (!flags.frames && (flags.fps || flags.hold || frames.ease != Ease::linear)) {
    throw UsageError("--fps, --ease and --hold are for --frames N; give it too, or leave them out");
  }
  return frames;
}

FramePattern parse_frame_pattern(const std::string& text) {
  FramePattern pattern;
  bool found = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& part = found ? pattern.after : pattern.before;
    if (text[i] != '%') {
      part += text[i];
      continue;
    }
    if (i + 1 < text.size() && text[i + 1] == '%') {
      part += '%';
      ++i;
      continue;
    }
    const Conversion conversion = conversion_at(std::string_view(text).substr(i + 1));
    if (conversion.length == 0 || found) fail(text);
    found = true;
    pattern.width = conversion.width;
    i += conversion.length;
  }
  if (!found) fail(text);
  return pattern;
}

std::string frame_path(const FramePattern& pattern, int index) {
  return fmt::format("{}{:0{}}{}", pattern.before, index, pattern.width, pattern.after);
}

}  // namespace knead::command
