// The panel on the right: how the shape is drawn, and the history as layers: what was done, by name; looking back,
// switching off, moving, renaming, changing.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "document/layers.h"
#include "panels/panels.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

// Of an entry, 0: of its text.
float row_height() { return is_touched() ? ImGui::GetFrameHeight() : 0; }

constexpr const char* kDragged = "layer";  // what is carried by drag and drop: the number of an entry

// The name that a person gave, or what the entry does.
std::string label_of(const Studio& studio, const HistoryEntry& entry) {
  const std::string words = words_of(entry.strokes, text_of(studio.preferences().unit));
  const std::string& own = entry.strokes.front().name;
  return own.empty() ? words : fmt::format("{}  ({})", own, words);
}

void draw_numbers(LayerEditor& layers) {
  for (const StrokeField& field : fields_of(layers.strokes)) {
    double value = field.value;
    std::string label = fmt::format("{}##{}", field.label, field.name);
    label[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(label[0])));
    if (!type_number(label.c_str(), value, {-1e9, 1e9}, field.help.c_str(), "%.4g")) continue;
    std::vector<SessionStroke> strokes = layers.strokes;
    set_field(strokes, field.name, value);
    set_strokes(layers, std::move(strokes));
  }
  std::optional<int> falloff = falloff_of(layers.strokes);
  if (!falloff || !choose_falloff(*falloff)) return;
  std::vector<SessionStroke> strokes = layers.strokes;
  set_falloff(strokes, *falloff);
  set_strokes(layers, std::move(strokes));
}

void draw_text(LayerEditor& layers) {
  if (!ImGui::TreeNode("As text")) return;
  const ImVec2 size{-1, ImGui::GetTextLineHeight() * 7};
  std::string text = layers.text;
  if (ImGui::InputTextMultiline("##lines", &text, size)) set_text(layers, std::move(text));
  ImGui::TreePop();
}

// A bar with the strength that is being made, until the shape has it.
void draw_making(const Studio& studio, HistoryEditor& editor, std::size_t entry) {
  if (!editor.made) return;
  const bool is_busy = studio.document().worker().is_busy();
  const double now = 100 * strength_of(studio.document().shown().history[entry]->strokes);
  if (!is_busy || std::abs(now - *editor.made) < 0.5) {
    if (!editor.percent) editor.made.reset();
    return;
  }
  const std::optional<WorkStatus> work = studio.document().worker().status();
  const double fraction = work && work->fraction ? *work->fraction : 0;
  const std::string text = fmt::format("Making {:.0f}%...", *editor.made);
  ImGui::ProgressBar(static_cast<float>(fraction), {-1, 0}, text.c_str());
}

// In percent. The shape follows while the slider is dragged; the whole drag is one change.
void draw_strength(Studio& studio, HistoryEditor& editor, std::size_t entry) {
  int percent = static_cast<int>(
      std::lround(editor.percent.value_or(100 * strength_of(studio.document().shown().history[entry]->strokes))));
  const int most = static_cast<int>(std::lround(100 * kMaxStrength));
  if (slide_whole("Strength", percent, 0, most, fmt::format("{}%", percent))) {
    editor.percent = editor.made = percent;
    studio.history().drag(with_strength(entry, percent / 100.0));
  }
  help_on_hover("how much of it is applied; above 100% it continues beyond its end");
  if (ImGui::IsItemDeactivatedAfterEdit()) studio.history().end_drag(true);
  if (!ImGui::IsItemActive()) editor.percent.reset();
  draw_making(studio, editor, entry);
}

// Buttons that change where an entry stands. They deselect nothing: the selection follows.
void draw_order(Studio& studio, std::size_t entry) {
  const std::size_t count = studio.document().shown().history.size();
  const auto button = [&](const char* label, bool is_possible, const LayerChange& change, const char* help) {
    ImGui::BeginDisabled(!is_possible);
    if (ImGui::Button(label)) studio.history().change(change);
    ImGui::EndDisabled();
    help_on_hover(help);
  };
  button("Up", entry > 0, moved(entry, entry == 0 ? 0 : entry - 1), "before the entry above");
  ImGui::SameLine();
  button("Down", entry + 1 < count, moved(entry, entry + 1), "after the entry below");
  ImGui::SameLine();
  button("Join", entry > 0, joined(entry), "makes one group of this entry and the one above");
  ImGui::SameLine();
  button("Split", studio.document().shown().history[entry]->strokes.size() > 1, split(entry), "into its strokes");
}

void begin_renaming(const Studio& studio, HistoryEditor& editor, std::size_t entry) {
  editor.renaming = entry;
  editor.name = name_of(studio.document().shown().history[entry]->strokes);
  editor.is_beginning = true;
}

}  // namespace

