// knead studio: starts the application, which is a program of its own.
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "command.h"

namespace knead::command {
namespace {

constexpr const char* kProgram = "knead-studio";

// Becomes the program, or returns where there is none of that name.
void become(const std::string& program, std::vector<std::string>& words) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execvp(program.c_str(), arguments.data());
}

void run_studio(const std::string& backend, const std::string& shape, const std::string& session) {
  std::vector<std::string> words{kProgram};
  if (!backend.empty()) words.insert(words.end(), {"--backend", backend});
  words.emplace_back("--");
  for (const std::string& file : {shape, session}) {
    if (!file.empty()) words.push_back(file);
  }
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) become((self.parent_path() / kProgram).string(), words);
  become(kProgram, words);
  throw std::runtime_error(
      "knead-studio is neither beside this command nor on PATH; install GLFW, Dear ImGui, epoxy, EGL and stb, and "
      "build again");
}

}  // namespace

Subcommand add_studio(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("studio", "The interactive application");
  const auto shape = std::make_shared<std::string>();
  const auto session = std::make_shared<std::string>();
  const auto backend = std::make_shared<std::string>();
  app->add_option("--backend", *backend, "What moves the shape under the hand: cpu, or gpu (default: as last chosen)")
      ->check(CLI::IsMember({"cpu", "gpu"}));
  app->add_option("SHAPE", *shape, "What to work on; a new sphere where it is not given")->type_name("");
  app->add_option("SESSION", *session, "What has been done to it before")->type_name("");
  add_examples(*app,
               "  knead studio\n"
               "  knead studio hand.ply bend.knead");
  return {app, [=] { run_studio(*backend, *shape, *session); }};
}

}  // namespace knead::command
