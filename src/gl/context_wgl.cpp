// Opens contexts through WGL, as on Windows. Each has a window of its own, which is never shown.
#include <array>
#include <cstddef>

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

#include "knead/editor/gl.h"

namespace knead::gl {

namespace {

// Of the extensions WGL_ARB_create_context, _profile and _robustness.
constexpr int kMajorVersion = 0x2091;
constexpr int kMinorVersion = 0x2092;
constexpr int kProfileMask = 0x9126;
constexpr int kCoreProfile = 1;
constexpr int kFlags = 0x2094;
constexpr int kRobustAccess = 4;
constexpr int kResetStrategy = 0x8256;
constexpr int kLoseContextOnReset = 0x8252;
using CreateContext = HGLRC(WINAPI*)(HDC, HGLRC, const int*);

constexpr const wchar_t* kWindowClass = L"knead offscreen";

// Returns the device context of a new hidden window, in a format for OpenGL; null if there is none.
HDC make_hidden_window() {
  WNDCLASSW description{};
  description.style = CS_OWNDC;
  description.lpfnWndProc = ::DefWindowProcW;
  description.hInstance = ::GetModuleHandleW(nullptr);
  description.lpszClassName = kWindowClass;
  ::RegisterClassW(&description);  // fails where it is registered already
  const HWND window =
      ::CreateWindowExW(0, kWindowClass, L"", WS_POPUP, 0, 0, 1, 1, nullptr, nullptr, description.hInstance, nullptr);
  if (window == nullptr) return nullptr;
  const HDC picture = ::GetDC(window);
  PIXELFORMATDESCRIPTOR format{};
  format.nSize = sizeof format;
  format.nVersion = 1;
  format.dwFlags = PFD_DRAW_TO_WINDOW | PFD_SUPPORT_OPENGL | PFD_DOUBLEBUFFER;
  format.cColorBits = 24;
  const int number = ::ChoosePixelFormat(picture, &format);
  if (number == 0 || ::SetPixelFormat(picture, number, &format) == FALSE) {
    ::DestroyWindow(window);
    return nullptr;
  }
  return picture;
}

// Only a context that is current knows the function that makes one of a version.
CreateContext find_create_context(HDC picture) {
  const HDC before_picture = ::wglGetCurrentDC();
  const HGLRC before = ::wglGetCurrentContext();
  const HGLRC old = ::wglCreateContext(picture);
  if (old == nullptr) return nullptr;
  ::wglMakeCurrent(picture, old);
  const PROC found = ::wglGetProcAddress("wglCreateContextAttribsARB");
  ::wglMakeCurrent(before_picture, before);
  ::wglDeleteContext(old);
  return reinterpret_cast<CreateContext>(reinterpret_cast<void*>(found));
}

// Returns the newest context that the driver offers, which reports its loss where the driver can.
HGLRC create_context(HDC picture, int least_version) {
  const CreateContext create = find_create_context(picture);
  if (create == nullptr) return nullptr;
  for (const int version : {43, 41, 33}) {
    if (version < least_version) break;
    const std::array<int, 11> attributes{kResetStrategy,
                                         kLoseContextOnReset,
                                         kFlags,
                                         kRobustAccess,
                                         kMajorVersion,
                                         version / 10,
                                         kMinorVersion,
                                         version % 10,
                                         kProfileMask,
                                         kCoreProfile,
                                         0};
    for (const std::size_t first : {0, 4}) {
      const HGLRC context = create(picture, nullptr, attributes.data() + first);
      if (context != nullptr) return context;
    }
  }
  return nullptr;
}

}  // namespace

Context Context::open(int version) {
  Context found;
  const HDC picture = make_hidden_window();
  found.display_ = picture;
  if (picture != nullptr) found.context_ = create_context(picture, version);
  if (found.context_ == nullptr) {
    throw GpuError("no GPU with OpenGL " + std::to_string(version / 10) + "." + std::to_string(version % 10) +
                   " was found; install its maker's driver");
  }
  const CurrentContext current(found);
  found.describe_current();
  return found;
}

Context::~Context() {
  if (context_ != nullptr) ::wglDeleteContext(static_cast<HGLRC>(context_));
  if (display_ != nullptr) ::DestroyWindow(::WindowFromDC(static_cast<HDC>(display_)));
}

CurrentContext::CurrentContext(const Context& context)
    : is_adopted_(context.context_ == nullptr), display_(context.display_) {
  if (is_adopted_) return;
  before_display_ = ::wglGetCurrentDC();
  before_context_ = ::wglGetCurrentContext();
  if (::wglMakeCurrent(static_cast<HDC>(display_), static_cast<HGLRC>(context.context_)) == FALSE) {
    throw GpuError("the GPU does not answer; start again, or use the CPU");
  }
}

CurrentContext::~CurrentContext() {
  if (!is_adopted_) ::wglMakeCurrent(static_cast<HDC>(before_display_), static_cast<HGLRC>(before_context_));
}

}  // namespace knead::gl
