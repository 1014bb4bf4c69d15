// What tests of Studio share: a folder of their own, a ball to work on, a script for every tool.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "knead/io.h"
#include "knead/replay.h"
#include "script.h"
#include "studio.h"

namespace knead::studio {

namespace fs = std::filesystem;

class StudioTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("knead_studio_test_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  StudioOptions options(bool has_worker = false) const {
    return {folder_ / "config", folder_ / "state", has_worker, 0};
  }

  static void run(Studio& studio, const std::string& script) {
    std::istringstream lines(script);
    run_script(lines, "script", studio, {});
    do {
      studio.document().worker().wait();
      studio.refresh();
    } while (studio.document().worker().is_busy());
  }

  // A ball of radius 1 seen from the front, 1 unit 200 pixels, the middle at (400, 300).
  static std::string ball(int vertices = 2562) {
    return R"({"size": [800, 600]}
{"new": "sphere", "vertices": )" +
           std::to_string(vertices) + R"(}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"tool": "ball"}
{"set": {"radius": 0.5, "inner_ratio": 0.4}}
)";
  }

  static std::vector<Vec3d> positions(const Studio& studio) { return studio.document().shown().state.positions.copy(); }

  static std::string errors(Studio& studio) {
    std::string all;
    for (const Notice& notice : studio.document().take_notices()) {
      if (notice.is_error) all += notice.text + "\n";
    }
    return all;
  }

  // Saves, and replays the file as the command does.
  ReplayResult saved_and_replayed(Studio& studio, const std::string& name = "work.knead") const {
    run(studio, R"({"save": ")" + (folder_ / name).string() + "\"}");
    EXPECT_EQ(errors(studio), "");
    const Session session = read_session(folder_ / name);
    EXPECT_TRUE(session.mesh.has_value());
    return replay(read_shape(folder_ / *session.mesh).mesh, session);
  }

  fs::path folder_;
};

struct ToolCase {
  const char* name;
  const char* script;
  std::size_t strokes;  // at least, of the session

  friend std::ostream& operator<<(std::ostream& out, const ToolCase& tool) { return out << tool.name; }
};

