// The numbers of strokes that a person may want to change afterwards.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/session.h"

namespace knead::studio {

struct StrokeField {
  std::string name;  // its key in the session file
  std::string help;
  double value = 0;  // of the first stroke that has it
};

// Of the strokes of one entry, each name once.
std::vector<StrokeField> fields_of(std::span<const SessionStroke> strokes);

// Gives the first stroke that has the field this value, and changes that of all others by the same factor: mirror
// images have their own signs. Does nothing where no stroke has such a field.
void set_field(std::span<SessionStroke> strokes, const std::string& name, double value);

// Returns the falloff of the first stroke that has one.
std::optional<int> falloff_of(std::span<const SessionStroke> strokes);

// Gives all strokes that have one this falloff.
void set_falloff(std::span<SessionStroke> strokes, int falloff);

}  // namespace knead::studio
