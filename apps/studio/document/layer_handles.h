// The handles by which the strokes of a past entry are changed in the view: points of its paths, centres of its tools.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "gestures/screen.h"
#include "knead/session.h"

namespace knead::studio {

// A path of an entry, or the place of a tool, which is a path of one point.
struct LayerPath {
  std::vector<Vec3d> points;
  std::vector<std::size_t> handles;  // which of them have a handle: at most nine, the first and the last among them
};

// Returns the paths of an entry; strokes that go on where the one before ended have one together. Strokes without a
// path or a place have none.
std::vector<LayerPath> paths_of(std::span<const SessionStroke> strokes);

// One handle of an entry.
struct LayerHandle {
  std::size_t path = 0;
  std::size_t handle = 0;  // of that path's

  friend bool operator==(const LayerHandle&, const LayerHandle&) = default;
};

// Returns the handle within a few pixels of a place; the nearest of several.
std::optional<LayerHandle> handle_at(const Screen& screen, std::span<const LayerPath> paths, double x, double y);

// Returns where a handle is.
Vec3d place_of(std::span<const LayerPath> paths, const LayerHandle& handle);

// Returns the strokes after a handle was moved. The points between it and its neighbours follow in part. Paths that
// were mirror images of this one in coordinate planes still are.
std::vector<SessionStroke> with_handle_moved(std::vector<SessionStroke> strokes, const LayerHandle& handle,
                                             const Vec3d& by);

}  // namespace knead::studio
