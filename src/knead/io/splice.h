// A copy of a text with some of its words replaced.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "knead/io/decimals.h"
#include "knead/io/text.h"
#include "knead/math/vec3.h"

namespace knead::io_detail {

class Splice {
 public:
  // The source must outlive this. Numbers have so many digits after the point, or the shortest form that reads back as
  // the same number.
  explicit Splice(std::string_view source, std::optional<int> decimals = std::nullopt)
      : source_(source), decimals_(decimals) {
    result_.reserve(source.size() + source.size() / 4 + 64);
  }

  // Replaces the components of a point that differ; next_word() gives the word of each, front to back.
  template <class NextWord>
  void replace_changed(const Vec3d& from, const Vec3d& to, NextWord next_word) {
    replace_components(from, to, decimals_, next_word);
  }

  // Does the same for a unit vector.
  template <class NextWord>
  void replace_direction(const Vec3d& from, const Vec3d& to, NextWord next_word) {
    replace_components(from, to, direction_decimals(decimals_), next_word);
  }

  std::string finish() {
    result_.append(source_, copied_);
    return std::move(result_);
  }

  // Replaces one component of a point or of a unit vector.
  void replace_coordinate(std::string_view word, double from, double to) { replace(word, from, to, decimals_); }
  void replace_component(std::string_view word, double from, double to) {
    replace(word, from, to, direction_decimals(decimals_));
  }

 private:
  template <class NextWord>
  void replace_components(const Vec3d& from, const Vec3d& to, std::optional<int> decimals, NextWord next_word) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string_view word = next_word();
      replace(word, from[axis], to[axis], decimals);
    }
  }

  // Where the rounded number is the old one, its spelling stays.
  void replace(std::string_view word, double from, double to, std::optional<int> decimals) {
    if (from == to) return;
    number_.clear();
    append_decimals(number_, to, decimals);
    double rounded = to;
    if (decimals) parse_real(number_, rounded);
    if (rounded == from) return;
    const std::size_t begin = static_cast<std::size_t>(word.data() - source_.data());
    result_.append(source_, copied_, begin - copied_);
    result_ += number_;
    copied_ = begin + word.size();
  }

  std::string_view source_;
  std::optional<int> decimals_;
  std::string number_;
  std::string result_;
  std::size_t copied_ = 0;
};

}  // namespace knead::io_detail
