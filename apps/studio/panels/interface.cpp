// Which events go to panels, dialogs or the shape, and what panels may ask for.
#include "panels/interface.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>
#include <variant>

#include "gestures/gesture_kinds.h"
#include "panels/panels.h"
#include "panels/widgets.h"

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

Pixel middle_of(const Area& area) { return {0.5 * (area.left + area.right), 0.5 * (area.top + area.bottom)}; }

// A right click that is about nothing else asks for the settings at the pointer.
bool is_right(const Event& event, bool down) {
  const auto* button = std::get_if<ButtonChanged>(&event);
  return button != nullptr && button->button == MouseButton::right && button->down == down &&
         button->modifiers == Modifiers{};
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
  const bool had_size = width_ > 1;
  const double before = height_;
  const Vec3d middle = middle_of_free();
  width_ = std::max(width, 1);
  height_ = std::max(height, 1);
  arrange();
  studio_.handle(Resized{width, height});
  // A device that is turned, or has opened its keyboard, shows the shape as large, in the middle of what is left.
  if (!had_size || !gui_.is_touch()) return;
  studio_.view().navigation().view.height *= height_ / before;
  show_in_middle(middle);
}

// Returns the point in the middle of the free part, as deep as the view's target.
Vec3d Interface::middle_of_free() const {
  const Navigation& at = studio_.view().navigation();
  const Pixel middle = middle_of(layout_.free);
  return under_pointer(at.view, middle.x, middle.y, at.width, at.height);
}

void Interface::show_in_middle(const Vec3d& point) {
  Navigation& at = studio_.view().navigation();
  const auto before = pixel_of(studio_.view().screen(), point);
  const Pixel to = middle_of(layout_.free);
  if (before) at.view = panned(at.view, to.x - before->x, to.y - before->y, at.height);
}

namespace {

constexpr double kFingerScale = 1.5;  // what fingers grab is larger by this

int tool_pairs() {
  int rows = 0;
  for (const ToolGroup group : kToolGroups) {
    const auto is_in_group = [&](const StudioTool& tool) { return tool.group == group; };
    const auto count = std::count_if(studio_tools().begin(), studio_tools().end(), is_in_group);
    rows += static_cast<int>((count + 1) / 2);
  }
  return rows;
}

}  // namespace

void Interface::arrange() {
  studio_.view().set_unit(gui_.unit() * (gui_.is_touch() ? kFingerScale : 1));
  LayoutQuery query;
  query.width = static_cast<float>(width_);
  query.height = static_cast<float>(height_);
  query.unit = gui_.unit();
  query.bar = gui_.bar_height();
  query.item = kToolSize * gui_.unit();
  query.item_gap = kToolGap * gui_.unit();
  query.tools = static_cast<int>(studio_tools().size());
  query.tool_pairs = tool_pairs();
  query.group_gaps = static_cast<float>(kToolGroups.size() - 1) * (kGroupGap + kToolGap) * gui_.unit();
  query.panels = studio_.view().settings().panels;
  query.top_bar = gui_.bar_height() + 2 * kTopBarPadding * gui_.unit();
  query.labels = studio_.view().settings().tool_labels;
  query.panel_width = static_cast<float>(studio_.preferences().panels.width);
  query.side = compact_.is_side_open;
  query.touch = gui_.is_touch();
  query.target = studio_.fit().is_open();
  const bool had_target = layout_.target.width() > 0;
  const bool had_side = layout_.side_panel.height() > 0;
  const Vec3d middle = middle_of_free();
  layout_ = layout_of(query);
  const auto pixels = [](float length) { return std::max(1, static_cast<int>(std::lround(length))); };
  if (query.target) {
    studio_.fit().set_size(
        {pixels(layout_.target.width()), pixels(layout_.target.height()),
         Margins{.bottom = pixels(std::min(kFitPanelHeight * gui_.unit(), 0.5F * layout_.target.height()))}});
  }
  studio_.view().navigation().covered = margins_of(layout_, query.width, query.height);
  const bool has_side = layout_.side_panel.height() > 0;
  if (gui_.is_touch() && has_side != had_side) show_in_middle(middle);
  if (query.target != had_target) studio_.view().frame_all();
}

