// Random strokes of every tool on closed shapes without self-intersections: how many pairs of triangles cross each
// other afterwards, and why.
//
//   crossings FOLDER [STROKES [SEED [TOOL]]]
//
// FOLDER holds the shapes; STROKES (200) are made for each tool, in turn over the shapes. Where triangles cross, the
// stroke is integrated again in double precision to 1e-9, which shows whether the integration made them; and on the
// undeformed shape with its crossing triangles cut smaller, round by round, which shows whether its triangles were too
// large for the deformation (sampling). What neither explains is an error of the fields or flows.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "knead/io/shape_file.h"
#include "knead/math/error.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/normals.h"
#include "knead/mesh/self_intersections.h"
#include "knead/mesh/shapes.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/replay.h"
#include "random_strokes.h"

namespace knead::acceptance {
namespace {

constexpr int kRounds = 8;
constexpr std::size_t kMostTriangles = 2'000'000;
constexpr std::size_t kMostPairs = 100'000;

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
  std::optional<SelfIntersections> crossings;  // none: the stroke was refused or ran away
  std::vector<SessionStroke> resolved;
};

Outcome deform(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  try {
    ReplayResult result = replay(mesh, session, options);
    if (result.status != AdvectStatus::done) return {};
    return {self_intersections(triangulate(mesh), result.positions, {.limit = kMostPairs}), std::move(result.resolved)};
  } catch (const InvalidInput&) {
    return {};
  }
}

// The mesh with the edges of some triangles cut at their middles: the same surface.
Mesh refined(const Mesh& mesh, const std::set<std::uint32_t>& chosen) {
  const std::vector<Triangle> triangles = triangulate(mesh);
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> middles;
  Mesh result;
  result.positions = mesh.positions;
  const auto key = [](std::uint32_t a, std::uint32_t b) { return std::array{std::min(a, b), std::max(a, b)}; };
  for (const std::uint32_t t : chosen) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangles[t][i];
      const std::uint32_t b = triangles[t][(i + 1) % 3];
      const auto [place, is_new] = middles.try_emplace(key(a, b), static_cast<std::uint32_t>(result.positions.size()));
      if (is_new) result.positions.push_back((mesh.positions[a] + mesh.positions[b]) * 0.5);
    }
  }
  for (const Triangle& triangle : triangles) {
    // Corners and middles in order around; cut as a fan from a middle, so that no part is flat.
    std::vector<std::uint32_t> ring;
    std::size_t first_middle = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      ring.push_back(triangle[i]);
      const auto middle = middles.find(key(triangle[i], triangle[(i + 1) % 3]));
      if (middle == middles.end()) continue;
      ring.push_back(middle->second);
      first_middle = ring.size() - 1;
    }
    std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(first_middle), ring.end());
    if (ring.size() == 6) {  // middle, corner, middle, ...
      for (const auto& [a, b, c] : {Triangle{0, 1, 2}, Triangle{2, 3, 4}, Triangle{4, 5, 0}, Triangle{0, 2, 4}}) {
        result.add_face(std::array{ring[a], ring[b], ring[c]});
      }
      continue;
    }
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) result.add_face(std::array{ring[0], ring[i], ring[i + 1]});
  }
  return result;
}

std::set<std::uint32_t> triangles_in(const SelfIntersections& crossings) {
  std::set<std::uint32_t> result;
  for (const auto& pair : crossings.pairs) result.insert(pair.begin(), pair.end());
  return result;
}

// The pairs left after each round of refinement, as text; whether the last is 0.
bool vanishes(const Subject& subject, const Session& flow, const ReplayOptions& precise, std::string& rounds) {
  Mesh mesh = subject.mesh;
  for (int round = 0; round < kRounds; ++round) {
    const Outcome outcome = deform(mesh, flow, precise);
    if (!outcome.crossings || !outcome.crossings->complete) return false;
    rounds += fmt::format(" {}", outcome.crossings->count);
    if (outcome.crossings->count == 0) return true;
    mesh = refined(mesh, triangles_in(*outcome.crossings));
    if (mesh.face_count() > kMostTriangles) return false;
  }
  return false;
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
  precise.precision = Precision::float64;
  precise.tolerance = 1e-9;
  const Session flow = session_of(outcome.resolved, folder);
  const Outcome again = deform(subject.mesh, flow, precise);
  std::string cause = "UNEXPLAINED";
  std::string rounds;
  if (again.crossings && again.crossings->count == 0) {
    cause = "integration: none in double";
    ++row.only_float;
  } else if (vanishes(subject, flow, precise, rounds)) {
    cause = "sampling, refined:" + rounds;
    ++row.sampling;
  } else {
    cause += ", refined:" + rounds;
  }
  fmt::print("  {:9} {:24} {:6} pairs, {}\n", tool, subject.name, outcome.crossings->count, cause);
  if (cause.starts_with("UNEXPLAINED")) fmt::print("    {}\n", stroke_line(stroke).substr(0, 2000));
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
}  // namespace knead::acceptance

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: crossings FOLDER [STROKES [SEED [TOOL]]]\n");
    return 2;
  }
  const auto number = [&](int i, unsigned long otherwise) {
    return argc > i ? std::strtoul(argv[i], nullptr, 10) : otherwise;
  };
  return knead::acceptance::run(argv[1], number(2, 200), static_cast<unsigned>(number(3, 1)), argc > 4 ? argv[4] : "");
}
