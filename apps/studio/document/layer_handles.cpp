#include "document/layer_handles.h"

#include <algorithm>
#include <cmath>

#include "knead/tools.h"
#include "knead/workbench.h"

namespace knead::studio {

namespace {

constexpr std::size_t kMaxHandles = 9;  // of one path
constexpr double kReach = 10;           // pixels

// A path with the numbers of strokes that it is made of.
struct OwnedPath {
  std::vector<Vec3d> points;
  std::vector<std::vector<Vec3d*>> owners;  // of each point: where two strokes meet, of both
  std::size_t tool = 0;                     // of its strokes
  bool is_whole = false;                    // all owners move alike: a set of points
};

// What a stroke's key holds if it is a path or a place.
struct Places {
  std::vector<Vec3d>* path = nullptr;
  Vec3d* center = nullptr;
};

Places places_of(Stroke& stroke) {
  Places places;
  if (auto* handles = std::get_if<HandlesStroke>(&stroke)) {
    if (auto* turn = std::get_if<HandlesRotation>(&handles->motion)) places.center = &turn->center;
    return places;
  }
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    if (key.quantity != Quantity::finite) continue;
    auto* const* list = std::get_if<std::vector<Vec3d>*>(&key.value);
    auto* const* place = std::get_if<Vec3d*>(&key.value);
    if (list != nullptr && *list != nullptr && key.name == "path") places.path = *list;
    if (place != nullptr && *place != nullptr) places.center = *place;
  }
  return places;
}

void add_path(std::size_t tool, std::vector<Vec3d>& path, std::vector<OwnedPath>& paths) {
  if (path.empty()) return;
  const auto found = std::find_if(paths.rbegin(), paths.rend(), [&](const OwnedPath& before) {
    return before.tool == tool && before.points.size() > 1 && before.points.back() == path.front();
  });
  OwnedPath& whole = found == paths.rend() ? paths.emplace_back() : *found;
  whole.tool = tool;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i == 0 && !whole.points.empty()) {
      whole.owners.back().push_back(path.data());
    } else {
      whole.points.push_back(path[i]);
      whole.owners.push_back({&path[i]});
    }
  }
}

// A set of points moves as a whole, by its middle.
void add_set(std::size_t tool, PointsStroke& stroke, std::vector<OwnedPath>& paths) {
  OwnedPath whole{{}, {{}}, tool, true};
  const auto add = [&](std::vector<Vec3d>& points) {
    for (Vec3d& p : points) whole.owners.front().push_back(&p);
  };
  add(stroke.points);
  for (std::vector<Vec3d>& curve : stroke.curves) add(curve);
  Vec3d sum{0, 0, 0};
  for (const Vec3d* p : whole.owners.front()) sum += *p;
  whole.points.push_back(sum / static_cast<double>(whole.owners.front().size()));
  paths.push_back(std::move(whole));
}

// The displacement of each pin that moves.
void add_pins(std::size_t tool, PinsStroke& stroke, std::vector<OwnedPath>& paths) {
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    Vec3d& from = stroke.points[i];
    Vec3d& to = stroke.to[i];
    if (!(from == to)) paths.push_back({{from, to}, {{&from}, {&to}}, tool});
  }
}

// What goes on beyond the paths of an entry follows from them, so it has no handles. Returns the strength.
double without_beyond(std::vector<SessionStroke>& strokes) {
  const double strength = strength_of(strokes);
  if (strength > 1) set_strength(strokes, 1);
  return strength;
}

std::vector<OwnedPath> owned_paths(std::vector<SessionStroke>& strokes) {
  std::vector<OwnedPath> paths;
  for (SessionStroke& each : strokes) {
    const std::size_t tool = each.stroke.index();
    if (auto* points = std::get_if<PointsStroke>(&each.stroke)) {
      add_set(tool, *points, paths);
      continue;
    }
    if (auto* pins = std::get_if<PinsStroke>(&each.stroke)) {
      add_pins(tool, *pins, paths);
      continue;
    }
    const Places places = places_of(each.stroke);
    if (places.path != nullptr) add_path(tool, *places.path, paths);
    if (places.path == nullptr && places.center != nullptr)
      paths.push_back({{*places.center}, {{places.center}}, tool});
  }
  return paths;
}

