// The shape on the GPU, and the flow of the current gesture there.
#include "view/shown_shape.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "knead/editor/shape_state.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::studio {

namespace {

void extend(Box& box, const Box& other) {
  if (other.empty()) return;
  box.extend(other.min);
  box.extend(other.max);
}

// Returns the distance from the centre of the field beyond which it moves no point; nothing if that is not known.
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

// The equations of more pins take longer to solve than a picture may.
constexpr std::size_t kMaxPins = 100;

// The GPU evaluates no mask, no curve, and no images that act at the same time.
bool can_preview(const PendingStrokes& pending) {
  return pending.start.mask.is_empty() &&
         std::none_of(pending.strokes.begin(), pending.strokes.end(), [](const SessionStroke& stroke) {
           const auto* const pins = std::get_if<PinsStroke>(&stroke.stroke);
           return (pins == nullptr && !stroke.mirror.empty()) || reads_surface(stroke.stroke) ||
                  tool_of(stroke.stroke).is_event || std::holds_alternative<CurveStroke>(stroke.stroke) ||
                  (pins != nullptr && pins->points.size() > kMaxPins);
         });
}

gpu::GpuOptions here(gpu::GpuOptions options) {
  options.in_current_context = true;
  return options;
}

}  // namespace

GpuPreview::GpuPreview(const gpu::GpuOptions& options) : gpu_(here(options)) {}

bool GpuPreview::follow(const ShapeState& state, const PendingStrokes* pending, double diagonal,
                        render::LiveView& view) {
  if (state.mesh == nullptr) return false;
  const bool previews = pending != nullptr && can_preview(*pending);
  const ShapeState& base = previews ? pending->start : state;
  bool has_changed = take_state(base);
  if (!has_view_) {
    view.set_shape(visible_mesh(objects_, base));
    has_view_ = true;
    has_changed = true;
  }
  if (previews) {
    has_changed = apply(pending->strokes, diagonal) || has_changed;
  } else {
    check_strokes();
    has_changed = take_back() || has_changed;
  }
  if (!has_changed) return false;
  std::vector<render::PointBuffer> buffers;
  for (const gpu::GpuBuffer& part : gpu::Gpu::buffers(*points_)) {
    const auto begin = static_cast<std::uint32_t>(part.begin);
    buffers.push_back({part.name, {begin, begin + static_cast<std::uint32_t>(part.count)}});
  }
  Box box = state_box();  // of the picture, or larger
  extend(box, reach_);
  view.move_on_gpu(buffers, box);
  return true;
}

void GpuPreview::upload(const ShapeState& state) {
  const std::vector<Vec3d> positions = state.positions.copy();
  start_.reset();
  points_.reset();
  start_ = gpu_.upload(positions);
  points_ = gpu_.upload(positions);
  surface_.reset();
  forget_strokes();
  boxes_.assign((positions.size() + Snapshot::kChunk - 1) / Snapshot::kChunk, {});
  state_ = state;
  has_view_ = false;
}

