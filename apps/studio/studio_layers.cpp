// Past entries, changed from the panel and in the view; and the view as the journal keeps it.
#include <utility>

#include "studio.h"
#include "view_memory.h"

namespace knead::studio {

void Studio::change_layers(const LayerChange& change) {
  if (gesture_) end(false);
  post([this, change](Progress& progress) { document_.change_layers(change, progress); }, "Changing the history");
}

// Of a drag only the latest step counts.
void Studio::drag_layers(const LayerChange& change) {
  if (gesture_) end(false);
  sent_ = worker_->post_latest([this, change](Progress& progress) { document_.drag_layers(change, progress); },
                               "Changing the history");
  refresh();
}

void Studio::end_layer_drag(bool is_kept) {
  post([this, is_kept](Progress& /*progress*/) { document_.end_layer_drag(is_kept); });
}

void Studio::select_layer(std::optional<std::size_t> entry) { select(layers_, shown_, entry); }

std::optional<LayerHandle> Studio::pointed_handle() const {
  if (layer_drag_) return layer_drag_->handle;
  if (!layers_.entry || gesture_ || shown_.looked_at) return std::nullopt;
  return handle_at(screen(), layers_.paths, pointer_.x, pointer_.y);
}

bool Studio::begin_handle_drag() {
  const std::optional<LayerHandle> handle = pointed_handle();
  if (!handle) return false;
  LayerDrag drag{*layers_.entry, *handle, place_of(layers_.paths, *handle), {0, 0, 0}, layers_.strokes};
  const Ray ray = ray_through(screen(), pointer_.x, pointer_.y);
  const auto taken = on_plane(ray, drag.start, render::camera_frame(screen().camera).forward);
  if (taken) drag.offset = drag.start - *taken;
  layer_drag_ = std::move(drag);
  return true;
}

// In the plane of the view.
void Studio::move_handle() {
  const Ray ray = ray_through(screen(), pointer_.x, pointer_.y);
  const auto at = on_plane(ray, layer_drag_->start, render::camera_frame(screen().camera).forward);
  if (!at) return;
  const Vec3d by = *at + layer_drag_->offset - layer_drag_->start;
  std::vector<SessionStroke> strokes = with_handle_moved(layer_drag_->strokes, layer_drag_->handle, by);
  if (strokes == layers_.strokes) return;
  set_strokes(layers_, strokes);
  drag_layers(replaced(layer_drag_->entry, std::move(strokes)));
}

void Studio::end_handle_drag(bool is_kept) {
  if (is_kept) move_handle();
  if (!is_kept) set_strokes(layers_, layer_drag_->strokes);
  layer_drag_.reset();
  end_layer_drag(is_kept);
}

void Studio::remember_view() {
  const bool is_moving = gesture_ || adjusting_ || turntable_ || navigation_.drag != NavigationDrag::none;
  if (shown_.opened == 0 || is_moving) return;
  std::string view = script_of_view(*this);
  if (view == remembered_view_) return;
  remembered_view_ = view;
  worker_->post([this, view = std::move(view)](Progress& /*progress*/) { document_.remember_view(view); });
}

}  // namespace knead::studio
