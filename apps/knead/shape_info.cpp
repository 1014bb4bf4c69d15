#include "shape_info.h"

#include <fmt/format.h>

namespace knead::command {
namespace {

std::string to_text(const Vec3d& v) { return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z); }

const char* yes_or_no(bool value) { return value ? "yes" : "no"; }

std::string rows_of(const Box& box, const std::vector<std::string>& attributes) {
  std::string text = row("box min", to_text(box.min));
  text += row("box max", to_text(box.max));
  text += row("diagonal", fmt::format("{:.6g}", box.diagonal()));
  return text + row("attributes", fmt::format("{}", fmt::join(attributes, ", ")));
}

}  // namespace

std::string table_of(const ShapeInfo& info) {
  const Measures& m = info.measures;
  std::string text = row("format", info.format);
  text += row("vertices", fmt::format("{}", m.vertices));
  text += row("faces", fmt::format("{}", m.faces));
  text += row("triangles", fmt::format("{}", m.triangles));
  text += row("closed", yes_or_no(m.closed()));
  text += row("manifold", yes_or_no(m.manifold()));
  text += row("oriented", yes_or_no(m.oriented()));
  text += row("components", fmt::format("{}", m.components));
  text += row("boundary loops", fmt::format("{}", m.boundary_loops));
  text += row("euler", fmt::format("{}", m.euler));
  text += row("volume", m.closed() && m.oriented() ? fmt::format("{:.6g}", m.volume) : "- (not closed and oriented)");
  text += row("area", fmt::format("{:.6g}", m.area));
  return text + rows_of(m.box, info.attributes);
}

std::string table_of(const ShapeSummary& summary) {
  std::string text = row("format", summary.format);
  text += row("vertices", fmt::format("{}", summary.vertices));
  text += row("faces", fmt::format("{}", summary.faces));
  text += row("triangles", fmt::format("{}", summary.triangles));
  return text + rows_of(summary.box, summary.attributes);
}

std::string table_of_notes(std::span<const std::string> notes) {
  std::string text;
  for (const std::string& note : notes) text += row("note", note);
  return text;
}

std::string row(std::string_view name, std::string_view value) { return fmt::format("{:<22}{}\n", name, value); }

}  // namespace knead::command
