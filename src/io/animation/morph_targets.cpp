// glTF with morph targets: one for each frame that differs from the one before it and from the first, and an animation
// whose weights go from one to the next. Source: Khronos, "glTF 2.0 Specification" (2021), 3.7.2.2 and 3.11.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include "io/animation/writers.h"
#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/numbers.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::detail {
namespace {

using gltf::Block;
using gltf::Document;
using gltf::Edit;
using gltf::Layout;
using gltf::Patch;
using gltf::Span;

// A GLB file of the source, and the source's vertex of each of its vertices.
struct Base {
  ShapeFile shape;
  std::vector<std::uint32_t> original{};  // empty: the same vertices
};

Base generated_base(const ShapeFile& source) {
  Mesh mesh = source.mesh;
  if (mesh.face_count() > 0 && mesh.find_attribute("normal") == nullptr) {
    Attribute normals{"normal", Domain::vertex, NumberType::float32, 3, {}};
    for (const Vec3d& n : vertex_normals(mesh)) normals.values.insert(normals.values.end(), {n.x, n.y, n.z});
    mesh.attributes.push_back(std::move(normals));
  }
  Base base{parse_shape(serialize_mesh("glb", mesh), "glb", "base")};
  base.original = gltf::split_vertices(mesh, gltf::writable_attributes(mesh).attributes).original;
  return base;
}

Base base_of(const ShapeFile& source) {
  if (source.format != "glb" && source.format != "gltf") return generated_base(source);
  const bool is_whole = !source.file && source.layout->edits.vertices.empty();
  if (is_whole) return {source};
  return {parse_shape(serialize_shape(source.format, source, source.mesh.positions), source.format, "base")};
}

// What a block's vertices do in one target, in the node's coordinates: differences from the file's values.
struct BlockTarget {
  Changes positions;
  Changes normals;
};

// A target: what each block does.
using Target = std::vector<BlockTarget>;

template <class ToLocal>
Changes differences(const Block& block, std::span<const Vec3d> before, std::span<const Vec3d> after,
                    const ToLocal& to_local) {
  Changes changes;
  for (std::size_t i = 0; i < block.count; ++i) {
    const std::size_t v = block.first + i;
    if (before[v] == after[v]) continue;
    const Vec3d from = to_local(before[v]);
    const Vec3d to = to_local(after[v]);
    changes.elements.push_back(static_cast<std::uint32_t>(i));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      changes.values.push_back(static_cast<float>(to[axis] - double{static_cast<float>(from[axis])}));
    }
  }
  return changes;
}

// How strong the targets are: as the file stands, and over time.
struct Track {
  std::vector<float> weights{};  // empty: not stated
  std::vector<float> times{};
  std::vector<float> keys{};  // of all targets at each time
  std::vector<std::string> names{};
  std::optional<std::size_t> animation{};  // of the file, to which the keys are added; none: a new one
};

// The track that shows one frame after the other.
Track frames_track(const std::vector<std::optional<std::size_t>>& frames, std::size_t targets, double fps) {
  Track track;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    track.times.push_back(static_cast<float>(static_cast<double>(k) / fps));
    for (std::size_t t = 0; t < targets; ++t) track.keys.push_back(frames[k] == t ? 1.0f : 0.0f);
  }
  return track;
}

// Writes the targets into the file.
class Morpher {
 public:
  Morpher(const ShapeFile& base, const std::vector<Target>& targets)
      : layout_(layout_of<Layout>(base)),
        targets_(targets),
        document_(gltf::open_source(base)),
        edit_(document_, layout_) {}

  std::string run(const Track& track) {
    if (targets_.empty()) return std::string(document_.bytes);
    const std::map<std::size_t, std::size_t> placed = gltf::count_placements(document_);
    for (const auto& [mesh, nodes] : gltf::blocks_by_node(layout_)) {
      // Nodes that share a mesh move differently, so that each gets its own.
      const bool is_shared = placed.at(mesh) > 1;
      for (const std::vector<std::size_t>& blocks : nodes) add_targets(mesh, blocks, is_shared, track);
    }
    if (!track.times.empty()) add_animation(track);
    return edit_.finish();
  }

