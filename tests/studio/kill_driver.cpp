// Studio driven by a script that takes its time, to be killed at any moment.
//   kill_driver STATE_FOLDER thread|no-thread [PAUSE]
// Prints "batch HASH" of the shape as soon as a batch is in the journal.
#include <unistd.h>

#include <cstring>
#include <string>

#include "kill_script.h"

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::filesystem::path state = argv[1];
  const bool has_worker = std::strcmp(argv[2], "thread") == 0;
  const double pause = argc > 3 ? std::stod(argv[3]) : 0;
  knead::studio::Studio studio({state / "config", state, has_worker, 1});
  knead::test::run_batches(studio, knead::test::kKillScript, pause, [](std::string line) {
    line += "\n";
    if (::write(STDOUT_FILENO, line.data(), line.size()) < 0) std::exit(1);
  });
  if (pause > 0) ::pause();  // until it is killed
  studio.document().close();
  return 0;
}
