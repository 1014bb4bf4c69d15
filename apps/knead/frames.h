// The file names of --frames: a pattern with one %d or %0Nd.
#pragma once

#include <string>

namespace knead::command {

struct FramePattern {
  std::string before;
  int width = 0;  // digits, filled up with zeros; 0: as many as it takes
  std::string after;
};

// Throws UsageError unless the text holds exactly one %d or %0Nd (N from 1 to 9); %% stands for %.
FramePattern parse_frame_pattern(const std::string& text);

std::string frame_path(const FramePattern& pattern, int index);

}  // namespace knead::command
