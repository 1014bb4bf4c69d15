// Random strokes of every tool on closed shapes without self-intersections: how many pairs of triangles cross each
// other afterwards, and why.
//
//   crossings FOLDER [STROKES [SEED [TOOL]]]
//
// FOLDER holds the shapes; STROKES (200) are made for each tool, in turn over the shapes. Where triangles cross, the
// stroke is integrated again in double precision to 1e-9, which shows whether the integration made them; and the places
// where they cross are compared with where the flow takes them, which shows whether the triangles were too large for
// the deformation (sampling). What neither explains is an error of the fields or flows.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/vec.h"
#include "random_strokes.h"

namespace knead::surveys {
namespace {

constexpr double kFar = 10;

struct Subject {
  std::string name;
  Mesh mesh;
  std::vector<Vec3d> normals;
};

std::vector<Subject> subjects(const std::filesystem::path& folder) {
  std::vector<Subject> result;
  for (const char* name : {"armadillo_43k.ply", "bunny_35k.ply", "camel_35k.ply", "dragon_50k.ply", "fandisk_6k.ply",
                           "hand_50k.ply", "bust_maxplanck_5k.ply", "bust_nefertiti_35k.ply", "scorpion_6k.ply",
                           "sphere_16k.ply", "torus_2k.ply", "wingnut_3k.ply", "bar_6k.ply"}) {
    if (result.size() == 10 || !std::filesystem::exists(folder / name)) continue;
    Mesh mesh = read_shape(folder / name).mesh;
    if (self_intersections(triangulate(mesh), mesh.positions).count > 0) continue;
    std::vector<Vec3d> normals = vertex_normals(mesh);
    result.push_back({name, std::move(mesh), std::move(normals)});
  }
  return result;
}

Session session_of(const std::vector<SessionStroke>& strokes, const std::filesystem::path& folder) {
  Session session;
  session.name = (folder / "random.knead").string();
  session.strokes = strokes;
  return session;
}

struct Outcome {
  std::optional<SelfIntersections> crossings;  // std::nullopt: the stroke was refused or ran away
  std::vector<SessionStroke> resolved;
  std::vector<Vec3d> positions;
};

Outcome deform(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  try {
    ReplayResult result = replay(mesh, session, options);
    if (result.status != AdvectStatus::done) return {};
    return {self_intersections(triangulate(mesh), result.shape.positions()), std::move(result.resolved),
            std::move(result.shape).positions()};
  } catch (const InvalidInput&) {
    return {};
  }
}

Flow flow_of(const std::vector<SessionStroke>& strokes) {
  Flow flow;
  for (const SessionStroke& stroke : strokes) {
    const Flow part = knead::flow_of(stroke.stroke);
    flow.segments.insert(flow.segments.end(), part.segments.begin(), part.segments.end());
  }
  return flow;
}

using Corners = std::array<Vec3d, 3>;

Corners corners_of(const Triangle& t, const std::vector<Vec3d>& positions) {
  return {positions[t[0]], positions[t[1]], positions[t[2]]};
}

// Where an edge of one triangle, that has no corner of the other, passes through the other; nothing where rounding
// hides it.
std::optional<Vec3d> piercing(const Triangle& edge_triangle, const Triangle& face_triangle,
                              const std::vector<Vec3d>& positions) {
  const Corners edges = corners_of(edge_triangle, positions);
  const Corners face = corners_of(face_triangle, positions);
  const auto is_shared = [&](std::uint32_t v) {
    return std::find(face_triangle.begin(), face_triangle.end(), v) != face_triangle.end();
  };
  const Vec3d normal = cross(face[1] - face[0], face[2] - face[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    if (is_shared(edge_triangle[i]) || is_shared(edge_triangle[(i + 1) % 3])) continue;
    const Vec3d& a = edges[i];
    const Vec3d& b = edges[(i + 1) % 3];
    const double above = dot(normal, a - face[0]);
    const double below = dot(normal, b - face[0]);
    if (!(above * below < 0)) continue;
    const Vec3d x = a + (b - a) * (above / (above - below));
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
      inside = inside && dot(normal, cross(face[(k + 1) % 3] - face[k], x - face[k])) >= 0;
    }
    if (inside) return x;
  }
  return std::nullopt;
}

// The point of a triangle that x, in the plane of its image, is the straight image of.
Vec3d straight_preimage(const Vec3d& x, const Corners& image, const Corners& triangle) {
  const Vec3d normal = cross(image[1] - image[0], image[2] - image[0]);
  Vec3d sum{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d part = cross(image[(i + 2) % 3] - image[(i + 1) % 3], x - image[(i + 1) % 3]);
    sum += triangle[i] * (dot(normal, part) / norm2(normal));
  }
  return sum;
}

// Path lines cannot cross, so a point that two deformed triangles have in common is not where the flow takes both
// triangles: one at least has left the straight triangle through its corners there. How far, in units of what the
// integration errs, for the crossing pair where that is least; a pair whose common point rounding hides is left out.
double least_chord_error(const Mesh& mesh, const std::vector<Vec3d>& deformed, const SelfIntersections& crossings,
                         const Flow& flow, double size) {
  const std::vector<Triangle> triangles = triangulate(mesh);
  std::vector<Vec3d> common;
  std::vector<Vec3d> sources;  // two of each
  for (const auto& [t, u] : crossings.pairs) {
    std::optional<Vec3d> x = piercing(triangles[t], triangles[u], deformed);
    if (!x) x = piercing(triangles[u], triangles[t], deformed);
    if (!x) continue;
    common.push_back(*x);
    for (const Triangle& triangle : {triangles[t], triangles[u]}) {
      sources.push_back(straight_preimage(*x, corners_of(triangle, deformed), corners_of(triangle, mesh.positions)));
    }
  }
  const auto carried = [&](double tolerance) {
    AdvectOptions options;
    options.precision = Precision::float64;
    options.tolerance = tolerance * size;
    std::vector<Vec3d> points = sources;
    advect(flow, points, options);
    return points;
  };
  const std::vector<Vec3d> exact = carried(1e-10);
  const std::vector<Vec3d> nearly = carried(1e-8);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < common.size(); ++i) {
    const double chord = std::max(norm(exact[2 * i] - common[i]), norm(exact[2 * i + 1] - common[i]));
    const double error =
        std::max(norm(exact[2 * i] - nearly[2 * i]), norm(exact[2 * i + 1] - nearly[2 * i + 1])) + 1e-12 * size;
    least = std::min(least, chord / error);
  }
  return common.empty() ? 0 : least;
}

struct Row {
  std::size_t strokes = 0;
  std::size_t refused = 0;
  std::size_t crossed = 0;  // strokes with crossing pairs
  std::size_t pairs = 0;
  std::size_t only_float = 0;  // of those, none in double at 1e-9
  std::size_t sampling = 0;    // of those, none on the refined shape
};

void try_stroke(const std::string& tool, const Subject& subject, const Stroke& stroke,
                const std::filesystem::path& folder, Row& row) {
  ++row.strokes;
  const Outcome outcome = deform(subject.mesh, session_of({{stroke, 1}}, folder), {});
  if (!outcome.crossings) {
    ++row.refused;
    return;
  }
  if (outcome.crossings->count == 0) return;
  ++row.crossed;
  row.pairs += outcome.crossings->count;
  ReplayOptions precise;
  precise.motion.precision = Precision::float64;
  precise.motion.relative_tolerance = 1e-9;
  const Outcome again = deform(subject.mesh, session_of(outcome.resolved, folder), precise);
  std::string cause = "UNEXPLAINED";
  if (again.crossings && again.crossings->count == 0) {
    cause = "integration: none in double";
    ++row.only_float;
  } else if (again.crossings) {
    const double size = bounding_box(subject.mesh.positions).diagonal();
    const double error =
        least_chord_error(subject.mesh, again.positions, *again.crossings, flow_of(outcome.resolved), size);
    if (error > kFar) {
      cause = fmt::format("sampling: triangles off by {:.2g} times the integration's error or more", error);
      ++row.sampling;
    }
  }
  fmt::print("  {:9} {:24} {:6} pairs, {}\n", tool, subject.name, outcome.crossings->count, cause);
  if (cause == "UNEXPLAINED") fmt::print("    {}\n", stroke_line(stroke).substr(0, 2000));
  std::fflush(stdout);
}

int run(const std::filesystem::path& folder, std::size_t strokes, unsigned seed, const std::string& only) {
  const std::vector<Subject> shapes = subjects(folder);
  if (shapes.empty()) {
    fmt::print(stderr, "crossings: {}: no shape without self-intersections here\n", folder.string());
    return 3;
  }
  const auto stamp_folder = std::filesystem::temp_directory_path() / "knead_crossings";
  std::filesystem::create_directories(stamp_folder);
  write_mesh(stamp_folder / "stamp.ply", make_shape(ShapeKind::sphere, 2000));
  fmt::print("{} shapes, {} strokes a tool, seed {}\n", shapes.size(), strokes, seed);
  std::string table = fmt::format("{:9} {:>8} {:>8} {:>8} {:>8} {:>12} {:>9} {:>12}\n", "tool", "strokes", "refused",
                                  "crossed", "pairs", "integration", "sampling", "unexplained");
  for (const std::string& tool : tool_names()) {
    if (!only.empty() && tool != only) continue;
    std::mt19937_64 random(seed);
    Row row;
    for (std::size_t i = 0; i < strokes; ++i) {
      const Subject& subject = shapes[i % shapes.size()];
      const Stroke stroke = random_stroke(tool, subject.mesh, subject.normals, "stamp.ply", random);
      try_stroke(tool, subject, stroke, stamp_folder, row);
    }
    table += fmt::format("{:9} {:8} {:8} {:8} {:8} {:12} {:9} {:12}\n", tool, row.strokes, row.refused, row.crossed,
                         row.pairs, row.only_float, row.sampling, row.crossed - row.only_float - row.sampling);
  }
  fmt::print("{}", table);
  return 0;
}

}  // namespace
}  // namespace knead::surveys

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: crossings FOLDER [STROKES [SEED [TOOL]]]\n");
    return 2;
  }
  const auto number = [&](int i, unsigned long otherwise) {
    return argc > i ? std::strtoul(argv[i], nullptr, 10) : otherwise;
  };
  return knead::surveys::run(argv[1], number(2, 200), static_cast<unsigned>(number(3, 1)), argc > 4 ? argv[4] : "");
}
