// The words of an STL text.
#include "knead/io/text.h"

#include <optional>

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

// The next word that is no color: `end` and what follows it are one word.
std::string_view FacetCursor::next_keyword() {
  std::string_view word = text_.next();
  while (is_keyword(word, "color")) {
    oddities_.colors = true;
    for (double value = 0; parse_real(word = text_.next(), value) != ParseResult::malformed;) continue;
  }
  if (!is_keyword(word, "end")) return word;
  const std::size_t begin = text_.word_begin();
  const std::string_view second = text_.next();
  for (const std::string_view whole : {"endloop", "endfacet", "endsolid"}) {
    if (!is_keyword(second, whole.substr(3))) continue;
    oddities_.split_words = true;
    return whole;
  }
  text_.take(begin, begin + word.size());
  return word;
}

void FacetCursor::expect(std::string_view keyword) {
  const std::string_view word = next_keyword();
  if (!is_keyword(word, keyword)) fail_expected(in_quotes(keyword), word);
}

// Whether `facet normal` and a number follow on the line. Stays where it is.
bool FacetCursor::is_at_facet() {
  const std::size_t begin = text_.position();
  double value = 0;
  const bool found = is_keyword(text_.next_on_line(), "facet") && is_keyword(text_.next_on_line(), "normal") &&
                     parse_real(text_.next_on_line(), value) == ParseResult::ok;
  text_.take(begin, begin);
  return found;
}

// Goes past the name after `solid` or `endsolid`, which may have blanks, or be a keyword: to the end of the line, or to
// the facet, or the next `solid` and its facet, that stand on it.
void FacetCursor::end_name(bool of_begin) {
  const std::size_t begin = text_.position();
  std::optional<std::size_t> solid;  // where the last word `solid` begins
  while (true) {
    if ((of_begin || solid) && is_at_facet()) {
      oddities_.on_one_line = true;
      const std::size_t at = solid.value_or(text_.position());
      text_.take(at, at);
      return;
    }
    const std::string_view word = text_.next_on_line();
    if (word.empty()) break;
    if (!of_begin && is_keyword(word, "solid")) solid = text_.word_begin();
  }
  text_.take(begin, begin);
  text_.next_line();
}

// Goes past the next `facet`, and the ends and beginnings of solids before it; false at the end of the file.
bool FacetCursor::begin_facet() {
  while (true) {
    const std::string_view word = next_keyword();
    if (in_solid_ && is_keyword(word, "facet")) return true;
    const bool may_end = in_solid_ ? facets_ > 0 : solids_ > 0;
    if (word.empty() && may_end) {
      oddities_.open_end = in_solid_;
      return false;
    }
    if (!is_keyword(word, in_solid_ ? "endsolid" : "solid")) {
      fail_expected(in_solid_ ? "'facet' or 'endsolid'" : "'solid'", word);
    }
    in_solid_ = !in_solid_;
    if (in_solid_) ++solids_;
    end_name(in_solid_);
  }
}

bool FacetCursor::next(Facet& facet) {
  if (!begin_facet()) return false;
  ++facets_;
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
