#include <algorithm>
#include <array>

#include "command.h"
#include "interrupt.h"
#include "knead/certify.h"
#include "knead/io.h"
#include "panels.h"
#include "progress_bar.h"

namespace knead::command {
namespace {

// From the renderer's clay to dark red, ever darker.
constexpr std::array<Vec3d, 5> kColors{
    {{0.80, 0.755, 0.70}, {0.97, 0.80, 0.42}, {0.93, 0.52, 0.20}, {0.76, 0.22, 0.14}, {0.42, 0.04, 0.10}}};

Vec3d color_at(double part) {
  const double at = std::clamp(part, 0.0, 1.0) * (kColors.size() - 1);
  const std::size_t first = std::min(static_cast<std::size_t>(at), kColors.size() - 2);
  return kColors[first] + (kColors[first + 1] - kColors[first]) * (at - static_cast<double>(first));
}

Attribute colors_of(const std::vector<double>& distances, double greatest) {
  Attribute colors{"color", Domain::vertex, NumberType::float32, 3, {}};
  for (const double distance : distances) {
    const Vec3d color = color_at(greatest > 0 ? distance / greatest : 0);
    colors.values.insert(colors.values.end(), {color.x, color.y, color.z});
  }
  return colors;
}

std::vector<std::vector<double>> distances_of(const std::vector<Panel>& panels, const Mesh& target, bool quiet) {
  Progress progress;
  const CancelOnInterruption cancel(progress);
  for (const Panel& panel : panels) progress.total += panel.shape.vertex_count();
  const ProgressBar bar(progress, progress.total, !quiet);
  std::vector<std::vector<double>> distances;
  try {
    for (const Panel& panel : panels) distances.push_back(vertex_distances(panel.shape, target, 0, &progress));
  } catch (const Cancelled&) {
    throw Interrupted{};
  }
  return distances;
}

}  // namespace

double color_by_distance(const DistanceColors& colors, bool quiet, std::vector<Panel>& panels) {
  const std::vector<std::vector<double>> distances = distances_of(panels, read_shape(colors.shape).mesh, quiet);
  double greatest = 0;
  for (const std::vector<double>& own : distances) {
    for (const double distance : own) greatest = std::max(greatest, distance);
  }
  greatest = colors.greatest.value_or(greatest);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    std::vector<Attribute>& attributes = panels[i].shape.attributes;
    std::erase_if(attributes, [](const Attribute& attribute) { return attribute.name == "color"; });
    attributes.push_back(colors_of(distances[i], greatest));
  }
  return greatest;
}

}  // namespace knead::command
