// Dear ImGui on a page.
#include "platform/gui_backend.h"

#include <imgui.h>
#include <imgui_impl_opengl3.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string_view>
#include <vector>

#include "platform/web/input.h"

namespace knead::studio {

namespace {

struct NamedKey {
  std::string_view name;
  ImGuiKey key;
};

constexpr std::array<NamedKey, 22> kKeys{{{"Tab", ImGuiKey_Tab},
                                          {"Left", ImGuiKey_LeftArrow},
                                          {"Right", ImGuiKey_RightArrow},
                                          {"Up", ImGuiKey_UpArrow},
                                          {"Down", ImGuiKey_DownArrow},
                                          {"Page Up", ImGuiKey_PageUp},
                                          {"Page Down", ImGuiKey_PageDown},
                                          {"Home", ImGuiKey_Home},
                                          {"End", ImGuiKey_End},
                                          {"Insert", ImGuiKey_Insert},
                                          {"Delete", ImGuiKey_Delete},
                                          {"Backspace", ImGuiKey_Backspace},
                                          {"Space", ImGuiKey_Space},
                                          {"Enter", ImGuiKey_Enter},
                                          {"Escape", ImGuiKey_Escape},
                                          {"Numpad Enter", ImGuiKey_KeyPadEnter},
                                          {"A", ImGuiKey_A},
                                          {"C", ImGuiKey_C},
                                          {"V", ImGuiKey_V},
                                          {"X", ImGuiKey_X},
                                          {"Y", ImGuiKey_Y},
                                          {"Z", ImGuiKey_Z}}};

// Dear ImGui looks at the keys once a picture: of one that changes twice it gets the second change in the next.
void take_keys(ImGuiIO& io, PageInput& input) {
  std::vector<std::size_t> changed;
  while (!input.keys.empty()) {
    const auto found = std::find_if(kKeys.begin(), kKeys.end(),
                                    [&](const NamedKey& named) { return named.name == input.keys.front().key; });
    if (found != kKeys.end()) {
      const auto index = static_cast<std::size_t>(found - kKeys.begin());
      if (std::find(changed.begin(), changed.end(), index) != changed.end()) return;
      io.KeysDown[index] = input.keys.front().down;
      changed.push_back(index);
    }
    input.keys.pop_front();
  }
}

}  // namespace

GuiBackend::GuiBackend(Window& window) {
  ImGuiIO& io = ImGui::GetIO();
  for (std::size_t i = 0; i < kKeys.size(); ++i) io.KeyMap[kKeys[i].key] = static_cast<int>(i);
  io.DisplaySize = {static_cast<float>(window.width()), static_cast<float>(window.height())};
  ImGui_ImplOpenGL3_Init("#version 300 es");
}

GuiBackend::~GuiBackend() { ImGui_ImplOpenGL3_Shutdown(); }

void GuiBackend::begin_frame(const Window& window) {
  using Clock = std::chrono::steady_clock;
  static Clock::time_point last = Clock::now();
  const Clock::time_point now = Clock::now();
  ImGuiIO& io = ImGui::GetIO();
  io.DeltaTime = std::clamp(std::chrono::duration<float>(now - std::exchange(last, now)).count(), 1e-4F, 0.5F);
  io.DisplaySize = {static_cast<float>(window.width()), static_cast<float>(window.height())};
  PageInput& input = page_input();
  io.MousePos = {static_cast<float>(input.x), static_cast<float>(input.y)};
  for (std::size_t i = 0; i < input.held.size(); ++i) io.MouseDown[i] = input.held[i] || input.pressed[i];
  input.pressed = {};
  io.MouseWheel += static_cast<float>(std::exchange(input.wheel, 0));
  io.KeyShift = input.modifiers.shift;
  io.KeyCtrl = input.modifiers.ctrl;
  io.KeyAlt = input.modifiers.alt;
  take_keys(io, input);
  for (const unsigned code : std::exchange(input.text, {})) io.AddInputCharacter(code);
  ImGui_ImplOpenGL3_NewFrame();
}

void GuiBackend::draw() { ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData()); }

}  // namespace knead::studio
