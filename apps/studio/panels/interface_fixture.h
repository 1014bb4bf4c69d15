// Drives the panels by events, as a window does, but without one: Dear ImGui lays everything out and draws nothing.
#pragma once

#include <imgui.h>
#include <imgui_internal.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "panels/interface.h"
#include "platform/imgui_keys.h"
#include "studio_fixture.h"

namespace knead::studio {

// A Studio with its panels in a window of a size that nobody sees.
class ShownPanels {
 public:
  ShownPanels(const StudioOptions& options, int width, int height, double unit = 1)
      : studio(options), gui(unit), interface(studio, gui, {}) {
    studio.preferences().desktop_dialogs = false;
    ImGuiIO& io = ImGui::GetIO();
    io.DeltaTime = 1.0F / 60;
#if IMGUI_VERSION_NUM >= 19200
    io.BackendFlags |= ImGuiBackendFlags_RendererHasTextures;  // letters are added when they are first used
#endif
    for (const auto& [name, key] : kKeys) number_key(key);
    interface.set_size(width, height);
    show(width, height);
    frame();
  }

  // One picture, after events that happened before it.
  void frame(const std::vector<Event>& events = {}) {
    for (const Event& event : events) tell_imgui(event);
    gui.begin_frame(events);
    interface.handle(events);
    studio.refresh();
    interface.draw({}, {});
    gui.end_frame();
  }

  void resize(int width, int height) {
    show(width, height);
    frame({Resized{width, height}});
  }

  void move(double x, double y) { frame({PointerMoved{x, y}}); }
  void press(double x, double y) { frame({ButtonChanged{MouseButton::left, true, x, y}}); }
  void right_click(double x, double y) {
    move(x, y);
    frame({ButtonChanged{MouseButton::right, true, x, y}});
    frame({ButtonChanged{MouseButton::right, false, x, y}});
    frame();
  }
  void release(double x, double y) { frame({ButtonChanged{MouseButton::left, false, x, y}}); }

  void click(double x, double y) {
    move(x, y);
    press(x, y);
    release(x, y);
    frame();
  }

  void drag(double x0, double y0, double x1, double y1) {
    move(x0, y0);
    press(x0, y0);
    for (int i = 1; i <= 4; ++i) move(x0 + (x1 - x0) * i / 4, y0 + (y1 - y0) * i / 4);
    release(x1, y1);
    frame();
  }

  void wheel(double steps) { frame({WheelTurned{steps}}); }

  void key(const std::string& text) {
    const Chord chord = chord_of(text).value();
    frame({KeyChanged{chord.key, true, chord.modifiers}});
    frame({KeyChanged{chord.key, false, chord.modifiers}});
  }

  void type(const std::string& text) {
    ImGui::GetIO().AddInputCharactersUTF8(text.c_str());
    frame();
  }

  static bool is_list_open() { return ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup); }

  // The rectangle of a panel, as Dear ImGui laid it out.
  static Area area_of(const char* panel) {
    const ImGuiWindow* const window = ImGui::FindWindowByName(panel);
    if (window == nullptr || !window->WasActive) return {};
    return {window->Pos.x, window->Pos.y, window->Pos.x + window->Size.x, window->Pos.y + window->Size.y};
  }

  // Where the pointer finds an item within an area.
  std::optional<std::pair<double, double>> place_in(const Area& area, ImGuiID item) {
    const double step = 6 * gui.unit();
    for (double y = area.top + 0.5 * step; y < area.bottom; y += step) {
      for (double x = area.left + 0.5 * step; x < area.right; x += step) {
        move(x, y);
        if (ImGui::GetCurrentContext()->HoveredId == item) return std::pair{x, y};
      }
    }
    return std::nullopt;
  }

  // The same in the side panel, where items are wide.
  std::optional<std::pair<double, double>> place_of(ImGuiID item) {
    const Area& panel = interface.layout().side_panel;
    const float x = panel.left + 0.3F * panel.width();
    return place_in({x, panel.top, x + 6 * gui.unit(), panel.bottom}, item);
  }

  // Clicks on an item of a window. Returns whether it is there.
  bool click_item(ImGuiWindow* window, const char* label) {
    if (window == nullptr) return false;
    const Area area{window->Pos.x, window->Pos.y, window->Pos.x + window->Size.x, window->Pos.y + window->Size.y};
    const auto place = place_in(area, window->GetID(label));
    if (place) click(place->first, place->second);
    return place.has_value();
  }
  bool click_item(const char* window, const char* label) { return click_item(ImGui::FindWindowByName(window), label); }

  // The list, menu or dialog that is open above all others; null if there is none.
  static ImGuiWindow* popup() {
    const auto& stack = ImGui::GetCurrentContext()->OpenPopupStack;
    return stack.empty() ? nullptr : stack.back().Window;
  }

  // Opens a list of the side panel. Returns whether it is open.
  bool open_a_list() {
    const auto place = place_of(ImGui::FindWindowByName("Settings")->GetID("##Shading"));
    if (place) click(place->first, place->second);
    return is_list_open();
  }

  Studio studio;
  Gui gui;
  Interface interface;

 private:
  static constexpr std::array<std::pair<const char*, ImGuiKey>, 8> kKeys{{{"Escape", ImGuiKey_Escape},
                                                                          {"Enter", ImGuiKey_Enter},
                                                                          {"Up", ImGuiKey_UpArrow},
                                                                          {"Down", ImGuiKey_DownArrow},
                                                                          {"Backspace", ImGuiKey_Backspace},
                                                                          {"Tab", ImGuiKey_Tab},
                                                                          {"Numpad Enter", kNumpadEnter},
                                                                          {"A", ImGuiKey_A}}};

  static void show(int width, int height) {
    ImGui::GetIO().DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
  }

  static void tell_imgui(const Event& event) {
    ImGuiIO& io = ImGui::GetIO();
    if (const auto* wheel = std::get_if<WheelTurned>(&event)) {
      io.MouseWheel += static_cast<float>(wheel->steps);
    } else if (const auto* key = std::get_if<KeyChanged>(&event)) {
      set_modifiers(key->modifiers);
      for (const auto& [name, imgui_key] : kKeys) {
        if (key->key == name) set_key(imgui_key, key->down);
      }
    }
  }
};

}  // namespace knead::studio
