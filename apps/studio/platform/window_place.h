// How large a window is.
#pragma once

namespace knead::studio {

struct WindowPlace {
  int width = 1440;  // in points; of a maximised window, as it is when it is restored
  int height = 900;
  bool maximized = false;

  friend bool operator==(const WindowPlace&, const WindowPlace&) = default;
};

}  // namespace knead::studio
