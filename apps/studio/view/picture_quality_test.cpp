#include "view/picture_quality.h"

#include <gtest/gtest.h>

namespace knead::studio {
namespace {

// A scene whose pictures take this long with one sample, and four times as long when smooth.
void show(PictureQuality& quality, double seconds, int pictures, bool is_still = false) {
  for (int i = 0; i < pictures; ++i) {
    const int samples = quality.samples(is_still);
    quality.note(samples == 0 ? 4 * seconds : seconds, samples);
  }
}

TEST(PictureQuality, FastPicturesStaySmooth) {
  PictureQuality quality;
  show(quality, 0.02, 100);
  EXPECT_EQ(quality.samples(false), 0);
}

TEST(PictureQuality, SlowOnesLoseSmoothnessWhileTheyMoveOnly) {
  PictureQuality quality;
  show(quality, 0.05, 4);
  EXPECT_EQ(quality.samples(false), 0);  // a few slow ones are no reason
  show(quality, 0.05, 1);
  EXPECT_EQ(quality.samples(false), 1);
  EXPECT_EQ(quality.samples(true), 0);
  show(quality, 0.05, 1, true);
  EXPECT_EQ(quality.samples(false), 1);  // the picture at rest was slow, too
  show(quality, 0.05, 100);
  EXPECT_EQ(quality.samples(false), 1);
}

TEST(PictureQuality, SmoothnessReturnsDuringMotionThatHasBecomeFast) {
  PictureQuality quality;
  show(quality, 0.05, 20);
  ASSERT_EQ(quality.samples(false), 1);
  show(quality, 0.01, 9);
  EXPECT_EQ(quality.samples(false), 1);
  show(quality, 0.01, 1);
  EXPECT_EQ(quality.samples(false), 0);
  show(quality, 0.01, 100);
  EXPECT_EQ(quality.samples(false), 0);
}

TEST(PictureQuality, SmoothnessReturnsWithAFastPictureAtRest) {
  PictureQuality quality;
  show(quality, 0.05, 20);
  show(quality, 0.01, 1, true);
  EXPECT_EQ(quality.samples(false), 0);
}

}  // namespace
}  // namespace knead::studio
