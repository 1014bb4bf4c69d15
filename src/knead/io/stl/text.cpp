// The words of an STL text.
#include "knead/io/text.h"
#include "knead/io/stl/stl.h"

namespace knead::io_detail::stl {
namespace {

// Keywords stand in any letter case.
bool is_keyword(std::string_view word, std::string_view keyword) {
  if (word.size() != keyword.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const char lower = word[i] >= 'A' && word[i] <= 'Z' ? static_cast<char>(word[i] - 'A' + 'a') : word[i];
    if (lower != keyword[i]) return false;
  }
  return true;
}

}  // namespace

void FacetCursor::fail_expected(const std::string& what, std::string_view found) const {
  if (found.empty()) text_.fail("the file ends where " + what + " is expected; it is cut short");
  text_.fail("expected " + what + ", found " + in_quotes(found));
}

void FacetCursor::expect(std::string_view keyword) {
  const std::string_view word = text_.next();
  if (!is_keyword(word, keyword)) fail_expected(in_quotes(keyword), word);
}

// Goes past the next `facet`, and the ends and beginnings of solids before it; false at the end of the file.
bool FacetCursor::begin_facet() {
  while (true) {
    const std::string_view word = text_.next();
    if (in_solid_ && is_keyword(word, "facet")) return true;
    if (!in_solid_ && word.empty() && solids_ > 0) return false;
    if (!is_keyword(word, in_solid_ ? "endsolid" : "solid")) {
      fail_expected(in_solid_ ? "'facet' or 'endsolid'" : "'solid'", word);
    }
    in_solid_ = !in_solid_;
    if (in_solid_) ++solids_;
    text_.next_line();  // the name may have blanks, or be a keyword
  }
}

bool FacetCursor::next(Facet& facet) {
  if (!begin_facet()) return false;
  facet.begin = text_.word_begin();
  const auto take_vector = [&](std::array<std::string_view, 3>& words) {
    for (std::string_view& word : words) {
      word = text_.next();
      if (word.empty()) fail_expected("a number", word);
    }
  };
  expect("normal");
  take_vector(facet.normal);
  expect("outer");
  expect("loop");
  for (auto& corner : facet.corner) {
    expect("vertex");
    take_vector(corner);
  }
  expect("endloop");
  expect("endfacet");
  facet.end = text_.position();
  return true;
}

}  // namespace knead::io_detail::stl
