// What both renderers read from splats, and the constants of their pictures, which are those of Kerbl et al. (2023).
// Internal to render.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/elementary.h"

namespace knead::render {

inline constexpr double kSplatBlur = 0.3;            // of a pixel, added to the variance
inline constexpr double kMaxSplatAlpha = 0.99;       // in a pixel
inline constexpr double kMinSplatAlpha = 1.0 / 255;  // below it a splat is not seen
inline constexpr double kNearestSplat = 0.01;        // of the distance to the target: nearer ones are not drawn

// The attributes of a mesh of splats, which must outlive it.
class SplatAttributes {
 public:
  // Throws InvalidInput as splat_degree().
  explicit SplatAttributes(const Mesh& mesh)
      : degree_(splat_degree(mesh)),
        opacity_(mesh.find_attribute("opacity")),
        sizes_(find(mesh, "scale_", 3)),
        turns_(find(mesh, "rot_", 4)),
        colors_(find(mesh, "f_dc_", 3)),
        harmonics_(find(mesh, "f_rest_", 3 * degree_ * (degree_ + 2))) {}

  std::size_t degree() const { return degree_; }

  // Returns the opacity from 0 to 1.
  double opacity(std::size_t splat) const {
    constexpr double kWithoutOpacity = 50;  // as the logarithm of the odds: opaque
    const double logit = opacity_ == nullptr ? kWithoutOpacity : opacity_->values[splat];
    return elementary::sigmoid(std::clamp(logit, -80.0, 80.0));
  }

  // Returns the axes, each as long as its standard deviation.
  std::array<Vec3d, 3> axes(std::size_t splat) const {
    std::array<double, 4> turn{};
    for (std::size_t i = 0; i < 4; ++i) turn[i] = turns_[i]->values[splat];
    std::array<Vec3d, 3> axes = splat_axes(turn);
    for (std::size_t i = 0; i < 3; ++i) {
      axes[i] = axes[i] * elementary::exp(std::min(sizes_[i]->values[splat], 80.0));
    }
    return axes;
  }

  // Returns, for red, green and blue, the part of the colour that is the same in all directions, and the coefficient of
  // a harmonic of degrees 1 to 3.
  double base(std::size_t splat, std::size_t channel) const {
    constexpr double kDegreeZero = 0.28209479177387814;  // the spherical harmonic, 1 / sqrt(4 pi)
    return colors_[channel] == nullptr ? 0.5 : 0.5 + kDegreeZero * colors_[channel]->values[splat];
  }
  double harmonic(std::size_t splat, std::size_t channel, std::size_t k) const {
    return harmonics_[channel * harmonics_.size() / 3 + k]->values[splat];
  }

 private:
  static std::vector<const Attribute*> find(const Mesh& mesh, const char* name, std::size_t count) {
    std::vector<const Attribute*> found;
    for (std::size_t i = 0; i < count; ++i) found.push_back(mesh.find_attribute(name + std::to_string(i)));
    return found;
  }

  std::size_t degree_;
  const Attribute* opacity_;
  std::vector<const Attribute*> sizes_;
  std::vector<const Attribute*> turns_;
  std::vector<const Attribute*> colors_;
  std::vector<const Attribute*> harmonics_;
};

}  // namespace knead::render
