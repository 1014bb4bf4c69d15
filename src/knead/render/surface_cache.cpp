#include "knead/render/surface_cache.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

namespace knead::render {
namespace {

constexpr std::size_t kMostEntries = 32;  // two levels, both ends of the way, and mirror images of these

const Vec3d* first_point(const PointSet<double>& set) {
  if (!set.points.empty()) return &set.points.front();
  for (const auto& curve : set.curves) {
    if (!curve.empty()) return &curve.front();
  }
  return nullptr;
}

bool is_shifted(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to, const Vec3d& shift, double tolerance) {
  return std::equal(from.begin(), from.end(), to.begin(), to.end(),
                    [&](const Vec3d& a, const Vec3d& b) { return norm(b - a - shift) <= tolerance; });
}

// What takes the first set to the second, if a shift does.
std::optional<Vec3d> shift_between(const PointSet<double>& from, const PointSet<double>& to, double tolerance) {
  const Vec3d* const a = first_point(from);
  const Vec3d* const b = first_point(to);
  if (a == nullptr || b == nullptr || from.exponent != to.exponent) return std::nullopt;
  const Vec3d shift = *b - *a;
  const auto shifted = [&](const auto& x, const auto& y) { return is_shifted(x, y, shift, tolerance); };
  if (!shifted(from.points, to.points)) return std::nullopt;
  if (!std::equal(from.curves.begin(), from.curves.end(), to.curves.begin(), to.curves.end(), shifted)) {
    return std::nullopt;
  }
  return shift;
}

}  // namespace

Mesh SurfaceCache::surface(const Field& field, double level, const SurfaceDetail& detail) {
  const auto& set = std::get<PointSet<double>>(field.region);
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->level != level || entry->detail != detail) continue;
    const std::optional<Vec3d> shift = shift_between(entry->set, set, 1e-6 * level);
    if (!shift) continue;
    std::rotate(entry, entry + 1, entries_.end());
    Mesh mesh = entries_.back().mesh;
    const Vec3d way = *shift + (field.center - entries_.back().center);
    for (Vec3d& p : mesh.positions) p += way;
    return mesh;
  }
  ++made_;
  if (entries_.size() == kMostEntries) entries_.erase(entries_.begin());
  entries_.push_back({set, field.center, level, detail, region_surface(field, field.center, level, {}, {}, detail)});
  return entries_.back().mesh;
}

}  // namespace knead::render
