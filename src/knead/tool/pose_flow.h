// What poses and bends of a body have in common: from a surface to the body that is posed, and to its flow. Internal to
// the tool room.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "knead/flow/segment.h"
#include "knead/pose/pose_motion.h"
#include "knead/tool/live_surface.h"
#include "knead/tool/pose.h"

namespace knead::tool_detail {

// Of the box around what triangles use, or around a cloud.
double diagonal_of(const LiveSurface& surface);

// Returns a part that holds: evenly spread ones of its points, enough for a grid of that spacing.
detail::PosedPart part_of(const std::vector<Vec3d>& all, double spacing);

inline constexpr std::size_t kSamplesInside = 4000;  // of a body

// Returns samples of the body for a grid of that spacing, about so many of them inside it. Adds a warning if the
// surface is open.
detail::BodySamples body_of(const LiveSurface& surface, double spacing, std::size_t inside, int threads,
                            std::vector<std::string>& warnings);

// Returns what a pose on the surface is, in numbers. Throws as pose_on. Adds a warning if the surface is open.
detail::PoseProblem problem_of(const PoseStroke& stroke, const LiveSurface& surface, std::size_t inside, int threads,
                               std::vector<std::string>& warnings);

// Returns for each point the number of the nearest position.
std::vector<std::uint32_t> nearest_of(std::span<const Vec3d> positions, const std::vector<Vec3d>& points);

// Solves the problem; the flow gets one segment for each grid.
detail::PoseOutcome find_flow(detail::PoseProblem problem, Flow& flow);

// Sets the stretches of the result: how the flow stretches the surface at evenly spread points.
void measure_stretch(const Flow& flow, const LiveSurface& surface, double diagonal, int threads, PoseResult& result);

// Passes each grid of the flow to surface.apply; returns false if that did.
bool apply_grids(const Flow& flow, const LiveSurface& surface);

}  // namespace knead::tool_detail
