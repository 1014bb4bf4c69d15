// Gaussian splats of glTF files (KHR_gaussian_splatting): their numbers in the file, and those of a mesh of splats.
// Source: Khronos, "KHR_gaussian_splatting" (2026).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/mesh_builder.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "math/elementary.h"

namespace knead::detail::gltf {
namespace {

constexpr std::size_t kMaxDegree = 3;
constexpr std::size_t kOthers = 3;                     // attributes besides the harmonics
constexpr std::size_t kAtOnce = std::size_t{1} << 16;  // splats, so that little memory is needed
constexpr double kMinNumber = 0x1p-151;  // size or opacity: its logarithm is finite, and as a float it is 0
constexpr double kMaxOpacity = 1 - 0x1p-53;
constexpr double kOpaque = 50;  // the logarithm of the odds

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

// Returns the least degree of splats that have so many harmonics.
std::size_t degree_with(std::size_t harmonics) {
  std::size_t degree = 0;
  while (degree < kMaxDegree && (degree + 1) * (degree + 1) < harmonics) ++degree;
  return degree;
}

// Adds attributes of splats that are not seen, in the order of PLY files.
void add_unseen(Mesh& mesh, std::size_t degree) {
  const auto add = [&](const std::string& name, double value) {
    const std::vector<double> values(mesh.vertex_count(), value);
    mesh.attributes.push_back({name, Domain::vertex, NumberType::float32, 1, values});
  };
  for (std::size_t i = 0; i < 3; ++i) add(fmt::format("f_dc_{}", i), 0);
  for (std::size_t i = 0; i < 3 * degree * (degree + 2); ++i) add(fmt::format("f_rest_{}", i), 0);
  add("opacity", elementary::logit(kMinNumber));
  for (std::size_t i = 0; i < 3; ++i) add(fmt::format("scale_{}", i), elementary::log(kMinNumber));
  for (std::size_t i = 0; i < 4; ++i) add(fmt::format("rot_{}", i), i == 0 ? 1 : 0);
}

// Reads an attribute of splats [first, first + count) as a mesh holds it.
void read_numbers(const Document& document, const SplatNumbers& attribute, std::size_t index, std::size_t first,
                  std::size_t count, Mesh& mesh) {
  const Accessor accessor = find_accessor(document, index);
  const Value value = document.root().item("accessors", index);
  const std::size_t n = attribute.names.size();
  const bool are_sizes = attribute.key == kSizes;
  const bool is_real = accessor.type == NumberType::float32 ||
                       ((accessor.normalized || are_sizes) && accessor.type != NumberType::uint32);
  if (accessor.count != count || accessor.components != n || !is_real) {
    value.fail(fmt::format("does not fit {} of {} splats; repair the file", attribute.key, count));
  }
  const std::vector<double> numbers = read_accessor(document, index, accessor, true);
  for (std::size_t c = 0; c < n; ++c) {
    Attribute& to = *std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                                  [&](const Attribute& each) { return each.name == attribute.names[c]; });
    for (std::size_t i = 0; i < count; ++i) {
      double number = numbers[i * n + c];
      if (!std::isfinite(number)) value.fail("has a number that is not finite; repair the file");
      if (are_sizes && number < 0) {
        value.fail("has a negative size, as a draft of the extension that had logarithms; export the splats anew");
      }
      if (are_sizes) number = elementary::log(std::max(number, kMinNumber));
      if (attribute.key == kOpacities) number = elementary::logit(std::clamp(number, kMinNumber, kMaxOpacity));
      to.values[first + i] = number;
    }
  }
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
    ChangedSplats changed = deformed_splats(mesh, maps);
    for (Attribute& attribute : changed.attributes) {
      const double more = attribute.name.starts_with("scale_") ? elementary::log(size) : 0;
      double sign = 1;
      if (is_mirrored && attribute.name.starts_with("f_rest_")) {
        const std::size_t harmonic = std::stoul(attribute.name.substr(7)) % harmonics;
        sign = harmonic < 3 || harmonic >= 8 ? -1 : 1;
      }
      for (double& value : attribute.values) {
        value = sign * value + more;
        if (std::isfinite(value)) continue;
        throw InvalidInput("a node stretches its splats too much; use a transform with like sizes on all axes");
      }
    }
    put_values(mesh, changed.attributes, changed.splats);
  }
}

// Puts those of the values at `changed` that are at one of the splats. Both ascend.
void put_changed(const std::vector<double>& from, std::span<const std::uint32_t> changed,
                 std::span<const std::uint32_t> splats, std::vector<double>& values) {
  auto next = std::lower_bound(changed.begin(), changed.end(), splats.front());
  for (std::size_t i = 0; i < splats.size(); ++i) {
    next = std::find_if(next, changed.end(), [&](std::uint32_t splat) { return splat >= splats[i]; });
    if (next == changed.end()) return;
    if (*next == splats[i]) values[i] = from[static_cast<std::size_t>(next - changed.begin())];
  }
}

