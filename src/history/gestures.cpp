// Which strokes form a gesture, its strength, the change between two lists of its strokes, and joined strokes.
#include <algorithm>
#include <iterator>
#include <utility>

#include "history/history.h"
#include "knead/editor/workbench.h"
#include "strokes/describe.h"
#include "strokes/suffix.h"

namespace knead {

namespace {

// Beyond strength 1, an extension extends the path of several strokes: a stroke of its own, made for kMaxStrength.
constexpr double kMaxExtension = kMaxStrength - 1;
constexpr std::size_t kMaxImages = 8;  // of one gesture, mirrored in three planes

// The path along which the tool of a stroke goes; null for other strokes.
template <class AnyStroke>
auto path_of(AnyStroke& stroke) {
  return detail::with_row(stroke,
                          [](const auto& row, auto& own) { return row.path != nullptr ? &(own.*row.path) : nullptr; });
}

Stroke with_path(Stroke stroke, std::vector<Vec3d> path) {
  *path_of(stroke) = std::move(path);
  return stroke;
}

// Returns the number of pieces of a path that have a length; each is a segment.
double segments_along(const Stroke& stroke) {
  const std::vector<Vec3d>& path = *path_of(stroke);
  double pieces = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) pieces += path[i] == path[i + 1] ? 0 : 1;
  return pieces;
}

// Strokes each of which continues the one before it; or a single stroke.
struct Chain {
  std::vector<std::size_t> strokes;
  std::optional<std::size_t> extension;  // the stroke that extends it beyond strength 1
};

using Strokes = std::span<const SessionStroke>;

// Returns the stroke that extends a chain; nothing if its path has no length. It begins with a piece without length,
// which distinguishes it from strokes that a person drew.
std::optional<Stroke> extension_of(Strokes strokes, const std::vector<std::size_t>& chain) {
  std::vector<Vec3d> whole;
  for (const std::size_t i : chain) {
    const std::vector<Vec3d>& path = *path_of(strokes[i].stroke);
    whole.insert(whole.end(), path.begin(), path.end());
  }
  const std::size_t count = whole.size();
  const Stroke& last = strokes[chain.back()].stroke;
  const Stroke longer = prolonged(with_path(last, whole), kMaxStrength);
  const std::vector<Vec3d>& path = *path_of(longer);
  if (path.size() == count) return std::nullopt;
  return with_path(last, {path[count - 1], path[count - 1], path[count]});
}

// Returns true if the stroke is the extension of the chain.
bool is_extension(Strokes strokes, const Chain& chain, const SessionStroke& stroke) {
  const std::vector<Vec3d>& path = *path_of(stroke.stroke);
  if (chain.strokes.size() < 2 || path.size() != 3 || path[0] != path[1]) return false;
  return extension_of(strokes, chain.strokes) == stroke.stroke;
}

std::vector<Chain> chains_of(Strokes strokes) {
  std::vector<Chain> chains;
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    const auto goes_on = [&](const Chain& chain) {
      const Stroke& last = strokes[chain.strokes.back()].stroke;
      return !chain.extension && path_of(last) != nullptr && continues(last, strokes[i].stroke);
    };
    const auto found = std::find_if(chains.rbegin(), chains.rend(), goes_on);
    if (found != chains.rend() && is_extension(strokes, *found, strokes[i])) {
      found->extension = i;
      continue;
    }
    Chain& chain = found == chains.rend() ? chains.emplace_back() : *found;
    chain.strokes.push_back(i);
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

// Returns true for strokes that are never mirror images of each other.
bool stands_alone(const Stroke& stroke) {
  if (std::holds_alternative<MaskStroke>(stroke) || std::holds_alternative<PoseStroke>(stroke)) return true;
  const auto* handles = std::get_if<HandlesStroke>(&stroke);
  return handles != nullptr && !(handles->full_vertices.empty() && handles->zero_vertices.empty());
}

// Returns the stroke with only the first point of its path, since further pieces of one side may have been joined.
Stroke beginning(const Stroke& stroke) {
  Stroke result = stroke;
  detail::with_row(result, [](const auto& row, auto& own) {
    if (row.path != nullptr && row.join != nullptr) (own.*row.path).resize(1);
  });
  return result;
}

bool are_images(const Stroke& first, const Stroke& second) {
  if (first.index() != second.index() || stands_alone(first)) return false;
  const Stroke a = beginning(first);
  const Stroke b = beginning(second);
  for (int planes = 1; planes < 8; ++planes) {
    Stroke image = a;
    for (int axis = 0; axis < 3; ++axis) {
      if ((planes >> axis & 1) != 0) image = mirrored(image, axis);
    }
    Stroke other = b;
    if (auto* file = find_value<std::string>(image, "mesh")) *file = *find_value<std::string>(other, "mesh");
    if (image == b && image != a) return true;
  }
  return false;
}

bool belongs_to(const std::vector<SessionStroke>& group, const SessionStroke& stroke) {
  if (stroke.new_entry) return !*stroke.new_entry;
  if (!stroke.name.empty() || !group.back().name.empty()) return stroke.name == group.back().name;
  if (stroke.off != group.back().off) return false;
  const std::size_t first = group.size() > kMaxImages ? group.size() - kMaxImages : 0;
  return std::any_of(group.begin() + static_cast<std::ptrdiff_t>(first), group.end(), [&](const SessionStroke& member) {
    if (member.remesh != stroke.remesh || member.mirror != stroke.mirror) return false;
    return continues(member.stroke, stroke.stroke) || are_images(member.stroke, stroke.stroke);
  });
}

}  // namespace

double strength_of(std::span<const SessionStroke> gesture) {
  if (gesture.empty()) return 1;
  const Chain chain = chains_of(gesture).front();
  if (chain.strokes.size() == 1) return gesture[chain.strokes.front()].strength;
  if (chain.extension) return 1 + kMaxExtension * gesture[*chain.extension].strength;
  double done = 0;
  for (const std::size_t i : chain.strokes) done += gesture[i].strength * segments_along(gesture[i].stroke);
  const double pieces = segments_along(gesture, chain);
  return pieces > 0 ? done / pieces : 1;
}

void set_strength(std::vector<SessionStroke>& gesture, double strength) {
  std::vector<SessionStroke> added;
  std::vector<std::size_t> dropped;
  for (const Chain& chain : chains_of(gesture)) {
    if (chain.extension) dropped.push_back(*chain.extension);
    if (chain.strokes.size() == 1) {
      gesture[chain.strokes.front()].strength = strength;
      continue;
    }
    cut(gesture, chain, std::min(strength, 1.0));
    if (strength <= 1) continue;
    std::optional<Stroke> stroke = extension_of(gesture, chain.strokes);
    if (!stroke) continue;
    added.push_back(gesture[chain.strokes.back()]);
    added.back().stroke = std::move(*stroke);
    added.back().strength = (strength - 1) / kMaxExtension;
  }
  std::sort(dropped.rbegin(), dropped.rend());
  for (const std::size_t i : dropped) gesture.erase(gesture.begin() + static_cast<std::ptrdiff_t>(i));
  gesture.insert(gesture.end(), added.begin(), added.end());
}

StrokeDelta stroke_delta(std::span<const SessionStroke> before, std::span<const SessionStroke> now) {
  const auto same = [](const SessionStroke& a, const SessionStroke& b) {
    return a.stroke == b.stroke && a.name == b.name && a.off == b.off && a.strength == b.strength &&
           a.duration == b.duration && a.mirror == b.mirror;
  };
  const auto [a, b] = std::mismatch(before.begin(), before.end(), now.begin(), now.end(), same);
  StrokeDelta result;
  result.first_new = static_cast<std::size_t>(a - before.begin());
  if (a == before.end()) return result;
  const auto has_rest = [](SessionStroke stroke) {
    stroke.mirror.clear();
    return is_plain(stroke) && (!reads_surface(stroke.stroke) || !is_flow(stroke.stroke));
  };
  if (std::next(a) == before.end() && b != now.end() && a->mirror == b->mirror && has_rest(*a) && has_rest(*b)) {
    result.rest = flow_suffix_since(a->stroke, b->stroke, b->mirror);
    if (std::optional<Stroke> rest = suffix_since(a->stroke, b->stroke)) {
      result.rest_as_line = SessionStroke{std::move(*rest)};
      result.rest_as_line->mirror = b->mirror;
    }
    ++result.first_new;
  }
  if (result.rest || result.rest_as_line) return result;
  return {true, 0, std::nullopt, std::nullopt};
}

std::vector<std::vector<SessionStroke>> strokes_of_gestures(const std::vector<SessionStroke>& strokes) {
  std::vector<std::vector<SessionStroke>> groups;
  for (const SessionStroke& stroke : strokes) {
    if (groups.empty() || !belongs_to(groups.back(), stroke)) groups.emplace_back();
    groups.back().push_back(stroke);
    groups.back().back().new_entry.reset();
  }
  return groups;
}

std::vector<SessionStroke> strokes_of_entry(const std::vector<SessionStroke>& before,
                                            std::vector<SessionStroke> strokes) {
  std::vector<SessionStroke> group = before;
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    strokes[i].new_entry.reset();
    const bool begins = i == 0;
    const bool seems_to_begin = group.empty() || !belongs_to(group, strokes[i]);
    if (begins) group.clear();
    group.push_back(strokes[i]);
    if (begins != seems_to_begin) strokes[i].new_entry = begins;
  }
  return strokes;
}

std::vector<SessionStroke> joined_strokes(std::vector<SessionStroke> strokes) {
  return detail::joined_where(std::move(strokes), [](const SessionStroke& before, const SessionStroke& stroke) {
    const auto may_join = [](SessionStroke each) {
      each.mirror.clear();
      return is_plain(each) && !each.remesh;
    };
    return may_join(before) && may_join(stroke);
  });
}

std::vector<SessionStroke> detail::joined_where(std::vector<SessionStroke> strokes, MayJoin may_join) {
  std::vector<SessionStroke> result;
  for (SessionStroke& stroke : strokes) {
    const bool is_joined = !result.empty() && result.back().mirror == stroke.mirror &&
                           may_join(result.back(), stroke) && join(result.back().stroke, stroke.stroke);
    if (!is_joined) result.push_back(std::move(stroke));
  }
  return result;
}

}  // namespace knead
