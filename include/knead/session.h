// The session file `.knead`: JSON Lines, the first line a header, every further line an event.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io.h"
#include "knead/remesh.h"
#include "knead/stroke.h"

namespace knead {

// The greatest strength of a stroke.
inline constexpr double kMaxStrength = 1.5;

// A named number of a session. Strokes use it as "$name".
struct Parameter {
  std::string name;                  // letters, digits and underscores; does not begin with a digit
  double value = 0;                  // finite, and within the bounds
  std::optional<double> least{};     // the key "min"
  std::optional<double> greatest{};  // the key "max"

  friend bool operator==(const Parameter&, const Parameter&) = default;
};

// The values of some parameters by their names.
using ParameterValues = std::map<std::string, double>;

// A key of a stroke's line that names parameters.
struct ParameterUse {
  std::string key;
  std::string text;     // the key's value, JSON with "$name" in the place of numbers
  std::string numbers;  // the same JSON with the parameters' values

  friend bool operator==(const ParameterUse&, const ParameterUse&) = default;
};

// A patch of a volume mesh that is held, slides on its surface, moves as another patch does, or follows the strokes and
// keeps the layers of cells beside it.
struct Wall {
  std::string patch;              // its name in the mesh
  bool slides = false;            // false: it is held, or periodic
  std::optional<double> width{};  // the distance beyond which the wall has no effect on the mesh; above 0
  std::string periodic{};         // the patch that it moves as; empty: none
  bool keeps_layers = false;      // true for a wall that follows the strokes: not held, sliding or periodic

  friend bool operator==(const Wall&, const Wall&) = default;
};

// A stroke of a session, or an event that is undone like a stroke (a mask, a relax), with the part of it that is
// applied and the settings of remeshing after it.
struct SessionStroke {
  Stroke stroke;
  std::size_t line = 0;  // of the session file, from 1; 0: not from a file
  // The settings of the last remesh event before the stroke. Nothing: the mesh is not remeshed after it.
  std::optional<RemeshSettings> remesh{};
  std::string name{};  // for people; empty: none
  bool off = false;    // skipped, as if it did not exist
  // From 0 to kMaxStrength. Up to 1: only this part of the stroke's segments, as SessionPart::until cuts a stroke.
  // Above 1: prolonged() by this factor.
  double strength = 1;
  double duration = 1;  // relative to the other strokes, for frames evenly spaced in time; above 0
  Mirror mirror{};      // planes in which the stroke is mirrored; its images act at the same time. Not of events
  // Whether the stroke begins an entry of the history. Nothing: strokes_of_gestures() decides.
  std::optional<bool> new_entry{};
  // The keys that name parameters. A use whose numbers differ from those of the stroke, because the stroke was edited,
  // is ignored.
  std::vector<ParameterUse> uses{};

  friend bool operator==(const SessionStroke&, const SessionStroke&) = default;
};

class PointConstraint;

// A session: its header, and the strokes in effect.
struct Session {
  std::string name;                 // of the file, for messages
  std::optional<std::string> mesh;  // the shape it was made on, relative to the session file
  std::optional<std::string> note;
  std::vector<SessionStroke> strokes;  // in effect, in order: without undone ones
  std::vector<std::string> warnings;   // of reading, each with file and line
  std::vector<Parameter> parameters{};
  std::vector<std::string> also{};  // further shapes that it was made on, as `mesh`; strokes read the surface of all
  std::vector<Wall> walls{};
  std::shared_ptr<const PointConstraint> constraint{};  // the walls on a mesh, and its cells: set by on_walls()

