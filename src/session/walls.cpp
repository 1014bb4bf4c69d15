// Walls of a session: patches of a volume mesh that stay, or slide in their planes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "session/stroke_json.h"
#include "strokes/mirror.h"

namespace knead {
namespace {

constexpr double kFlat = 1e-7;       // of the diagonal of the shape: how far a plane patch leaves its plane
constexpr double kBorder = 0.05;     // of the diagonal: the width around what is held, where none is given
constexpr double kAlongAxis = 1e-9;  // a normal this near to an axis is that axis

Vec3d mean_of(std::span<const std::uint32_t> numbers, std::span<const Vec3d> points) {
  Vec3d sum{0, 0, 0};
  for (const std::uint32_t i : numbers) sum += points[i];
  return sum / static_cast<double>(numbers.size());
}

// The plane through three points of the patch that are far apart; of points on a line, or of a mesh of two dimensions,
// the plane at a right angle to z = 0. Nothing for fewer than two different points.
std::optional<MirrorPlane> plane_of(std::span<const std::uint32_t> numbers, std::span<const Vec3d> points,
                                    double tolerance) {
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
  if (!(norm(normal) > tolerance * norm(along))) normal = cross(along, Vec3d{0, 0, 1});
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

MirrorPlane plane_of_wall(const Patch& patch, std::span<const Vec3d> points, double diagonal, const Place& place) {
  const std::optional<MirrorPlane> plane = plane_of(patch.points, points, kFlat * diagonal);
  if (!plane) throw InvalidInput(place, fmt::format("the patch \"{}\" is a point, and cannot slide", patch.name));
  double distance = 0;
  for (const std::uint32_t i : patch.points) {
    distance = std::max(distance, std::abs(dot(points[i] - plane->point, plane->normal)));
  }
  if (distance <= kFlat * diagonal) return *plane;
  throw InvalidInput(place,
                     fmt::format("the patch \"{}\" is not plane: a point is {:.3g} off; a patch that slides must be "
                                 "plane, so hold it",
                                 patch.name, distance));
}

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

Session on_walls(Session session, std::span<const Patch> patches, std::span<const Vec3d> points) {
  const Place place{session.name, 1};
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  std::vector<Vec3d> held;
  Mirror mirror;
  double width = kBorder * box.diagonal();
  for (Wall& wall : session.walls) {
    const Patch& patch = patch_named(wall.patch, patches, place);
    wall.points = patch.points;
    if (wall.slides) {
      wall.plane = plane_of_wall(patch, points, box.diagonal(), place);
      if (std::find(mirror.begin(), mirror.end(), *wall.plane) == mirror.end()) mirror.push_back(*wall.plane);
      continue;
    }
    for (const std::uint32_t i : patch.points) held.push_back(points[i]);
    if (wall.width) width = *wall.width;
  }
  if (!session.walls.empty() && box.min.z == box.max.z) {  // of two dimensions: the plane of the mesh is a wall, too
    Wall& flat = session.walls.emplace_back(Wall{"", true});
    flat.plane = MirrorPlane{{0, 0, 1}, {0, 0, box.min.z}};
    flat.points.resize(points.size());
    std::iota(flat.points.begin(), flat.points.end(), 0U);
    mirror.push_back(*flat.plane);
  }
  try {
    validate(mirror);
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

double put_on_walls(const Session& session, std::span<Vec3d> points) {
  double greatest = 0;
  for (const Wall& wall : session.walls) {
    if (!wall.plane) continue;
    const auto& [normal, point] = *wall.plane;
    for (const std::uint32_t i : wall.points) {
      if (i >= points.size()) throw InvalidInput("the points are not those of the mesh that has the walls");
      const double distance = dot(points[i] - point, normal) / dot(normal, normal);
      const Vec3d before = points[i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool is_axis = std::abs(normal[axis]) == 1;
        points[i][axis] = is_axis ? point[axis] : points[i][axis] - distance * normal[axis];
      }
      greatest = std::max(greatest, norm(points[i] - before));
    }
  }
  return greatest;
}

namespace session_detail {

std::vector<Wall> read_walls(const JsonValue& value, const Place& place) {
  std::vector<Wall> walls;
  for (const JsonValue& item : value.items()) {
    const JsonObject object(item, place, "a wall");
    object.allow({"patch", "hold", "slide", "width"});
    Wall wall{object.at("patch").text()};
    const bool holds = object.has("hold") && object.at("hold").flag();
    wall.slides = object.has("slide") && object.at("slide").flag();
    if (holds == wall.slides) {
      throw InvalidInput(place, fmt::format("the wall \"{}\" needs \"hold\": true or \"slide\": true", wall.patch));
    }
    wall.width = object.optional_number("width");
    if (wall.width && (wall.slides || !(*wall.width > 0))) {
      object.at("width").fail("a length greater than 0, of a wall that is held");
    }
    walls.push_back(std::move(wall));
  }
  return walls;
}

}  // namespace session_detail
}  // namespace knead
