#include "platform/pen.h"

#include <algorithm>

namespace knead::studio {

double pressure_of_axis(double value, double least, double most) {
  return most > least ? std::clamp((value - least) / (most - least), 0.0, 1.0) : 1;
}

}  // namespace knead::studio
