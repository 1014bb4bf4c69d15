// What lies over the picture: statistics, help, the line at the bottom, messages.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <span>
#include <string>
#include <string_view>

#include "panels/file_dialog.h"
#include "panels/panels.h"
#include "panels/widgets.h"
#include "view/overlay.h"

namespace knead::studio {

namespace {

constexpr double kSecondsShown = 5;
constexpr double kSecondsOfErrors = 30;
constexpr std::size_t kMaxMessages = 6;
constexpr float kStatisticsWidth = 420;  // points

constexpr int kOverlay = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize |
                         ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBringToFrontOnFocus;

void begin_row(const char* name) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextDisabled("%s", name);
  ImGui::TableNextColumn();
}

// For a column that is as wide as its table leaves room.
void wrapped_row(const char* name, const std::string& value) {
  begin_row(name);
  ImGui::TextWrapped("%s", value.c_str());
}

std::string volume_text(const DocumentState& shown, const std::optional<double>& on_gpu) {
  if (!shown.volume || !shown.volume_before) return "not closed";
  const double volume = on_gpu.value_or(*shown.volume);
  return fmt::format("{:.6g}  ({:+.4f}%)", volume, 100 * (volume - *shown.volume_before) / *shown.volume_before);
}

void draw_frame_times(const FrameTimes& times) {
  double sum = 0;
  float longest = 0;
  const std::size_t known = std::min(times.count, times.seconds.size());
  for (std::size_t i = 0; i < known; ++i) {
    sum += times.seconds[i];
    longest = std::max(longest, times.seconds[i]);
  }
  const double mean = sum / static_cast<double>(std::max<std::size_t>(known, 1));
  wrapped_row("Frame", fmt::format("{:.1f} ms, longest {:.1f} ms, drawing {:.1f} ms", 1000 * mean, 1000 * longest,
                                   1000 * times.drawing));
}

constexpr float kWhatOfKeys = 0.55F;  // of a column of the help

// Three columns where they fit, else as wide as is easy to read.
float keys_column(const Gui& gui) {
  const float width = 0.97F * ImGui::GetIO().DisplaySize.x;
  return std::min(std::clamp(width / 3, 400 * gui.unit(), 450 * gui.unit()), 0.95F * width);
}

// Begins a table of commands and their keys, under a heading.
bool begin_keys(const Gui& gui, const char* heading) {
  Gui::begin_heading();
  ImGui::TextUnformatted(heading);
  Gui::end_heading();
  if (!ImGui::BeginTable(heading, 2, ImGuiTableFlags_SizingFixedFit)) return false;
  ImGui::TableSetupColumn("what", ImGuiTableColumnFlags_WidthFixed, kWhatOfKeys * keys_column(gui));
  ImGui::TableSetupColumn("how", ImGuiTableColumnFlags_WidthFixed, (0.97F - kWhatOfKeys) * keys_column(gui));
  return true;
}

void draw_keys_of(Studio& studio, const Gui& gui, const char* group) {
  if (!begin_keys(gui, group)) return;
  for (const Action action : all_actions()) {
    if (group_of(action) != group) continue;
    wrapped_row(std::string(title_of(action)).c_str(), keys_text(studio.preferences().keys, action));
  }
  ImGui::EndTable();
}

struct PointerUse {
  const char* what;
  const char* how;
};

void draw_pointer_help(const Gui& gui, NavigationPreset preset) {
  constexpr std::array blender{PointerUse{"Turn the view", "middle button, or Alt+left"},
                               PointerUse{"", "left beside the shape, or the axes in the corner"},
                               PointerUse{"Move the view", "Shift+middle, or Alt+Shift+left"},
                               PointerUse{"Zoom", "wheel, or Ctrl+middle"}};
  constexpr std::array maya{PointerUse{"Turn the view", "Alt+left button"}, PointerUse{"Move the view", "Alt+middle"},
                            PointerUse{"Zoom", "wheel, or Alt+right"}};
  constexpr std::array both{PointerUse{"Use the tool", "left button"},
                            PointerUse{"Settings of the tool", "right click"},
                            PointerUse{"Cancel a drag", "right button, or Escape"},
                            PointerUse{"Radius", "Ctrl+wheel"},
                            PointerUse{"Inner ratio", "Shift+wheel"},
                            PointerUse{"Invert the brush", "Ctrl+left button"},
                            PointerUse{"Smooth the surface", "Shift+left button"},
                            PointerUse{"Even out the triangles only", "Ctrl+Shift+left button"},
                            PointerUse{"Type a number", "Ctrl+click on its slider"}};
  constexpr std::array fingers{PointerUse{"Use the tool", "one finger on the shape"},
                               PointerUse{"Turn the view", "two fingers, or one beside the shape"},
                               PointerUse{"Zoom", "two fingers apart or together"},
                               PointerUse{"Move the view", "three fingers"},
                               PointerUse{"Undo", "tap with two fingers"},
                               PointerUse{"Redo", "tap with three fingers"},
                               PointerUse{"Pose an arm or a leg", "tap twice, hold, and drag"},
                               PointerUse{"Mirror, falloff and more", "More, at the bottom"}};
  if (!begin_keys(gui, is_touched() ? "Fingers" : "Pointer")) return;
  if (is_touched()) {
    for (const PointerUse& gesture : fingers) wrapped_row(gesture.what, gesture.how);
    return ImGui::EndTable();
  }
  const bool is_maya = preset == NavigationPreset::maya;
  for (const PointerUse& gesture : is_maya ? std::span<const PointerUse>(maya) : blender)
    wrapped_row(gesture.what, gesture.how);
  for (const PointerUse& gesture : both) wrapped_row(gesture.what, gesture.how);
  ImGui::EndTable();
}

// Returns what a person does next about an error: the same again, with another file.
std::optional<Action> remedy_of(Subject subject) {
  switch (subject) {
    case Subject::opening:
      return Action::open;
    case Subject::saving:
      return Action::save_as;
    case Subject::exporting:
      return Action::export_shape;
    case Subject::picture:
      return Action::picture;
    case Subject::stamp:
      return Action::stamp_file;
    default:
      return std::nullopt;
  }
}

// What a bend cannot do, a pose can.
bool has_placed_bend(const Studio& studio) {
  return studio.tools().settings().tool->turning.takes_limit_cylinder && studio.tools().placed().placement;
}

// Draws one message; true where the person has clicked it away.
bool draw_message(Studio& studio, const Notice& notice, float opacity, int id) {
  ImGui::PushStyleVar(ImGuiStyleVar_Alpha, opacity);
  ImGui::PushID(id);
  bool gone = false;
  if (notice.is_error) {
    text_in_colour(kError, notice.text);
    if (const std::optional<Action> remedy = remedy_of(notice.subject)) {
      gone = small_button(std::string(title_of(*remedy)).c_str());
      if (gone) studio.perform(*remedy);
      ImGui::SameLine();
    }
    if (notice.subject == Subject::strokes && has_placed_bend(studio)) {
      gone = draw_pose_button(studio);
      ImGui::SameLine();
    }
    gone = small_button("Close") || gone;
  } else {
    ImGui::TextWrapped("%s", notice.text.c_str());
  }
  ImGui::PopID();
  ImGui::PopStyleVar();
  return gone;
}

}  // namespace

