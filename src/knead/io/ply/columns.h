// Reading binary rows of equal length, many at a time and one property after the other.
#pragma once

#include <string>
#include <vector>

#include "knead/io/ply/body.h"
#include "knead/io/ply/target.h"

namespace knead::io_detail::ply {

// Reads an element whose only list, if it has one, is that of the faces' vertices. Rows are read together as long as
// their lists have the same length.
void read_columns(BinaryBody& body, const Element& element, const std::vector<Sink>& sinks, Target& target);

// The fewest bytes that a row takes: in text a digit and what ends it for each number, else those of empty lists.
std::size_t smallest_row(const Element& element, bool ascii);

// Sets memory aside for an element that `left` bytes may hold, never for more.
void reserve_rows(const Element& element, const std::vector<Sink>& sinks, std::size_t left, bool ascii, Target& target);

std::string index_message(double index, std::size_t vertices);

}  // namespace knead::io_detail::ply
