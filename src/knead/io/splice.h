// A copy of a text with some of its words replaced.
#pragma once

#include <string>
#include <string_view>

#include "knead/io/text.h"
#include "knead/math/vec3.h"

namespace knead::io_detail {

class Splice {
 public:
  // The source must outlive this.
  explicit Splice(std::string_view source) : source_(source) {
    result_.reserve(source.size() + source.size() / 4 + 64);
  }

  // Replaces a word of the source, front to back, by the shortest decimal that reads back as the same number.
  void replace(std::string_view word, double value) {
    const std::size_t begin = static_cast<std::size_t>(word.data() - source_.data());
    result_.append(source_, copied_, begin - copied_);
    append_real(result_, value);
    copied_ = begin + word.size();
  }

  // Replaces the components of a vector that differ; next_word() gives the word of each.
  template <class NextWord>
  void replace_changed(const Vec3d& from, const Vec3d& to, NextWord next_word) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string_view word = next_word();
      if (from[axis] != to[axis]) replace(word, to[axis]);
    }
  }

  std::string finish() {
    result_.append(source_, copied_);
    return std::move(result_);
  }

 private:
  std::string_view source_;
  std::string result_;
  std::size_t copied_ = 0;
};

}  // namespace knead::io_detail
