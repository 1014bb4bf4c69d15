// Dear ImGui: fonts, colours, and events.
#include "platform/gui.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <utility>
#include <variant>

#include "knead/editor/render.h"

namespace knead::studio {

namespace {

constexpr float kTextHeight = 15;
constexpr float kHeadingHeight = 20;

// Where systems keep a font that is easy to read.
constexpr std::array<const char*, 6> kFonts{"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                            "/usr/share/fonts/TTF/DejaVuSans.ttf",
                                            "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
                                            "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
                                            "/usr/share/fonts/truetype/freefont/FreeSans.ttf",
                                            "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf"};

#if defined(KNEAD_FONT)
// A font in the program itself.
constexpr unsigned char kFont[] = {
#embed KNEAD_FONT
};
#else
constexpr std::array<unsigned char, 0> kFont{};
#endif

void load_font(float height) {
  ImFontConfig config;
  config.OversampleH = 2;
  config.SizePixels = std::round(height);
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  // Latin, punctuation (dashes, quotes), arrows and the signs of mathematics.
  static constexpr std::array<ImWchar, 9> ranges{0x20, 0x24F, 0x2010, 0x205E, 0x2190, 0x21FF, 0x2200, 0x22FF, 0};
  if (std::size(kFont) > 0) {
    config.FontDataOwnedByAtlas = false;  // then nothing writes to it
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
    fonts.AddFontFromMemoryTTF(const_cast<unsigned char*>(std::data(kFont)), static_cast<int>(std::size(kFont)),
                               config.SizePixels, &config, ranges.data());
    return;
  }
  for (const char* file : kFonts) {
    std::error_code error;
    if (std::filesystem::exists(file, error) &&
        fonts.AddFontFromFileTTF(file, config.SizePixels, &config, ranges.data()) != nullptr) {
      return;
    }
  }
  fonts.AddFontDefault(&config);
}

// The picture that holds the letters, and the number of its columns; where a rectangle of it lies. Since 1.92 Dear
// ImGui adds letters when they are first used, and must not be asked to make them all.
#if IMGUI_VERSION_NUM >= 19200
std::pair<unsigned char*, int> pixels_of(ImFontAtlas& fonts) { return {fonts.TexData->Pixels, fonts.TexData->Width}; }
std::pair<int, int> place_of(const ImFontAtlasRect& rectangle) { return {rectangle.x, rectangle.y}; }
#else
std::pair<unsigned char*, int> pixels_of(ImFontAtlas& fonts) {
  std::pair<unsigned char*, int> found;
  fonts.GetTexDataAsRGBA32(&found.first, &found.second, nullptr);
  return found;
}
std::pair<int, int> place_of(const ImFontAtlasCustomRect& rectangle) { return {rectangle.X, rectangle.Y}; }
#endif

// Puts pictures of all matcaps beside the letters.
std::array<int, render::kMatcapCount> load_balls(int size) {
  std::array<int, render::kMatcapCount> rectangles{};
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  for (int& rectangle : rectangles) rectangle = fonts.AddCustomRectRegular(size, size);
  const auto [pixels, width] = pixels_of(fonts);
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    const auto [x_from, y_from] = place_of(*fonts.GetCustomRectByIndex(rectangles[i]));
    const render::Image ball = render::matcap_ball(render::all_matcaps()[i], size);
    const std::size_t row = 4 * static_cast<std::size_t>(size);
    for (int y = 0; y < size; ++y) {
      unsigned char* const to = pixels + 4 * (static_cast<std::ptrdiff_t>(y_from + y) * width + x_from);
      std::memcpy(to, ball.pixels.data() + row * static_cast<std::size_t>(y), row);
    }
  }
  return rectangles;
}

ImVec4 gray(float value, float alpha = 1) { return {value, value * 1.01F, value * 1.03F, alpha}; }

// Calm and dark, one warm accent.
void set_colours(ImGuiStyle& style) {
  const ImVec4 accent{0.86F, 0.52F, 0.26F, 1};
  const auto faint = [&](float alpha) { return ImVec4{accent.x, accent.y, accent.z, alpha}; };
  auto& colours = style.Colors;
  colours[ImGuiCol_Text] = gray(0.92F);
  colours[ImGuiCol_TextDisabled] = gray(0.60F);
  colours[ImGuiCol_WindowBg] = gray(0.13F, 0.94F);
  colours[ImGuiCol_PopupBg] = gray(0.15F, 0.98F);
  colours[ImGuiCol_MenuBarBg] = gray(0.11F);
  colours[ImGuiCol_Border] = gray(0.30F, 0.60F);
  colours[ImGuiCol_FrameBg] = gray(0.22F);
  colours[ImGuiCol_FrameBgHovered] = gray(0.28F);
  colours[ImGuiCol_FrameBgActive] = gray(0.32F);
  colours[ImGuiCol_TitleBg] = gray(0.11F);
  colours[ImGuiCol_TitleBgActive] = gray(0.16F);
  colours[ImGuiCol_TitleBgCollapsed] = gray(0.11F);
  colours[ImGuiCol_Button] = gray(0.25F);
  colours[ImGuiCol_ButtonHovered] = gray(0.33F);
  colours[ImGuiCol_ButtonActive] = faint(0.80F);
  colours[ImGuiCol_Header] = faint(0.40F);
  colours[ImGuiCol_HeaderHovered] = gray(0.28F);
  colours[ImGuiCol_HeaderActive] = faint(0.60F);
  colours[ImGuiCol_CheckMark] = accent;
  // Digits are written over the grab of a slider: it must be dark enough to read them.
  colours[ImGuiCol_SliderGrab] = {0.52F, 0.29F, 0.12F, 1};
  colours[ImGuiCol_SliderGrabActive] = {0.60F, 0.33F, 0.13F, 1};
  colours[ImGuiCol_Separator] = gray(0.30F);
  colours[ImGuiCol_ScrollbarBg] = gray(0.13F, 0.5F);
  colours[ImGuiCol_ScrollbarGrab] = gray(0.35F);
  colours[ImGuiCol_TextSelectedBg] = faint(0.40F);
  colours[ImGuiCol_NavHighlight] = accent;
  colours[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, kDimmed};
  colours[ImGuiCol_ResizeGrip] = gray(0.30F, 0.4F);
  colours[ImGuiCol_PlotHistogram] = accent;
}

// Rows of 37 points, which take a touch up to 3 points beside them.
void set_style_for_fingers(ImGuiStyle& style) {
  style.FramePadding = {9, 11};
  style.TouchExtraPadding = {2, 3};
  style.ScrollbarSize = 16;
  style.SelectableTextAlign = {0, 0.5F};
}

void set_style(float unit, bool is_touch) {
  ImGuiStyle& style = ImGui::GetStyle();
  style = {};
  set_colours(style);
  style.WindowRounding = 5;
  style.FrameRounding = 4;
  style.PopupRounding = 4;
  style.GrabRounding = 4;
  style.ScrollbarRounding = 4;
  style.WindowPadding = {10, 9};
  style.FramePadding = {7, 4};
  style.ItemSpacing = {8, 6};
  style.WindowBorderSize = 1;
  style.ScrollbarSize = 13;
  style.WindowTitleAlign = {0.02F, 0.5F};
  if (is_touch) set_style_for_fingers(style);
  style.ScaleAllSizes(unit);
}

}  // namespace

