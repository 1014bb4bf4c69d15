// Studio on a page: its window is a canvas with WebGL 2. The page's script sends what a person does. It calls main()
// once its stored files are there, and shows what goes wrong.
#include "platform/window.h"

#include <emscripten.h>
#include <emscripten/html5.h>
#include <imgui.h>
#include <imgui_impl_opengl3.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <chrono>
#include <deque>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "application.h"
#include "platform/gui.h"
#include "platform/imgui_keys.h"

// The page's side (bindings/web/page/studio.js).
EM_JS(void, page_set_title, (const char* title), { Module.page.setTitle(UTF8ToString(title)); });
EM_JS(void, page_toggle_full_screen, (), { Module.page.toggleFullScreen(); });
EM_JS(void, page_choose_files, (), { Module.page.chooseFiles(); });
EM_JS(void, page_fail, (const char* line), { Module.page.fail(UTF8ToString(line)); });
EM_JS(void, page_tell, (const char* line), { Module.page.tell(UTF8ToString(line)); });
EM_JS(void, page_end, (), { Module.page.end(); });

namespace knead::studio {

// --- the window
// -------------------------------------------------------------------------------------------------------

struct KeyInput {
  std::string key;
  bool down = false;
  Modifiers modifiers;
};

// What Dear ImGui has not been told yet.
struct PageInput {
  double wheel = 0;
  Modifiers modifiers;
  std::deque<std::variant<KeyInput, unsigned>> typed;  // keys and the code points of letters
};

struct WindowState {
  std::vector<Event> events;
  int width = 1;
  int height = 1;
  double scale = 1;
  bool has_touch = false;
  bool is_lifted = false;  // the finger that pointed last
  PageInput input;
  bool is_closing = false;
};

namespace {

WindowState& the_state() {
  static WindowState state;
  return state;
}

Modifiers modifiers_of(int bits) { return {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0}; }

}  // namespace

bool must_bring_files() { return true; }

void choose_files_to_bring() { page_choose_files(); }

Window::Window(const std::string& title, const WindowPlace&) {
  EmscriptenWebGLContextAttributes attributes;
  emscripten_webgl_init_context_attributes(&attributes);
  attributes.majorVersion = 2;
  attributes.alpha = EM_FALSE;
  attributes.depth = EM_FALSE;
  attributes.antialias = EM_FALSE;
  attributes.powerPreference = EM_WEBGL_POWER_PREFERENCE_HIGH_PERFORMANCE;
  const EMSCRIPTEN_WEBGL_CONTEXT_HANDLE context = emscripten_webgl_create_context("#canvas", &attributes);
  if (context <= 0) {
    throw std::runtime_error("this browser has no WebGL 2; use a newer one, or turn on its hardware acceleration");
  }
  emscripten_webgl_make_context_current(context);
  set_title(title);
  the_state().events.emplace_back(Resized{width(), height()});
}

Window::~Window() = default;

std::vector<Event> Window::events(double) { return take_frame(the_state().events); }

bool Window::is_closing() const { return the_state().is_closing; }

void Window::set_closing(bool closing) { the_state().is_closing = closing; }

void Window::set_title(const std::string& title) { page_set_title(title.c_str()); }

void Window::toggle_full_screen() { page_toggle_full_screen(); }

WindowPlace Window::place() const { return {}; }

int Window::width() const { return the_state().width; }

int Window::height() const { return the_state().height; }

double Window::scale() const { return std::clamp(the_state().scale, 0.5, 4.0); }

bool Window::has_touch() const { return the_state().has_touch; }

// The browser shows what was drawn when the step ends.
void Window::show() {}

// --- Dear ImGui
// -------------------------------------------------------------------------------------------------------

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
                                          {"Numpad Enter", kNumpadEnter},
                                          {"A", ImGuiKey_A},
                                          {"C", ImGuiKey_C},
                                          {"V", ImGuiKey_V},
                                          {"X", ImGuiKey_X},
                                          {"Y", ImGuiKey_Y},
                                          {"Z", ImGuiKey_Z}}};

// Gives Dear ImGui what was typed, in order. It looks at letters, keys and modifiers once a picture, at letters first:
// those after a key, a key that changes twice, and keys with other modifiers wait for the next picture.
void take_typed(PageInput& input) {
  std::vector<ImGuiKey> changed;
  const auto* const first = input.typed.empty() ? nullptr : std::get_if<KeyInput>(&input.typed.front());
  const Modifiers modifiers = first != nullptr ? first->modifiers : input.modifiers;
  set_modifiers(modifiers);
  while (!input.typed.empty()) {
    if (const auto* letter = std::get_if<unsigned>(&input.typed.front())) {
      if (!changed.empty()) return;
      ImGui::GetIO().AddInputCharacter(*letter);
    } else {
      const KeyInput& own = std::get<KeyInput>(input.typed.front());
      const auto found =
          std::find_if(kKeys.begin(), kKeys.end(), [&](const NamedKey& named) { return named.name == own.key; });
      const bool is_letter = own.down && own.key.size() == 1 && !own.modifiers.ctrl;  // the letter itself comes as well
      if (found != kKeys.end() && !is_letter) {
        const bool is_again = std::find(changed.begin(), changed.end(), found->key) != changed.end();
        if (is_again || own.modifiers != modifiers) return;
        set_key(found->key, own.down);
        changed.push_back(found->key);
      }
    }
    input.typed.pop_front();
  }
}

}  // namespace

GuiBackend::GuiBackend(Window& window) {
  ImGuiIO& io = ImGui::GetIO();
  for (const NamedKey& named : kKeys) number_key(named.key);
  io.DisplaySize = {static_cast<float>(window.width()), static_cast<float>(window.height())};
  ImGui_ImplOpenGL3_Init("#version 300 es");
}

