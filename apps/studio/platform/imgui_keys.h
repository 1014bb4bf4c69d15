// Keys as the installed Dear ImGui has them: since 1.87 a change of a key is an event; before, a program numbered its
// keys.
#pragma once

#include <imgui.h>

#include "platform/window.h"

namespace knead::studio {

#if IMGUI_VERSION_NUM >= 18900

inline constexpr ImGuiKey kNumpadEnter = ImGuiKey_KeypadEnter;

inline bool is_pressed(ImGuiKey key, bool repeats = true) { return ImGui::IsKeyPressed(key, repeats); }

// Makes a key known. For backends that are not Dear ImGui's own, once.
inline void number_key(ImGuiKey) {}

inline void set_key(ImGuiKey key, bool down) { ImGui::GetIO().AddKeyEvent(key, down); }

inline void set_modifiers(const Modifiers& modifiers) {
  set_key(ImGuiMod_Shift, modifiers.shift);
  set_key(ImGuiMod_Ctrl, modifiers.ctrl);
  set_key(ImGuiMod_Alt, modifiers.alt);
}

#else

inline constexpr ImGuiKey kNumpadEnter = ImGuiKey_KeyPadEnter;

inline bool is_pressed(ImGuiKey key, bool repeats = true) {
  return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), repeats);
}

inline void number_key(ImGuiKey key) { ImGui::GetIO().KeyMap[key] = key; }

inline void set_key(ImGuiKey key, bool down) { ImGui::GetIO().KeysDown[key] = down; }

inline void set_modifiers(const Modifiers& modifiers) {
  ImGuiIO& io = ImGui::GetIO();
  io.KeyShift = modifiers.shift;
  io.KeyCtrl = modifiers.ctrl;
  io.KeyAlt = modifiers.alt;
}

#endif

}  // namespace knead::studio
