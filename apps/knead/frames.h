// The options --frames, --fps, --ease and --hold, and the file names of frames: a pattern with one %d or %0Nd.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "knead/replay.h"
#include "options.h"

namespace knead::command {

struct FrameFlags {
  std::optional<int> frames;
  std::optional<double> fps;
  std::string ease = "linear";
  std::optional<int> hold;

  double frames_per_second() const { return fps.value_or(24); }
};

// Appends --fps, --ease and --hold.
void add_time_options(std::vector<Option>& options, FrameFlags& flags);

// Throws UsageError for values out of range, and for a time without frames.
FrameOptions frame_options(const FrameFlags& flags);

// Throws UsageError unless the frames per second, if given, are a number above 0.
void check_fps(const FrameFlags& flags);

// Returns whether a name is a pattern, or wants to be one.
inline bool is_pattern(const std::string& name) { return name.find('%') != std::string::npos; }

struct FramePattern {
  std::string before;
  int width = 0;  // digits, filled up with zeros; 0: as many as it takes
  std::string after;
};

// Throws UsageError unless the text holds exactly one %d or %0Nd (N from 1 to 9); %% stands for %.
FramePattern parse_frame_pattern(const std::string& text);

std::string frame_path(const FramePattern& pattern, int index);

}  // namespace knead::command
