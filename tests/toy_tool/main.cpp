// A session with a tool that was added by the list in CONTRIBUTING.md: read, checked, applied, mirrored, written, and
// what Studio and the documentation say of it.   toy_tool SESSION.MD
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "gestures/tools.h"
#include "keys.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/session.h"
#include "support/tool_docs.h"
#include "surveys/random_strokes.h"

namespace {

int failures = 0;

void expect(bool is_true, const std::string& what) {
  if (is_true) return;
  std::fprintf(stderr, "failed: %s\n", what.c_str());
  ++failures;
}

std::string error_of(const std::string& stroke) {
  try {
    knead::parse_session("{\"knead\": 1}\n" + stroke + "\n", "toy.knead");
  } catch (const knead::InvalidInput& error) {
    return error.what();
  }
  return "";
}

void check_session() {
  const std::string line = R"({"tool": "toy", "center": [1, 0, 0], "push": [0.5, 0, 0], "outer": 0.5})";
  const knead::Session session = knead::parse_session("{\"knead\": 1}\n" + line + "\n", "toy.knead");
  const knead::Stroke& stroke = session.strokes.at(0).stroke;
  expect(knead::stroke_line(stroke) == line, "a stroke is written as it was read");
  expect(knead::flow_of(stroke).segments.size() == 1, "a stroke becomes a flow");
  expect(knead::stroke_line(knead::mirrored(stroke, 0)).find(R"("center": [-1, 0, 0], "push": [-0.5, 0, 0])") !=
             std::string::npos,
         "a stroke has a mirror image");
  expect(knead::words_of(stroke, "mm") == "Toy", "the history says what a stroke does");
  expect(knead::widest_outer(stroke, std::vector<knead::Vec3d>{{1, 0, 0}, {3, 0, 0}}) > 1, "its border can be widened");
  const std::string place = "toy.knead:2: ";
  expect(error_of(R"({"tool": "toy", "center": [1, 0, 0], "push": [1, 0, 0]})") ==
             place + R"("outer" is missing; tool "toy" needs it)",
         "a missing key is an error");
  expect(error_of(R"({"tool": "toy", "centre": [1, 0, 0]})").starts_with(place + R"(unknown key "centre")"),
         "an unknown key is an error");
  expect(error_of(R"({"tool": "toy", "center": [1, 0, 0], "push": [0, 0, 0], "outer": 1})")
             .starts_with(place + R"("push" must be a vector of any length but 0)"),
         "a wrong value is an error");
}

void check_studio() {
  const knead::studio::StudioTool* tool = knead::studio::studio_tool("toy");
  expect(tool != nullptr && !tool->icon.empty(), "Studio has the tool");
  if (tool == nullptr) return;
  const knead::studio::Action action = knead::studio::action_of(*tool);
  expect(knead::studio::name_of(action) == "tool_toy", "an action chooses it");
  expect(keys_text(knead::studio::default_keys(), action) == "Shift+1", "it has a key");
}

}  // namespace

int main(int /*argc*/, char** argv) {
  check_session();
  check_studio();
  const auto& names = knead::surveys::tool_names();
  expect(std::find(names.begin(), names.end(), "toy") != names.end(), "there are random strokes of it");
  std::ifstream file(argv[1]);
  std::stringstream document;
  document << file.rdbuf();
  for (const std::string& problem : knead::test::documentation_problems(document.str())) expect(false, problem);
  return failures == 0 ? 0 : 1;
}
