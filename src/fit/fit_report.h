// Distances, volumes and crossings of fits. Internal to the fit module.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "knead/fit.h"
#include "knead/mesh.h"
#include "knead/stroke.h"

namespace knead::detail {

// A surface or a cloud.
struct MeasuredShape {
  std::span<const Vec3d> positions;
  std::span<const Triangle> triangles;
};

// Returns a tree over its triangles, or over its points if it has none.
SurfaceTree tree_of(const MeasuredShape& shape);

// How shapes are measured.
struct Measuring {
  double length = 1;            // distances are relative to it
  std::size_t max_samples = 0;  // vertices of each shape that are measured, evenly through the list; 0: all
  int threads = 0;
  Progress* progress = nullptr;
};

// Returns the distance of two shapes. Throws Cancelled.
FitDistance distance_of(const MeasuredShape& a, const MeasuredShape& b, const SurfaceTree& of_b,
                        const Measuring& measuring);

// Returns the mean distance of the positions from another shape. Throws Cancelled.
double mean_distance(std::span<const Vec3d> from, const SurfaceTree& to, const Measuring& measuring);

// Reverses the triangles of a closed mesh whose faces look inward. Returns true if it reversed them.
bool turn_outward(const Mesh& mesh, std::vector<Triangle>& triangles, int threads);

// Returns the volume of a mesh with these positions; nothing unless it is closed and oriented.
std::optional<double> volume_of(const Mesh& mesh, std::span<const Vec3d> positions, int threads);

// Returns now / before - 1; nothing if one is unknown.
std::optional<double> relative(const std::optional<double>& now, const std::optional<double>& before);

// Returns the mean length of the edges; there is at least one triangle.
double mean_edge(std::span<const Triangle> triangles, std::span<const Vec3d> positions);

// Returns the number of new crossing pairs that are allowed: 1% of those of a scan that crosses itself everywhere; else
// 0.
inline std::size_t max_new_crossings(std::size_t own) { return own < 1000 ? 0 : own / 100; }

// Adds the distances of landmarks from their targets. `at`: the position of each.
void add_landmarks(std::span<const Vec3d> at, std::span<const FitPair> pairs, double diagonal, BodyFitReport& report);

// Returns the median distance of points from the targets of their pairs; 0 without pairs.
double median_distance(std::span<const Vec3d> at, std::span<const FitPair> pairs);

// The least and greatest factor by which volumes change.
struct GrowthRange {
  double least = 1;
  double greatest = 1;
};

// Returns the range of the strokes at `measuring.max_samples` evenly spread points. `measuring.length`: the diagonal.
// Throws Cancelled.
GrowthRange growth_range(std::span<const Stroke> strokes, const std::vector<Vec3d>& points, const Measuring& measuring);

}  // namespace knead::detail
