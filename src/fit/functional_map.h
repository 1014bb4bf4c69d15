// Eigenfunctions of surfaces' Laplacians, and maps between surfaces that respect them. Internal to the fit module.
//
// Functional maps of Ovsjanikov et al. 2012, from wave kernel signatures (Aubry et al. 2011) of all points and of
// seeds, refined by ZoomOut (Melzi et al. 2019). Nearly isometric surfaces are mapped to within a few per cent of
// their size; where a surface is symmetric, the seeds decide.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/fit.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail {

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

// A surface, its unit normals and eigenfunctions.
struct SpectralSurface {
  std::vector<Vec3d> positions;  // of the nodes
  std::vector<Vec3d> normals;
  Spectrum spectrum;
};

// The number of eigenfunctions that maps use.
inline constexpr std::size_t kMapFunctions = 120;

// Returns the surface; nothing where it has no such functions. Time and errors as for spectrum_of().
std::optional<SpectralSurface> spectral_surface(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                                const Progress* progress);

// A map of evenly spread points.
struct SurfaceMap {
  std::vector<FitPair> pairs;
  double quality = 0;  // 1: an isometry that keeps the orientation; below kMinMapQuality: no good map
};

inline constexpr double kMinMapQuality = 0.3;

// Returns the map that begins with these seeds, pairs of points. If `sketches`, only its quality is found, from few
// functions. Time: 1.5 s, for a sketch 0.1 s. Throws Cancelled.
SurfaceMap functional_map(const SpectralSurface& source, const SpectralSurface& target, std::span<const FitPair> seeds,
                          bool sketches, int threads, const Progress* progress);

}  // namespace knead::detail