void draw_entry_editor(Studio& studio, HistoryEditor& editor) {
  LayerEditor& layers = studio.history().editor();
  const std::size_t entry = *layers.entry;
  if (entry >= studio.document().shown().history.size()) return;  // a frame
  ImGui::BeginDisabled(editor.is_beginning);                      // the second click of two is for the name
  ImGui::TextUnformatted(label_of(studio, *studio.document().shown().history[entry]).c_str());
  draw_strength(studio, editor, entry);
  draw_order(studio, entry);
  draw_numbers(layers);
  draw_text(layers);
  if (!layers.problem.empty()) text_in_colour(kWarning, layers.problem);
  const bool changed = layers.strokes != studio.document().shown().history[entry]->strokes;
  ImGui::BeginDisabled(!changed || !layers.problem.empty());
  if (ImGui::Button("Apply and redo the rest")) studio.history().change(replaced(entry, layers.strokes));
  ImGui::EndDisabled();
  if (ImGui::Button("Show")) studio.history().look_at(entry + 1);
  ImGui::SameLine();
  if (ImGui::Button("Rename")) begin_renaming(studio, editor, entry);
  ImGui::SameLine();
  if (ImGui::Button("Remove")) {
    studio.history().change(removed(entry));
    studio.history().select(std::nullopt);
  }
  ImGui::EndDisabled();
}

