#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "knead/math/error.h"
#include "knead/mesh/edges.h"
#include "knead/mesh/measures.h"
#include "knead/remesh/remesh.h"

namespace knead {

namespace {

void require(bool good, const char* key, const std::string& expected, double value) {
  if (good) return;
  throw InvalidInput("\"" + std::string(key) + "\" must be " + expected + ", got " + std::to_string(value));
}

void require_length(const std::optional<double>& value, const char* key) {
  if (value) require(std::isfinite(*value) && *value > 0, key, "a length greater than 0", *value);
}

// Returns the lengths of all edges, ascending.
std::vector<double> edge_lengths(const Mesh& mesh) {
  std::vector<double> lengths;
  for_each_edge(mesh, [&](std::span<const EdgeUse> uses) {
    lengths.push_back(norm(mesh.positions[uses[0].high] - mesh.positions[uses[0].low]));
  });
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

}  // namespace

void validate(const RemeshSettings& settings) {
  require_length(settings.max_edge, "max_edge");
  if (settings.max_angle_deg) {
    const double angle = *settings.max_angle_deg;
    require(angle > 0 && angle <= 180, "max_angle_deg", "an angle greater than 0 and at most 180", angle);
  }
  if (settings.max_chord) {
    const double chord = *settings.max_chord;
    require(chord > 0 && chord < 1, "max_chord", "a fraction of the box diagonal between 0 and 1", chord);
  }
  if (settings.min_edge) {
    require(std::isfinite(*settings.min_edge) && *settings.min_edge >= 0, "min_edge", "a length of 0 or more",
            *settings.min_edge);
  }
  if (settings.iterations) {
    require(*settings.iterations >= 0 && *settings.iterations <= 100, "iterations", "a whole number from 0 to 100",
            *settings.iterations);
  }
  if (settings.max_vertices) {
    require(*settings.max_vertices >= 1 && *settings.max_vertices <= kMostVertices, "max_vertices",
            "a whole number from 1 to " + std::to_string(kMostVertices), static_cast<double>(*settings.max_vertices));
  }
  if (settings.min_edge && settings.max_edge) {
    require(*settings.min_edge <= 0.5 * *settings.max_edge, "min_edge", "at most half of \"max_edge\"",
            *settings.min_edge);
  }
}

RemeshTargets resolve(const RemeshSettings& settings, const Mesh& mesh) {
  validate(settings);
  validate(mesh);
  const double diagonal = shape_box(mesh).diagonal();
  RemeshTargets targets;
  targets.max_angle = settings.max_angle_deg.value_or(kDefaultMaxAngleDeg) * std::numbers::pi / 180;
  targets.max_chord = settings.max_chord.value_or(kDefaultMaxChord) * diagonal;
  targets.iterations = settings.iterations.value_or(kDefaultRemeshIterations);
  targets.max_vertices = settings.max_vertices.value_or(
      std::clamp(kDefaultGrowth * mesh.vertex_count(), kDefaultMaxVertices, kMostVertices));
  targets.diagonal = diagonal;
  double mean = diagonal;
  double long_one = diagonal;
  if (const std::vector<double> lengths = edge_lengths(mesh); !lengths.empty()) {
    mean = 0;
    for (const double length : lengths) mean += length / static_cast<double>(lengths.size());
    long_one = lengths[lengths.size() - 1 - lengths.size() / 20];
  }
  targets.max_edge = settings.max_edge.value_or(2 * long_one);
  targets.min_edge = settings.min_edge.value_or(std::min(mean, targets.max_edge) / 4);
  if (!settings.max_edge) targets.max_edge = std::max(targets.max_edge, 2 * targets.min_edge);
  return targets;
}

}  // namespace knead
