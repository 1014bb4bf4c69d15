// The window by GLFW: events in, pictures out.
#include "platform/window.h"

#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <variant>

#include "platform/gui.h"

namespace knead::studio {

// --- keys
// -------------------------------------------------------------------------------------------------------------

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

// Returns the name that keys.h has for a GLFW_KEY_... and its scancode; empty for a key without a name there. A letter
// is the one that the layout of the keyboard gives the key, so that Ctrl+Z is on Z; all else goes by its place.
std::string key_name(int glfw_key, int scancode) {
  const char* const printed = glfw_key == GLFW_KEY_UNKNOWN ? nullptr : glfwGetKeyName(glfw_key, scancode);
  if (printed != nullptr && printed[0] >= 'a' && printed[0] <= 'z' && printed[1] == 0) {
    return {static_cast<char>(printed[0] - 'a' + 'A')};
  }
  const auto* const found =
      std::find_if(kKeys.begin(), kKeys.end(), [&](const NamedKey& named) { return named.key == glfw_key; });
  return found == kKeys.end() ? std::string() : std::string(found->name);
}

}  // namespace

// --- the window
// -------------------------------------------------------------------------------------------------------

// What the callbacks of GLFW fill.
struct WindowState {
  std::vector<Event> events;
  // What was typed and Dear ImGui has not been told yet: for each the arguments of GLFW's call.
  struct Call {
    int key = 0;  // or the character
    int scancode = 0;
    int action = 0;
    int mods = 0;
  };
  std::vector<Typed> typed;
  std::vector<Call> calls;
  double x = 0;  // of the pointer, in pixels of the picture
  double y = 0;
  Pen pen;
  double pressed_at = -1;  // when the left button was pressed last, in seconds; -1: the next press is not a second one
  double pressed_x = 0;
  double pressed_y = 0;
  std::array<int, 4> place_before_full_screen{};
  WindowPlace restored;        // when it was opened
  double scale_when_made = 1;  // its size in the system's units beside what was asked for: GLFW follows the display
};

namespace {

[[noreturn]] void fail() {
  const char* reason = nullptr;
  glfwGetError(&reason);
  throw std::runtime_error(std::string("cannot open a window (") + (reason == nullptr ? "GLFW" : reason) +
                           "); is there a display?");
}

GLFWwindow* try_to_open(const std::string& title, int width, int height, int major, int minor) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "knead-studio");
  return glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
}

Modifiers modifiers_of(int mods) {
  return {(mods & GLFW_MOD_SHIFT) != 0, (mods & GLFW_MOD_CONTROL) != 0, (mods & GLFW_MOD_ALT) != 0};
}

// Those held now: GLFW tells them with buttons and keys only.
Modifiers held_modifiers(GLFWwindow* window) {
  const auto down = [&](int left, int right) {
    return glfwGetKey(window, left) == GLFW_PRESS || glfwGetKey(window, right) == GLFW_PRESS;
  };
  return {down(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT), down(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL),
          down(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT)};
}

// Pixels of the picture for one unit of the window's coordinates.
double pixels_per_unit(GLFWwindow* window) {
  int units = 1;
  int pixels = 1;
  int ignored = 0;
  glfwGetWindowSize(window, &units, &ignored);
  glfwGetFramebufferSize(window, &pixels, &ignored);
  return units > 0 ? static_cast<double>(pixels) / units : 1;
}

// A window that the system made larger than the screen is made to fit it.
void fit_screen(GLFWwindow* window) {
  GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
  if (monitor == nullptr) return;
  int x = 0;
  int y = 0;
  int most_width = 0;
  int most_height = 0;
  int width = 0;
  int height = 0;
  glfwGetMonitorWorkarea(monitor, &x, &y, &most_width, &most_height);
  glfwGetWindowSize(window, &width, &height);
  if (most_width <= 0 || most_height <= 0 || (width <= most_width && height <= most_height)) return;
  glfwSetWindowSize(window, std::min(width, most_width), std::min(height, most_height));
}

WindowState& state_of(GLFWwindow* window) { return *static_cast<WindowState*>(glfwGetWindowUserPointer(window)); }

