#include "panels/interface.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>
#include <variant>

#include "panels/panels.h"

namespace knead::studio {

namespace {

bool may_repeat(Action action) {
  switch (action) {
    case Action::undo:
    case Action::redo:
    case Action::larger:
    case Action::smaller:
    case Action::rounder:
    case Action::sharper:
      return true;
    default:
      return false;
  }
}

// Events that Studio needs even while a dialog is open: the window's size, and the end of what began before.
bool passes_dialogs(const Event& event) {
  const auto* button = std::get_if<ButtonChanged>(&event);
  const auto* key = std::get_if<KeyChanged>(&event);
  return std::holds_alternative<Resized>(event) || (button != nullptr && !button->down) ||
         (key != nullptr && !key->down);
}

bool is_escape(const Event& event) {
  const auto* key = std::get_if<KeyChanged>(&event);
  return key != nullptr && key->down && key->key == "Escape";
}

}  // namespace

Interface::Interface(Studio& studio, Gui& gui, InterfaceHost host)
    : studio_(studio), gui_(gui), host_(std::move(host)) {
  dialogs_.is_recovery_open = !studio_.document().abandoned().empty();
}

void Interface::set_size(int width, int height) {
  width_ = std::max(width, 1);
  height_ = std::max(height, 1);
  arrange();
  studio_.handle(Resized{width, height});
}

void Interface::arrange() {
  LayoutQuery query;
  query.width = static_cast<float>(width_);
  query.height = static_cast<float>(height_);
  query.unit = gui_.unit();
  query.bar = gui_.bar_height();
  query.item = kToolSize * gui_.unit();
  query.item_gap = kToolGap * gui_.unit();
  query.tools = static_cast<int>(
      std::count_if(studio_tools().begin(), studio_tools().end(), [](const StudioTool& tool) { return tool.in_bar; }));
  query.panels = studio_.view().settings().panels;
  query.labels = studio_.view().settings().tool_labels;
  query.panel_width = static_cast<float>(studio_.preferences().panels.width);
  layout_ = layout_of(query);
  studio_.view().navigation().covered = margins_of(layout_, query.width, query.height);
}

void Interface::handle(const std::vector<Event>& events) {
  arrange();
  studio_.set_pointer_over_view(!gui_.has_pointer());
  for (const Event& event : gui_.for_the_view(events)) {
    if (const auto* size = std::get_if<Resized>(&event)) {
      set_size(size->width, size->height);
    } else if (!is_asking() && is_escape(event) && gui_.close_lists()) {
      continue;
    } else if (!is_asking() || passes_dialogs(event)) {
      send(event);
    }
    answer();
  }
}

void Interface::send(const Event& event) {
  try {
    if (const auto* files = std::get_if<FilesDropped>(&event)) {
      do_or_ask(studio_, dialogs_, [this, dropped = *files] { studio_.handle(dropped); });
    } else if (!is_idle_repeat(event)) {
      studio_.handle(event);
    }
  } catch (const std::exception& error) {
    studio_.document().tell({true, error.what()});
  }
}

// A held key keeps sending events; most actions are meant once.
bool Interface::is_idle_repeat(const Event& event) {
  const auto* key = std::get_if<KeyChanged>(&event);
  if (key == nullptr) return false;
  if (!key->down) return held_.erase(key->key) == 0;
  const bool is_first = held_.insert(key->key).second;
  if (is_first) return false;
  const std::optional<Action> action = action_of(studio_.preferences().keys, {key->key, key->modifiers});
  return !action || !may_repeat(*action);
}

void Interface::answer() {
  const auto action = studio_.take_request();
  if (!action) return;
  if (*action == Action::full_screen) {
    if (host_.toggle_full_screen) host_.toggle_full_screen();
  } else if (*action == Action::quit) {
    close();
  } else {
    answer_request(studio_, dialogs_, *action);
  }
}

void Interface::close() {
  do_or_ask(studio_, dialogs_, [this] { has_ended_ = true; });
}

void Interface::draw(const FrameTimes& times, const Stretched& stretched) {
  arrange();
  draw_numbers(studio_, gui_, layout_);
  draw_axes(studio_, gui_, layout_);
  gui_.set_menu_open(draw_menus(studio_, dialogs_));
  draw_status(studio_, gui_);
  if (studio_.view().settings().panels) {
    draw_tool_bar(studio_, gui_, layout_);
    draw_side_panel(studio_, gui_, layout_, side_panel_);
  }
  if (studio_.view().settings().statistics) draw_statistics(studio_, gui_, layout_, times);
  if (studio_.view().settings().help) draw_help(studio_, gui_);
  const float offer = draw_stretch(studio_, gui_, stretched);
  draw_messages(studio_, gui_, layout_, offer, messages_);
  draw_dialogs(studio_, dialogs_, gui_, host_.write_picture);
  answer();
  if (!gui_.is_dragging()) studio_.view().remember_panels();
}

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

// --- the bar of tools, with their pictures ---------------------------------------------------------------------------

namespace {

// Draws in a square from -1 to 1, y downwards.
class Pen {
 public:
  Pen(ImDrawList& list, ImVec2 center, float half, ImU32 ink, ImU32 light)
      : list_(list), center_(center), half_(half), ink_(ink), light_(light) {}