Gui::Gui(double unit) : unit_(static_cast<float>(unit)) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;        // panels have their places
  ImGui::GetIO().MouseDoubleClickTime = 0.5F;  // also where pictures are slow
#if IMGUI_VERSION_NUM >= 18900
  ImGui::GetIO().ConfigInputTrickleEventQueue =
      false;  // a window tells it what one frame may have, and draws no more frames
#endif
  set_style(unit_, is_touch_);
  load_font(kTextHeight * unit_);
  load_font(kHeadingHeight * unit_);
  balls_ = load_balls(static_cast<int>(std::round(kTextHeight * unit_)));
}

Gui::~Gui() { ImGui::DestroyContext(); }

void Gui::begin_heading() { ImGui::PushFont(ImGui::GetIO().Fonts->Fonts[1]); }

void Gui::end_heading() { ImGui::PopFont(); }

void Gui::begin_frame(const std::vector<Event>& events) {
  ImGuiIO& io = ImGui::GetIO();
  const auto point_at = [&](double x, double y) {
    io.MousePos = {static_cast<float>(x) / io.DisplayFramebufferScale.x,
                   static_cast<float>(y) / io.DisplayFramebufferScale.y};
  };
  for (const Event& event : events) {
    if (const auto* moved = std::get_if<PointerMoved>(&event)) {
      point_at(moved->x, moved->y);
    } else if (const auto* button = std::get_if<ButtonChanged>(&event)) {
      constexpr std::array order{0, 2, 1};  // Dear ImGui counts the right one before the middle one
      point_at(button->x, button->y);
      down_[static_cast<std::size_t>(order[static_cast<std::size_t>(button->button)])] = button->down;
    }
  }
  std::copy(down_.begin(), down_.end(), io.MouseDown);
  ImGui::NewFrame();
}

void Gui::end_frame() { ImGui::Render(); }

void Gui::set_touch(bool is_touch) {
  if (std::exchange(is_touch_, is_touch) != is_touch) set_style(unit_, is_touch);
}

