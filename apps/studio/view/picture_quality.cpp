#include "view/picture_quality.h"

#include <algorithm>

namespace knead::studio {

namespace {

constexpr double kSlow = 0.1;  // seconds
constexpr double kFast = 0.06;
constexpr int kSlowPictures = 5;
constexpr int kFastPictures = 10;

}  // namespace

void PictureQuality::note(double seconds, int samples) {
  if (samples == 0) {
    note_smooth(seconds);
  } else {
    note_reduced(seconds);
  }
}

void PictureQuality::note_smooth(double seconds) {
  smooth_ = seconds;
  is_new_ = true;
  if (is_reduced_) {
    is_reduced_ = seconds > kFast;
    in_a_row_ = 0;
    return;
  }
  in_a_row_ = seconds > kSlow ? in_a_row_ + 1 : 0;
  if (in_a_row_ < kSlowPictures) return;
  is_reduced_ = true;
  in_a_row_ = 0;
}

void PictureQuality::note_reduced(double seconds) {
  if (is_new_) cost_ = std::max(1.0, smooth_ / std::max(seconds, 1e-6));
  is_new_ = false;
  in_a_row_ = cost_ * seconds < kFast ? in_a_row_ + 1 : 0;
  if (in_a_row_ < kFastPictures) return;
  is_reduced_ = false;
  in_a_row_ = 0;
}

}  // namespace knead::studio
