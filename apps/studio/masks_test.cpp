// Masks in Studio: painted, drawn round, changed as a whole; saved, replayed and undone.
#include <algorithm>

#include "document/document.h"
#include "studio_fixture.h"
#include "view/overlay.h"

namespace knead::studio::masks_test {
namespace {

// Masks what is seen left of the middle.
constexpr const char* kLeftHalf = R"({"tool": "mask"}
{"set": {"mask_mode": "box", "mask_width": 0.4}}
{"drag": [[20, 20], [398, 580]]}
)";
constexpr const char* kPullInTheMiddle = R"({"tool": "ball"}
{"drag": [[0, 0.3, 0.95], [0, 0.8, 0.95]]}
)";

std::size_t masked_count(const Studio& studio) {
  const MaskValues& values = studio.masks().values();
  return static_cast<std::size_t>(std::count(values.begin(), values.end(), 255));
}

TEST_F(StudioTest, MaskedVerticesStayWhileTheRestIsPulled) {
  for (const bool has_worker : {false, true}) {
    Studio studio(options(has_worker));
    run(studio, ball());
    const std::vector<Vec3d> before = positions(studio);
    run(studio, kLeftHalf);
    EXPECT_EQ(errors(studio), "");
    ASSERT_EQ(studio.document().shown().history.size(), 1u);
    EXPECT_TRUE(positions(studio) == before);
    run(studio, kPullInTheMiddle);
    EXPECT_EQ(errors(studio), "");
    const std::vector<Vec3d> after = positions(studio);
    std::size_t moved = 0;
    for (std::size_t v = 0; v < before.size(); ++v) {
      if (before[v].x < -0.02) {
        EXPECT_EQ(after[v], before[v]) << v;
      }
      moved += after[v] == before[v] ? 0 : 1;
    }
    EXPECT_GT(moved, 100u);
    EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == after);
    run(studio, R"({"key": "Ctrl+Z"}
{"key": "Ctrl+Z"})");
    EXPECT_TRUE(studio.document().shown().state.mask.is_empty());
    EXPECT_EQ(masked_count(studio), 0u);
    run(studio, R"({"key": "Ctrl+Shift+Z"}
{"key": "Ctrl+Shift+Z"})");
    EXPECT_TRUE(positions(studio) == after);
    EXPECT_GT(masked_count(studio), 1000u);
    studio.document().close();
  }
}

TEST_F(StudioTest, AHiddenPartIsNeitherSeenNorMetButMoves) {
  Studio studio(options());
  run(studio, ball());
  run(studio, kLeftHalf);
  const auto seen = [&] {
    return visible_mesh(studio.document().shown().objects, studio.document().shown().state).face_count();
  };
  const auto is_met = [&](double x) {
    const Ray ray = ray_through(studio.view().screen(), x, 300);
    return studio.document().shown().picker->pick(ray, studio.document().shown().state).has_value();
  };
  const std::size_t all = seen();
  run(studio, R"({"key": "Ctrl+H"})");
  const std::size_t half = seen();
  EXPECT_NEAR(static_cast<double>(half), 0.5 * static_cast<double>(all), 0.05 * static_cast<double>(all));
  const Ray left = ray_through(studio.view().screen(), 260, 300);
  const auto hit = studio.document().shown().picker->pick(left, studio.document().shown().state);
  EXPECT_TRUE(!hit || hit->point.x > -0.05);
  EXPECT_TRUE(is_met(540));
  // The mask is gone; a pull beside the border moves what is hidden, also after remeshing, which keeps it hidden.
  run(studio, R"({"key": "Alt+M"}
{"set": {"remesh": true, "mirror": [true, false, false]}}
{"tool": "ball"}
{"drag": [[0.2, 0.95, 0.2], [0.3, 1.6, 0.2]]})");
  EXPECT_EQ(errors(studio), "");
  const std::vector<Vec3d> after = positions(studio);
  EXPECT_TRUE(std::any_of(after.begin(), after.end(), [](const Vec3d& p) { return p.x < -0.1 && p.y > 1.3; }));
  EXPECT_GT(after.size(), 2562u) << "it was remeshed";
  EXPECT_LT(seen(), studio.document().shown().state.mesh->face_count());
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == after);
  run(studio, R"({"key": "Alt+H"})");
  EXPECT_EQ(seen(), studio.document().shown().state.mesh->face_count());
  EXPECT_TRUE(is_met(260));
  // The other way round; and nothing is hidden where nothing would be left.
  run(studio,
      std::string(R"({"set": {"mirror": [false, false, false]}})") + "\n" + kLeftHalf + R"({"key": "Shift+H"})");
  EXPECT_TRUE(is_met(260));
  EXPECT_FALSE(studio.document()
                   .shown()
                   .picker->pick(ray_through(studio.view().screen(), 540, 300), studio.document().shown().state)
                   .value_or(SurfaceHit{})
                   .point.x > 0.05);
  const std::size_t isolated = seen();
  run(studio, R"({"key": "Ctrl+M"}
{"key": "Ctrl+H"})");
  EXPECT_EQ(seen(), isolated);
  studio.document().close();
}

