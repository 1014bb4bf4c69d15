// What the driver that is killed and the test that kills it have in common.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <sstream>
#include <string>
#include <thread>

#include "script.h"
#include "studio.h"

namespace knead::test {

// Of the bits of all positions (FNV-1a).
inline std::uint64_t hash_of(const Snapshot& positions) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &positions[i][axis], sizeof bits);
      hash = (hash ^ bits) * 0x100000001b3u;
    }
  }
  return hash;
}

inline std::string batch_line(const Snapshot& positions) { return fmt::format("batch {:016x}", hash_of(positions)); }

// Every tool, undo, redo, a drag that is given up, a past stroke changed, layers, a remeshed one.
inline constexpr const char* kKillScript = R"({"size": [800, 600]}
{"new": "sphere", "vertices": 642}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"set": {"radius": 0.5, "inner_ratio": 0.4}}
{"tool": "ball"}
{"drag": [[0, 0, 1], [0.3, 0.3, 1], [0.6, 0.2, 1]], "steps": 12}
{"tool": "paint"}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]], "steps": 20}
{"key": "Ctrl+Z"}
{"key": "Ctrl+Shift+Z"}
{"tool": "rotate"}
{"click": [0, 0.3, 0.95]}
{"drag": [[-0.9, -0.9, 0], [-0.2, -0.9, 0]], "steps": 20}
{"tool": "curve"}
{"drag": [[-0.4, 0, 0.9], [0, 0.2, 0.97], [0.4, 0, 0.9]]}
{"drag": [[-0.4, 0, 0.9], [-0.4, 0.3, 0.9]], "steps": 10}
{"tool": "ball"}
{"set": {"mirror": [true, false, false]}}
{"drag": [[0.3, 0, 0.98], [0.4, 0.3, 0.98]], "steps": 10}
{"press": [0, 0.5, 0.9]}
{"move": [0.2, 0.7, 0.9]}
{"key": "Escape"}
{"set": {"mirror": [false, false, false]}}
{"edit": 1, "strokes": [{"tool": "rotate", "center": [0, 0, 1], "axis": [0, 0, 1], "angle_deg": 20, "inner": 0.2, "outer": 0.6}]}
{"key": "Ctrl+Z"}
{"layer": 0, "off": true}
{"layer": 2, "strength": 0.5}
{"layer": 1, "name": "ridge"}
{"layer": 2, "move_to": 1}
{"layer": 2, "join": true}
{"layer": 0, "off": false}
{"tool": "stamp"}
{"set": {"drag": "normal"}}
{"stamp": "sphere"}
{"click": [0.2, 0.5, 0.84]}
{"drag": [[0.25, 0.65, 1.1], [0.2, 0.5, 0.84]], "steps": 6}
{"tool": "ball"}
{"set": {"drag": "view", "remesh": true}}
{"press": [-0.5, -0.5, 0.7]}
{"move": [-0.58, -0.58, 0.7]}
{"move": [-0.66, -0.66, 0.7]}
{"move": [-0.74, -0.74, 0.7]}
{"move": [-0.82, -0.82, 0.7]}
{"move": [-0.9, -0.9, 0.7]}
{"release": [-0.9, -0.9, 0.7]}
{"key": "Ctrl+Z"}
{"key": "Ctrl+Z"}
)";

// Runs a script and calls `tell` with the line "batch HASH" of the shape whenever a batch has come into the journal.
inline void run_batches(studio::Studio& studio, const std::string& script, double pause,
                        const std::function<void(const std::string&)>& tell) {
  std::uint64_t version = 0;
  studio::ScriptHost host;
  host.after_event = [&] {
    if (pause > 0) std::this_thread::sleep_for(std::chrono::duration<double>(pause));
    studio.refresh();
    const studio::DocumentState& shown = studio.document().shown();
    if (shown.version == version || shown.opened == 0) return;
    version = shown.version;
    tell(batch_line(shown.state.positions));
  };
  std::istringstream lines(script);
  studio::run_script(lines, "script", studio, host);
  studio.document().worker().wait();
  host.after_event();
}

}  // namespace knead::test