void Interface::handle(const std::vector<Event>& events) {
  arrange();
  studio_.set_pointer_over_view(!gui_.has_pointer() && !is_over_target_);
  for (const Event& event : gui_.for_the_view(events)) {
    if (const auto* size = std::get_if<Resized>(&event)) {
      set_size(size->width, size->height);
    } else if (!is_asking() && is_escape(event) && gui_.close_lists()) {
      continue;
    } else if (!is_asking() && is_escape(event) && dialogs_.welcome.tour) {
      dialogs_.welcome.tour.reset();
    } else if (const auto* dropped = std::get_if<FilesDropped>(&event);
               dropped != nullptr && (asks_for_files(dialogs_.file) || dialogs_.welcome.is_open)) {
      dialogs_.file.brought = dropped->files;
    } else if (!is_asking() || passes_dialogs(event)) {
      const bool was_free = !studio_.is_in_hand();
      send(event);
      note_right_click(event, was_free);
    }
    answer();
  }
}

// The button must be let go where it was pressed: some turn the view with it.
void Interface::note_right_click(const Event& event, bool was_free) {
  if (is_right(event, true)) {
    const auto& button = std::get<ButtonChanged>(event);
    right_press_ = was_free && !studio_.is_in_hand() ? std::optional(Pixel{button.x, button.y}) : std::nullopt;
  } else if (is_right(event, false) && right_press_) {
    const auto& button = std::get<ButtonChanged>(event);
    const double way = std::hypot(button.x - right_press_->x, button.y - right_press_->y);
    if (way <= kClick * gui_.unit() && !is_asking()) pointer_menu_ = std::exchange(right_press_, std::nullopt);
    right_press_.reset();
  }
}

namespace {

// Ctrl and Shift that a bar holds count for the pointer as those of a keyboard.
Event with_modifiers(Event event, const Modifiers& held) {
  const auto add = [&](Modifiers& modifiers) {
    modifiers.ctrl = modifiers.ctrl || held.ctrl;
    modifiers.shift = modifiers.shift || held.shift;
  };
  if (auto* moved = std::get_if<PointerMoved>(&event)) add(moved->modifiers);
  auto* const button = std::get_if<ButtonChanged>(&event);
  if (button != nullptr && button->button == MouseButton::left) add(button->modifiers);  // others move the view
  return event;
}

}  // namespace

void Interface::send(const Event& given) {
  const Event event = layout_.is_compact ? with_modifiers(given, compact_.held) : given;
  try {
    if (send_to_target(event)) return;
    if (const auto* files = std::get_if<FilesDropped>(&event)) {
      do_or_ask(studio_, dialogs_, [this, dropped = *files] { studio_.handle(dropped); });
    } else if (!is_idle_repeat(event)) {
      studio_.handle(event);
    }
  } catch (const std::exception& error) {
    studio_.document().tell({true, error.what()});
  }
}

