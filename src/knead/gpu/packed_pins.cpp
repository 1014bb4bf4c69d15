#include "knead/gpu/packed_pins.h"

#include <algorithm>
#include <span>
#include <utility>

#include "knead/flow/owned_pins.h"
#include "knead/flow/pins.h"
#include "knead/flow/segment_mover.h"
#include "knead/flow/step_rule.h"
#include "knead/gpu/packed_bounds.h"
#include "knead/math/box.h"

namespace knead::gpu {

namespace {

using namespace layout;
using detail::OwnedPins;
using detail::PinPiece;

// Pins to a call of a shader, each counted for every piece of time: graphics drivers stop what takes seconds.
constexpr std::size_t kMostPins = 4096;

Vec3d middle_of(const Segment& segment) {
  Box box;
  for (const Field& pin : segment.fields) box.extend(pin.center);
  return box.center();
}

// Fills one pack with pieces of the segment's time, each as a segment of its own.
class PinPacker {
 public:
  PinPacker(const Segment& segment, const AdvectOptions& options)
      : segment_(segment), options_(options), middle_(middle_of(segment)), pins_(segment.fields.size()) {}

  PackedSegments run(std::span<const PinPiece> pieces) {
    packed_ = {};
    packed_.count = static_cast<int>(pieces.size());
    packed_.numbers.resize(pieces.size() * kSegmentNumbers);
    packed_.places.resize(pieces.size() * (kSegmentPlaces + pins_ * kFieldBounds));
    packed_.table.resize(pieces.size() * (kSegmentEntries + pins_ * kFieldEntries));
    Segment part = segment_;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      part.begin = pieces[i].begin;
      part.end = pieces[i].end;
      if (segment_.end < segment_.begin) std::swap(part.begin, part.end);
      const std::size_t table = pieces.size() * kSegmentEntries + i * pins_ * kFieldEntries;
      const std::size_t bounds = pieces.size() * kSegmentPlaces + i * pins_ * kFieldBounds;
      const OwnedPins<double> pins(part, pieces[i], middle_, false);
      put_part(part, pins, i, table);
      put_pins(part, pins, table, bounds);
    }
    return std::move(packed_);
  }

 private:
  void put_part(const Segment& part, const OwnedPins<double>& pins, std::size_t i, std::size_t table) {
    double speed = 0;
    for (const detail::ExactPin& pin : pins.exact) speed = std::max(speed, pin.speed);
    double* const numbers = packed_.numbers.data() + i * kSegmentNumbers;
    numbers[3] = speed;
    numbers[kReach] = detail::reach_of_step(part);
    numbers[kTolerance] = detail::kErrorShare * options_.tolerance;
    numbers[kLeast] = kLeastMotion * pins.field.radius;
    numbers[kPerRadius] = pins.field.per_radius;
    numbers[kMiddle] = pins.field.middle;
    numbers[kPerHalf] = pins.field.per_half;
    put(packed_.places, i * kSegmentPlaces, middle_);
    packed_.places[i * kSegmentPlaces + 6] = part.begin;
    packed_.places[i * kSegmentPlaces + 7] = part.end;
    std::int32_t* const entries = packed_.table.data() + i * kSegmentEntries;
    entries[0] = static_cast<std::int32_t>(pins_);
    entries[1] = static_cast<std::int32_t>(table);
    entries[3] = static_cast<std::int32_t>(i * kSegmentNumbers);
  }

  // The pins' numbers, then those of the turns.
  void put_pins(const Segment& part, const OwnedPins<double>& pins, std::size_t table, std::size_t bounds) {
    const std::size_t begin = packed_.numbers.size();
    packed_.numbers.insert(packed_.numbers.end(), pins.numbers.begin(), pins.numbers.end());
    const std::size_t turns = packed_.numbers.size();
    packed_.numbers.insert(packed_.numbers.end(), pins.turn_numbers.begin(), pins.turn_numbers.end());
    for (std::size_t pin = 0; pin < pins_; ++pin) {
      std::int32_t* const entries = packed_.table.data() + table + pin * kFieldEntries;
      const std::size_t own_bounds = bounds + pin * kFieldBounds;
      entries[kFieldBegin] = static_cast<std::int32_t>(begin) + static_cast<std::int32_t>(pin) * pins.field.pins.stride;
      entries[kBounds] = static_cast<std::int32_t>(own_bounds);
      entries[kDegree] = pins.field.degree;
      entries[kFirstTurn] = static_cast<std::int32_t>(turns);
      entries[kTurns] = pins.field.turns.count;
      put_bounds(packed_.places, own_bounds, part.fields[pin], part);
    }
  }

  const Segment& segment_;
  const AdvectOptions& options_;
  Vec3d middle_;
  std::size_t pins_;
  PackedSegments packed_;
};

}  // namespace

std::vector<PackedSegments> pack_pins(const Segment& segment, const AdvectOptions& options) {
  std::vector<PinPiece> pieces = detail::solve_pins(segment, options.tolerance, options.progress);
  if (segment.end < segment.begin) std::reverse(pieces.begin(), pieces.end());
  PinPacker packer(segment, options);
  const std::size_t length = std::max<std::size_t>(kMostPins / segment.fields.size(), 1);
  std::vector<PackedSegments> packs;
  for (std::span<const PinPiece> rest = pieces; !rest.empty();) {
    const std::span<const PinPiece> next = rest.first(std::min(length, rest.size()));
    packs.push_back(packer.run(next));
    rest = rest.subspan(next.size());
  }
  return packs;
}

}  // namespace knead::gpu
