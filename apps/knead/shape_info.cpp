#include "shape_info.h"

#include <fmt/format.h>

namespace knead::command {
namespace {

bool has_volume(const Measures& measures) { return measures.closed() && measures.oriented(); }

std::vector<std::string> attribute_names(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const Attribute& attribute : mesh.attributes) names.push_back(attribute.name);
  return names;
}

Json to_json(const Vec3d& v) { return std::vector<Json>{v.x, v.y, v.z}; }

std::string to_text(const Vec3d& v) { return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z); }

const char* yes_or_no(bool value) { return value ? "yes" : "no"; }

}  // namespace

ShapeInfo read_info(const std::string& shape, const StreamFormat& format) {
  ShapeInfo info;
  info.file = read_shape_or_stream(shape, format);
  info.measures = measure(info.file.mesh);
  info.notes = info.file.notes;
  for (std::string& note : describe_oddities(info.measures)) info.notes.push_back(std::move(note));
  return info;
}

Json to_json(const ShapeInfo& info) {
  const Measures& m = info.measures;
  Json json;
  json.set("format", info.file.format);
  json.set("vertices", m.vertices);
  json.set("faces", m.faces);
  json.set("triangles", m.triangles);
  json.set("closed", m.closed());
  json.set("manifold", m.manifold());
  json.set("oriented", m.oriented());
  json.set("components", m.components);
  json.set("boundary_loops", m.boundary_loops);
  json.set("euler", m.euler);
  json.set("volume", has_volume(m) ? Json(m.volume) : Json(nullptr));
  json.set("area", m.area);
  json.set("box_min", to_json(m.box.min));
  json.set("box_max", to_json(m.box.max));
  json.set("diagonal", m.box.diagonal());
  json.set("attributes", attribute_names(info.file.mesh));
  json.set("notes", info.notes);
  return json;
}

std::string table_of(const ShapeInfo& info) {
  const Measures& m = info.measures;
  std::string text = row("format", info.file.format);
  text += row("vertices", fmt::format("{}", m.vertices));
  text += row("faces", fmt::format("{}", m.faces));
  text += row("triangles", fmt::format("{}", m.triangles));
  text += row("closed", yes_or_no(m.closed()));
  text += row("manifold", yes_or_no(m.manifold()));
  text += row("oriented", yes_or_no(m.oriented()));
  text += row("components", fmt::format("{}", m.components));
  text += row("boundary loops", fmt::format("{}", m.boundary_loops));
  text += row("euler", fmt::format("{}", m.euler));
  text += row("volume", has_volume(m) ? fmt::format("{:.6g}", m.volume) : "- (not closed and oriented)");
  text += row("area", fmt::format("{:.6g}", m.area));
  text += row("box min", to_text(m.box.min));
  text += row("box max", to_text(m.box.max));
  text += row("diagonal", fmt::format("{:.6g}", m.box.diagonal()));
  return text + row("attributes", fmt::format("{}", fmt::join(attribute_names(info.file.mesh), ", ")));
}

std::string table_of_notes(const ShapeInfo& info) {
  std::string text;
  for (const std::string& note : info.notes) text += row("note", note);
  return text;
}

std::string row(std::string_view name, std::string_view value) { return fmt::format("{:<22}{}\n", name, value); }

}  // namespace knead::command
