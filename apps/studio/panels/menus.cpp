// The bar of menus.
#include <imgui.h>

#include <array>

#include "panels/dialogs.h"
#include "panels/panels.h"

namespace knead::studio {

namespace {

void item(Studio& studio, Action action, bool chosen = false, bool enabled = true) {
  const std::string title(title_of(action));
  const KeyMap& keys = studio.preferences().keys;
  const std::string key = keys.of(action).empty() ? "" : text_of(keys.of(action).front());
  if (ImGui::MenuItem(title.c_str(), key.c_str(), chosen, enabled)) studio.perform(action);
}

void draw_recent(Studio& studio, Dialogs& dialogs) {
  if (!ImGui::BeginMenu("Recent", !studio.recent().empty())) return;
  for (const std::filesystem::path& path : studio.recent()) {
    if (ImGui::MenuItem(path.c_str())) do_or_ask(studio, dialogs, [&studio, path] { studio.open(path); });
  }
  ImGui::EndMenu();
}

void draw_file_menu(Studio& studio, Dialogs& dialogs) {
  const bool open = studio.shown().opened != 0;
  item(studio, Action::new_shape);
  item(studio, Action::open);
  draw_recent(studio, dialogs);
  item(studio, Action::recover, false, !studio.abandoned().empty());
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
  Navigation& navigation = studio.navigation();
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
  const ViewSettings& view = studio.view();
  for (const Action side : {Action::frame_all, Action::view_front, Action::view_back, Action::view_right,
                            Action::view_left, Action::view_top, Action::view_bottom}) {
    item(studio, side);
  }
  item(studio, Action::frame_stroke);
  item(studio, Action::projection, studio.navigation().view.projection == render::Projection::perspective);
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
  item(studio, Action::undo, false, !studio.shown().history.empty() || studio.gesture().has_value());
  item(studio, Action::redo, false, !studio.shown().redoable.empty());
  ImGui::Separator();
  for (const Action action : {Action::mirror_x, Action::mirror_y, Action::mirror_z}) {
    item(studio, action,
         studio.settings().mirror[static_cast<std::size_t>(action) - static_cast<std::size_t>(Action::mirror_x)]);
  }
  item(studio, Action::remesh, studio.settings().remesh);
  item(studio, Action::remesh_last, false, !studio.shown().history.empty());
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
    item(studio, Action::help, studio.view().help);
  });
  ImGui::EndMainMenuBar();
  return is_open;
}

}  // namespace knead::studio
