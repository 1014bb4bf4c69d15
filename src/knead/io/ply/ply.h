// PLY (Turk 1994), text and binary: its row of the format table (formats.h). A new file is binary, little-endian.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/decimals.h"
#include "knead/io/new_mesh.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail::ply {

ShapeFile parse(std::string bytes, const std::string& name);
bool is_binary(const ShapeFile& source);
std::optional<ShapeSummary> summarize(std::string_view bytes, const std::string& name);
void rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
             const WriteOptions& options, const std::function<void(std::string_view)>& out);
std::string generate(const Mesh& mesh, const WriteOptions& options);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
std::string remeshed(const NewMesh& shape, const WriteOptions& options);
std::vector<std::string> remesh_losses(const ShapeFile& source);
bool reads_floats(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);

}  // namespace knead::io_detail::ply
