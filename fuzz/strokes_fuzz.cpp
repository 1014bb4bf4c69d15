// Applies strokes to a small mesh; bytes choose both. Unless they are refused, the positions are finite, and the same
// bits follow from the session as resolved, from its text, and in another number of threads.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "byte_choices.h"
#include "knead/error.h"
#include "knead/replay.h"

namespace {

using namespace knead;

bool is_flow_or_mask(const SessionStroke& stroke) { return is_flow(stroke.stroke); }

std::string broken_promise(const std::shared_ptr<const Mesh>& mesh, const Session& session) {
  ReplayOptions options;
  options.motion.threads = 1;
  const ReplayResult result = replay(mesh, session, options);
  if (result.status != AdvectStatus::done) return "";
  const std::vector<Vec3d>& positions = result.shape.positions();
  if (!std::all_of(positions.begin(), positions.end(), [](const Vec3d& p) { return is_finite(p); })) {
    return "a position is not finite";
  }
  options.motion.threads = 2;
  const Session read = parse_session(serialize_session(session), session.name);
  if (replay(mesh, read, options).shape.positions() != positions) return "the session's text moves otherwise";
  if (!std::all_of(session.strokes.begin(), session.strokes.end(), is_flow_or_mask)) return "";
  const Session resolved{session.name, {}, {}, result.resolved, {}};
  return replay(mesh, resolved, options).shape.positions() == positions ? "" : "the resolved session moves otherwise";
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices choices({data, size});
  const auto mesh = std::make_shared<const Mesh>(fuzz::mesh(choices));
  Session session;
  try {
    session.strokes = fuzz::strokes(choices, 4, mesh->vertex_count());
    const std::string broken = broken_promise(mesh, session);
    if (broken.empty()) return 0;
    std::fprintf(stderr, "broken promise: %s\n", broken.c_str());
    std::abort();
  } catch (const InvalidInput&) {
    return 0;
  }
}
