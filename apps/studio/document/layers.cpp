#include "document/layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "knead/error.h"

namespace knead::studio {

namespace {

// What Studio calls the tool of a stroke.
std::string title_of(const Stroke& stroke) {
  std::string word = tool_name(stroke);
  if (const auto* implicit = std::get_if<ImplicitStroke>(&stroke)) {
    word = implicit->region == ImplicitRegion::capsule ? "capsule" : "ball";
  }
  if (const auto* points = std::get_if<PointsStroke>(&stroke); points != nullptr && points->points.empty()) {
    word = "curve";
  }
  if (const StudioTool* const tool = studio_tool(word)) return tool->name;
  word[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(word[0])));
  return word;
}

std::string lines_of(const std::vector<SessionStroke>& strokes) {
  std::string text;
  for (const SessionStroke& stroke : strokes) text += stroke_line(stroke) + "\n";
  return text;
}

// The strokes of lines as typed, remeshed as those before were.
std::vector<SessionStroke> strokes_of_lines(const std::string& text, const std::optional<RemeshSettings>& remesh) {
  Session session = parse_session(header_line({}, {}) + "\n" + text, "history");
  for (SessionStroke& stroke : session.strokes) stroke.remesh = remesh;
  if (session.strokes.empty()) throw InvalidInput("no stroke is left; use \"Remove\" instead");
  return session.strokes;
}

// A change of the strokes of one entry.
template <class Change>
LayerChange change_of(std::size_t entry, Change change) {
  return [entry, change = std::move(change)](Layers& layers) {
    if (entry < layers.size()) change(layers[entry]);
  };
}

void give_name(std::vector<SessionStroke>& strokes, const std::string& name) {
  for (SessionStroke& stroke : strokes) stroke.name = name;
}

Layers::iterator at(Layers& layers, std::size_t entry) { return layers.begin() + static_cast<std::ptrdiff_t>(entry); }

}  // namespace

std::string name_of(std::span<const SessionStroke> strokes) {
  if (strokes.empty()) return "Nothing";
  const std::string& own = strokes.front().name;
  return own.empty() ? title_of(strokes.front().stroke) : own;
}

std::string description_of(std::span<const SessionStroke> strokes) {
  if (strokes.empty()) return "nothing";
  const Stroke& first = strokes.front().stroke;
  const std::string name = title_of(first);
  std::string text = strokes.size() == 1 ? name : fmt::format("{} x {}", strokes.size(), name);
  if (const auto* implicit = std::get_if<ImplicitStroke>(&first)) {
    const std::size_t pieces = implicit->path.size() - 1;
    text += pieces == 1 ? ", 1 piece" : fmt::format(", {} pieces", pieces);
  } else if (const auto* paint = std::get_if<PaintStroke>(&first)) {
    text += fmt::format(", {} dabs", paint->samples.size() + paint->path.size());
  } else if (const auto* relax = std::get_if<RelaxStroke>(&first)) {
    text += fmt::format(", {} places", relax->points.size());
  }
  return text;
}

bool is_off(std::span<const SessionStroke> strokes) {
  return std::all_of(strokes.begin(), strokes.end(), [](const SessionStroke& stroke) { return stroke.off; });
}

LayerChange renamed(std::size_t entry, const std::string& name) {
  return change_of(entry, [name](std::vector<SessionStroke>& strokes) { give_name(strokes, name); });
}

LayerChange switched(std::size_t entry, bool off) {
  return change_of(entry, [off](std::vector<SessionStroke>& strokes) {
    for (SessionStroke& stroke : strokes) stroke.off = off;
  });
}

LayerChange with_strength(std::size_t entry, double strength) {
  const double kept = std::clamp(strength, 0.0, kMaxStrength);
  return change_of(entry, [kept](std::vector<SessionStroke>& strokes) { set_strength(strokes, kept); });
}

LayerChange moved(std::size_t entry, std::size_t to) {
  return [entry, to](Layers& layers) {
    if (entry >= layers.size() || to >= layers.size()) return;
    if (entry < to) std::rotate(at(layers, entry), at(layers, entry + 1), at(layers, to + 1));
    if (to < entry) std::rotate(at(layers, to), at(layers, entry), at(layers, entry + 1));
  };
}

LayerChange joined(std::size_t entry) {
  return [entry](Layers& layers) {
    if (entry == 0 || entry >= layers.size()) return;
    std::vector<SessionStroke>& before = layers[entry - 1];
    const std::string name = name_of(before);
    before.insert(before.end(), layers[entry].begin(), layers[entry].end());
    give_name(before, name);
    layers.erase(at(layers, entry));
  };
}

LayerChange split(std::size_t entry) {
  return [entry](Layers& layers) {
    if (entry >= layers.size() || layers[entry].size() < 2) return;
    const std::vector<SessionStroke> strokes = layers[entry];
    layers.erase(at(layers, entry));
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      SessionStroke own = strokes[i];
      own.name = fmt::format("{} {}", name_of({&own, 1}), i + 1);
      layers.insert(at(layers, entry + i), {std::move(own)});
    }
  };
}

LayerChange removed(std::size_t entry) { return replaced(entry, {}); }

LayerChange replaced(std::size_t entry, std::vector<SessionStroke> strokes) {
  return change_of(entry, [strokes = std::move(strokes)](std::vector<SessionStroke>& old) { old = strokes; });
}

void select(LayerEditor& editor, const DocumentState& shown, std::optional<std::size_t> entry) {
  editor = {};
  if (!entry || *entry >= shown.history.size()) return;
  editor.entry = entry;
  editor.source = shown.history[*entry];
  editor.entries = shown.history.size();
  set_strokes(editor, editor.source->strokes);
}

void follow(LayerEditor& editor, const DocumentState& shown) {
  if (!editor.entry) return;
  const auto& history = shown.history;
  if (*editor.entry < history.size() && history[*editor.entry] == editor.source) return;
  const auto is_it = [&](const auto& entry) {
    return entry == editor.source || entry->strokes == editor.source->strokes;
  };
  const bool is_as_long = history.size() == editor.entries;
  editor.entries = history.size();
  if (*editor.entry < history.size() && is_it(history[*editor.entry])) {
    editor.source = history[*editor.entry];
    return;
  }
  const auto found = std::find_if(history.begin(), history.end(), is_it);
  if (found != history.end()) return select(editor, shown, static_cast<std::size_t>(found - history.begin()));
  select(editor, shown, is_as_long ? editor.entry : std::nullopt);
}

void set_strokes(LayerEditor& editor, std::vector<SessionStroke> strokes) {
  editor.strokes = std::move(strokes);
  editor.paths = paths_of(editor.strokes);
  editor.text = lines_of(editor.strokes);
  editor.problem.clear();
}

void set_text(LayerEditor& editor, std::string text) {
  editor.text = std::move(text);
  try {
    editor.strokes =
        strokes_of_lines(editor.text, editor.source ? editor.source->strokes.front().remesh : std::nullopt);
    editor.paths = paths_of(editor.strokes);
    editor.problem.clear();
  } catch (const InvalidInput& error) {
    editor.problem = error.what();
  }
}

}  // namespace knead::studio
