// The tags of an XML text.
#include "io/threemf/xml.h"

#include "io/text.h"

namespace knead::detail::threemf {

namespace {

bool is_space(char c) { return is_blank(c) || is_line_end(c); }

std::size_t skip_spaces(std::string_view text, std::size_t at) {
  while (at < text.size() && is_space(text[at])) ++at;
  return at;
}

}  // namespace

std::string_view local_name(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

void TagCursor::fail(std::size_t position, const std::string& what) const {
  fail_at_line(name_, text_, position, what);
}

void TagCursor::skip_past(std::string_view end) {
  const std::size_t at = text_.find(end, position_);
  if (at == text_.npos) fail(position_, "a comment or instruction has no end; the file is damaged");
  position_ = at + end.size();
}

bool TagCursor::next(Tag& tag) {
  for (;;) {
    position_ = text_.find('<', position_);
    if (position_ == text_.npos) {
      position_ = text_.size();
      return false;
    }
    const std::string_view rest = text_.substr(position_);
    if (rest.starts_with("<!--")) {
      skip_past("-->");
    } else if (rest.starts_with("<![CDATA[")) {
      skip_past("]]>");
    } else if (rest.starts_with("<?")) {
      skip_past("?>");
    } else {
      break;
    }
  }
  tag.begin = position_;
  if (text_.substr(position_ + 1, 1) == "!") fail(position_, "a document type is not allowed in 3MF; remove it");
  char quote = 0;
  std::size_t at = position_ + 1;
  for (; at < text_.size(); ++at) {
    const char c = text_[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      break;
    } else if (c == '<') {
      at = text_.size();
    }
  }
  if (at >= text_.size()) fail(tag.begin, "a tag has no end; the file is damaged");
  tag.end = at + 1;
  position_ = tag.end;
  tag.is_end = text_[tag.begin + 1] == '/';
  tag.is_empty = !tag.is_end && text_[at - 1] == '/';
  const std::size_t begin = tag.begin + (tag.is_end ? 2 : 1);
  const std::string_view inner = text_.substr(begin, at - (tag.is_empty ? 1 : 0) - begin);
  std::size_t size = 0;
  while (size < inner.size() && !is_space(inner[size])) ++size;
  tag.name = local_name(inner.substr(0, size));
  tag.attributes = inner.substr(size);
  return true;
}

bool TagCursor::next_attribute(std::string_view& attributes, TagAttribute& attribute) const {
  const std::size_t begin = skip_spaces(attributes, 0);
  if (begin >= attributes.size()) return false;
  const std::size_t position = static_cast<std::size_t>(attributes.data() - text_.data());
  std::size_t end = begin;
  while (end < attributes.size() && attributes[end] != '=' && !is_space(attributes[end])) ++end;
  attribute.name = attributes.substr(begin, end - begin);
  end = skip_spaces(attributes, end);
  if (end >= attributes.size() || attributes[end] != '=') fail(position, "an attribute has no value");
  const std::size_t open = skip_spaces(attributes, end + 1);
  const bool is_quoted = open < attributes.size() && (attributes[open] == '"' || attributes[open] == '\'');
  const std::size_t close = is_quoted ? attributes.find(attributes[open], open + 1) : attributes.npos;
  if (close == attributes.npos) fail(position, "the value of an attribute is not in quotes");
  attribute.value = attributes.substr(open + 1, close - open - 1);
  attributes.remove_prefix(close + 1);
  return true;
}

std::string_view TagCursor::value(const Tag& tag, std::string_view name) const {
  TagAttribute attribute;
  for (std::string_view rest = tag.attributes; next_attribute(rest, attribute);) {
    if (local_name(attribute.name) == name) return attribute.value;
  }
  return {};
}

}  // namespace knead::detail::threemf
