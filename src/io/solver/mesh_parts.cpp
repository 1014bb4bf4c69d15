// The patches and cells of solvers' meshes (read_patches, read_cells), with the files that lie beside OpenFOAM's
// points.
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "io/solver/solver.h"
#include "knead/cells.h"
#include "knead/error.h"
#include "knead/io.h"

namespace knead {
namespace {

namespace solver = detail::solver;
namespace fs = std::filesystem;

// A file, or its compressed form; empty: neither is there.
fs::path existing(const fs::path& file) {
  std::error_code error;
  if (fs::exists(file, error)) return file;
  const fs::path compressed = file.string() + std::string(detail::kGzip);
  return fs::exists(compressed, error) ? compressed : fs::path();
}

// The time that names a folder of OpenFOAM; nothing for another name.
std::optional<double> time_of(const fs::path& name) {
  double time = 0;
  const bool is_time = detail::parse_real(name.string(), time) == detail::ParseResult::ok;
  return is_time ? std::optional(time) : std::nullopt;
}

// Where a mesh moves, each time has its points: the other files are those of the last time before it that has them, or
// of `constant`. Returns the path of such a file, of a mesh whose folder is given; empty: there is none.
fs::path file_of_earlier_time(const fs::path& mesh, const char* name) {
  std::error_code error;
  fs::path folder = fs::absolute(mesh, error).lexically_normal();
  fs::path within;  // the time's folder, e.g. polyMesh, or region/polyMesh
  while (folder.has_relative_path() && !time_of(folder.filename())) {
    within = within.empty() ? folder.filename() : folder.filename() / within;
    folder = folder.parent_path();
  }
  const std::optional<double> now = time_of(folder.filename());
  if (!now) return {};
  fs::path best = existing(folder.parent_path() / "constant" / within / name);
  std::optional<double> latest;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.parent_path(), error)) {
    const std::optional<double> time = time_of(entry.path().filename());
    if (!time || *time >= *now || (latest && *time <= *latest)) continue;
    const fs::path file = existing(entry.path() / within / name);
    if (file.empty()) continue;
    latest = time;
    best = file;
  }
  return best;
}

// Returns the bytes of a file beside another one, or of an earlier time, which may be compressed.
std::string read_beside(const fs::path& path, const char* name) {
  fs::path file = existing(path.parent_path() / name);
  if (file.empty()) file = file_of_earlier_time(fs::absolute(path).parent_path(), name);
  if (!file.empty()) return detail::bytes_of_file(file);
  throw IoError(IoError::Operation::read, path.string(),
                "the file " + std::string(name) +
                    " of its mesh is neither beside it nor in constant/polyMesh of its case; copy it beside it");
}

void require_points(std::span<const std::uint32_t> numbers, std::size_t points, const std::string& path,
                    const std::string& what) {
  if (std::all_of(numbers.begin(), numbers.end(), [&](std::uint32_t i) { return i < points; })) return;
  throw InvalidInput(Place{path}, what + " has points that the mesh lacks");
}

}  // namespace

std::vector<Patch> read_patches(const std::filesystem::path& path, const ShapeFile& shape) {
  std::vector<Patch> patches;
  if (shape.format == detail::su2_codec.name) {
    patches = solver::su2_patches(shape.bytes, path.string(), shape.mesh.vertex_count());
  } else if (shape.format == detail::gmsh_codec.name) {
    patches = solver::gmsh_patches(shape.bytes, path.string());
  } else if (shape.format == detail::foam_codec.name) {
    const std::string faces = read_beside(path, "faces");
    const std::string boundary = read_beside(path, "boundary");
    patches = solver::foam_patches(boundary, faces, path.parent_path().string());
  }
  for (Patch& patch : patches) {
    std::sort(patch.points.begin(), patch.points.end());
    patch.points.erase(std::unique(patch.points.begin(), patch.points.end()), patch.points.end());
    require_points(patch.points, shape.mesh.vertex_count(), path.string(), "the patch " + patch.name);
  }
  return patches;
}

VolumeCells read_cells(const std::filesystem::path& path, const ShapeFile& shape) {
  VolumeCells cells;
  if (shape.format == detail::su2_codec.name) {
    cells = solver::su2_cells(shape.bytes, path.string(), shape.mesh.positions);
  } else if (shape.format == detail::gmsh_codec.name) {
    cells = solver::gmsh_cells(shape.bytes, path.string(), shape.mesh.positions);
  } else if (shape.format == detail::foam_codec.name) {
    cells = solver::foam_cells(read_beside(path, "faces"), read_beside(path, "owner"), read_beside(path, "neighbour"),
                               path.parent_path().string());
  }
  if (cells.is_flat) return cells;  // whose numbers were looked at when they were added
  require_points(cells.cells.corners, shape.mesh.vertex_count(), path.string(), "a cell");
  require_points(cells.on_surfaces, shape.mesh.vertex_count(), path.string(), "a face");
  require_points(cells.middles.points, shape.mesh.vertex_count(), path.string(), "a cell");
  for (const std::vector<std::uint32_t>& faces : cells.polyhedra) {
    for (std::size_t at = 0; at < faces.size(); at += faces[at] + std::size_t{1}) {
      require_points(std::span(faces).subspan(at + 1, faces[at]), shape.mesh.vertex_count(), path.string(), "a cell");
    }
  }
  return cells;
}

VolumeCells cells_to_judge(const std::filesystem::path& path, const ShapeFile& shape, bool are_needed,
                           std::vector<std::string>& notes) {
  VolumeCells cells;
  try {
    cells = read_cells(path, shape);
  } catch (const std::exception& error) {
    if (are_needed) throw;
    notes.push_back(fmt::format("the cells are not judged: {}", error.what()));
  }
  if (cells.by_corners > 0) {
    notes.push_back(fmt::format("{}: {} {} of the third order or above: judged by their corners", path.string(),
                                cells.by_corners, cells.by_corners == 1 ? "cell" : "cells"));
  }
  return cells;
}

}  // namespace knead
