// Pins that take a surface to its matches (knead fit --surface). Internal to the session room.
#pragma once

#include <span>
#include <vector>

#include "knead/session/fit_matches.h"
#include "knead/tool/stroke.h"

namespace knead::session_detail {

// Landmarks, where they are and where they belong.
struct FitLandmarks {
  std::vector<Vec3d> at;
  std::vector<Vec3d> to;
};

// How the field of the pins is made.
struct PinFieldOptions {
  double radius = 0;                   // of the pins
  double smoothness = 0;               // what the field's norm counts beside the matches
  const Progress* progress = nullptr;  // cancels
};

// Returns pins that are evenly spaced on the samples, the landmarks among them first. Landmarks go to their places. All
// other pins move as the smoothest divergence-free field of this radius does that brings the matches together: by least
// squares, so that pins slip along the surface where nothing tells them how to move along it. Motions are so small that
// no two pins come near each other. Throws Cancelled.
PinsStroke fit_pins(std::span<const Match> matches, std::span<const SurfaceSample> samples,
                    const FitLandmarks& landmarks, const PinFieldOptions& options);

// The distance of neighbouring pins, in radii. With 0.4 the fields are too rough: fits end three to six times as far
// away.
inline constexpr double kPinSpacing = 0.25;

}  // namespace knead::session_detail
