#include "knead/io/cloud/words.h"

namespace knead::io_detail::xyz {
namespace {

bool is_separator(char c) { return c == ',' || c == ';'; }

}  // namespace

bool is_number(std::string_view word) {
  double value = 0;
  return parse_real(word, value) != ParseResult::malformed;
}

std::string_view Words::next_on_line() {
  std::size_t begin = text_.position();
  std::size_t separators = 0;
  for (; begin < bytes_.size() && (is_blank(bytes_[begin]) || is_separator(bytes_[begin])); ++begin) {
    if (is_separator(bytes_[begin])) note_separator(bytes_[begin], separators);
  }
  const std::size_t end = is_comment(begin) ? begin : word_end(begin);
  const std::string_view word = text_.take(begin, end);
  if (separators > (at_begin_ ? 0 : 1) && !word.empty()) text_.fail("expected a number between two separators");
  if (mixed_) text_.fail("commas and semicolons on one line; write numbers with points and one kind of separator");
  if (!word.empty()) note_gap(separators, word[0] >= '+' && word[0] <= '9');
  at_begin_ = false;
  return word;
}

void Words::note_gap(std::size_t separators, bool is_number) {
  if (!at_begin_ && after_number_ && is_number) {
    separated_ = separated_ || separators > 0;
    by_blanks_ = by_blanks_ || separators == 0;
    if (separated_ && by_blanks_) {
      text_.fail(
          "commas between some numbers and blanks between others; write decimals with points, not commas, and one "
          "kind of separator");
    }
  }
  after_number_ = is_number;
}

bool Words::next_line() {
  at_begin_ = true;
  after_number_ = separated_ = by_blanks_ = false;
  separator_ = '\0';
  return text_.next_line();
}

std::string_view Words::next() {
  std::string_view word = next_on_line();
  while (word.empty() && next_line()) word = next_on_line();
  return word;
}

void Words::go_to(std::size_t position) {
  text_.take(position, position);
  at_begin_ = true;
  after_number_ = separated_ = by_blanks_ = false;
  separator_ = '\0';
}

void Words::note_separator(char c, std::size_t& count) {
  ++count;
  mixed_ = mixed_ || (separator_ != '\0' && separator_ != c);
  separator_ = c;
}

bool Words::is_comment(std::size_t begin) const {
  const std::string_view two = bytes_.substr(begin, 2);
  return two == "//" || (!two.empty() && (two[0] == '#' || two[0] == '%'));
}

std::size_t Words::word_end(std::size_t begin) const {
  while (begin < bytes_.size() && !is_blank(bytes_[begin]) && !is_line_end(bytes_[begin]) &&
         !is_separator(bytes_[begin])) {
    ++begin;
  }
  return begin;
}

}  // namespace knead::io_detail::xyz
