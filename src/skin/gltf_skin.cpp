// Skeletons of glTF files, and their animations. Source: Khronos, "glTF 2.0 Specification" (2021), 3.7.3 and 3.11.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "io/gltf/gltf.h"
#include "knead/error.h"
#include "knead/fit.h"
#include "knead/io.h"
#include "math/elementary.h"
#include "skin/rigid.h"

namespace knead {

using namespace detail;

namespace {

namespace gltf = detail::gltf;
using gltf::Document;
using gltf::Value;

// The transform of a node relative to its parent.
struct Local {
  Quaternion turn{};
  Vec3d scale{1, 1, 1};
  Vec3d translation{0, 0, 0};
  std::optional<BoneTransform> matrix{};  // replaces the other members
};

BoneTransform transform_of(const Local& local) {
  if (local.matrix) return *local.matrix;
  const Vec3d x = local.turn * Vec3d{local.scale.x, 0, 0};
  const Vec3d y = local.turn * Vec3d{0, local.scale.y, 0};
  const Vec3d z = local.turn * Vec3d{0, 0, local.scale.z};
  return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}, local.translation};
}

// Returns the transform of 16 numbers in column order.
BoneTransform matrix_of(const double* m) {
  return {{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}, {m[12], m[13], m[14]}};
}

Quaternion quaternion_of(const double* q) {
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return size > 0 ? Quaternion{q[3] / size, Vec3d{q[0], q[1], q[2]} / size} : Quaternion{};
}

Local local_of(const Value& node) {
  Local local;
  if (const std::optional<Value> matrix = node.find("matrix")) {
    local.matrix = matrix_of(matrix->numbers(16).data());
    return local;
  }
  if (const std::optional<Value> turn = node.find("rotation")) local.turn = quaternion_of(turn->numbers(4).data());
  const auto vector = [&](const char* key, Vec3d& to) {
    const std::optional<Value> value = node.find(key);
    if (!value) return;
    const std::vector<double> numbers = value->numbers(3);
    to = {numbers[0], numbers[1], numbers[2]};
  };
  vector("scale", local.scale);
  vector("translation", local.translation);
  return local;
}

// One channel of an animation: a property of a node over time.
struct Channel {
  std::size_t node = 0;
  std::string path;           // rotation, translation or scale
  std::string interpolation;  // LINEAR, STEP or CUBICSPLINE
  std::vector<double> times;
  std::vector<double> values;
  std::size_t width = 3;  // numbers of a value

  void apply(double seconds, Local& local) const {
    const std::vector<double> now = at(seconds);
    if (path == "rotation") {
      local.turn = quaternion_of(now.data());
    } else {
      (path == "scale" ? local.scale : local.translation) = Vec3d{now[0], now[1], now[2]};
    }
  }

 private:
  std::vector<double> value(std::size_t key, std::size_t part = 1) const {
    const bool is_cubic = interpolation == "CUBICSPLINE";
    const std::size_t first = is_cubic ? (3 * key + part) * width : key * width;
    return {values.begin() + static_cast<std::ptrdiff_t>(first),
            values.begin() + static_cast<std::ptrdiff_t>(first + width)};
  }

  std::vector<double> at(double seconds) const {
    const auto next = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), seconds) - times.begin());
    if (next == 0) return value(0);
    if (next == times.size() || interpolation == "STEP") return value(next - 1);
    const double span = times[next] - times[next - 1];
    const double u = span > 0 ? (seconds - times[next - 1]) / span : 0;
    if (interpolation == "CUBICSPLINE") return cubic(next, span, u);
    return path == "rotation" ? turned(value(next - 1), value(next), u) : mixed(value(next - 1), value(next), u);
  }

  static std::vector<double> mixed(std::vector<double> a, const std::vector<double>& b, double u) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] += (b[i] - a[i]) * u;
    return a;
  }

  // Slerp.
  static std::vector<double> turned(const std::vector<double>& a, const std::vector<double>& b, double u) {
    const Quaternion from = quaternion_of(a.data());
    const Quaternion step = inverse(from) * quaternion_of(b.data());
    const Quaternion part = from * screw_of({step, {0, 0, 0}}, {0, 0, 0}).at(u).turn;
    return {part.v.x, part.v.y, part.v.z, part.w};
  }

  std::vector<double> cubic(std::size_t next, double span, double u) const {
    const std::vector<double> a = value(next - 1);
    const std::vector<double> leave = value(next - 1, 2);
    const std::vector<double> arrive = value(next, 0);
    const std::vector<double> b = value(next);
    const double u2 = u * u;
    const double u3 = u2 * u;
    std::vector<double> result(width);
    for (std::size_t i = 0; i < width; ++i) {
      result[i] = (2 * u3 - 3 * u2 + 1) * a[i] + span * (u3 - 2 * u2 + u) * leave[i] + (3 * u2 - 2 * u3) * b[i] +
                  span * (u3 - u2) * arrive[i];
    }
    return result;
  }
};