 private:
  void add_targets(std::size_t mesh, const std::vector<std::size_t>& blocks, bool is_shared, const Track& track) {
    const Span span = edit_.item("meshes", mesh);
    const std::vector<gltf::Member> primitives = members(document_.text, *member(document_.text, span, "primitives"));
    std::vector<Patch> patches;
    for (const std::size_t b : blocks) {
      const Block& block = layout_.blocks[b];
      const std::string text = targets_text(b);
      for (const std::size_t p : block.primitives) {
        if (member(document_.text, primitives[p].value, "targets")) {
          throw InvalidInput(fmt::format(
              "meshes[{}] has morph targets of its own, which an animation would replace; write .pc2, or a file for "
              "each frame",
              mesh));
        }
        const std::size_t end = primitives[p].value.end - 1;
        patches.push_back({{end, end}, text});
      }
    }
    if (!track.weights.empty()) patches.push_back({{span.end - 1, span.end - 1}, weights_text(span, track)});
    const std::size_t node = layout_.blocks[blocks.front()].node;
    nodes_.push_back(node);
    if (!is_shared) return edit_.patch(patches);
    edit_.copy_mesh(node, mesh, std::move(patches));
  }

  std::string targets_text(std::size_t b) {
    const Block& block = layout_.blocks[b];
    std::string text = R"(,"targets":[)";
    for (const Target& target : targets_) {
      if (text.back() != '[') text += ",";
      text += fmt::format(R"({{"POSITION":{})", accessor_of(block.count, target[b].positions, true));
      if (block.normal) text += fmt::format(R"(,"NORMAL":{})", accessor_of(block.count, target[b].normals, false));
      text += "}";
    }
    return text + "]";
  }

