// Walls of a session: patches of a volume mesh that stay, or slide in their planes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "engineering/mesh_walls.h"
#include "strokes/mirror.h"

namespace knead {

using namespace detail;

namespace {

constexpr double kAlike = 1e-6;   // of the diagonal: the greatest difference of periodic patches
constexpr double kFlat = 1e-7;    // of the diagonal of the shape: the greatest distance of a plane patch from its plane
constexpr double kBorder = 0.05;  // of the diagonal: the default width around a held wall
constexpr double kAlongAxis = 1e-9;  // a normal this near to an axis is that axis

Vec3d mean_of(std::span<const std::uint32_t> numbers, std::span<const Vec3d> points) {
  Vec3d sum{0, 0, 0};
  for (const std::uint32_t i : numbers) sum += points[i];
  return sum / static_cast<double>(numbers.size());
}

// The plane through three points of the patch that are far apart; of points on a line, or of a mesh of two dimensions,
// the plane at a right angle to z = 0 through two of them. Nothing for fewer than two different points.
std::optional<MirrorPlane> plane_of(std::span<const std::uint32_t> numbers, std::span<const Vec3d> points,
                                    double tolerance, bool is_flat) {
  const Vec3d center = mean_of(numbers, points);
  const auto farthest = [&](const auto& distance) {
    return points[*std::max_element(numbers.begin(), numbers.end(), [&](std::uint32_t a, std::uint32_t b) {
      return distance(points[a]) < distance(points[b]);
    })];
  };
  const Vec3d first = farthest([&](const Vec3d& p) { return norm(p - center); });
  const Vec3d second = farthest([&](const Vec3d& p) { return norm(p - first); });
  const Vec3d along = second - first;
  if (!(norm(along) > tolerance)) return std::nullopt;
  const Vec3d third = farthest([&](const Vec3d& p) { return norm(cross(p - first, along)); });
  Vec3d normal = cross(third - first, along);
  if (is_flat || !(norm(normal) > tolerance * norm(along))) normal = cross(along, Vec3d{0, 0, 1});
  if (!(norm(normal) > 0)) return std::nullopt;
  normal = normal / norm(normal);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(normal[axis]) < 1 - kAlongAxis) continue;
    normal = {0, 0, 0};
    normal[axis] = 1;
    Vec3d point{0, 0, 0};
    point[axis] = first[axis];
    return MirrorPlane{normal, point};
  }
  return MirrorPlane{normal, first};
}

const Patch& patch_named(const std::string& name, std::span<const Patch> patches, const Place& place) {
  std::string known;
  for (const Patch& patch : patches) {
    if (patch.name == name) return patch;
    known += fmt::format("{}\"{}\"", known.empty() ? "the mesh has " : ", ", patch.name);
  }
  if (known.empty()) known = "the mesh has none; walls need a mesh of gmsh, SU2 or OpenFOAM that names its patches";
  throw InvalidInput(place, fmt::format("no patch \"{}\"; {}", name, known));
}

// The plane of the patch; nothing if it is not plane.
std::optional<MirrorPlane> plane_of_wall(const Patch& patch, std::span<const Vec3d> points, const Box& box,
                                         const Place& place) {
  const double diagonal = box.diagonal();
  const std::optional<MirrorPlane> plane = plane_of(patch.points, points, kFlat * diagonal, box.min.z == box.max.z);
  if (!plane) throw InvalidInput(place, fmt::format("the patch \"{}\" is a point, and cannot slide", patch.name));
  const bool is_plane = std::all_of(patch.points.begin(), patch.points.end(), [&](std::uint32_t i) {
    return std::abs(dot(points[i] - plane->point, plane->normal)) <= kFlat * diagonal * norm(plane->normal);
  });
  return is_plane ? plane : std::nullopt;
}

