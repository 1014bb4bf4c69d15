#include <algorithm>
#include <iterator>

#include "knead/session/workbench.h"
#include "knead/tool/continued.h"

namespace knead {

namespace {

constexpr std::size_t kMostImages = 8;  // of one gesture, mirrored in three planes

// Of which two are never mirror images of each other.
bool stands_alone(const Stroke& stroke) {
  if (std::holds_alternative<MaskStroke>(stroke) || std::holds_alternative<PoseStroke>(stroke)) return true;
  const auto* handles = std::get_if<HandlesStroke>(&stroke);
  return handles != nullptr && !(handles->full_vertices.empty() && handles->zero_vertices.empty());
}

// Pieces of a side may have been joined: of a path only the beginning is looked at.
Stroke beginning(const Stroke& stroke) {
  Stroke result = stroke;
  if (auto* implicit = std::get_if<ImplicitStroke>(&result)) implicit->path.resize(1);
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
    if (auto* stamp = std::get_if<StampStroke>(&image)) stamp->mesh = std::get<StampStroke>(b).mesh;
    if (image == b && image != a) return true;
  }
  return false;
}

bool belongs_to(const std::vector<SessionStroke>& group, const SessionStroke& stroke) {
  if (stroke.new_entry) return !*stroke.new_entry;
  if (!stroke.name.empty() || !group.back().name.empty()) return stroke.name == group.back().name;
  if (stroke.off != group.back().off) return false;
  const std::size_t first = group.size() > kMostImages ? group.size() - kMostImages : 0;
  return std::any_of(group.begin() + static_cast<std::ptrdiff_t>(first), group.end(), [&](const SessionStroke& member) {
    if (member.remesh != stroke.remesh || member.mirror != stroke.mirror) return false;
    return continues(member.stroke, stroke.stroke) || are_images(member.stroke, stroke.stroke);
  });
}

}  // namespace

GestureChange gesture_change(std::span<const SessionStroke> before, std::span<const SessionStroke> now) {
  const auto same = [](const SessionStroke& a, const SessionStroke& b) {
    return a.stroke == b.stroke && a.name == b.name && a.off == b.off && a.strength == b.strength &&
           a.duration == b.duration && a.mirror == b.mirror;
  };
  const auto [a, b] = std::mismatch(before.begin(), before.end(), now.begin(), now.end(), same);
  GestureChange result;
  result.first_new = static_cast<std::size_t>(a - before.begin());
  if (a == before.end()) return result;
  const auto has_rest = [](SessionStroke stroke) {
    stroke.mirror.clear();
    return is_plain(stroke) && (!reads_surface(stroke.stroke) || !is_flow(stroke.stroke));
  };
  if (std::next(a) == before.end() && b != now.end() && a->mirror == b->mirror && has_rest(*a) && has_rest(*b)) {
    result.rest = rest_of_flow(a->stroke, b->stroke, b->mirror);
    if (std::optional<Stroke> rest = rest_of(a->stroke, b->stroke)) {
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
  std::vector<SessionStroke> result;
  for (SessionStroke& stroke : strokes) {
    std::optional<Stroke> both;
    const auto may_join = [](SessionStroke each) {
      each.mirror.clear();
      return is_plain(each) && !each.remesh;
    };
    const bool same_mirror = !result.empty() && result.back().mirror == stroke.mirror;
    if (same_mirror && may_join(result.back()) && may_join(stroke)) {
      both = joined(result.back().stroke, stroke.stroke);
    }
    if (both) {
      result.back().stroke = std::move(*both);
    } else {
      result.push_back(std::move(stroke));
    }
  }
  return result;
}

}  // namespace knead
