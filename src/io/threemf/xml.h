// The tags of an XML text and their attributes, with their places in it. Comments, instructions and texts are passed
// over; entities stay as they are spelled.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace knead::detail::threemf {

struct Tag {
  std::string_view name;        // without its prefix
  std::string_view attributes;  // what follows the name
  std::size_t begin = 0;        // the byte of its <
  std::size_t end = 0;          // the byte after its >
  bool is_end = false;          // </name>
  bool is_empty = false;        // <name/>
};

// An attribute of a tag.
struct TagAttribute {
  std::string_view name;   // with its prefix
  std::string_view value;  // between the quotes
};

class TagCursor {
 public:
  // The text and the name must outlive this.
  TagCursor(std::string_view text, const std::string& name, std::size_t position = 0)
      : text_(text), name_(name), position_(position) {}

  // Takes the next tag; returns false at the end of the text. Throws InvalidInput for text that is no XML, and for a
  // document type, which 3MF forbids.
  bool next(Tag& tag);

  // Takes the next attribute from the front of a tag's; false if there are no more.
  bool next_attribute(std::string_view& attributes, TagAttribute& attribute) const;

  // Returns the value of an attribute, whose name may have a prefix; empty without it.
  std::string_view value(const Tag& tag, std::string_view name) const;

  // Names the line of a byte of the text.
  [[noreturn]] void fail(std::size_t position, const std::string& what) const;

 private:
  void skip_past(std::string_view end);

  std::string_view text_;
  const std::string& name_;
  std::size_t position_ = 0;
};

// Returns a name without the prefix of its namespace.
std::string_view local_name(std::string_view name);

}  // namespace knead::detail::threemf
