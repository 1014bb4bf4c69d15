// The numbers of pins as their kernel reads them (kernel_pins.h). Internal to the flow room.
#pragma once

#include <array>
#include <vector>

#include "knead/flow/kernel.h"
#include "knead/flow/pin_equations.h"
#include "knead/flow/pins.h"

namespace knead::detail {

// The pins of one piece of a segment, relative to a centre, and everything that the kernel's field points to.
template <class S>
struct OwnedPins {
  PinKernelField<S> field;
  std::vector<S> numbers;
  std::vector<S> turn_numbers;
  std::vector<ExactPin> exact;

  OwnedPins(const Segment& segment, const PinPiece& piece, const Vec3d& center, bool masked) {
    field.center = center;
    field.radius = segment.fields.front().thresholds.outer;
    field.degree = piece.degree;
    for (std::size_t i = 0; i < segment.fields.size(); ++i) add_pin(segment, piece, i);
    for (std::size_t i = 0; i < segment.turns.size(); ++i) add_turn(segment, piece, i);
    field.pins = {numbers.data(), static_cast<int>(exact.size()), 9 + 3 * piece.degree};
    field.turns = {turn_numbers.data(), static_cast<int>(segment.turns.size()), 15 + 9 * piece.degree};
    field.exact = exact.data();
    field.per_radius = static_cast<S>(1 / field.radius);
    field.middle = static_cast<S>(0.5 * (piece.begin + piece.end));
    field.per_half = static_cast<S>(2 / (piece.end - piece.begin));
    field.begin = segment.begin;
    field.end = segment.end;
    if (masked) field.mask = view_of<S>(segment.mask, field.center);
  }
  OwnedPins(const OwnedPins&) = delete;
  OwnedPins& operator=(const OwnedPins&) = delete;
  ~OwnedPins() = default;

 private:
  static void add(const Vec3d& v, std::vector<S>& list) {
    for (std::size_t axis = 0; axis < 3; ++axis) list.push_back(static_cast<S>(v[axis]));
  }

  void add_pin(const Segment& segment, const PinPiece& piece, std::size_t i) {
    const Vec3d place = segment.fields[i].center - field.center;
    const Vec3d by = displacement_of(segment, segment.fields[i]);
    add(place / field.radius, numbers);
    add(by / field.radius, numbers);
    for (std::size_t k = 0; k <= static_cast<std::size_t>(piece.degree); ++k) add(piece.power(i, k), numbers);
    exact.push_back({place, by, norm(by)});
  }

  void add_turn(const Segment& segment, const PinPiece& piece, std::size_t i) {
    const ExactPin& pin = exact[segment.turns[i].pin];
    add(pin.place / field.radius, turn_numbers);
    add(pin.by / field.radius, turn_numbers);
    const std::size_t node = segment.fields.size() + kNodesOfTurn * i;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(piece.degree); ++k) {
      const TurnKernel turn =
          turn_kernel(std::array{piece.power(node, k), piece.power(node + 1, k), piece.power(node + 2, k)});
      add(turn.rate, turn_numbers);
      add({turn.strain.row0.x, turn.strain.row1.y, turn.strain.row2.z}, turn_numbers);
      add({turn.strain.row0.y, turn.strain.row0.z, turn.strain.row1.z}, turn_numbers);
    }
  }
};

}  // namespace knead::detail
