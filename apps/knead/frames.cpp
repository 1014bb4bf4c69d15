#include "frames.h"

#include <fmt/format.h>

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
