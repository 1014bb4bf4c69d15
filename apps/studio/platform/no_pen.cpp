// Where Studio is built without XInput2.
#include "platform/pen.h"

namespace knead::studio {

struct Pen::State {};

Pen::Pen() = default;
Pen::~Pen() = default;

// A mouse.
double Pen::pressure() { return 1; }

}  // namespace knead::studio
