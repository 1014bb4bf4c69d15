// Finds commands by what a person types.
#pragma once

#include <string_view>
#include <vector>

#include "keys.h"

namespace knead::studio {

// Returns the actions in whose title, group or name every word of the text occurs, in upper or lower case: first those
// whose title begins with the text, then those with a word that begins with its first word, then the others. All
// actions if the text holds no word.
std::vector<Action> found_actions(std::string_view text);

}  // namespace knead::studio
