// Strokes that continue others: the new part of a growing stroke, and the pieces of one stroke joined.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/stroke.h"

namespace knead {

// Returns the part of `now` that `before` lacks, if `now` extends `before`: the rest of an implicit stroke's path,
// the new samples of a painted stroke, or the new points of a relax stroke. `before` followed by this part gives the
// same segments as `now`, bit for bit. Returns nothing if the strokes are equal, or `now` does not extend `before`.
std::optional<Stroke> suffix_since(const Stroke& before, const Stroke& now);

// Returns the flow of suffix_since(), also for point sets with more displacements; both strokes are mirrored. Returns
// nothing for relax strokes, which are no flow. The strokes must be valid.
std::optional<Flow> flow_suffix_since(const Stroke& before, const Stroke& now, const Mirror& mirror = {});

// Returns whether `next` begins where `last` ended, with the same tool and the same numbers: an implicit stroke or a
// stamp whose path continues, a painted stroke of the same brush, or a relax stroke that begins near the last points.
// Painted strokes do not show whether the pointer was released between them.
bool continues(const Stroke& last, const Stroke& next);

// Appends `next` to a stroke that it continues: `last` then gives the result of both, one after the other, bit for bit.
// Returns false if no stroke can, as for stamps, whose contacts are chosen for a whole stroke.
bool join(Stroke& last, const Stroke& next);

}  // namespace knead

namespace knead::detail {

// The functions of a row (strokes/describe.h) for a stroke whose list grows. Two strokes that continue each other share
// `kShared` items: 1 for a path, 0 for separate places.
template <class S, auto kList, std::size_t kShared = 0>
struct Growing {
  static auto at(const S& stroke, std::size_t item) {
    return (stroke.*kList).begin() + static_cast<std::ptrdiff_t>(item);
  }
  static S without(S stroke) {
    (stroke.*kList).clear();
    return stroke;
  }
  static bool is_alike(const S& a, const S& b) { return without(a) == without(b); }

  static std::size_t segments(const S& stroke, const Mesh* /*mesh*/) { return (stroke.*kList).size(); }

  static bool grows(const S& before, const S& now) {
    const auto& first = before.*kList;
    return !first.empty() && (now.*kList).size() > first.size() &&
           std::equal(first.begin(), first.end(), (now.*kList).begin()) && is_alike(before, now);
  }
  static S rest(const S& before, const S& now) {
    S rest = without(now);
    (rest.*kList).assign(at(now, (before.*kList).size() - kShared), (now.*kList).end());
    return rest;
  }
  static bool continues(const S& last, const S& next) {
    const auto& a = last.*kList;
    const auto& b = next.*kList;
    return !a.empty() && !b.empty() && a.back() == b.front() && is_alike(last, next);
  }
  static void join(S& last, const S& next) {
    (last.*kList).insert((last.*kList).end(), at(next, kShared), (next.*kList).end());
  }
  static std::vector<Stroke> pieces(const S& stroke) {
    std::vector<Stroke> pieces;
    S piece = without(stroke);
    for (std::size_t i = kShared; i < (stroke.*kList).size(); ++i) {
      (piece.*kList).assign(at(stroke, i - kShared), at(stroke, i + 1));
      pieces.emplace_back(piece);
    }
    return pieces;
  }
  // Each item has its images after it, so that all sides grow together. Nothing without items.
  static std::optional<Stroke> interleaved(const S& stroke, std::span<const SymmetryImage> images) {
    if ((stroke.*kList).empty()) return std::nullopt;
    S result = without(stroke);
    S one = result;
    for (const auto& item : stroke.*kList) {
      (one.*kList).assign(1, item);
      (result.*kList).push_back(item);
      for (const SymmetryImage& image : images) {
        (result.*kList).push_back((std::get<S>(image_of(one, image, {})).*kList).front());
      }
    }
    return result;
  }
};

}  // namespace knead::detail
