#include "knead/io/spacing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knead/io/float_chars.h"
#include "knead/math/box.h"
#include "knead/mesh/measures.h"

namespace knead::io_detail {
namespace {

constexpr double kCoarse = 0.01;  // of the mean edge

double mean_edge(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t c = 0; c < face.size(); ++c) {
      sum += norm(mesh.positions[face[c]] - mesh.positions[face[(c + 1) % face.size()]]);
    }
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, mesh.corner_vertex.size()));
}

// With three digits.
std::string short_number(double value) {
  char buffer[32];
  const auto result = float_to_chars(buffer, buffer + sizeof buffer, value, kGeneral, 3);
  return {buffer, result.ptr};
}

}  // namespace

std::string spacing_note(const Mesh& mesh) {
  const Box box = shape_box(mesh);
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(box.min[axis]), std::abs(box.max[axis])});
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  const double spacing = std::ldexp(1.0, std::ilogb(largest) - (std::numeric_limits<float>::digits - 1));
  const double diagonal = box.diagonal();
  const double points = std::sqrt(static_cast<double>(mesh.vertex_count()));
  constexpr double finest = 1e-5;  // edges of the diagonal: no mesh of memory's size has a shorter mean
  if (spacing < kCoarse * finest * diagonal) return {};
  const double edge = mesh.face_count() > 0 ? mean_edge(mesh) : diagonal / points;
  if (!(spacing > kCoarse * edge) || !(edge > 0)) return {};
  return "coordinates are floats that lie " + short_number(spacing) + " apart where the shape stands, and its mean " +
         (mesh.face_count() > 0 ? "edge" : "distance") + " is " + short_number(edge) +
         "; move the shape to the origin, or write its coordinates as doubles";
}

}  // namespace knead::io_detail
