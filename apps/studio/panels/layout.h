// Where the panels lie in a window, as plain arithmetic.
#pragma once

#include "gestures/navigation.h"

namespace knead::studio {

// A rectangle in pixels, from the upper left corner of the window.
struct Area {
  float left = 0;
  float top = 0;
  float right = 0;
  float bottom = 0;

  float width() const { return right - left; }
  float height() const { return bottom - top; }
};

struct LayoutQuery {
  float width = 1;  // of the window, pixels
  float height = 1;
  float unit = 1;         // pixels for one point of the design
  float bar = 23;         // height of the menu bar, and of the line at the bottom
  float item = 38;        // height of an entry of the tool bar
  float item_gap = 2;     // below each
  int tools = 0;          // entries of the tool bar
  bool labels = false;    // names beside the icons
  bool panels = true;     // tool bar and side panel are shown
  float panel_width = 0;  // of the side panel, as the person chose it, in points
};

struct Layout {
  Area tool_bar;
  bool tool_bar_scrolls = false;  // not all entries fit
  Area side_panel;
  Area free;  // of the picture, between the panels
};

inline constexpr float kPanelWidth = 308;  // points, unless the person chose another
inline constexpr float kMinPanelWidth = 220;
inline constexpr float kMaxPanelWidth = 640;
inline constexpr float kToolLabelWidth = 76;  // points

// The gap between panels and around them, and the padding of the tool bar, in points.
inline constexpr float kPanelGap = 8;
inline constexpr float kToolBarPadding = 4;
inline constexpr float kToolScrollbar = 9;

// The side panel takes at most 45% of the window; nothing reaches beyond the window.
Layout layout_of(const LayoutQuery& query);

// What the layout covers of the picture.
Margins margins_of(const Layout& layout, float width, float height);

}  // namespace knead::studio
