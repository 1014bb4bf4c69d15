#include <algorithm>
#include <cmath>

#include "fit/fit_parts.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::session_detail {

namespace {

// Radii of the levels: of the diagonal, and of the level before.
constexpr double kFirstRadius = 1;
constexpr double kFiner = 0.7;
constexpr std::size_t kLevels = 12;
constexpr std::size_t kRounds = 8;  // strokes of a level
constexpr double kWorthwhile = 0.98;
// The finest pins: so many on the source's surface, and so many mean edges apart.
constexpr double kMaxSurfacePins = 1200;
constexpr double kEdges = 1.5;
constexpr double kSamplesOfPin = 10;
constexpr std::size_t kMinSamples = 4000;
constexpr double kSmoothness = 0.003;

}  // namespace

std::size_t most_strokes(const ShapeFitOptions& options) {
  return (options.landmarks ? 1 : 0) + (options.surface ? kLevels * kRounds : 0);
}

ShapeFitter::ShapeFitter(const Mesh& source, const Mesh& target, const ShapeFitOptions& options)
    : options_(options),
      source_(borrow(source)),
      shape_(source_, MotionOptions{.threads = options.threads}),
      target_triangles_(triangulate(target)),
      target_mesh_(target) {
  if (options.landmarks) landmarks_ = {options.landmarks->points, options.landmarks->to};
  if (options.surface && (target_triangles_.empty() || shape_.triangles().empty())) {
    throw InvalidInput("a shape without faces has no surface to fit; fit landmarks alone");
  }
}

double ShapeFitter::landmark_distance() const {
  double greatest = 0;
  for (std::size_t i = 0; i < landmarks_.at.size(); ++i) {
    greatest = std::max(greatest, norm(landmarks_.at[i] - landmarks_.to[i]));
  }
  return greatest;
}

std::size_t ShapeFitter::count_crossings() const {
  const SelfIntersectionOptions crossing{.threads = options_.threads, .progress = options_.progress};
  return self_intersections(shape_.triangles(), shape_.positions(), crossing).count;
}

void ShapeFitter::run() {
  crossings_before_ = crossings_ = count_crossings();
  if (options_.landmarks) apply(*options_.landmarks);
  if (options_.surface) fit_surface();
  if (options_.progress != nullptr) options_.progress->done = fit_work(*source_, options_);
}

void ShapeFitter::go_back(const Moment& moment) {
  shape_.restore(moment.shape);
  landmarks_.at = moment.landmarks;
  crossings_ = moment.crossings;
}

void ShapeFitter::apply(SessionStroke stroke) {
  AdvectOptions options = advect_options(shape_.motion(), shape_.reference_length());
  options.progress = options_.progress;
  AdvectStatus status = advect(flow_of(stroke), landmarks_.at, options).status;
  if (status == AdvectStatus::done) status = shape_.apply(stroke, {}, options_.progress).status;
  if (status == AdvectStatus::cancelled) throw Cancelled();
  if (status == AdvectStatus::step_limit) throw InvalidInput(kStepLimitAdvice);
  crossings_ = count_crossings();
  strokes_.push_back(std::move(stroke));
}

// With a remesh where triangles cross else.
void ShapeFitter::apply(const PinsStroke& pins) {
  const Moment before = moment();
  apply(SessionStroke{pins});
  if (!options_.surface || crossings_ <= crossings_before_) return;
  strokes_.pop_back();
  go_back(before);
  SessionStroke remeshed{pins};
  remeshed.remesh = RemeshSettings{};
  apply(std::move(remeshed));
}

void ShapeFitter::look() {
  const std::span<const Triangle> triangles = shape_.triangles();
  const FitSurface surface({triangles.begin(), triangles.end()}, shape_.positions());
  samples_ = surface.samples(sample_count_);
  matches_ = match(surface, samples_, *target_, target_samples_, options_.threads, options_.progress);
}

// Strokes of one radius, until the mean distance no longer falls.
void ShapeFitter::fit_level(double radius, std::size_t last_stroke) {
  while (strokes_.size() < last_stroke) {
    const Moment before = moment();
    const double distance = matches_.mean_distance;
    if (distance <= kDefaultRelativeTolerance * shape_.reference_length()) return;
    const PinsStroke pins = fit_pins(matches_.all, samples_, landmarks_, {radius, kSmoothness, options_.progress});
    if (pins.points.size() == landmarks_.at.size()) return;  // which leave no room for others
    apply(pins);
    look();
    if (matches_.mean_distance > kWorthwhile * distance || crossings_ > crossings_before_) {
      if (matches_.mean_distance < distance && crossings_ <= crossings_before_) return;
      strokes_.pop_back();
      go_back(before);
      look();
      return;
    }
  }
}

void ShapeFitter::fit_surface() {
  const std::span<const Triangle> triangles = shape_.triangles();
  const FitSurface source({triangles.begin(), triangles.end()}, shape_.positions());
  target_ = std::make_unique<FitSurface>(target_triangles_, target_mesh_.positions);
  const double unit = shape_.reference_length();
  const double spacing =
      std::max(std::sqrt(source.area() / kMaxSurfacePins), kEdges * std::max(source.mean_edge(), target_->mean_edge()));
  double radius = kFirstRadius * unit;
  for (std::size_t level = 0; level < kLevels && radius * kPinSpacing >= spacing; ++level, radius *= kFiner) {
    const double pins = source.area() / (kPinSpacing * kPinSpacing * radius * radius);
    sample_count_ = std::max(kMinSamples, static_cast<std::size_t>(kSamplesOfPin * pins));
    target_samples_ = target_->samples(sample_count_);
    look();
    fit_level(radius, strokes_.size() + kRounds);
    if (options_.progress != nullptr) {
      options_.progress->done = source_->vertex_count() * ((options_.landmarks ? 1 : 0) + (level + 1) * kRounds);
    }
  }
}

}  // namespace knead::session_detail
