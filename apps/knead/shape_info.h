// What `knead info` and `knead check` print about a shape as text.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "knead/certify.h"

namespace knead::command {

// Return a row for each key except the notes; and the rows of the notes.
std::string table_of(const ShapeInfo& info);
std::string table_of(const ShapeSummary& summary);
std::string table_of_notes(std::span<const std::string> notes);
std::string row(std::string_view name, std::string_view value);

}  // namespace knead::command
