// assimp_dump SHAPE DUMP: what assimp reads, without any postprocessing. Warnings of its log go to standard error.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <utility>

#include "dump.h"

namespace {

class WarningsToStderr : public Assimp::LogStream {
 public:
  void write(const char* message) override { std::fputs(message, stderr); }
};

// An attribute that some meshes of the scene lack is filled up with zeros.
template <typename T>
void fill(std::vector<T>& values, std::size_t size) {
  if (!values.empty()) values.resize(size);
}

template <typename T>
void start(std::vector<T>& values, bool wanted, std::size_t before) {
  if (wanted && values.empty()) values.resize(before);
}

void add_attributes(const aiMesh& mesh, unsigned vertex, const aiMatrix3x3& turn, Dump& dump) {
  if (mesh.HasTextureCoords(0)) {
    dump.uv.push_back({mesh.mTextureCoords[0][vertex].x, mesh.mTextureCoords[0][vertex].y});
  }
  if (mesh.HasVertexColors(0)) {
    const aiColor4D& c = mesh.mColors[0][vertex];
    dump.color.push_back({c.r, c.g, c.b, c.a});
  }
  if (mesh.HasNormals()) {
    const aiVector3D n = (turn * mesh.mNormals[vertex]).NormalizeSafe();
    dump.normal.push_back({n.x, n.y, n.z});
  }
}

void add_mesh(const aiMesh& mesh, const aiMatrix4x4& place, Dump& dump) {
  const auto first = static_cast<std::int32_t>(dump.positions.size());
  const bool points = (mesh.mPrimitiveTypes & ~static_cast<unsigned>(aiPrimitiveType_POINT)) == 0;
  aiMatrix3x3 turn(place);
  turn.Inverse().Transpose();
  const std::size_t before = points ? dump.positions.size() : dump.corners.size();
  start(dump.uv, mesh.HasTextureCoords(0), before);
  start(dump.color, mesh.HasVertexColors(0), before);
  start(dump.normal, mesh.HasNormals(), before);
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D p = place * mesh.mVertices[v];
    dump.positions.push_back({p.x, p.y, p.z});
    if (points) add_attributes(mesh, v, turn, dump);
  }
  for (unsigned f = 0; f < mesh.mNumFaces && !points; ++f) {
    const aiFace& face = mesh.mFaces[f];
    dump.sizes.push_back(static_cast<std::int32_t>(face.mNumIndices));
    for (unsigned i = 0; i < face.mNumIndices; ++i) {
      dump.corners.push_back(first + static_cast<std::int32_t>(face.mIndices[i]));
      add_attributes(mesh, face.mIndices[i], turn, dump);
    }
  }
  const std::size_t after = points ? dump.positions.size() : dump.corners.size();
  fill(dump.uv, after);
  fill(dump.color, after);
  fill(dump.normal, after);
}

Dump dump_of(const aiScene& scene) {
  Dump dump;
  std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{{scene.mRootNode, aiMatrix4x4()}};
  while (!open.empty()) {
    const auto [node, above] = open.back();
    open.pop_back();
    const aiMatrix4x4 place = above * node->mTransformation;
    for (unsigned i = 0; i < node->mNumMeshes; ++i) add_mesh(*scene.mMeshes[node->mMeshes[i]], place, dump);
    for (unsigned i = 0; i < node->mNumChildren; ++i) open.emplace_back(node->mChildren[i], place);
  }
  return dump;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  Assimp::DefaultLogger::create(nullptr, Assimp::Logger::NORMAL, 0);
  Assimp::DefaultLogger::get()->attachStream(new WarningsToStderr, Assimp::Logger::Warn | Assimp::Logger::Err);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(argv[1], aiProcess_ValidateDataStructure);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    std::fprintf(stderr, "assimp: %s\n", importer.GetErrorString());
    return 1;
  }
  return write_dump(argv[2], dump_of(*scene)) ? 0 : 1;
}
