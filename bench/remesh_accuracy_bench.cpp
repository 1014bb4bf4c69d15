// How accurate deformations are without remeshing, with the paper's, and with ours: the scenes of the paper's table of
// volume errors, as a table in Markdown.
//
//   remesh_accuracy_bench [MESHES [SCENE [WAY]]]
//
// MESHES holds the shapes of the scenes that need one, which are left out without it; SCENE is a part of a name, WAY
// one of off, paper and ours.
//
// Distances from the true image are those of the certificate (knead/certify.h), in parts of the box's diagonal:
// the rms of the stroke where it is greatest, the greatest of all, and the rms of what is carried back. Seconds are
// those of the processor.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "knead/certify.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/replay.h"
#include "knead/vec.h"
#include "support/paper_remesh.h"

namespace {

using namespace knead;

const std::filesystem::path kGallery = std::filesystem::path(KNEAD_ROOT) / "examples" / "gallery";
const std::filesystem::path kScenes = std::filesystem::path(KNEAD_ROOT) / "bench" / "scenes";

struct Scene {
  std::string name;
  std::filesystem::path session;
  std::optional<ShapeKind> kind;  // of a shape made here; std::nullopt: `file` is read
  std::size_t vertices = 0;
  std::string file;
  std::string paper;  // its figure
};

std::vector<Scene> all_scenes() {
  return {{"sphere pulled through", kGallery / "fig07_through.knead", ShapeKind::sphere, 16000, "", "-1.1e-03"},
          {"box twisted", kGallery / "fig14_twist.knead", ShapeKind::box, 6000, "", "7.8e-04"},
          {"box bent", kGallery / "fig15_box.knead", ShapeKind::box, 6000, "", "7.5e-04"},
          {"fandisk stamped", kGallery / "mesh11_features.knead", {}, 0, "fandisk_6k.ply", "-7.0e-06"},
          {"armadillo bent", kGallery / "mesh16_bow.knead", {}, 0, "armadillo_43k.ply", "1.3e-03"},
          {"dragon pulled", kGallery / "mesh19_dragon.knead", {}, 0, "dragon_438k_constructed.ply", "-1.5e-03"},
          {"spider, 35 strokes", kGallery / "fig17_spider.knead", ShapeKind::sphere, 16000, "", "1.9e-03"},
          {"monster, 20 strokes", kScenes / "monster.knead", ShapeKind::sphere, 16000, "", "7.0e-05"}};
}

enum class Way { off, paper, ours };
constexpr std::array kWays{"off", "paper", "ours"};

// Of all threads.
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Outcome {
  ReplayResult result;
  Certificate certificate;
  double seconds = 0;  // of the processor, without those of the certificate
};

// The library's own replay.
Outcome replayed(const Mesh& mesh, const Session& session, Way way) {
  Outcome outcome;
  ReplayOptions options;
  options.may_cross = true;
  if (way == Way::ours) options.remesh.settings = RemeshSettings{};
  CertificateBuilder builder(mesh, options);
  double proving = 0;
  options.on_stroke = [&](const AppliedStroke& stroke) {
    const double begin = processor_seconds();
    builder.add(stroke);
    proving += processor_seconds() - begin;
  };
  const double begin = processor_seconds();
  outcome.result = replay(borrow(mesh), session, options);
  outcome.seconds = processor_seconds() - begin - proving;
  outcome.certificate = builder.finish(outcome.result, true);
  return outcome;
}

// What a stroke comes to on a surface as it is.
Flow flow_on(const Mesh& mesh, const Session& session, const SessionStroke& stroke) {
  if (!reads_surface(stroke.stroke)) return flow_of(stroke.stroke);
  Session one;
  one.name = session.name;
  one.strokes = {stroke};
  Flow flow;
  for (const SessionStroke& part : replay(borrow(mesh), one).resolved) {
    const Flow of_part = flow_of(part.stroke);
    flow.segments.insert(flow.segments.end(), of_part.segments.begin(), of_part.segments.end());
  }
  return flow;
}

// Adds a stroke's remesh to what is known of the session.
void hand_on(const Remeshed& remeshed, Provenance& result) {
  std::vector<bool> touched = remeshed.moved;
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const std::uint32_t source = remeshed.vertex_source[i];
    touched[i] = touched[i] || source == kNewVertex || result.touched[source];
  }
  std::vector<std::uint32_t> face_source;
  for (const std::uint32_t face : remeshed.face_source) face_source.push_back(result.face_source[face]);
  result.touched = std::move(touched);
  result.face_source = std::move(face_source);
}

