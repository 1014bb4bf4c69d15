// The panels around the picture: bars, settings, history, statistics, help. Call them between Gui::begin_frame and
// end_frame. They read everything from Studio, and change everything through it.
#pragma once

#include <imgui.h>

#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gestures/navigation.h"
#include "knead/editor/tools.h"
#include "platform/gui.h"
#include "setting.h"
#include "studio.h"

namespace knead::studio {

// --- where the panels lie in a window
// ---------------------------------------------------------------------------------

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
  float top_bar = 0;      // height of the bar of settings above the picture
  float item = 46;        // height of an entry of the tool bar
  float item_gap = 2;     // below each
  float group_gaps = 0;   // between the groups of tools, all together
  int tools = 0;          // entries of the tool bar
  int tool_pairs = 0;     // its rows where two stand side by side, each group from a new row on
  bool labels = false;    // names beside the icons
  bool panels = true;     // tool bar and side panel are shown
  bool touch = false;     // fingers press
  bool target = false;    // another shape is seen beside the shape
  bool side = true;       // the side panel is open; only a compact window can close it alone
  float panel_width = 0;  // of the side panel, as the person chose it, in points
};

struct Layout {
  bool is_compact = false;  // a phone or a tablet
  bool is_wide = false;     // a compact window whose bar is one row
  float menu_height = 0;
  float hint_bottom = 0;  // of the lines above the bar of a compact window
  Area bottom_bar;        // of a compact window, instead of the others
  Area top_bar;
  Area tool_bar;
  int tool_columns = 1;           // two where one without names is higher than the window
  float tool_size = 46;           // of an entry, in pixels: smaller where a column with names is higher
  bool tool_bar_scrolls = false;  // not all entries fit
  Area side_panel;
  Area free;    // of the picture, between the panels
  Area target;  // the view of the shape that the shown one is fitted to; empty: none is
};

inline constexpr float kPanelWidth = 308;  // points, unless the person chose another
inline constexpr float kMinPanelWidth = 220;
inline constexpr float kMaxPanelWidth = 640;
inline constexpr float kToolLabelWidth = 76;  // points

// The gap between panels and around them, and the padding of the tool bar, in points.
inline constexpr float kPanelGap = 8;
inline constexpr float kToolBarPadding = 4;
inline constexpr float kToolScrollbar = 9;
inline constexpr float kSmallestTool = 0.53F;  // of the size of an entry: a line of text still fits

// Windows narrower than this, in points, higher than wide by this factor, or pressed by fingers are compact: those of a
// phone or a tablet. A bar at their bottom takes the place of the others.
inline constexpr float kCompactWidth = 620;
inline constexpr float kUpright = 1.15F;
inline constexpr float kPhoneWidth = kCompactWidth;  // below it the side panel is a sheet at the bottom
inline constexpr float kWideBar = 760;               // from it on the bar is one row, else two
inline constexpr float kTouchSize = 44;              // points, of what a finger meets

// The side panel takes at most 45% of the window, or in a narrow one 55% of its height; nothing reaches beyond the
// window.
Layout layout_of(const LayoutQuery& query);

// Returns the parts of the picture that the layout covers.
Margins margins_of(const Layout& layout, float width, float height);

// --- the left bar ----------------------------------------------------------------------------------------------------

// The size of an entry, the gap below it, and that between groups, in points.
inline constexpr float kToolSize = 46;
inline constexpr float kToolGap = 2;
inline constexpr float kGroupGap = 8;

// Draws the picture of a tool in the colour of its group, within a square of 2 * half pixels.
void draw_icon(const StudioTool& tool, ImVec2 center, float half);

// Scrolls if not all entries fit; the chosen tool is then scrolled into view.
void draw_tool_bar(Studio& studio, const Gui& gui, const Layout& layout);

// --- settings above the picture: radius, strength, falloff and mirror of the tool in use, as lengths with units ------

// Above and below the bar's widgets, and the room for the tool's name, in points.
inline constexpr float kTopBarPadding = 6;
inline constexpr float kNameWidth = 150;

void draw_top_bar(Studio& studio, const Gui& gui, const Layout& layout);

// Draws the same settings in a menu at the place of a right click, and clears `asked` once it is open.
void draw_pointer_menu(Studio& studio, const Gui& gui, std::optional<Pixel>& asked);

// The state of a compact window's bar. Its Ctrl and Shift stay until they are chosen again.
struct CompactBar {
  bool is_side_open = false;
  Modifiers held;
};

// Draws the bar of a compact window: the tool, its radius and strength, undo, redo, Ctrl, Shift, and the side panel, in
// sizes for a finger.
void draw_bottom_bar(Studio& studio, const Gui& gui, const Layout& layout, CompactBar& bar);

// Draws the setting with this key as its row says: a box to tick, a slider or a list.
void draw_setting(std::span<const Setting> rows, std::string_view key, std::optional<float> width = std::nullopt);
void draw_tool_setting(Studio& studio, std::string_view key, std::optional<float> width = std::nullopt);

// Draws all settings of the bar above the picture, one below the other.
void draw_hand_settings(Studio& studio, float width);

// Chooses a font by its letters; empty: the standard one.
void draw_font(std::string& font);

// has_mode() returns whether the tool in use has several modes: of poses, masks or stamps. draw_mode() draws their
// choice.
bool has_mode(const Studio& studio);
void draw_mode(Studio& studio, float width);