void on_pointer(GLFWwindow* window, double x, double y) {
  WindowState& state = state_of(window);
  const double scale = pixels_per_unit(window);
  state.x = x * scale;
  state.y = y * scale;
  const PointerMoved moved{state.x, state.y, state.pen.pressure(), held_modifiers(window)};
  if (!state.events.empty() && std::holds_alternative<PointerMoved>(state.events.back())) {
    state.events.back() = moved;
  } else {
    state.events.emplace_back(moved);
  }
}

constexpr double kDoubleClick = 0.4;      // seconds
constexpr double kDoubleClickPixels = 6;  // between its places

// Notes a press of the left button. Returns whether it is the second one of a double click.
bool note_press(WindowState& state) {
  const double now = glfwGetTime();
  const bool is_double = state.pressed_at >= 0 && now - state.pressed_at < kDoubleClick &&
                         std::hypot(state.x - state.pressed_x, state.y - state.pressed_y) < kDoubleClickPixels;
  state.pressed_at = is_double ? -1 : now;
  state.pressed_x = state.x;
  state.pressed_y = state.y;
  return is_double;
}

void on_button(GLFWwindow* window, int button, int action, int mods) {
  if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
  WindowState& state = state_of(window);
  constexpr std::array<MouseButton, 3> buttons{MouseButton::left, MouseButton::right, MouseButton::middle};
  const bool is_double = button == GLFW_MOUSE_BUTTON_LEFT && action == GLFW_PRESS && note_press(state);
  state.events.emplace_back(ButtonChanged{buttons[static_cast<std::size_t>(button)], action == GLFW_PRESS, state.x,
                                          state.y, modifiers_of(mods), is_double});
}

void on_wheel(GLFWwindow* window, double x, double y) {
  ImGui_ImplGlfw_ScrollCallback(window, x, y);
  const Modifiers held = held_modifiers(window);
  state_of(window).events.emplace_back(WheelTurned{y == 0 && held.shift ? x : y, held});  // some turn it so themselves
}

void on_key(GLFWwindow* window, int key, int scancode, int action, int mods) {
  WindowState& state = state_of(window);
  state.typed.push_back({action == GLFW_RELEASE ? Typed::What::up : Typed::What::down, key,
                         key == GLFW_KEY_LEFT_SHIFT || key == GLFW_KEY_RIGHT_SHIFT});
  state.calls.push_back({key, scancode, action, mods});
  const std::string name = key_name(key, scancode);
  if (name.empty()) return;
  state.events.emplace_back(KeyChanged{name, action != GLFW_RELEASE, modifiers_of(mods)});
}

void on_text(GLFWwindow* window, unsigned character) {
  WindowState& state = state_of(window);
  state.typed.push_back({});
  state.calls.push_back({static_cast<int>(character)});
}

// Tells Dear ImGui what was typed, as much as one frame may have.
void tell_typed(GLFWwindow* window) {
  WindowState& state = state_of(window);
  const std::size_t count = typed_in_a_frame(state.typed);
  for (std::size_t i = 0; i < count; ++i) {
    const WindowState::Call& call = state.calls[i];
    if (state.typed[i].what == Typed::What::text) {
      ImGui_ImplGlfw_CharCallback(window, static_cast<unsigned>(call.key));
    } else {
      ImGui_ImplGlfw_KeyCallback(window, call.key, call.scancode, call.action, call.mods);
    }
  }
  state.typed.erase(state.typed.begin(), state.typed.begin() + static_cast<std::ptrdiff_t>(count));
  state.calls.erase(state.calls.begin(), state.calls.begin() + static_cast<std::ptrdiff_t>(count));
}

void on_size(GLFWwindow* window, int width, int height) {
  state_of(window).events.emplace_back(Resized{width, height});
}

void on_drop(GLFWwindow* window, int count, const char** paths) {
  FilesDropped dropped;
  for (int i = 0; i < count; ++i) dropped.files.emplace_back(paths[i]);
  state_of(window).events.emplace_back(std::move(dropped));
}

