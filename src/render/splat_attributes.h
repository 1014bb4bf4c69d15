// What both renderers read from splats, and the constants of their pictures, which are those of Kerbl et al. (2023).
// Internal to render.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::render {

inline constexpr double kSplatBlur = 0.3;            // of a pixel, added to the variance
inline constexpr double kMaxSplatAlpha = 0.99;       // in a pixel
inline constexpr double kMinSplatAlpha = 1.0 / 255;  // below it a splat is not seen
inline constexpr double kNearestSplat = 0.01;        // of the distance to the target: nearer ones are not drawn

// The attributes of a mesh of splats, which must outlive it.
class SplatAttributes {
 public:
  // Throws InvalidInput as splat_degree().
  explicit SplatAttributes(const Mesh& mesh);

  std::size_t degree() const { return degree_; }

  // Returns the opacity from 0 to 1.
  double opacity(std::size_t splat) const;

  // Returns the axes, each as long as its standard deviation.
  std::array<Vec3d, 3> axes(std::size_t splat) const;

  // Returns, for red, green and blue, the part of the colour that is the same in all directions, and the coefficient of
  // a harmonic of degrees 1 to 3.
  double base(std::size_t splat, std::size_t channel) const;
  double harmonic(std::size_t splat, std::size_t channel, std::size_t k) const {
    return harmonics_[channel * harmonics_.size() / 3 + k]->values[splat];
  }

 private:
  std::size_t degree_;
  const Attribute* opacity_;
  std::vector<const Attribute*> sizes_;
  std::vector<const Attribute*> turns_;
  std::vector<const Attribute*> colors_;
  std::vector<const Attribute*> harmonics_;
};

}  // namespace knead::render