// Returns whether anything has changed.
bool GpuPreview::take_state(const ShapeState& state) {
  const IndexRange all{0, static_cast<std::uint32_t>(state.positions.size())};
  std::vector<IndexRange> changes{all};
  if (state_.mesh != state.mesh || state_.positions.size() != state.positions.size()) {
    upload(state);
  } else {
    changes = state.positions.changes_since(state_.positions);
    if (changes.empty()) return false;
    check_strokes();
    for (const IndexRange& range : changes) write(state.positions, range);
    gpu_.assign(*points_, *start_);
    forget_strokes();
    state_ = state;
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

void GpuPreview::write(const Snapshot& positions, const IndexRange& range) {
  static_assert(Snapshot::kChunk % gpu::Gpu::kGroup == 0, "changes are of whole groups");
  std::vector<Vec3d> part;
  part.reserve(range.end - range.begin);
  for (std::size_t i = range.begin; i < range.end; ++i) part.push_back(positions[i]);
  gpu_.write(*start_, range.begin, part);
}

bool GpuPreview::apply(std::span<const SessionStroke> strokes, double diagonal) {
  const StrokeDelta change = stroke_delta(strokes_, strokes);
  if (change.is_nothing(strokes.size())) return false;
  const AdvectOptions options = advect_options(MotionOptions(), diagonal);
  try {
    std::vector<Flow> flows;
    if (change.rest) flows.push_back(*change.rest);
    for (std::size_t i = change.first_new; i < strokes.size(); ++i)
      flows.push_back(flow_of(strokes[i].stroke, strokes[i].mirror));
    if (change.from_start) take_back();
    strokes_.assign(strokes.begin(), strokes.end());
    for (const Flow& flow : flows) {
      extend_reach(flow);
      gpu_.enqueue(flow, *points_, options);
    }
  } catch (const InvalidInput&) {
    return take_back();  // the worker reports the same
  }
  return true;
}

bool GpuPreview::take_back() {
  if (strokes_.empty()) return false;
  gpu_.assign(*points_, *start_);
  forget_strokes();
  return true;
}

// Throws if the driver did not complete the work, as Mesa on the CPU may not.
void GpuPreview::check_strokes() {
  if (!strokes_.empty()) gpu_.collect(*points_);
}

void GpuPreview::forget_strokes() {
  strokes_.clear();
  reach_ = {};
  distance_ = 0;
}

// Balls, capsules and grids move points in a bounded region only. Other regions move no point farther than twice the
// path of the tool, and turn points about the shape.
void GpuPreview::extend_reach(const Flow& flow) {
  const Box shape = state_box();
  for (const Segment& segment : flow.segments) {
    const PotentialGrid& grid = segment.grid;
    if (!grid.is_empty()) {
      const Vec3d margin = Vec3d{2, 2, 2} * grid.spacing;
      const Vec3d nodes{grid.counts[0] - 1.0, grid.counts[1] - 1.0, grid.counts[2] - 1.0};
      extend(reach_, Box{grid.origin - margin, grid.origin + nodes * grid.spacing + margin});
    }
    distance_ += norm(segment.displacement) * std::abs(segment.end - segment.begin);
    for (const Field& field : segment.fields) {
      const std::optional<double> reach = reach_of(field);
      if (!reach) extend(reach_, shape.center(), shape.diagonal() + 2 * distance_);
      for (const double t : {segment.begin, segment.end}) {
        if (reach) extend(reach_, field.center + displacement_of(segment, field) * t, *reach);
      }
    }
  }
}

Box GpuPreview::state_box() const {
  Box result;
  for (const Box& chunk : boxes_) extend(result, chunk);
  return result;
}

const gpu::GpuSurface& GpuPreview::surface() {
  if (!surface_) surface_.emplace(gpu_, triangulate(*state_.mesh));
  return *surface_;
}

std::optional<SurfaceHit> GpuPreview::hit(const Ray& ray) {
  if (state_.mesh == nullptr || state_.mesh->face_count() == 0) return std::nullopt;
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

double GpuPreview::volume() {
  if (state_.mesh == nullptr) return 0;
  return surface().volume(*points_, state_box().center());
}

std::vector<Vec3d> GpuPreview::positions() {
  std::vector<Vec3d> result(points_ ? points_->size() : 0);
  if (points_) gpu_.download(*points_, result);
  return result;
}

bool ShownShape::follow(const ShapeState& state, const PendingStrokes* pending, double diagonal,
                        render::LiveView& view) {
  const bool has_moved = gpu_ ? gpu_->follow(state, pending, diagonal, view) : send(state, view);
  return view.set_splats(state.splats) || has_moved;
}

void ShownShape::use_cpu() {
  gpu_.reset();
  state_ = {};
}

void GpuPreview::show(const DocumentObjects& objects) {
  objects_ = objects;
  has_view_ = false;
}

void ShownShape::show(const DocumentObjects& objects) {
  if (objects.is_seen_as(objects_)) return;
  objects_ = objects;
  state_ = {};
  if (gpu_) gpu_->show(objects_);
}

bool ShownShape::send(const ShapeState& state, render::LiveView& view) {
  if (state.mesh == nullptr) return false;
  if (state.mesh != state_.mesh || state.positions.size() != positions_.size()) {
    const Mesh mesh = visible_mesh(objects_, state);
    view.set_shape(mesh);
    positions_ = mesh.positions;
    state_ = state;
    touched_ = positions_.size();
    return true;
  }
  const std::vector<IndexRange> changes = state.positions.changes_since(state_.positions);
  if (changes.empty()) return false;
  std::vector<render::VertexRange> ranges;
  touched_ = 0;
  for (const IndexRange& range : changes) {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      if (!(positions_[i] == state.positions[i])) ++touched_;
      positions_[i] = state.positions[i];
    }
    ranges.push_back({range.begin, range.end});
  }
  view.move(positions_, ranges);
  state_ = state;
  return true;
}

namespace {

constexpr double kSlow = 0.04;  // seconds
constexpr double kFast = 0.02;
constexpr double kPatience = 0.2;  // seconds of slow pictures
constexpr int kSlowPictures = 2;   // one alone may have other reasons
constexpr int kSoon = 300;         // pictures
constexpr int kMaxNeeded = 2000;

Fineness next(Fineness fineness, int step) { return static_cast<Fineness>(static_cast<int>(fineness) + step); }

}  // namespace

void set_fineness(render::LiveScene& scene, Fineness fineness) {
  scene.samples = fineness == Fineness::smooth ? 0 : 1;
  scene.coarseness = fineness == Fineness::coarse ? 2 : 1;
}

void PictureQuality::note(double seconds, Fineness fineness) {
  if (fineness != moving_) return;
  ++pictures_;
  const bool is_slow = seconds > kSlow;
  slow_ = is_slow ? slow_ + 1 : 0;
  slow_seconds_ = is_slow ? slow_seconds_ + seconds : 0;
  fast_ = seconds < kFast ? fast_ + 1 : 0;
  if (slow_ >= kSlowPictures && slow_seconds_ > kPatience && moving_ != Fineness::coarse) {
    if (pictures_ < kSoon) needed_ = std::min(2 * needed_, kMaxNeeded);
    become(next(moving_, 1));
  } else if (fast_ >= needed_ && moving_ != Fineness::smooth) {
    become(next(moving_, -1));
  }
}

void PictureQuality::become(Fineness fineness) {
  moving_ = fineness;
  pictures_ = 0;
  slow_ = 0;
  slow_seconds_ = 0;
  fast_ = 0;
}

}  // namespace knead::studio