  ImVec2 at(float x, float y) const { return {center_.x + half_ * x, center_.y + half_ * y}; }
  void line(float x0, float y0, float x1, float y1) const { list_.AddLine(at(x0, y0), at(x1, y1), ink_, width()); }
  void circle(float x, float y, float r) const { list_.AddCircle(at(x, y), half_ * r, ink_, 0, width()); }
  void disc(float x, float y, float r) const { list_.AddCircleFilled(at(x, y), half_ * r, ink_); }
  void halo(float x, float y, float r) const { list_.AddCircleFilled(at(x, y), half_ * r, light_); }
  void box(float x0, float y0, float x1, float y1) const {
    list_.AddRect(at(x0, y0), at(x1, y1), ink_, 0.2F * half_, 0, width());
  }
  // A cubic Bezier curve by its four points, x and y of each.
  void wave(const std::array<float, 8>& p) const {
    list_.AddBezierCubic(at(p[0], p[1]), at(p[2], p[3]), at(p[4], p[5]), at(p[6], p[7]), ink_, width());
  }
  void arc(float x, float y, float r, float from, float to) const {
    list_.PathArcTo(at(x, y), half_ * r, from, to);
    list_.PathStroke(ink_, 0, width());
  }
  void arrow(float x0, float y0, float x1, float y1) const {
    line(x0, y0, x1, y1);
    head(x1, y1, std::atan2(y1 - y0, x1 - x0));
  }
  // The head of an arrow that flies at an angle.
  void head(float x, float y, float angle) const {
    const float r = 0.38F;
    for (const float turn : {2.6F, -2.6F}) line(x, y, x + r * std::cos(angle + turn), y + r * std::sin(angle + turn));
  }

 private:
  float width() const { return 0.16F * half_; }