// The nodes of a file, moved by one animation.
struct Nodes {
  std::vector<Local> locals;
  std::vector<std::int32_t> parents;
  std::vector<Channel> channels;

  // Returns the world transforms at a time; std::nullopt: without animation.
  std::vector<BoneTransform> worlds(std::optional<double> seconds) const {
    std::vector<Local> now = locals;
    for (const Channel& channel : channels) {
      if (seconds) channel.apply(*seconds, now[channel.node]);
    }
    std::vector<std::optional<BoneTransform>> found(now.size());
    std::vector<BoneTransform> result(now.size());
    for (std::size_t n = 0; n < now.size(); ++n) {
      std::vector<std::size_t> way;
      for (auto at = static_cast<std::int32_t>(n); at >= 0 && !found[static_cast<std::size_t>(at)];
           at = parents[static_cast<std::size_t>(at)]) {
        way.push_back(static_cast<std::size_t>(at));
      }
      for (auto it = way.rbegin(); it != way.rend(); ++it) {
        const BoneTransform own = transform_of(now[*it]);
        found[*it] = parents[*it] < 0 ? own : after(*found[static_cast<std::size_t>(parents[*it])], own);
      }
      result[n] = *found[n];
    }
    return result;
  }
};

class Reader {
 public:
  Reader(const ShapeFile& shape, std::size_t animation)
      : layout_(detail::layout_of<gltf::Layout>(shape)), animation_(animation) {
    document_ = std::make_unique<Document>(gltf::open_source(shape));
  }

  SkinFile run() {
    if (document_->root().count("skins") == 0) {
      throw InvalidInput("the file has no skeleton (\"skins\"); export it with its armature");
    }
    read_nodes();
    read_animations();
    file_.skin.begin.assign(1, 0);
    for (const gltf::Block& block : layout_.blocks) add_block(block);
    if (file_.skin.rest.empty()) throw InvalidInput("no mesh of the scene hangs on a skeleton");
    find_parents();
    finish();
    return std::move(file_);
  }

 private:
  Value root() const { return document_->root(); }

  std::vector<double> numbers(std::size_t index, bool as_real = true) const {
    return gltf::read_accessor(*document_, index, gltf::find_accessor(*document_, index), as_real);
  }

  void read_nodes() {
    const std::size_t count = root().count("nodes");
    nodes_->parents.assign(count, -1);
    for (std::size_t n = 0; n < count; ++n) {
      const Value node = root().item("nodes", n);
      nodes_->locals.push_back(local_of(node));
      for (std::size_t i = 0; i < node.count("children"); ++i) {
        nodes_->parents[node.item("children", i).whole()] = static_cast<std::int32_t>(n);
      }
    }
  }

  void read_animations() {
    const std::size_t count = root().count("animations");
    for (std::size_t a = 0; a < count; ++a) {
      const std::optional<Value> name = root().item("animations", a).find("name");
      file_.animations.push_back(name ? name->text() : fmt::format("{}", a));
    }
    if (animation_ >= count) {
      if (animation_ == 0) return;
      throw InvalidInput(fmt::format("there is no animation {}; the file has {}", animation_, count));
    }
    const Value animation = root().item("animations", animation_);
    for (std::size_t c = 0; c < animation.count("channels"); ++c)
      read_channel(animation, animation.item("channels", c));
  }

  void read_channel(const Value& animation, const Value& of) {
    const Value target = of.at("target");
    const std::optional<std::size_t> node = target.whole("node");
    Channel channel;
    channel.path = target.at("path").text();
    if (!node || channel.path == "weights") return;
    if (*node >= nodes_->locals.size()) target.fail("names a node that is not there; repair the file");
    channel.node = *node;
    channel.width = channel.path == "rotation" ? 4 : 3;
    const Value sampler = animation.item("samplers", of.at("sampler").whole());
    const std::optional<Value> interpolation = sampler.find("interpolation");
    channel.interpolation = interpolation ? interpolation->text() : "LINEAR";
    channel.times = numbers(sampler.at("input").whole());
    channel.values = numbers(sampler.at("output").whole());
    const std::size_t per_key = channel.width * (channel.interpolation == "CUBICSPLINE" ? 3 : 1);
    if (channel.times.empty() || channel.values.size() != per_key * channel.times.size() ||
        !std::is_sorted(channel.times.begin(), channel.times.end())) {
      sampler.fail("has times and values that do not fit together; repair the file");
    }
    file_.duration = std::max(file_.duration, channel.times.back());
    nodes_->locals[*node].matrix.reset();
    nodes_->channels.push_back(std::move(channel));
  }

