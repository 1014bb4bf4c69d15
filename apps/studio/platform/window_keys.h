// The names that keys.h has for the keys of GLFW.
#pragma once

#include <string>

namespace knead::studio {

// Of a GLFW_KEY_... and its scancode; empty for a key without a name there. A letter is the one that the layout of the
// keyboard gives the key, so that Ctrl+Z is on Z; all else goes by its place.
std::string key_name(int glfw_key, int scancode);

}  // namespace knead::studio