bool Gui::scroll(double x, double y, double by) {
  const ImVec2 at{static_cast<float>(x), static_cast<float>(y)};
  const ImVector<ImGuiWindow*>& windows = ImGui::GetCurrentContext()->Windows;  // the last is in front
  for (int i = windows.Size - 1; i >= 0; --i) {
    ImGuiWindow* window = windows[i];
    const bool is_there = window->WasActive && !window->Hidden && window->OuterRectClipped.Contains(at);
    if (!is_there || (window->Flags & ImGuiWindowFlags_NoMouseInputs) != 0) continue;
    while (window->ScrollMax.y <= 0 && (window->Flags & ImGuiWindowFlags_ChildWindow) != 0) {
      window = window->ParentWindow;
    }
    const float from = window->ScrollTarget.y < FLT_MAX ? window->ScrollTarget.y : window->Scroll.y;
    if (by != 0) ImGui::SetScrollY(window, std::clamp(from - static_cast<float>(by), 0.0F, window->ScrollMax.y));
    return window->ScrollMax.y > 0;
  }
  return false;
}

float Gui::bar_height() const { return std::round(kTextHeight * unit_) + 2 * ImGui::GetStyle().FramePadding.y; }

bool Gui::is_dragging() const { return ImGui::IsAnyItemActive(); }

bool Gui::close_lists() {
  if (!ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup)) return false;
  ImGui::SetWindowFocus(nullptr);  // what is open above the focus closes
  return true;
}

void Gui::draw_ball(render::Matcap matcap) const {
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  ImVec2 from;
  ImVec2 to;
  const auto& place = *fonts.GetCustomRectByIndex(balls_[static_cast<std::size_t>(matcap)]);
  fonts.CalcCustomRectUV(&place, &from, &to);
  const float size = ImGui::GetFontSize();
  ImGui::Image(fonts.TexID, {size, size}, from, to);
}

bool Gui::has_pointer() const { return ImGui::GetIO().WantCaptureMouse || !ImGui::IsMousePosValid(); }

std::vector<Event> Gui::for_the_view(std::vector<Event> events) {
  std::erase_if(events, [this](const Event& event) { return !is_for_the_view(event); });
  return events;
}

bool Gui::is_for_the_view(const Event& event) {
  const ImGuiIO& io = ImGui::GetIO();
  if (const auto* button = std::get_if<ButtonChanged>(&event)) {
    if (!button->down) return std::erase(buttons_, button->button) > 0;
    if (is_menu_open_ ? io.WantCaptureMouse : io.WantCaptureMouseUnlessPopupClose) return false;
    buttons_.push_back(button->button);
    return true;
  }
  if (const auto* key = std::get_if<KeyChanged>(&event)) {
    if (!key->down) return std::erase(keys_, key->key) > 0;
    if (io.WantCaptureKeyboard) return false;
    std::erase(keys_, key->key);
    keys_.push_back(key->key);
    return true;
  }
  if (std::holds_alternative<PointerMoved>(event)) return !io.WantCaptureMouse || !buttons_.empty();
  if (std::holds_alternative<WheelTurned>(event)) return !io.WantCaptureMouse;
  return true;
}

#ifndef __EMSCRIPTEN__  // the page's own are in web/window.cpp

bool must_bring_files() { return false; }

void choose_files_to_bring() {}

#endif

std::vector<Event> take_frame(std::vector<Event>& events) {
  bool has_changed = false;
  const auto end = std::find_if(events.begin(), events.end(), [&](const Event& event) {
    const bool changes = std::holds_alternative<ButtonChanged>(event);
    if (has_changed && (changes || std::holds_alternative<PointerMoved>(event))) return true;
    has_changed = has_changed || changes;
    return false;
  });
  std::vector<Event> frame(std::make_move_iterator(events.begin()), std::make_move_iterator(end));
  events.erase(events.begin(), end);
  return frame;
}

std::size_t typed_in_a_frame(std::span<const Typed> typed) {
  std::vector<int> down;  // keys that write nothing, and must be seen while they are down
  bool has_text = false;
  for (std::size_t i = 0; i < typed.size(); ++i) {
    const Typed& each = typed[i];
    const bool writes = i + 1 < typed.size() && typed[i + 1].what == Typed::What::text;
    switch (each.what) {
      case Typed::What::text:
        has_text = true;
        break;
      case Typed::What::up:
        if (each.is_shift ? !down.empty() : std::find(down.begin(), down.end(), each.key) != down.end()) return i;
        break;
      case Typed::What::down:
        if (each.is_shift) break;
        if (writes ? !down.empty() : has_text) return i;
        if (!writes) down.push_back(each.key);
        break;
    }
  }
  return typed.size();
}

}  // namespace knead::studio
