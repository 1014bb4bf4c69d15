// Strokes and session files.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <filesystem>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/session.h"
#include "module.h"
#include "work.h"

namespace knead::python {
namespace {

// The type of a key's value, as a stub names it.
struct TypeName {
  std::string operator()(const double*) const { return "float"; }
  std::string operator()(const std::optional<double>*) const { return "float"; }
  std::string operator()(const AutoNumber&) const { return "float | Literal['auto']"; }
  std::string operator()(const int*) const { return "int"; }
  std::string operator()(const Vec3d*) const { return "Vector"; }
  std::string operator()(const std::optional<Vec3d>*) const { return "Vector"; }
  std::string operator()(const std::vector<Vec3d>*) const { return "Points3"; }
  std::string operator()(const std::vector<std::vector<Vec3d>>*) const { return "Sequence[Points3]"; }
  std::string operator()(const std::vector<std::uint32_t>*) const { return "Sequence[int]"; }
  std::string operator()(const std::vector<PaintSample>*) const { return "Sequence[Mapping[str, Vector]]"; }
  std::string operator()(const std::vector<std::optional<PinRotation>>*) const {
    return "Sequence[Mapping[str, Any] | None]";
  }
  std::string operator()(const std::vector<VertexRange>*) const { return "Sequence[int | Sequence[int]]"; }
  std::string operator()(const std::vector<double>*) const { return "Sequence[float]"; }
  std::string operator()(const Mat3d*) const { return "Points3"; }
  std::string operator()(const std::vector<PoseItem>*) const { return "Sequence[Mapping[str, Any]]"; }
  std::string operator()(const std::vector<PoseStiffness>*) const { return "Sequence[Mapping[str, Any]]"; }
  std::string operator()(const bool*) const { return "bool"; }
  std::string operator()(const HandlesMotion*) const { return "Mapping[str, Any]"; }
  std::string operator()(const std::array<int, 3>*) const { return "Sequence[int]"; }
  std::string operator()(const SharedVectors*) const { return "str"; }
  std::string operator()(const SharedNumbers*) const { return "str"; }
  std::string operator()(const std::string*) const { return "str"; }
  std::string operator()(const Choice& choice) const {
    std::string words;
    for (const std::string_view word : choice.words) {
      words += (words.empty() ? "'" : ", '") + std::string(word) + "'";
    }
    return "Literal[" + words + "]";
  }
};

std::string type_of(const StrokeKey& key) {
  return std::visit(TypeName{}, key.value) + (key.quantity == Quantity::wide_falloff ? " | Literal['wide']" : "");
}

// Whether a line that has these two keys may lack the key.
bool may_lack(const Tool& tool, std::string_view name, std::string_view first, std::string_view second) {
  Stroke stroke = tool.start;
  try {
    tool.prepare(stroke, [&](std::string_view key) { return key == first || key == second; });
  } catch (const InvalidInput&) {
    return false;
  }
  const std::vector<StrokeKey> keys = tool.keys(stroke);
  return std::ranges::any_of(keys, [&](const StrokeKey& key) {
    return key.name == name && (key.presence != Presence::required || !applies(key));
  });
}

// Whether a line needs the key, whichever two others it has: they may take its place.
bool is_required(const Tool& tool, std::string_view name) {
  Stroke start = tool.start;
  const std::vector<StrokeKey> keys = tool.keys(start);
  for (const StrokeKey& first : keys) {
    for (const StrokeKey& second : keys) {
      if (first.name != name && second.name != name && may_lack(tool, name, first.name, second.name)) return false;
    }
  }
  return std::ranges::none_of(keys, [&](const StrokeKey& key) {
    return key.name == name && (key.presence != Presence::required || !applies(key));
  });
}

// Each tool: its name, whether it is an event, and of each key its name, whether it is required, its help and its type.
py::list describe_tools() {
  py::list result;
  for (const Tool* tool : tools()) {
    Stroke start = tool->start;
    py::list keys;
    for (const StrokeKey& key : tool->keys(start)) {
      keys.append(
          py::make_tuple(std::string(key.name), is_required(*tool, key.name), std::string(key.help), type_of(key)));
    }
    result.append(py::make_tuple(std::string(tool->name), tool->is_event, keys));
  }
  return result;
}

// The line, and the remesh event before it, belong to the session.
bool is_same(const SessionStroke& a, const SessionStroke& b) {
  return a.stroke == b.stroke && a.name == b.name && a.off == b.off && a.strength == b.strength &&
         a.duration == b.duration && a.mirror == b.mirror;
}

// The settings of a remesh event before the strokes; empty: none.
std::string remesh_of(const SessionStroke& stroke) { return stroke.remesh ? remesh_line(stroke.remesh) : ""; }

SessionStroke with_remesh(SessionStroke stroke, const std::string& line) {
  stroke.remesh.reset();
  if (line.empty()) return stroke;
  // The reader gives the settings of the event to the stroke after it.
  const Session read = parse_session("{\"knead\": 1}\n" + line + "\n" + stroke_line(stroke), "remesh");
  stroke.remesh = read.strokes.front().remesh;
  return stroke;
}

// Strokes without a line of a file get the one that they would have in it.
Session session_of(std::vector<SessionStroke> strokes, const std::string& name, std::vector<Parameter> parameters) {
  Session session;
  session.parameters = std::move(parameters);
  session.name = name.empty() ? "session" : name;
  for (std::size_t i = 0; i < strokes.size(); ++i) strokes[i].line = i + 2;
  session.strokes = std::move(strokes);
  return session;
}

void write_session(const Session& session, const std::filesystem::path& path) {
  const std::string text = serialize_session(session);
  const py::gil_scoped_release released;
  write_file_atomically(path, text);
}

}  // namespace

void add_strokes(py::module_& module) {
  py::class_<Parameter>(module, "Parameter")
      .def_readonly("name", &Parameter::name)
      .def_readonly("value", &Parameter::value)
      .def_readonly("least", &Parameter::least)
      .def_readonly("greatest", &Parameter::greatest);
  const py::class_<Wall> wall(module, "Wall");  // a name for Session.walls; JSON has the rest
  py::class_<SessionStroke>(module, "Stroke")
      .def(py::init([](const std::string& json, const std::string& name, const std::vector<Parameter>& parameters) {
             return parse_stroke(json, name, parameters);
           }),
           py::arg("json"), py::arg("name"), py::arg("parameters") = std::vector<Parameter>{})
      .def_property_readonly("tool", [](const SessionStroke& s) { return std::string(tool_of(s.stroke).name); })
      .def("line", [](const SessionStroke& s) { return stroke_line(s); })
      .def("values", &stroke_values)
      .def("remesh", &remesh_of)
      .def("with_remesh", &with_remesh)
      .def("__eq__", &is_same);
  py::class_<Session>(module, "Session")
      .def(py::init(&session_of), py::arg("strokes"), py::arg("name"), py::arg("parameters") = std::vector<Parameter>{})
      .def_readonly("name", &Session::name)
      .def_readwrite("mesh", &Session::mesh)
      .def_readwrite("note", &Session::note)
      .def_readonly("strokes", &Session::strokes)
      .def_readonly("parameters", &Session::parameters)
      .def_readwrite("walls", &Session::walls)
      .def("with_values", &with_values)
      .def_readonly("warnings", &Session::warnings)
      .def("text", &serialize_session)
      .def("write", &write_session);
  module.def("read_session", &read_session);
  module.def("parse_session", &parse_session);
  module.def("tools", &describe_tools);
}

}  // namespace knead::python
