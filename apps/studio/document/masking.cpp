// Masks: their values on the vertices, brushes, and the strokes that they become.
#include "document/document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace knead::studio {

namespace {

constexpr std::uint8_t kMasked = 255;

bool is_renumbered(const ShapeState& state) { return state.provenance != nullptr && state.provenance->is_renumbered; }

std::uint8_t byte_of(double value) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0))); }

const MaskStroke* latest_mask(std::span<const std::shared_ptr<const HistoryEntry>> history) {
  for (std::size_t i = history.size(); i-- > 0;) {
    const std::vector<SessionStroke>& strokes = history[i]->strokes;
    for (std::size_t k = strokes.size(); k-- > 0;) {
      if (const auto* mask = std::get_if<MaskStroke>(&strokes[k].stroke)) return mask;
    }
  }
  return nullptr;
}

std::uint8_t value_of(const MaskStroke& mask, std::size_t item) {
  return mask.values.empty() ? kMasked : byte_of(mask.values[item]);
}

void take_vertices(const MaskStroke& mask, MaskValues& values) {
  for (std::size_t i = 0; i < mask.vertices.size(); ++i) {
    const VertexRange& range = mask.vertices[i];
    for (std::size_t v = range.first; v <= range.last && v < values.size(); ++v) values[v] = value_of(mask, i);
  }
}

// A vertex has the value of a masked point in its cell of the mask's grid.
void take_points(const MaskStroke& mask, const Snapshot& positions, MaskValues& values) {
  const double cell = *mask.width / 8;
  const auto place = [&](const Vec3d& p) {
    return std::array<long, 3>{std::lround(std::floor(p.x / cell)), std::lround(std::floor(p.y / cell)),
                               std::lround(std::floor(p.z / cell))};
  };
  std::map<std::array<long, 3>, std::uint8_t> cells;
  for (std::size_t i = 0; i < mask.points.size(); ++i) {
    std::uint8_t& value = cells[place(mask.points[i])];
    value = std::max(value, value_of(mask, i));
  }
  for (std::size_t v = 0; v < values.size(); ++v) {
    const auto found = cells.find(place(positions[v]));
    if (found != cells.end()) values[v] = std::max(values[v], found->second);
  }
}

// Of each vertex and its neighbours: their mean (a neighbour counts once for each face that shares the edge), the
// greatest or the smallest.
MaskValues filtered(const MaskValues& values, MaskEdit edit, const Mesh& mesh) {
  MaskValues result = values;
  std::vector<std::uint32_t> sum(values.begin(), values.end());
  std::vector<std::uint32_t> count(values.size(), 1);
  const auto add = [&](std::uint32_t to, std::uint32_t from) {
    sum[to] += values[from];
    ++count[to];
    if (edit == MaskEdit::grow) result[to] = std::max(result[to], values[from]);
    if (edit == MaskEdit::shrink) result[to] = std::min(result[to], values[from]);
  };
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::uint32_t next = face[(i + 1) % face.size()];
      add(face[i], next);
      add(next, face[i]);
    }
  }
  if (edit != MaskEdit::blur) return result;
  for (std::size_t v = 0; v < values.size(); ++v) {
    result[v] = static_cast<std::uint8_t>((sum[v] + count[v] / 2) / count[v]);
  }
  return result;
}

}  // namespace

MaskValues mask_values(std::span<const std::shared_ptr<const HistoryEntry>> history, const ShapeState& state) {
  const MaskStroke* mask = latest_mask(history);
  if (mask == nullptr || is_empty(*mask)) return {};
  MaskValues values(state.positions.size());
  const bool renumbered = is_renumbered(state);
  if (!renumbered) take_vertices(*mask, values);
  take_points(*mask, state.positions, values);
  for (std::size_t v = 0; renumbered && v < values.size(); ++v) {
    if (state.mask.holds(state.positions[v])) values[v] = kMasked;
  }
  return values;
}

MaskStroke mask_stroke(const MaskValues& values, const ShapeState& state, double width) {
  MaskStroke stroke;
  std::vector<double> numbers;
  for (std::uint32_t v = 0; v < values.size();) {
    std::uint32_t end = v + 1;
    while (end < values.size() && values[end] == values[v]) ++end;
    if (values[v] > 0) {
      stroke.vertices.push_back({v, end - 1});
      numbers.push_back(values[v] / 255.0);
    }
    v = end;
  }
  if (stroke.vertices.empty()) return {};
  const bool is_soft = std::any_of(numbers.begin(), numbers.end(), [](double value) { return value < 1; });
  if (is_soft) stroke.values = std::move(numbers);
  stroke.width = width;
  if (!is_renumbered(state)) return stroke;
  MaskStroke by_points;
  by_points.width = width;
  std::vector<Vec3d> points;
  std::vector<double> point_values;
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (values[v] == 0) continue;
    points.push_back(state.positions[v]);
    point_values.push_back(values[v] / 255.0);
  }
  for (const std::uint32_t i : representative_points(points, point_values, width)) {
    by_points.points.push_back(points[i]);
    if (is_soft) by_points.values.push_back(point_values[i]);
  }
  return by_points;
}

std::optional<MaskEdit> mask_edit(std::string_view word) {
  constexpr std::array<std::string_view, 6> words{"fill", "clear", "invert", "blur", "grow", "shrink"};
  const auto* const found = std::find(words.begin(), words.end(), word);
  if (found == words.end()) return std::nullopt;
  return static_cast<MaskEdit>(found - words.begin());
}

MaskValues changed(MaskValues values, MaskEdit edit, const Mesh& mesh) {
  values.resize(mesh.vertex_count());
  switch (edit) {
    case MaskEdit::fill:
      std::fill(values.begin(), values.end(), kMasked);
      return values;
    case MaskEdit::clear:
      return {};
    case MaskEdit::invert:
      for (std::uint8_t& value : values) value = static_cast<std::uint8_t>(kMasked - value);
      return values;
    case MaskEdit::blur:
    case MaskEdit::grow:
    case MaskEdit::shrink:
      return filtered(values, edit, mesh);
  }
  return values;
}

void paint(const MaskBrush& brush, const Snapshot& positions, MaskValues& values) {
  values.resize(positions.size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    const double distance = norm(positions[v] - brush.center);
    if (distance >= brush.outer) continue;
    const double s = std::clamp((brush.outer - distance) / (brush.outer - brush.inner), 0.0, 1.0);
    const std::uint8_t strength = byte_of(s * s * (3 - 2 * s));
    values[v] = brush.erases ? std::min(values[v], static_cast<std::uint8_t>(kMasked - strength))
                             : std::max(values[v], strength);
  }
}

void fill(std::span<const Pixel> line, const Screen& screen, bool erases, const Snapshot& positions,
          MaskValues& values) {
  if (line.size() < 3) return;
  values.resize(positions.size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    const std::optional<Pixel> seen = pixel_of(screen, positions[v]);
    if (seen && is_within(line, *seen)) values[v] = erases ? 0 : kMasked;
  }
}

}  // namespace knead::studio
