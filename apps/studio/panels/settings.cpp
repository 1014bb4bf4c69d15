// The settings of the chosen tool, of symmetry, of remeshing and of the view.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "gestures/gesture_kinds.h"
#include "knead/editor/tools.h"
#include "knead/field.h"
#include "knead/mesh.h"
#include "panels/panels.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

constexpr float kEdge = 7;               // points at the left of the panel that can be dragged
constexpr float kMaxEditorShare = 0.7F;  // of the room of the history
constexpr std::size_t kVerticesOfPicture = 800;
constexpr double kSoftest = 0.01;  // of a part of a pose
constexpr double kStiffest = 100;
constexpr float kMarksShown = 6;        // rows of the list of pins and parts
constexpr float kBeforeNumbers = 3.8F;  // in font sizes: before the places in that list
constexpr double kCoarsestPose = 0.15;  // of the shape's size
constexpr int kFinestLevel = 6;
constexpr int kCoarsestResolution = 10;
constexpr int kFinestResolution = 1000;
const ImVec4 kSelected{0.95F, 0.55F, 0.10F, 1};  // pins

// The three axes, side by side.
void choose_axis(const char* name, Vec3d& chosen) {
  ImGui::PushID(name);
  for (std::size_t i = 0; i < 3; ++i) {
    Vec3d axis;
    axis[i] = 1;
    if (i > 0) ImGui::SameLine();
    if (ImGui::RadioButton(std::array{"x", "y", "z"}[i], norm(cross(chosen, axis)) < 1e-9)) chosen = axis;
  }
  ImGui::PopID();
}

void draw_drag(Studio& studio) {
  ToolSettings& settings = studio.tools().settings();
  if (settings.drag == DragMode::axis) choose_axis("axis", settings.axis);
  if (settings.tool->use == ToolUse::pull && settings.tool->brush == nullptr) draw_tool_setting(studio, "start");
}

void draw_limit_cylinder_settings(Studio& studio) {
  draw_tool_setting(studio, "limit_cylinder");
  draw_tool_setting(studio, "widens_zone");
  const auto& placement = studio.tools().placed().placement;
  const bool is_known = placement && placement->limit_cylinder;
  const bool is_found = is_known && placement->limit_cylinder->problem.empty();
  // One line in each case, because it comes when the search ends: nothing moves.
  ImGui::TextDisabled("%s", is_found   ? "What is in the grey cylinder moves alone."
                            : is_known ? "No part is found here."
                                       : "Click on a finger, an arm or a leg.");
}

// The places of a pin, each a number that can be typed.
void draw_place_of_pin(Studio& studio, std::size_t number) {
  Vec3d place = studio.tools().placed().pins[number].place;
  bool is_moved = false;
  const float font = ImGui::GetFontSize();
  const float width = (ImGui::GetContentRegionAvail().x - kBeforeNumbers * font) / 3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ImGui::SameLine(kBeforeNumbers * font + static_cast<float>(axis) * (width + 0.2F * font));
    ImGui::SetNextItemWidth(width);
    const double most = std::numeric_limits<double>::max();
    const char* const label = std::array{"##x", "##y", "##z"}[axis];
    is_moved = type_number(label, place[axis], {-most, most}, nullptr, "%.4g") || is_moved;
  }
  if (is_moved) studio.move_pin(number, place);
}

// Whether a pin or a part holds, and its name, which is clicked to select it. Returns whether it was clicked.
bool draw_marked(bool& holds, bool is_selected, const std::string& name, float width) {
  ImGui::Checkbox("##holds", &holds);
  help_on_hover("Checked: it holds while others are dragged. Else it is free, and goes with the shape.");
  ImGui::SameLine();
  if (is_selected) ImGui::PushStyleColor(ImGuiCol_Text, kSelected);
  const bool is_clicked = ImGui::Selectable(name.c_str(), is_selected, 0, {width, 0});
  if (is_selected) ImGui::PopStyleColor();
  return is_clicked;
}

