#include "card_shape.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "knead/math/error.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/deformed_shape.h"
#include "knead/session/workbench.h"

namespace knead::studio {

namespace {

void extend(Box& box, const Box& other) {
  if (other.empty()) return;
  box.extend(other.min);
  box.extend(other.max);
}

// Beyond which no point is moved by the field, from its centre; nothing where that is not known.
std::optional<double> reach_of(const Field& field) {
  const double outer = field.thresholds.outer;
  if (std::holds_alternative<Ball<double>>(field.region)) return outer;
  if (const auto* capsule = std::get_if<Capsule<double>>(&field.region)) return outer + norm(capsule->half_axis);
  return std::nullopt;
}

void extend(Box& box, const Vec3d& center, double radius) {
  box.extend(center - Vec3d{radius, radius, radius});
  box.extend(center + Vec3d{radius, radius, radius});
}

bool can_be_ahead(const std::vector<SessionStroke>& strokes) {
  return std::none_of(strokes.begin(), strokes.end(),
                      [](const SessionStroke& stroke) { return reads_surface(stroke.stroke); });
}

gpu::GpuOptions here(gpu::GpuOptions options) {
  options.in_current_context = true;
  return options;
}

}  // namespace

CardShape::CardShape(const gpu::GpuOptions& options) : device_(here(options)) {}

bool CardShape::follow(const ShapeState& state, const PendingStrokes* pending, double diagonal,
                       render::LiveView& view) {
  if (state.mesh == nullptr) return false;
  const bool is_ahead = pending != nullptr && can_be_ahead(pending->strokes);
  const ShapeState& base = is_ahead ? pending->start : state;
  bool has_changed = rest_at(base);
  if (!has_view_) {
    view.set_shape(base.to_mesh());
    has_view_ = true;
    has_changed = true;
  }
  if (is_ahead) {
    has_changed = go_ahead(pending->strokes, diagonal) || has_changed;
  } else {
    check_work();
    has_changed = come_back() || has_changed;
  }
  if (!has_changed) return false;
  std::vector<render::PointBuffer> buffers;
  for (const gpu::GpuBuffer& part : gpu::Gpu::buffers(*points_)) {
    const auto begin = static_cast<std::uint32_t>(part.begin);
    buffers.push_back({part.name, {begin, begin + static_cast<std::uint32_t>(part.count)}});
  }
  view.move_on_gpu(buffers, box());
  return true;
}

void CardShape::take_shape(const ShapeState& state) {
  const std::vector<Vec3d> positions = state.positions.copy();
  rest_.reset();
  points_.reset();
  rest_ = device_.upload(positions);
  points_ = device_.upload(positions);
  surface_.reset();
  forget_work();
  boxes_.assign((positions.size() + Snapshot::kChunk - 1) / Snapshot::kChunk, {});
  at_ = state;
  has_view_ = false;
}

// Whether anything has changed.
bool CardShape::rest_at(const ShapeState& state) {
  const IndexRange all{0, static_cast<std::uint32_t>(state.positions.size())};
  std::vector<IndexRange> changes{all};
  if (at_.mesh != state.mesh || at_.positions.size() != state.positions.size()) {
    take_shape(state);
  } else {
    changes = state.positions.changes_since(at_.positions);
    if (changes.empty()) return false;
    check_work();
    for (const IndexRange& range : changes) write(state.positions, range);
    device_.assign(*points_, *rest_);
    forget_work();
    at_ = state;
  }
  for (const IndexRange& range : changes) {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      Box& box = boxes_[i / Snapshot::kChunk];
      if (i % Snapshot::kChunk == 0) box = {};
      if (is_finite(state.positions[i])) box.extend(state.positions[i]);
    }
  }
  return true;
}

void CardShape::write(const Snapshot& positions, const IndexRange& range) {
  static_assert(Snapshot::kChunk % gpu::Gpu::kGroup == 0, "changes are of whole groups");
  std::vector<Vec3d> part;
  part.reserve(range.end - range.begin);
  for (std::size_t i = range.begin; i < range.end; ++i) part.push_back(positions[i]);
  device_.write(*rest_, range.begin, part);
}

bool CardShape::go_ahead(std::span<const SessionStroke> strokes, double diagonal) {
  const GestureChange change = gesture_change(done_, strokes);
  if (change.is_nothing(strokes.size())) return false;
  const AdvectOptions options = advect_options(MotionOptions(), diagonal);
  std::vector<Flow> flows;
  try {
    if (change.rest) flows.push_back(*change.rest);
    for (std::size_t i = change.first_new; i < strokes.size(); ++i) flows.push_back(flow_of(strokes[i].stroke));
  } catch (const InvalidInput&) {
    return come_back();  // the worker finds and says the same
  }
  if (change.from_start) come_back();
  for (const Flow& flow : flows) {
    reach_with(flow);
    device_.enqueue(flow, *points_, options);
  }
  done_.assign(strokes.begin(), strokes.end());
  return true;
}

bool CardShape::come_back() {
  if (done_.empty()) return false;
  device_.assign(*points_, *rest_);
  forget_work();
  return true;
}

// Throws where the driver did not go all the way, as Mesa's on the CPU may not.
void CardShape::check_work() {
  if (!done_.empty()) device_.collect(*points_);
}

void CardShape::forget_work() {
  done_.clear();
  reached_ = {};
  way_ = 0;
}

// What is moved stays in a bounded region; by others nothing goes farther than twice the tool's way and, turned, about
// the shape.
void CardShape::reach_with(const Flow& flow) {
  const Box shape = resting_box();
  for (const Segment& segment : flow.segments) {
    way_ += norm(segment.displacement) * std::abs(segment.end - segment.begin);
    for (const Field& field : segment.fields) {
      const std::optional<double> reach = reach_of(field);
      if (!reach) extend(reached_, shape.center(), shape.diagonal() + 2 * way_);
      for (const double t : {segment.begin, segment.end}) {
        if (reach) extend(reached_, field.center + segment.displacement * t, *reach);
      }
    }
  }
}

Box CardShape::resting_box() const {
  Box result;
  for (const Box& chunk : boxes_) extend(result, chunk);
  return result;
}

const gpu::GpuSurface& CardShape::surface() {
  if (!surface_) surface_.emplace(device_, triangulate(*at_.mesh));
  return *surface_;
}

std::optional<SurfaceHit> CardShape::hit(const Ray& ray) {
  if (at_.mesh == nullptr || at_.mesh->face_count() == 0) return std::nullopt;
  const std::optional<gpu::GpuHit> found = surface().first_hit(*points_, ray.origin, ray.direction);
  if (!found) return std::nullopt;
  const auto& [a, b, c] = found->corners;
  const Vec3d normal = cross(b - a, c - a);
  if (!(norm(normal) > 0)) return std::nullopt;
  SurfaceHit result;
  result.triangle = found->triangle;
  result.point = ray.origin + ray.direction * found->t;
  result.barycentric = barycentric_of(result.point, a, b, c);
  result.normal = normalized(normal);
  return result;
}

double CardShape::volume() {
  if (at_.mesh == nullptr) return 0;
  return surface().volume(*points_, resting_box().center());
}

std::vector<Vec3d> CardShape::positions() {
  std::vector<Vec3d> result(points_ ? points_->size() : 0);
  if (points_) device_.download(*points_, result);
  return result;
}

// Of what is seen, or larger.
Box CardShape::box() const {
  Box result = resting_box();
  extend(result, reached_);
  return result;
}

}  // namespace knead::studio