void listen(GLFWwindow* window) {
  glfwSetCursorPosCallback(window, on_pointer);
  glfwSetMouseButtonCallback(window, on_button);
  glfwSetScrollCallback(window, on_wheel);
  glfwSetKeyCallback(window, on_key);
  glfwSetCharCallback(window, on_text);
  glfwSetWindowFocusCallback(window, ImGui_ImplGlfw_WindowFocusCallback);
  glfwSetCursorEnterCallback(window, ImGui_ImplGlfw_CursorEnterCallback);
  glfwSetFramebufferSizeCallback(window, on_size);
  glfwSetDropCallback(window, on_drop);
}

}  // namespace

Window::Window(const std::string& title, const WindowPlace& place) : state_(std::make_unique<WindowState>()) {
  if (glfwInit() != GLFW_TRUE) fail();
  window_ = try_to_open(title, place.width, place.height, 4, 3);
  if (window_ == nullptr) window_ = try_to_open(title, place.width, place.height, 3, 3);
  if (window_ == nullptr) {
    glfwTerminate();
    throw std::runtime_error("cannot open a window with OpenGL 3.3; check the display and its driver");
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowSizeLimits(window_, 480, 320, GLFW_DONT_CARE, GLFW_DONT_CARE);
  state_->restored = place;
  int made_width = 0;
  glfwGetWindowSize(window_, &made_width, nullptr);
  if (made_width > 0) state_->scale_when_made = static_cast<double>(made_width) / place.width;
  if (place.maximized) {
    glfwMaximizeWindow(window_);
  } else {
    fit_screen(window_);
  }
  glfwSetWindowUserPointer(window_, state_.get());

  listen(window_);
  state_->events.emplace_back(Resized{this->width(), this->height()});
}

Window::~Window() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

std::vector<Event> Window::events(double wait_seconds) {
  if (wait_seconds > 0 && state_->typed.empty() && state_->events.empty()) {
    glfwWaitEventsTimeout(wait_seconds);
  } else {
    glfwPollEvents();
  }
  std::vector<Event> frame = take_frame(state_->events);
  if (state_->events.empty()) tell_typed(window_);  // else what is typed may be for what will be clicked
  return frame;
}

bool Window::is_closing() const { return glfwWindowShouldClose(window_) == GLFW_TRUE; }

void Window::set_closing(bool closing) { glfwSetWindowShouldClose(window_, closing ? GLFW_TRUE : GLFW_FALSE); }

void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

void Window::toggle_full_screen() {
  auto& [x, y, w, h] = state_->place_before_full_screen;
  if (glfwGetWindowMonitor(window_) != nullptr) {
    glfwSetWindowMonitor(window_, nullptr, x, y, w, h, 0);
    return;
  }
  GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* const mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
  if (mode == nullptr) return;
  glfwGetWindowPos(window_, &x, &y);
  glfwGetWindowSize(window_, &w, &h);
  glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

WindowPlace Window::place() const {
  WindowPlace place = state_->restored;
  place.maximized = glfwGetWindowAttrib(window_, GLFW_MAXIMIZED) == GLFW_TRUE;
  if (place.maximized) return place;
  int width = state_->place_before_full_screen[2];
  int height = state_->place_before_full_screen[3];
  if (glfwGetWindowMonitor(window_) == nullptr) glfwGetWindowSize(window_, &width, &height);
  if (width <= 0 || height <= 0) return place;
  place.width = static_cast<int>(std::lround(width / state_->scale_when_made));
  place.height = static_cast<int>(std::lround(height / state_->scale_when_made));
  return place;
}

int Window::width() const {
  int width = 0;
  glfwGetFramebufferSize(window_, &width, nullptr);
  return width;
}

int Window::height() const {
  int height = 0;
  glfwGetFramebufferSize(window_, nullptr, &height);
  return height;
}

double Window::scale() const {
  float x = 1;
  float y = 1;
  glfwGetWindowContentScale(window_, &x, &y);
  return std::clamp<double>(std::max(x, y), 0.5, 4);
}

bool Window::has_touch() const { return false; }

void Window::show() { glfwSwapBuffers(window_); }

// --- Dear ImGui
// -------------------------------------------------------------------------------------------------------

GuiBackend::GuiBackend(Window& window) {
  ImGui_ImplGlfw_InitForOpenGL(window.handle(), false);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

GuiBackend::~GuiBackend() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
}

// GLFW knows the window.
void GuiBackend::begin_frame(const Window&) {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
}

void GuiBackend::draw() { ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData()); }

}  // namespace knead::studio
