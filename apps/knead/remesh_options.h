// The options that say how a mesh is remade, of `knead deform` and `knead remesh`.
#pragma once

#include <optional>
#include <vector>

#include "knead/remesh/remesh.h"
#include "options.h"

namespace knead::command {

struct RemeshFlags {
  bool remesh = false;
  std::optional<double> max_edge;
  std::optional<double> max_angle;  // degrees
  std::optional<double> max_chord;
  std::optional<double> min_edge;
  std::optional<int> iterations;
};

// The settings asked for, if any. Throws UsageError for one out of range.
std::optional<RemeshSettings> settings_of(const RemeshFlags& flags);

// --max-edge and --min-edge, which have a meaning without a deformation too.
void add_edge_options(std::vector<Option>& options, RemeshFlags& flags);

// --remesh, and all else that follows a deformation.
void add_remesh_options(std::vector<Option>& options, RemeshFlags& flags);

}  // namespace knead::command
