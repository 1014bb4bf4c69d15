// Sizes, turns, opacities and colours of splats.
#include "render/splat_attributes.h"

#include <algorithm>
#include <string>

#include "knead/splats.h"
#include "math/elementary.h"

namespace knead::render {
namespace {

constexpr double kDegreeZero = 0.28209479177387814;  // the spherical harmonic, 1 / sqrt(4 pi)
constexpr double kWithoutOpacity = 50;               // as the logarithm of the odds: opaque

std::vector<const Attribute*> find(const Mesh& mesh, const char* name, std::size_t count) {
  std::vector<const Attribute*> found;
  for (std::size_t i = 0; i < count; ++i) found.push_back(mesh.find_attribute(name + std::to_string(i)));
  return found;
}

}  // namespace

SplatAttributes::SplatAttributes(const Mesh& mesh)
    : degree_(splat_degree(mesh)),
      opacity_(mesh.find_attribute("opacity")),
      sizes_(find(mesh, "scale_", 3)),
      turns_(find(mesh, "rot_", 4)),
      colors_(find(mesh, "f_dc_", 3)),
      harmonics_(find(mesh, "f_rest_", 3 * degree_ * (degree_ + 2))) {}

double SplatAttributes::opacity(std::size_t splat) const {
  const double logit = opacity_ == nullptr ? kWithoutOpacity : opacity_->values[splat];
  return 1 / (1 + elementary::exp(-std::clamp(logit, -80.0, 80.0)));
}

std::array<Vec3d, 3> SplatAttributes::axes(std::size_t splat) const {
  std::array<double, 4> turn{};
  for (std::size_t i = 0; i < 4; ++i) turn[i] = turns_[i]->values[splat];
  std::array<Vec3d, 3> axes = splat_axes(turn);
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i] = axes[i] * elementary::exp(std::min(sizes_[i]->values[splat], 80.0));
  }
  return axes;
}

double SplatAttributes::base(std::size_t splat, std::size_t channel) const {
  return colors_[channel] == nullptr ? 0.5 : 0.5 + kDegreeZero * colors_[channel]->values[splat];
}

}  // namespace knead::render
