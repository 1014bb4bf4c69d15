// Where the numbers of a file are: what a format's reader leaves for its writer.
#pragma once

#include <any>
#include <memory>
#include <utility>

#include "knead/io/shape_file.h"

namespace knead::io_detail {

// Holds the Layout type of the format that read the file, e.g. ply::Layout.
struct AnyLayout {
  std::any value;
};

template <class FormatLayout>
void set_layout(ShapeFile& shape, FormatLayout layout) {
  shape.layout = std::make_shared<const AnyLayout>(AnyLayout{std::move(layout)});
}

// Returns null for a shape of another format.
template <class FormatLayout>
const FormatLayout* find_layout(const ShapeFile& shape) {
  return shape.layout == nullptr ? nullptr : std::any_cast<FormatLayout>(&shape.layout->value);
}

// The layout of a shape that this format's reader has made; any other shape is an error of the caller,
// std::bad_any_cast.
template <class FormatLayout>
const FormatLayout& layout_of(const ShapeFile& shape) {
  if (const FormatLayout* layout = find_layout<FormatLayout>(shape)) return *layout;
  throw std::bad_any_cast();
}

}  // namespace knead::io_detail
