// Numbers of a gesture: typed, snapped, or set with the pointer.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "studio.h"

namespace knead::studio {

namespace {

constexpr double kSnapParts = 100;  // of the diagonal
constexpr double kRatioPerPixel = 0.003;
constexpr double kSnapRatio = 0.05;
constexpr double kMinRatio = 0.01;
constexpr double kMaxRatio = 0.95;
constexpr double kMinRadius = 1e-4;  // of the diagonal
constexpr std::size_t kMaxTyped = 16;

// The character that a key writes into a number, or 0. A comma is a decimal point.
char written_by(std::string_view key) {
  if (key.starts_with("Numpad ")) key.remove_prefix(7);
  if (key == ",") return '.';
  const bool writes = key.size() == 1 && ((key[0] >= '0' && key[0] <= '9') || key[0] == '.' || key[0] == '-');
  return writes ? key[0] : '\0';
}

std::optional<double> number_in(const std::string& text) {
  const bool has_digit = std::any_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  return has_digit ? std::optional(std::strtod(text.c_str(), nullptr)) : std::nullopt;
}

// A minus changes the sign, wherever it is typed.
void write(std::string& text, char c) {
  if (c == '-') {
    text.starts_with('-') ? text.erase(0, 1) : text.insert(0, 1, '-');
  } else if (text.size() < kMaxTyped && (c != '.' || text.find('.') == std::string::npos)) {
    text += c;
  }
}

}  // namespace

double snap_length(double diagonal) {
  const double step = diagonal / kSnapParts;
  const double power = std::pow(10, std::floor(std::log10(step)));
  double best = power;
  for (const double factor : {2.0, 5.0, 10.0}) {
    if (std::abs(std::log(factor * power / step)) < std::abs(std::log(best / step))) best = factor * power;
  }
  return best;
}

std::optional<Amount> Studio::amount() const {
  if (gesture_) return amount_of(*gesture_, settings_);
  if (!adjusting_) return std::nullopt;
  if (adjusting_->what == Action::radius) return Amount{AmountKind::length, settings_.radius};
  return Amount{AmountKind::percent, 100 * settings_.inner_ratio};
}

void Studio::clear_typed() {
  typed_.clear();
  pointer_.typed.reset();
}

// Digits, ".", "," and "-" write the number of the gesture; Backspace takes the last one away.
bool Studio::type(const KeyChanged& key) {
  if (!(key.modifiers == Modifiers{}) || !amount()) return false;
  const char c = written_by(key.key);
  if (c != '\0') {
    write(typed_, c);
  } else if (key.key == "Backspace" && !typed_.empty()) {
    typed_.pop_back();
  } else {
    return false;
  }
  follow_typed();
  return true;
}

void Studio::follow_typed() {
  pointer_.typed = number_in(typed_);
  if (adjusting_) adjust();
  if (!gesture_) return;
  move_gesture(pointer_, surroundings(), placed_, *gesture_);
  send_live();
}

void Studio::begin_adjusting(Action what) {
  if (gesture_) return;
  clear_typed();
  const bool was_auto = settings_.auto_radius;
  if (what == Action::radius) fix_radius();
  const double value = what == Action::radius ? settings_.radius : settings_.inner_ratio;
  adjusting_ = Adjusting{what, pointer_.x, value, was_auto};
}

void Studio::adjust() {
  const double pixels = pointer_.x - adjusting_->start_x;
  if (adjusting_->what == Action::radius) {
    const double per_pixel = pixel_size(screen(), navigation_.view.target);
    const double pointed =
        snapped(adjusting_->start_value + pixels * per_pixel, snap_length(shown_.diagonal), pointer_);
    settings_.radius = std::max(pointer_.typed.value_or(pointed), kMinRadius * shown_.diagonal);
  } else {
    const double pointed = snapped(adjusting_->start_value + pixels * kRatioPerPixel, kSnapRatio, pointer_);
    const double ratio = pointer_.typed ? *pointer_.typed / 100 : pointed;
    settings_.inner_ratio = std::clamp(ratio, kMinRatio, kMaxRatio);
  }
}

void Studio::stop_adjusting(bool is_kept) {
  if (!is_kept) {
    (adjusting_->what == Action::radius ? settings_.radius : settings_.inner_ratio) = adjusting_->start_value;
    settings_.auto_radius = adjusting_->was_auto;
  }
  adjusting_.reset();
  clear_typed();
}

}  // namespace knead::studio
