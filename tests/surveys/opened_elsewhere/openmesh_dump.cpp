// openmesh_dump SHAPE DUMP: what OpenMesh reads into a mesh of polygons.
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <string>

#include "dump.h"

namespace {

// Points as doubles: positions in text keep their accuracy.
struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  using TexCoord2D = OpenMesh::Vec2d;
  using Color = OpenMesh::Vec4f;
  VertexAttributes(OpenMesh::Attributes::Normal | OpenMesh::Attributes::TexCoord2D | OpenMesh::Attributes::Color);
  HalfedgeAttributes(OpenMesh::Attributes::TexCoord2D | OpenMesh::Attributes::Normal);
};
using Mesh = OpenMesh::PolyMesh_ArrayKernelT<Traits>;

void add_vertex(const Mesh& mesh, Mesh::VertexHandle v, const OpenMesh::IO::Options& read, Dump& dump) {
  if (read.vertex_has_color()) {
    const auto& c = mesh.color(v);
    dump.color.push_back({c[0], c[1], c[2], c[3]});
  }
  if (read.vertex_has_normal()) {
    const auto& n = mesh.normal(v);
    dump.normal.push_back({n[0], n[1], n[2]});
  }
  if (read.vertex_has_texcoord() && !read.face_has_texcoord()) {
    dump.uv.push_back({mesh.texcoord2D(v)[0], mesh.texcoord2D(v)[1]});
  }
}

Dump dump_of(const Mesh& mesh, const OpenMesh::IO::Options& read) {
  Dump dump;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    dump.positions.push_back({p[0], p[1], p[2]});
    if (mesh.n_faces() == 0) add_vertex(mesh, v, read, dump);
  }
  for (const auto f : mesh.faces()) {
    dump.sizes.push_back(static_cast<std::int32_t>(mesh.valence(f)));
    for (auto h = mesh.cfh_iter(f); h.is_valid(); ++h) {
      dump.corners.push_back(mesh.to_vertex_handle(*h).idx());
      add_vertex(mesh, mesh.to_vertex_handle(*h), read, dump);
      if (read.face_has_texcoord()) dump.uv.push_back({mesh.texcoord2D(*h)[0], mesh.texcoord2D(*h)[1]});
    }
  }
  return dump;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  using Options = OpenMesh::IO::Options;
  Options options(Options::VertexColor | Options::VertexNormal | Options::VertexTexCoord | Options::FaceTexCoord |
                  Options::ColorFloat);
  Mesh mesh;
  if (!OpenMesh::IO::read_mesh(mesh, argv[1], options)) {
    std::fprintf(stderr, "OpenMesh: cannot read it\n");
    return 1;
  }
  // The STL reader leaves the options as they were asked for; the format holds none of them.
  const std::string path = argv[1];
  if (path.ends_with(".stl")) options = Options();
  return write_dump(argv[2], dump_of(mesh, options)) ? 0 : 1;
}