  std::size_t accessor_of(std::size_t count, const Changes& changes, bool has_bounds) {
    std::vector<float> bounded = changes.values;
    if (changes.elements.size() < count) bounded.insert(bounded.end(), {0, 0, 0});
    std::string text = fmt::format(R"("componentType":5126,"count":{},"type":"VEC3")", count);
    if (has_bounds) {
      text += fmt::format(R"(,"min":{},"max":{})", gltf::least_text(bounded, 3), gltf::greatest_text(bounded, 3));
    }
    if (changes.elements.empty()) return edit_.append_accessor("{" + text + "}");
    if (2 * changes.elements.size() < count) return sparse_accessor(text, count, changes);
    std::string bytes;
    std::size_t next = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const bool differs = next < changes.elements.size() && changes.elements[next] == i;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        gltf::append_number(bytes, NumberType::float32, differs ? double{changes.values[3 * next + axis]} : 0);
      }
      if (differs) ++next;
    }
    return edit_.append_elements(bytes, 0, gltf::kVertexData, text);
  }

  std::size_t sparse_accessor(const std::string& text, std::size_t count, const Changes& changes) {
    const bool is_short = count <= 65536;
    std::string indices;
    for (const std::uint32_t i : changes.elements) {
      gltf::append_number(indices, is_short ? NumberType::uint16 : NumberType::uint32, i);
    }
    std::string values;
    for (const float value : changes.values) gltf::append_number(values, NumberType::float32, double{value});
    const std::size_t index_view = edit_.append_view(indices, 0, 0);
    return edit_.append_accessor(fmt::format(
        R"({{{},"sparse":{{"count":{},"indices":{{"bufferView":{},"componentType":{}}},"values":{{"bufferView":{}}}}}}})",
        text, changes.elements.size(), index_view, is_short ? 5123 : 5125, edit_.append_view(values, 0, 0)));
  }

  // The members of a mesh that say how strong its targets are, and their names where there is room for them.
  std::string weights_text(const Span& mesh, const Track& track) const {
    std::string text;
    if (!member(document_.text, mesh, "weights")) {
      for (const float weight : track.weights) text += fmt::format("{}{}", text.empty() ? "" : ",", weight);
      text = fmt::format(R"(,"weights":[{}])", text);
    }
    if (track.names.empty() || member(document_.text, mesh, "extras")) return text;
    return text + fmt::format(R"(,"extras":{})", to_text(Json{{"targetNames", track.names}}));
  }

  void add_animation(const Track& track) {
    std::string times;
    std::string weights;
    for (const float time : track.times) gltf::append_number(times, NumberType::float32, double{time});
    for (const float weight : track.keys) gltf::append_number(weights, NumberType::float32, double{weight});
    const std::size_t input =
        edit_.append_elements(times, 0, 0,
                              fmt::format(R"("componentType":5126,"count":{},"type":"SCALAR","min":[{}],"max":[{}])",
                                          track.times.size(), track.times.front(), track.times.back()));
    const std::size_t output = edit_.append_elements(
        weights, 0, 0, fmt::format(R"("componentType":5126,"count":{},"type":"SCALAR")", track.keys.size()));
    const std::string sampler = fmt::format(R"({{"input":{},"output":{},"interpolation":"LINEAR"}})", input, output);
    if (!track.animation) {
      edit_.append_animation(
          fmt::format(R"({{"name":"Knead","samplers":[{}],"channels":[{}]}})", sampler, channels_text(0)));
      return;
    }
    const Span animations = *member(document_.text, gltf::root_span(document_.text), "animations");
    const Span animation = members(document_.text, animations)[*track.animation].value;
    const Span samplers = *member(document_.text, animation, "samplers");
    const std::size_t number = members(document_.text, samplers).size();
    edit_.patch({appended_item(document_.text, samplers, sampler),
                 appended_item(document_.text, *member(document_.text, animation, "channels"), channels_text(number))});
  }

  std::string channels_text(std::size_t sampler) const {
    std::string channels;
    for (const std::size_t node : nodes_) {
      if (!channels.empty()) channels += ",";
      channels += fmt::format(R"({{"sampler":{},"target":{{"node":{},"path":"weights"}}}})", sampler, node);
    }
    return channels;
  }

  const Layout& layout_;
  const std::vector<Target>& targets_;
  Document document_;
  Edit edit_;
  std::vector<std::size_t> nodes_;  // that are animated
};

// The targets so far.
struct Frames {
  const ShapeFile& source;
  Base base;
  FrameNormals frame_normals;  // of the base if its normals are authored, else of the source
  double fps = 24;
  std::vector<Vec3d> before{};  // the last frame
  std::vector<Target> targets{};
  std::vector<std::optional<std::size_t>> shown{};

  Frames(const ShapeFile& of, double frames_per_second)
      : source(of), base(base_of(of)), frame_normals(has_own_normals() ? base.shape : of), fps(frames_per_second) {}

  bool has_own_normals() const { return base.original.empty() || source.mesh.find_attribute("normal") != nullptr; }

  // A normal for each vertex of the base.
  std::vector<Vec3d> expanded(const std::vector<Vec3d>& normals) const {
    if (has_own_normals() || normals.empty()) return normals;
    std::vector<Vec3d> result;
    result.reserve(base.original.size());
    for (const std::uint32_t v : base.original) result.push_back(normals[v]);
    return result;
  }

  void add_target(std::span<const Vec3d> positions) {
    check_fits_floats(positions);
    const std::vector<Vec3d> now = in_base(positions);
    targets.push_back(target_of(now, expanded(frame_normals.at(has_own_normals() ? now : positions))));
  }

