// What the documents show must work: every session line in them is a session, and the example is applied.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "knead/mesh/measures.h"
#include "knead/mesh/shapes.h"
#include "knead/session/replay.h"
#include "support/test_meshes.h"

namespace knead {
namespace {

TEST(Documents, ShowOnlySessionLinesThatAreOnes) {
  int lines = 0;
  for (const char* name : {"README.md", "docs/session.md", "docs/command.md"}) {
    std::istringstream text(file_bytes(std::filesystem::path(KNEAD_SOURCE) / name));
    for (std::string line; std::getline(text, line);) {
      if (line.rfind("    {\"tool\"", 0) != 0) continue;
      ++lines;
      EXPECT_NO_THROW(parse_session("{\"knead\": 1}\n" + line + "\n", name)) << line;
    }
  }
  EXPECT_GT(lines, 8);
}

TEST(Documents, TheExampleBendsTwoFingersOfTheHand) {
  const Mesh hand = make_shape(ShapeKind::hand);
  const Session session = read_session(std::filesystem::path(KNEAD_SOURCE) / "examples/peace.knead");
  EXPECT_TRUE(session.warnings.empty());
  const ReplayResult result = replay(hand, session);
  EXPECT_EQ(result.status, AdvectStatus::done);
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
  EXPECT_NEAR(measure_volume_and_area(hand, result.positions).volume / measure(hand).volume, 1, 1e-4);
  for (const Finger& finger : hand_fingers()) {
    const Vec3d tip = finger.base + finger.axis * finger.length;
    double farthest = 0;
    for (std::size_t i = 0; i < hand.vertex_count(); ++i) {
      if (norm(hand.positions[i] - tip) > finger.radius) continue;
      farthest = std::fmax(farthest, norm(result.positions[i] - hand.positions[i]));
    }
    const bool bent = finger.name == "ring" || finger.name == "little";
    EXPECT_EQ(farthest > 0.1, bent) << finger.name << " moved by " << farthest;
    if (!bent) {
      EXPECT_EQ(farthest, 0) << finger.name;
    }
  }
}

}  // namespace
}  // namespace knead
