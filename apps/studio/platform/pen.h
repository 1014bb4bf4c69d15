// The pressure of a pen. GLFW 3.3 does not report it; on X11 the extension XInput2 does (docs/decisions/0019).
#pragma once

#include <memory>

namespace knead::studio {

// Returns the pressure from 0 to 1 for a value of an axis; 1 for an axis without length.
double pressure_of_axis(double value, double least, double most);

// Follows the devices of the display on a connection of its own. Without X11 or its extension there is no pen.
class Pen {
 public:
  Pen();
  ~Pen();
  Pen(const Pen&) = delete;
  Pen& operator=(const Pen&) = delete;

  // Returns the pressure, from 0 to 1, of the device that moved last; 1 if that has no axis for it.
  double pressure();

 private:
  struct State;
  std::unique_ptr<State> state_;  // null: no pen can be followed
};

}  // namespace knead::studio