// Returns whether the tool in use follows a drag, in a plane or along a line that the setting "drag" chooses.
bool has_drag_mode(const ToolSettings& settings);

// Returns whether the radius of the tool in use has a meaning.
bool has_radius(const ToolSettings& settings);

// --- the panel on the right ------------------------------------------------------------------------------------------

// The texts and sliders of the history that are being edited.
struct HistoryEditor {
  std::optional<std::size_t> renaming;  // the entry whose name is typed
  std::optional<std::size_t> clicked;   // the entry whose name was clicked last, unless something else was
  std::string name;                     // as typed so far
  bool is_beginning = false;            // the field is drawn for the first time
  std::optional<double> percent;        // strength, while its slider is dragged
  std::optional<double> made;           // requested strength that is not applied yet, in percent
  std::string search;                   // only entries with these words are shown
};

struct SidePanel {
  HistoryEditor editor;
  float settings_height = 0;  // full height of each of the two windows, as last drawn
  float history_height = 0;
  float editor_height = 0;  // of the selected entry's numbers; 0: none is selected
  std::size_t entries = 0;  // of the history, as last drawn
};

// Draws the settings above and the history below, each with the height that it needs. If both are too high, they scroll
// separately, and the history keeps kMinHistory of the height. The numbers of the selected entry stand below, over the
// end of the history where there is no room, so that no row moves. The left edge can be dragged.
inline constexpr float kMinHistory = 0.4F;
void draw_side_panel(Studio& studio, const Gui& gui, const Layout& layout, SidePanel& panel);

// Draw the parts of the side panel: settings that are changed rarely, and the history.
void draw_tool_settings(Studio& studio);
void draw_symmetry(Studio& studio);
void draw_view_settings(Studio& studio, const Gui& gui);
void draw_look_settings(Studio& studio, const Gui& gui);
void draw_references(Studio& studio);
void draw_history(Studio& studio, HistoryEditor& editor);
void draw_entry_editor(Studio& studio, HistoryEditor& editor);
// Draws the list of several objects: which are visible, and which one the pointer meets.
void draw_objects(Studio& studio);

// Draws the curve of a falloff.
void draw_falloff(int falloff);

// Draws the choice of a falloff, with its curve. Returns whether it was changed.
bool choose_falloff(int& falloff);

// Draws the pointer's part of the preferences' menu. Returns whether something was changed.
bool draw_pointer_preferences(Preferences& preferences);

// --- over the picture ------------------------------------------------------------------------------------------------

// Durations of the last frames, in seconds, and numbers of the statistics.
struct FrameTimes {
  std::array<float, 120> seconds{};
  std::size_t count = 0;         // so far; the latest overwrite the oldest
  double drawing = 0;            // of the last frame, without waiting for the display
  std::size_t uploaded = 0;      // bytes, of the last movement
  std::size_t touched = 0;       // vertices, by it; unknown for the GPU
  std::string mover;             // the GPU that moves the shape; empty: the CPU does
  std::optional<double> volume;  // computed by the GPU, while the CPU has not caught up
  std::size_t read_back = 0;     // times, from the GPU since the last gesture began
};

// Draws the axes of the scene, in the upper right corner of the picture if there is room. A click on an end shows the
// shape from there; a drag turns the view.
void draw_axes(Studio& studio, const Gui& gui, const Layout& layout);

// The height of the window of a fit, at the bottom of the target's view, in points.
inline constexpr float kFitPanelHeight = 156;

// Draws the numbers of the pairs of a fit, in both views, and the window of its actions.
void draw_fit(Studio& studio, const Gui& gui, const Layout& layout);

// Draws the numbers of the current gesture beside the pointer.
void draw_numbers(const Studio& studio, const Gui& gui, const Layout& layout);

void draw_statistics(Studio& studio, const Gui& gui, const Layout& layout, const FrameTimes& times);

// Draws the table of all keys.
void draw_help(Studio& studio, const Gui& gui);

// Where fingers press, which have no Escape: draws a button in the upper left corner of the picture that stops the work
// or removes what is placed, if there is any.
void draw_cancel(Studio& studio, const Gui& gui, const Layout& layout);

// Draws the line at the bottom: the hint for the tool, the work in progress, and trouble with the journal. In a compact
// window it wraps, above the bar.
void draw_status(Studio& studio, const Gui& gui, const Layout& layout);

// The stretches in the picture.
struct Stretched {
  bool is_known = false;                    // the stretch of the shown shape is known
  std::optional<GreatestStretch> estimate;  // the stretch that the tool would make
};

// Draws the legend of stretches, the estimate beside the placed tool, and the offer to remesh the last stroke. Returns
// the height of the offer at the bottom of the view.
float draw_stretch(Studio& studio, const Gui& gui, const Stretched& stretched);

// Draws the button that makes a pose of a bend that is impossible. Returns whether it was clicked.
bool draw_pose_button(Studio& studio);

// The shown notices. Reports fade; errors stay until they are closed, withdrawn, or half a minute old.
struct Messages {
  struct Message {
    Notice notice;
    double until = 0;  // ImGui::GetTime()
  };
  std::deque<Message> messages;
};

// Takes over new notices and removes those that have faded or were withdrawn. now: in seconds.
void update_messages(Messages& messages, std::vector<Notice> notices, double now);

// Draws the notices at the bottom of the free part of the picture, with the height `below` left free.
void draw_messages(Studio& studio, const Gui& gui, const Layout& layout, float below, Messages& messages);

}  // namespace knead::studio