// The paper's way, which sessions do not offer.
Outcome in_the_paper_way(const Mesh& mesh, const Session& session) {
  Outcome outcome;
  Provenance provenance;
  provenance.touched.resize(mesh.vertex_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) provenance.face_source.push_back(static_cast<std::uint32_t>(f));
  DeformedShape shape(borrow(mesh));
  RemeshOptions options;
  options.targets = resolve({}, mesh);
  AdvectOptions move;
  move.tolerance = 1e-5 * bounding_box(mesh.positions).diagonal();
  std::vector<MeshEdge> creases = find_creases(mesh);
  const ReplayOptions replay_options;
  CertificateBuilder builder(mesh, replay_options);
  for (const SessionStroke& stroke : session.strokes) {
    const double begin = processor_seconds();
    const DeformedShape before = shape;
    const Flow flow = flow_on(before.mesh(), session, stroke);
    std::vector<Vec3d> after = before.positions();
    advect(flow, after, move);
    const FlowSupport reach(flow);
    Deformation deformation;
    deformation.carry = [&](std::span<Vec3d> points) { advect(flow, points, move); };
    deformation.may_move = [&](const Vec3d& center, double radius) { return reach.may_move(center, radius); };
    deformation.feature = reach.smallest_feature();
    options.creases = creases;
    Remeshed remeshed = test::remesh_as_in_the_paper(before.mesh(), after, deformation, options);
    hand_on(remeshed, provenance);
    shape = DeformedShape(std::make_shared<const Mesh>(std::move(remeshed.mesh)));
    creases = remeshed.creases;
    outcome.seconds += processor_seconds() - begin;
    builder.add({stroke.line, flow, before, shape, &remeshed});
  }
  ShapeState state = shape.state();
  state.provenance = std::make_shared<const Provenance>(std::move(provenance));
  shape.restore(state);
  outcome.result.shape = std::move(shape);
  outcome.certificate = builder.finish(outcome.result, true);
  return outcome;
}

double worst_stroke(const Certificate& certificate) {
  double worst = 0;
  for (const StrokeDistance& stroke : certificate.strokes) worst = std::max(worst, stroke.rms);
  return worst;
}

void print_row(const Scene& scene, const Mesh& mesh, Way way) {
  Session session = read_session(scene.session);
  if (!scene.file.empty()) session.name = scene.file;  // what a stamp presses lies beside the shape
  const Outcome outcome = way == Way::paper ? in_the_paper_way(mesh, session) : replayed(mesh, session, way);
  const Certificate& c = outcome.certificate;
  const double error = c.volume_error.value_or(std::nan(""));
  const double volume = measure(mesh).volume;
  const std::string uncompensated =
      way == Way::ours
          ? fmt::format("{:.1e}", error - outcome.result.shape.provenance()->counts.compensated_volume / volume)
          : "";
  const char* const name = way == Way::paper ? "paper's way" : kWays.at(static_cast<std::size_t>(way));
  fmt::print("| {} | {} | {} | {} | {:.1e} | {} | {} | {:.1f} | {:.1e} | {:.1e} | {:.1e} | {:.1f} |\n",
             way == Way::off ? scene.name : "", name, outcome.result.shape.positions().size(), uncompensated, error,
             way == Way::off ? scene.paper : "", c.crossings_after, c.touched_angle_after.value_or(0), worst_stroke(c),
             c.distance_max, c.carried_back_rms, outcome.seconds);
  std::fflush(stdout);
  if (way != Way::ours || c.strokes.size() < 2) return;
  std::string strokes;
  for (const StrokeDistance& stroke : c.strokes) strokes += fmt::format(" {:.1e}", stroke.rms);
  fmt::print(stderr, "{}, distance of each stroke, rms:{}\n", scene.name, strokes);
}

void run(const std::filesystem::path& folder, const std::string& only, const std::string& way) {
  fmt::print(
      "| scene | remeshing | vertices | volume error, uncompensated | volume error | the paper's | crossings | ");
  fmt::print("smallest angle | distance, rms | max | carried back, rms | s |\n");
  fmt::print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (Scene scene : all_scenes()) {
    if (scene.name.find(only) == std::string::npos) continue;
    if (!scene.kind) {
      scene.file = (folder / scene.file).string();
      if (folder.empty() || !std::filesystem::exists(scene.file)) continue;
    }
    const Mesh mesh = scene.kind ? make_shape(*scene.kind, scene.vertices) : read_shape(scene.file).mesh;
    for (std::size_t i = 0; i < kWays.size(); ++i) {
      if (way.empty() || way == kWays[i]) print_row(scene, mesh, static_cast<Way>(i));
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  run(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
  return 0;
}
