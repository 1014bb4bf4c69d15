// The fit of the shape to another one, driven by the events of a window.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "document/layers.h"
#include "knead/io.h"
#include "knead/vec.h"
#include "panels/interface_fixture.h"

namespace knead::studio::fit_test {
namespace {

constexpr const char* kWindow = "###Fit";

class FitWindow : public StudioTest {
 protected:
  // The shape is a ball; the target a ball that is longer in x and as much thinner.
  void open(ShownPanels& panels) const {
    run(panels.studio, R"({"new": "sphere", "vertices": 2562})");
    run(panels.studio, R"({"key": "Alt+1"}
{"key": "Home"})");
    ShapeFile target;
    target.mesh = panels.studio.document().shown().state.to_mesh();
    for (Vec3d& p : target.mesh.positions) p = {1.2 * p.x, p.y / std::sqrt(1.2), p.z / std::sqrt(1.2)};
    write_shape(folder_ / "target.ply", target, target.mesh.positions);
    panels.studio.fit().open(folder_ / "target.ply", panels.studio.view().navigation());
    panels.frame();
    panels.frame();
  }

  static Pixel middle_of_shape(const ShownPanels& panels) {
    return pixel_of(panels.studio.view().screen(), {0, 0, 0}).value();
  }
  static Pixel middle_of_target(const ShownPanels& panels) {
    const Area& area = panels.interface.layout().target;
    const Pixel at = pixel_of(panels.studio.fit().screen(), {0, 0, 0}).value();
    return {at.x + area.left, at.y + area.top};
  }
};

TEST_F(FitWindow, IsBesideTheShape) {
  for (const auto& [width, height] : {std::pair{1440, 900}, {390, 844}, {1024, 1366}}) {
    ShownPanels panels(options(), width, height);
    open(panels);
    ASSERT_TRUE(panels.studio.fit().is_open());
    const Layout& layout = panels.interface.layout();
    EXPECT_TRUE(layout.free.right == layout.target.left || layout.free.bottom == layout.target.top);
    EXPECT_GT(std::min(layout.target.width(), layout.target.height()), 150);
    const Screen screen = panels.studio.fit().screen();
    EXPECT_NEAR(screen.width, layout.target.width(), 1);
    EXPECT_NEAR(screen.height, layout.target.height(), 1);
    panels.studio.fit().close();
    panels.frame();
    EXPECT_EQ(panels.interface.layout().target.width(), 0);
  }
}

TEST_F(FitWindow, PairsAreClickedInBothViews) {
  ShownPanels panels(options(), 1440, 900);
  open(panels);
  StudioFit& fit = panels.studio.fit();
  const Pixel shape = middle_of_shape(panels);
  const Pixel target = middle_of_target(panels);
  panels.click(shape.x, shape.y);
  ASSERT_EQ(fit.pairs().size(), 1u);
  EXPECT_EQ(fit.complete_pairs(), 0u);
  panels.click(shape.x + 60, shape.y);  // another point of the same pair
  ASSERT_EQ(fit.pairs().size(), 1u);
  panels.click(target.x + 60, target.y);
  EXPECT_EQ(fit.complete_pairs(), 1u);
  panels.click(target.x, target.y);  // the other order
  panels.click(shape.x, shape.y);
  ASSERT_EQ(fit.complete_pairs(), 2u);
  EXPECT_EQ(*fit.pairs()[1].source, *fit.pairs()[1].target) << "the same vertex faces the person in both";
  EXPECT_TRUE(panels.studio.document().shown().history.empty()) << "no tool acts while a fit is open";
  ASSERT_TRUE(panels.click_item(kWindow, "Remove last"));
  EXPECT_EQ(fit.pairs().size(), 1u);
}

TEST_F(FitWindow, EachViewTurnsByItself) {
  ShownPanels panels(options(), 1440, 900);
  open(panels);
  const View shape = panels.studio.view().navigation().view;
  const render::Camera before = panels.studio.fit().screen().camera;
  const Area area = panels.interface.layout().target;
  panels.drag(area.right - 20, area.top + 20, area.right - 120, area.top + 20);
  EXPECT_EQ(panels.studio.view().navigation().view, shape);
  const render::Camera after = panels.studio.fit().screen().camera;
  EXPECT_GT(norm(after.eye - before.eye), 0.1);
  panels.drag(panels.interface.layout().free.left + 20, area.bottom - 20, panels.interface.layout().free.left + 90,
              area.bottom - 20);
  EXPECT_FALSE(panels.studio.view().navigation().view == shape);
  EXPECT_EQ(norm(panels.studio.fit().screen().camera.eye - after.eye), 0);
  EXPECT_TRUE(panels.studio.fit().pairs().empty());
}

TEST_F(FitWindow, FitsAsOneEntryAndMeasures) {
  ShownPanels panels(options(), 1440, 900);
  open(panels);
  StudioFit& fit = panels.studio.fit();
  const double before = fit.mean_distance();
  EXPECT_GT(before, 0.01);
  // The ends of the axes alone; the library's tests bring whole surfaces together.
  run(panels.studio,
      R"({"fit": ")" + (folder_ / "target.ply").string() +
          R"(", "pairs": [[0, 0], [1, 1], [2, 2], [3, 3], [4, 4], [5, 5], [6, 6], [7, 7], [8, 8], [9, 9], [10, 10], [11, 11]], "surface": false, "run": false})");
  panels.frame();
  ASSERT_TRUE(panels.click_item(kWindow, "Fit")) << errors(panels.studio);
  panels.frame();
  EXPECT_EQ(panels.studio.document().shown().history.size(), 1u);
  EXPECT_EQ(name_of(panels.studio.document().shown().history.front()->strokes), "Fit to target.ply");
  ASSERT_TRUE(fit.report().has_value());
  EXPECT_TRUE(fit.report()->is_sound);
  EXPECT_LT(fit.mean_distance(), 0.8 * before);
  EXPECT_EQ(fit.distances().size(), 2562u);
  panels.key("Ctrl+Z");
  panels.frame();
  panels.frame();
  EXPECT_FALSE(fit.report().has_value()) << "it is about another shape";
  EXPECT_NEAR(fit.mean_distance(), before, 1e-12);
  panels.key("Ctrl+Y");
  const ReplayResult replayed = saved_and_replayed(panels.studio);
  EXPECT_TRUE(replayed.shape.positions() == positions(panels.studio));
}

TEST_F(FitWindow, TellsWhatCannotBeRead) {
  ShownPanels panels(options(), 1440, 900);
  run(panels.studio, R"({"new": "sphere", "vertices": 642})");
  panels.studio.fit().open(folder_ / "nothing.ply", panels.studio.view().navigation());
  EXPECT_FALSE(panels.studio.fit().is_open());
  EXPECT_NE(errors(panels.studio).find("nothing.ply"), std::string::npos);
}

}  // namespace
}  // namespace knead::studio::fit_test
