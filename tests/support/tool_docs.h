// Holds docs/session.md against the descriptions of the tools.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <string>
#include <vector>

#include "knead/editor/tools.h"

namespace knead::test {

// Returns the part of the document under the heading "### NAME", with or without more words after a colon.
inline std::string section_of(const std::string& document, std::string_view tool) {
  std::size_t begin = document.find(fmt::format("\n### {}:", tool));
  if (begin == std::string::npos) begin = document.find(fmt::format("\n### {}\n", tool));
  if (begin == std::string::npos) return "";
  const std::size_t end = std::min(document.find("\n### ", begin + 1), document.find("\n## ", begin + 1));
  return document.substr(begin, end - begin);
}

// Returns the default as the document gives it, or nothing for defaults that it describes in words.
inline std::string documented_default(const StrokeKey& key) {
  if (key.presence == Presence::required) return "";
  if (auto* const* number = std::get_if<double*>(&key.value); number != nullptr && *number != nullptr) {
    return fmt::format(" ({})", **number);
  }
  if (auto* const* number = std::get_if<int*>(&key.value)) return fmt::format(" ({})", **number);
  if (const auto* choice = std::get_if<Choice>(&key.value)) return fmt::format(" (\"{}\")", choice->words.front());
  return "";
}

// Returns a sentence for each tool and key that the document does not name, for each default that it does not give, and
// for each key in a tool's table that the tool does not have.
inline std::vector<std::string> documentation_problems(const std::string& document) {
  std::vector<std::string> problems;
  for (const Tool* tool : tools()) {
    const std::string section = section_of(document, tool->name);
    if (section.empty()) problems.push_back(fmt::format("docs/session.md has no section \"### {}\"", tool->name));
    Stroke start = tool->start;
    std::vector<std::string> names;
    for (const StrokeKey& key : tool->keys(start)) {
      names.emplace_back(key.name);
      const std::string given = documented_default(key);
      const bool is_named = section.find(fmt::format("`{}`{}", key.name, given)) != std::string::npos ||
                            (given.empty() && section.find(fmt::format("\"{}\":", key.name)) != std::string::npos);
      if (!is_named)
        problems.push_back(fmt::format("docs/session.md, {}: `{}`{} is missing", tool->name, key.name, given));
    }
    const std::regex row("\n\\| ((?:[^|]*`[a-z_]+`)+)");
    const std::regex word("`([a-z_]+)`");
    for (std::sregex_iterator i(section.begin(), section.end(), row), end; i != end; ++i) {
      const std::string cell = (*i)[1];
      for (std::sregex_iterator k(cell.begin(), cell.end(), word); k != end; ++k) {
        if (std::find(names.begin(), names.end(), (*k)[1]) != names.end()) continue;
        problems.push_back(fmt::format("docs/session.md: {} has no key `{}`", tool->name, (*k)[1].str()));
      }
    }
  }
  return problems;
}

}  // namespace knead::test
