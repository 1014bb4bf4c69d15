// What is lost between GLB and other formats.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "knead/io/glb/accessor.h"
#include "knead/io/glb/attributes.h"
#include "knead/io/glb/glb.h"
#include "knead/io/glb/writable.h"
#include "knead/io/layout.h"
#include "knead/io/text.h"

namespace knead::io_detail::glb {
namespace {

struct Kind {
  const char* key;  // of an array at the top of the file
  const char* loss;
};

constexpr Kind kKinds[] = {{"materials", "materials are left out"},   {"textures", "textures are left out"},
                           {"animations", "animations are left out"}, {"skins", "skeletons are left out"},
                           {"cameras", "cameras are left out"},       {"extensionsUsed", "extensions are left out"}};

void add_primitive_losses(const Value& primitive, std::set<std::string>& losses) {
  if (primitive.count("targets") > 0) losses.insert("morph targets are left out");
  const std::size_t mode = primitive.whole("mode").value_or(kTriangles);
  if (mode != kPoints && mode < kTriangles) losses.insert("lines are left out");
  for (const auto& [key, accessor] : primitive.at("attributes").json().members()) {
    if (!is_read(key)) losses.insert("attribute " + in_quotes(key) + " is left out");
  }
}

}  // namespace

std::vector<std::string> losses(const Mesh& mesh) {
  WritableAttributes held = writable_attributes(mesh);
  std::vector<std::string> losses = std::move(held.losses);
  std::size_t cut = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) cut += mesh.face(f).size() > 3 ? 1 : 0;
  const bool has_seams = std::any_of(held.attributes.begin(), held.attributes.end(),
                                     [](const WritableAttribute& h) { return h.attribute.domain == Domain::corner; });
  if (has_seams) losses.push_back("GLB holds one value of an attribute at a vertex; vertices along seams are split");
  if (cut > 0) losses.push_back("GLB holds triangles only; faces with more than three corners are cut");
  const bool is_exact = std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Vec3d& p) {
    return fits_float(p.x) && fits_float(p.y) && fits_float(p.z) && Vec3d(Vec3f(p)) == p;
  });
  if (!is_exact) losses.push_back("GLB holds floats only; coordinates are rounded to seven digits");
  return losses;
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  const Document document = open_document(source.bytes, layout, "source");
  const Value root = document.root();
  std::vector<std::string> losses;
  for (const Kind& kind : kKinds) {
    if (root.find(kind.key)) losses.emplace_back(kind.loss);
  }
  if (root.count("nodes") > 1) losses.emplace_back("the tree of nodes is left out; every mesh is placed where it is");
  if (document.text.find("\"extras\"") != std::string_view::npos) losses.emplace_back("extras are left out");
  std::set<std::string> more;
  for (const Block& block : layout.blocks) {
    for (const std::size_t p : block.primitives) {
      add_primitive_losses(root.item("meshes", block.mesh).item("primitives", p), more);
    }
  }
  losses.insert(losses.end(), more.begin(), more.end());
  return losses;
}

}  // namespace knead::io_detail::glb
