#include "headless.h"

#include <fmt/format.h>

#include <cstdio>
#include <optional>

#include "knead/gl.h"
#include "knead/io.h"
#include "knead/render.h"
#include "script.h"
#include "view/overlay.h"
#include "view/shown_shape.h"

namespace knead::studio {

namespace {

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
  const DocumentState& shown = studio.shown();
  canvas->shape.follow(shown.state, studio.pending(), shown.diagonal, canvas->view);
  if (const auto influence = canvas->overlay.influence(studio)) canvas->view.set_influence(*influence);
  if (const auto mask = canvas->overlay.mask(studio)) canvas->view.set_mask(*mask);
  const Screen screen = studio.screen();
  const render::Image image = canvas->view.picture(canvas->overlay.scene(studio), screen.width, screen.height);
  write_file_atomically(path, render::encode_png(image));
}

}  // namespace

bool run_headless(std::istream& script, const std::string& name, const StudioOptions& options, BackendChoice backend) {
  Studio studio(options);
  std::optional<Canvas> canvas;
  bool is_fine = true;
  const auto print_notices = [&] {
    for (const Notice& notice : studio.take_notices()) {
      if (notice.text.empty()) continue;
      fmt::print(stderr, "{}: {}\n", notice.is_error ? "error" : "note", notice.text);
      is_fine = is_fine && !notice.is_error;
    }
  };
  ScriptHost host;
  host.picture = [&](const std::filesystem::path& path) { write_picture(studio, path, backend, canvas); };
  host.after_event = print_notices;
  run_script(script, name, studio, host);
  studio.close();
  print_notices();
  return is_fine;
}

}  // namespace knead::studio
