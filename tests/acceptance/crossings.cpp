// Random strokes of every tool on closed shapes without self-intersections: how many pairs of triangles cross each
// other afterwards, and why.
//
//   crossings FOLDER [STROKES [SEED [TOOL]]]
//
// FOLDER holds the shapes; STROKES (200) are made for each tool, in turn over the shapes. Where triangles cross, the
// stroke is integrated again in double precision to 1e-9, which shows whether the integration made them; and the points
// where they cross are carried back, which shows whether the triangles were too large for the deformation (sampling).
// What neither explains is an error of the fields or flows.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "knead/io/shape_file.h"
#include "knead/math/box.h"
#include "knead/math/error.h"
#include "knead/mesh/normals.h"
#include "knead/mesh/self_intersections.h"
#include "knead/mesh/shapes.h"
#include "knead/mesh/surface_tree.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/replay.h"
#include "random_strokes.h"

namespace knead::acceptance {
namespace {

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
  std::vector<Vec3d> positions;
};

Outcome deform(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  try {
    ReplayResult result = replay(mesh, session, options);
    if (result.status != AdvectStatus::done) return {};
    return {self_intersections(triangulate(mesh), result.positions), std::move(result.resolved),
            std::move(result.positions)};
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

// Where an edge of one triangle passes through the other; nothing where rounding hides it.
std::optional<Vec3d> piercing(const Corners& edges, const Corners& face) {
  const Vec3d normal = cross(face[1] - face[0], face[2] - face[0]);
  for (std::size_t i = 0; i < 3; ++i) {
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

double distance(const Vec3d& p, const Corners& corners) {
  const std::vector<Vec3d> positions(corners.begin(), corners.end());
  const std::vector<Triangle> one{{0, 1, 2}};
  return SurfaceTree(one, positions).closest(p)->distance;
}

// A path line cannot cross another, so a point that lies on two deformed triangles at once cannot come from both of the
// undeformed ones, which do not meet: carried back it lies beside one of them at least, as the straight triangle does
// not lie where the flow takes its points. Whether that is so for every crossing pair, by far more than the integration
// errs. A pair whose common point rounding hides is left out.
bool is_sampling(const Mesh& mesh, const std::vector<Vec3d>& deformed, const SelfIntersections& crossings,
                 const Flow& flow, double size) {
  const std::vector<Triangle> triangles = triangulate(mesh);
  std::vector<Vec3d> common;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (const auto& [t, u] : crossings.pairs) {
    const Corners a = corners_of(triangles[t], deformed);
    const Corners b = corners_of(triangles[u], deformed);
    std::optional<Vec3d> x = piercing(a, b);
    if (!x) x = piercing(b, a);
    if (!x) continue;
    common.push_back(*x);
    pairs.push_back({t, u});
  }
  const auto carried_back = [&](double tolerance) {
    AdvectOptions options;
    options.precision = Precision::float64;
    options.tolerance = tolerance * size;
    std::vector<Vec3d> points = common;
    advect(inverse(flow), points, options);
    return points;
  };
  const std::vector<Vec3d> back = carried_back(1e-10);
  const std::vector<Vec3d> roughly = carried_back(1e-8);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double first = distance(back[i], corners_of(triangles[pairs[i][0]], mesh.positions));
    const double second = distance(back[i], corners_of(triangles[pairs[i][1]], mesh.positions));
    if (!(std::max(first, second) > 10 * norm(back[i] - roughly[i]))) return false;
  }
  return !pairs.empty();
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
  const Outcome again = deform(subject.mesh, session_of(outcome.resolved, folder), precise);
  std::string cause = "UNEXPLAINED";
  if (again.crossings && again.crossings->count == 0) {
    cause = "integration: none in double";
    ++row.only_float;
  } else if (again.crossings && is_sampling(subject.mesh, again.positions, *again.crossings, flow_of(outcome.resolved),
                                            bounding_box(subject.mesh.positions).diagonal())) {
    cause = "sampling";
    ++row.sampling;
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
