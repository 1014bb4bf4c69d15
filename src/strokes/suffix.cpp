// The new part of a growing stroke, and pieces joined to one stroke.
#include "strokes/suffix.h"

#include "strokes/describe.h"

namespace knead {

namespace {

// Calls body with the row of the tool and both strokes; nothing if these are of two tools.
template <class Body>
auto of_both(const Stroke& a, const Stroke& b, const Body& body) {
  return detail::with_row(a, [&]<class S>(const detail::ToolRow<S>& row, const S& first) {
    const S* second = std::get_if<S>(&b);
    return second != nullptr ? body(row, first, *second) : decltype(body(row, first, *second)){};
  });
}

}  // namespace

std::optional<Stroke> suffix_since(const Stroke& before, const Stroke& now) {
  return of_both(before, now, [](const auto& row, const auto& a, const auto& b) -> std::optional<Stroke> {
    if (row.rest == nullptr || !row.grows(a, b)) return std::nullopt;
    return row.rest(a, b);
  });
}

std::optional<Flow> flow_suffix_since(const Stroke& before, const Stroke& now, const Mirror& mirror) {
  if (!is_flow(now)) return std::nullopt;
  if (const std::optional<Stroke> rest = suffix_since(before, now)) return flow_of(*rest, mirror);
  const bool grows = of_both(before, now, [](const auto& row, const auto& a, const auto& b) {
    return row.grows != nullptr && row.grows(a, b);
  });
  if (!grows) return std::nullopt;
  Flow flow = flow_of(now, mirror);
  const std::size_t done = flow_of(before).segments.size();
  flow.segments.erase(flow.segments.begin(), flow.segments.begin() + static_cast<std::ptrdiff_t>(done));
  return flow;
}

bool continues(const Stroke& last, const Stroke& next) {
  return of_both(last, next, [](const auto& row, const auto& a, const auto& b) {
    return row.continues != nullptr && row.continues(a, b);
  });
}

bool join(Stroke& last, const Stroke& next) {
  if (!continues(last, next)) return false;
  return detail::with_row(last, [&]<class S>(const detail::ToolRow<S>& row, S& own) {
    if (row.join == nullptr) return false;
    row.join(own, std::get<S>(next));
    return true;
  });
}

}  // namespace knead
