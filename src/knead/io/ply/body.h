// The numbers after a PLY header, one after the other, in binary and in text. Both bodies have the same members.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "knead/io/ply/header.h"

namespace knead::io_detail::ply {

// Throws InvalidInput for a list of an element whose length is no count of items.
[[noreturn]] void fail_length(std::string_view bytes, std::size_t position, bool ascii, const std::string& name,
                              const Element& element, double length);

// Whether a number could be the index of a vertex, and what to say of one that could not.
inline bool is_index(double value) { return value == std::floor(value) && std::abs(value) <= 0x1p32; }
std::string not_an_index(double value);

class BinaryBody {
 public:
  BinaryBody(std::string_view bytes, const Layout& layout, const std::string& name)
      : bytes_(bytes), position_(layout.body_begin), swapped_(is_swapped(layout.encoding)), name_(name) {}

  static constexpr bool kAscii = false;
  std::size_t position() const { return position_; }
  std::size_t left() const { return bytes_.size() - position_; }
  bool swapped() const { return swapped_; }
  [[noreturn]] void fail(const std::string& what) const { fail_at_byte(name_, position_, what); }
  [[noreturn]] void fail_at(std::size_t position, const std::string& what) const {
    fail_at_byte(name_, position, what);
  }

  // The next byte; only as many as are left.
  const char* data() const { return bytes_.data() + position_; }

  // The next bytes, read over; the caller has checked that they are there.
  const char* skip(std::size_t count) {
    position_ += count;
    return bytes_.data() + (position_ - count);
  }

  void begin_row() {}
  bool end_row() { return false; }

  double number(StoredType type, const Element& element) {
    const std::size_t size = size_of(type);
    if (left() < size) fail_missing(element);
    return read_binary(skip(size), type, swapped_);
  }

  std::size_t length(const Property& property, const Element& element) {
    if (left() < size_of(property.count_type)) fail_missing(element);
    const std::size_t value = length_at(0, property, element);
    skip(size_of(property.count_type));
    return value;
  }

  // The length of a list that begins `offset` bytes ahead, where its count is known to be within the file.
  std::size_t length_at(std::size_t offset, const Property& property, const Element& element) const {
    const double value = read_binary(data() + offset, property.count_type, swapped_);
    const std::size_t most = (left() - offset - size_of(property.count_type)) / size_of(property.type);
    if (!(value >= 0) || value > static_cast<double>(most)) {
      fail_length(bytes_, position_ + offset, kAscii, name_, element, value);
    }
    return static_cast<std::size_t>(value);
  }

  // The items of a list whose length was just read.
  void indices(const Property& property, std::size_t count, const Element&, std::vector<std::int64_t>& items) {
    items.resize(count);
    visit_type(property.type, [&](auto value) {
      const char* from = skip(count * sizeof value);
      for (std::size_t i = 0; i < count; ++i) {
        std::memcpy(&value, from + i * sizeof value, sizeof value);
        if (swapped_) value = swap_bytes(value);
        if constexpr (std::is_floating_point_v<decltype(value)>) {
          if (!is_index(double{value})) fail_index(double{value});
        }
        // NOLINTNEXTLINE(bugprone-signed-char-misuse): a number, no character
        items[i] = static_cast<std::int64_t>(value);
      }
    });
  }

  void skip_list(const Property& property, std::size_t count, const Element&) { skip(count * size_of(property.type)); }

  [[noreturn]] void fail_missing(const Element& element) const;

 private:
  [[noreturn]] void fail_index(double value) const { fail(not_an_index(value)); }

  std::string_view bytes_;
  std::size_t position_;
  bool swapped_;
  const std::string& name_;
};

class TextBody {
 public:
  TextBody(std::string_view bytes, const Layout& layout, const std::string& name)
      : bytes_(bytes), position_(layout.body_begin), name_(name) {}

  static constexpr bool kAscii = true;
  std::size_t position() const { return position_; }
  std::size_t left() const { return bytes_.size() - position_; }
  [[noreturn]] void fail(const std::string& what) const { fail_at_line(name_, bytes_, position_, what); }
  [[noreturn]] void fail_at(std::size_t position, const std::string& what) const {
    fail_at_line(name_, bytes_, position, what);
  }

  void begin_row() { skip_to_token(); }

  // A row may span lines but ends with one. Returns true if the last line has further numbers, which are read over.
  bool end_row();

  double number(StoredType type, const Element& element);
  std::size_t length(const Property& property, const Element& element);

  void indices(const Property& property, std::size_t count, const Element& element, std::vector<std::int64_t>& items);

  void skip_list(const Property& property, std::size_t count, const Element& element) {
    for (std::size_t i = 0; i < count; ++i) number(property.type, element);
  }

  void skip_to_token() {
    while (position_ < bytes_.size() && (is_blank(bytes_[position_]) || is_line_end(bytes_[position_]))) ++position_;
  }

 private:
  std::string_view next_token() const { return bytes_.substr(position_, token_end(bytes_, position_) - position_); }

  std::string_view bytes_;
  std::size_t position_;
  const std::string& name_;
};

}  // namespace knead::io_detail::ply
