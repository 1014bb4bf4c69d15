// The nodes of a glTF file's scene, and where they stand.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/gltf/gltf.h"
#include "io/mesh_builder.h"

namespace knead::detail::gltf {
namespace {

struct Transform {
  Mat3d linear;
  Vec3d offset;
};

// Column-major, as in glTF.
Transform from_matrix(const Value& matrix) {
  constexpr double kRounding = 1e-6;  // of exporters that multiply in float
  const std::vector<double> m = matrix.numbers(16);
  const double beyond = std::abs(m[3]) + std::abs(m[7]) + std::abs(m[11]) + std::abs(m[15] - 1);
  if (!(beyond <= kRounding)) matrix.fail("has a last row that is not 0 0 0 1; repair the file");
  return {{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}, {m[12], m[13], m[14]}};
}

Mat3d from_quaternion(const Value& rotation) {
  const std::vector<double> q = rotation.numbers(4);
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(size > 0) || !std::isfinite(size)) rotation.fail("is no rotation: its length is not positive; repair the file");
  const double x = q[0] / size;
  const double y = q[1] / size;
  const double z = q[2] / size;
  const double w = q[3] / size;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
          {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
          {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
}

Transform local_transform(const Value& node) {
  if (const std::optional<Value> matrix = node.find("matrix")) return from_matrix(*matrix);
  Transform transform;
  if (const std::optional<Value> rotation = node.find("rotation")) transform.linear = from_quaternion(*rotation);
  if (const std::optional<Value> scale = node.find("scale")) {
    const std::vector<double> s = scale->numbers(3);
    transform.linear = transform.linear * Mat3d({s[0], 0, 0}, {0, s[1], 0}, {0, 0, s[2]});
  }
  if (const std::optional<Value> translation = node.find("translation")) {
    const std::vector<double> t = translation->numbers(3);
    transform.offset = {t[0], t[1], t[2]};
  }
  return transform;
}

bool is_finite(const Transform& t) {
  return knead::is_finite(t.linear.row0) && knead::is_finite(t.linear.row1) && knead::is_finite(t.linear.row2) &&
         knead::is_finite(t.offset);
}

// Nothing where the columns are so nearly in one plane that going back would lose every digit.
std::optional<Placement> invertible(const Transform& t) {
  constexpr double kFlattest = 1e-12;  // volume of the unit columns
  Vec3d unit[3];
  double size[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d column = t.linear.column(i);
    size[i] = norm(column);
    if (!std::isnormal(size[i])) return std::nullopt;
    unit[i] = column / size[i];
  }
  const double volume = dot(unit[0], cross(unit[1], unit[2]));
  if (!(std::abs(volume) > kFlattest)) return std::nullopt;
  const Mat3d inverse{cross(unit[1], unit[2]) / volume / size[0], cross(unit[2], unit[0]) / volume / size[1],
                      cross(unit[0], unit[1]) / volume / size[2]};
  if (!is_finite({inverse, {}})) return std::nullopt;
  return Placement{t.linear, t.offset, inverse};
}

// Every node reached from the roots once, or the nodes are no forest.
class Forest {
 public:
  explicit Forest(const Document& document) : root_(document.root()), has_parent_(root_.count("nodes"), false) {
    for (std::size_t i = 0; i < has_parent_.size(); ++i) {
      for (const std::size_t child : children(node(i))) {
        if (child >= has_parent_.size()) node(child);
        if (has_parent_[child]) node(child).fail("has two parents or is given twice; repair the file");
        has_parent_[child] = true;
      }
    }
    check_no_cycle();
  }

  Value node(std::size_t i) const { return root_.item("nodes", i); }

  // The nodes below which the scene is.
  std::vector<std::size_t> scene_roots() const {
    if (root_.count("scenes") == 0) return all_roots();
    const Value scene = root_.item("scenes", root_.whole("scene").value_or(0));
    std::vector<std::size_t> roots;
    std::vector<bool> named(has_parent_.size(), false);
    for (std::size_t i = 0; i < scene.count("nodes"); ++i) {
      const Value item = scene.item("nodes", i);
      const std::size_t n = item.whole();
      if (n >= named.size()) node(n);
      if (named[n] || has_parent_[n]) item.fail("is a node that has a parent or is given twice; repair the file");
      named[n] = true;
      roots.push_back(n);
    }
    return roots;
  }

  // Calls visit(node's number, world transform) for the trees below the roots, parents first.
  template <class Visit>
  void for_each_below(const std::vector<std::size_t>& roots, Visit visit) const {
    std::vector<std::pair<std::size_t, Transform>> waiting;
    const auto push = [&](const std::vector<std::size_t>& nodes, const Transform& transform) {
      const std::size_t begin = waiting.size();
      for (const std::size_t n : nodes) waiting.emplace_back(n, transform);
      std::reverse(waiting.begin() + static_cast<std::ptrdiff_t>(begin), waiting.end());
    };
    push(roots, {});
    while (!waiting.empty()) {
      const auto [n, parent] = waiting.back();
      waiting.pop_back();
      const Transform local = local_transform(node(n));
      const Transform world{parent.linear * local.linear, parent.linear * local.offset + parent.offset};
      visit(n, world);
      push(children(node(n)), world);
    }
  }

 private:
  static std::vector<std::size_t> children(const Value& node) {
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < node.count("children"); ++i) result.push_back(node.item("children", i).whole());
    return result;
  }

  std::vector<std::size_t> all_roots() const {
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < has_parent_.size(); ++i) {
      if (!has_parent_[i]) roots.push_back(i);
    }
    return roots;
  }

