// Mirrors and radial symmetry.
#include <imgui.h>

#include <array>

#include "panels/panels.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

void draw_mirrors(Studio& studio) {
  ToolSettings& settings = studio.settings();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted("Mirror");
  for (std::size_t i = 0; i < 3; ++i) {
    ImGui::SameLine();
    ImGui::Checkbox(std::array{"x", "y", "z"}[i], &settings.mirror[i]);
  }
  bool is_on = settings.symmetry.plane.has_value();
  if (is_on && ImGui::Checkbox("Mirror in a plane of your own", &is_on)) settings.symmetry.plane.reset();
  const bool face = studio.picking_mirror() == Studio::PlanePick::face;
  const bool three = studio.picking_mirror() == Studio::PlanePick::three_points;
  if (ImGui::Button(face ? "Click on the shape..." : "Plane from a face")) studio.pick_mirror(Studio::PlanePick::face);
  help_on_hover("The next click on the shape gives the plane: through that point, along the surface.");
  ImGui::SameLine();
  if (ImGui::Button(three ? "Click three points..." : "From three points"))
    studio.pick_mirror(Studio::PlanePick::three_points);
}

void draw_center(Studio& studio) {
  Vec3d& center = studio.settings().symmetry.center;
  if (ImGui::Button("Through the middle of the shape")) studio.center_symmetry();
  help_on_hover("moves the mirrors x, y and z and the axis of the turns there");
  if (center == Vec3d{0, 0, 0}) return;
  ImGui::SameLine();
  if (ImGui::Button("Origin")) center = {0, 0, 0};
}

void draw_turns(Symmetry& symmetry) {
  ImGui::SliderInt("Radial", &symmetry.turns, 1, kMaxTurns, symmetry.turns == 1 ? "off" : "%d times");
  help_on_hover("repeats everything about an axis");
  if (symmetry.turns < 2) return;
  for (std::size_t i = 0; i < 3; ++i) {
    Vec3d axis;
    axis[i] = 1;
    if (i > 0) ImGui::SameLine();
    if (ImGui::RadioButton(std::array{"x##turns", "y##turns", "z##turns"}[i], symmetry.axis == axis)) {
      symmetry.axis = axis;
    }
  }
}

}  // namespace

void draw_symmetry(Studio& studio) {
  draw_mirrors(studio);
  draw_turns(studio.settings().symmetry);
  draw_center(studio);
}

}  // namespace knead::studio
