#include "knead/io/ply/body.h"

#include "knead/io/text.h"

namespace knead::io_detail::ply {
namespace {

std::string cut_short(const Element& element) {
  return "the file ends within element '" + element.name + "'; it is cut short, or the counts in the header are wrong";
}

}  // namespace

void fail_length(std::string_view bytes, std::size_t position, bool ascii, const std::string& name,
                 const Element& element, double length) {
  std::string what = "a list cannot have " + shown(length) + " items";
  if (length >= 0 && length == std::floor(length)) {
    what = "a list of element '" + element.name + "' declares " + shown(length) + " items, but only " +
           std::to_string(bytes.size() - position) + " bytes follow; the file is cut short or damaged";
  }
  if (ascii) fail_at_line(name, bytes, position, what);
  fail_at_byte(name, position, what);
}

void BinaryBody::fail_missing(const Element& element) const { fail(cut_short(element)); }

std::string not_an_index(double value) {
  return "vertex index " + shown(value) + " is not the number of a vertex; repair the file";
}

bool TextBody::end_row() {
  const auto skip_blanks = [&] {
    while (position_ < bytes_.size() && is_blank(bytes_[position_])) ++position_;
  };
  bool surplus = false;
  for (skip_blanks(); position_ < bytes_.size() && !is_line_end(bytes_[position_]); skip_blanks()) {
    const std::string_view token = next_token();
    double value = 0;
    if (parse_real(token, value) != ParseResult::ok) fail(in_quotes(token) + " is not a number");
    position_ += token.size();
    surplus = true;
  }
  return surplus;
}

double TextBody::number(StoredType type, const Element& element) {
  skip_to_token();
  if (position_ == bytes_.size()) fail(cut_short(element));
  const std::string_view token = next_token();
  double value = 0;
  float single = 0;
  const bool is_single = type == StoredType::float32;
  const ParseResult result = is_single ? parse_real(token, single) : parse_real(token, value);
  if (result == ParseResult::malformed) fail(in_quotes(token) + " is not a number");
  if (result == ParseResult::overflow) {
    fail(in_quotes(token) + " does not fit in a " + std::string(type_name(type)));
  }
  position_ += token.size();
  return is_single ? double{single} : value;
}

std::size_t TextBody::length(const Property& property, const Element& element) {
  skip_to_token();
  const std::size_t begin = position_;
  const double value = number(property.count_type, element);
  const std::size_t most = left() / 2 + 1;  // the last number needs no blank after it
  if (!(value >= 0) || value != std::floor(value) || value > static_cast<double>(most)) {
    fail_length(bytes_, begin, kAscii, name_, element, value);
  }
  return static_cast<std::size_t>(value);
}

void TextBody::indices(const Property& property, std::size_t count, const Element& element,
                       std::vector<std::int64_t>& items) {
  items.resize(count);
  for (std::int64_t& item : items) {
    const double value = number(property.type, element);
    if (!is_index(value)) fail(not_an_index(value));
    item = static_cast<std::int64_t>(value);
  }
}

}  // namespace knead::io_detail::ply
