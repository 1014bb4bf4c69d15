// For tests of the journal: a random sequence of what Studio does to it, and the strokes in effect after each of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "knead/editor/workbench.h"
#include "knead/mesh.h"
#include "knead/session.h"
#include "support/scratch.h"

namespace knead::test {

inline ShapeFile sphere() {
  ShapeFile shape;
  shape.mesh = make_shape(ShapeKind::sphere, 162);
  shape.format = "ply";
  return shape;
}

inline SessionStroke short_stroke(double x, std::optional<RemeshSettings> remesh = {}) {
  ImplicitStroke stroke;
  stroke.path = {{x, 0.1, 0.2}, {x + 0.013, 0.11, 0.2}};
  stroke.inner = 0.125;
  stroke.outer = 0.5;
  return {stroke, 0, remesh};
}

inline RemeshSettings edges_below(double max_edge) {
  RemeshSettings settings;
  settings.max_edge = max_edge;
  return settings;
}

// Strokes without the lines they were read from.
inline std::vector<SessionStroke> without_lines(std::vector<SessionStroke> strokes) {
  for (SessionStroke& stroke : strokes) stroke.line = 0;
  return strokes;
}

// The same seed does the same.
class RandomWork {
 public:
  explicit RandomWork(std::uint32_t seed) : random_(seed) {}

  // Takes back some strokes, appends some, or both; in the journal too if there is one.
  void step(Journal* journal) {
    const std::size_t back = below(3) == 0 ? below(std::min<std::size_t>(strokes_.size(), 4) + 1) : 0;
    std::vector<SessionStroke> added;
    for (std::size_t n = back == 0 ? 1 + below(3) : below(4); n > 0; --n) added.push_back(next());
    if (back == 0 && added.size() == 1 && below(4) == 0) added.push_back(next());
    strokes_.resize(strokes_.size() - back);
    strokes_.insert(strokes_.end(), added.begin(), added.end());
    if (journal == nullptr) return;
    if (back == 0) {
      journal->append(added);
    } else if (added.empty()) {
      journal->undo(back);
    } else {
      journal->replace(back, added);
    }
  }

  const std::vector<SessionStroke>& strokes() const { return strokes_; }

 private:
  std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }

  SessionStroke next() {
    const double x = std::normal_distribution<double>()(random_);
    if (below(3) == 0) remesh_ = below(2) == 0 ? std::nullopt : std::optional(edges_below(0.25 * x * x + 0.01));
    return short_stroke(x, remesh_);
  }

  std::mt19937 random_;
  std::optional<RemeshSettings> remesh_;
  std::vector<SessionStroke> strokes_;
};

}  // namespace knead::test
