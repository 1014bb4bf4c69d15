// The words of OBJ's lines.
#include "knead/io/text.h"
#include "knead/io/obj/obj.h"

namespace knead::io_detail::obj {
namespace {

// A line end that a backslash takes away: its length, or 0 where there is none.
std::size_t joined_length(std::string_view bytes, std::size_t position) {
  if (position + 1 >= bytes.size() || bytes[position] != '\\') return 0;
  if (bytes[position + 1] == '\n') return 2;
  if (bytes[position + 1] != '\r') return 0;
  return position + 2 < bytes.size() && bytes[position + 2] == '\n' ? 3 : 2;
}

}  // namespace

std::size_t first_byte(std::string_view bytes) { return bytes.substr(0, 3) == "\xef\xbb\xbf" ? 3 : 0; }

std::size_t skip_blanks(std::string_view bytes, std::size_t position) {
  while (position < bytes.size()) {
    if (is_blank(bytes[position])) {
      ++position;
    } else if (const std::size_t joined = joined_length(bytes, position); joined > 0) {
      position += joined;
    } else {
      break;
    }
  }
  return position;
}

std::size_t end_of_line(std::string_view bytes, std::size_t position) {
  while (position < bytes.size() && !is_line_end(bytes[position])) ++position;
  return position;
}

std::size_t word_end(std::string_view bytes, std::size_t position) {
  while (position < bytes.size() && !is_blank(bytes[position]) && !is_line_end(bytes[position]) &&
         joined_length(bytes, position) == 0) {
    ++position;
  }
  return position;
}

}  // namespace knead::io_detail::obj