void draw_statistics(Studio& studio, const Gui& gui, const Layout& layout, const FrameTimes& times) {
  const DocumentState& shown = studio.document().shown();
  const float gap = kPanelGap * gui.unit();
  // Never under the side panel: longer lines wrap.
  const float width = std::min(kStatisticsWidth * gui.unit(), layout.free.width() - 2 * gap);
  ImGui::SetNextWindowPos({layout.free.left + gap, layout.free.top + gap});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, layout.free.height() - 2 * gap});
  ImGui::SetNextWindowBgAlpha(0.75F);
  if (ImGui::Begin("Statistics", nullptr, kOverlay & ~ImGuiWindowFlags_NoScrollbar) && ImGui::BeginTable("rows", 2)) {
    ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthFixed);
    ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthStretch);
    draw_frame_times(times);
    const std::size_t faces = shown.state.mesh ? shown.state.mesh->face_count() : 0;
    wrapped_row("Shape", fmt::format("{} vertices, {} faces", shown.state.positions.size(), faces));
    if (times.mover.empty()) {
      wrapped_row("Last step", fmt::format("{:.1f} ms, {} vertices touched", 1000 * shown.live_seconds, times.touched));
    } else {
      wrapped_row("Moved by", times.mover);
      wrapped_row("Read back", fmt::format("{} times in this gesture", times.read_back));
      wrapped_row("Last step", fmt::format("{:.1f} ms on the CPU", 1000 * shown.live_seconds));
    }
    wrapped_row("Last stroke", fmt::format("{} steps of path lines", shown.live_steps));
    wrapped_row("Sent", size_text(times.uploaded));
    wrapped_row("Journal", fmt::format("{:.3f} ms", 1000 * shown.journal_seconds));
    wrapped_row("Volume", volume_text(shown, times.volume));
    ImGui::EndTable();
    if (small_button("Count crossings")) studio.document().count_crossings();
  }
  ImGui::End();
}

