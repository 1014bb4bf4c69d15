#include "panels/layout.h"

#include <algorithm>
#include <cmath>

namespace knead::studio {

namespace {

constexpr float kMaxOfWindow = 0.45F;  // that the side panel takes

}  // namespace

Layout layout_of(const LayoutQuery& query) {
  Layout layout;
  const float gap = kPanelGap * query.unit;
  const float top = query.bar + gap;
  const float bottom = std::max(query.height - query.bar - gap, top);
  layout.free = {0, query.bar, query.width, std::max(query.height - query.bar, query.bar)};
  if (!query.panels) return layout;
  const float padding = kToolBarPadding * query.unit;
  const float needed = static_cast<float>(query.tools) * (query.item + query.item_gap) + 2 * padding;
  layout.tool_bar_scrolls = needed > bottom - top;
  const float label = query.labels ? kToolLabelWidth * query.unit : 0;
  const float scrollbar = layout.tool_bar_scrolls ? kToolScrollbar * query.unit : 0;
  const float right = std::min(gap + 2 * padding + query.item + label + scrollbar, 0.5F * query.width);
  layout.tool_bar = {gap, top, right, std::min(top + needed, bottom)};
  const float wanted = std::clamp(query.panel_width, kMinPanelWidth, kMaxPanelWidth) * query.unit;
  const float width = std::min({wanted, kMaxOfWindow * query.width, query.width - right - 2 * gap});
  layout.side_panel = {query.width - gap - width, top, query.width - gap, bottom};
  layout.free.left = right;
  layout.free.right = std::max(layout.side_panel.left, right);
  return layout;
}

Margins margins_of(const Layout& layout, float width, float height) {
  const auto pixels = [](float length) { return static_cast<int>(std::lround(length)); };
  return {pixels(layout.free.left), pixels(layout.free.top), pixels(width - layout.free.right),
          pixels(height - layout.free.bottom)};
}

}  // namespace knead::studio
