// Gaussian splats of glTF files (KHR_gaussian_splatting): their numbers in the file, and those of a mesh of splats.
// Source: Khronos, "KHR_gaussian_splatting" (2026).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/mesh_builder.h"
#include "knead/error.h"
#include "knead/splats.h"
#include "math/elementary.h"

namespace knead::io_detail::gltf {
namespace {

constexpr std::size_t kMaxDegree = 3;
constexpr std::size_t kAtOnce = std::size_t{1} << 16;            // splats, so that little memory is needed
constexpr double kSmallest = std::numeric_limits<float>::min();  // size, so that its logarithm is finite
constexpr double kFaintest = 0x1p-26;                            // opacity; as far below 1 is the most
constexpr double kOpaque = 50;                                   // the logarithm of the odds

constexpr std::string_view kTurns = "KHR_gaussian_splatting:ROTATION";
constexpr std::string_view kSizes = "KHR_gaussian_splatting:SCALE";
constexpr std::string_view kOpacities = "KHR_gaussian_splatting:OPACITY";
constexpr std::string_view kHarmonics = "KHR_gaussian_splatting:SH_";

// Returns the attributes of splats, without values.
std::vector<SplatNumbers> attributes_of(std::size_t degree) {
  std::vector<SplatNumbers> all{
      {std::string(kTurns), {"rot_1", "rot_2", "rot_3", "rot_0"}, {}},
      {std::string(kSizes), {"scale_0", "scale_1", "scale_2"}, {}},
      {std::string(kOpacities), {"opacity"}, {}},
  };
  for (std::size_t l = 0; l <= degree; ++l) {
    for (std::size_t n = 0; n <= 2 * l; ++n) {
      SplatNumbers& harmonic = all.emplace_back();
      harmonic.key = fmt::format("{}DEGREE_{}_COEF_{}", kHarmonics, l, n);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t number = c * degree * (degree + 2) + l * l + n - 1;
        harmonic.names.push_back(l == 0 ? fmt::format("f_dc_{}", c) : fmt::format("f_rest_{}", number));
      }
    }
  }
  return all;
}

// Returns the degree of splats that have so many attributes; nothing if there is none.
std::optional<std::size_t> degree_with(std::size_t attributes) {
  for (std::size_t degree = 0; degree <= kMaxDegree; ++degree) {
    if (attributes == 3 + (degree + 1) * (degree + 1)) return degree;
  }
  return std::nullopt;
}

std::vector<double>& values_of(Mesh& mesh, const std::string& name) {
  return std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                      [&](const Attribute& attribute) { return attribute.name == name; })
      ->values;
}

// Adds attributes of splats that are not seen, in the order of PLY files.
void add_unseen(Mesh& mesh, std::size_t degree) {
  const auto add = [&](const std::string& name, double value) {
    const std::vector<double> values(mesh.vertex_count(), value);
    mesh.attributes.push_back({name, Domain::vertex, NumberType::float32, 1, values});
  };
  for (std::size_t i = 0; i < 3; ++i) add(fmt::format("f_dc_{}", i), 0);
  for (std::size_t i = 0; i < 3 * degree * (degree + 2); ++i) add(fmt::format("f_rest_{}", i), 0);
  add("opacity", elementary::logit(kFaintest));
  for (std::size_t i = 0; i < 3; ++i) add(fmt::format("scale_{}", i), elementary::log(kSmallest));
  for (std::size_t i = 0; i < 4; ++i) add(fmt::format("rot_{}", i), i == 0 ? 1 : 0);
}

// Returns the numbers of an attribute as a mesh of splats holds them.
std::vector<double> read_numbers(const Document& document, const std::string& key, std::size_t components,
                                 std::size_t index, std::size_t count) {
  const Accessor accessor = find_accessor(document, index);
  const Value value = document.root().item("accessors", index);
  const bool are_sizes = key == kSizes;
  const bool is_real = accessor.type == NumberType::float32 ||
                       ((accessor.normalized || are_sizes) && accessor.type != NumberType::uint32);
  if (accessor.count != count || accessor.components != components || !is_real) {
    value.fail(fmt::format("does not fit {} of {} splats; repair the file", key, count));
  }
  std::vector<double> numbers = read_accessor(document, index, accessor, true);
  for (double& number : numbers) {
    if (!std::isfinite(number)) value.fail("has a number that is not finite; repair the file");
    if (are_sizes && number < 0) {
      value.fail("has a negative size, as a draft of the extension that had logarithms; export the splats anew");
    }
    if (are_sizes) number = elementary::log(std::max(number, kSmallest));
    if (key == kOpacities) number = elementary::logit(std::clamp(number, kFaintest, 1 - kFaintest));
  }
  return numbers;
}

