// Pixels and rays, and where a ray meets the shape.
#include "gestures/picker.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "knead/vec.h"

namespace knead::studio {

namespace {

constexpr double kParallel = 1e-6;
constexpr double kMaxPointDistance = 0.02;  // of the diagonal of a point cloud

double target_distance(const Screen& screen) { return norm(screen.camera.target - screen.camera.eye); }

bool is_perspective(const Screen& screen) { return screen.camera.projection == render::Projection::perspective; }

// Scene units a pixel covers in the plane through the target.
double target_pixel(const Screen& screen) { return screen.camera.height / screen.height; }

// Where the target is seen.
Pixel target_of(const Screen& screen) {
  return {0.5 * screen.width * (1 + screen.camera.shift_x), 0.5 * screen.height * (1 - screen.camera.shift_y)};
}

}  // namespace

Ray ray_through(const Screen& screen, double x, double y) {
  const render::CameraFrame frame = render::camera_frame(screen.camera);
  const Pixel middle = target_of(screen);
  const Vec3d aside = (frame.right * (x - middle.x) - frame.up * (y - middle.y)) * target_pixel(screen);
  if (!is_perspective(screen)) return {screen.camera.eye + aside, frame.forward};
  return {screen.camera.eye, normalized(screen.camera.target + aside - screen.camera.eye)};
}

std::optional<Pixel> pixel_of(const Screen& screen, const Vec3d& p) {
  const render::CameraFrame frame = render::camera_frame(screen.camera);
  const Vec3d from_eye = p - screen.camera.eye;
  const double depth = dot(from_eye, frame.forward);
  if (is_perspective(screen) && !(depth > 0)) return std::nullopt;
  const double scale = (is_perspective(screen) ? target_distance(screen) / depth : 1) / target_pixel(screen);
  const Pixel middle = target_of(screen);
  return Pixel{middle.x + dot(from_eye, frame.right) * scale, middle.y - dot(from_eye, frame.up) * scale};
}

double pixel_size(const Screen& screen, const Vec3d& p) {
  if (!is_perspective(screen)) return target_pixel(screen);
  const double depth = dot(p - screen.camera.eye, render::camera_frame(screen.camera).forward);
  return target_pixel(screen) * std::max(depth / target_distance(screen), 1e-6);
}

double point_size(const Screen& screen, const Vec3d& p) { return screen.unit * pixel_size(screen, p); }

// By the number of edges that a ray to the right crosses.
bool is_within(std::span<const Pixel> line, const Pixel& p) {
  bool is_inside = false;
  for (std::size_t i = 0, before = line.size() - 1; i < line.size(); before = i++) {
    const Pixel& a = line[i];
    const Pixel& b = line[before];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if (p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) is_inside = !is_inside;
  }
  return is_inside;
}

std::optional<Vec3d> on_plane(const Ray& ray, const Vec3d& point, const Vec3d& normal) {
  const double slope = dot(ray.direction, normal);
  if (std::abs(slope) < kParallel * norm(normal)) return std::nullopt;
  const double t = dot(point - ray.origin, normal) / slope;
  if (!(t > 0)) return std::nullopt;
  return ray.origin + ray.direction * t;
}

std::optional<Vec3d> on_line(const Ray& ray, const Vec3d& point, const Vec3d& direction) {
  const Vec3d u = normalized(direction);
  const double across = dot(u, ray.direction);
  const double sine2 = 1 - across * across;
  if (sine2 < kParallel) return std::nullopt;
  const Vec3d gap = ray.origin - point;
  return point + u * ((dot(gap, u) - across * dot(gap, ray.direction)) / sine2);
}

std::array<double, 3> barycentric_of(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d normal = cross(b - a, c - a);
  const double area = norm2(normal);
  if (!(area > 0)) return {1, 0, 0};
  const double v = dot(cross(c - p, a - p), normal) / area;
  const double w = dot(cross(a - p, b - p), normal) / area;
  return {1 - v - w, v, w};
}

Picker::Picker(const ShapeState& state, const std::vector<bool>& faces)
    : mesh_(state.mesh),
      links_(links_of(state, faces)),
      followed_(state.positions),
      positions_(followed_.copy()),
      tree_(links_.triangles, positions_) {
  if (!links_.triangles.empty() || positions_.empty()) return;
  // About the distance of neighbours on a surface.
  const double apart = 1 / std::sqrt(static_cast<double>(positions_.size()));
  point_distance_ = std::min(kMaxPointDistance, apart) * bounding_box(positions_).diagonal();
}

Picker::Links Picker::links_of(const ShapeState& state, const std::vector<bool>& faces) {
  Links links;
  links.triangles = triangulate(*state.mesh);
  if (!faces.empty()) {
    const std::vector<std::uint32_t> sources = triangle_faces(*state.mesh);
    std::size_t kept = 0;
    for (std::size_t t = 0; t < sources.size(); ++t) {
      if (faces[sources[t]]) links.triangles[kept++] = links.triangles[t];
    }
    links.triangles.resize(kept);
  }
  links.first.assign(state.positions.size() + 1, 0);
  for (const Triangle& t : links.triangles) {
    for (const std::uint32_t v : t) ++links.first[v + 1];
  }
  std::partial_sum(links.first.begin(), links.first.end(), links.first.begin());
  links.around.resize(links.first.back());
  std::vector<std::uint32_t> next(links.first.begin(), links.first.end() - 1);
  for (std::uint32_t t = 0; t < links.triangles.size(); ++t) {
    for (const std::uint32_t v : links.triangles[t]) links.around[next[v]++] = t;
  }
  return links;
}

void Picker::follow(const ShapeState& state) {
  Box moved;
  for (const IndexRange& range : state.positions.changes_since(followed_)) {
    for (std::uint32_t v = range.begin; v < range.end; ++v) {
      if (positions_[v] == state.positions[v]) continue;
      moved.extend(positions_[v]);
      positions_[v] = state.positions[v];
    }
  }
  followed_ = state.positions;
  tree_.refit(positions_, moved);
}

Vec3d Picker::vertex_normal(std::uint32_t vertex, const Snapshot& positions) const {
  Vec3d sum{};
  for (std::uint32_t i = links_.first[vertex]; i < links_.first[vertex + 1]; ++i) {
    const Triangle& t = links_.triangles[links_.around[i]];
    sum += cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
  }
  return sum;
}

std::optional<SurfaceHit> Picker::pick(const Ray& ray, const ShapeState& now) const {
  const std::optional<RayHit> hit = tree_.first_hit(ray.origin, ray.direction);
  if (!hit) return std::nullopt;
  const Triangle& t = links_.triangles[hit->triangle];
  SurfaceHit result;
  result.triangle = hit->triangle;
  result.barycentric =
      barycentric_of(ray.origin + ray.direction * hit->t, positions_[t[0]], positions_[t[1]], positions_[t[2]]);
  Vec3d normal{};
  for (std::size_t k = 0; k < 3; ++k) {
    result.point += now.positions[t[k]] * result.barycentric[k];
    const Vec3d at_corner = vertex_normal(t[k], now.positions);
    const double length = norm(at_corner);
    if (length > 0) normal += at_corner * (result.barycentric[k] / length);
  }
  if (!(norm(normal) > 0)) return std::nullopt;
  result.normal = normalized(normal);
  return result;
}

std::optional<SurfaceHit> Picker::pick_point(const Ray& ray, const ShapeState& now) const {
  std::optional<std::uint32_t> first;
  double least = kInfinity;
  for (std::uint32_t v = 0; v < positions_.size(); ++v) {
    const Vec3d d = positions_[v] - ray.origin;
    const double depth = dot(d, ray.direction);
    if (!(depth > 0 && depth < least) || norm2(d) - depth * depth > point_distance_ * point_distance_) continue;
    least = depth;
    first = v;
  }
  if (!first) return std::nullopt;
  SurfaceHit hit;
  hit.triangle = *first;
  hit.point = ray.origin + ray.direction * least + (now.positions[*first] - positions_[*first]);
  hit.normal = -ray.direction;
  return hit;
}

std::uint32_t Picker::vertex_of(const SurfaceHit& hit, const ShapeState& now) const {
  if (links_.triangles.empty()) return hit.triangle;
  const Triangle& corners = links_.triangles[hit.triangle];
  const auto distance = [&](std::uint32_t v) { return norm2(now.positions[v] - hit.point); };
  return *std::min_element(corners.begin(), corners.end(),
                           [&](std::uint32_t a, std::uint32_t b) { return distance(a) < distance(b); });
}

std::optional<Vec3d> Picker::middle(const Ray& ray, const ShapeState& now) const {
  const std::optional<SurfaceHit> front = pick(ray, now);
  if (!front) return std::nullopt;
  for (const RayHit& hit : tree_.hits(ray.origin, ray.direction)) {
    if (hit.leaves) return (front->point + ray.origin + ray.direction * hit.t) * 0.5;
  }
  return front->point;
}

// The hit as it lies in the shape that is searched.
Vec3d Picker::searched(const SurfaceHit& hit) const {
  Vec3d place{};
  const Triangle& t = links_.triangles[hit.triangle];
  for (std::size_t k = 0; k < 3; ++k) place += positions_[t[k]] * hit.barycentric[k];
  return place;
}

std::optional<double> Picker::thickness(const SurfaceHit& hit, const ShapeState& now) const {
  if (links_.triangles.empty()) return std::nullopt;
  for (const RayHit& found : tree_.hits(searched(hit), -hit.normal)) {
    if (!found.leaves || found.triangle == hit.triangle) continue;
    const Triangle& t = links_.triangles[found.triangle];
    const Vec3d place = searched(hit) - hit.normal * found.t;
    const auto weights = barycentric_of(place, positions_[t[0]], positions_[t[1]], positions_[t[2]]);
    Vec3d back{};
    for (std::size_t k = 0; k < 3; ++k) back += now.positions[t[k]] * weights[k];
    return norm(back - hit.point);
  }
  return std::nullopt;
}

std::shared_ptr<const Picker> PickerPool::make(const ShapeState& state, const std::vector<bool>& faces) {
  std::unique_ptr<Picker> picker;
  {
    const std::lock_guard lock(shelf_->mutex);
    picker = std::move(shelf_->picker);
  }
  if (picker && picker->fits(state)) {
    picker->follow(state);
  } else {
    picker = std::make_unique<Picker>(state, faces);
  }
  Picker* const own = picker.release();
  return {own, [shelf = shelf_, own](const Picker* /*picker*/) {
            std::unique_ptr<Picker> back(own);
            const std::lock_guard lock(shelf->mutex);
            shelf->picker = std::move(back);
          }};
}

}  // namespace knead::studio
