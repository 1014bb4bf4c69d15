// PLY, ascii and binary: reading, writing back, writing anew.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

ShapeFile parse_ply(std::string bytes, const std::string& name);

// The source with other positions and normals (one per vertex; empty: none, or left as they are).
std::string rewrite_ply(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                        const WriteOptions& options);

// A new binary little-endian file.
std::string generate_ply(const Mesh& mesh, const WriteOptions& options);

// What generate_ply leaves out, a sentence each.
std::vector<std::string> ply_losses(const Mesh& mesh);

// What a file made of the source's mesh alone leaves out.
std::vector<std::string> ply_source_losses(const ShapeFile& source);

}  // namespace knead
