// Poses beside the other ways to move a part of a shape: what each does to volume, crossings and triangles.
//   pose_bench [--detail D] [--export FOLDER] [MESH...]   procedural shapes, and closed meshes
// In a scene "turn" a part turns as a rigid body while another holds; in "tip" a pin takes its tip there while pins at
// the other ends hold; in "drag" one of eight pins goes round an arc of 50 degrees. --export writes the scenes for
// bench/pose_igl.py, which measures the deformations of libigl.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/vec.h"
#include "pose_scenes.h"

namespace {

using namespace knead;

constexpr std::size_t kMaxForHandles = 12'000;  // vertices: handles take minutes beyond

std::vector<VertexRange> ranges_of(const std::vector<std::uint32_t>& vertices) {
  std::vector<VertexRange> ranges;
  for (const std::uint32_t v : vertices) {
    if (!ranges.empty() && ranges.back().last + 1 == v) {
      ranges.back().last = v;
    } else {
      ranges.push_back({v, v});
    }
  }
  return ranges;
}

Stroke pose_of(const PoseScene& scene, double detail) {
  PoseStroke stroke;
  stroke.detail = detail;
  if (scene.turn) {
    PosePart moving;
    moving.vertices = ranges_of(scene.moving);
    moving.rotation = scene.turn;
    PosePart fixed;
    fixed.vertices = ranges_of(scene.fixed);
    fixed.hold = true;
    stroke.parts = {moving, fixed};
    return stroke;
  }
  PosePin dragged;
  dragged.vertex = scene.moving.front();
  dragged.path = scene.path;
  stroke.parts = {dragged};
  for (const std::uint32_t vertex : scene.fixed) {
    PosePin pin;
    pin.vertex = vertex;
    pin.hold = true;
    stroke.parts.emplace_back(pin);
  }
  return stroke;
}

Stroke handles_of(const PoseScene& scene) {
  HandlesStroke stroke;
  stroke.full_vertices = scene.moving;
  stroke.zero_vertices = scene.fixed;
  stroke.motion = *scene.turn;
  return stroke;
}

Stroke pins_of(const PoseScene& scene) {
  PinsStroke stroke;
  stroke.radius_auto = true;
  for (const auto* vertices : {&scene.moving, &scene.fixed}) {
    for (const std::uint32_t v : *vertices) {
      stroke.points.push_back(scene.mesh.positions[v]);
      stroke.to.push_back(vertices == &scene.moving ? scene.place_of(v) : scene.mesh.positions[v]);
    }
  }
  return stroke;
}

// The singular values of a triangle's map are within [least, greatest].
struct Stretched {
  double least = HUGE_VAL;
  double greatest = 0;
  double rms_log = 0;  // weighted by area
};

Stretched stretches(const std::vector<Triangle>& triangles, const std::vector<Vec3d>& before,
                    const std::vector<Vec3d>& after) {
  Stretched result;
  double sum = 0;
  double area = 0;
  for (const Triangle& t : triangles) {
    const Vec3d a = before[t[1]] - before[t[0]];
    const Vec3d b = before[t[2]] - before[t[0]];
    const double twice = norm(cross(a, b));
    if (!(twice > 0)) continue;
    // In an orthonormal frame of the triangle a = (x, 0) and b = (y, z).
    const double x = norm(a);
    const double y = dot(a, b) / x;
    const double z = twice / x;
    const Vec3d u = (after[t[1]] - after[t[0]]) / x;
    const Vec3d v = ((after[t[2]] - after[t[0]]) - u * y) / z;
    const double mean = 0.5 * (norm2(u) + norm2(v));
    const double apart = std::hypot(0.5 * (norm2(u) - norm2(v)), dot(u, v));
    const double greatest = std::sqrt(mean + apart);
    const double least = norm(cross(u, v)) / greatest;
    result.greatest = std::max(result.greatest, greatest);
    result.least = std::min(result.least, least);
    sum += twice * (std::log(greatest) * std::log(greatest) + std::log(least) * std::log(least)) / 2;
    area += twice;
  }
  result.rms_log = std::sqrt(sum / area);
  return result;
}

struct Way {
  std::string name;
  Stroke stroke;
};

void show(const PoseScene& scene, const Way& way, const std::shared_ptr<const Mesh>& mesh) {
  Session session;
  session.name = way.name;
  session.strokes.push_back({way.stroke});
  const auto began = std::chrono::steady_clock::now();
  std::vector<Vec3d> after;
  try {
    after = replay(mesh, session).shape.positions();
  } catch (const InvalidInput& error) {
    fmt::print("| {} | {} | refused: {} |\n", scene.name, way.name, error.what());
    return;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const std::vector<Triangle> triangles = triangulate(*mesh);
  const double volume = measure_volume_and_area(*mesh, mesh->positions).volume;
  const Stretched stretched = stretches(triangles, mesh->positions, after);
  double off = 0;
  for (const std::uint32_t v : scene.moving) off = std::max(off, norm(after[v] - scene.place_of(v)));
  for (const std::uint32_t v : scene.fixed) off = std::max(off, norm(after[v] - mesh->positions[v]));
  fmt::print("| {} | {} | {} | {:+.1e} | {} | {:.2f}, {:.2f} | {:.4f} | {:.1e} | {:.2f} |\n", scene.name,
             mesh->positions.size(), way.name, measure_volume_and_area(*mesh, after).volume / volume - 1,
             self_intersections(triangles, after).count, stretched.least, stretched.greatest, stretched.rms_log,
             off / bounding_box(mesh->positions).diagonal(), seconds);
  std::fflush(stdout);
}

void show(const PoseScene& scene, double detail) {
  const auto mesh = std::make_shared<const Mesh>(scene.mesh);
  std::vector<Way> ways{{"pose", pose_of(scene, detail)}};
  if (!scene.turn) ways.push_back({"pins", pins_of(scene)});
  if (scene.turn && scene.mesh.positions.size() <= kMaxForHandles) ways.push_back({"handles", handles_of(scene)});
  if (scene.bend) ways.push_back({"bend", *scene.bend});
  for (const Way& way : ways) show(scene, way, mesh);
  if (scene.least_strain > 0) {
    fmt::print("| {} | | least possible | 0 | 0 | {:.2f}, {:.2f} | | | |\n", scene.name, 1 - scene.least_strain,
               1 + scene.least_strain);
  }
}

// NAME.ply, and NAME.csv with a line for each marked vertex: its number, and where it should be at ten moments.
void write_scene(const PoseScene& scene, const std::filesystem::path& folder) {
  std::string name = scene.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == ',' || c == ' '; }, '_');
  write_mesh(folder / (name + ".ply"), scene.mesh);
  std::ofstream file(folder / (name + ".csv"));
  constexpr int kMoments = 10;
  for (const auto* vertices : {&scene.moving, &scene.fixed}) {
    for (const std::uint32_t v : *vertices) {
      file << v;
      for (int k = 1; k <= kMoments; ++k) {
        const Vec3d place = vertices == &scene.fixed ? scene.mesh.positions[v] : scene.place_of(v, 0.1 * k);
        file << fmt::format(",{},{},{}", place.x, place.y, place.z);
      }
      file << '\n';
    }
  }
}

