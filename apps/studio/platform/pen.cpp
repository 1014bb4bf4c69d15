// The pressure of a pen: on X11 by raw events of XInput2, which come for the whole display, whatever window has them;
// on Windows by the messages of Windows Ink. Elsewhere there is only a mouse.
#include "platform/window.h"

#ifdef KNEAD_HAS_XINPUT

#include <X11/Xlib.h>
#include <X11/extensions/XInput2.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>

namespace knead::studio {

namespace {

constexpr int kMajor = 2;
constexpr int kMinor = 2;

struct PressureAxis {
  int number = 0;
  double least = 0;
  double most = 1;
};

// Returns the pressure from 0 to 1 for a value of an axis; 1 for an axis without length.
double pressure_of_axis(double value, double least, double most) {
  return most > least ? std::clamp((value - least) / (most - least), 0.0, 1.0) : 1;
}

// The axis of a device that is labelled so; nothing for a mouse.
std::optional<PressureAxis> pressure_axis(const XIDeviceInfo& device, Atom label) {
  for (const XIAnyClassInfo* const each : std::span(device.classes, static_cast<std::size_t>(device.num_classes))) {
    if (each->type != XIValuatorClass) continue;
    const auto* const axis = reinterpret_cast<const XIValuatorClassInfo*>(each);
    if (axis->label == label) return PressureAxis{axis->number, axis->min, axis->max};
  }
  return std::nullopt;
}

// The value of an axis in a raw event, which holds only those that changed.
std::optional<double> raw_value(const XIRawEvent& event, int axis) {
  const XIValuatorState& state = event.valuators;
  if (axis >= state.mask_len * 8 || !XIMaskIsSet(state.mask, axis)) return std::nullopt;
  std::size_t index = 0;
  for (int i = 0; i < axis; ++i) index += XIMaskIsSet(state.mask, i) ? 1 : 0;
  return event.raw_values[index];
}

}  // namespace

struct Pen::State {
  explicit State(Display* opened) : display(opened) {}
  ~State() { XCloseDisplay(display); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  bool start();
  void find_devices();
  void take(const XIRawEvent& event);

  Display* display;
  int extension = 0;
  std::map<int, PressureAxis> axes;  // of the devices that have one
  double pressure = 1;
};

bool Pen::State::start() {
  int ignored = 0;
  int major = kMajor;
  int minor = kMinor;
  if (XQueryExtension(display, "XInputExtension", &extension, &ignored, &ignored) == 0) return false;
  if (XIQueryVersion(display, &major, &minor) != Success) return false;
  find_devices();
  std::array<unsigned char, XIMaskLen(XI_LASTEVENT)> motions{};
  XISetMask(motions.data(), XI_RawMotion);
  std::array<unsigned char, XIMaskLen(XI_LASTEVENT)> changes{};
  XISetMask(changes.data(), XI_HierarchyChanged);
  std::array<XIEventMask, 2> masks{{{XIAllMasterDevices, static_cast<int>(motions.size()), motions.data()},
                                    {XIAllDevices, static_cast<int>(changes.size()), changes.data()}}};
  XISelectEvents(display, DefaultRootWindow(display), masks.data(), static_cast<int>(masks.size()));
  XFlush(display);
  return true;
}

void Pen::State::find_devices() {
  axes.clear();
  int count = 0;
  XIDeviceInfo* const devices = XIQueryDevice(display, XIAllDevices, &count);
  if (devices == nullptr) return;
  const Atom label = XInternAtom(display, "Abs Pressure", False);
  for (const XIDeviceInfo& device : std::span(devices, static_cast<std::size_t>(count))) {
    const bool is_master = device.use == XIMasterPointer || device.use == XIMasterKeyboard;
    if (is_master) continue;  // it has the axes of whatever device moved it last
    if (const auto axis = pressure_axis(device, label)) axes[device.deviceid] = *axis;
  }
  XIFreeDeviceInfo(devices);
}

void Pen::State::take(const XIRawEvent& event) {
  const auto axis = axes.find(event.sourceid);
  if (axis == axes.end()) {
    pressure = 1;
  } else if (const auto value = raw_value(event, axis->second.number)) {
    pressure = pressure_of_axis(*value, axis->second.least, axis->second.most);
  }
}

Pen::Pen() {
  Display* const display = XOpenDisplay(nullptr);
  if (display == nullptr) return;
  state_ = std::make_unique<State>(display);
  if (!state_->start()) state_.reset();
}

Pen::~Pen() = default;

double Pen::pressure() {
  if (!state_) return 1;
  while (XPending(state_->display) > 0) {
    XEvent event;
    XNextEvent(state_->display, &event);
    XGenericEventCookie& cookie = event.xcookie;
    if (cookie.type != GenericEvent || cookie.extension != state_->extension) continue;
    if (XGetEventData(state_->display, &cookie) == False) continue;
    if (cookie.evtype == XI_RawMotion) state_->take(*static_cast<const XIRawEvent*>(cookie.data));
    if (cookie.evtype == XI_HierarchyChanged) state_->find_devices();
    XFreeEventData(state_->display, &cookie);
  }
  return state_->pressure;
}

}  // namespace knead::studio

#elif defined(_WIN32)

#include <algorithm>

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

namespace knead::studio {

namespace {

constexpr double kMaxPenPressure = 1024;  // of Windows
// How Windows marks what it sends as a mouse's but comes from a pen or a finger.
constexpr LPARAM kPenMark = 0xFF515700;
constexpr LPARAM kPenMask = 0xFFFFFF00;
// Without this Windows waits with each press whether it becomes a right click.
constexpr const wchar_t* kPenService = L"MicrosoftTabletPenServiceProperty";
constexpr std::intptr_t kNoPressAndHold = 1;

// Of the pen that moved last. One for the program: a hook of Windows knows no object.
double pressure_now = 1;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

void take(const MSG& message) {
  switch (message.message) {
    case WM_POINTERENTER:
      ::SetPropW(message.hwnd, kPenService, reinterpret_cast<HANDLE>(kNoPressAndHold));
      break;
    case WM_POINTERDOWN:
    case WM_POINTERUPDATE: {
      POINTER_PEN_INFO pen{};
      if (::GetPointerPenInfo(GET_POINTERID_WPARAM(message.wParam), &pen) == FALSE) break;  // a finger
      pressure_now = (pen.penMask & PEN_MASK_PRESSURE) != 0 ? std::clamp(pen.pressure / kMaxPenPressure, 0.0, 1.0) : 1;
      break;
    }
    case WM_MOUSEMOVE:
    case WM_LBUTTONDOWN:
      if ((::GetMessageExtraInfo() & kPenMask) != kPenMark) pressure_now = 1;
      break;
    default:
      break;
  }
}

// Sees each message of the thread before its window does.
LRESULT CALLBACK on_message(int code, WPARAM is_removed, LPARAM message) {
  if (code == HC_ACTION && is_removed == PM_REMOVE) take(*reinterpret_cast<const MSG*>(message));
  return ::CallNextHookEx(nullptr, code, is_removed, message);
}

}  // namespace

struct Pen::State {
  HHOOK hook;
};

Pen::Pen()
    : state_(std::make_unique<State>(::SetWindowsHookExW(WH_GETMESSAGE, on_message, nullptr, ::GetCurrentThreadId()))) {
}

Pen::~Pen() { ::UnhookWindowsHookEx(state_->hook); }

// Windows Ink: the messages of a pointer come first, then the same as a mouse's, which GLFW reports.
double Pen::pressure() { return pressure_now; }

}  // namespace knead::studio

#else

namespace knead::studio {

struct Pen::State {};

Pen::Pen() = default;
Pen::~Pen() = default;

// A mouse.
double Pen::pressure() { return 1; }

}  // namespace knead::studio

#endif
