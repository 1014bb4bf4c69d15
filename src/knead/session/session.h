// The session file `.knead`: JSON Lines, the first line a header, every further line an event.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knead/remesh/remesh.h"
#include "knead/tool/stroke.h"

namespace knead {

struct SessionStroke {
  Stroke stroke;
  std::size_t line = 0;  // of the session file, from 1; 0: of none
  // How the mesh is made to follow the stroke: what the latest remesh event before it says. Nothing: vertices and faces
  // stay as they are.
  std::optional<RemeshSettings> remesh{};

  friend bool operator==(const SessionStroke&, const SessionStroke&) = default;
};

struct Session {
  std::string name;                 // of the file, for messages
  std::optional<std::string> mesh;  // the shape it was made on, relative to the session file
  std::optional<std::string> note;
  std::vector<SessionStroke> strokes;  // in effect, in order: what undo took back and redo did not restore is left out
  std::vector<std::string> warnings;   // of reading, each with file and line

  friend bool operator==(const Session&, const Session&) = default;
};

// Reads a session file. Throws IoError(read) for a file that cannot be read, and InvalidInput with file, line, key and
// what was expected for anything malformed: an unknown, missing or repeated key, a wrong type, a number that is not
// finite, a value that its tool cannot use, more undone than done, an event that this version does not know. An
// incomplete last line (without a line end, and no JSON) is dropped with a warning.
Session read_session(const std::filesystem::path& path);

// The same for text at hand; `name` stands for the file in messages.
Session parse_session(std::string_view text, const std::string& name);

// A session file of the header and the strokes in effect, with a remesh event where the settings change from one stroke
// to the next; parses back to the same strokes, to the bit.
std::string serialize_session(const Session& session);

// The first line of a session file, one stroke as a line of it, and the remesh event after which strokes have these
// settings; without the line end. Numbers are written in the
// shortest form that reads back as the same; keys at their defaults are left out.
std::string header_line(const std::optional<std::string>& mesh, const std::optional<std::string>& note);
std::string stroke_line(const Stroke& stroke);
std::string remesh_line(const std::optional<RemeshSettings>& settings);

}  // namespace knead
