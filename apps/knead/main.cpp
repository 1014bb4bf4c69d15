// The command `knead`. Its subcommands `bench` and `studio` start programs of their own.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "command.h"
#include "program.h"

namespace knead::command {
namespace {

// Replaces this process by the program beside this command, or else on PATH. Returns if there is neither.
void start(const std::string& name, std::vector<std::string> words) {
  words.insert(words.begin(), name);
  const std::filesystem::path self = own_program();
  if (!self.empty()) become(self.parent_path() / name, words);
  become(name, words);
}

struct StudioOptions {
  std::string backend;
  std::string shape;
  std::string session;
  std::vector<std::string> also;
};

void run_studio(const StudioOptions& options) {
  std::vector<std::string> words;
  if (!options.backend.empty()) words.insert(words.end(), {"--backend", options.backend});
  for (const std::string& shape : options.also) words.insert(words.end(), {"--also", shape});
  words.emplace_back("--");
  for (const std::string& file : {options.shape, options.session}) {
    if (!file.empty()) words.push_back(file);
  }
  start("knead-studio", words);
  throw std::runtime_error(
      "knead-studio was found neither next to this command nor on PATH; install GLFW, Dear ImGui, epoxy, EGL and stb, "
      "and build again");
}

}  // namespace

Subcommand bench_command(const std::vector<std::string>& words) {
  return bench_subcommand([words](const BenchOptions& /*options*/) {
    start("knead-bench", words);
    throw std::runtime_error(
        "knead-bench was found neither next to this command nor on PATH; build it with ./dev bench, or as the target "
        "knead-bench");
  });
}

Subcommand studio_command() {
  const auto options = std::make_shared<StudioOptions>();
  return {"studio",
          "Start Knead Studio, the interactive application",
          {{"--backend",
            WordTarget{{"cpu", "gpu"}, 0, [options](std::size_t gpu) { options->backend = gpu != 0 ? "gpu" : "cpu"; }},
            "Deform shapes on the CPU or the GPU (default: as last chosen)", "cpu|gpu"},
           {"SHAPE", &options->shape, "The shape to open (default: a new sphere)"},
           {"SESSION", &options->session, "The session to open: strokes that were made on this shape"},
           {"--also", &options->also, "A further shape, such as clothes, which the same strokes move; may be repeated",
            "FILE"}},
          "  knead studio\n"
          "  knead studio hand.ply bend.knead",
          [options] { run_studio(*options); }};
}

}  // namespace knead::command

int main(int argc, char** argv) {
  using namespace knead::command;
  const std::vector<std::string> words(argv + std::min(argc, 2), argv + argc);  // after the name of the subcommand
  return run_program(argc, argv,
                     {deform_command(), bend_command(), twist_command(), stretch_command(), taper_command(),
                      wrap_command(), print_command(), lattice_command(), resolve_command(), fit_command(),
                      skin_command(), info_command(), check_command(), make_command(), remesh_command(),
                      refine_command(), render_command(), bench_command(words), studio_command()});
}
