#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "knead/math/system.h"
#include "knead/session/session.h"
#include "knead/session/stroke_json.h"

namespace knead {

namespace {

using session_detail::JsonObject;
using session_detail::JsonValue;

constexpr int kFormatVersion = 1;
// Bytes of a line: a hundred thousand samples of a painted stroke are some 10 MB, and hold 25 times as much in memory.
constexpr std::size_t kLongestLine = std::size_t{16} << 20;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kBlanks = " \t\r\n";

struct Line {
  std::string_view text;
  bool ended = false;  // by a line end
};

// The text up to the next LF, without it and a CR before it; takes it away from `rest`.
Line next_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  Line line{rest.substr(0, end), end != std::string_view::npos};
  rest.remove_prefix(line.ended ? end + 1 : rest.size());
  if (line.ended && line.text.ends_with('\r')) line.text.remove_suffix(1);
  return line;
}

// Follows the events of a session one line after the other.
class SessionReader {
 public:
  explicit SessionReader(const std::string& name) : place_{name, 0} { session_.name = name; }

  Session read(std::string_view rest) {
    if (rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
    while (rest.find_first_not_of(kBlanks) != std::string_view::npos) {
      const Line line = next_line(rest);
      ++place_.line;
      if (line.text.size() > kLongestLine) {
        throw InvalidInput(place_, fmt::format("the line has {} bytes, more than {}; split the stroke into several",
                                               line.text.size(), kLongestLine));
      }
      if (line.text.find_first_not_of(kBlanks) == std::string_view::npos) {
        throw InvalidInput(place_, "the line is empty; every line must be a JSON object");
      }
      const std::optional<Json> json = session_detail::parse_line(line.text, place_);
      if (json) {
        read_line(JsonValue(*json, "", place_));
      } else {
        read_incomplete(line);
      }
    }
    if (place_.line == 0) {
      throw InvalidInput({place_.file, 1}, R"(the file is empty; its first line must be the header {"knead": 1})");
    }
    return std::move(session_);
  }

 private:
  void read_line(const JsonValue& line) {
    if (!line.json().is_object()) throw InvalidInput(place_, "the line must be a JSON object {...}");
    if (place_.line == 1) {
      read_header(JsonObject(line, place_, "the header"));
    } else {
      read_event(line);
    }
  }

  void read_incomplete(const Line& line) {
    if (line.ended || place_.line == 1) {
      throw InvalidInput(place_, "the JSON object of this line is incomplete; complete it or remove the line");
    }
    session_.warnings.push_back(to_string(place_) + ": the last line is incomplete and was left out");
  }

  void read_header(const JsonObject& header) {
    if (!header.has("knead")) {
      throw InvalidInput(place_, R"("knead" is missing; the first line must be the header {"knead": 1})");
    }
    const long long version = header.at("knead").integer();
    if (version != kFormatVersion) {
      throw InvalidInput(place_, fmt::format("\"knead\" must be {}, the format that this version reads, got {}",
                                             kFormatVersion, version));
    }
    header.allow({"knead", "mesh", "note"});
    if (header.has("mesh")) session_.mesh = header.at("mesh").text();
    if (header.has("note")) session_.note = header.at("note").text();
  }

  void read_event(const JsonValue& line) {
    const JsonObject event(line, place_, "an event");
    if (event.has("tool")) {
      add(session_detail::read_stroke(line, place_));
    } else if (const Tool* tool = session_detail::event_tool(event)) {
      event.allow({tool->name});
      add(session_detail::read_event_stroke(*tool, event.at(tool->name), place_));
    } else if (event.has("undo")) {
      event.allow({"undo"});
      move_last(event.at("undo"), session_.strokes, undone_, "in effect");
    } else if (event.has("redo")) {
      event.allow({"redo"});
      move_last(event.at("redo"), undone_, session_.strokes, "to be redone");
    } else if (event.has("remesh")) {
      event.allow({"remesh"});
      remesh_ = session_detail::read_remesh(event.at("remesh"), place_);
    } else {
      event.allow({"tool", "relax", "mask", "undo", "redo", "remesh"});
      throw InvalidInput(
          place_, R"(the line is an empty object; an event has the key "tool", "relax", "mask", "undo", "redo" or )"
                  R"("remesh")");
    }
  }

  void add(SessionStroke stroke) {
    session_.strokes.push_back(std::move(stroke));
    session_.strokes.back().remesh = remesh_;
    undone_.clear();
  }

  // Moves the last n strokes, one after the other.
  void move_last(const JsonValue& count, std::vector<SessionStroke>& from, std::vector<SessionStroke>& to,
                 const char* what) const {
    const long long n = count.integer();
    if (n < 1 || static_cast<std::size_t>(n) > from.size()) {
      count.fail(fmt::format("a whole number from 1 to the {} strokes {}", from.size(), what));
    }
    for (long long i = 0; i < n; ++i) {
      to.push_back(std::move(from.back()));
      from.pop_back();
    }
  }

  Place place_;
  Session session_;
  std::vector<SessionStroke> undone_;     // the one to be redone first at the end
  std::optional<RemeshSettings> remesh_;  // of the strokes that follow
};

[[noreturn]] void fail_to_read(const std::string& file) {
  throw IoError(IoError::Operation::read, file, "cannot be read: " + std::generic_category().message(errno));
}

}  // namespace

Session parse_session(std::string_view text, const std::string& name) { return SessionReader(name).read(text); }

SessionStroke parse_stroke(std::string_view text, const std::string& name) {
  const Place place{name, 0};
  const std::optional<Json> json = session_detail::parse_line(text, place);
  if (!json || !json->is_object()) throw InvalidInput(place, "a stroke must be a JSON object {...}");
  const JsonValue line(*json, "", place);
  const JsonObject event(line, place, "a stroke");
  const Tool* tool = session_detail::event_tool(event);
  if (tool == nullptr || event.has("tool")) return session_detail::read_stroke(line, place);
  event.allow({tool->name});
  return session_detail::read_event_stroke(*tool, event.at(tool->name), place);
}

Session read_session(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open_to_read(path), std::fclose);
  if (file == nullptr) fail_to_read(path.string());
  std::string text;
  std::string buffer(std::size_t{1} << 16, '\0');
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), file.get())) {
    text.append(buffer, 0, count);
  }
  if (std::ferror(file.get()) != 0) fail_to_read(path.string());
  return parse_session(text, path.string());
}

}  // namespace knead
