// Images of strokes in planes and about an axis, and the dabs of a drag that paints.
#include <gtest/gtest.h>

#include <bit>
#include <vector>

#include "knead/editor/tools.h"
#include "strokes/mirror.h"

namespace knead::images_test {
namespace {

const ImageFile kNoFile;

ImplicitStroke bent_pull() { return {{{0.7, 0.7, 0.1}, {0.8, 0.9, 0.1}, {0.8, 1, 0.2}}, 0.1, 0.5}; }

// In the coordinate planes of a bit mask.
std::vector<SymmetryImage> mirror_images(unsigned planes) {
  Mirror mirror;
  if ((planes & 1U) != 0) mirror.push_back({{1, 0, 0}});
  if ((planes & 2U) != 0) mirror.push_back({{0, 1, 0}});
  if ((planes & 4U) != 0) mirror.push_back({{0, 0, 1}});
  return images_in(mirror);
}

std::vector<Stroke> with_mirrors(const Stroke& stroke, unsigned planes) {
  const std::vector<Stroke> strokes{stroke};
  return symmetric_strokes(strokes, mirror_images(planes), 1e-12, kNoFile);
}

TEST(Images, OfEachCombinationOfPlanesThereIsOne) {
  for (unsigned planes = 0; planes < 8; ++planes) {
    const auto images = mirror_images(planes);
    EXPECT_EQ(images.size(), (1U << std::popcount(planes)) - 1) << planes;
    for (const SymmetryImage& image : images) {
      EXPECT_EQ(is_reflection(image.motion), std::popcount(image.planes) % 2 == 1);
      EXPECT_EQ(image.motion({1, 1, 1}), Vec3d((image.planes & 1U) != 0 ? -1 : 1, (image.planes & 2U) != 0 ? -1 : 1,
                                               (image.planes & 4U) != 0 ? -1 : 1));
    }
  }
}

TEST(Images, WithoutMirrorsAStrokeStaysAsItIs) {
  EXPECT_EQ(with_mirrors(bent_pull(), 0), std::vector<Stroke>{bent_pull()});
}

TEST(Images, PiecesOfAPathTakeTurnsWithThoseOfItsImage) {
  const std::vector<Stroke> strokes = with_mirrors(bent_pull(), 1);
  const std::vector<Stroke> pieces = pieces_of(bent_pull());
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_EQ(strokes, (std::vector<Stroke>{pieces[0], mirrored(pieces[0], 0), mirrored(pieces[1], 0), pieces[1]}));
}

TEST(Images, AStrokeThatIsItsOwnImageIsAppliedOnce) {
  RotateStroke turn;
  turn.center = {0, 1, 0.3};
  turn.axis = {1, 0, 0};
  turn.angle_deg = -20;
  turn.inner = 0.1;
  turn.outer = 0.5;
  const StretchStroke stretch{{0, 1, 0.3}, {-2, 0, 0}, 1.5, 0.1, 0.5};
  EXPECT_EQ(with_mirrors(turn, 1), std::vector<Stroke>{turn});
  EXPECT_EQ(with_mirrors(stretch, 1), std::vector<Stroke>{stretch});
  turn.axis = {0, 1, 0};  // the image turns the other way
  EXPECT_EQ(with_mirrors(turn, 1).size(), 2U);
}

TEST(Images, SamplesOfPaintHaveTheirImagesBesideThem) {
  const PaintStroke paint{0.4, 0.1, {{{0.6, 0.8, 0}, {0.6, 0.8, 0}}, {{0.5, 0.8, 0.1}, {0.5, 0.8, 0.1}}}};
  const std::vector<Stroke> strokes = with_mirrors(paint, 1);
  ASSERT_EQ(strokes.size(), 1U);
  const auto& samples = std::get<PaintStroke>(strokes.front()).samples;
  ASSERT_EQ(samples.size(), 4U);
  for (std::size_t i = 0; i < 4; i += 2) {
    EXPECT_EQ(samples[i], paint.samples[i / 2]);
    EXPECT_EQ(samples[i + 1].point.x, -samples[i].point.x);
    EXPECT_EQ(samples[i + 1].normal.x, -samples[i].normal.x);
  }
}

std::size_t dabs_along_a_line(int touches, double pressure) {
  const PaintStroke stroke{0.3, -0.05, {}, {}};
  PaintDrag drag = begin_paint(stroke, {{{0, 0, 0}, {0, 0, 1}}, 0.3, pressure});
  for (int i = 1; i <= touches; ++i) drag_paint(drag, {{{1.0 * i / touches, 0, 0}, {0, 0, 1}}, 0.3, pressure});
  end_paint(drag);
  return drag.stroke.samples.size();
}

TEST(PaintDrag, TheNumberOfDabsFollowsTheWayAndThePressure) {
  const std::size_t dabs = dabs_along_a_line(1000, 1);
  EXPECT_NEAR(static_cast<double>(dabs), 1 + 6 / dab_length({0.3, -0.05, {}}), 1);
  EXPECT_EQ(dabs_along_a_line(5000, 1), dabs);
  EXPECT_NEAR(static_cast<double>(dabs_along_a_line(1000, 0.5)), 0.5 * static_cast<double>(dabs), 1);
}

TEST(PaintDrag, AClickHasTheDepthOfALayer) {
  const PaintStroke stroke{0.3, -0.06, {}, {}};
  PaintDrag drag = begin_paint(stroke, {{{0, 0, 0}, {0, 0, 1}}, 0.3, 1});
  end_paint(drag);
  EXPECT_NEAR(static_cast<double>(drag.stroke.samples.size()) * drag.stroke.depth, -0.06, 1e-12);
}

TEST(PaintDrag, AnotherRadiusBeginsAnotherStroke) {
  const PaintStroke stroke{0.3, -0.06, {}, {}};
  PaintDrag drag = begin_paint(stroke, {{{0, 0, 0}, {0, 0, 1}}, 0.3, 1});
  drag_paint(drag, {{{0.2, 0, 0}, {0, 0, 1}}, 0.15, 1});
  const std::vector<Stroke> strokes = drag.strokes();
  ASSERT_EQ(strokes.size(), 2U);
  EXPECT_EQ(std::get<PaintStroke>(strokes[1]).outer, 0.15);
  EXPECT_NEAR(std::get<PaintStroke>(strokes[1]).depth / std::get<PaintStroke>(strokes[0]).depth, 0.5, 1e-12);
}

}  // namespace
}  // namespace knead::images_test
