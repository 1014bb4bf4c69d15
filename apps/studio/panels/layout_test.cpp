#include "panels/layout.h"

#include <gtest/gtest.h>

namespace knead::studio {
namespace {

LayoutQuery query_of(float width, float height, float unit) {
  LayoutQuery query{width, height, unit};
  query.bar = 23 * unit;
  query.item = 38 * unit;
  query.item_gap = 2 * unit;
  query.tools = 13;
  query.panel_width = kPanelWidth;
  return query;
}

TEST(Layout, PanelsStayInTheWindowAndApart) {
  for (const float width : {480.0F, 800.0F, 1440.0F, 3840.0F}) {
    for (const float height : {320.0F, 500.0F, 900.0F, 2160.0F}) {
      for (const float unit : {0.5F, 1.0F, 2.0F, 3.0F}) {
        for (const bool labels : {false, true}) {
          LayoutQuery query = query_of(width, height, unit);
          query.labels = labels;
          const Layout layout = layout_of(query);
          EXPECT_GE(layout.tool_bar.left, 0);
          EXPECT_GE(layout.tool_bar.top, query.bar);
          EXPECT_LE(layout.tool_bar.bottom, height - query.bar);
          EXPECT_LE(layout.tool_bar.right, layout.side_panel.left);
          EXPECT_LE(layout.side_panel.right, width);
          EXPECT_LE(layout.side_panel.bottom, height - query.bar);
          EXPECT_LE(layout.side_panel.width(), 0.45F * width + 0.01F);
          EXPECT_GE(layout.free.width(), 0);
          EXPECT_GE(layout.free.height(), 0);
        }
      }
    }
  }
}

TEST(Layout, TheToolBarScrollsWhereItDoesNotFit) {
  EXPECT_FALSE(layout_of(query_of(1440, 900, 1)).tool_bar_scrolls);
  EXPECT_TRUE(layout_of(query_of(800, 500, 1)).tool_bar_scrolls);
  EXPECT_TRUE(layout_of(query_of(1440, 900, 2)).tool_bar_scrolls);
}

TEST(Layout, ThePersonChoosesTheWidthOfThePanelWithinLimits) {
  LayoutQuery query = query_of(1440, 900, 1);
  query.panel_width = 400;
  EXPECT_FLOAT_EQ(layout_of(query).side_panel.width(), 400);
  query.panel_width = 5;
  EXPECT_FLOAT_EQ(layout_of(query).side_panel.width(), kMinPanelWidth);
  query.panel_width = 5000;
  EXPECT_FLOAT_EQ(layout_of(query).side_panel.width(), kMaxPanelWidth);
}

TEST(Layout, MarginsAreWhatIsNotFree) {
  const Layout layout = layout_of(query_of(1440, 900, 1));
  const Margins margins = margins_of(layout, 1440, 900);
  EXPECT_NEAR(margins.right, 1440 - layout.side_panel.left, 0.5);
  EXPECT_NEAR(margins.left, layout.tool_bar.right, 0.5);
  EXPECT_EQ(margins.top, 23);
  EXPECT_EQ(margins.bottom, 23);
  LayoutQuery hidden = query_of(1440, 900, 1);
  hidden.panels = false;
  EXPECT_EQ(margins_of(layout_of(hidden), 1440, 900), (Margins{0, 23, 0, 23}));
}

}  // namespace
}  // namespace knead::studio
