// Writes a shape whose connectivity has changed to a file that keeps everything else of its source.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

// Returns a file of that format with the source's contents and another mesh. `face_source` names, for each face of the
// mesh, the face of source.mesh that it lies in. The mesh has the source's attributes (names, domains, types) with its
// own values; "normal" is written as it is.
//
// The source's own format keeps:
//   PLY   encoding, line ends, comments, obj_info; names, types and order of elements and properties. Integer
//         coordinates become doubles if a position is not whole; indices get a wider type if they need it; strips of
//         triangles become faces. Elements other than vertices and faces stay if they cannot refer to vertices (only
//         reals and bytes, no lists). Other elements are left out, and all lists but vertex indices and texcoord.
//   OBJ   every line that does not name vertices, in place. A new face stands where the face stood that it lies in, so
//         it keeps material, groups, object and smoothing. v (with colors), vt and vn, each value once, stand before
//         the first line that could name them. A face has texture coordinates, or normals, if the face that it lies in
//         has them.
//   GLB   everything but the numbers of the primitives that changed: each keeps its material and the triangles that
//         lie in it. If several nodes place a mesh, those that changed get copies. Unchanged numbers keep their bits.
//         Points and lines whose vertices are in no face move with them if the mesh has as many such vertices as the
//         source, in its order; otherwise they stay. Points and lines among vertices of faces are left out if these
//         change.
//   STL   header, names, solids, the 16 bits, bytes after the last triangle; normals stay on their side, or zero. In
//         text a new triangle stands where the triangle stood that it lies in, with its spelling.
//   OFF   text or binary with its byte order; keyword, everything before the counts and after the last face; normals,
//         texture coordinates, colors of vertices and faces. The count of edges becomes 0 (not counted).
// A mesh that equals the source's gives the bytes of the source. Another format is generated from the mesh as by
// serialize_mesh. remesh_losses says what is left out.
//
// Throws InvalidInput for a source without faces, a face_source or attributes that do not fit, positions that are not
// finite or do not fit the format, and GLB with a skeleton or morph targets, which would need numbers for new vertices.
std::string serialize_remeshed(std::string_view format, const ShapeFile& source, const Mesh& mesh,
                               std::span<const std::uint32_t> face_source, const WriteOptions& options = {});

// Writes the bytes of serialize_remeshed to a file, in the format that its extension names. Throws also IoError(write).
void write_remeshed(const std::filesystem::path& path, const ShapeFile& source, const Mesh& mesh,
                    std::span<const std::uint32_t> face_source, const WriteOptions& options = {});

// Returns a number for each face; faces have the same number if the file groups them: under one material, group, object
// and smoothing (OBJ) or in one primitive (GLB). Empty for the other formats. A remesh with these face_labels keeps the
// lines between groups.
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

// Returns what write_remeshed may leave out when it writes to this path, a sentence each; for a format other than the
// source's, what conversion_losses says. Throws InvalidInput if write_remeshed would throw for every mesh.
std::vector<std::string> remesh_losses(const std::filesystem::path& path, const ShapeFile& source);

}  // namespace knead