// Converts an element to numbers of the file; turns become unit quaternions.
void to_file(const std::string& key, std::span<double> element) {
  double size2 = 0;
  for (double& number : element) {
    size2 += number * number;
    if (key == kSizes) number = elementary::exp(number);
    if (key == kOpacities) number = elementary::sigmoid(number);
  }
  if (key != kTurns) return;
  for (double& number : element) number = size2 > 0 ? number / std::sqrt(size2) : 0;
  if (!(size2 > 0)) element[3] = 1;
}

}  // namespace

std::map<std::string, std::size_t> splat_accessors(const Value& primitive) {
  std::map<std::string, std::size_t> accessors;
  const std::optional<Value> extensions = primitive.find("extensions");
  const std::optional<Value> splatting = extensions ? extensions->find(kSplatting) : std::nullopt;
  if (!splatting) return accessors;
  if (splatting->find("extensions")) {
    splatting->fail(
        "holds splats that another extension compresses or changes; export them without it, or as .spz or .ply");
  }
  if (const auto kernel = splatting->find("kernel"); kernel && kernel->text() != "ellipse") {
    kernel->fail("is no kernel of splats that Knead knows; export them with \"ellipse\"");
  }
  if (primitive.whole("mode").value_or(kTriangles) != kPoints) {
    primitive.fail("holds splats and has another mode than POINTS; repair the file");
  }
  const Value attributes = primitive.at("attributes");
  std::size_t harmonics = 0;
  for (const JsonMember& each : attributes.json().members()) harmonics += each.key.starts_with(kHarmonics) ? 1 : 0;
  for (const SplatNumbers& attribute : attributes_of(degree_with(harmonics))) {
    const std::optional<std::size_t> accessor = attributes.whole(attribute.key.c_str());
    if (!accessor) attributes.fail(fmt::format("lacks {}; export the splats anew", attribute.key));
    accessors[attribute.key] = *accessor;
  }
  if (accessors.size() != harmonics + kOthers)
    attributes.fail("has harmonics above degree 3; export the splats without");
  return accessors;
}

void read_splats(const Document& document, const std::vector<Block>& blocks, Mesh& mesh,
                 std::vector<std::string>& notes) {
  std::size_t most = 0;
  std::size_t others = mesh.vertex_count();
  for (const Block& block : blocks) most = std::max(most, block.splats.size());
  if (most == 0) return;
  if (mesh.vertex_count() > most_elements(document.size) / most) {
    throw InvalidInput(Place{document.source.file}, "its nodes unfold into too many splats; place fewer copies");
  }
  const std::vector<SplatNumbers> attributes = attributes_of(degree_with(most - kOthers));
  add_unseen(mesh, degree_with(most - kOthers));
  for (const Block& block : blocks) {
    if (block.splats.empty()) continue;
    others -= block.count;
    for (const SplatNumbers& attribute : attributes) {
      const auto found = block.splats.find(attribute.key);
      if (found != block.splats.end()) read_numbers(document, attribute, found->second, block.first, block.count, mesh);
    }
    transform(mesh, block.first, block.count, block.placement.linear);
  }
  if (document.text.find("lin_rec709_display") != std::string_view::npos) {
    notes.emplace_back("colours of splats are linear, and are drawn as if they were sRGB");
  }
  if (others == 0) return;
  const std::string splats = counted(mesh.vertex_count() - others, "vertex is a splat", "vertices are splats");
  notes.push_back(splats + (mesh.face_count() > 0 ? ", which deform with the faces and are not drawn as splats"
                                                  : "; the other points are not drawn"));
}

std::vector<SplatNumbers> local_splats(const Placement& placement, const Mesh& mesh,
                                       std::span<const std::uint32_t> splats, const WriteOptions& options) {
  std::vector<SplatNumbers> result = attributes_of(splat_degree(mesh));
  for (std::size_t begin = 0; begin < splats.size(); begin += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, splats.size() - begin);
    Mesh part;
    part.positions.resize(count);
    for (const SplatNumbers& attribute : result) {
      for (const std::string& name : attribute.names) {
        std::vector<double> values(count, attribute.key == kOpacities ? kOpaque : 0);
        const Attribute* const before = mesh.find_attribute(name);
        for (std::size_t i = 0; before != nullptr && i < count; ++i) values[i] = before->values[splats[begin + i]];
        for (const Attribute& after : options.attributes) {
          if (after.name == name) put_changed(after.values, options.changed, splats.subspan(begin, count), values);
        }
        part.attributes.push_back({name, Domain::vertex, NumberType::float64, 1, std::move(values)});
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

bool is_one_part(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  const Document document = open_source(source);
  const Block& block = layout.blocks.front();
  const Value primitive = document.root().item("meshes", block.mesh).item("primitives", block.primitives.front());
  return layout.blocks.size() == 1 && block.primitives.size() == 1 && !primitive.find("indices") &&
         primitive.count("targets") == 0 && count_placements(document).at(block.mesh) == 1;
}

}  // namespace knead::detail::gltf
