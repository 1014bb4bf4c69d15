// The program `knead-studio`.
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "application.h"
#include "knead/error.h"
#include "knead/knead.h"
#include "platform/system.h"

namespace {

constexpr const char* kHelp =
    "usage: knead-studio [--backend cpu|gpu] [SHAPE] [SESSION] [--also SHAPE]...\n"
    "       knead-studio [--backend cpu|gpu] --script FILE\n"
    "\n"
    "Opens a window in which the shape (PLY, OBJ, GLB, STL, OFF or XYZ; a sphere if none is given) can be\n"
    "deformed, after the strokes of the session. H shows the keys.\n"
    "\n"
    "--also SHAPE: a further shape, such as clothes, which the same strokes move; may be repeated.\n"
    "\n"
    "--backend gpu: the GPU moves the shape during a drag (View > Deform on).\n"
    "--script needs no display: it does what the lines of FILE say, as a person would (- is standard input;\n"
    "docs/command.md has the lines).\n";

int fail(int code, const char* message) {
  knead::studio::show_failure(std::string("knead-studio: ") + message);
  return code;
}

// The exit code.
int run_script_file(const std::string& name, knead::studio::BackendChoice backend) {
  knead::studio::StudioOptions options;
  options.has_worker = false;  // every event is done before the next: the same result whenever it is run
  if (name == "-") return knead::studio::run_headless(std::cin, "standard input", options, backend) ? 0 : 1;
  std::ifstream file(name);
  if (!file) return fail(3, (name + ": cannot be read").c_str());
  return knead::studio::run_headless(file, name, options, backend) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  knead::studio::prepare_program();
  try {
    knead::studio::ApplicationOptions options;
    std::vector<std::string_view> files;
    bool only_files = false;
    for (int i = 1; i < argc; ++i) {
      const std::string_view word = argv[i];
      if (!only_files && word == "--") {
        only_files = true;
      } else if (!only_files && (word == "-h" || word == "--help")) {
        std::fputs(kHelp, stdout);
        return 0;
      } else if (!only_files && word == "--version") {
        std::puts("knead-studio " KNEAD_VERSION);
        return 0;
      } else if (!only_files && word == "--script") {
        if (i + 2 != argc) return fail(2, "--script takes one file, and nothing after it");
        return run_script_file(argv[i + 1], options.backend.value_or(knead::studio::BackendChoice::cpu));
      } else if (!only_files && word == "--backend") {
        const std::string_view name = i + 1 < argc ? argv[++i] : "";
        if (name != "cpu" && name != "gpu") return fail(2, "--backend takes cpu or gpu");
        options.backend = name == "gpu" ? knead::studio::BackendChoice::gpu : knead::studio::BackendChoice::cpu;
      } else if (!only_files && word == "--also") {
        if (i + 1 == argc) return fail(2, "--also takes a shape");
        options.also.emplace_back(argv[++i]);
      } else if (!only_files && word.starts_with('-')) {
        return fail(2, "unknown option; see knead-studio --help");
      } else {
        files.push_back(word);
      }
    }
    if (files.size() > 2) return fail(2, "give at most one shape and one session; see knead-studio --help");
    if (!options.also.empty() && files.empty()) return fail(2, "--also adds to a shape; give that first");
    if (!files.empty()) options.shape = files[0];
    if (files.size() > 1) options.session = files[1];
    knead::studio::run_application(options);
    return 0;
  } catch (const knead::InvalidInput& error) {
    return fail(3, error.what());
  } catch (const std::exception& error) {
    return fail(1, error.what());
  }
}
