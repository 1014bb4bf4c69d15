// The options of `knead deform` and `knead remesh` that control remeshing.
#pragma once

#include <optional>
#include <vector>

#include "knead/remesh.h"
#include "options.h"

namespace knead::command {

struct RemeshFlags {
  bool remesh = false;
  std::optional<double> max_edge;
  std::optional<double> max_angle;  // degrees
  std::optional<double> max_chord;
  std::optional<double> min_edge;
  std::optional<int> iterations;
  std::optional<std::size_t> max_vertices;
  std::optional<double> seconds;
};

// Returns the settings that the options ask for, if any. Throws UsageError for a value out of range.
std::optional<RemeshSettings> settings_of(const RemeshFlags& flags);

// Adds --max-edge, --min-edge and --max-vertices, which also have a meaning without a deformation.
void add_edge_options(std::vector<Option>& options, RemeshFlags& flags);

// Adds --remesh and all options of remeshing after a deformation.
void add_remesh_options(std::vector<Option>& options, RemeshFlags& flags);

}  // namespace knead::command
