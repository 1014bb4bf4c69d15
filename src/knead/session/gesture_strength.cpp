// The strength of a gesture of several strokes.
#include <algorithm>
#include <cmath>
#include <utility>

#include "knead/session/workbench.h"
#include "knead/tool/continued.h"

namespace knead {

namespace {

// Beyond strength 1, the path of several strokes goes on by a stroke of its own: as long as it can become.
constexpr double kMostBeyond = kMostStrength - 1;

const std::vector<Vec3d>* path_of(const Stroke& stroke) {
  if (const auto* implicit = std::get_if<ImplicitStroke>(&stroke)) return &implicit->path;
  if (const auto* stamp = std::get_if<StampStroke>(&stroke)) return &stamp->path;
  return nullptr;
}

Stroke with_path(Stroke stroke, std::vector<Vec3d> path) {
  auto* const implicit = std::get_if<ImplicitStroke>(&stroke);
  auto* const stamp = std::get_if<StampStroke>(&stroke);
  if (implicit != nullptr) {
    implicit->path = std::move(path);
  } else if (stamp != nullptr) {
    stamp->path = std::move(path);
  }
  return stroke;
}

// The pieces of a path that have a length, which are its segments.
double segments_along(const Stroke& stroke) {
  const std::vector<Vec3d>& path = *path_of(stroke);
  double pieces = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) pieces += path[i] == path[i + 1] ? 0 : 1;
  return pieces;
}

double length_of(const std::vector<Vec3d>& path) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) length += norm(path[i + 1] - path[i]);
  return length;
}

// Strokes each of which goes on where the one before ended; another one alone.
struct Chain {
  std::vector<std::size_t> strokes;
  double length = 0;                  // of their path
  std::optional<std::size_t> beyond;  // the stroke by which it goes on
};

using Strokes = std::span<const SessionStroke>;

bool is_path(const Stroke& stroke) { return path_of(stroke) != nullptr; }

// The stroke by which a chain goes on; nothing where its path has no length.
std::optional<Stroke> beyond(Strokes strokes, const std::vector<std::size_t>& chain) {
  std::vector<Vec3d> whole;
  for (const std::size_t i : chain) {
    const std::vector<Vec3d>& path = *path_of(strokes[i].stroke);
    whole.insert(whole.end(), path.begin(), path.end());
  }
  const std::size_t count = whole.size();
  const Stroke& last = strokes[chain.back()].stroke;
  const Stroke longer = prolonged(with_path(last, whole), kMostStrength);
  const std::vector<Vec3d>& path = *path_of(longer);
  if (path.size() == count) return std::nullopt;
  return with_path(last, {path[count - 1], path[count]});
}

// Whether the stroke is that by which the chain goes on. Few are about as long.
bool is_beyond(Strokes strokes, const Chain& chain, const SessionStroke& stroke) {
  constexpr double kAbout = 1e-6;
  if (chain.strokes.size() < 2) return false;
  const double length = length_of(*path_of(stroke.stroke));
  if (std::abs(length - kMostBeyond * chain.length) > kAbout * chain.length) return false;
  return beyond(strokes, chain.strokes) == stroke.stroke;
}

std::vector<Chain> chains_of(Strokes strokes) {
  std::vector<Chain> chains;
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    const auto goes_on = [&](const Chain& chain) {
      const Stroke& last = strokes[chain.strokes.back()].stroke;
      return !chain.beyond && is_path(last) && continues(last, strokes[i].stroke);
    };
    const auto found = std::find_if(chains.rbegin(), chains.rend(), goes_on);
    if (found != chains.rend() && is_beyond(strokes, *found, strokes[i])) {
      found->beyond = i;
      continue;
    }
    Chain& chain = found == chains.rend() ? chains.emplace_back() : *found;
    chain.strokes.push_back(i);
    if (is_path(strokes[i].stroke)) chain.length += length_of(*path_of(strokes[i].stroke));
  }
  return chains;
}

double segments_along(Strokes strokes, const Chain& chain) {
  double pieces = 0;
  for (const std::size_t i : chain.strokes) pieces += segments_along(strokes[i].stroke);
  return pieces;
}

// Cuts a chain of several strokes as one path.
void cut(std::span<SessionStroke> strokes, const Chain& chain, double strength) {
  double left = strength * segments_along(strokes, chain);
  for (const std::size_t i : chain.strokes) {
    const double own = segments_along(strokes[i].stroke);
    strokes[i].strength = own == 0 ? 1 : std::clamp(left / own, 0.0, 1.0);
    left -= own;
  }
}

}  // namespace

double strength_of(std::span<const SessionStroke> gesture) {
  if (gesture.empty()) return 1;
  const Chain chain = chains_of(gesture).front();
  if (chain.strokes.size() == 1) return gesture[chain.strokes.front()].strength;
  if (chain.beyond) return 1 + kMostBeyond * gesture[*chain.beyond].strength;
  double done = 0;
  for (const std::size_t i : chain.strokes) done += gesture[i].strength * segments_along(gesture[i].stroke);
  const double pieces = segments_along(gesture, chain);
  return pieces > 0 ? done / pieces : 1;
}

void set_strength(std::vector<SessionStroke>& gesture, double strength) {
  std::vector<SessionStroke> added;
  std::vector<std::size_t> dropped;
  for (const Chain& chain : chains_of(gesture)) {
    if (chain.beyond) dropped.push_back(*chain.beyond);
    if (chain.strokes.size() == 1) {
      gesture[chain.strokes.front()].strength = strength;
      continue;
    }
    cut(gesture, chain, std::min(strength, 1.0));
    if (strength <= 1) continue;
    std::optional<Stroke> stroke = beyond(gesture, chain.strokes);
    if (!stroke) continue;
    added.push_back(gesture[chain.strokes.back()]);
    added.back().stroke = std::move(*stroke);
    added.back().strength = (strength - 1) / kMostBeyond;
  }
  std::sort(dropped.rbegin(), dropped.rend());
  for (const std::size_t i : dropped) gesture.erase(gesture.begin() + static_cast<std::ptrdiff_t>(i));
  gesture.insert(gesture.end(), added.begin(), added.end());
}

}  // namespace knead