double seconds_of(const std::function<void()>& work) {
  const auto began = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

// A pointer drags the pin of a scene along its path, with a coarse grid as in Studio, and then rests.
void show_drag(const PoseScene& scene, double detail) {
  constexpr double kCoarse = 0.1;
  constexpr std::size_t kPerPiece = 4;  // places of the pointer
  Workbench bench(scene.mesh);
  bench.prepare();
  PoseStroke pose = std::get<PoseStroke>(pose_of(scene, kCoarse));
  PosePin& pin = std::get<PosePin>(pose.parts.front());
  Vec3d from = scene.mesh.positions[*pin.vertex];
  pin.path.clear();
  std::vector<double> batches;
  for (const Vec3d& to : scene.path) {
    pin.path.push_back(to);
    for (std::size_t i = 1; i <= kPerPiece; ++i) {
      pin.path.back() = from + (to - from) * (static_cast<double>(i) / kPerPiece);
      batches.push_back(seconds_of([&] { bench.set_live({{pose}}, nullptr, true); }));
    }
    from = to;
  }
  pose.detail = detail;
  const double rest = seconds_of([&] { bench.set_live({{pose}}); });
  const double first = batches.front();
  batches.erase(batches.begin());
  std::sort(batches.begin(), batches.end());
  fmt::print("| {} | {} | {:.0f} | {:.0f} | {:.0f} | {:.2f} |\n", scene.name, scene.mesh.vertex_count(), 1e3 * first,
             1e3 * batches[batches.size() / 2], 1e3 * batches[batches.size() * 9 / 10], rest);
}

struct Arguments {
  double detail = PoseStroke{}.detail;
  std::filesystem::path folder;
  std::vector<std::filesystem::path> meshes;
};

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--detail" && i + 1 < argc) {
      arguments.detail = std::stod(argv[++i]);
    } else if (word == "--export" && i + 1 < argc) {
      arguments.folder = argv[++i];
    } else {
      arguments.meshes.emplace_back(word);
    }
  }
  return arguments;
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments arguments = parse(argc, argv);
  std::vector<PoseScene> scenes = procedural_scenes();
  for (const std::filesystem::path& path : arguments.meshes) {
    for (PoseScene& scene : scenes_of(path.stem().string(), read_shape(path).mesh)) scenes.push_back(std::move(scene));
  }
  fmt::print(
      "detail {}; stretch: the least and the greatest singular value of a triangle's map; place: the greatest "
      "distance of a\nmarked vertex from its place, of the diagonal\n\n",
      arguments.detail);
  fmt::print("| scene | vertices | way | volume | crossing pairs | stretch | rms of log stretch | place | seconds |\n");
  fmt::print("| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (const PoseScene& scene : scenes) {
    show(scene, arguments.detail);
    if (!arguments.folder.empty()) write_scene(scene, arguments.folder);
  }
  fmt::print("\nA pin follows a pointer, detail 0.1: milliseconds for each place of the pointer; seconds at rest\n\n");
  fmt::print("| scene | vertices | first | median | 9 of 10 | at rest, detail {} |\n", arguments.detail);
  fmt::print("| --- | ---: | ---: | ---: | ---: | ---: |\n");
  for (const PoseScene& scene : scenes) {
    if (scene.path.size() > 1) show_drag(scene, arguments.detail);
  }
}
