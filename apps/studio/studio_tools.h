// The tool in use, its settings, what is placed for it (points, curves, pins, parts, a stamp, mirrors), and masks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gestures/gesture.h"
#include "gestures/tools.h"
#include "keys.h"
#include "studio_document.h"

namespace knead::studio {

// Returns the step of lengths while Ctrl is held: 1, 2 or 5 times a power of ten, about a hundredth of the diagonal.
double snap_length(double diagonal);

class StudioTools {
 public:
  // `interrupt` gives up the current gesture, before another tool is chosen.
  StudioTools(StudioDocument& document, std::function<void()> interrupt)
      : document_(document), interrupt_(std::move(interrupt)) {}

  ToolSettings& settings() { return settings_; }
  const ToolSettings& settings() const { return settings_; }
  PlacedTools& placed() { return placed_; }
  const PlacedTools& placed() const { return placed_; }

  // Performs an action of a key or menu; returns false if it does not concern the tool in use.
  bool perform(Action action);
  // Adapts to a new document. follow() adapts to its changes, completely only between gestures.
  void begin_document();
  void follow(bool has_gesture);
  // Lays the line of bend_along through the shape as it is: where the last stroke has taken it, or, at first and after
  // clear_placed(), along the shape's longest axis. Must not be called while a gesture waits for the shape.
  void follow_line();

  // Shows the lattice of the last entry of the history, or lays one about the shape as it is: at first, with other
  // counts, and after clear_placed(). Must not be called during a gesture.
  void follow_lattice();

  // Returns the radius of the tool; for pins the automatic one, unless it is set. fix_radius() sets it to that.
  double radius() const;
  void fix_radius();

  // Removes everything that is placed, except pins, parts and the stamp, and deselects pins and parts.
  void clear_placed();

  // Returns the box of everything that the tool in use has placed; empty if there is nothing.
  Box placed_box() const;

  // Moves the placed stamp back to the start of these strokes, if it is at their end.
  void take_stamp_back(std::span<const SessionStroke> strokes);

  // Loads a stamp. A file also chooses the tool: a mesh is stamped, a picture printed.
  void use_stamp(ShapeKind kind);
  void use_stamp(const std::filesystem::path& file);

  // Replaces all pins; one whose vertex is not known takes the nearest one.
  void set_pins(std::vector<Pin> pins);
  void select_pins(bool are_selected);
  void remove_pin(std::size_t pin);
  void remove_selected();  // pins, and the part
  // The pin in placed() that the last click has set.
  void note_set_pin(std::optional<std::size_t> pin) { set_pin_ = pin; }
  std::optional<std::size_t> set_pin() const { return set_pin_; }

  // Finds the part that the placed twist or bend moves. `may_turn`, for a new placement: its axis may turn.
  void find_limit_cylinder(bool may_turn);

  // Uses the next click on the shape (`face`), or the next three, for the plane of one more mirror. A second call
  // cancels this.
  enum class PlanePick { none, face, three_points };
  void pick_mirror(PlanePick how);
  PlanePick picking_mirror() const { return picking_; }
  // Returns whether the click was used for the plane.
  bool pick_plane(const Pointer& pointer, const GestureContext& context);
  // Moves the mirrors x, y and z and the axis to the middle of the shape's box.
  void center_symmetry();

 private:
  std::optional<std::vector<Vec3d>> bent_line();
  const LatticeStroke* last_lattice();
  void set_stamp(const std::function<StampShape(Document&)>& make);
  void set_picture(const std::filesystem::path& source);
  // Has the worker do it, and tell what is wrong with a stamp.
  void load(const StudioDocument::Job& job);

  StudioDocument& document_;
  std::function<void()> interrupt_;
  ToolSettings settings_;
  PlacedTools placed_;
  PlanePick picking_ = PlanePick::none;
  std::optional<std::size_t> set_pin_;
  std::uint64_t line_version_ = 0;     // of the document, for which the line was laid
  std::size_t first_bend_ = 0;         // the entry of the history from which on strokes have taken the line along
  std::uint64_t lattice_version_ = 0;  // as line_version_
  std::size_t first_lattice_ = 0;      // the entry of the history from which on a lattice may grow
  // The mesh for which the limit cylinder was found; remeshing may change it later.
  std::shared_ptr<const Mesh> limit_cylinder_mesh_;
};

// Masks: painted, drawn round, and changed as a whole. Each change is a stroke in the history.
class StudioMasks {
 public:
  // `apply` applies strokes to the document as a gesture of their own.
  StudioMasks(StudioDocument& document, StudioTools& tools, std::function<void(std::vector<SessionStroke>)> apply);

  // Returns the mask's value at each vertex, with the current drag; empty if no vertex is masked.
  const MaskValues& values() const { return values_; }

  // Paint, or draw a line, from one event to the next.
  void begin(const Pointer& pointer, const GestureContext& context);
  void move(const Pointer& pointer, const GestureContext& context);
  void end(bool is_kept);
  bool is_drawing() const { return drawing_.has_value(); }
  // Returns the line drawn so far; empty while a brush paints.
  std::vector<Pixel> line() const;

  // Changes the whole mask.
  void change(MaskEdit edit);

  // Takes over the mask of the document if it has changed. clear() ends the current drag without effect.
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