void draw_help(Studio& studio, const Gui& gui) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * size.x, 0.5F * size.y}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {0.98F * size.x, 0.98F * size.y});
  ImGui::SetNextWindowBgAlpha(1);  // it covers the panels, whose text would shine through
  bool open = true;
  if (ImGui::Begin("Keys", &open,
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse)) {
    const float column = keys_column(gui);
    const int columns = std::clamp(static_cast<int>(0.98F * size.x / column), 1, 3);
    if (ImGui::BeginTable("groups", columns, ImGuiTableFlags_SizingFixedFit)) {
      for (int i = 0; i < columns; ++i) ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, column);
      ImGui::TableNextColumn();
      if (is_touched()) draw_pointer_help(gui, studio.view().navigation().preset);
      for (const char* group : {"File", "Edit", "Window"}) draw_keys_of(studio, gui, group);
      if (!is_touched()) {
        ImGui::BeginDisabled();
        ImGui::TextWrapped("Other keys: \"keys\" in %s", (config_folder() / "studio.json").string().c_str());
        ImGui::EndDisabled();
      }
      ImGui::TableNextColumn();
      draw_keys_of(studio, gui, "Tools");
      ImGui::TableNextColumn();
      draw_keys_of(studio, gui, "View");
      if (!is_touched()) draw_pointer_help(gui, studio.view().navigation().preset);
      ImGui::EndTable();
    }
  }
  ImGui::End();
  if (!open) studio.view().settings().help = false;
}

namespace {

constexpr double kSecondsWithoutBar = 0.3;
constexpr float kBarWidth = 150;

// What is being done, and a bar where it is known how much of it is.
void draw_work(const WorkStatus& work, const Gui& gui, float width) {
  const std::string what = work.what.empty() ? "Working" : work.what;
  const std::string text = fmt::format("{}...{}", what, is_touched() ? "" : " (Escape stops)");
  const float left = width - (kBarWidth + 10) * gui.unit() - ImGui::CalcTextSize(text.c_str()).x;
  ImGui::SameLine(std::max(left, 0.0F));
  ImGui::TextDisabled("%s", text.c_str());
  ImGui::SameLine(width - kBarWidth * gui.unit());
  const std::string part =
      work.fraction ? fmt::format("{:.0f}%", 100 * *work.fraction) : fmt::format("{:.0f} s", work.seconds);
  ImGui::ProgressBar(static_cast<float>(work.fraction.value_or(0)),
                     {(kBarWidth - 10) * gui.unit(), ImGui::GetTextLineHeight()}, part.c_str());
}

}  // namespace

namespace {

struct StatusLine {
  std::string text;
  ImVec4 colour;
};

// Fingers have Ctrl and Shift in the bar, but no other keys.
std::string without_keys(std::string hint) {
  hint = hint.substr(0, hint.find(" Type "));
  const std::string_view alt = "Alt+click removes, ";
  const std::size_t at = hint.find(alt);
  return at == std::string::npos ? hint : hint.erase(at, alt.size());
}

// The first that there is: trouble with the journal, a problem, what was widened, what the tool waits for.
StatusLine status_line(const Studio& studio) {
  const DocumentState& shown = studio.document().shown();
  const ImVec4 dim = ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled);
  if (!shown.journal_trouble.empty()) return {shown.journal_trouble, kError};
  if (!shown.refusal.empty()) return {shown.refusal, kWarning};
  if (std::string note = zone_note(studio); !note.empty()) return {note, ImGui::GetStyleColorVec4(ImGuiCol_Text)};
  if (shown.opened == 0) return {"No shape is open: File > New shape... or Open...", dim};
  if (studio.fit().is_open()) return {"Fit: drag beside a shape to turn it. The tools wait until Fit is closed.", dim};
  const ToolSettings& settings = studio.tools().settings();
  const PlacedTools& placed = studio.tools().placed();
  std::string hint = hint_of(settings, placed, turn_drag(studio.view().screen(), settings, placed));
  if (is_touched()) hint = without_keys(hint);
  return {fmt::format("{}: {}", settings.tool->name, hint), dim};
}

