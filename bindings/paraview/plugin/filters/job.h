// One run of the filter: a session applied to all blocks of a data object, together with the other ranks.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "blocks.h"
#include "cells.h"
#include "knead/error.h"
#include "knead/replay.h"
#include "ranks.h"

namespace knead::paraview {

// The properties of the filter.
struct Settings {
  std::string session_file;
  double relative_tolerance = kDefaultRelativeTolerance;
  double diagonal = 0;                 // 0: of all points
  std::optional<Precision> precision;  // std::nullopt: float64 if there are cells with a volume
  bool inverse = false;
  double until = 0;
  bool quality = true;
  bool fail_on_inversion = true;
  std::vector<std::string> vectors;
};

// Does the work beside the main thread, which reports the progress; throws Cancelled if it was aborted.
using Watch = std::function<void(Progress& progress, const std::function<void()>& work)>;

// The result of a run, the same on all ranks.
struct Findings {
  std::vector<std::string> notes;
  std::int64_t inverted = 0;
};

// Reads a session that is applied to points alone. Throws InvalidInput for a stroke that reads the surface, with the
// command that resolves it.
Session read_flow_session(const std::string& path);

// Moves the points of all blocks, and adds arrays. Throws Failure, the same on all ranks.
Findings knead_blocks(std::vector<Block>& blocks, const Settings& settings, const Ranks& ranks, const Watch& watch);

}  // namespace knead::paraview