  ImDrawList& list_;
  ImVec2 center_;
  float half_;
  ImU32 ink_;
  ImU32 light_;
};

void draw(const IconPart& part, const Pen& pen) {
  const std::array<float, 8>& n = part.numbers;
  switch (part.shape) {
    case IconShape::line:
      return pen.line(n[0], n[1], n[2], n[3]);
    case IconShape::circle:
      return pen.circle(n[0], n[1], n[2]);
    case IconShape::disc:
      return pen.disc(n[0], n[1], n[2]);
    case IconShape::halo:
      return pen.halo(n[0], n[1], n[2]);
    case IconShape::box:
      return pen.box(n[0], n[1], n[2], n[3]);
    case IconShape::wave:
      return pen.wave(n);
    case IconShape::arc:
      return pen.arc(n[0], n[1], n[2], n[3], n[4]);
    case IconShape::arrow:
      return pen.arrow(n[0], n[1], n[2], n[3]);
    case IconShape::arrow_head:
      return pen.head(n[0], n[1], n[2]);
  }
}

// Scrolls the last entry into view if it is cut off.
void scroll_to_entry() {
  const float top = ImGui::GetWindowPos().y;
  const float bottom = top + ImGui::GetWindowHeight();
  if (ImGui::GetItemRectMin().y < top || ImGui::GetItemRectMax().y > bottom) ImGui::SetScrollHereY();
}

void draw_button(Studio& studio, const StudioTool& tool, float size, bool is_new) {
  const bool has_name = studio.view().settings().tool_labels;
  const bool chosen = studio.tools().settings().tool == &tool;
  ImGui::PushID(&tool);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  if (ImGui::Selectable("##tool", chosen, 0, {has_name ? 0 : size, size})) studio.perform(action_of(tool));
  if (chosen && is_new) scroll_to_entry();
  if (ImGui::IsItemHovered()) {
    ImGui::SetTooltip("%s  (%s)", tool.name.c_str(), keys_text(studio.preferences().keys, action_of(tool)).c_str());
  }
  const ImU32 ink = ImGui::GetColorU32(chosen ? ImGuiCol_Text : ImGuiCol_TextDisabled);
  const Pen pen(*ImGui::GetWindowDrawList(), {corner.x + 0.5F * size, corner.y + 0.5F * size}, 0.34F * size, ink,
                ImGui::GetColorU32(ImGuiCol_TextDisabled, 0.25F));
  for (const IconPart& part : tool.icon) draw(part, pen);
  if (has_name) {
    const ImVec2 at{corner.x + 1.05F * size, corner.y + 0.5F * (size - ImGui::GetFontSize())};
    ImGui::GetWindowDrawList()->AddText(at, ImGui::GetColorU32(ImGuiCol_Text), tool.name.c_str());
  }
  ImGui::PopID();
}

}  // namespace

void draw_tool_bar(Studio& studio, const Gui& gui, const Layout& layout) {
  const Area& area = layout.tool_bar;
  const float padding = kToolBarPadding * gui.unit();
  ImGui::SetNextWindowPos({area.left, area.top});
  ImGui::SetNextWindowSize({area.width(), area.height()});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {padding, padding});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0, kToolGap * gui.unit()});
  ImGui::PushStyleVar(ImGuiStyleVar_ScrollbarSize, kToolScrollbar * gui.unit());
  int flags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
              ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus;
  if (!layout.tool_bar_scrolls) flags |= ImGuiWindowFlags_NoScrollbar;
  if (ImGui::Begin("Tools", nullptr, flags)) {
    // A tool that a key chose is scrolled into view once; later the person may scroll away from it.
    int* const scrolled_to = ImGui::GetStateStorage()->GetIntRef(ImGui::GetID("scrolled to"), -1);
    const int chosen = static_cast<int>(studio.tools().settings().tool - studio_tools().data());
    const bool is_new = std::exchange(*scrolled_to, chosen) != chosen;
    for (const StudioTool& tool : studio_tools()) {
      if (tool.in_bar) draw_button(studio, tool, kToolSize * gui.unit(), is_new);
    }
  }
  ImGui::End();
  ImGui::PopStyleVar(4);
}

// --- the bar of menus ------------------------------------------------------------------------------------------------

namespace {

void item(Studio& studio, Action action, bool chosen = false, bool enabled = true) {
  const std::string title(title_of(action));
  const KeyMap& keys = studio.preferences().keys;
  const std::string key = keys.of(action).empty() ? "" : text_of(keys.of(action).front());
  if (ImGui::MenuItem(title.c_str(), key.c_str(), chosen, enabled)) studio.perform(action);
}

void draw_recent(Studio& studio, Dialogs& dialogs) {
  if (!ImGui::BeginMenu("Recent", !studio.document().recent().empty())) return;
  for (const std::filesystem::path& path : studio.document().recent()) {
    if (ImGui::MenuItem(path.c_str())) do_or_ask(studio, dialogs, [&studio, path] { studio.document().open(path); });
  }
  ImGui::EndMenu();
}

void draw_file_menu(Studio& studio, Dialogs& dialogs) {
  const bool open = studio.document().shown().opened != 0;
  item(studio, Action::new_shape);
  item(studio, Action::open);
  draw_recent(studio, dialogs);
  item(studio, Action::recover, false, !studio.document().abandoned().empty());
  ImGui::Separator();
  item(studio, Action::save, false, open);
  item(studio, Action::save_as, false, open);
  item(studio, Action::export_shape, false, open);
  item(studio, Action::export_frames, false, open);
  item(studio, Action::picture, false, open);
  item(studio, Action::turntable, false, open);
  ImGui::Separator();
  item(studio, Action::stamp_file, false, open);
  item(studio, Action::reference_image, false, open);
  ImGui::Separator();
  item(studio, Action::quit);
}

void draw_preferences(Studio& studio) {
  Preferences& preferences = studio.preferences();
  Navigation& navigation = studio.view().navigation();
  if (ImGui::BeginMenu("Navigation")) {
    for (const NavigationPreset preset : {NavigationPreset::blender, NavigationPreset::maya}) {
      const char* const name = preset == NavigationPreset::maya ? "As in Maya" : "As in Blender";
      if (ImGui::MenuItem(name, nullptr, preferences.navigation == preset)) {
        preferences.navigation = navigation.preset = preset;
        studio.save_preferences();
      }
    }
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Up")) {
    for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
      if (ImGui::MenuItem(up == UpAxis::y ? "y" : "z", nullptr, preferences.up == up)) {
        preferences.up = navigation.view.up = up;
        studio.save_preferences();
        studio.perform(Action::frame_all);
      }
    }
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Deform on")) {
    for (const BackendChoice mover : {BackendChoice::cpu, BackendChoice::gpu}) {
      const char* const name = mover == BackendChoice::gpu ? "GPU" : "CPU";
      if (ImGui::MenuItem(name, nullptr, preferences.backend == mover)) {
        preferences.backend = mover;
        studio.save_preferences();
      }
    }
    ImGui::EndMenu();
  }
  if (draw_pointer_preferences(preferences)) studio.save_preferences();
  if (ImGui::BeginMenu("Text size")) {
    for (const double scale : {0.85, 1.0, 1.25, 1.5, 2.0}) {
      const std::string name = std::to_string(static_cast<int>(100 * scale)) + "%";
      if (ImGui::MenuItem(name.c_str(), nullptr, preferences.interface_scale == scale)) {
        preferences.interface_scale = scale;
        studio.save_preferences();
      }
    }
    ImGui::EndMenu();
  }
}

