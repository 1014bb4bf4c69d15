// How the shape is drawn: what Studio remembers from one start to the next.
#pragma once

#include <string>

#include "knead/render.h"

namespace knead::studio {

struct Look {
  render::Material material = render::Material::clay;
  render::Matcap matcap = render::Matcap::terracotta;
  render::Relief relief;
  std::string background = "gradient";  // as render::background_named
  render::Projection projection = render::Projection::perspective;
  double field_of_view_deg = 30;

  friend bool operator==(const Look&, const Look&) = default;
};

}  // namespace knead::studio
