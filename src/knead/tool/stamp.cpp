#include "knead/tool/check.h"
#include "knead/tool/tools.h"

namespace knead::tool_detail {

void validate(const StampStroke& stroke) {
  require_count("path", stroke.path.size(), 2, "points");
  require_finite("path", stroke.path);
  if (stroke.outer) require_positive("outer", *stroke.outer);
  if (stroke.step) require_positive("step", *stroke.step);
}

void warn(const StampStroke& /*stroke*/, Warnings& /*warnings*/) {}

}  // namespace knead::tool_detail
