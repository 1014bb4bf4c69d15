// In the place of renderer.cpp on pages, which draw the live view only.
#include "knead/gl.h"
#include "knead/render.h"

namespace knead::render {

Image render(const Scene& /*scene*/, const Options& /*options*/) {
  throw GpuError("a page draws no posters; use Studio on the desktop, or knead render");
}

}  // namespace knead::render
