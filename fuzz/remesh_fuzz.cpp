// Remeshes what strokes deform. Bytes choose a small mesh, one or two strokes and settings: the result is a sound mesh
// whose faces and vertices come from the given one, or the input is refused.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "byte_choices.h"
#include "flow/block_mover.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/replay.h"
#include "support/shape_promises.h"

namespace {

using namespace knead;

RemeshSettings settings(fuzz::Choices& choices) {
  RemeshSettings result;
  if (choices.flag()) result.max_edge = choices.positive();
  if (choices.flag()) result.max_angle_deg = 5 + choices.byte() / 2.0;
  if (choices.flag()) result.max_chord = 1e-4 * (1 + choices.byte());
  if (choices.flag()) result.min_edge = choices.positive() / 8;
  if (choices.flag()) result.iterations = static_cast<int>(choices.below(8));
  result.max_vertices = 40 + choices.below(160);
  return result;
}

// A remesh may take ten times the evaluations of its stroke: so that most runs take a few hundredths of a second with
// sanitizers, strokes of more evaluations move the mesh only, and those of many more are not run to their end.
constexpr std::uint64_t kMaxEvaluations = 5'000;
constexpr std::size_t kMaxDabs = 2'000;

// Whether a stroke is short by itself. What asks the surface for a radius moves no more points than without one.
bool is_short(Stroke stroke, const Mesh& mesh) {
  const auto* paint = std::get_if<PaintStroke>(&stroke);
  if (paint != nullptr && !paint->path.empty()) return paint_dabs(*paint).aims.size() <= kMaxDabs;
  if (auto* twist = std::get_if<TwistStroke>(&stroke)) twist->radius_auto = false;
  if (auto* bend = std::get_if<BendStroke>(&stroke)) bend->radius_auto = false;
  if (!is_flow(stroke) || reads_surface(stroke)) return true;
  std::vector<Vec3d> points = mesh.positions;
  const AdvectOptions options = advect_options({.threads = 1}, reference_length(points));
  const AdvectResult moved = detail::advect_within(flow_of(stroke), points, options, kMaxEvaluations);
  return moved.status == AdvectStatus::done;
}

bool is_short(const std::shared_ptr<const Mesh>& mesh, const Session& session, ReplayOptions options) {
  const auto alone = [&](const SessionStroke& stroke) { return is_short(stroke.stroke, *mesh); };
  if (!std::all_of(session.strokes.begin(), session.strokes.end(), alone)) return false;
  options.remesh.settings.reset();
  options.motion.backend = [](const Flow& flow, std::span<Vec3d> points, const AdvectOptions& advect_options) {
    return detail::advect_within(flow, points, advect_options, kMaxEvaluations);
  };
  const ReplayResult moved = replay(mesh, session, options);
  return moved.status == AdvectStatus::done && moved.shape.work().evaluations <= kMaxEvaluations;
}

std::string broken_result(const Mesh& before, const DeformedShape& shape) {
  const Mesh mesh = shape.to_mesh();
  if (std::string what = broken_mesh(mesh); !what.empty()) return what;
  const Provenance* from = shape.provenance();
  if (from == nullptr) return "";
  if (from->face_source.size() != mesh.face_count()) return "the number of face sources";
  if (from->vertex_source.size() != mesh.vertex_count()) return "the number of vertex sources";
  const auto is_face = [&](std::uint32_t f) { return f < before.face_count(); };
  const auto is_vertex = [&](std::uint32_t v) { return v == kNewVertex || v < before.vertex_count(); };
  if (!std::all_of(from->face_source.begin(), from->face_source.end(), is_face)) return "a face source";
  return std::all_of(from->vertex_source.begin(), from->vertex_source.end(), is_vertex) ? "" : "a vertex source";
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices choices({data, size});
  const auto mesh = std::make_shared<const Mesh>(fuzz::mesh(choices, 42));
  ReplayOptions options;
  options.motion.threads = 1;
  options.remesh.settings = settings(choices);
  options.remesh.single_precision = choices.flag();
  Session session;
  try {
    session.strokes = fuzz::strokes(choices, 2, mesh->vertex_count());
    if (!is_short(mesh, session, options)) return 0;
    const ReplayResult result = replay(mesh, session, options);
    if (result.status != AdvectStatus::done) return 0;
    const std::string broken = broken_result(*mesh, result.shape);
    if (broken.empty()) return 0;
    std::fprintf(stderr, "broken promise: %s\n", broken.c_str());
    std::abort();
  } catch (const InvalidInput&) {
    return 0;
  }
}
