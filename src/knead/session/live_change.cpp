#include "knead/session/live_change.h"

#include <algorithm>
#include <iterator>

#include "knead/tool/continued.h"

namespace knead {

LiveChange live_change(std::span<const SessionStroke> before, std::span<const SessionStroke> now) {
  const auto same = [](const SessionStroke& a, const SessionStroke& b) { return a.stroke == b.stroke; };
  const auto [a, b] = std::mismatch(before.begin(), before.end(), now.begin(), now.end(), same);
  LiveChange result;
  result.first_new = static_cast<std::size_t>(a - before.begin());
  if (a == before.end()) return result;
  if (std::next(a) == before.end() && b != now.end() && !reads_surface(a->stroke) && !reads_surface(b->stroke)) {
    result.rest = rest_of_flow(a->stroke, b->stroke);
    result.rest_as_line = rest_of(a->stroke, b->stroke);
    ++result.first_new;
  }
  if (result.rest) return result;
  return {true, 0, std::nullopt, std::nullopt};
}

}  // namespace knead
