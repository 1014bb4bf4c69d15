// knead studio: starts the application, which is a program of its own.
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "command.h"
#include "program.h"

namespace knead::command {
namespace {

constexpr const char* kProgram = "knead-studio";

struct StudioOptions {
  std::string backend;
  std::string shape;
  std::string session;
};

void run_studio(const StudioOptions& options) {
  std::vector<std::string> words{kProgram};
  if (!options.backend.empty()) words.insert(words.end(), {"--backend", options.backend});
  words.emplace_back("--");
  for (const std::string& file : {options.shape, options.session}) {
    if (!file.empty()) words.push_back(file);
  }
  const std::filesystem::path self = own_program();
  if (!self.empty()) become(self.parent_path() / kProgram, words);
  become(kProgram, words);
  throw std::runtime_error(
      "knead-studio was found neither next to this command nor on PATH; install GLFW, Dear ImGui, epoxy, EGL and stb, "
      "and "
      "build again");
}

}  // namespace

Subcommand studio_command() {
  const auto options = std::make_shared<StudioOptions>();
  return {"studio",
          "Start Knead Studio, the interactive application",
          {{"--backend",
            &options->backend,
            "Deform shapes on the CPU or the GPU (default: as last chosen)",
            "",
            OptionKind::optional,
            {"cpu", "gpu"}},
           {"SHAPE", &options->shape, "The shape to open (default: a new sphere)"},
           {"SESSION", &options->session, "The session to open: strokes that were made on this shape"}},
          "  knead studio\n"
          "  knead studio hand.ply bend.knead",
          [options] { run_studio(*options); }};
}

}  // namespace knead::command
