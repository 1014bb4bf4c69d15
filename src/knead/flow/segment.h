// Segments and flows: deformations as plain values that contain no mesh (method, section 3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "knead/field/field.h"
#include "knead/field/mask.h"
#include "knead/field/potential_grid.h"

namespace knead {

// How the fields of a segment depend on its time t in [0, 1]:
//   swept:   they move with the tool's frame, c(t) = c + t displacement (and a half-space may turn);
//   blended: v(x, t) = (1 - t) v_c(x) + t v_{c + displacement}(x), two resting fields (paper, Eq. 9);
//   pinned:  each field is a pin, which moves by a displacement u of its own, the velocity of its motion: it is at
//            q(t) = c + t u, and v(q(t), t) = u for every pin (method, section 9). v is the sum of the fields with the
//            velocities a(t) for which that is so, in the place of u.
enum class TimeLaw { swept, blended, pinned };

// A barrel: only points within `radius` of the line {point + s direction} at the segment's t = 0 are moved.
struct SegmentBarrel {
  Vec3d point;
  Vec3d direction;  // a unit vector
  double radius = 0;

  friend bool operator==(const SegmentBarrel&, const SegmentBarrel&) = default;
};

// A pin about which the shape turns as a rigid body does: the Jacobian of the flow at the pin is the rotation by
// t |rate| about the direction of `rate` (with rate 0: it stays the identity).
struct PinTurn {
  std::uint32_t pin = 0;  // the number of its field
  Vec3d rate{0, 0, 0};    // radians per unit time

  friend bool operator==(const PinTurn&, const PinTurn&) = default;
};

// A sum has at most so many parts.
inline constexpr std::size_t kMostParts = 8;

// The sum of one or more fields over one unit of time, or v = curl A of a grid in their place. Path lines run from t =
// begin to t = end, both in [0, 1]: from 0 to 1 is the whole segment, from 1 to 0 its inverse, from 0 to 0.5 its first
// half.
struct Segment {
  std::vector<Field> fields;
  Vec3d displacement{0, 0, 0};
  TimeLaw time_law = TimeLaw::swept;
  std::optional<SegmentBarrel> barrel;
  Mask mask;  // of all fields
  double begin = 0;
  double end = 1;
  PotentialGrid grid{};          // not empty: there are no fields, no displacement, no barrel and no turns
  std::vector<PinTurn> turns{};  // of a pinned segment, by ascending pin; about other pins the shape turns as it will
  // Not empty: v is the sum of the velocities of these 2 to kMostParts segments, which act at the same time, as a
  // stroke and its mirror images do. Nothing else is given but the mask, `begin` and `end`, which are those of every
  // part. A barrel limits its part alone. A part is neither pinned nor a sum.
  std::vector<Segment> parts{};
  // Of a sum whose parts are each other's mirror images in a plane {x[axis] = *mirrored_at[axis]}, and of pins that
  // are: points of the plane stay in it exactly.
  std::array<std::optional<double>, 3> mirrored_at{};

  friend bool operator==(const Segment&, const Segment&) = default;
};

// Returns how far a field of the segment moves in one unit of time.
Vec3d displacement_of(const Segment& segment, const Field& field);

// Segments, applied one after the other.
struct Flow {
  std::vector<Segment> segments;

  friend bool operator==(const Flow&, const Flow&) = default;
};

// Returns the flow with the mask on all of its segments. Each field's vector potential gets a constant of its own where
// the mask is in its reach, so that little flows along the mask's border (docs/mathematics.md); it does not depend on
// `begin` and `end`.
Flow masked(Flow flow, const Mask& mask);

// Returns the flow that moves every point back.
Flow inverse(const Flow& flow);

// Returns the first `segments` segments of the flow, 0 <= segments <= flow.segments.size(). A fraction ends within a
// segment.
Flow prefix(const Flow& flow, double segments);

// Returns the flow from one moment to another, both in segments from the beginning and within the flow; backwards if
// to < from. Throws InvalidInput for a moment outside the flow.
Flow flow_between(const Flow& flow, double from, double to);

// Throws InvalidInput, naming the segment, if
//   - a number is not finite, or inner >= outer,
//   - an axis is not of unit length, or a strain not traceless,
//   - a point set is empty, or its exponent not an even number of at least 2,
//   - a blended segment is anything but the translation of a ball or capsule,
//   - a pinned segment is anything but translations of balls with inner = 0, falloff kPinFalloff and the same outer,
//     or has a displacement or barrel,
//   - a grid's spacing is not above 0, its counts are not those of its coefficients, or there are fields, a
//     displacement, a barrel or turns besides,
//   - a turn is none of a pin's, or the pins of turns do not ascend,
//   - a sum has 1 part, or more than kMostParts, or a field of its own, or a part that is pinned, a sum, masked or cut,
//   - begin or end lies outside [0, 1].
void validate(const Flow& flow);

}  // namespace knead
