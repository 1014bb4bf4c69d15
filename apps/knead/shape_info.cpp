#include "shape_info.h"

#include <fmt/format.h>

namespace knead::command {
namespace {

using Json = nlohmann::ordered_json;

bool has_volume(const Measures& measures) { return measures.closed() && measures.oriented(); }

std::vector<std::string> attribute_names(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const Attribute& attribute : mesh.attributes) names.push_back(attribute.name);
  return names;
}

Json to_json(const Vec3d& v) { return Json::array({v.x, v.y, v.z}); }

std::string to_text(const Vec3d& v) { return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z); }

const char* yes_or_no(bool value) { return value ? "yes" : "no"; }

}  // namespace

ShapeInfo read_info(const std::string& shape) {
  ShapeInfo info;
  info.file = read_shape(shape);
  info.measures = measure(info.file.mesh);
  info.notes = info.file.notes;
  for (std::string& note : describe_oddities(info.measures)) info.notes.push_back(std::move(note));
  return info;
}

Json to_json(const ShapeInfo& info) {
  const Measures& m = info.measures;
  Json json;
  json["format"] = info.file.format;
  json["vertices"] = m.vertices;
  json["faces"] = m.faces;
  json["triangles"] = m.triangles;
  json["closed"] = m.closed();
  json["manifold"] = m.manifold();
  json["oriented"] = m.oriented();
  json["components"] = m.components;
  json["boundary_loops"] = m.boundary_loops;
  json["euler"] = m.euler;
  json["volume"] = has_volume(m) ? Json(m.volume) : Json(nullptr);
  json["area"] = m.area;
  json["box_min"] = to_json(m.box.min);
  json["box_max"] = to_json(m.box.max);
  json["diagonal"] = m.box.diagonal();
  json["attributes"] = attribute_names(info.file.mesh);
  json["notes"] = info.notes;
  return json;
}

std::string dump(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

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