void draw_recording(const Turntable& turntable, const Gui& gui) {
  ImGui::ProgressBar(static_cast<float>(turntable.next) / static_cast<float>(turntable.pictures), {220 * gui.unit(), 0},
                     fmt::format("picture {} of {}", turntable.next, turntable.pictures).c_str());
  ImGui::SameLine();
  ImGui::TextDisabled("Recording a turntable. Escape stops it.");
}

void draw_wrapped_status(Studio& studio, const Gui& gui, const Layout& layout) {
  const float width = layout.free.right - layout.free.left;
  ImGui::SetNextWindowPos({layout.free.left, layout.hint_bottom}, ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::SetNextWindowBgAlpha(0.85F);
  if (ImGui::Begin("Status", nullptr, (kOverlay & ~ImGuiWindowFlags_AlwaysAutoResize) | ImGuiWindowFlags_NoInputs)) {
    const std::optional<WorkStatus> work = studio.document().worker().status();
    if (const auto& turntable = studio.view().turntable()) {
      draw_recording(*turntable, gui);
    } else if (work && work->seconds > kSecondsWithoutBar) {
      draw_work(*work, gui, width);
    } else {
      const StatusLine line = status_line(studio);
      text_in_colour(line.colour, line.text);
    }
  }
  ImGui::End();
}

}  // namespace

void draw_status(Studio& studio, const Gui& gui, const Layout& layout) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float height = ImGui::GetFrameHeight();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {10 * gui.unit(), 3 * gui.unit()});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  if (layout.is_compact) {
    draw_wrapped_status(studio, gui, layout);
    ImGui::PopStyleVar(3);
    return;
  }
  ImGui::SetNextWindowPos({0, size.y - height});
  ImGui::SetNextWindowSize({size.x, height});
  if (ImGui::Begin("Status", nullptr, kOverlay & ~ImGuiWindowFlags_AlwaysAutoResize)) {
    const std::optional<WorkStatus> work = studio.document().worker().status();
    const bool is_long = work && work->seconds > kSecondsWithoutBar;
    const float room = size.x - (is_long ? 2 * kBarWidth : 10) * gui.unit();
    ImGui::PushClipRect({0, size.y - height}, {room, size.y}, true);
    if (const auto& turntable = studio.view().turntable()) {
      draw_recording(*turntable, gui);
    } else {
      const StatusLine line = status_line(studio);
      ImGui::TextColored(line.colour, "%s", line.text.c_str());
      help_on_hover(line.text.c_str());
    }
    ImGui::PopClipRect();
    if (is_long) draw_work(*work, gui, size.x);
  }
  ImGui::End();
  ImGui::PopStyleVar(3);
}

void draw_cancel(Studio& studio, const Gui& gui, const Layout& layout) {
  const char* const what = studio.cancellable();
  if (what == nullptr) return;
  const float gap = kPanelGap * gui.unit();
  ImGui::SetNextWindowPos({layout.free.left + gap, layout.free.top + gap});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  if (ImGui::Begin("Cancel", nullptr, kOverlay)) {
    if (ImGui::Button(what, {0, kTouchSize * gui.unit()})) studio.perform(Action::cancel);
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

namespace {

// Returns whether two texts differ in numbers only: what is said again is not said twice.
bool are_alike(const std::string& a, const std::string& b) {
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  const auto is_same = [&](unsigned char x, unsigned char y) { return x == y || (is_digit(x) && is_digit(y)); };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), is_same);
}

}  // namespace

void update_messages(Messages& messages, std::vector<Notice> notices, double now) {
  for (Notice& notice : notices) {
    std::erase_if(messages.messages, [&](const Messages::Message& message) {
      const bool is_withdrawn = message.notice.is_error && !notice.is_error && notice.subject != Subject::other &&
                                message.notice.subject == notice.subject;
      return is_withdrawn || are_alike(message.notice.text, notice.text);
    });
    if (notice.text.empty()) continue;
    const double until = now + (notice.is_error ? kSecondsOfErrors : kSecondsShown);
    messages.messages.push_back({std::move(notice), until});
  }
  while (messages.messages.size() > kMaxMessages) messages.messages.pop_front();
  std::erase_if(messages.messages, [&](const Messages::Message& message) { return message.until < now; });
}

