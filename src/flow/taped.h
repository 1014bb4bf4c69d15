// Numbers that record how they are computed. One pass back over the record gives the derivatives of a result with
// respect to all variables, however many there are. Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "flow/varying.h"

namespace knead::detail {

class Tape;

// A constant, or a number on a tape. A number is equal to a constant only if it is one, so that a formula for a special
// value is not used where the value varies.
struct Taped : DerivativeRules<Taped> {
  double v = 0;
  Tape* tape = nullptr;    // null: a constant
  std::uint32_t node = 0;  // 0: a constant

  constexpr Taped() = default;
  template <class T>
  requires std::is_arithmetic_v<T>
  constexpr explicit Taped(T value) : v(static_cast<double>(value)) {}
  constexpr Taped(double value, Tape* on, std::uint32_t at) : v(value), tape(on), node(at) {}

  static Taped chain(double value, const Taped& a, double by_a, const Taped& b, double by_b);
  static Taped chain(double value, const Taped& a, double by_a) { return chain(value, a, by_a, Taped(), 0); }

  friend bool operator==(const Taped& a, const Taped& b) { return a.v == b.v && a.node == b.node; }
};

// The record. Its first numbers are usually variables that stay, and what depends on them is recorded anew for each
// result; the derivatives with respect to the variables add up.
class Tape {
 public:
  // Removes everything.
  void clear() {
    nodes_.assign(1, {});
    adjoints_.assign(1, 0);
  }

  Taped variable(double value) { return record(value, 0, 0, 0, 0); }

  Taped record(double value, std::uint32_t a, double by_a, std::uint32_t b, double by_b) {
    nodes_.push_back({by_a, by_b, a, b});
    return {value, this, static_cast<std::uint32_t>(nodes_.size() - 1)};
  }

  // Returns the number of nodes, for truncate().
  std::size_t size() const { return nodes_.size(); }

  // Removes the nodes from `size` on.
  void truncate(std::size_t size) {
    nodes_.resize(size);
    adjoints_.resize(size);
  }

  // Adds `weight` times the number to the result.
  void add(const Taped& number, double weight) {
    adjoints_.resize(nodes_.size(), 0);
    if (number.node != 0) adjoints_[number.node] += weight;
  }

  // Carries the derivatives back to the variables among the nodes, down to the node `first`. What the result does not
  // depend on may have infinite derivatives of its own.
  void carry_back(std::size_t first) {
    for (std::size_t i = adjoints_.size(); i-- > first;) {
      const double adjoint = adjoints_[i];
      if (adjoint == 0) continue;
      const Node& node = nodes_[i];
      if (node.a != 0) adjoints_[node.a] += adjoint * node.by_a;
      if (node.b != 0) adjoints_[node.b] += adjoint * node.by_b;
    }
  }

  // Returns the derivative with respect to a number; 0 for a constant.
  double derivative(const Taped& number) const { return number.node < adjoints_.size() ? adjoints_[number.node] : 0; }

 private:
  struct Node {
    double by_a = 0;
    double by_b = 0;
    std::uint32_t a = 0;
    std::uint32_t b = 0;
  };
  std::vector<Node> nodes_{1};
  std::vector<double> adjoints_{0.0};
};

// What depends on nothing is a constant.
inline Taped Taped::chain(double value, const Taped& a, double by_a, const Taped& b, double by_b) {
  const std::uint32_t on_a = by_a == 0 ? 0 : a.node;
  const std::uint32_t on_b = by_b == 0 ? 0 : b.node;
  if (on_a == 0 && on_b == 0) return Taped(value);
  return (on_a != 0 ? a.tape : b.tape)->record(value, on_a, by_a, on_b, by_b);
}

}  // namespace knead::detail

// The formulas of fields need these.
template <>
class std::numeric_limits<knead::detail::Taped> {
 public:
  static constexpr knead::detail::Taped max() { return knead::detail::Taped(numeric_limits<double>::max()); }
  static constexpr knead::detail::Taped epsilon() { return knead::detail::Taped(numeric_limits<double>::epsilon()); }
};