void draw_parts(PartMarks& parts) {
  for (std::size_t part = 0; part < parts.holds.size(); ++part) {
    ImGui::PushID(static_cast<int>(part));
    bool holds = parts.holds[part];
    const bool is_selected = parts.selected == part;
    if (draw_marked(holds, is_selected, fmt::format("Part {}", part + 1), 0)) {
      select_part(is_selected ? std::nullopt : std::optional(part), parts);
    }
    parts.holds[part] = holds;
    ImGui::PopID();
  }
}

void draw_pins(Studio& studio) {
  std::vector<Pin>& pins = studio.tools().placed().pins;
  studio.tools().placed().lit_pin.reset();
  const float row = ImGui::GetFrameHeightWithSpacing();
  for (std::size_t i = 0; i < pins.size(); ++i) {
    ImGui::PushID(&pins + 1 + i);
    const float top = ImGui::GetCursorScreenPos().y;
    if (draw_marked(pins[i].holds, pins[i].is_selected, fmt::format("{}", i), 1.4F * ImGui::GetFontSize())) {
      pins[i].is_selected = !pins[i].is_selected;
    }
    draw_place_of_pin(studio, i);
    const float y = ImGui::GetIO().MousePos.y;
    if (ImGui::IsWindowHovered(ImGuiHoveredFlags_AllowWhenBlockedByActiveItem) && y >= top && y < top + row) {
      studio.tools().placed().lit_pin = i;
    }
    ImGui::PopID();
  }
}

// Pins and parts, in a list that is as high whatever is in it, and above it what is done with those that are selected:
// nothing that is clicked moves.
void draw_marks(Studio& studio) {
  PlacedTools& placed = studio.tools().placed();
  const bool has_parts = !has_exact_pins(studio.tools().settings());
  draw_tool_setting(studio, "lasso_selects");
  const bool has_selected_part = has_parts && placed.parts.selected.has_value();
  const auto selected = static_cast<std::size_t>(
      std::count_if(placed.pins.begin(), placed.pins.end(), [](const Pin& pin) { return pin.is_selected; }));
  ImGui::BeginDisabled(selected == 0 && !has_selected_part);
  if (ImGui::Button("Remove")) studio.tools().remove_selected();
  ImGui::EndDisabled();
  help_on_hover("Removes the pins and the part that are selected (Alt+click removes one).");
  ImGui::SameLine();
  if (ImGui::Button("Clear")) {
    studio.tools().set_pins({});
    if (has_parts) placed.parts = {};
  }
  ImGui::SameLine();
  const float width = ImGui::CalcTextSize("Select none").x + 2 * ImGui::GetStyle().FramePadding.x;
  if (ImGui::Button(selected == 0 ? "Select all##pins" : "Select none##pins", {width, 0})) {
    studio.tools().select_pins(selected == 0);
  }
  ImGui::SameLine();
  ImGui::TextDisabled("%zu of %zu", selected, placed.pins.size());
  help_on_hover("pins that are selected, and all");
  if (has_parts) {
    const std::optional<std::size_t> part = placed.parts.selected;
    double stiffness = part ? placed.parts.stiffness[*part] : 1;
    ImGui::BeginDisabled(!part);
    slide("Stiffness", stiffness, {kSoftest, kStiffest},
          "how stiff the selected part is where it bends: bone above 1, flesh below; it counts until the shape is "
          "remeshed");
    ImGui::EndDisabled();
    if (part) placed.parts.stiffness[*part] = stiffness;
  }
  ImGui::BeginChild("##pins", {0, ImGui::GetFrameHeightWithSpacing() * kMarksShown + 2});
  if (placed.pins.empty() && (!has_parts || placed.parts.holds.empty()))
    ImGui::TextDisabled(has_parts ? "No pins or parts yet." : "No pins yet.");
  if (has_parts) draw_parts(placed.parts);
  draw_pins(studio);
  ImGui::EndChild();
}