void draw_messages(Studio& studio, const Gui& gui, const Layout& layout, float below, Messages& messages) {
  const double now = ImGui::GetTime();
  update_messages(messages, studio.document().take_notices(), now);
  if (messages.messages.empty()) return;
  const float gap = kPanelGap * gui.unit();
  const float width = std::min(460 * gui.unit(), layout.free.width() - 2 * gap);
  ImGui::SetNextWindowPos({layout.free.left + gap, layout.free.bottom - below - gap}, ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, 0.6F * layout.free.height()});
  ImGui::SetNextWindowBgAlpha(0.92F);
  if (ImGui::Begin("Messages", nullptr, kOverlay & ~ImGuiWindowFlags_NoBringToFrontOnFocus)) {
    int id = 0;
    std::erase_if(messages.messages, [&](const Messages::Message& message) {
      const auto opacity = static_cast<float>(std::clamp(message.until - now, 0.0, 1.0));
      return draw_message(studio, message.notice, opacity, id++);
    });
  }
  ImGui::End();
}

// --- the numbers of a gesture beside the pointer, the word at the arrow into the picture -----------------------------

namespace {

constexpr ImU32 kInk = IM_COL32(245, 245, 240, 255);
constexpr ImU32 kPaper = IM_COL32(25, 27, 32, 205);

// Within `room`, if it fits there.
void draw_box(const Area& room, ImVec2 at, const std::vector<std::string>& lines, float unit) {
  const float height = ImGui::GetTextLineHeight();
  float width = 0;
  for (const std::string& line : lines) width = std::max(width, ImGui::CalcTextSize(line.c_str()).x);
  const float margin = 6 * unit;
  const ImVec2 size{width + 2 * margin, height * static_cast<float>(lines.size()) + 2 * margin};
  at.x = std::clamp(at.x, room.left, std::max(room.right - size.x, room.left));
  at.y = std::clamp(at.y, room.top, std::max(room.bottom - size.y, room.top));
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled(at, {at.x + size.x, at.y + size.y}, kPaper, 4 * unit);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    list.AddText({at.x + margin, at.y + margin + height * static_cast<float>(i)}, kInk, lines[i].c_str());
  }
}

}  // namespace

void draw_numbers(const Studio& studio, const Gui& gui, const Layout& layout) {
  const Area& room = layout.free;
  const std::vector<std::string> lines = numbers_at_pointer(studio);
  const auto x = static_cast<float>(studio.pointer().x);
  const auto y = static_cast<float>(studio.pointer().y);
  if (!lines.empty()) draw_box(room, {x + 22 * gui.unit(), y + 18 * gui.unit()}, lines, gui.unit());
  const std::optional<InArrow> arrow = studio.view().settings().tool ? in_arrow(studio) : std::nullopt;
  if (!arrow) return;
  const auto tip = pixel_of(studio.view().screen(), arrow->to);
  if (!tip) return;
  draw_box(room, {static_cast<float>(tip->x) + 8 * gui.unit(), static_cast<float>(tip->y)}, {"in"}, gui.unit());
}

// --- the axes in the corner ------------------------------------------------------------------------------------------

namespace {

constexpr float kAxisLength = 30;  // points, of an axis that lies in the picture
constexpr float kAxisEnd = 9;      // radius of its end
constexpr std::array<ImU32, 3> kAxisColours{IM_COL32(214, 72, 66, 255), IM_COL32(98, 158, 50, 255),
                                            IM_COL32(62, 118, 214, 255)};
constexpr std::array kAxisNames{"X", "Y", "Z"};

// An end of an axis, as it is seen.
struct AxisEnd {
  std::size_t axis = 0;
  bool is_positive = true;
  Vec3d direction;
  ImVec2 at;
  double nearness = 0;  // from -1 to 1, towards the person
};

// From the farthest to the nearest.
std::array<AxisEnd, 6> axis_ends(const View& view, ImVec2 middle, float unit) {
  const render::CameraFrame frame = render::camera_frame(camera_of(view));
  std::array<AxisEnd, 6> ends;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    AxisEnd& end = ends[i];
    end.axis = i % 3;
    end.is_positive = i < 3;
    end.direction[end.axis] = end.is_positive ? 1 : -1;
    const double reach = kAxisLength * unit;
    end.at = {middle.x + static_cast<float>(reach * dot(end.direction, frame.right)),
              middle.y - static_cast<float>(reach * dot(end.direction, frame.up))};
    end.nearness = -dot(end.direction, frame.forward);
  }
  std::stable_sort(ends.begin(), ends.end(),
                   [](const AxisEnd& a, const AxisEnd& b) { return a.nearness < b.nearness; });
  return ends;
}

