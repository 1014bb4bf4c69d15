// What a script does besides events: it restores a view, and it runs without a window.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <sstream>
#include <vector>

#include "application.h"
#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/error.h"
#include "knead/io.h"
#include "script.h"
#include "setting.h"
#include "view/overlay.h"
#include "view/shown_shape.h"

namespace knead::studio {

namespace {

std::string text_of(const Vec3d& v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); }

// The shape may be another when they come back: one that was remeshed last has other vertices, and one that is dragged
// has them in other places.
std::string pins_line(const std::vector<Pin>& pins, const ShapeState& state) {
  std::string text;
  for (const Pin& pin : pins) {
    text += fmt::format(R"({}{{"place": {}, "holds": {})", text.empty() ? "" : ", ", text_of(pin.place), pin.holds);
    const auto found = std::find_if(pin.vertices.begin(), pin.vertices.end(),
                                    [&](const Pin::PinVertex& one) { return one.mesh.lock() == state.mesh; });
    if (found != pin.vertices.end()) text += fmt::format(R"(, "vertex": {})", found->vertex);
    text += "}";
  }
  return fmt::format(R"({{"pins": [{}], "of": {}}})", text, state.positions.size());
}

// By the numbers that the vertices have now. Asked for often, so in one pass over the vertices.
std::string parts_line(const PartMarks& parts) {
  std::vector<std::string> ranges(parts.holds.size());
  const std::vector<std::uint8_t>& marks = parts.of_vertex;
  for (std::size_t first = 0; first < marks.size();) {
    std::size_t end = first + 1;
    while (end < marks.size() && marks[end] == marks[first]) ++end;
    if (marks[first] != 0) {
      std::string& own = ranges[marks[first] - 1u];
      own += fmt::format("{}[{}, {}]", own.empty() ? "" : ", ", first, end - 1);
    }
    first = end;
  }
  std::string text;
  for (std::size_t part = 0; part < ranges.size(); ++part) {
    text += fmt::format(R"({}{{"vertices": [{}], "holds": {}, "stiffness": {}}})", text.empty() ? "" : ", ",
                        ranges[part], parts.holds[part], parts.stiffness[part]);
  }
  return fmt::format(R"({{"parts": [{}], "of": {}}})", text, marks.size());
}

// The context comes first, and goes last.
struct Canvas {
  gl::OffscreenContext context;
  render::LiveView view;
  Overlay overlay;
  ShownShape shape;
};

void write_picture(const Studio& studio, const std::filesystem::path& path, BackendChoice backend,
                   std::optional<Canvas>& canvas) {
  if (!canvas) {
    canvas.emplace();
    if (backend == BackendChoice::gpu) canvas->shape.use_gpu();
  }
  const DocumentState& shown = studio.document().shown();
  canvas->shape.show(shown.objects);
  canvas->shape.follow(shown.state, studio.pending(), shown.diagonal, canvas->view);
  if (const auto influence = canvas->overlay.influence(studio)) canvas->view.set_influence(*influence);
  if (const auto mask = canvas->overlay.mask(studio)) canvas->view.set_mask(*mask);
  const Screen screen = studio.view().screen();
  const render::Image image = canvas->view.picture(canvas->overlay.scene(studio), screen.width, screen.height);
  write_file_atomically(path, render::encode_png(image));
}

}  // namespace

std::string script_of_view(Studio& studio) {
  const std::string tool = fmt::format(R"({{"tool": "{}"}})", word_of(*studio.tools().settings().tool));
  const std::vector<Pin>& pins = studio.tools().placed().pins;
  const std::string of_pins = pins.empty() ? "" : pins_line(pins, studio.document().shown().state) + "\n";
  const PartMarks& parts = studio.tools().placed().parts;
  const std::string of_parts = parts.holds.empty() ? "" : parts_line(parts) + "\n";
  const Json set{{"set", json_of(settings_of(studio.tools().settings()))}};
  const Json view{{"view", json_of(settings_of(studio.view().navigation().view))}};
  return tool + "\n" + to_text(set) + "\n" + to_text(view) + "\n" + of_pins + of_parts;
}

void restore_view(Studio& studio, const std::string& script) {
  std::istringstream lines(script);
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream one(line);
    try {
      run_script(one, "view", studio, {});
    } catch (const InvalidInput& error) {
      studio.document().tell({false, fmt::format("The view could not be restored as it was: {}", error.what())});
    }
  }
}

bool run_headless(std::istream& script, const std::string& name, const StudioOptions& options, BackendChoice backend) {
  Studio studio(options);
  std::optional<Canvas> canvas;
  bool is_fine = true;
  const auto print_notices = [&] {
    for (const Notice& notice : studio.document().take_notices()) {
      if (notice.text.empty()) continue;
      fmt::print(stderr, "{}: {}\n", notice.is_error ? "error" : "note", notice.text);
      is_fine = is_fine && !notice.is_error;
    }
  };
  ScriptHost host;
  host.picture = [&](const std::filesystem::path& path) { write_picture(studio, path, backend, canvas); };
  host.after_event = print_notices;
  run_script(script, name, studio, host);
  studio.document().close();
  print_notices();
  return is_fine;
}

}  // namespace knead::studio
