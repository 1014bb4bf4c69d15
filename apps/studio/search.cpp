#include "search.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string>

namespace knead::studio {

namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream(lower(text));
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// 0 is best; 3: not found.
int rank_of(Action action, const std::vector<std::string>& words) {
  const std::string title = lower(title_of(action));
  const std::string all = title + " " + lower(group_of(action)) + " " + lower(name_of(action));
  const bool has_all = std::all_of(words.begin(), words.end(),
                                   [&](const std::string& word) { return all.find(word) != std::string::npos; });
  if (!has_all) return 3;
  if (words.empty() || title.starts_with(words.front())) return 0;
  return title.find(" " + words.front()) != std::string::npos ? 1 : 2;
}

}  // namespace

std::vector<Action> found_actions(std::string_view text) {
  const std::vector<std::string> words = words_of(text);
  std::vector<Action> found;
  for (int rank = 0; rank < 3; ++rank) {
    for (const Action action : all_actions()) {
      if (rank_of(action, words) == rank) found.push_back(action);
    }
  }
  return found;
}

}  // namespace knead::studio