bool are_valid(const Mirror& mirror) {
  try {
    validate(mirror);
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

// Finds the walls of a session on a mesh.
class WallFinder {
 public:
  WallFinder(std::span<const Vec3d> points, double diagonal, Place place)
      : points_(points), diagonal_(diagonal), place_(std::move(place)) {}

  void add_held(const Patch& patch) {
    std::vector<Triangle> faces = patch.faces;
    for (const std::uint32_t i : patch.points) {
      if (patch.faces.empty()) faces.push_back({i, i, i});
    }
    held_.push_back({WallSurface(Form::fixed, patch.points, faces, points_)});
  }

  // A plane at another angle than the mirrors', or a curved patch.
  void add_slide(const Patch& patch, const Wall& wall, const std::optional<MirrorPlane>& plane) {
    require_faces(patch, "slide on, and is no plane at right angles to others");
    const std::optional<RoundForm> round = plane ? std::nullopt : detail::round_form_of(patch.faces, points_);
    const Form form = plane ? Form::plane : round ? Form::round : Form::polygons;
    SlidingWall& added =
        parts_.walls.emplace_back(SlidingWall{WallSurface(form, patch.points, patch.faces, points_), wall.width});
    if (plane) added.surface.set_plane(plane->normal / norm(plane->normal));
    if (round) added.surface.set_round(*round);
  }

  void add_layers(const Patch& patch, const Wall& wall) {
    require_faces(patch, "keep layers on");
    parts_.walls.push_back({WallSurface(Form::open, patch.points, patch.faces, points_), wall.width, true, true});
  }

  void add_periodic(const Patch& patch, const Patch& other, const Wall& wall) {
    for (const Patch* const side : {&patch, &other}) {
      require_faces(*side, "be periodic by");
      parts_.walls.push_back({WallSurface(Form::open, side->points, side->faces, points_), wall.width});
    }
    add_pairs(patch, other);
  }

  // A plane in which all strokes are mirrored.
  void add_mirror(const MirrorPlane& plane, std::vector<std::uint32_t> numbers) {
    parts_.planes.push_back({plane, std::move(numbers)});
  }

  std::shared_ptr<const MeshWalls> find(const WallOptions& options) {
    if (!parts_.walls.empty()) add_common_points();
    return std::make_shared<const MeshWalls>(std::move(parts_), points_, diagonal_, options);
  }

 private:
  using Form = WallSurface::Form;

  // Beside walls that put points back, mirrors keep the points that they have in common with these.
  void add_common_points() {
    std::vector<std::uint8_t> slides(points_.size());
    for (const SlidingWall& wall : parts_.walls) {
      for (const std::uint32_t i : wall.surface.numbers()) slides[i] = 1;
    }
    for (const auto& [plane, numbers] : parts_.planes) {
      std::vector<std::uint32_t> common;
      std::copy_if(numbers.begin(), numbers.end(), std::back_inserter(common),
                   [&](std::uint32_t i) { return slides[i] != 0; });
      if (common.empty()) continue;
      SlidingWall& mirror = parts_.walls.emplace_back(SlidingWall{WallSurface(Form::plane, common, {}, points_)});
      mirror.surface.set_plane(plane.normal / norm(plane.normal));
      mirror.is_followed = false;
    }
    std::move(held_.begin(), held_.end(), std::back_inserter(parts_.walls));
  }

  void require_faces(const Patch& patch, const char* what) const {
    if (!patch.faces.empty()) return;
    throw InvalidInput(place_, fmt::format("the patch \"{}\" has no faces to {}", patch.name, what));
  }

  // Both patches' points in the order of their places, which a shift nearly keeps: each is paired with the nearest one.
  void add_pairs(const Patch& patch, const Patch& other) {
    const double near = kAlike * diagonal_;
    const Vec3d shift = mean_of(other.points, points_) - mean_of(patch.points, points_);
    std::vector<Triangle> places;
    for (const std::uint32_t i : other.points) places.push_back({i, i, i});
    const SurfaceTree tree(places, points_);
    std::vector<std::uint8_t> is_taken(points_.size());
    for (const std::uint32_t i : patch.points) {
      const auto found = tree.closest(points_[i] + shift, near);
      const std::uint32_t twin = found ? other.points[found->triangle] : 0;
      if (!found || is_taken[twin] != 0 || patch.points.size() != other.points.size()) {
        throw InvalidInput(place_, fmt::format("the patch \"{}\" is not a shifted copy of \"{}\", to 1e-6 of the "
                                               "diagonal; periodic patches must be",
                                               other.name, patch.name));
      }
      is_taken[twin] = 1;
      parts_.pairs.push_back({i, twin});
    }
  }

  std::span<const Vec3d> points_;
  double diagonal_;
  Place place_;
  WallParts parts_;
  std::vector<SlidingWall> held_;
};

// Adds the held places and their mirror images to each mask, and begins with a mask of them.
void hold(Session& session, std::span<const Vec3d> held, double width) {
  const Place place{session.name, 1};
  session.strokes.insert(session.strokes.begin(), SessionStroke{MaskStroke{}, 1});
  for (SessionStroke& stroke : session.strokes) {
    auto* mask = std::get_if<MaskStroke>(&stroke.stroke);
    if (mask == nullptr) continue;
    if (!mask->vertices.empty()) {
      throw InvalidInput(Place{session.name, stroke.line}, "beside walls a mask must be given by points");
    }
    if (is_empty(*mask)) mask->width = width;
    if (!mask->values.empty()) mask->values.resize(mask->points.size() + held.size(), 1);
    mask->points.insert(mask->points.end(), held.begin(), held.end());
  }
}

}  // namespace

Session on_walls(Session session, std::span<const Patch> patches, std::span<const Vec3d> points,
                 const WallOptions& options) {
  const Place place{session.name, 1};
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  std::vector<Vec3d> held;
  Mirror mirror;
  double width = kBorder * box.diagonal();
  WallFinder finder(points, box.diagonal(), place);
  if (session.walls.empty()) {
    if (options.cells && options.cells->size() > 0) session.constraint = finder.find(options);
    return session;
  }
  if (box.min.z == box.max.z) {  // of two dimensions: the plane of the mesh is a wall, too
    mirror.push_back({{0, 0, 1}, {0, 0, box.min.z}});
    std::vector<std::uint32_t> all(points.size());
    std::iota(all.begin(), all.end(), 0U);
    finder.add_mirror(mirror.front(), std::move(all));
  }
  for (const Wall& wall : session.walls) {
    stop_if_cancelled(options.progress);
    const Patch& patch = patch_named(wall.patch, patches, place);
    if (patch.points.empty()) throw InvalidInput(place, fmt::format("the patch \"{}\" has no points", patch.name));
    if (!wall.periodic.empty()) {
      finder.add_periodic(patch, patch_named(wall.periodic, patches, place), wall);
    } else if (wall.keeps_layers) {
      finder.add_layers(patch, wall);
    } else if (wall.slides) {
      const std::optional<MirrorPlane> plane = plane_of_wall(patch, points, box, place);
      Mirror more = mirror;
      if (plane) more.push_back(*plane);
      const bool is_known = plane && std::find(mirror.begin(), mirror.end(), *plane) != mirror.end();
      if (is_known || (plane && are_valid(more))) {
        finder.add_mirror(*plane, patch.points);
        if (!is_known) mirror = std::move(more);
      } else {
        finder.add_slide(patch, wall, plane);
      }
    } else {
      for (const std::uint32_t i : patch.points) held.push_back(points[i]);
      finder.add_held(patch);
      if (wall.width) width = *wall.width;
    }
  }
  session.constraint = finder.find(options);
  try {
    session.strokes = mirrored_in(std::move(session.strokes), mirror);
  } catch (const InvalidInput& error) {
    throw InvalidInput(place, std::string("walls that slide: ") + error.what());
  }
  if (held.empty()) return session;
  const std::size_t count = held.size();
  for (const SymmetryImage& image : images_in(mirror)) {
    for (std::size_t i = 0; i < count; ++i) held.push_back(image.motion(held[i]));
  }
  hold(session, held, width);
  return session;
}

}  // namespace knead