  // Nodes with one parent each that no root reaches go round in a circle.
  void check_no_cycle() const {
    std::size_t reached = 0;
    std::vector<std::size_t> waiting = all_roots();
    while (!waiting.empty()) {
      const std::vector<std::size_t> below = children(node(waiting.back()));
      waiting.pop_back();
      waiting.insert(waiting.end(), below.begin(), below.end());
      ++reached;
    }
    if (reached < has_parent_.size()) root_.at("nodes").fail("some nodes are their own ancestors; repair the file");
  }

  Value root_;
  std::vector<bool> has_parent_;
};

}  // namespace

std::vector<Instance> find_instances(const Document& document, std::vector<std::string>& notes) {
  const Forest forest(document);
  std::vector<Instance> instances;
  std::size_t skinned = 0;
  std::size_t singular = 0;
  std::size_t repeated = 0;
  forest.for_each_below(forest.scene_roots(), [&](std::size_t n, Transform world) {
    const Value node = forest.node(n);
    const std::optional<std::size_t> mesh = node.whole("mesh");
    if (!mesh) return;
    if (node.find("skin")) {
      ++skinned;
      world = {};
    }
    if (!is_finite(world)) node.fail("has a transform that is not finite; repair the file");
    const std::optional<Value> extensions = node.find("extensions");
    if (extensions && extensions->find("EXT_mesh_gpu_instancing")) ++repeated;
    if (const std::optional<Placement> placement = invertible(world)) {
      instances.push_back({n, *mesh, *placement});
    } else {
      ++singular;
    }
  });
  const auto note = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) notes.push_back(counted(count, one, many));
  };
  note(skinned, "mesh hangs on a skeleton; its vertices are read at rest, and skeleton and animations stay as they are",
       "meshes hang on skeletons; their vertices are read at rest, and skeletons and animations stay as they are");
  note(singular, "node is left out: its transform is flat, so that nothing could be written back",
       "nodes are left out: their transforms are flat, so that nothing could be written back");
  note(repeated, "node is drawn in several places (EXT_mesh_gpu_instancing); it is read once and they all follow",
       "nodes are drawn in several places (EXT_mesh_gpu_instancing); each is read once and its places follow");
  return instances;
}

}  // namespace knead::detail::gltf