  void add(std::span<const Vec3d> positions) {
    check_fits_floats(positions);
    const std::vector<Vec3d> now = in_base(positions);
    if (now == base.shape.mesh.positions) {
      shown.emplace_back();
    } else if (now == before) {
      shown.push_back(shown.back());
    } else {
      shown.emplace_back(targets.size());
      add_target(positions);
    }
    before = now;
  }

  // The base's positions are floats where it was generated: a vertex that rests keeps them.
  std::vector<Vec3d> in_base(std::span<const Vec3d> positions) const {
    std::vector<Vec3d> result = base.shape.mesh.positions;
    for (std::size_t i = 0; i < result.size(); ++i) {
      const std::size_t v = base.original.empty() ? i : base.original[i];
      if (positions[v] != source.mesh.positions[v]) result[i] = positions[v];
    }
    return result;
  }

  Target target_of(std::span<const Vec3d> now, const std::vector<Vec3d>& normals) const {
    const std::vector<Vec3d>& start = base.shape.mesh.positions;
    const std::vector<Vec3d> first_normals = expanded(frame_normals.first());
    Target target;
    for (const Block& block : layout_of<Layout>(base.shape).blocks) {
      const gltf::Placement& placement = block.placement;
      const Mat3d& linear = placement.linear;
      const Mat3d transposed(linear.column(0), linear.column(1), linear.column(2));
      BlockTarget part;
      part.positions =
          differences(block, start, now, [&](const Vec3d& p) { return placement.inverse * (p - placement.offset); });
      if (block.normal) {
        part.normals =
            differences(block, first_normals, normals, [&](const Vec3d& n) { return gltf::direction(transposed * n); });
      }
      target.push_back(std::move(part));
    }
    return target;
  }

  std::string bytes() const { return Morpher(base.shape, targets).run(frames_track(shown, targets.size(), fps)); }
};

void require(bool holds, const std::string& what) {
  if (!holds) throw InvalidInput(what);
}

std::vector<float> floats_of(const std::vector<double>& numbers) { return {numbers.begin(), numbers.end()}; }

}  // namespace

AnimationFile::Writer glb_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options) {
  struct Open {
    AtomicFile file;
    Frames frames;

    Open(const std::filesystem::path& to, const ShapeFile& of, double fps) : file(to), frames(of, fps) {}
  };
  const auto open = std::make_shared<Open>(path, source, options.fps);
  return {[open](std::span<const Vec3d> positions) { open->frames.add(positions); },
          [open] {
            open->file.write(open->frames.bytes());
            open->file.finish();
          }};
}

}  // namespace knead::detail

namespace knead {

std::string serialize_morphed(const ShapeFile& source, const MorphTargets& targets, std::string_view format) {
  using namespace detail;
  const std::size_t count = targets.shapes.size();
  require(targets.weights.size() == count, fmt::format("{} morph targets need as many weights", count));
  require(targets.names.empty() || targets.names.size() == count,
          fmt::format("{} morph targets need as many names", count));
  require(targets.keys.size() == count * targets.times.size(),
          fmt::format("{} morph targets at {} times need {} keys, got {}", count, targets.times.size(),
                      count * targets.times.size(), targets.keys.size()));
  require(std::is_sorted(targets.times.begin(), targets.times.end()) &&
              (targets.times.empty() || targets.times.front() >= 0),
          "times must be 0 or more, and ascending");
  Frames frames(source, 1);
  for (const std::vector<Vec3d>& shape : targets.shapes) {
    require(shape.size() == source.mesh.positions.size(), "a morph target has not one position for each vertex");
    frames.add_target(shape);
  }
  Track track{floats_of(targets.weights), floats_of(targets.times), floats_of(targets.keys), targets.names, {}};
  const gltf::Document document = gltf::open_source(frames.base.shape);
  if (targets.animation < document.root().count("animations")) track.animation = targets.animation;
  const std::string bytes = Morpher(frames.base.shape, frames.targets).run(track);
  return format == "gltf" ? gltf::as_text(bytes) : bytes;
}

}  // namespace knead