// The view from the end of an axis.
StandardView side_at(const View& view, const Vec3d& direction) {
  constexpr std::array sides{StandardView::front, StandardView::back, StandardView::right,
                             StandardView::left,  StandardView::top,  StandardView::bottom};
  return *std::max_element(sides.begin(), sides.end(), [&](StandardView a, StandardView b) {
    const auto towards = [&](StandardView side) {
      return -dot(render::camera_frame(camera_of(seen_from(view, side))).forward, direction);
    };
    return towards(a) < towards(b);
  });
}

void draw_axis_ends(const std::array<AxisEnd, 6>& ends, const AxisEnd* lit, ImVec2 middle, float unit) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  for (const AxisEnd& end : ends) {
    const ImU32 colour = kAxisColours[end.axis];
    const ImU32 faint = (colour & 0x00FFFFFFU) | IM_COL32(0, 0, 0, 110);
    const float radius = (end.is_positive ? kAxisEnd : 0.6F * kAxisEnd) * unit;
    if (end.is_positive) list.AddLine(middle, end.at, end.nearness < -0.3 ? faint : colour, 2 * unit);
    list.AddCircleFilled(end.at, radius, end.is_positive && end.nearness >= -0.3 ? colour : faint);
    if (&end == lit) list.AddCircle(end.at, radius + unit, IM_COL32(250, 250, 250, 255), 0, 2 * unit);
    if (!end.is_positive) continue;
    const ImVec2 size = ImGui::CalcTextSize(kAxisNames[end.axis]);
    list.AddText({end.at.x - 0.5F * size.x, end.at.y - 0.5F * size.y}, IM_COL32(255, 255, 255, 255),
                 kAxisNames[end.axis]);
  }
}

}  // namespace

void draw_axes(Studio& studio, const Gui& gui, const Layout& layout) {
  const float unit = gui.unit();
  const float side = 2 * (kAxisLength + kAxisEnd + 2) * unit;
  if (studio.view().turntable() || layout.free.width() < 4 * side || layout.free.height() < 3 * side) return;
  const float gap = kPanelGap * unit;
  ImGui::SetNextWindowPos({layout.free.right - gap - side, layout.free.top + gap});
  ImGui::SetNextWindowSize({side, side});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  constexpr int flags = (kOverlay & ~ImGuiWindowFlags_AlwaysAutoResize) | ImGuiWindowFlags_NoBackground;
  if (ImGui::Begin("Axes", nullptr, flags)) {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 middle{corner.x + 0.5F * side, corner.y + 0.5F * side};
    ImGui::InvisibleButton("turn", {side, side});
    const ImGuiIO& io = ImGui::GetIO();
    const View& view = studio.view().navigation().view;
    const std::array<AxisEnd, 6> ends = axis_ends(view, middle, unit);
    const AxisEnd* lit = nullptr;
    for (const AxisEnd& end : ends) {
      const float away = std::hypot(io.MousePos.x - end.at.x, io.MousePos.y - end.at.y);
      if (ImGui::IsItemHovered() && away <= (kAxisEnd + 2) * unit) lit = &end;
    }
    draw_axis_ends(ends, lit, middle, unit);
    const bool is_drag = io.MouseDragMaxDistanceSqr[0] > io.MouseDragThreshold * io.MouseDragThreshold;
    if (ImGui::IsItemActive() && is_drag) studio.view().turn(io.MouseDelta.x, io.MouseDelta.y);
    if (ImGui::IsItemDeactivated() && !is_drag && lit != nullptr) {
      studio.view().look_from(side_at(view, lit->direction));
    }
  }
  ImGui::End();
  ImGui::PopStyleVar(2);
}

}  // namespace knead::studio