TEST_F(StudioTest, AMaskIsPaintedAndErased) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "mask"}
{"set": {"inner_ratio": 0.7}}
{"click": [0, 0, 1]})");
  EXPECT_EQ(errors(studio), "");
  const std::size_t painted = masked_count(studio);
  EXPECT_GT(painted, 20u);
  EXPECT_TRUE(studio.document().shown().state.mask.holds({0, 0, 1}));
  const MaskValues values = studio.masks().values();
  EXPECT_TRUE(std::any_of(values.begin(), values.end(), [](int value) { return value > 0 && value < 255; }))
      << "a brush has a soft rim";
  run(studio, R"({"drag": [[0, 0, 1], [0.4, 0, 0.91]]})");
  EXPECT_GT(masked_count(studio), painted);
  run(studio, R"({"set": {"radius": 1.5}}
{"click": [0, 0, 1], "modifiers": ["ctrl"]})");
  EXPECT_EQ(masked_count(studio), 0u);
  EXPECT_TRUE(studio.document().shown().state.mask.is_empty());
  EXPECT_EQ(studio.document().shown().history.size(), 3u);
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_GT(masked_count(studio), painted);
}

TEST_F(StudioTest, EscapeGivesUpAMask) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "mask"}
{"press": [0, 0, 1]}
{"move": [0.4, 0, 0.91]})");
  EXPECT_TRUE(studio.masks().is_drawing());
  EXPECT_GT(masked_count(studio), 0u);
  run(studio, R"({"key": "Escape"})");
  EXPECT_FALSE(studio.masks().is_drawing());
  EXPECT_EQ(masked_count(studio), 0u);
  EXPECT_TRUE(studio.document().shown().history.empty());
}

TEST_F(StudioTest, AMaskIsChangedAsAWhole) {
  Studio studio(options());
  run(studio, ball());
  const std::size_t all = positions(studio).size();
  run(studio, kLeftHalf);
  const std::size_t half = masked_count(studio);
  run(studio, R"({"mask": "grow"})");
  const std::size_t grown = masked_count(studio);
  EXPECT_GT(grown, half);
  run(studio, R"({"key": "Ctrl+["})");
  EXPECT_LT(masked_count(studio), grown);
  run(studio, R"({"mask": "invert"})");
  EXPECT_GT(masked_count(studio), all - grown - 1);
  run(studio, R"({"mask": "blur"})");
  const MaskValues& values = studio.masks().values();
  EXPECT_TRUE(std::any_of(values.begin(), values.end(), [](int value) { return value > 0 && value < 255; }));
  run(studio, R"({"mask": "fill"})");
  EXPECT_EQ(masked_count(studio), all);
  run(studio, R"({"mask": "clear"})");
  EXPECT_EQ(masked_count(studio), 0u);
  EXPECT_EQ(studio.document().shown().history.size(), 7u);
  EXPECT_EQ(words_of(studio.document().shown().history[5]->strokes, ""), "Mask");
  EXPECT_EQ(words_of(studio.document().shown().history[6]->strokes, ""), "Clear the mask");
  EXPECT_EQ(errors(studio), "");
  run(studio, R"({"mask": "clear"})");  // changes nothing
  EXPECT_EQ(studio.document().shown().history.size(), 7u);
}

TEST_F(StudioTest, ALassoMasksWhatItGoesRound) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "mask"}
{"set": {"mask_mode": "lasso"}}
{"drag": [[350, 250], [450, 250], [400, 350]]})");
  const std::vector<Vec3d> places = positions(studio);
  const MaskValues& values = studio.masks().values();
  std::size_t front = 0;
  for (std::size_t v = 0; v < places.size(); ++v) {
    if (values[v] == 0) continue;
    EXPECT_LT(std::abs(places[v].x), 0.3);  // 50 pixels, and what lies behind is seen smaller
    EXPECT_LT(std::abs(places[v].y), 0.3);
    front += places[v].z > 0 ? 1 : 0;
  }
  EXPECT_GT(front, 5u);
}

// After remeshing the vertices have other numbers: the mask names points.
TEST_F(StudioTest, AMaskAfterRemeshingIsReplayed) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "ball"}
{"set": {"remesh": true}}
{"drag": [[0.5, 0.5, 0.7], [0.8, 0.8, 0.7]]}
{"set": {"remesh": false}})");
  ASSERT_NE(studio.document().shown().state.provenance, nullptr);
  run(studio, kLeftHalf);
  EXPECT_EQ(errors(studio), "");
  const std::size_t masked = masked_count(studio);
  EXPECT_GT(masked, 1000u);
  run(studio, kPullInTheMiddle);
  EXPECT_EQ(errors(studio), "");
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
  run(studio, R"({"mask": "invert"})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_GT(masked_count(studio), 100u);
}

TEST_F(StudioTest, AMaskIsShownDark) {
  Studio studio(options());
  run(studio, ball());
  Overlay overlay;
  EXPECT_FALSE(overlay.mask(studio).has_value());
  run(studio, kLeftHalf);
  const auto shades = overlay.mask(studio);
  ASSERT_TRUE(shades.has_value());
  const std::vector<Vec3d> places = positions(studio);
  for (std::size_t v = 0; v < places.size(); ++v) {
    if (places[v].x < -0.02) {
      EXPECT_EQ((*shades)[v], 1);
    }
    if (places[v].x > 0.4) {
      EXPECT_EQ((*shades)[v], 0);
    }
  }
  EXPECT_FALSE(overlay.mask(studio).has_value()) << "nothing has changed";
  run(studio, R"({"mask": "clear"})");
  const auto cleared = overlay.mask(studio);
  ASSERT_TRUE(cleared.has_value());
  EXPECT_EQ(std::count(cleared->begin(), cleared->end(), 0.0F), static_cast<std::ptrdiff_t>(cleared->size()));
}

}  // namespace
}  // namespace knead::studio::masks_test