  // Reads the weights of a block's vertices by the skin of its node.
  void add_block(const gltf::Block& block) {
    const Value node = root().item("nodes", block.node);
    const std::optional<std::size_t> skin = node.whole("skin");
    const Value attributes =
        root().item("meshes", block.mesh).item("primitives", block.primitives.front()).at("attributes");
    std::vector<std::vector<BoneWeight>> rows(block.count);
    if (skin) {
      const std::vector<std::uint32_t>& bones = bones_of(*skin);
      for (int set = 0;; ++set) {
        const std::optional<std::size_t> joints = attributes.whole(fmt::format("JOINTS_{}", set).c_str());
        const std::optional<std::size_t> weights = attributes.whole(fmt::format("WEIGHTS_{}", set).c_str());
        if (!joints && !weights && set > 0) break;
        if (!joints || !weights) {
          attributes.fail(fmt::format("has {}; export the weights with the skeleton",
                                      joints    ? fmt::format("JOINTS_{0} without WEIGHTS_{0}", set)
                                      : weights ? fmt::format("WEIGHTS_{0} without JOINTS_{0}", set)
                                                : "a skin, but no JOINTS_0 and WEIGHTS_0"));
        }
        add_set(*joints, *weights, bones, rows);
      }
      note_free(rows, attributes);
    }
    for (const std::vector<BoneWeight>& row : rows) {
      file_.skin.weights.insert(file_.skin.weights.end(), row.begin(), row.end());
      file_.skin.begin.push_back(file_.skin.weights.size());
    }
  }

