#include "studio_masks.h"

#include <utility>

#include "gestures/gesture_kinds.h"

namespace knead::studio {

StudioMasks::StudioMasks(StudioDocument& document, StudioTools& tools,
                         std::function<void(std::vector<SessionStroke>)> apply)
    : document_(document), tools_(tools), apply_(std::move(apply)) {}

void StudioMasks::follow() {
  const DocumentState& shown = document_.shown();
  if (shown.looked_at || drawing_) return;
  if (shown.state.mask.shares(values_mask_) && shown.state.mesh == values_mesh_) return;
  values_mask_ = shown.state.mask;
  values_mesh_ = shown.state.mesh;
  values_ = mask_values(shown.history, shown.state);
}

std::vector<Pixel> StudioMasks::line() const { return drawing_ ? drawing_->line : std::vector<Pixel>{}; }

void StudioMasks::begin(const Pointer& pointer, const GestureContext& context) {
  drawing_ = Drawing{values_, pointer.modifiers.ctrl, {{pointer.x, pointer.y}}, context.screen};
  move(pointer, context);
}

void StudioMasks::move(const Pointer& pointer, const GestureContext& context) {
  std::vector<Pixel>& line = drawing_->line;
  switch (tools_.settings().mask_mode) {
    case MaskMode::paint:
      return paint(pointer, context);
    case MaskMode::lasso:
      return extend_line(pointer, line);
    case MaskMode::box: {
      const Pixel first = line.front();
      const Pixel here{pointer.x, pointer.y};
      line = {first, {here.x, first.y}, here, {first.x, here.y}};
      return;
    }
  }
}

void StudioMasks::paint(const Pointer& pointer, const GestureContext& context) {
  const auto hit = hit_at(pointer, context);
  if (!hit) return;
  const ToolSettings& settings = tools_.settings();
  const Snapshot& positions = document_.shown().state.positions;
  MaskBrush brush{hit->point, settings.inner_ratio * settings.radius, settings.radius, drawing_->erases};
  studio::paint(brush, positions, values_);
  for (const SymmetryImage& image : images_of(settings)) {
    brush.center = image.motion(hit->point);
    studio::paint(brush, positions, values_);
  }
}

void StudioMasks::end(bool is_kept) {
  const Drawing done = std::move(*drawing_);
  drawing_.reset();
  if (!is_kept) {
    values_ = done.before;
    return;
  }
  if (tools_.settings().mask_mode != MaskMode::paint) {
    fill(done.line, done.screen, done.erases, document_.shown().state.positions, values_);
  }
  if (values_ != done.before) apply();
}

void StudioMasks::change(MaskEdit edit) {
  const DocumentState& shown = document_.shown();
  if (drawing_ || shown.opened == 0 || shown.looked_at) return;
  const MaskValues before = values_;
  values_ = changed(std::move(values_), edit, *shown.state.mesh);
  if (values_ != before) apply();
}

void StudioMasks::apply() {
  const ToolSettings& settings = tools_.settings();
  apply_({{mask_stroke(values_, document_.shown().state, settings.mask_width * settings.radius)}});
}

}  // namespace knead::studio
