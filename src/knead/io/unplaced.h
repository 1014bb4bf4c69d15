// Vertices whose coordinates are not finite, as scanners write for what they did not see: they stay in the file as they
// are and are no part of the mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead::io_detail {

// Where such vertices are in a file: rows ascend, counted from 0 with all vertices of the file.
struct Unplaced {
  std::vector<std::uint32_t> rows;
  std::vector<std::size_t> begin;  // the byte of each row, for messages

  // Adds a row; the same one again is no other.
  void add(std::size_t row, std::size_t byte);
};

// Returns the number, in `unplaced`, of the first of these vertices that a face of the mesh uses.
std::optional<std::size_t> first_used(const Unplaced& unplaced, const Mesh& mesh);

// Removes the vertices, which no face uses, with their attributes, and renumbers the others.
void remove_unplaced(const Unplaced& unplaced, Mesh& mesh);

// Returns one value for each row of the file: those of the mesh's vertices, and zero for vertices without a place.
std::vector<Vec3d> by_row(std::span<const Vec3d> values, std::span<const std::uint32_t> unplaced);

// Returns the note that says so; empty without such vertices.
std::string unplaced_note(std::size_t count);

// Returns what a file that holds only the mesh leaves out; empty without such vertices.
std::string unplaced_loss(std::size_t count);

}  // namespace knead::io_detail