namespace {

void draw_past_banner(Studio& studio) {
  const DocumentState& shown = studio.document().shown();
  if (!shown.looked_at || *shown.looked_at == shown.history.size()) return;  // a frame
  text_in_colour(kWarning,
                 fmt::format("This is the shape after {} of {} entries.", *shown.looked_at, shown.history.size()));
  if (ImGui::Button("Back to the present")) studio.history().look_at(std::nullopt);
}

// The field in which the name is typed; Enter or a click elsewhere ends it, Escape gives it up.
void draw_renaming(Studio& studio, HistoryEditor& editor, std::size_t entry) {
  ImGui::SetNextItemWidth(-1);
  if (std::exchange(editor.is_beginning, false)) ImGui::SetKeyboardFocusHere();
  const bool is_entered = ImGui::InputText("##name", &editor.name,
                                           ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  if (!is_entered && !ImGui::IsItemDeactivated()) return;
  const bool is_given_up = !is_entered && escape_pressed();
  editor.renaming.reset();
  if (!is_given_up) studio.history().change(renamed(entry, editor.name));
}

void carry(Studio& studio, std::size_t entry) {
  if (ImGui::BeginDragDropSource()) {
    ImGui::SetDragDropPayload(kDragged, &entry, sizeof entry);
    ImGui::TextUnformatted(name_of(studio.document().shown().history[entry]->strokes).c_str());
    ImGui::EndDragDropSource();
  }
  if (!ImGui::BeginDragDropTarget()) return;
  if (const ImGuiPayload* const payload = ImGui::AcceptDragDropPayload(kDragged)) {
    studio.history().change(moved(*static_cast<const std::size_t*>(payload->Data), entry));
  }
  ImGui::EndDragDropTarget();
}

void draw_name(Studio& studio, HistoryEditor& editor, std::size_t entry) {
  const HistoryEntry& shown = *studio.document().shown().history[entry];
  const float height = ImGui::GetFrameHeight();
  if (const StudioTool* const tool = tool_of(shown.strokes)) {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    draw_icon(*tool, {corner.x + 0.5F * height, corner.y + 0.5F * height}, 0.36F * height);
  }
  ImGui::Dummy({height, height});
  ImGui::SameLine(0, 0.3F * height);
  ImGui::AlignTextToFramePadding();
  if (is_touched()) ImGui::GetCurrentWindow()->DC.CurrLineTextBaseOffset = 0;  // the row has the frame's height
  const std::string label = label_of(studio, shown) + "###name";
  const bool is_open = studio.history().editor().entry == entry;
  const bool is_lit = is_open || studio.document().shown().looked_at == entry + 1;
  const double strength = strength_of(shown.strokes);
  const float room = strength == 1 ? 0.0F : ImGui::GetFontSize() * 2.6F;
  const ImVec2 size{std::max(ImGui::GetContentRegionAvail().x - room, 1.0F), row_height()};
  if (ImGui::Selectable(label.c_str(), is_lit, 0, size)) {
    editor.clicked = entry;
    studio.history().select(is_open ? std::nullopt : std::optional(entry));
  }
  help_on_hover(fmt::format("Entry {}: {}, {:.0f} ms. Double click to rename, drag to move.", entry + 1,
                            description_of(shown.strokes), 1000 * shown.seconds)
                    .c_str());
  carry(studio, entry);
  if (strength == 1) return;
  ImGui::SameLine();
  ImGui::TextDisabled("%.0f%%", 100 * strength);
}

void draw_entry(Studio& studio, HistoryEditor& editor, std::size_t entry) {
  ImGui::PushID(static_cast<int>(entry));
  bool is_on = !is_off(studio.document().shown().history[entry]->strokes);
  if (ImGui::Checkbox("##on", &is_on)) studio.history().change(switched(entry, !is_on));
  help_on_hover("switched on or off");
  ImGui::SameLine();
  if (editor.renaming == entry) {
    draw_renaming(studio, editor, entry);
  } else {
    draw_name(studio, editor, entry);
  }
  ImGui::PopID();
}

}  // namespace

void draw_history(Studio& studio, HistoryEditor& editor) {
  const DocumentState& shown = studio.document().shown();
  if (shown.opened == 0) return;
  // The second click of two is for the entry of the first, wherever that is by then, and for nothing else.
  const bool renames = ImGui::IsMouseDoubleClicked(0) && editor.clicked && *editor.clicked < shown.history.size();
  const std::optional<std::size_t> entry_clicked = editor.clicked;
  if (ImGui::IsMouseClicked(0)) editor.clicked.reset();
  ImGui::BeginDisabled(renames);
  draw_past_banner(studio);
  if (!shown.history.empty() || !editor.search.empty()) {
    ImGui::SetNextItemWidth(-1);
    ImGui::InputTextWithHint("##search", "Search", &editor.search);
  }
  if (ImGui::Selectable("As it was opened", shown.looked_at == 0U, 0, {0, row_height()})) {
    studio.history().look_at(std::size_t{0});
    studio.history().select(std::nullopt);
  }
  // A change without a worker is made at once, so the number of entries is asked for again.
  for (std::size_t i = 0; i < studio.document().shown().history.size(); ++i) {
    if (is_found(studio.document().shown().history[i]->strokes, editor.search)) draw_entry(studio, editor, i);
  }
  for (const auto& entry : studio.document().shown().redoable) {
    ImGui::TextDisabled("%s", fmt::format("     {}", label_of(studio, *entry)).c_str());
  }
  ImGui::EndDisabled();
  if (renames) begin_renaming(studio, editor, *entry_clicked);
}

// --- several objects -------------------------------------------------------------------------------------------------

void draw_objects(Studio& studio) {
  const DocumentObjects& objects = studio.document().shown().objects;
  std::optional<std::size_t> switched_object;
  std::optional<std::size_t> clicked;
  std::optional<std::size_t> removed;
  for (std::size_t i = 0; i < objects.list.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    bool is_visible = objects.list[i].is_visible;
    if (ImGui::Checkbox("##visible", &is_visible)) switched_object = i;
    help_on_hover("shown or hidden; the strokes move it in both cases");
    ImGui::SameLine();
    const float room = ImGui::GetContentRegionAvail().x - ImGui::GetFrameHeightWithSpacing();
    if (ImGui::Selectable((objects.list[i].name + "###name").c_str(), objects.active == i, 0, {room, 0})) clicked = i;
    help_on_hover("Click: the pointer meets this one only, also behind others. Click again: it meets all.");
    ImGui::SameLine();
    if (small_button("x")) removed = i;
    help_on_hover("removes it; the strokes stay and move the others");
    ImGui::PopID();
  }
  // Without a worker the list changes at once.
  if (switched_object) {
    studio.document().show_object(*switched_object, !objects.list[*switched_object].is_visible);
  } else if (clicked) {
    studio.document().make_active(objects.active == clicked ? std::nullopt : clicked);
  } else if (removed) {
    studio.remove_object(*removed);
  }
}

// --- how the shape is drawn: material, relief, background, perspective -----------------------------------------------

namespace {

// All of them side by side, as pictures.
void draw_matcaps(Look& look, const Gui& gui) {
  const float margin = 0.25F * ImGui::GetFontSize();
  const float size = ImGui::GetFontSize() + 2 * margin;
  for (const render::Matcap matcap : render::all_matcaps()) {
    const std::string title(title_of(matcap));
    if (matcap != render::all_matcaps().front()) ImGui::SameLine(0, margin);
    const ImVec2 at = ImGui::GetCursorPos();
    if (ImGui::Selectable(("##" + title).c_str(), matcap == look.matcap, 0, {size, size})) look.matcap = matcap;
    help_on_hover(title.c_str());
    ImGui::SameLine(at.x + margin);
    ImGui::SetCursorPosY(at.y + margin);
    gui.draw_ball(matcap);
    ImGui::SameLine(at.x);
    ImGui::SetCursorPosY(at.y);
    ImGui::Dummy({size, size});
  }
}

void draw_background(std::string& background) {
  constexpr std::array<const char*, 3> names{"gradient", "light", "dark"};
  constexpr std::array<const char*, 3> titles{"Gradient", "Light", "Dark"};
  const std::optional<render::Color> own = render::color_from(background);
  const auto* const known = std::find(names.begin(), names.end(), background);
  if (begin_list("Background", own ? "Colour" : titles[static_cast<std::size_t>(known - names.begin())])) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (ImGui::Selectable(titles[i], background == names[i])) background = names[i];
    }
    if (ImGui::Selectable("Colour", own.has_value()) && !own) {
      background = text_of(render::background_named(background)->bottom);
    }
    end_list();
  }
  if (!own) return;
  std::array<float, 3> channels{own->red, own->green, own->blue};
  if (ImGui::ColorEdit3("##background", channels.data(), ImGuiColorEditFlags_DisplayHex)) {
    background = text_of(render::Color{channels[0], channels[1], channels[2], 1});
  }
}