void draw_view_menu(Studio& studio) {
  const ViewSettings& view = studio.view().settings();
  for (const Action side : {Action::frame_all, Action::view_front, Action::view_back, Action::view_right,
                            Action::view_left, Action::view_top, Action::view_bottom}) {
    item(studio, side);
  }
  item(studio, Action::frame_stroke);
  item(studio, Action::projection, studio.view().navigation().view.projection == render::Projection::perspective);
  ImGui::Separator();
  item(studio, Action::wireframe, view.wireframe);
  item(studio, Action::shading);
  item(studio, Action::next_matcap);
  item(studio, Action::cavity, view.look.relief.cavity);
  item(studio, Action::occlusion, view.look.relief.occlusion);
  item(studio, Action::background);
  item(studio, Action::references, view.references);
  item(studio, Action::influence, view.influence);
  item(studio, Action::region, view.region);
  item(studio, Action::stretch, view.stretch != StretchView::off);
  item(studio, Action::cutting_plane, view.cut);
  ImGui::Separator();
  item(studio, Action::panels, view.panels);
  item(studio, Action::tool_labels, view.tool_labels);
  item(studio, Action::history, view.history);
  item(studio, Action::statistics, view.statistics);
  item(studio, Action::full_screen);
  ImGui::Separator();
  draw_preferences(studio);
}

void draw_edit_menu(Studio& studio) {
  item(studio, Action::undo, false, !studio.document().shown().history.empty() || studio.gesture().has_value());
  item(studio, Action::redo, false, !studio.document().shown().redoable.empty());
  ImGui::Separator();
  for (const Action action : {Action::mirror_x, Action::mirror_y, Action::mirror_z}) {
    item(studio, action,
         studio.tools().settings().mirror[static_cast<std::size_t>(action) -
                                          static_cast<std::size_t>(Action::mirror_x)]);
  }
  item(studio, Action::remesh, studio.tools().settings().remesh);
  item(studio, Action::remesh_last, false, !studio.document().shown().history.empty());
}

}  // namespace

bool draw_menus(Studio& studio, Dialogs& dialogs) {
  if (!ImGui::BeginMainMenuBar()) return false;
  bool is_open = false;
  const auto menu = [&](const char* title, const auto& draw) {
    if (!ImGui::BeginMenu(title)) return;
    is_open = true;
    draw();
    ImGui::EndMenu();
  };
  menu("File", [&] { draw_file_menu(studio, dialogs); });
  menu("Edit", [&] { draw_edit_menu(studio); });
  menu("View", [&] { draw_view_menu(studio); });
  menu("Help", [&] {
    item(studio, Action::search);
    item(studio, Action::help, studio.view().settings().help);
  });
  ImGui::EndMainMenuBar();
  return is_open;
}

}  // namespace knead::studio
