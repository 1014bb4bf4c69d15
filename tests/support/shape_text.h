// Shapes from text in tests, and what is said of them.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/io.h"

namespace knead {

// What reading the bytes is refused with; "none" if it is not.
inline std::string refusal(const std::string& bytes, const std::string& format, const std::string& name) {
  try {
    parse_shape(bytes, format, name);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

// The text with the first place of `from` replaced, which must be there.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// A line for each.
inline std::string text_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

}  // namespace knead
