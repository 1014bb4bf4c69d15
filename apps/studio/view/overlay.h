// What is seen besides the shape: the tool's region, the gizmo, what is placed, the cut; and the influence as colour.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gestures/picker.h"
#include "knead/editor/render.h"
#include "knead/editor/shape_state.h"
#include "knead/editor/tools.h"
#include "knead/flow.h"
#include "studio.h"

namespace knead::studio {

// What a gesture would act on that began now.
GestureContext next_context(const Studio& studio);

// Adds the cursor: a solid ring where the tool's outer region begins, and a dashed one where its motion has fallen to
// half, thicker for a stronger tool. Both lie in the tangent plane of the surface at the pointer, or during a pull at
// the tool; beside the shape in a plane that faces the viewer. Mirror images are dots. A print's
// outline stands in the place of the rings. Tools that are placed have no cursor.
void add_cursor(const Studio& studio, std::span<const PlaneLine> outline, std::vector<render::Line>& lines);

// Makes the overlays, and keeps them, so that only changed ones are made again.
class Overlay {
 public:
  // Returns the scene for the live view in the current state of Studio.
  render::LiveScene scene(const Studio& studio);

  // Returns the scene for the view of a fit's target.
  static render::LiveScene target_scene(const Studio& studio);

  // Returns the influence, the stretch or the distance from the target at each vertex, as the view shows it; empty if
  // it shows none. Returns nothing if that has not changed since the last call.
  std::optional<std::vector<float>> influence(const Studio& studio);

  // Returns how dark the mask makes each vertex, from 0 to 1; nothing if that has not changed since the last call.
  std::optional<std::vector<float>> mask(const Studio& studio);
  // Returns whether the stretch that the view asks for is known.
  bool knows_stretch() const { return knows_stretch_; }

  // Returns why a tool that turns cannot be used at its placement; an empty text if it can.
  static std::string placement_problem(const Studio& studio);

 private:
  std::optional<std::vector<float>> stretch(const Studio& studio);
  std::optional<std::vector<float>> parts(const Studio& studio);
  std::optional<std::vector<float>> distances(const Studio& studio);
  // Of what the tool would print; empty if that is nothing, or no print.
  const std::vector<PlaneLine>& outline(const Studio& studio);

  std::vector<Stroke> drawn_;  // strokes whose regions are in parts_
  render::Scene parts_;
  render::SurfaceCache surfaces_;
  PrintStroke outlined_;  // whose outline this is
  std::vector<PlaneLine> outline_;
  std::vector<Stroke> influencing_;
  std::uint64_t influenced_version_ = 0;
  bool has_influence_ = false;
  std::uint64_t mask_version_ = 0;
  std::shared_ptr<const Mesh> mask_mesh_;
  Mask mask_;
  bool was_masking_ = false;
  bool has_mask_ = false;
  std::vector<float> part_shades_;
  std::shared_ptr<const Mesh> part_mesh_;
  std::uint64_t measured_ = 0;                // StudioFit::measured() of the distances that are shown; 0: none are
  StretchView stretched_ = StretchView::off;  // what has_influence_ is about, if not the tool
  bool knows_stretch_ = false;
};

// Returns the strokes with which the tool would begin at the pointer, with mirror images; empty if it would do nothing.
std::vector<Stroke> hovering(const Studio& studio);

// --- influence: the fraction of a tool's motion that vertices would have
// ---------------------------------------------------

// Returns for each vertex the weight w = (1 - b)^2 of the inner motion, from 0 (outside) to 1 (inner region), at the
// beginning of the flows; of several flows the greatest. Evaluated by the fields themselves, in double.
std::vector<float> influence_of(std::span<const Flow> flows, const Snapshot& positions, int threads = 0);

// Returns the displacement of each vertex by pins, relative to the greatest one of a pin; empty for an impossible
// stroke.
std::vector<float> influence_of(const PinsStroke& stroke, const Snapshot& positions, int threads = 0);

// --- texts and arrows in the view
// --------------------------------------------------------------------------------------

// The arrow that shows which vertical movement of the pointer takes the tool into the picture.
struct InArrow {
  Vec3d from;
  Vec3d to;
};

// Returns the arrow for a drag along a line that faces the viewer: of the current gesture, or of the one that would
// begin at the pointer. Nothing for other drags.
std::optional<InArrow> in_arrow(const Studio& studio);

// Returns the sign of a unit: "mm", "\u00b0", "%".
std::string sign_of(AmountKind kind, LengthUnit unit);

// Returns a number with its unit: "12.5 mm", "45\u00b0", "30%".
std::string text_of(const Amount& amount, LengthUnit unit);

// Returns the lines at the pointer: what was typed or dragged, the radius, the change of the volume. Empty without a
// gesture.
std::vector<std::string> numbers_at_pointer(const Studio& studio);

// --- pins
// -------------------------------------------------------------------------------------------------------------

inline constexpr render::Color kPlaced{0.95f, 0.55f, 0.10f, 1};    // of placed things
inline constexpr render::Color kLitHandle{1.0f, 0.85f, 0.25f, 1};  // of the thing under the pointer

// The colour of a pair of points of a fit.
render::Color color_of_pair(std::size_t pair);

// The clicked points of one of the two shapes of a fit.
void add_fit_points(const Studio& studio, bool of_target, const Screen& screen, std::vector<render::Line>& lines);

// Adds the line of bend_along with its handles, or the line that is drawn for it.
void add_bend_line(const Studio& studio, std::vector<render::Line>& lines);

// Adds the lattice: its control points, of which selected ones are lighter, and lines between neighbours.
void add_lattice(const Studio& studio, std::vector<render::Line>& lines);

// Blue pins hold, white ones are free, selected and dragged ones are orange; images are smaller.
void add_pins(const Studio& studio, std::vector<render::Line>& lines);

// Returns a stroke that moves the pin at the pointer, else the last one, a little up in the picture.
std::optional<PinsStroke> hovering_pins(const Studio& studio);

// --- stretch of the shape, and of what the tool would do ----------------------------------

// The stretch that is drawn in the last colour; 1 is drawn in the first, and equal factors are equally far apart.
inline constexpr double kGreatestShown = 8;

// Returns where a stretch lies between the first colour and the last one, from 0 to 1.
float shade_of_stretch(double stretch);

// Returns for each vertex of the shown shape the greatest stretch of its triangles, since the start or by the last
// stroke (the current one during a gesture); nothing if the places that it is stretched from are not known.
std::optional<std::vector<float>> stretches_shown(const DocumentState& shown, StretchView since);

// Estimates what the tool would do to the shape, and remembers it while nothing changes.
class StretchEstimate {
 public:
  // Returns the estimate for the strokes of the current gesture, or for those that a placed tool would begin with;
  // nothing for tools that are not placed and turned.
  const std::optional<GreatestStretch>& update(const Studio& studio);

 private:
  std::vector<Stroke> strokes_;
  ShapeState state_;
  std::vector<Vec3d> positions_;  // of some vertices of state_
  std::optional<GreatestStretch> estimate_;
};

// Returns one line about a zone that was widened for the current gesture or the placed tool; empty: none was.
std::string zone_note(const Studio& studio);

}  // namespace knead::studio
