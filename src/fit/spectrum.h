// The lowest eigenfunctions of a surface's Laplacian. Internal to the fit module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::fit_detail {

// Eigenfunctions of the Laplacian of the largest piece of a surface, whose area counts as 1. A surface with many
// vertices is represented by 4,000 of them, with the triangles of their regions' corners.
struct Spectrum {
  std::vector<std::uint32_t> vertices;         // of the shape: the nodes
  std::vector<Triangle> triangles;             // between nodes
  std::vector<double> mass;                    // of each node; 1 together
  std::vector<double> values;                  // ascending
  std::vector<std::vector<double>> functions;  // one for each eigenvalue, with a number for each node; orthonormal

  std::size_t size() const { return vertices.size(); }
};

// Returns `count` eigenfunctions, by Lanczos' method on the inverse; nothing if the surface has too few nodes or no
// piece with most of its area. Time: about 1 s. The bits depend on the arguments alone. Throws Cancelled.
std::optional<Spectrum> spectrum_of(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                    std::size_t count, const Progress* progress);

}  // namespace knead::fit_detail
