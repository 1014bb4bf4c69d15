// The words of point files in text: between blanks, or between commas or semicolons.
#pragma once

#include <string>
#include <string_view>

#include "knead/io/cursor.h"

namespace knead::io_detail::xyz {

// Whether a word begins as a number does; "nan" and "inf" are numbers too.
bool is_number(std::string_view word);

class Words {
 public:
  // The bytes and the name must outlive this.
  Words(std::string_view bytes, const std::string& name) : bytes_(bytes), text_(bytes, name, text_begin(bytes, name)) {}

  const TextCursor& text() const { return text_; }

  // The next word of this line; empty where the line, or the file, has no more. Comments begin with #, % or //. Throws
  // InvalidInput where separators are mixed: commas among blanks may be those of decimals.
  std::string_view next_on_line();
  bool next_line();

  // The first word of the next line that has any; empty at the end of the file.
  std::string_view next();

  // Goes back to a byte at the beginning of a line.
  void go_to(std::size_t position);

 private:
  void note_separator(char c, std::size_t& count);
  void note_gap(std::size_t separators, bool is_number);
  bool is_comment(std::size_t begin) const;
  std::size_t word_end(std::size_t begin) const;

  std::string_view bytes_;
  TextCursor text_;
  bool at_begin_ = true;       // of a line
  bool after_number_ = false;  // the word before is a number
  bool separated_ = false;     // two numbers of this line have a comma between them
  bool by_blanks_ = false;     // two numbers of this line have only blanks between them
  bool mixed_ = false;
  char separator_ = '\0';  // of this line
};

}  // namespace knead::io_detail::xyz
