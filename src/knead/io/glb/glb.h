// Binary glTF 2.0 (GLB): reading, writing back, writing anew. Source: Khronos, "glTF 2.0 Specification" (2021), and
// KHR_mesh_quantization.
//
// The mesh is that of the default scene in world coordinates, as stored: vertices that a seam in the texture or a hard
// edge repeats are not welded, and a mesh that several nodes place has its vertices once for each. Attributes: "normal"
// (3, unit), "uv" (2; v upwards as in the other formats, 1 minus what the file holds), "color" (3 or 4, in the type of
// the file) and "tangent" (4), each if some primitive has it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "knead/io/new_mesh.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail::glb {

// Throws InvalidInput also for what cannot be read without another file or a decoder: buffers outside of the file,
// Draco and meshopt compression. Vertices and corners may not exceed 2^21 plus four for each byte of the file (a small
// file can place one mesh very often).
ShapeFile parse(std::string bytes, const std::string& name);

// The source with other positions and, if there are any, other normals (both per vertex, in world coordinates); the
// tangents follow (transport_tangents). Numbers in the file are local floats: a vertex that did not move keeps its
// bits. Only its numbers, the bounds of its accessors and what those need are replaced. Data that the file stores as
// integers, sparsely, or in bytes that something else reads too, is appended as new floats; a mesh that several nodes
// place gets copies where they moved differently. Throws InvalidInput where a float cannot hold a coordinate. The
// options change nothing.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);

// A new file: one node, one mesh, one primitive of triangles (of points, if there are no faces) with float coordinates,
// whatever the options say. A vertex whose corners differ in an attribute becomes several at the end of the list.
// Other attributes per vertex become "_NAME". Throws InvalidInput where a float cannot hold a coordinate.
std::string generate(const Mesh& mesh, const WriteOptions& options);

// What generate leaves out, a sentence each.
std::vector<std::string> losses(const Mesh& mesh);

// What a file made of the source's mesh alone leaves out.
std::vector<std::string> source_losses(const ShapeFile& source);

std::string remeshed(const NewMesh& shape, const WriteOptions& options);
std::vector<std::string> remesh_losses(const ShapeFile& source);
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

}  // namespace knead::io_detail::glb