// Maps splats [first, first + count). A mirror image has harmonics of odd degrees with the other sign.
void transform(Mesh& mesh, std::size_t first, std::size_t count, const Mat3d& linear) {
  if (linear == Mat3d{}) return;
  const double size = std::max({norm(linear.column(0)), norm(linear.column(1)), norm(linear.column(2))});
  const bool is_mirrored = determinant(linear) < 0;
  const std::size_t harmonics = splat_degree(mesh) * (splat_degree(mesh) + 2);
  for (std::size_t begin = first; begin < first + count; begin += kAtOnce) {
    SplatJacobians maps;
    maps.splats.resize(std::min(kAtOnce, first + count - begin));
    std::iota(maps.splats.begin(), maps.splats.end(), static_cast<std::uint32_t>(begin));
    maps.jacobians.assign(maps.splats.size(), linear * ((is_mirrored ? -1 : 1) / size));
    for (const Attribute& changed : deformed_splats(mesh, maps).attributes) {
      const double more = changed.name.starts_with("scale_") ? elementary::log(size) : 0;
      double sign = 1;
      if (is_mirrored && changed.name.starts_with("f_rest_")) {
        const std::size_t harmonic = std::stoul(changed.name.substr(7)) % harmonics;
        sign = harmonic < 3 || harmonic >= 8 ? -1 : 1;
      }
      std::vector<double>& values = values_of(mesh, changed.name);
      for (std::size_t i = 0; i < changed.values.size(); ++i) {
        values[begin + i] = sign * changed.values[i] + more;
        if (std::isfinite(values[begin + i])) continue;
        throw InvalidInput("a node stretches its splats too much; use a transform with like sizes on all axes");
      }
    }
  }
}

// Converts an element to numbers of the file; turns become unit quaternions.
void to_file(const std::string& key, std::span<double> element) {
  double size2 = 0;
  for (double& number : element) {
    size2 += number * number;
    if (key == kSizes) number = elementary::exp(std::clamp(number, elementary::log(kSmallest), 88.0));
    if (key == kOpacities) number = elementary::sigmoid(std::clamp(number, -kOpaque, kOpaque));
  }
  if (key != kTurns) return;
  for (double& number : element) number = size2 > 0 ? number / std::sqrt(size2) : 0;
  if (!(size2 > 0)) element[3] = 1;
}

void refuse_compressed(const std::optional<Value>& extensions) {
  if (!extensions || !extensions->json().is_object()) return;
  for (const JsonMember& member : extensions->json().members()) {
    const bool is_codec =
        member.key.find("gaussian_splat") != std::string::npos && member.key.find("compression") != std::string::npos;
    if (!is_codec) continue;
    extensions->fail(fmt::format(
        "holds compressed splats ({}), which Knead cannot read; export them without compression", member.key));
  }
}

// Returns the text of an accessor with copies of these elements after its last one.
std::string with_copied_elements(const Document& document, Edit& edit, std::size_t index,
                                 std::span<const std::uint32_t> copied) {
  const Accessor accessor = find_accessor(document, index);
  const std::vector<double> numbers = read_accessor(document, index, accessor, false);
  const std::size_t stride = (accessor.element_size() + 3) / 4 * 4;
  std::string elements;
  for (std::size_t i = 0; i < accessor.count + copied.size(); ++i) {
    const std::size_t from = accessor.components * (i < accessor.count ? i : copied[i - accessor.count]);
    for (std::size_t c = 0; c < accessor.components; ++c) append_number(elements, accessor.type, numbers[from + c]);
    elements.resize((i + 1) * stride, '\0');
  }
  const std::size_t view = edit.append_view(elements, stride == accessor.element_size() ? 0 : stride, kVertexData);
  std::string text = fmt::format(R"({{"bufferView":{},"count":{})", view, accessor.count + copied.size());
  for (const Member& member : members(document.text, edit.item("accessors", index))) {
    if (member.key == "bufferView" || member.key == "byteOffset" || member.key == "count" || member.key == "sparse") {
      continue;
    }
    const Span& span = member.value;
    text += fmt::format(",{}:{}", to_text(member.key), document.text.substr(span.begin, span.end - span.begin));
  }
  return text + "}";
}

}  // namespace

std::map<std::string, std::size_t> splat_accessors(const Value& primitive) {
  const std::optional<Value> extensions = primitive.find("extensions");
  refuse_compressed(extensions);
  const std::optional<Value> splatting = extensions ? extensions->find(kSplatting) : std::nullopt;
  std::map<std::string, std::size_t> accessors;
  if (!splatting) return accessors;
  refuse_compressed(splatting->find("extensions"));
  if (const auto kernel = splatting->find("kernel"); kernel && kernel->text() != "ellipse") {
    kernel->fail("is no kernel of splats that Knead knows; export them with \"ellipse\"");
  }
  if (primitive.whole("mode").value_or(kTriangles) != kPoints) {
    primitive.fail("holds splats and has another mode than POINTS; repair the file");
  }
  const Value attributes = primitive.at("attributes");
  std::size_t count = 3;
  for (const JsonMember& member : attributes.json().members()) count += member.key.starts_with(kHarmonics) ? 1 : 0;
  const std::optional<std::size_t> degree = degree_with(count);
  if (!degree) attributes.fail("does not have the spherical harmonics of a degree from 0 to 3; export the splats anew");
  for (const SplatNumbers& attribute : attributes_of(*degree)) {
    const std::optional<std::size_t> accessor = attributes.whole(attribute.key.c_str());
    if (!accessor) attributes.fail(fmt::format("lacks {}; export the splats anew", attribute.key));
    accessors[attribute.key] = *accessor;
  }
  return accessors;
}