// How fine a pose is, in steps of a third: at 0 as the thickness of what moves asks.
void draw_fineness(double& detail) {
  int level = detail > 0 ? static_cast<int>(std::lround(std::log(kCoarsestPose / detail) / std::log(1.5))) + 1 : 0;
  const std::string text = level == 0 ? "automatic" : fmt::format("{}", level);
  if (slide_whole("Fineness", level, 0, kFinestLevel, text)) {
    detail = level == 0 ? 0 : kCoarsestPose / std::pow(1.5, level - 1);
  }
  help_on_hover("how thin the parts are that move alone: finer takes longer; automatic: as thin as they are");
}

void draw_mask(Studio& studio) {
  constexpr std::array actions{std::pair{Action::mask_fill, "Fill"},     std::pair{Action::mask_clear, "Clear"},
                               std::pair{Action::mask_invert, "Invert"}, std::pair{Action::mask_blur, "Blur"},
                               std::pair{Action::mask_grow, "Grow"},     std::pair{Action::mask_shrink, "Shrink"},
                               std::pair{Action::hide_masked, "Hide"},   std::pair{Action::hide_unmasked, "Isolate"},
                               std::pair{Action::show_all, "Show all"}};
  for (std::size_t i = 0; i < actions.size(); ++i) {
    if (i % 3 != 0) ImGui::SameLine();
    if (ImGui::Button(actions[i].second)) studio.perform(actions[i].first);
    help_on_hover(keys_text(studio.preferences().keys, actions[i].first).c_str());
  }
}

void draw_own_settings(Studio& studio) {
  ToolSettings& settings = studio.tools().settings();
  const StudioTool& tool = *settings.tool;
  if (tool.use == ToolUse::stamp) draw_tool_setting(studio, "contact");
  if (has_two_signs(tool.use)) draw_tool_setting(studio, "paint_in");
  if (tool.use == ToolUse::print && !studio.tools().placed().picture) draw_font(settings.font);
  if (tool.use == ToolUse::points || tool.use == ToolUse::curve) {
    ImGui::TextDisabled("%zu points, %zu curves", studio.tools().placed().points.size(),
                        studio.tools().placed().curves.size());
    if (ImGui::Button("Clear")) studio.tools().clear_placed();
  }
  if (tool.use == ToolUse::bend_along) draw_tool_setting(studio, "bend_keep");
  for (const char* key : {"lattice_x", "lattice_y", "lattice_z"}) {
    if (tool.use == ToolUse::lattice) draw_tool_setting(studio, key);
  }
  if (tool.turning.takes_limit_cylinder) draw_limit_cylinder_settings(studio);
  if (tool.use == ToolUse::pose) {
    if (settings.pose != PoseMode::exact) draw_fineness(settings.pose_detail);
    draw_marks(studio);
  }
  if (tool.use == ToolUse::mask) draw_mask(studio);
}

void draw_remeshing(Studio& studio) {
  ToolSettings& settings = studio.tools().settings();
  draw_tool_setting(studio, "remesh");
  if (!settings.remesh) return;
  std::optional<double>& longest = settings.remesh_settings.max_edge;
  const double diagonal = studio.document().shown().diagonal;
  int edges = longest ? static_cast<int>(std::lround(diagonal / *longest)) : 0;
  if (slide_whole("Resolution", edges, 0, kFinestResolution, longest ? fmt::format("{}", edges) : "automatic")) {
    longest = edges < kCoarsestResolution ? std::nullopt : std::optional(diagonal / edges);
  }
  help_on_hover(
      "edges of triangles across the shape; automatic: as fine as they are, and finer where a stroke needs it");
}