  void note_free(const std::vector<std::vector<BoneWeight>>& rows, const Value& attributes) {
    const auto is_free = [](const std::vector<BoneWeight>& row) { return row.empty(); };
    const auto count = static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), is_free));
    if (count == rows.size()) attributes.fail("has weights that are all 0; export the weights with the skeleton");
    if (count == 0) return;
    file_.notes.push_back(
        fmt::format("{} of {} vertices of a mesh have no weight; they go with most of the shape", count, rows.size()));
  }

  void add_set(std::size_t joints, std::size_t weights, const std::vector<std::uint32_t>& bones,
               std::vector<std::vector<BoneWeight>>& rows) const {
    constexpr double kMaxRounding = 1e-3;  // of exporters, which write weights slightly below 0
    const std::vector<double> joint = numbers(joints, false);
    const std::vector<double> weight = numbers(weights);
    if (joint.size() != 4 * rows.size() || weight.size() != 4 * rows.size()) {
      root().item("accessors", joints).fail("has not four joints and weights for each vertex; repair the file");
    }
    for (std::size_t i = 0; i < weight.size(); ++i) {
      if (!(weight[i] >= -kMaxRounding && std::isfinite(weight[i]))) {
        root().item("accessors", weights).fail(fmt::format("has the weight {}; repair the file", weight[i]));
      }
      if (!(weight[i] > 0)) continue;
      const auto number = static_cast<std::size_t>(joint[i]);
      if (number >= bones.size()) {
        root()
            .item("accessors", joints)
            .fail(fmt::format("names joint {}, but the skin has {}; repair the file", number, bones.size()));
      }
      rows[i / 4].push_back({bones[number], weight[i]});
    }
  }

  // Returns the bones of a skin's joints. Skins that bind a node with the same transform share its bone.
  const std::vector<std::uint32_t>& bones_of(std::size_t skin) {
    std::vector<std::uint32_t>& bones = bones_[skin];
    if (!bones.empty()) return bones;
    const Value value = root().item("skins", skin);
    const std::size_t count = value.at("joints").size();
    std::vector<double> matrices;
    if (const std::optional<std::size_t> accessor = value.whole("inverseBindMatrices")) matrices = numbers(*accessor);
    if (!matrices.empty() && matrices.size() < 16 * count)
      value.fail("has fewer matrices than joints; repair the file");
    for (std::size_t j = 0; j < count; ++j) {
      const std::size_t node = value.item("joints", j).whole();
      if (node >= nodes_->locals.size()) value.fail("names a node that is not there; repair the file");
      const BoneTransform bind = matrices.empty() ? BoneTransform{} : matrix_of(&matrices[16 * j]);
      bones.push_back(bone_of(node, bind));
    }
    return bones;
  }

  std::uint32_t bone_of(std::size_t node, const BoneTransform& bind) {
    for (std::size_t b = 0; b < node_of_.size(); ++b) {
      if (node_of_[b] == node && binds_[b] == bind) return static_cast<std::uint32_t>(b);
    }
    if (!(std::abs(determinant(bind.linear)) > 0)) {
      throw InvalidInput(fmt::format("the inverse bind matrix of node {} is flat; repair the file", node));
    }
    node_of_.push_back(node);
    binds_.push_back(bind);
    file_.skin.rest.push_back(inverse(bind));
    const std::optional<Value> name = root().item("nodes", node).find("name");
    const bool is_named = name && std::find(node_of_.begin(), node_of_.end() - 1, node) == node_of_.end() - 1;
    file_.skin.names.push_back(is_named ? name->text()
                                        : "");  // a node that two skins bind elsewhere is one bone by name
    return static_cast<std::uint32_t>(node_of_.size() - 1);
  }

  // The parent of a bone is the nearest node above it that is a bone.
  void find_parents() {
    std::map<std::size_t, std::size_t> first;
    for (std::size_t b = 0; b < node_of_.size(); ++b) first.emplace(node_of_[b], b);
    for (std::size_t b = 0; b < node_of_.size(); ++b) {
      std::int32_t parent = -1;
      for (std::int32_t at = nodes_->parents[node_of_[b]]; at >= 0 && parent < 0;
           at = nodes_->parents[static_cast<std::size_t>(at)]) {
        const auto found = first.find(static_cast<std::size_t>(at));
        if (found != first.end()) parent = static_cast<std::int32_t>(found->second);
      }
      if (first.at(node_of_[b]) != b) parent = static_cast<std::int32_t>(first.at(node_of_[b]));
      file_.skin.parents.push_back(parent);
    }
  }

  // Scales a skeleton in other units to those of the mesh.
  void finish() {
    const auto pose = [nodes = nodes_, bones = node_of_](std::optional<double> seconds) {
      const std::vector<BoneTransform> worlds = nodes->worlds(seconds);
      SkinPose result;
      for (const std::size_t node : bones) result.push_back(worlds[node]);
      return result;
    };
    file_.pose = pose(std::nullopt);
    const double scale = common_scale(file_.skin, file_.pose);
    const auto scaled = [scale](SkinPose result) {
      for (BoneTransform& bone : result) bone = {bone.linear * scale, bone.offset * scale};
      return result;
    };
    file_.pose = scaled(std::move(file_.pose));
    file_.at = [pose, scaled](double seconds) { return scaled(pose(seconds)); };
  }

  // Returns the factor that makes the bones' common scale 1; 1 if they have no common scale.
  static double common_scale(const Skin& skin, const SkinPose& pose) {
    constexpr double kSame = 1e-3;
    const std::vector<BoneTransform> motions = motions_of(skin, pose);
    const double first = elementary::cbrt(std::abs(determinant(motions.front().linear)));
    const bool is_common = std::all_of(motions.begin(), motions.end(), [&](const BoneTransform& m) {
      return std::abs(elementary::cbrt(std::abs(determinant(m.linear))) / first - 1) < kSame;
    });
    return is_common && std::abs(first - 1) > kSame ? 1 / first : 1;
  }

  const gltf::Layout& layout_;
  std::size_t animation_;
  std::unique_ptr<Document> document_;
  std::shared_ptr<Nodes> nodes_ = std::make_shared<Nodes>();
  std::map<std::size_t, std::vector<std::uint32_t>> bones_;  // by skin
  std::vector<std::size_t> node_of_;                         // of each bone
  std::vector<BoneTransform> binds_;
  SkinFile file_;
};

}  // namespace

SkinFile read_skin(const ShapeFile& shape, std::size_t animation) {
  if (shape.format != "glb" && shape.format != "gltf") {
    throw InvalidInput("only glTF files hold a skeleton; give a .glb or .gltf file");
  }
  return Reader(shape, animation).run();
}

}  // namespace knead
