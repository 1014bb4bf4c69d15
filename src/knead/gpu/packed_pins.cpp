#include "knead/gpu/packed_pins.h"

#include <algorithm>
#include <span>
#include <utility>

#include "knead/flow/pins.h"
#include "knead/flow/segment_mover.h"
#include "knead/flow/step_rule.h"
#include "knead/gpu/packed_bounds.h"
#include "knead/math/box.h"

namespace knead::gpu {

namespace {

using namespace layout;
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
      put_part(part, pieces[i], i, table);
      for (std::size_t pin = 0; pin < pins_; ++pin) {
        put_pin(part, pieces[i], pin, table + pin * kFieldEntries, bounds + pin * kFieldBounds);
      }
    }
    return std::move(packed_);
  }

 private:
  double radius() const { return segment_.fields.front().thresholds.outer; }

  void put_part(const Segment& part, const PinPiece& piece, std::size_t i, std::size_t table) {
    double speed = 0;
    for (const Field& pin : part.fields) speed = std::max(speed, norm(displacement_of(part, pin)));
    double* const numbers = packed_.numbers.data() + i * kSegmentNumbers;
    numbers[3] = speed;
    numbers[kReach] = detail::reach_of_step(part);
    numbers[kTolerance] = detail::kErrorShare * options_.tolerance;
    numbers[kLeast] = kLeastMotion * radius();
    numbers[kPerRadius] = 1 / radius();
    numbers[kMiddle] = 0.5 * (piece.begin + piece.end);
    numbers[kPerHalf] = 2 / (piece.end - piece.begin);
    put(packed_.places, i * kSegmentPlaces, middle_);
    packed_.places[i * kSegmentPlaces + 6] = part.begin;
    packed_.places[i * kSegmentPlaces + 7] = part.end;
    std::int32_t* const entries = packed_.table.data() + i * kSegmentEntries;
    entries[0] = static_cast<std::int32_t>(pins_);
    entries[1] = static_cast<std::int32_t>(table);
    entries[3] = static_cast<std::int32_t>(i * kSegmentNumbers);
  }

  void put_pin(const Segment& part, const PinPiece& piece, std::size_t pin, std::size_t table, std::size_t bounds) {
    const Field& field = part.fields[pin];
    packed_.table[table + kFieldBegin] = static_cast<std::int32_t>(packed_.numbers.size());
    packed_.table[table + kBounds] = static_cast<std::int32_t>(bounds);
    packed_.table[table + kDegree] = piece.degree;
    put_bounds(packed_.places, bounds, field, part);
    append((field.center - middle_) / radius());
    append(displacement_of(part, field) / radius());
    const std::size_t powers = static_cast<std::size_t>(piece.degree) + 1;
    for (std::size_t k = 0; k < powers; ++k) append(piece.coefficients[pin * powers + k]);
  }

  void append(const Vec3d& v) { packed_.numbers.insert(packed_.numbers.end(), {v.x, v.y, v.z}); }

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
