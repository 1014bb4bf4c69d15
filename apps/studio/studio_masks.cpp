// Masks: painted, drawn round, and changed as a whole. Each change is a stroke in the history.
#include <algorithm>

#include "gestures/gesture_kinds.h"
#include "gestures/symmetry.h"
#include "studio.h"

namespace knead::studio {

// What the document's mask was when the values were made.
void Studio::refresh_mask() {
  if (shown_.looked_at || masking_) return;
  const bool is_same = shown_.state.mask.shares(values_mask_) && shown_.state.mesh == values_mesh_;
  if (is_same) return;
  values_mask_ = shown_.state.mask;
  values_mesh_ = shown_.state.mesh;
  mask_values_ = studio::mask_values(shown_.history, shown_.state);
}

std::vector<Pixel> Studio::drawn_line() const {
  if (masking_) return masking_->line;
  const auto* const lasso = gesture_ ? std::get_if<LassoGesture>(&gesture_->kind) : nullptr;
  return lasso != nullptr ? lasso->line : std::vector<Pixel>{};
}

void Studio::begin_masking() {
  masking_ = Masking{mask_values_, pointer_.modifiers.ctrl, {{pointer_.x, pointer_.y}}, screen()};
  move_masking();
}

void Studio::move_masking() {
  std::vector<Pixel>& line = masking_->line;
  switch (settings_.mask_mode) {
    case MaskMode::paint:
      return paint_mask();
    case MaskMode::lasso:
      return extend_line(pointer_, line);
    case MaskMode::box: {
      const Pixel first = line.front();
      const Pixel here{pointer_.x, pointer_.y};
      line = {first, {here.x, first.y}, here, {first.x, here.y}};
      return;
    }
  }
}

void Studio::paint_mask() {
  const auto hit = hit_at(pointer_, surroundings());
  if (!hit) return;
  MaskBrush brush{hit->point, settings_.inner_ratio * settings_.radius, settings_.radius, masking_->erases};
  paint(brush, shown_.state.positions, mask_values_);
  for (const SymmetryImage& image : images_of(settings_)) {
    brush.center = image.motion(hit->point);
    paint(brush, shown_.state.positions, mask_values_);
  }
}

void Studio::end_masking(bool is_kept) {
  const Masking done = std::move(*masking_);
  masking_.reset();
  if (!is_kept) {
    mask_values_ = done.before;
    return;
  }
  if (settings_.mask_mode != MaskMode::paint) {
    fill(done.line, done.screen, done.erases, shown_.state.positions, mask_values_);
  }
  if (mask_values_ != done.before) apply_mask();
}

void Studio::change_mask(MaskEdit edit) {
  refresh();
  if (gesture_ || masking_ || shown_.opened == 0 || shown_.looked_at) return;
  const MaskValues before = mask_values_;
  mask_values_ = changed(std::move(mask_values_), edit, *shown_.state.mesh);
  if (mask_values_ != before) apply_mask();
}

bool Studio::perform_mask(Action action) {
  if (action < Action::mask_fill || action > Action::mask_shrink) return false;
  change_mask(static_cast<MaskEdit>(static_cast<int>(action) - static_cast<int>(Action::mask_fill)));
  return true;
}

void Studio::apply_mask() {
  apply({{mask_stroke(mask_values_, shown_.state, settings_.mask_width * settings_.radius)}});
}

// As a gesture.
void Studio::apply(std::vector<SessionStroke> strokes) {
  if (!pending_) {
    pending_ = PendingStrokes{shown_.state, {}};
    ended_strokes_.clear();
  }
  pending_->strokes = ended_strokes_;
  pending_->strokes.insert(pending_->strokes.end(), strokes.begin(), strokes.end());
  ended_strokes_ = pending_->strokes;
  ++ended_;
  post([this, strokes = std::move(strokes)](Progress& progress) {
    document_.set_live(strokes, progress);
    document_.finish(progress);
  });
}

}  // namespace knead::studio