std::vector<std::size_t> handles_of(std::size_t points) {
  const std::size_t count = std::min(points, kMaxHandles);
  std::vector<std::size_t> handles;
  for (std::size_t k = 0; k < count; ++k) handles.push_back(count == 1 ? 0 : k * (points - 1) / (count - 1));
  return handles;
}

// How much of a handle's motion each point of its path makes: all at the handle, none at its neighbours.
std::vector<double> weights_of(const LayerPath& path, std::size_t handle) {
  const std::size_t at = path.handles[handle];
  const std::size_t first = handle == 0 ? at : path.handles[handle - 1];
  const std::size_t last = handle + 1 == path.handles.size() ? at : path.handles[handle + 1];
  std::vector<double> weights(path.points.size(), 0.0);
  for (std::size_t i = first; i < at; ++i) {
    weights[i] = static_cast<double>(i - first) / static_cast<double>(at - first);
  }
  for (std::size_t i = at; i < last; ++i) {
    weights[i] = static_cast<double>(last - i) / static_cast<double>(last - at);
  }
  weights[at] = 1;
  return weights;
}

Vec3d mirrored_in(const Vec3d& p, unsigned planes) {
  return {(planes & 1U) != 0 ? -p.x : p.x, (planes & 2U) != 0 ? -p.y : p.y, (planes & 4U) != 0 ? -p.z : p.z};
}

// The planes in which one path is the image of another; nothing if it is not.
std::optional<unsigned> planes_between(const OwnedPath& path, const OwnedPath& image) {
  if (path.tool != image.tool || path.points.size() != image.points.size()) return std::nullopt;
  for (unsigned planes = 1; planes < 8; ++planes) {
    const auto is_image = [&](const Vec3d& p, const Vec3d& q) { return mirrored_in(p, planes) == q; };
    if (std::equal(path.points.begin(), path.points.end(), image.points.begin(), is_image)) return planes;
  }
  return std::nullopt;
}

void move(const OwnedPath& path, const std::vector<double>& weights, const Vec3d& by) {
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (weights[i] == 0) continue;
    for (Vec3d* owner : path.owners[i]) *owner = path.is_whole ? *owner + by : path.points[i] + by * weights[i];
  }
}

}  // namespace

std::vector<LayerPath> paths_of(std::span<const SessionStroke> strokes) {
  std::vector<SessionStroke> own(strokes.begin(), strokes.end());
  without_beyond(own);
  std::vector<LayerPath> paths;
  for (OwnedPath& path : owned_paths(own)) {
    std::vector<std::size_t> handles = handles_of(path.points.size());
    paths.push_back({std::move(path.points), std::move(handles)});
  }
  return paths;
}

std::optional<LayerHandle> handle_at(const Screen& screen, std::span<const LayerPath> paths, double x, double y) {
  std::optional<LayerHandle> nearest;
  double least = kReach;
  for (std::size_t path = 0; path < paths.size(); ++path) {
    for (std::size_t handle = 0; handle < paths[path].handles.size(); ++handle) {
      const auto pixel = pixel_of(screen, place_of(paths, {path, handle}));
      const double distance = pixel ? std::hypot(pixel->x - x, pixel->y - y) : least;
      if (distance >= least) continue;
      least = distance;
      nearest = LayerHandle{path, handle};
    }
  }
  return nearest;
}

Vec3d place_of(std::span<const LayerPath> paths, const LayerHandle& handle) {
  const LayerPath& path = paths[handle.path];
  return path.points[path.handles[handle.handle]];
}

std::vector<SessionStroke> with_handle_moved(std::vector<SessionStroke> strokes, const LayerHandle& handle,
                                             const Vec3d& by) {
  const double strength = without_beyond(strokes);
  const std::vector<OwnedPath> paths = owned_paths(strokes);
  if (handle.path >= paths.size()) return strokes;
  const OwnedPath& path = paths[handle.path];
  const LayerPath shown{path.points, handles_of(path.points.size())};
  if (handle.handle >= shown.handles.size()) return strokes;
  const std::vector<double> weights = weights_of(shown, handle.handle);
  move(path, weights, by);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const auto planes = i == handle.path ? std::nullopt : planes_between(path, paths[i]);
    if (planes) move(paths[i], weights, mirrored_in(by, *planes));
  }
  if (strength > 1) set_strength(strokes, strength);
  return strokes;
}

}  // namespace knead::studio
