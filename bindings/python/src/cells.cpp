// The cells and patches of volume meshes, the quality of cells, and a deformation that keeps it.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.h"
#include "knead/cells.h"
#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "module.h"
#include "options.h"
#include "work.h"

namespace knead::python {

namespace {

using CellArray = py::array_t<std::int64_t, py::array::c_style>;
using MaskArray = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;

using CellRequest = std::tuple<std::optional<double>, double, MaskArray>;  // until, least scaled Jacobian, fixed

CellKind kind_of(const CellArray& cells) {
  constexpr std::array kinds{CellKind::tetrahedron, CellKind::pyramid, CellKind::wedge, CellKind::hexahedron};
  const auto columns = static_cast<std::size_t>(cells.ndim() == 2 ? cells.shape(1) : 0);
  const auto* const kind = std::ranges::find(kinds, columns, corner_count);
  if (kind == kinds.end()) throw InvalidInput("cells must have the shape (m, 4), (m, 5), (m, 6) or (m, 8)");
  return *kind;
}

// Returns the corner if it is a point.
std::uint32_t point_of(std::int64_t corner, std::size_t cell, std::size_t points) {
  if (corner >= 0 && static_cast<std::uint64_t>(corner) < points &&
      corner <= std::numeric_limits<std::uint32_t>::max()) {
    return static_cast<std::uint32_t>(corner);
  }
  throw InvalidInput(fmt::format("cell {} has the corner {}, but there are {} points", cell, corner, points));
}

// Volume, scaled Jacobian and orientation of cells (m, 4), (m, 5), (m, 6) or (m, 8).
py::tuple cell_qualities(const py::object& vertices, const CellArray& cells) {
  const Points points = points_from(vertices, "points");
  const CellKind kind = kind_of(cells);
  const std::size_t columns = corner_count(kind);
  const auto count = static_cast<std::size_t>(cells.shape(0));
  std::vector<double> volume(count);
  std::vector<double> jacobian(count);
  std::vector<std::int8_t> orientation(count);
  Progress progress;
  run_watched(py::none(), progress, [&] {
    parallel_for(count, 4096, 0, [&](std::size_t begin, std::size_t end) {
      std::array<Vec3d, 8> corners;
      for (std::size_t i = begin; i < end && !progress.cancel; ++i) {
        for (std::size_t k = 0; k < columns; ++k) {
          corners[k] = points.span()[point_of(cells.data()[i * columns + k], i, points.span().size())];
        }
        const CellQuality quality = cell_quality(kind, std::span(corners).first(columns));
        volume[i] = quality.volume;
        jacobian[i] = quality.scaled_jacobian;
        orientation[i] = static_cast<std::int8_t>(quality.orientation);
      }
    });
    stop_if_cancelled(&progress);
  });
  return py::make_tuple(array_from(volume), array_from(jacobian), array_from(orientation));
}

Cells cells_from(const std::vector<CellArray>& blocks, std::size_t points) {
  Cells cells;
  for (const CellArray& block : blocks) {
    const CellKind kind = kind_of(block);
    const std::size_t columns = corner_count(kind);
    const std::size_t begin = cells.size();
    const std::size_t end = begin + static_cast<std::size_t>(block.shape(0));
    cells.kinds.resize(end, kind);
    cells.first.resize(end + 1);
    cells.corners.resize(cells.first[begin] + (end - begin) * columns);
    const std::int64_t* corner = block.data();
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t at = cells.first[i];
      for (std::size_t k = 0; k < columns; ++k) cells.corners[at + k] = point_of(*corner++, i, points);
      cells.first[i + 1] = at + columns;
    }
  }
  return cells;
}

// Points (n), edges (n, 2), or faces (n, k), which are cut into triangles.
Patch patch_from(const std::string& name, const CellArray& numbers, std::size_t points) {
  if (numbers.ndim() < 1 || numbers.ndim() > 2 || (numbers.ndim() == 2 && numbers.shape(1) < 2)) {
    throw InvalidInput(fmt::format("the patch \"{}\" must have the shape (n,), (n, 2), (n, 3) ...", name));
  }
  Patch patch{name, {}};
  for (py::ssize_t i = 0; i < numbers.size(); ++i) {
    const std::int64_t number = numbers.data()[i];
    if (number < 0 || static_cast<std::uint64_t>(number) >= points) {
      throw InvalidInput(fmt::format("the patch \"{}\" has the point {}, but there are {}", name, number, points));
    }
    patch.points.push_back(static_cast<std::uint32_t>(number));
  }
  const std::size_t corners = numbers.ndim() == 2 ? static_cast<std::size_t>(numbers.shape(1)) : patch.points.size();
  for (std::size_t first = 0; numbers.ndim() == 2 && first < patch.points.size(); first += corners) {
    const std::span face = std::span(patch.points).subspan(first, corners);
    if (corners == 2) patch.faces.push_back({face[0], face[1], face[1]});
    for (std::size_t k = 2; k < corners; ++k) patch.faces.push_back({face[0], face[k - 1], face[k]});
  }
  std::sort(patch.points.begin(), patch.points.end());
  patch.points.erase(std::unique(patch.points.begin(), patch.points.end()), patch.points.end());
  return patch;
}

VolumeCells flat_cells_from(const std::vector<CellArray>& blocks, std::span<const Vec3d> points) {
  VolumeCells cells;
  for (const CellArray& block : blocks) {
    const auto columns = static_cast<std::size_t>(block.ndim() == 2 ? block.shape(1) : 0);
    if (columns != 3 && columns != 4) {
      throw InvalidInput("cells of a mesh of two dimensions must have the shape (m, 3) or (m, 4)");
    }
    std::array<std::uint32_t, 4> corners{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(block.shape(0)); ++i) {
      for (std::size_t k = 0; k < columns; ++k) corners[k] = point_of(block.data()[i * columns + k], i, points.size());
      add_flat_cell(std::span(corners).first(columns), {}, points, cells);
    }
  }
  return cells;
}

MeshParts parts_from(const std::vector<std::pair<std::string, CellArray>>& patches,
                     const std::vector<CellArray>& blocks, const py::object& vertices, bool is_flat) {
  const Points points = points_from(vertices, "vertices");
  const std::size_t count = points.span().size();
  MeshParts parts;
  std::vector<Patch> named;
  for (const auto& [name, numbers] : patches) named.push_back(patch_from(name, numbers, count));
  parts.patches = [named = std::move(named)] { return named; };
  VolumeCells cells;
  if (is_flat) {
    cells = flat_cells_from(blocks, points.span());
  } else {
    cells.cells = cells_from(blocks, count);
  }
  parts.cells = std::make_shared<const VolumeCells>(std::move(cells));
  return parts;
}

// The file must outlive the result.
MeshParts parts_of_file(const std::filesystem::path& path, const ShapeFile& file) {
  MeshParts parts;
  parts.patches = [path, &file] { return read_patches(path, file); };
  parts.read_cells = [path, &file](bool are_needed, std::vector<std::string>& notes) {
    return cells_to_judge(path, file, are_needed, notes);
  };
  return parts;
}

// Faces (m, 3); edges (m, 2) of a mesh of two dimensions; the points (n) of a patch without faces.
py::dict patches_of(const MeshParts& parts) {
  std::vector<Patch> patches;
  Progress progress;
  run_watched(py::none(), progress, [&] { patches = parts.patches(); });
  py::dict dict;
  for (const Patch& patch : patches) {
    if (patch.faces.empty()) {
      dict[py::str(patch.name)] = array_from(patch.points);
      continue;
    }
    const bool is_flat = std::ranges::all_of(patch.faces, [](const Triangle& face) { return face[1] == face[2]; });
    const std::size_t corners = is_flat ? 2 : 3;
    py::array_t<std::uint32_t> faces({patch.faces.size(), corners});
    std::uint32_t* to = faces.mutable_data();
    for (const Triangle& face : patch.faces) to = std::copy_n(face.begin(), corners, to);
    dict[py::str(patch.name)] = faces;
  }
  return dict;
}

// Non-orthogonality in degrees, skewness and aspect ratio of the cells of all blocks.
py::tuple cell_face_qualities(const py::object& vertices, const std::vector<CellArray>& blocks) {
  const Points points = points_from(vertices, "points");
  CellFaceQuality quality;
  Progress progress;
  run_watched(py::none(), progress, [&] {
    const Cells cells = cells_from(blocks, points.span().size());
    stop_if_cancelled(&progress);
    quality = cell_face_quality(cells, points.span());
  });
  return py::make_tuple(array_from(quality.non_orthogonality_deg), array_from(quality.skewness),
                        array_from(quality.aspect_ratio));
}

py::dict dict_of(const CellSummary& summary) {
  py::dict dict;
  dict["inverted"] = summary.inverted;
  dict["below"] = summary.below;
  dict["least_scaled_jacobian"] = summary.least_scaled_jacobian;
  dict["mean_volume_change"] = summary.mean_volume_change;
  return dict;
}

py::dict report_of(const DeformedCells& deformed) {
  py::dict report;
  report["flow"] = dict_of(deformed.flow);
  report["result"] = dict_of(deformed.result);
  report["freed"] = deformed.freed;
  report["parts"] = deformed.parts;
  return report;
}

// Keeps the status of the first part that fails. All three must outlive the result.
CarryPoints carry_by(const Flow& flow, const AdvectOptions& options, AdvectStatus& status) {
  return [&](double from, double to, std::span<Vec3d> moved) {
    if (status != AdvectStatus::done) return;
    const auto length = static_cast<double>(flow.segments.size());
    const bool is_whole = from == 0 && to == 1;
    status = advect(is_whole ? flow : flow_between(flow, from * length, to * length), moved, options).status;
    stop_if_cancelled(options.progress);
  };
}

// The points and the report; None if the callback ended the work.
py::object deform_cells_by(const py::object& given, const std::vector<CellArray>& blocks, const Session& session,
                           const Accuracy& accuracy, const CellRequest& request, const py::object& callback) {
  const Points points = points_from(given, "points");
  const Cells cells = cells_from(blocks, points.span().size());
  const MotionOptions motion = motion_options(accuracy);
  Progress progress;
  CellOptions options;
  options.least_scaled_jacobian = std::get<1>(request);
  const MaskArray& fixed = std::get<2>(request);
  options.threads = accuracy.threads;
  options.progress = &progress;
  options.fixed = {fixed.data(), static_cast<std::size_t>(fixed.size())};
  DeformedCells deformed;
  AdvectStatus status = AdvectStatus::done;
  const bool is_done = run_watched(callback, progress, [&] {
    const Flow flow = flow_of(session, {Direction::forwards, std::get<0>(request)}, accuracy.threads);
    if (points.span().empty()) return;
    AdvectOptions advection = advect_options(motion, motion.diagonal.value_or(reference_length(points.span())));
    advection.progress = &progress;
    deformed = deform_cells(cells, points.span(), carry_by(flow, advection, status), options);
  });
  if (!is_done) return py::none();
  require_done(status, session, 0);
  py::object moved = array_of(deformed.points);
  if (points.is_float32) moved = moved.attr("astype")("float32");
  return py::make_tuple(moved, report_of(deformed));
}

// None if the callback ended the work.
py::object safe_until_of(const py::object& given, const std::vector<CellArray>& blocks, const Session& session,
                         const Accuracy& accuracy, const std::tuple<bool, std::optional<double>, double>& request,
                         const py::object& callback) {
  const Points points = points_from(given, "points");
  const Cells cells = cells_from(blocks, points.span().size());
  Progress progress;
  SafeCellsOptions options;
  options.part = {std::get<0>(request) ? Direction::backwards : Direction::forwards, std::get<1>(request)};
  options.least_scaled_jacobian = std::get<2>(request);
  options.motion = motion_options(accuracy);
  options.progress = &progress;
  SafeCells safe;
  if (!run_watched(callback, progress, [&] { safe = safe_until(session, cells, points.span(), options); })) {
    return py::none();
  }
  require_done(safe.status, session, 0);
  py::dict found;
  found["until"] = safe.range.until;
  found["beyond"] = safe.range.beyond;
  found["cell"] = safe.cell;
  found["scaled_jacobian"] = safe.cell ? std::optional(safe.scaled_jacobian) : std::nullopt;
  found["outer"] = safe.outer;
  return found;
}

std::optional<double> widest_outer_of(const py::object& given, const std::vector<CellArray>& blocks,
                                      const Session& session) {
  const Points points = points_from(given, "points");
  const Cells cells = cells_from(blocks, points.span().size());
  if (session.strokes.size() != 1) throw InvalidInput("widest_outer needs one stroke");
  std::optional<double> outer;
  Progress progress;
  run_watched(py::none(), progress, [&] {
    std::vector<Vec3d> boundary;
    for (const std::uint32_t v : boundary_points(cells, points.span().size())) boundary.push_back(points.span()[v]);
    outer = widest_outer(session.strokes.front().stroke, boundary);
  });
  return outer;
}

}  // namespace

void add_cells(py::module_& module) {
  py::class_<MeshParts>(module, "MeshParts").def("patches", &patches_of);
  module.def("parts_from", &parts_from);
  module.def("parts_of_file", &parts_of_file, py::keep_alive<0, 2>());
  module.def("cell_qualities", &cell_qualities);
  module.def("cell_face_qualities", &cell_face_qualities);
  module.def("deform_cells", &deform_cells_by);
  module.def("wedges_look_inward", [](const py::object& vertices, const std::vector<CellArray>& blocks) {
    const Points points = points_from(vertices, "points");
    return wedges_look_inward(cells_from(blocks, points.span().size()), points.span());
  });
  module.def("safe_until", &safe_until_of);
  module.def("widest_outer", &widest_outer_of);
}

}  // namespace knead::python