inline constexpr ToolCase kTools[] = {{"ball", R"({"tool": "ball"}
{"drag": [[0, 0, 1], [0.3, 0.3, 1], [0.6, 0.2, 1]]})",
                                       1},
                                      {"ball_along_surface", R"({"tool": "ball"}
{"set": {"drag": "surface"}}
{"drag": [[0, 0, 1], [0.3, 0.3, 1]]})",
                                       1},
                                      {"ball_along_normal", R"({"tool": "ball"}
{"set": {"drag": "normal"}}
{"drag": [[0.5, 0.3, 0.812], [0.8, 0.5, 0.812]]})",
                                       1},
                                      {"ball_along_axis", R"({"tool": "ball"}
{"set": {"drag": "axis", "axis": [1, 1, 0]}}
{"drag": [[0, 0, 1], [0.8, 0.5, 1]]})",
                                       1},
                                      {"capsule", R"({"tool": "capsule"}
{"drag": [[0, 0.9, 0.4], [0, 1.3, 0.4]]})",
                                       1},
                                      {"paint", R"({"tool": "paint"}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]]})",
                                       1},
                                      {"paint_in", R"({"tool": "paint"}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]], "modifiers": ["ctrl"]})",
                                       1},
                                      {"paint_a_dab", R"({"tool": "paint"}
{"click": [0, 0, 1]})",
                                       1},
                                      {"points", R"({"tool": "points"}
{"click": [-0.3, 0, 0.95]}
{"click": [0.3, 0, 0.95]}
{"drag": [[0.3, 0, 0.95], [0.3, 0.4, 0.95]]})",
                                       1},
                                      {"curve", R"({"tool": "curve"}
{"drag": [[-0.4, 0, 0.9], [0, 0.2, 0.97], [0.4, 0, 0.9]]}
{"drag": [[-0.4, 0, 0.9], [-0.4, 0.3, 0.9]]})",
                                       1},
                                      {"stamp", R"({"tool": "stamp"}
{"set": {"drag": "normal"}}
{"stamp": "sphere"}
{"click": [0.2, 0.5, 0.84]}
{"drag": [[0.25, 0.65, 1.1], [0.22, 0.55, 0.9]]})",
                                       1},
                                      {"rotate", R"({"tool": "rotate"}
{"click": [0, 0.3, 0.95]}
{"drag": [[-0.9, -0.9, 0], [-0.2, -0.9, 0]]})",
                                       1},
                                      {"stretch", R"({"tool": "stretch"}
{"click": [0.6, 0, 0.8]}
{"drag": [[-0.9, -0.9, 0], [-0.2, -0.9, 0]]})",
                                       1},
                                      {"twist", R"({"tool": "twist"}
{"set": {"limit_cylinder": false}}
{"click": [0, 0, 1]}
{"drag": [[-0.9, -0.9, 0], [-0.5, -0.9, 0]]})",
                                       1},
                                      {"bend", R"({"tool": "bend"}
{"set": {"limit_cylinder": false}}
{"click": [0, 0, 1]}
{"drag": [[-0.9, -0.9, 0], [-0.9, -0.5, 0]]})",
                                       1},
                                      {"mirrored_ball", R"({"tool": "ball"}
{"set": {"mirror": [true, false, false]}}
{"drag": [[0.2, 0, 0.98], [0.4, 0.3, 0.98]]})",
                                       1},
                                      {"mirrored_stamp", R"({"tool": "stamp"}
{"set": {"drag": "normal", "mirror": [true, false, false]}}
{"stamp": "letter-y"}
{"click": [0.5, 0.3, 0.81]}
{"drag": [[0.53, 0.32, 0.86], [0.4, 0.24, 0.65]]})",
                                       2},
                                      {"remeshed", R"({"tool": "ball"}
{"set": {"remesh": true, "mirror": [false, true, false]}}
{"drag": [[0, 0.6, 0.8], [0, 1.4, 0.8]]})",
                                       1},
                                      {"several", R"({"tool": "ball"}
{"drag": [[0, 0, 1], [0.3, 0.3, 1]]}
{"tool": "paint"}
{"drag": [[-0.5, 0, 0.86], [0.2, 0.1, 0.97]]}
{"key": "Ctrl+Z"}
{"tool": "rotate"}
{"click": [0.5, 0.5, 0.7]}
{"drag": [[-0.9, -0.9, 0], [-0.2, -0.9, 0]]})",
                                       2},
                                      {"relax", R"({"tool": "paint"}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]]}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]], "modifiers": ["shift"]})",
                                       1},
                                      {"mirrored_relax", R"({"tool": "ball"}
{"set": {"mirror": [true, true, false]}}
{"drag": [[0.2, 0.2, 0.95], [0.5, 0.5, 1]]}
{"drag": [[0.2, 0.2, 0.95], [0.4, 0.1, 0.9]], "modifiers": ["ctrl", "shift"]})",
                                       1},
                                      {"pins", R"({"tool": "pins"}
{"click": [-0.4, 0, 0.9]}
{"click": [0, -0.5, 0.86]}
{"drag": [[0.3, 0.2, 0.93], [0.5, 0.4, 0.93]]}
{"drag": [[-0.4, 0, 0.9], [-0.6, 0, 0.9]]})",
                                       2},
                                      {"mirrored_pins", R"({"tool": "pins"}
{"set": {"mirror": [true, false, false], "auto_radius": false, "radius": 0.8, "remesh": true}}
{"click": [0, -0.5, 0.86]}
{"drag": [[0.3, 0.2, 0.93], [0.5, 0.4, 0.93]]})",
                                       1},
                                      {"snakehook", R"({"tool": "snakehook"}
{"drag": [[0, 0, 1], [0.3, 0.3, 1], [0.6, 0.2, 1]]})",
                                       1},
                                      {"mirrored_crease", R"({"tool": "crease"}
{"set": {"mirror": [true, false, false]}}
{"drag": [[0.2, -0.5, 0.84], [0.3, 0.5, 0.81]]})",
                                       1},
                                      {"pinch_apart", R"({"tool": "pinch"}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]], "modifiers": ["ctrl"]})",
                                       1},
                                      {"flatten", R"({"tool": "flatten"}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]]})",
                                       1},
                                      {"bend_along", R"({"tool": "bend_along"}
{"drag": [[0, 0, 0], [0, 0.1, 0]]}
{"drag": [[0, 0.1, 0], [0.03, 0.12, 0]]})",
                                       2},
                                      {"lattice", R"({"tool": "lattice"}
{"drag": [[1.04, 1.04, 1.04], [1.2, 1.1, 1.04]]})",
                                       1}};

}  // namespace knead::studio