void read_splats(const Document& document, const std::vector<Block>& blocks, Mesh& mesh,
                 std::vector<std::string>& notes) {
  std::size_t most = 0;
  std::size_t others = mesh.vertex_count();
  for (const Block& block : blocks) most = std::max(most, block.splats.size());
  if (most == 0) return;
  const std::size_t degree = *degree_with(most);
  add_unseen(mesh, degree);
  bool is_linear = false;
  for (const Block& block : blocks) {
    if (block.splats.empty()) continue;
    others -= block.count;
    for (const SplatNumbers& attribute : attributes_of(degree)) {
      const auto found = block.splats.find(attribute.key);
      if (found == block.splats.end()) continue;
      const std::size_t n = attribute.names.size();
      const std::vector<double> numbers = read_numbers(document, attribute.key, n, found->second, block.count);
      for (std::size_t c = 0; c < n; ++c) {
        std::vector<double>& values = values_of(mesh, attribute.names[c]);
        for (std::size_t i = 0; i < block.count; ++i) values[block.first + i] = numbers[i * n + c];
      }
    }
    transform(mesh, block.first, block.count, block.placement.linear);
    const Value primitive = document.root().item("meshes", block.mesh).item("primitives", block.primitives.front());
    const std::optional<Value> space = primitive.at("extensions").at(kSplatting).find("colorSpace");
    is_linear = is_linear || (space && space->text() == "lin_rec709_display");
  }
  if (is_linear) notes.emplace_back("colours of splats are linear, and are drawn as if they were sRGB");
  if (others == 0) return;
  const std::string splats = counted(mesh.vertex_count() - others, "vertex is a splat", "vertices are splats");
  notes.push_back(splats + (mesh.face_count() > 0 ? ", which deform with the faces and are not drawn as splats"
                                                  : "; the other points are not drawn"));
}

std::vector<SplatNumbers> local_splats(const Placement& placement, const Mesh& mesh,
                                       std::span<const std::uint32_t> splats, std::span<const Attribute> changed,
                                       std::size_t first) {
  std::vector<SplatNumbers> result = attributes_of(splat_degree(mesh));
  for (std::size_t begin = 0; begin < splats.size(); begin += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, splats.size() - begin);
    Mesh part;
    part.positions.resize(count);
    for (const SplatNumbers& attribute : result) {
      for (const std::string& name : attribute.names) {
        Attribute& to = part.attributes.emplace_back(Attribute{name, Domain::vertex, NumberType::float64, 1, {}});
        const auto is_it = [&](const Attribute& each) { return each.name == name; };
        const auto after = std::find_if(changed.begin(), changed.end(), is_it);
        const Attribute* const before = mesh.find_attribute(name);
        for (std::size_t i = begin; i < begin + count; ++i) {
          const double otherwise = attribute.key == kOpacities ? kOpaque : 0;
          to.values.push_back(after != changed.end() ? after->values[first + i]
                              : before != nullptr    ? before->values[splats[i]]
                                                     : otherwise);
        }
      }
    }
    transform(part, 0, count, placement.inverse);
    const Attribute* next = part.attributes.data();  // in the order of the names
    for (SplatNumbers& attribute : result) {
      const std::size_t n = attribute.names.size();
      std::array<double, 4> element{};
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t c = 0; c < n; ++c) element[c] = next[c].values[i];
        to_file(attribute.key, std::span(element).first(n));
        for (std::size_t c = 0; c < n; ++c) {
          attribute.values.push_back(static_cast<float>(nearest_of(NumberType::float32, element[c])));
        }
      }
      next += n;
    }
  }
  return result;
}

std::string glb_with_copies(const ShapeFile& source, std::span<const std::uint32_t> vertices) {
  const Layout& layout = layout_of<Layout>(source);
  const Document document = open_document(glb_bytes(source), layout, "source");
  const Block& block = layout.blocks.front();
  const Value mesh = document.root().item("meshes", block.mesh);
  const Value primitive = mesh.item("primitives", block.primitives.front());
  const bool is_alone = layout.blocks.size() == 1 && block.primitives.size() == 1 && !primitive.find("indices") &&
                        primitive.count("targets") == 0 && count_placements(document).at(block.mesh) == 1;
  if (!is_alone) return {};
  Edit edit(document, layout);
  edit.reuse(unused_after(document, {{block.mesh, block.primitives.front()}}));
  std::map<std::size_t, std::size_t> copies;  // accessors
  for (const JsonMember& member : primitive.at("attributes").json().members()) {
    const std::size_t index = primitive.at("attributes").at(member.key.c_str()).whole();
    if (find_accessor(document, index).count != block.count) continue;
    if (!copies.contains(index)) {
      copies[index] = edit.append_accessor(with_copied_elements(document, edit, index, vertices));
    }
    edit.patch(edit.attribute_patches(block.mesh, block.primitives, member.key, copies.at(index)));
  }
  return edit.finish();
}

}  // namespace knead::io_detail::gltf
