// The window of a page: a canvas with WebGL 2. The page's script sends what a person does.
#include "platform/window.h"

#include <emscripten.h>
#include <emscripten/html5.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <variant>

#include "platform/brought_files.h"
#include "platform/web/input.h"

// The page's side (web/page/studio.js).
EM_JS(void, page_set_title, (const char* title), { Module.page.setTitle(UTF8ToString(title)); });
EM_JS(void, page_toggle_full_screen, (), { Module.page.toggleFullScreen(); });
EM_JS(void, page_choose_files, (), { Module.page.chooseFiles(); });

namespace knead::studio {

struct WindowState {
  std::vector<Event> events;
  int width = 1;
  int height = 1;
  double scale = 1;
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

PageInput& page_input() { return the_state().input; }

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

std::vector<Event> Window::events(double) { return std::exchange(the_state().events, {}); }

bool Window::is_closing() const { return the_state().is_closing; }

void Window::set_closing(bool closing) { the_state().is_closing = closing; }

void Window::set_title(const std::string& title) { page_set_title(title.c_str()); }

void Window::toggle_full_screen() { page_toggle_full_screen(); }

WindowPlace Window::place() const { return {}; }

int Window::width() const { return the_state().width; }

int Window::height() const { return the_state().height; }

double Window::scale() const { return std::clamp(the_state().scale, 0.5, 4.0); }

// The browser shows what was drawn when the step ends.
void Window::show() {}

}  // namespace knead::studio

using namespace knead::studio;

// NOLINTBEGIN(bugprone-easily-swappable-parameters): the page passes numbers
extern "C" {

// Places are pixels of the picture; modifiers: shift 1, ctrl 2, alt 4; buttons as MouseButton.
EMSCRIPTEN_KEEPALIVE void studio_resize(int width, int height, double scale) {
  WindowState& state = the_state();
  if (state.width == width && state.height == height) return;
  state.width = width;
  state.height = height;
  state.scale = scale;
  state.events.emplace_back(Resized{width, height});
}

EMSCRIPTEN_KEEPALIVE void studio_pointer(double x, double y, double pressure, int modifiers) {
  WindowState& state = the_state();
  state.input.x = x;
  state.input.y = y;
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
  constexpr std::array<std::size_t, 3> gui_button{0, 2, 1};  // Dear ImGui counts the right one before the middle one
  const std::size_t index = gui_button[static_cast<std::size_t>(button)];
  state.input.held[index] = down != 0;
  if (down != 0) state.input.pressed[index] = true;
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
  state.input.keys.push_back({name, down != 0});
  state.events.emplace_back(KeyChanged{name, down != 0, modifiers_of(modifiers)});
}

EMSCRIPTEN_KEEPALIVE void studio_text(unsigned code_point) { the_state().input.text.push_back(code_point); }

// Paths, a line each.
EMSCRIPTEN_KEEPALIVE void studio_drop(const char* paths) {
  FilesDropped dropped;
  std::istringstream lines(paths);
  for (std::string line; std::getline(lines, line);) dropped.files.emplace_back(line);
  the_state().events.emplace_back(std::move(dropped));
}

}  // extern "C"
// NOLINTEND(bugprone-easily-swappable-parameters)
