#include "knead/tool/continued.h"

#include <algorithm>

namespace knead {

namespace {

template <class T>
bool begins_with(const std::vector<T>& whole, const std::vector<T>& beginning) {
  return whole.size() > beginning.size() && std::equal(beginning.begin(), beginning.end(), whole.begin());
}

// The stroke without what grows while it is made.
template <class S, class List>
S without(S stroke, List S::*list) {
  (stroke.*list).clear();
  return stroke;
}

template <class S, class List>
bool has_grown(const S& before, const S& now, List S::*list) {
  return begins_with(now.*list, before.*list) && without(before, list) == without(now, list);
}

template <class S, class List>
bool goes_on(const S& last, const S& next, List S::*list) {
  const bool touches = !(last.*list).empty() && !(next.*list).empty() && (last.*list).back() == (next.*list).front();
  return touches && without(last, list) == without(next, list);
}

// Of the list, what comes from an index on.
template <class S, class List>
S from(S stroke, List S::*list, std::size_t first) {
  (stroke.*list).erase((stroke.*list).begin(), (stroke.*list).begin() + static_cast<std::ptrdiff_t>(first));
  return stroke;
}

template <class S, class List>
S with(S stroke, List S::*list, const List& more, std::size_t skipped) {
  (stroke.*list).insert((stroke.*list).end(), more.begin() + static_cast<std::ptrdiff_t>(skipped), more.end());
  return stroke;
}

// Returns true if a relaxed path goes on near one of its last points; with mirror images these are several.
bool goes_on_near(const RelaxStroke& last, const RelaxStroke& next) {
  constexpr std::size_t kMostImages = 256;
  if (next.points.empty() || without(last, &RelaxStroke::points) != without(next, &RelaxStroke::points)) return false;
  const std::size_t first = last.points.size() - std::min(last.points.size(), kMostImages);
  return std::any_of(last.points.begin() + static_cast<std::ptrdiff_t>(first), last.points.end(),
                     [&](const Vec3d& p) { return norm(p - next.points.front()) <= last.radius; });
}

// Calls body with both as strokes of that tool; nothing where one is of another.
template <class S, class Body>
auto of_both(const Stroke& a, const Stroke& b, const Body& body) {
  const auto* first = std::get_if<S>(&a);
  const auto* second = std::get_if<S>(&b);
  return first != nullptr && second != nullptr ? body(*first, *second) : decltype(body(*first, *second)){};
}

}  // namespace

std::optional<Stroke> rest_of(const Stroke& before, const Stroke& now) {
  using Rest = std::optional<Stroke>;
  Rest path = of_both<ImplicitStroke>(before, now, [](const auto& a, const auto& b) -> Rest {
    if (a.path.empty() || !has_grown(a, b, &ImplicitStroke::path)) return std::nullopt;
    return from(b, &ImplicitStroke::path, a.path.size() - 1);
  });
  if (path) return path;
  Rest dabs = of_both<RelaxStroke>(before, now, [](const auto& a, const auto& b) -> Rest {
    if (a.points.empty() || !has_grown(a, b, &RelaxStroke::points)) return std::nullopt;
    return from(b, &RelaxStroke::points, a.points.size());
  });
  if (dabs) return dabs;
  return of_both<PaintStroke>(before, now, [](const auto& a, const auto& b) -> Rest {
    if (a.samples.empty() || !has_grown(a, b, &PaintStroke::samples)) return std::nullopt;
    return from(b, &PaintStroke::samples, a.samples.size());
  });
}

std::optional<Flow> rest_of_flow(const Stroke& before, const Stroke& now, const Mirror& mirror) {
  if (!is_flow(now)) return std::nullopt;
  if (const std::optional<Stroke> rest = rest_of(before, now)) return flow_of(*rest, mirror);
  return of_both<PointsStroke>(before, now, [&](const auto& a, const auto& b) -> std::optional<Flow> {
    if (!has_grown(a, b, &PointsStroke::displacements)) return std::nullopt;
    Flow flow = flow_of(b, mirror);
    const std::size_t done = flow_of(a).segments.size();
    flow.segments.erase(flow.segments.begin(), flow.segments.begin() + static_cast<std::ptrdiff_t>(done));
    return flow;
  });
}

bool continues(const Stroke& last, const Stroke& next) {
  const auto goes_on_along_path = [](const auto& a, const auto& b) {
    using S = std::decay_t<decltype(a)>;
    return goes_on(a, b, &S::path);
  };
  if (of_both<ImplicitStroke>(last, next, goes_on_along_path)) return true;
  if (of_both<StampStroke>(last, next, goes_on_along_path)) return true;
  if (of_both<RelaxStroke>(last, next, goes_on_near)) return true;
  return of_both<PaintStroke>(last, next, [](const auto& a, const auto& b) {
    return a.path.empty() && b.path.empty() && a.outer == b.outer && a.depth == b.depth && a.falloff == b.falloff;
  });
}

std::optional<Stroke> joined(const Stroke& last, const Stroke& next) {
  using Joined = std::optional<Stroke>;
  if (!continues(last, next)) return std::nullopt;
  Joined path = of_both<ImplicitStroke>(
      last, next, [](const auto& a, const auto& b) -> Joined { return with(a, &ImplicitStroke::path, b.path, 1); });
  if (path) return path;
  Joined dabs = of_both<RelaxStroke>(
      last, next, [](const auto& a, const auto& b) -> Joined { return with(a, &RelaxStroke::points, b.points, 0); });
  if (dabs) return dabs;
  return of_both<PaintStroke>(
      last, next, [](const auto& a, const auto& b) -> Joined { return with(a, &PaintStroke::samples, b.samples, 0); });
}

}  // namespace knead