void draw_projection(View& view) {
  bool is_perspective = view.projection == render::Projection::perspective;
  if (ImGui::Checkbox("Perspective", &is_perspective)) view = toggled_projection(view);
  if (!is_perspective) return;
  slide("Field of view", view.field_of_view_deg, {kSmallestFieldDeg, kLargestFieldDeg}, "degrees from bottom to top");
  view.field_of_view_deg = std::clamp(view.field_of_view_deg, kSmallestFieldDeg, kLargestFieldDeg);
}

}  // namespace

void draw_look_settings(Studio& studio, const Gui& gui) {
  Look& look = studio.view().settings().look;
  const std::vector<Setting> rows = settings_of(studio.view().settings());
  draw_setting(rows, "shading");
  if (look.material == render::Material::matcap) draw_matcaps(look, gui);
  draw_setting(rows, "cavity");
  ImGui::SameLine();
  draw_setting(rows, "occlusion");
  draw_background(look.background);
  draw_projection(studio.view().navigation().view);
}

// --- the pictures behind the shape -----------------------------------------------------------------------------------

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
  ImGui::TextUnformatted(reference.file.filename().string().c_str());
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
  std::vector<Reference>& references = studio.view().references();
  ImGui::Checkbox("Show", &studio.view().settings().references);
  std::optional<std::size_t> removed;
  for (std::size_t i = 0; i < references.size(); ++i) {
    ImGui::Separator();
    ImGui::PushID(static_cast<int>(i));
    if (!draw_reference(references[i], studio.view().navigation().view.up, studio.document().shown().diagonal))
      removed = i;
    ImGui::PopID();
  }
  if (removed) references.erase(references.begin() + static_cast<std::ptrdiff_t>(*removed));
}

// --- preferences of the pointer: unit of lengths, pressure of a pen, colours of the cursor ---------------------------

namespace {

template <class T, std::size_t N>
bool choose_in_menu(const char* label, T& value, const std::array<const char*, N>& names) {
  bool changed = false;
  if (!ImGui::BeginMenu(label)) return false;
  for (std::size_t i = 0; i < N; ++i) {
    const T each = static_cast<T>(i);
    if (!ImGui::MenuItem(names[i], nullptr, value == each)) continue;
    changed = value != each;
    value = each;
  }
  ImGui::EndMenu();
  return changed;
}

bool choose_color(const char* label, render::Color& color) {
  std::array<float, 3> parts{color.red, color.green, color.blue};
  const bool changed = ImGui::ColorEdit3(label, parts.data(), ImGuiColorEditFlags_NoInputs);
  if (changed) color = {parts[0], parts[1], parts[2], 1};
  return changed;
}

}  // namespace

bool draw_pointer_preferences(Preferences& preferences) {
  bool changed =
      choose_in_menu("Unit of the file", preferences.unit, std::array{"None", "Millimetres", "Centimetres", "Metres"});
  changed = choose_in_menu("Pen pressure", preferences.pressure, std::array{"None", "Radius", "Depth"}) || changed;
  if (ImGui::BeginMenu("Cursor colours")) {
    changed = choose_color("Outer ring", preferences.outer_ring) || changed;
    changed = choose_color("Inner ring", preferences.inner_ring) || changed;
    if (ImGui::MenuItem("Defaults")) {
      preferences.outer_ring = Preferences{}.outer_ring;
      preferences.inner_ring = Preferences{}.inner_ring;
      changed = true;
    }
    ImGui::EndMenu();
  }
  return changed;
}

}  // namespace knead::studio
