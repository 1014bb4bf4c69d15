// The pictures behind the shape.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <optional>

#include "panels/panels.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

// Moves the picture within its plane.
void draw_place(Reference& reference, UpAxis up, double diagonal) {
  const render::CameraFrame frame = frame_of(reference.plane, up);
  for (const auto& [label, direction] : {std::pair{"Right", frame.right}, {"Up", frame.up}}) {
    const double before = dot(reference.center, direction);
    double place = before;
    if (type_number(label, place, {-1e9, 1e9}, "of its middle, in the units of the shape")) {
      reference.center += direction * (place - before);
    }
  }
  slide("Height", reference.height, {1e-2 * diagonal, 10 * diagonal}, "of the picture, in the units of the shape");
}

// Returns false if the picture is to be taken away.
bool draw_reference(Reference& reference, UpAxis up, double diagonal) {
  ImGui::Checkbox("##shown", &reference.is_shown);
  ImGui::SameLine();
  ImGui::TextUnformatted(reference.file.filename().c_str());
  constexpr std::array planes{ReferencePlane::front, ReferencePlane::right, ReferencePlane::top};
  choose_one("Plane", reference.plane, planes, [](ReferencePlane plane) {
    return std::array{"Front", "Right", "Top"}[static_cast<std::size_t>(plane)];
  });
  slide("Opacity", reference.opacity, {0, 1}, nullptr);
  reference.opacity = std::clamp(reference.opacity, 0.0, 1.0);
  draw_place(reference, up, diagonal);
  ImGui::Checkbox("In every view", &reference.in_every_view);
  help_on_hover("otherwise only when you look straight at its plane (Alt+1, Alt+3, Alt+7)");
  ImGui::SameLine();
  return !ImGui::Button("Remove");
}

}  // namespace

void draw_references(Studio& studio) {
  std::vector<Reference>& references = studio.references();
  ImGui::Checkbox("Show", &studio.view().references);
  std::optional<std::size_t> removed;
  for (std::size_t i = 0; i < references.size(); ++i) {
    ImGui::Separator();
    ImGui::PushID(static_cast<int>(i));
    if (!draw_reference(references[i], studio.navigation().view.up, studio.shown().diagonal)) removed = i;
    ImGui::PopID();
  }
  if (removed) references.erase(references.begin() + static_cast<std::ptrdiff_t>(*removed));
}

}  // namespace knead::studio
