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

// A stroke of a session, and how the mesh follows it.
struct SessionStroke {
  Stroke stroke;
  std::size_t line = 0;  // of the session file, from 1; 0: of none
  // How the mesh follows the stroke: the settings of the latest remesh event before it. Nothing: the faces stay as they
  // are.
  std::optional<RemeshSettings> remesh{};

  friend bool operator==(const SessionStroke&, const SessionStroke&) = default;
};

// A session: its header, and the strokes in effect.
struct Session {
  std::string name;                 // of the file, for messages
  std::optional<std::string> mesh;  // the shape it was made on, relative to the session file
  std::optional<std::string> note;
  std::vector<SessionStroke> strokes;  // in effect, in order: without the strokes that undo took back
  std::vector<std::string> warnings;   // of reading, each with file and line

  friend bool operator==(const Session&, const Session&) = default;
};

// Reads a session file. Throws IoError(read) for a file that cannot be read. Throws InvalidInput with the file, the
// line, the key and the expected value for malformed text: an unknown, missing or repeated key, a wrong type, a number
// that is not finite, a value that its tool cannot use, more strokes undone than applied, an unknown event. Drops an
// incomplete last line (without a line end, and no JSON) with a warning.
Session read_session(const std::filesystem::path& path);

// Reads a session from text; `name` stands for the file in messages.
Session parse_session(std::string_view text, const std::string& name);

// Returns a session file with the header and the strokes in effect, and a remesh event before every stroke whose
// settings differ from those of the stroke before. It parses back to the same strokes, to the bit.
std::string serialize_session(const Session& session);

// Return a line of a session file without the line end: the first line, a stroke, the remesh event that gives the next
// strokes these settings. Numbers have the shortest form that reads back as the same number; keys with their default
// values are left out.
std::string header_line(const std::optional<std::string>& mesh, const std::optional<std::string>& note);
std::string stroke_line(const Stroke& stroke);
std::string remesh_line(const std::optional<RemeshSettings>& settings);

}  // namespace knead
