// Reads any bytes as a session: a session or InvalidInput, and what was read is written and read back the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "knead/error.h"
#include "knead/session.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  knead::Session session;
  try {
    session = knead::parse_session(text, "fuzz.knead");
  } catch (const knead::InvalidInput&) {
    return 0;
  }
  const std::string written = knead::serialize_session(session);
  const knead::Session again = knead::parse_session(written, "fuzz.knead");
  if (knead::serialize_session(again) != written || again.strokes.size() != session.strokes.size()) std::abort();
  for (const knead::SessionStroke& stroke : session.strokes) {
    if (!knead::reads_surface(stroke.stroke)) knead::flow_of(stroke.stroke);
    knead::warnings(stroke.stroke);
  }
  return 0;
}
