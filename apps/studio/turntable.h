// A recording of the shape from all around: numbered pictures, evenly spaced about the axis that is up.
#pragma once

#include <filesystem>

#include "gestures/navigation.h"

namespace knead::studio {

inline constexpr int kMaxTurntablePictures = 9999;

struct Turntable {
  std::filesystem::path pattern;  // with %04d in its name
  int pictures = 0;
  int next = 0;  // the number of the next picture, from 0
  View start;    // the view of the first picture, which is also that afterwards
};

// Returns a recording that has not begun, with a numbered() pattern. Throws InvalidInput for another format than PNG,
// and for a number of pictures outside [2, kMaxTurntablePictures].
Turntable make_turntable(const std::filesystem::path& pattern, int pictures, const View& view);

// Return the view and the file of the next picture.
View view_of(const Turntable& turntable);
std::filesystem::path file_of(const Turntable& turntable);

}  // namespace knead::studio