  friend bool operator==(const Session&, const Session&) = default;
};

// Returns whether a stroke can move anything: it is not off, and its strength is not 0.
bool is_applied(const SessionStroke& stroke);

// Returns whether a stroke has the default values of all keys that are not its tool's own.
bool is_plain(const SessionStroke& stroke);

// Returns the segments of a stroke that reads no surface, as far as its strength applies them; none if it is off.
// Throws InvalidInput as flow_of(stroke.stroke, stroke.mirror).
Flow flow_of(const SessionStroke& stroke);

// Returns the strokes, mirrored also in the given planes. A stroke that is its own image in all of them does not
// change; for a relax its points are mirrored instead; a mask does not change. Throws InvalidInput if the planes are
// not valid together with those of a stroke.
std::vector<SessionStroke> mirrored_in(std::vector<SessionStroke> strokes, const Mirror& mirror);

// How on_walls() works.
struct WallOptions {
  int threads = 0;                             // as for parallel_for
  Progress* progress = nullptr;                // counts up to its total; cancels the work, which then throws Cancelled
  std::shared_ptr<const VolumeCells> cells{};  // cells of the mesh that replay() must not invert; null: none
};

// Returns the session with its walls set up for a mesh with these patches and points. replay() of it puts points back
// onto their walls, and throws QualityLimit for cells that would be inverted and were not before.
// - A held wall becomes a mask of its points, which is added to every other mask: the points keep their bits.
// - In the plane of a sliding wall all strokes are mirrored, so that no point leaves it, if that plane is at right
//   angles to the planes before it. A mesh of two dimensions slides in its own plane.
// - Points are put back onto all other walls: planes at other angles, cylinders and spheres (to 1e-5 of their radius),
//   any other surface, periodic patches, and those that keep their layers. The session is then no flow.
// The default width of a held wall is a twentieth of the diagonal; of these other walls a tenth, but at most 3/4 of the
// greatest distance of the mesh from the wall. Throws InvalidInput for a patch that the mesh lacks, a sliding patch
// that has no faces and is not plane, a periodic patch that is no shifted copy of the other one, and masks by vertices
// beside held walls.
Session on_walls(Session session, std::span<const Patch> patches, std::span<const Vec3d> points,
                 const WallOptions& options = {});

// Returns whether replay() of this session puts points back onto walls (see on_walls()), so that it is no flow.
bool puts_points_back(const Session& session);

// Returns the session without the strokes that are off. It deforms every shape in the same way.
Session without_off(Session session);

// Returns the session with other values of some parameters, and the strokes that these values give. Throws InvalidInput
// for a parameter that the session does not have, a value that is not finite or beyond its bounds, and with file and
// line for a stroke that cannot use the value.
Session with_values(Session session, const ParameterValues& values);

// Reads a session file. Throws IoError(read) for a file that cannot be read. Throws InvalidInput with the file, the
// line, the key and the expected value for malformed text: an unknown, missing or repeated key, a wrong type, a number
// that is not finite, a value that its tool cannot use, more strokes undone than applied, an unknown event. Drops an
// incomplete last line (without a line end, and no JSON) with a warning.
Session read_session(const std::filesystem::path& path);

// Reads a session from text; `name` stands for the file in messages.
Session parse_session(std::string_view text, const std::string& name);

// Reads one stroke, as a line of a session file with these parameters holds it, or in words: "TOOL key=value
// key=value", where a value is a number, numbers between commas, such lists between semicolons, or a text. Throws
// InvalidInput as parse_session, with `name` in the place of file and line.
SessionStroke parse_stroke(std::string_view text, const std::string& name, std::span<const Parameter> parameters = {});

// Returns the text of a session file with the header and the strokes in effect, and a remesh event before every stroke
// whose settings differ from those of the stroke before. It parses back to the same strokes, bit for bit. A key names
// parameters where its stroke does, if the session has them and their values give the stroke's numbers.
std::string serialize_session(const Session& session);

// Return a line of a session file without the line end: the header, a stroke, or the remesh event that gives the next
// strokes these settings (remesh_line). Numbers have the shortest form that reads back as the same number; keys with
// their default values are left out. A stroke's line has numbers in the place of parameters.
std::string header_line(const std::optional<std::string>& mesh, const std::optional<std::string>& note,
                        std::span<const Parameter> parameters = {}, std::span<const std::string> also = {},
                        std::span<const Wall> walls = {});
std::string stroke_line(const Stroke& stroke);
std::string stroke_line(const SessionStroke& stroke);  // with its name, off, strength, duration, mirror and new_entry

// Returns one JSON object with the keys that apply to a stroke, also those with default values, but not empty ones.
std::string stroke_values(const SessionStroke& stroke);
std::string remesh_line(const std::optional<RemeshSettings>& settings);

}  // namespace knead
