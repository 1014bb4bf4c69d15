// The cursor on the surface: where a tool's outer region ends, a solid ring, and its inner region, a dashed one.
#pragma once

#include <cstdint>
#include <vector>

#include "knead/render.h"
#include "studio.h"

namespace knead::studio {

// Remembers the rings while nothing changes.
class SurfaceCursor {
 public:
  // Adds the rings where the pointer is, or during a drag where the tool is, each with its images. Adds nothing for
  // tools that are placed, or where there is no surface.
  void add_lines(const Studio& studio, std::vector<render::Line>& lines);

 private:
  struct Rings {
    std::vector<Vec3d> outer;  // closed, without repeating the first point
    std::vector<Vec3d> inner;
  };
  struct Key {
    Vec3d point;
    Vec3d normal;
    double outer = 0;
    double inner = 0;
    std::uint64_t version = 0;

    friend bool operator==(const Key&, const Key&) = default;
  };

  Key key_;
  Rings rings_;
};

}  // namespace knead::studio
