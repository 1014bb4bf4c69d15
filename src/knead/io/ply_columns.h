// Reading binary rows of equal length, many at a time and one property after the other.
#pragma once

#include <string>
#include <vector>

#include "knead/io/ply_body.h"
#include "knead/io/ply_target.h"

namespace knead {

// Reads an element whose only list, if it has one, is that of the faces' vertices. Rows are read together as long as
// their lists have the same length.
void read_columns(PlyBinaryBody& body, const PlyElement& element, const std::vector<PlySink>& sinks, PlyTarget& target);

// The fewest bytes that a row takes: in text a digit and what ends it for each number, else those of empty lists.
std::size_t smallest_row(const PlyElement& element, bool ascii);

// Sets memory aside for an element that `left` bytes may hold, never for more.
void reserve_rows(const PlyElement& element, const std::vector<PlySink>& sinks, std::size_t left, bool ascii,
                  PlyTarget& target);

std::string ply_index_message(std::int64_t index, std::size_t vertices);

}  // namespace knead