// A part of the side panel that can be folded, which is remembered by its name.
bool begin_part(Studio& studio, const std::string& name, const std::string& heading) {
  std::vector<std::string>& closed = studio.preferences().panels.closed;
  const bool was_open = std::find(closed.begin(), closed.end(), name) == closed.end();
  ImGui::SetNextItemOpen(was_open);
  ImGui::PushStyleColor(ImGuiCol_Header, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
  const bool is_open = ImGui::CollapsingHeader((heading + "###" + name).c_str());
  ImGui::PopStyleColor();
  if (is_open && !was_open) std::erase(closed, name);
  if (!is_open && was_open) closed.push_back(name);
  return is_open;
}

// Drags the left edge of the side panel.
void draw_edge(Studio& studio, const Gui& gui, const Area& area) {
  const ImVec2 cursor = ImGui::GetCursorScreenPos();
  const float grip = kEdge * gui.unit();
  ImGui::PushClipRect({area.left, area.top}, {area.right, area.bottom}, false);
  ImGui::SetCursorScreenPos({area.left, area.top});
  // A little shorter than the panel, so that it does not count as something to scroll to.
  ImGui::InvisibleButton("##edge", {grip, std::max(area.height() - 3 * ImGui::GetStyle().WindowPadding.y, grip)});
  if (ImGui::IsItemHovered() || ImGui::IsItemActive()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  if (ImGui::IsItemActive() && ImGui::IsMouseDragging(0, 0)) {
    const float width = (area.right - ImGui::GetIO().MousePos.x) / gui.unit();
    studio.preferences().panels.width = std::clamp(width, kMinPanelWidth, kMaxPanelWidth);
  }
  ImGui::PopClipRect();
  ImGui::SetCursorScreenPos(cursor);
}

// Draws one of the windows of the side panel. Returns the height that it would take.
template <class Content>
float draw_window(Studio& studio, const Gui& gui, const char* name, const Area& area, const Content& content) {
  ImGui::SetNextWindowPos({area.left, area.top});
  ImGui::SetNextWindowSize({area.width(), area.height()});
  constexpr int flags =
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus;
  if (ImGui::Begin(name, nullptr, flags & ~ImGuiWindowFlags_NoScrollbar)) {
    draw_edge(studio, gui, area);
    ImGui::PushItemWidth(-ImGui::GetFontSize() * 6.2F);
    content();
    ImGui::PopItemWidth();
  }
  const float height = ImGui::GetCursorPosY() + ImGui::GetStyle().WindowPadding.y;
  ImGui::End();
  return height;
}

// Of exact pins; all other tools have the radius that is set at the hand.
void draw_automatic_radius(Studio& studio) {
  ToolSettings& settings = studio.tools().settings();
  if (!has_exact_pins(settings)) return;
  bool is_auto = settings.auto_radius;
  if (ImGui::Checkbox("Automatic radius", &is_auto)) {
    studio.tools().fix_radius();
    settings.auto_radius = is_auto;
  }
  help_on_hover("Twice the median distance of a pin from the third nearest one, or twice the displacement if longer.");
}

// A triangle of a picture, in a square from -1 to 1, y downwards.
struct PictureTriangle {
  std::array<ImVec2, 3> corners;
  float shade = 0;  // from 0 to 1
  double depth = 0;
};

// A solid seen a little from the right and above, from back to front.
std::vector<PictureTriangle> picture_of(ShapeKind kind) {
  const Mesh mesh = make_shape(kind, std::max(shape_counts(kind).minimum, kVerticesOfPicture));
  const Box box = shape_box(mesh);
  const Vec3d back = normalized(Vec3d{0.5, 0.4, 1});
  const Vec3d right = normalized(cross(Vec3d{0, 1, 0}, back));
  const Vec3d up = cross(back, right);
  std::vector<PictureTriangle> picture;
  for (const Triangle& t : triangulate(mesh)) {
    const std::array<Vec3d, 3> at{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
    const Vec3d normal = normalized(cross(at[1] - at[0], at[2] - at[0]));
    if (dot(normal, back) <= 0) continue;
    PictureTriangle& drawn = picture.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d p = (at[i] - box.center()) * (2 / box.diagonal());
      drawn.corners[i] = {static_cast<float>(dot(p, right)), static_cast<float>(-dot(p, up))};
      drawn.depth += dot(p, back);
    }
    drawn.shade = static_cast<float>(0.35 + 0.65 * std::max(dot(normal, normalized(up + back)), 0.0));
  }
  std::sort(picture.begin(), picture.end(), [](const auto& a, const auto& b) { return a.depth < b.depth; });
  return picture;
}

void draw_solid(ShapeKind kind, ImVec2 center, float half) {
  static std::map<ShapeKind, std::vector<PictureTriangle>> pictures;
  if (!pictures.contains(kind)) pictures[kind] = picture_of(kind);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImDrawListFlags flags = std::exchange(list.Flags, list.Flags & ~ImDrawListFlags_AntiAliasedFill);  // no seams
  const auto place = [&](ImVec2 p) { return ImVec2{center.x + half * p.x, center.y + half * p.y}; };
  for (const PictureTriangle& t : pictures[kind]) {
    const ImU32 colour = ImGui::ColorConvertFloat4ToU32({0.88F * t.shade, 0.80F * t.shade, 0.70F * t.shade, 1});
    list.AddTriangleFilled(place(t.corners[0]), place(t.corners[1]), place(t.corners[2]), colour);
  }
  list.Flags = flags;
}

// By pictures, three in a row.
void choose_stamp(Studio& studio, float width) {
  const auto& stamp = studio.tools().placed().stamp;
  ImGui::SetNextWindowSizeConstraints({0, 0}, ImGui::GetIO().DisplaySize);  // all rows
  if (!begin_list("##stamp", stamp ? stamp->name : "none", width)) return;
  const float size = 4 * ImGui::GetFontSize();
  for (const std::string_view name : shape_names()) {
    const ShapeKind kind = shape_kind(name);
    if (static_cast<int>(kind) % 3 != 0) ImGui::SameLine();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::PushID(static_cast<int>(kind));
    if (ImGui::Selectable("##solid", stamp && stamp->name == name, 0, {size, size})) studio.tools().use_stamp(kind);
    ImGui::PopID();
    help_on_hover(std::string(name).c_str());
    draw_solid(kind, {corner.x + 0.5F * size, corner.y + 0.5F * size}, 0.55F * size);
  }
  end_list();
}

// The text, or the picture in its place, which a click takes away.
void draw_printed(Studio& studio, float width) {
  std::optional<PrintPicture>& picture = studio.tools().placed().picture;
  ImGui::SetNextItemWidth(width);
  if (!picture) {
    ImGui::InputText("##text", &studio.tools().settings().text);
    help_on_hover("the text that is printed; File > Stamp from a file takes a picture in its place");
    return;
  }
  const std::string name = picture->source.filename().string() + "##picture";
  if (ImGui::Button(name.c_str(), {width, 0})) picture.reset();
  help_on_hover("The picture that is printed: white goes to the full depth. Click to print a text again.");
}

}  // namespace

void draw_setting(std::span<const Setting> rows, std::string_view key, std::optional<float> width) {
  const Setting& row = *find_setting(rows, key);
  const auto& [least, most, is_strict] = row.range;
  if (bool* const* flag = std::get_if<bool*>(&row.value)) ImGui::Checkbox(row.label, *flag);
  if (int* const* number = std::get_if<int*>(&row.value)) {
    slide_whole(row.label, **number, static_cast<int>(least), static_cast<int>(most), fmt::format("{}", **number),
                width.value_or(-1));
  }
  if (double* const* number = std::get_if<double*>(&row.value)) {
    slide(row.label, **number, {least, most}, nullptr, {"", width.value_or(-1)});
  }
  if (const auto* const choice = std::get_if<WordChoice>(&row.value)) {
    std::vector<std::size_t> all(choice->titles.size());
    std::iota(all.begin(), all.end(), 0);
    std::size_t chosen = choice->chosen;
    const auto title = [&](std::size_t i) { return choice->titles[i]; };
    if (choose_one(row.label, chosen, all, title, width.value_or(-1))) choice->choose(chosen);
  }
  help_on_hover(row.help);
}

void draw_tool_setting(Studio& studio, std::string_view key, std::optional<float> width) {
  draw_setting(settings_of(studio.tools().settings()), key, width);
}

bool has_drag_mode(const ToolSettings& settings) {
  const ToolUse use = settings.tool->use;
  return !has_two_signs(use) && use != ToolUse::smooth && use != ToolUse::turn && use != ToolUse::mask;
}

bool has_radius(const ToolSettings& settings) {
  if (settings.tool->use == ToolUse::bend_along || settings.tool->use == ToolUse::lattice) return false;
  if (settings.tool->use == ToolUse::mask) return settings.mask_mode == MaskMode::paint;
  return settings.tool->use != ToolUse::pose || settings.pose == PoseMode::exact || settings.pose == PoseMode::brush;
}

bool has_mode(const Studio& studio) {
  const ToolUse use = studio.tools().settings().tool->use;
  return use == ToolUse::stamp || use == ToolUse::print || use == ToolUse::bend_along || use == ToolUse::lattice ||
         use == ToolUse::pose || use == ToolUse::mask;
}

void draw_mode(Studio& studio, float width) {
  const ToolUse use = studio.tools().settings().tool->use;
  if (use == ToolUse::pose) draw_tool_setting(studio, "pose", width);
  if (use == ToolUse::bend_along) draw_tool_setting(studio, "bend_length", width);
  if (use == ToolUse::lattice) draw_tool_setting(studio, "lattice_mode", width);
  if (use == ToolUse::mask) draw_tool_setting(studio, "mask_mode", width);
  if (use == ToolUse::print) draw_printed(studio, width);
  if (use != ToolUse::stamp) return;
  choose_stamp(studio, width);
  help_on_hover("which solid is pressed in; File > Stamp from a file takes any closed mesh");
}

void draw_tool_settings(Studio& studio) {
  ToolSettings& settings = studio.tools().settings();
  draw_automatic_radius(studio);
  if (blends(settings)) draw_falloff(settings.falloff);
  draw_own_settings(studio);
  if (has_drag_mode(settings)) draw_drag(studio);
  ImGui::Separator();
  draw_symmetry(studio);
  draw_remeshing(studio);
}

void draw_view_settings(Studio& studio, const Gui& gui) {
  ViewSettings& view = studio.view().settings();
  draw_look_settings(studio, gui);
  const std::vector<Setting> rows = settings_of(view);
  draw_setting(rows, "wireframe");
  ImGui::SameLine();
  draw_setting(rows, "tool");
  ImGui::SameLine();
  draw_setting(rows, "influence");
  for (const char* key : {"region", "stretch", "cut"}) draw_setting(rows, key);
  if (!view.cut) return;
  const double half = 0.5 * studio.document().shown().diagonal;
  ImGui::SameLine();
  choose_axis("cut", view.cut_normal);
  slide("Offset", view.cut_offset, {-half, half}, "distance from the middle of the shape");
  if (ImGui::Button("Flip")) {
    view.cut_normal = -view.cut_normal;
    view.cut_offset = -view.cut_offset;
  }
}

void draw_side_panel(Studio& studio, const Gui& gui, const Layout& layout, SidePanel& panel) {
  const Area& area = layout.side_panel;
  const bool has_history = studio.view().settings().history;
  const float for_history = has_history ? std::min(panel.history_height, kMinHistory * area.height()) : 0;
  const float split = area.top + std::min(panel.settings_height, area.height() - for_history);
  panel.settings_height = draw_window(studio, gui, "Settings", {area.left, area.top, area.right, split}, [&] {
    if (layout.is_compact) draw_hand_settings(studio, -1);
    if (begin_part(studio, "tool", studio.tools().settings().tool->name + ": more settings")) {
      draw_tool_settings(studio);
    }
    if (begin_part(studio, "view", "View")) draw_view_settings(studio, gui);
    if (studio.document().shown().objects.list.size() > 1 && begin_part(studio, "objects", "Objects")) {
      draw_objects(studio);
    }
    if (!studio.view().references().empty() && begin_part(studio, "references", "Reference images"))
      draw_references(studio);
  });
  if (!has_history) return;
  const float for_editor = std::min(panel.editor_height, kMaxEditorShare * (area.bottom - split));
  const float bottom = std::min(split + panel.history_height, area.bottom - for_editor);
  bool is_open = false;
  panel.history_height = draw_window(studio, gui, "History", {area.left, split, area.right, bottom}, [&] {
    is_open = begin_part(studio, "history", "History");
    if (is_open) draw_history(studio, panel.editor);
    const std::size_t entries = studio.document().shown().history.size();
    if (entries > panel.entries) ImGui::SetScrollHereY(1);
    panel.entries = entries;
  });
  const bool has_editor = is_open && studio.history().editor().entry.has_value();
  if (!has_editor) panel.editor_height = 0;
  if (!has_editor) return;
  const Area below{area.left, bottom, area.right, bottom + for_editor};
  panel.editor_height = draw_window(studio, gui, "Entry", below, [&] { draw_entry_editor(studio, panel.editor); });
}

// --- mirrors and radial symmetry -------------------------------------------------------------------------------------

namespace {

void draw_mirrors(Studio& studio) {
  ToolSettings& settings = studio.tools().settings();
  ImGui::TextDisabled("Mirror");
  bool is_on = settings.symmetry.plane.has_value();
  ImGui::BeginDisabled(!is_on);  // it keeps its place: what is below must not move under the pointer
  if (ImGui::Checkbox("In a plane of your own", &is_on)) settings.symmetry.plane.reset();
  ImGui::EndDisabled();
  const bool face = studio.tools().picking_mirror() == StudioTools::PlanePick::face;
  const bool three = studio.tools().picking_mirror() == StudioTools::PlanePick::three_points;
  if (ImGui::Button(face ? "Click on the shape..." : "Plane from a face"))
    studio.tools().pick_mirror(StudioTools::PlanePick::face);
  help_on_hover("The next click on the shape gives the plane: through that point, along the surface.");
  ImGui::SameLine();
  if (ImGui::Button(three ? "Click three points..." : "From three points"))
    studio.tools().pick_mirror(StudioTools::PlanePick::three_points);
}

void draw_center(Studio& studio) {
  Vec3d& center = studio.tools().settings().symmetry.center;
  if (ImGui::Button("Through the middle")) studio.tools().center_symmetry();
  help_on_hover("moves the mirrors x, y and z and the axis of the turns there");
  ImGui::SameLine();
  ImGui::BeginDisabled(center == Vec3d{0, 0, 0});
  if (ImGui::Button("Origin")) center = {0, 0, 0};
  ImGui::EndDisabled();
}

void draw_turns(Symmetry& symmetry) {
  const std::string times = symmetry.turns == 1 ? "off" : fmt::format("{} times", symmetry.turns);
  slide_whole("Radial", symmetry.turns, 1, kMaxTurns, times);
  help_on_hover("repeats everything about an axis");
  if (symmetry.turns < 2) return;
  choose_axis("turns", symmetry.axis);
}

}  // namespace

void draw_symmetry(Studio& studio) {
  draw_mirrors(studio);
  draw_turns(studio.tools().settings().symmetry);
  draw_center(studio);
}

// --- the shape of a tool's blend, as a number and as a curve ---------------------------------------------------------

namespace {

constexpr std::size_t kPlaces = 65;
constexpr float kLines = 3;  // of text: the height of the curve

}  // namespace

void draw_falloff(int falloff) {
  std::array<float, kPlaces> weights{};
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const double s = static_cast<double>(i) / (kPlaces - 1);
    weights[i] = static_cast<float>(blend_weight(s, Thresholds<double>{0, 1, falloff}).value);
  }
  ImGui::PushStyleColor(ImGuiCol_PlotLines, ImGui::GetStyleColorVec4(ImGuiCol_Text));
  ImGui::PlotLines("##curve", weights.data(), static_cast<int>(kPlaces), 0, nullptr, 0, 1,
                   {ImGui::GetContentRegionAvail().x, kLines * ImGui::GetTextLineHeight()});
  help_on_hover("how the motion fades from the inner region, at the left of the curve, to the outer one");
  ImGui::PopStyleColor();
}

bool choose_falloff(int& falloff) {
  const bool is_changed = slide_whole("Falloff", falloff, kMinFalloff, kGreatestFalloff, fmt::format("{}", falloff));
  draw_falloff(falloff);
  return is_changed;
}

}  // namespace knead::studio
