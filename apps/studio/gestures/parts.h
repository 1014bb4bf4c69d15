// Parts of the shape that a pose holds or moves rigidly: marked on its vertices, followed as the shape changes.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gestures/tools.h"
#include "knead/replay.h"

namespace knead::studio {

inline constexpr std::size_t kMaxParts = 250;

// Returns whether there is a part on the vertex, and its number from 0.
std::optional<std::size_t> part_of(const PartMarks& parts, std::uint32_t vertex);

// Marks a new part, which holds and is selected; what it takes away from others they lose. Returns its number; nothing
// where there are no vertices, or too many parts.
std::optional<std::size_t> add_part(std::span<const std::uint32_t> vertices, const ShapeState& state, PartMarks& parts);

// Adds vertices to a part, or with nothing frees them of any.
void mark(std::span<const std::uint32_t> vertices, std::optional<std::size_t> part, const ShapeState& state,
          PartMarks& parts);

void remove_part(std::size_t part, PartMarks& parts);

// Removes the parts that have lost all their vertices.
void remove_empty_parts(PartMarks& parts);

void select_part(std::optional<std::size_t> part, PartMarks& parts);

// Takes the parts over to a later or earlier state of the shape, and puts the gizmo where the selected one is now. On a
// mesh that is new to them, a vertex keeps its part; one that remeshing has made is of the part of a neighbour.
void follow(PartMarks& parts, const ShapeState& state);

// Returns the vertices of a part.
std::vector<std::uint32_t> vertices_of(const PartMarks& parts, std::size_t part);

// Returns the joint of a part: the middle of its border, z pointing from there to its middle. Without a border that is
// its middle, with the axes of the scene. Nothing for a part without vertices.
std::optional<Placement> joint_of(const PartMarks& parts, std::size_t part, const ShapeState& state);

}  // namespace knead::studio