// What happens over the view of the target, and the drags that began there, are for it.
bool Interface::send_to_target(const Event& event) {
  StudioFit& fit = studio_.fit();
  if (!fit.is_open()) return is_over_target_ = false;
  const Area& area = layout_.target;
  Event own = event;
  const auto place = [&](double& x, double& y) {
    is_over_target_ = x >= area.left && x < area.right && y >= area.top && y < area.bottom;
    x -= area.left;
    y -= area.top;
  };
  if (auto* moved = std::get_if<PointerMoved>(&own)) place(moved->x, moved->y);
  if (auto* button = std::get_if<ButtonChanged>(&own)) place(button->x, button->y);
  const bool is_of_pointer = std::holds_alternative<PointerMoved>(own) || std::holds_alternative<ButtonChanged>(own) ||
                             std::holds_alternative<WheelTurned>(own);
  const bool is_elsewhere = studio_.is_in_hand() || studio_.view().navigation().drag != NavigationDrag::none;
  if (!is_of_pointer || is_elsewhere || !(is_over_target_ || fit.is_turning())) return false;
  fit.handle(own);
  return true;
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

void Interface::welcome() { dialogs_.welcome.is_open = studio_.preferences().welcome && !dialogs_.is_recovery_open; }

void Interface::close() {
  do_or_ask(studio_, dialogs_, [this] { has_ended_ = true; });
}

void Interface::draw(const FrameTimes& times, const Stretched& stretched) {
  arrange();
  draw_numbers(studio_, gui_, layout_);
  draw_axes(studio_, gui_, layout_);
  draw_fit(studio_, gui_, layout_);
  gui_.set_menu_open(draw_menus(studio_, dialogs_));
  draw_status(studio_, gui_, layout_);
  if (layout_.top_bar.height() > 0) draw_top_bar(studio_, gui_, layout_);
  if (layout_.tool_bar.height() > 0) draw_tool_bar(studio_, gui_, layout_);
  if (layout_.bottom_bar.height() > 0) draw_bottom_bar(studio_, gui_, layout_, compact_);
  if (layout_.side_panel.height() > 0) draw_side_panel(studio_, gui_, layout_, side_panel_);
  if (studio_.view().settings().statistics) draw_statistics(studio_, gui_, layout_, times);
  if (studio_.view().settings().help) draw_help(studio_, gui_);
  const float offer = draw_stretch(studio_, gui_, stretched);
  draw_messages(studio_, gui_, layout_, offer, messages_);
  if (gui_.is_touch()) draw_cancel(studio_, gui_, layout_);
  draw_pointer_menu(studio_, gui_, pointer_menu_);
  draw_tour(studio_, dialogs_.welcome, gui_, layout_);
  draw_dialogs(studio_, dialogs_, gui_, host_.write_picture);
  answer();
  if (!gui_.is_dragging()) studio_.view().remember_panels();
}

namespace {

constexpr float kMaxOfWindow = 0.45F;  // that the side panel takes
constexpr float kSheetHeight = 0.55F;  // of a phone's picture, that its side panel takes
constexpr float kHintLine = 20;        // points, above the bar of a compact window

// A bar at the bottom, and the side panel only on demand.
void lay_out_compact(const LayoutQuery& query, Layout& layout) {
  const float gap = kPanelGap * query.unit;
  layout.is_wide = query.width >= kWideBar * query.unit;
  const float rows = layout.is_wide ? 1 : 2;
  const float height = std::min(rows * (kTouchSize * query.unit + gap) + gap, 0.5F * query.height);
  const float hints = (rows * kHintLine + 6) * query.unit;
  const float bottom = query.panels ? query.height - height : query.height;
  layout.hint_bottom = bottom;
  layout.free = {0, query.bar, query.width, std::max(bottom - hints, query.bar)};
  if (!query.panels) return;
  layout.bottom_bar = {0, bottom, query.width, query.height};
  if (!query.side) return;
  if (query.width < kPhoneWidth * query.unit) {
    const float top = bottom - kSheetHeight * (bottom - query.bar);
    layout.side_panel = {gap, top, query.width - gap, bottom - gap};
    layout.hint_bottom = top;
    layout.free.bottom = std::max(top - hints, query.bar);
  } else {
    const float wanted = std::clamp(query.panel_width, kMinPanelWidth, kMaxPanelWidth) * query.unit;
    const float width = std::min(wanted, kMaxOfWindow * query.width);
    layout.side_panel = {query.width - gap - width, query.bar + gap, query.width - gap, layout.free.bottom};
    layout.free.right = layout.side_panel.left;
  }
}

}  // namespace

namespace {

// Without the target's view.
Layout lay_out_panels(const LayoutQuery& query) {
  Layout layout;
  layout.menu_height = query.bar;
  layout.is_compact = query.touch || query.width < kCompactWidth * query.unit || query.height > kUpright * query.width;
  if (layout.is_compact) {
    lay_out_compact(query, layout);
    return layout;
  }
  const float gap = kPanelGap * query.unit;
  const float bars = query.bar + (query.panels ? query.top_bar : 0);
  const float top = bars + gap;
  const float bottom = std::max(query.height - query.bar - gap, top);
  layout.free = {0, bars, query.width, std::max(query.height - query.bar, bars)};
  if (!query.panels) return layout;
  layout.top_bar = {0, query.bar, query.width, bars};
  const float padding = kToolBarPadding * query.unit;
  layout.tool_size = query.item;
  const auto height_of = [&](int rows) {
    return static_cast<float>(rows) * (layout.tool_size + query.item_gap) + query.group_gaps + 2 * padding;
  };
  const bool is_high = height_of(query.tools) > bottom - top;
  layout.tool_columns = !query.labels && is_high ? 2 : 1;
  if (query.labels && is_high) {
    const float over = (height_of(query.tools) - (bottom - top)) / static_cast<float>(query.tools);
    layout.tool_size = std::max(query.item - over, kSmallestTool * query.item);
  }
  const float needed = height_of(layout.tool_columns == 1 ? query.tools : query.tool_pairs);
  layout.tool_bar_scrolls = needed > bottom - top;
  const float label = query.labels ? kToolLabelWidth * query.unit : 0;
  const float scrollbar = layout.tool_bar_scrolls ? kToolScrollbar * query.unit : 0;
  const float items = static_cast<float>(layout.tool_columns) * layout.tool_size;
  const float right = std::min(gap + 2 * padding + items + label + scrollbar, 0.5F * query.width);
  layout.tool_bar = {gap, top, right, std::min(top + needed, bottom)};
  const float wanted = std::clamp(query.panel_width, kMinPanelWidth, kMaxPanelWidth) * query.unit;
  const float width = std::min({wanted, kMaxOfWindow * query.width, query.width - right - 2 * gap});
  layout.side_panel = {query.width - gap - width, top, query.width - gap, bottom};
  layout.free.left = right;
  layout.free.right = std::max(layout.side_panel.left, right);
  return layout;
}

}  // namespace

Layout layout_of(const LayoutQuery& query) {
  Layout layout = lay_out_panels(query);
  if (!query.target) return layout;
  layout.target = layout.free;
  if (layout.free.width() >= layout.free.height()) {
    layout.free.right = layout.target.left = 0.5F * (layout.free.left + layout.free.right);
  } else {
    layout.free.bottom = layout.target.top = 0.5F * (layout.free.top + layout.free.bottom);
  }
  return layout;
}

Margins margins_of(const Layout& layout, float width, float height) {
  const auto pixels = [](float length) { return static_cast<int>(std::lround(length)); };
  return {pixels(layout.free.left), pixels(layout.free.top), pixels(width - layout.free.right),
          pixels(height - layout.free.bottom)};
}

// --- the bar of menus ------------------------------------------------------------------------------------------------

namespace {

void draw_recent(Studio& studio, Dialogs& dialogs) {
  if (!ImGui::BeginMenu("Recent", !studio.document().recent().empty())) return;
  for (const std::filesystem::path& path : studio.document().recent()) {
    if (ImGui::MenuItem(path.string().c_str()))
      do_or_ask(studio, dialogs, [&studio, path] { studio.document().open(path); });
  }
  ImGui::EndMenu();
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

// The actions of a menu, in groups.
struct Menu {
  const char* title;
  std::vector<std::vector<Action>> groups;
};

const std::vector<Menu>& menus() {
  using enum Action;
  static const std::vector<Menu> kMenus{
      {"File",
       {{new_shape, open, add_shape, recover},
        {save, save_as, export_shape, export_frames, picture, poster, turntable},
        {stamp_file, reference_image},
        {quit}}},
      {"Edit", {{undo, redo}, {mirror_x, mirror_y, mirror_z, remesh, remesh_last}, {fit}}},
      {"View",
       {{frame_all, view_front, view_back, view_right, view_left, view_top, view_bottom, keep_view, kept_view,
         frame_stroke, projection},
        {hide_masked, hide_unmasked, show_all},
        {wireframe, shading, next_matcap, cavity, occlusion, background, references, influence, region, stretch,
         cutting_plane},
        {panels, tool_labels, history, statistics, full_screen}}},
      {"Help", {{search, help, welcome, tour}}}};
  return kMenus;
}

bool is_possible(const Studio& studio, Action action) {
  const DocumentState& shown = studio.document().shown();
  switch (action) {
    case Action::recover:
      return !studio.document().abandoned().empty();
    case Action::undo:
      return !shown.history.empty() || studio.gesture().has_value();
    case Action::redo:
      return !shown.redoable.empty();
    case Action::remesh_last:
      return !shown.history.empty();
    case Action::hide_masked:
    case Action::hide_unmasked:
      return !studio.masks().values().empty();
    case Action::show_all:
      return shown.objects.hidden != nullptr;
    case Action::new_shape:
    case Action::open:
    case Action::quit:
      return true;
    default:
      return group_of(action) != "File" || shown.opened != 0;
  }
}

bool is_chosen(Studio& studio, Action action) {
  ToolSettings& tool = studio.tools().settings();
  if (action >= Action::mirror_x && action <= Action::mirror_z) {
    return tool.mirror[static_cast<std::size_t>(action) - static_cast<std::size_t>(Action::mirror_x)];
  }
  if (action == Action::projection) {
    return studio.view().navigation().view.projection == render::Projection::perspective;
  }
  if (action == Action::fit) return studio.fit().is_open();
  const std::string_view key = action == Action::cutting_plane ? "cut" : name_of(action);
  for (const std::vector<Setting>& rows : {settings_of(studio.view().settings()), settings_of(tool)}) {
    const Setting* const row = find_setting(rows, key);
    const auto* const flag = row == nullptr ? nullptr : std::get_if<bool*>(&row->value);
    if (flag != nullptr) return **flag;
  }
  return action == Action::stretch && studio.view().settings().stretch != StretchView::off;
}

void draw_menu(Studio& studio, Dialogs& dialogs, const Menu& menu) {
  const KeyMap& keys = studio.preferences().keys;
  for (const std::vector<Action>& group : menu.groups) {
    if (group != menu.groups.front()) ImGui::Separator();
    for (const Action action : group) {
      if (action == Action::recover) draw_recent(studio, dialogs);
      const bool has_key = !keys.of(action).empty() && !is_touched();
      const std::string key = has_key ? text_of(keys.of(action).front()) : "";
      if (ImGui::MenuItem(std::string(title_of(action)).c_str(), key.c_str(), is_chosen(studio, action),
                          is_possible(studio, action))) {
        studio.perform(action);
      }
    }
  }
  if (std::string_view(menu.title) != "View") return;
  ImGui::Separator();
  draw_preferences(studio);
}

}  // namespace

std::string place_of(Action action) {
  if (const StudioTool* const tool = tool_of(action)) return fmt::format("Tools, {}", name_of(tool->group));
  for (const Menu& menu : menus()) {
    for (const std::vector<Action>& group : menu.groups) {
      if (std::find(group.begin(), group.end(), action) != group.end()) return fmt::format("Menu {}", menu.title);
    }
  }
  const bool is_mask = action >= Action::mask_fill && action <= Action::mask_shrink;
  return is_mask ? "Mask: more settings" : action == Action::cancel || action == Action::finish ? "Key" : "Bar above";
}

bool draw_menus(Studio& studio, Dialogs& dialogs) {
  if (!ImGui::BeginMainMenuBar()) return false;
  bool is_open = false;
  begin_rows();
  for (const Menu& menu : menus()) {
    if (!ImGui::BeginMenu(menu.title)) continue;
    is_open = true;
    draw_menu(studio, dialogs, menu);
    ImGui::EndMenu();
  }
  end_rows();
  ImGui::EndMainMenuBar();
  return is_open;
}

}  // namespace knead::studio
