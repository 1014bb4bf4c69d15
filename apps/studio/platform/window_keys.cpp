#include "platform/window_keys.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace knead::studio {

namespace {

struct NamedKey {
  int key;
  std::string_view name;
};

constexpr std::array<NamedKey, 98> kKeys{{
    {GLFW_KEY_A, "A"},
    {GLFW_KEY_B, "B"},
    {GLFW_KEY_C, "C"},
    {GLFW_KEY_D, "D"},
    {GLFW_KEY_E, "E"},
    {GLFW_KEY_F, "F"},
    {GLFW_KEY_G, "G"},
    {GLFW_KEY_H, "H"},
    {GLFW_KEY_I, "I"},
    {GLFW_KEY_J, "J"},
    {GLFW_KEY_K, "K"},
    {GLFW_KEY_L, "L"},
    {GLFW_KEY_M, "M"},
    {GLFW_KEY_N, "N"},
    {GLFW_KEY_O, "O"},
    {GLFW_KEY_P, "P"},
    {GLFW_KEY_Q, "Q"},
    {GLFW_KEY_R, "R"},
    {GLFW_KEY_S, "S"},
    {GLFW_KEY_T, "T"},
    {GLFW_KEY_U, "U"},
    {GLFW_KEY_V, "V"},
    {GLFW_KEY_W, "W"},
    {GLFW_KEY_X, "X"},
    {GLFW_KEY_Y, "Y"},
    {GLFW_KEY_Z, "Z"},
    {GLFW_KEY_0, "0"},
    {GLFW_KEY_1, "1"},
    {GLFW_KEY_2, "2"},
    {GLFW_KEY_3, "3"},
    {GLFW_KEY_4, "4"},
    {GLFW_KEY_5, "5"},
    {GLFW_KEY_6, "6"},
    {GLFW_KEY_7, "7"},
    {GLFW_KEY_8, "8"},
    {GLFW_KEY_9, "9"},
    {GLFW_KEY_F1, "F1"},
    {GLFW_KEY_F2, "F2"},
    {GLFW_KEY_F3, "F3"},
    {GLFW_KEY_F4, "F4"},
    {GLFW_KEY_F5, "F5"},
    {GLFW_KEY_F6, "F6"},
    {GLFW_KEY_F7, "F7"},
    {GLFW_KEY_F8, "F8"},
    {GLFW_KEY_F9, "F9"},
    {GLFW_KEY_F10, "F10"},
    {GLFW_KEY_F11, "F11"},
    {GLFW_KEY_F12, "F12"},
    {GLFW_KEY_LEFT_BRACKET, "["},
    {GLFW_KEY_RIGHT_BRACKET, "]"},
    {GLFW_KEY_COMMA, ","},
    {GLFW_KEY_PERIOD, "."},
    {GLFW_KEY_SLASH, "/"},
    {GLFW_KEY_SEMICOLON, ";"},
    {GLFW_KEY_APOSTROPHE, "'"},
    {GLFW_KEY_GRAVE_ACCENT, "`"},
    {GLFW_KEY_MINUS, "-"},
    {GLFW_KEY_EQUAL, "="},
    {GLFW_KEY_BACKSLASH, "\\"},
    {GLFW_KEY_SPACE, "Space"},
    {GLFW_KEY_ESCAPE, "Escape"},
    {GLFW_KEY_ENTER, "Enter"},
    {GLFW_KEY_TAB, "Tab"},
    {GLFW_KEY_BACKSPACE, "Backspace"},
    {GLFW_KEY_INSERT, "Insert"},
    {GLFW_KEY_DELETE, "Delete"},
    {GLFW_KEY_RIGHT, "Right"},
    {GLFW_KEY_LEFT, "Left"},
    {GLFW_KEY_DOWN, "Down"},
    {GLFW_KEY_UP, "Up"},
    {GLFW_KEY_PAGE_UP, "Page Up"},
    {GLFW_KEY_PAGE_DOWN, "Page Down"},
    {GLFW_KEY_HOME, "Home"},
    {GLFW_KEY_END, "End"},
    {GLFW_KEY_PAUSE, "Pause"},
    {GLFW_KEY_KP_0, "Numpad 0"},
    {GLFW_KEY_KP_1, "Numpad 1"},
    {GLFW_KEY_KP_2, "Numpad 2"},
    {GLFW_KEY_KP_3, "Numpad 3"},
    {GLFW_KEY_KP_4, "Numpad 4"},
    {GLFW_KEY_KP_5, "Numpad 5"},
    {GLFW_KEY_KP_6, "Numpad 6"},
    {GLFW_KEY_KP_7, "Numpad 7"},
    {GLFW_KEY_KP_8, "Numpad 8"},
    {GLFW_KEY_KP_9, "Numpad 9"},
    {GLFW_KEY_KP_DECIMAL, "Numpad ."},
    {GLFW_KEY_KP_DIVIDE, "Numpad /"},
    {GLFW_KEY_KP_MULTIPLY, "Numpad *"},
    {GLFW_KEY_KP_SUBTRACT, "Numpad -"},
    {GLFW_KEY_KP_ADD, "Numpad +"},
    {GLFW_KEY_KP_ENTER, "Numpad Enter"},
    {GLFW_KEY_LEFT_SHIFT, "Shift"},
    {GLFW_KEY_LEFT_CONTROL, "Ctrl"},
    {GLFW_KEY_LEFT_ALT, "Alt"},
    {GLFW_KEY_RIGHT_SHIFT, "Shift"},
    {GLFW_KEY_RIGHT_CONTROL, "Ctrl"},
    {GLFW_KEY_RIGHT_ALT, "Alt"},
    {GLFW_KEY_MENU, "Menu"},
}};

}  // namespace

std::string key_name(int glfw_key, int scancode) {
  const char* const printed = glfw_key == GLFW_KEY_UNKNOWN ? nullptr : glfwGetKeyName(glfw_key, scancode);
  if (printed != nullptr && printed[0] >= 'a' && printed[0] <= 'z' && printed[1] == 0) {
    return {static_cast<char>(printed[0] - 'a' + 'A')};
  }
  const auto* const found =
      std::find_if(kKeys.begin(), kKeys.end(), [&](const NamedKey& named) { return named.key == glfw_key; });
  return found == kKeys.end() ? std::string() : std::string(found->name);
}

}  // namespace knead::studio
