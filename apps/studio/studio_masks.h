// Masks: painted, drawn round, and changed as a whole. Each change is a stroke in the history.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "gestures/gesture.h"
#include "studio_document.h"
#include "studio_tools.h"

namespace knead::studio {

class StudioMasks {
 public:
  // `apply` applies strokes to the document as a gesture of their own.
  StudioMasks(StudioDocument& document, StudioTools& tools, std::function<void(std::vector<SessionStroke>)> apply);

  // Returns how much each vertex is masked, as painted so far; empty: no vertex is.
  const MaskValues& values() const { return values_; }

  // Paints or draws a line from one event to the next.
  void begin(const Pointer& pointer, const GestureContext& context);
  void move(const Pointer& pointer, const GestureContext& context);
  void end(bool is_kept);
  bool is_drawing() const { return drawing_.has_value(); }
  // Returns the line drawn so far; empty while a brush paints.
  std::vector<Pixel> line() const;

  // Changes the whole mask.
  void change(MaskEdit edit);

  // Takes over the mask of the document if it has changed. clear() ends what is being drawn, without effect.
  void follow();
  void clear() { drawing_.reset(); }

 private:
  struct Drawing {
    MaskValues before;
    bool erases = false;
    std::vector<Pixel> line;
    Screen screen;
  };

  void paint(const Pointer& pointer, const GestureContext& context);
  void apply();

  StudioDocument& document_;
  StudioTools& tools_;
  std::function<void(std::vector<SessionStroke>)> apply_;
  MaskValues values_;
  Mask values_mask_;                         // the document's when the values were made
  std::shared_ptr<const Mesh> values_mesh_;  // the document's mesh then
  std::optional<Drawing> drawing_;
};

}  // namespace knead::studio