GuiBackend::~GuiBackend() { ImGui_ImplOpenGL3_Shutdown(); }

void GuiBackend::begin_frame(const Window& window) {
  static auto last = std::chrono::steady_clock::now();
  const auto now = std::chrono::steady_clock::now();
  ImGuiIO& io = ImGui::GetIO();
  io.DeltaTime = std::clamp(std::chrono::duration<float>(now - std::exchange(last, now)).count(), 1e-4F, 0.5F);
  io.DisplaySize = {static_cast<float>(window.width()), static_cast<float>(window.height())};
  if (the_state().is_lifted && the_state().events.empty()) io.MousePos = {-FLT_MAX, -FLT_MAX};
  PageInput& input = the_state().input;
  io.MouseWheel += static_cast<float>(std::exchange(input.wheel, 0));
  if (the_state().events.empty()) {
    take_typed(input);
  } else {  // what is typed may be for what will be clicked
    set_modifiers(input.modifiers);
  }
  ImGui_ImplOpenGL3_NewFrame();
}

void GuiBackend::draw() { ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData()); }

}  // namespace knead::studio

// --- what the page calls
// ----------------------------------------------------------------------------------------------

using namespace knead::studio;

// NOLINTBEGIN(bugprone-easily-swappable-parameters): the page passes numbers
extern "C" {

// Places are pixels of the picture; modifiers: shift 1, ctrl 2, alt 4; buttons as MouseButton.
EMSCRIPTEN_KEEPALIVE void studio_resize(int width, int height, double scale, int has_touch) {
  WindowState& state = the_state();
  state.has_touch = has_touch != 0;
  if (state.width == width && state.height == height) return;
  state.width = width;
  state.height = height;
  state.scale = scale;
  state.events.emplace_back(Resized{width, height});
}

EMSCRIPTEN_KEEPALIVE void studio_pointer(double x, double y, double pressure, int modifiers) {
  WindowState& state = the_state();
  state.is_lifted = false;
  state.input.modifiers = modifiers_of(modifiers);
  const PointerMoved moved{x, y, pressure, modifiers_of(modifiers)};
  if (!state.events.empty() && std::holds_alternative<PointerMoved>(state.events.back())) {
    state.events.back() = moved;
  } else {
    state.events.emplace_back(moved);
  }
}

EMSCRIPTEN_KEEPALIVE void studio_button(int button, int down, double x, double y, int modifiers, int is_double) {
  if (button < 0 || button > 2) return;
  WindowState& state = the_state();
  state.input.modifiers = modifiers_of(modifiers);
  state.events.emplace_back(
      ButtonChanged{static_cast<MouseButton>(button), down != 0, x, y, modifiers_of(modifiers), is_double != 0});
}

EMSCRIPTEN_KEEPALIVE void studio_wheel(double steps, int modifiers) {
  WindowState& state = the_state();
  state.input.wheel += steps;
  state.events.emplace_back(WheelTurned{steps, modifiers_of(modifiers)});
}

EMSCRIPTEN_KEEPALIVE void studio_key(const char* name, int down, int modifiers) {
  WindowState& state = the_state();
  state.input.modifiers = modifiers_of(modifiers);
  state.input.typed.emplace_back(KeyInput{name, down != 0, modifiers_of(modifiers)});
  state.events.emplace_back(KeyChanged{name, down != 0, modifiers_of(modifiers)});
}

// A finger that is lifted points at nothing.
EMSCRIPTEN_KEEPALIVE void studio_lift() { the_state().is_lifted = true; }

// Returns whether a panel is there that scrolls.
EMSCRIPTEN_KEEPALIVE int studio_scroll(double x, double y, double by) { return Gui::scroll(x, y, by) ? 1 : 0; }

// Returns whether a text is edited.
EMSCRIPTEN_KEEPALIVE int studio_wants_text() { return ImGui::GetIO().WantTextInput ? 1 : 0; }

EMSCRIPTEN_KEEPALIVE void studio_text(unsigned code_point) { the_state().input.typed.emplace_back(code_point); }

// Paths, a line each.
EMSCRIPTEN_KEEPALIVE void studio_drop(const char* paths) {
  FilesDropped dropped;
  std::istringstream lines(paths);
  for (std::string line; std::getline(lines, line);) dropped.files.emplace_back(line);
  the_state().events.emplace_back(std::move(dropped));
}

}  // extern "C"
// NOLINTEND(bugprone-easily-swappable-parameters)

namespace {

std::unique_ptr<SteppedApplication>& application() {
  static std::unique_ptr<SteppedApplication> the;
  return the;
}

void fail(const char* line) {
  emscripten_cancel_main_loop();
  page_fail(line);
}

// Runs a function; what it throws ends the application with one line. The journal has all strokes.
template <class Function>
void guarded(Function function) {
  try {
    function();
  } catch (const std::bad_alloc&) {
    fail("The browser has too little memory for this shape. Your strokes are stored: reload the page to recover them.");
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

// The page repeats Studio's messages for readers of the screen.
void tell_messages() {
  static std::string told;
  const std::string message = application()->message();
  if (message == told) return;
  told = message;
  page_tell(told.c_str());
}

void step() {
  guarded([] {
    if (application()->step()) return tell_messages();
    emscripten_cancel_main_loop();
    page_end();
  });
}

}  // namespace

// Draws a picture at once.
extern "C" EMSCRIPTEN_KEEPALIVE void studio_step() { step(); }

int main() {
  guarded([] {
    std::error_code error;
    std::filesystem::create_directories("/home/web_user/files", error);
    std::filesystem::current_path("/home/web_user/files", error);
    application() = std::make_unique<SteppedApplication>(ApplicationOptions{});
    emscripten_set_main_loop(step, 0, 0);
  });
  return 0;
}
