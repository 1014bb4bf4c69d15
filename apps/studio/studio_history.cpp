// Undo, redo, and the entry that is selected and edited.
#include "studio_history.h"

#include <utility>

#include "knead/editor/render.h"

namespace knead::studio {

StudioHistory::StudioHistory(StudioDocument& document, std::function<void()> interrupt)
    : document_(document), interrupt_(std::move(interrupt)) {}

void StudioHistory::undo() {
  document_.post([](Document& document, Progress& progress) { document.undo(progress); }, "Undo");
}

void StudioHistory::redo() {
  document_.post([](Document& document, Progress& progress) { document.redo(progress); }, "Redo");
}

void StudioHistory::change(const LayerChange& change) {
  interrupt_();
  document_.post([change](Document& document, Progress& progress) { document.change_layers(change, progress); },
                 "Changing the history");
}

void StudioHistory::drag(const LayerChange& change) {
  interrupt_();
  post_step(change, "Changing the history");
}

void StudioHistory::grow(std::size_t entry, const SessionStroke& stroke) {
  post_step(grown(entry, stroke), name_of({&stroke, 1}));
}

void StudioHistory::post_step(const LayerChange& change, std::string what) {
  document_.post_latest([change](Document& document, Progress& progress) { document.drag_layers(change, progress); },
                        std::move(what));
}

void StudioHistory::end_drag(bool is_kept) {
  document_.post([is_kept](Document& document, Progress& /*progress*/) { document.end_layer_drag(is_kept); },
                 "Changing the history");
}

void StudioHistory::look_at(std::optional<std::size_t> entries) {
  interrupt_();
  document_.post([entries](Document& document, Progress& progress) { document.look_at(entries, progress); },
                 "Making the earlier shape");
}

void StudioHistory::look_at_frame(const FrameExport& how, int frame) {
  interrupt_();
  document_.post_latest(
      [how, frame](Document& document, Progress& progress) { document.look_at_frame(how, frame, progress); },
      "Making the frames");
}

void StudioHistory::select(std::optional<std::size_t> entry) { studio::select(editor_, document_.shown(), entry); }

void StudioHistory::follow() {
  if (!document_.worker().is_busy() && !drag_) studio::follow(editor_, document_.shown());
  if (editor_.entry && *editor_.entry >= document_.shown().history.size()) editor_ = {};
}

void StudioHistory::clear() {
  editor_ = {};
  drag_.reset();
}

std::optional<LayerHandle> StudioHistory::pointed_handle(const Screen& screen, const Pointer& pointer) const {
  if (drag_) return drag_->handle;
  if (!editor_.entry || document_.shown().looked_at) return std::nullopt;
  return handle_at(screen, editor_.paths, pointer.x, pointer.y);
}

bool StudioHistory::begin_handle(const Screen& screen, const Pointer& pointer) {
  const std::optional<LayerHandle> handle = pointed_handle(screen, pointer);
  if (!handle) return false;
  HandleDrag drag{*editor_.entry, *handle, place_of(editor_.paths, *handle), {0, 0, 0}, editor_.strokes};
  const Ray ray = ray_through(screen, pointer.x, pointer.y);
  const auto taken = on_plane(ray, drag.start, render::camera_frame(screen.camera).forward);
  if (taken) drag.offset = drag.start - *taken;
  drag_ = std::move(drag);
  return true;
}

void StudioHistory::move_handle(const Screen& screen, const Pointer& pointer) {
  const Ray ray = ray_through(screen, pointer.x, pointer.y);
  const auto at = on_plane(ray, drag_->start, render::camera_frame(screen.camera).forward);
  if (!at) return;
  std::vector<SessionStroke> strokes =
      with_handle_moved(drag_->strokes, drag_->handle, *at + drag_->offset - drag_->start);
  if (strokes == editor_.strokes) return;
  set_strokes(editor_, strokes);
  drag(replaced(drag_->entry, std::move(strokes)));
}

void StudioHistory::end_handle(bool is_kept) {
  if (!is_kept) set_strokes(editor_, drag_->strokes);
  drag_.reset();
  end_drag(is_kept);
}

}  // namespace knead::studio
