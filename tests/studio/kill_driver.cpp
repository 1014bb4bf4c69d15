// Studio driven by a script that takes its time, to be killed at any moment.
//   kill_driver STATE_FOLDER thread|no-thread [PAUSE]
// Prints, as soon as a batch is in the journal, "batch SESSION_STROKES HASH" of the shape as it then is.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <sstream>
#include <string>
#include <thread>

#include "kill_script.h"
#include "script.h"
#include "studio.h"

int main(int argc, char** argv) {
  using namespace knead::studio;
  if (argc < 3) return 2;
  const std::filesystem::path state = argv[1];
  const bool has_worker = std::strcmp(argv[2], "thread") == 0;
  const double pause = argc > 3 ? std::stod(argv[3]) : 0;
  Studio studio({state / "config", state, has_worker, 1});
  std::uint64_t version = 0;
  ScriptHost host;
  host.after_event = [&] {
    if (pause > 0) std::this_thread::sleep_for(std::chrono::duration<double>(pause));
    studio.refresh();
    if (studio.document().shown().version == version || studio.document().shown().opened == 0) return;
    version = studio.document().shown().version;
    const std::string line =
        fmt::format("batch {:016x}\n", knead::test::hash_of(studio.document().shown().state.positions));
    if (::write(STDOUT_FILENO, line.data(), line.size()) < 0) std::exit(1);
  };
  std::istringstream script(knead::test::kKillScript);
  run_script(script, "script", studio, host);
  studio.document().worker().wait();
  host.after_event();
  if (pause > 0) ::pause();  // until it is killed
  studio.document().close();
  return 0;
}
