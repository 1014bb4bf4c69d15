// A shape whose connectivity has changed, in a file that keeps what its source held.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

// The source with another mesh in its place, as a file of that format. face_source names for each face of the mesh the
// face of source.mesh that it lies in. The mesh has the source's attributes (names, domains, types) with its own
// values, "normal" among them as they are to be written.
//
// In the source's own format:
//   PLY   encoding, line ends, comments, obj_info; names, types and order of elements and properties. Integer
//         coordinates become doubles where a position is not whole; indices get a wider type where they need it;
//         strips of triangles become faces. Elements that no mesh holds stay if they cannot refer to vertices (reals
//         and bytes only, no lists); others are left out, and so are lists but faces' vertices and texcoord.
//   OBJ   every line but those that name vertices, in place. New faces stand where the face stood that they lie in: so
//         under its material, groups, object and smoothing. v (with colors), vt and vn, each value once, stand before
//         the first line that could name them. A face has texture coordinates, or normals, if that which it lies in
//         does.
//   GLB   everything but the numbers of the primitives that changed: each keeps its material with the triangles that
//         lie in it. Where several nodes place a mesh, those that changed get copies. Numbers that did not change keep
//         their bits. Points and lines whose vertices are in no face follow, if the mesh has as many such vertices as
//         the source, in its order, and else stay; those among vertices of faces are left out where these change.
//   STL   header, names, solids, the 16 bits, bytes after the last triangle; normals stay on their side, and zero. In
//         text the triangles stand where the one stood that they lie in, spelled as it is.
//   OFF   text or binary in its byte order; keyword, what stands before the counts and after the last face; normals,
//         texture coordinates, colors of vertices and faces. The count of edges becomes 0: not counted.
// A mesh that equals the source's is the source, byte for byte. Another format is generated from the mesh as by
// serialize_mesh. remesh_losses says what is lost.
//
// Throws InvalidInput for a source without faces; for a face_source or attributes that do not fit; for positions that
// are not finite or do not fit the format; and for GLB with a skeleton or morph targets, for which new vertices have
// no numbers.
std::string serialize_remeshed(std::string_view format, const ShapeFile& source, const Mesh& mesh,
                               std::span<const std::uint32_t> face_source, const WriteOptions& options = {});

// The same into a file, of the format that its extension names, as write_shape does.
void write_remeshed(const std::filesystem::path& path, const ShapeFile& source, const Mesh& mesh,
                    std::span<const std::uint32_t> face_source, const WriteOptions& options = {});

// A number for each face: equal where a file keeps the faces together, under one material, group, object and smoothing
// (OBJ) or in one primitive (GLB). Empty where it has no such thing. A remesh that is given these (RemeshOptions,
// ReplayOptions: face_labels) keeps the lines between them.
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

// What write_remeshed may lose when it writes to this path, a sentence each; for another format than the source's what
// conversion_losses says. Throws InvalidInput where write_remeshed would, whatever the mesh.
std::vector<std::string> remesh_losses(const std::filesystem::path& path, const ShapeFile& source);

}  // namespace knead
