// The history of the open document as panels and the pointer change it.
//
// Changes (document/layers.h) are made in the background; the view shows the old state until they are done.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "document/layers.h"
#include "gestures/gesture.h"
#include "studio_document.h"

namespace knead::studio {

class StudioHistory {
 public:
  // `interrupt` gives up the current gesture, before the history changes.
  StudioHistory(StudioDocument& document, std::function<void()> interrupt);

  void undo();
  void redo();
  void change(const LayerChange& change);
  // Changes the history during a drag. The steps of a drag are one change; only the latest step counts.
  void drag(const LayerChange& change);
  void end_drag(bool is_kept);
  // The same for the stroke of the current gesture, by grown().
  void grow(std::size_t entry, const SessionStroke& stroke);

  // Shows the shape after that many entries; std::nullopt: the present shape.
  void look_at(std::optional<std::size_t> entries);
  void look_at_frame(const FrameExport& how, int frame);  // from 0

  // The selected entry, and its changes that are not applied yet.
  void select(std::optional<std::size_t> entry);
  LayerEditor& editor() { return editor_; }
  const LayerEditor& editor() const { return editor_; }
  // Adapts to the document after its refresh(). clear() drops everything when another document was opened.
  void follow();
  void clear();

  // Returns the handle of the selected entry that the pointer is on, or drags in the plane of the view.
  std::optional<LayerHandle> pointed_handle(const Screen& screen, const Pointer& pointer) const;
  bool is_dragging() const { return drag_.has_value(); }
  bool begin_handle(const Screen& screen, const Pointer& pointer);  // returns false if it is on none
  void move_handle(const Screen& screen, const Pointer& pointer);
  void end_handle(bool is_kept);

 private:
  struct HandleDrag {
    std::size_t entry = 0;
    LayerHandle handle;
    Vec3d start;                         // where the handle was
    Vec3d offset;                        // from where the pointer took hold of it
    std::vector<SessionStroke> strokes;  // of the entry, as they were
  };

  void post_step(const LayerChange& change, std::string what);

  StudioDocument& document_;
  std::function<void()> interrupt_;
  LayerEditor editor_;
  std::optional<HandleDrag> drag_;
};

}  // namespace knead::studio
