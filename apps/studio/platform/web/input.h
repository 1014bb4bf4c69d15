// What the page tells of pointer and keys, for Dear ImGui. The page calls the functions at the end of window.cpp.
#pragma once

#include <array>
#include <deque>
#include <string>
#include <vector>

#include "platform/event.h"

namespace knead::studio {

struct KeyInput {
  std::string key;
  bool down = false;
};

// Since the last picture, but for the pointer's place and what is held.
struct PageInput {
  double x = -1;
  double y = -1;
  std::array<bool, 3> held{};     // left, right, middle
  std::array<bool, 3> pressed{};  // however short
  double wheel = 0;
  Modifiers modifiers;
  std::deque<KeyInput> keys;
  std::vector<unsigned> text;  // code points
};

// Of the page's one window.
PageInput& page_input();

}  // namespace knead::studio
