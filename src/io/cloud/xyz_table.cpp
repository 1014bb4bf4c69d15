// Which columns of points in text hold the coordinates, and the words and rows of such files.
#include <algorithm>
#include <charconv>

#include "io/cloud/cloud.h"
#include "io/text.h"

namespace knead::detail::xyz {
namespace {

bool is_separator(char c) { return c == ',' || c == ';'; }

using Fields = std::vector<std::string_view>;

bool is_comment(std::string_view text) {
  return !text.empty() && (text[0] == '#' || text[0] == '%' || text.substr(0, 2) == "//");
}

std::string_view unquoted(std::string_view text) {
  text = trimmed(text);
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return text;
  return trimmed(text.substr(1, text.size() - 2));
}

// The end of the line that begins at `begin`, without its line end.
std::size_t line_end(std::string_view bytes, std::size_t begin) {
  return std::min(bytes.find_first_of("\r\n", begin), bytes.size());
}

std::size_t after_line_end(std::string_view bytes, std::size_t end) {
  if (end >= bytes.size()) return bytes.size();
  return end + (bytes.substr(end, 2) == "\r\n" ? 2 : 1);
}

// The character that separates the fields of a line: the first of these that stands outside of quotes.
char separator_of(std::string_view line) {
  for (const char c : {';', ',', '\t'}) {
    bool quoted = false;
    for (const char at : line) {
      if (at == '"') quoted = !quoted;
      if (at == c && !quoted) return c;
    }
  }
  return ' ';
}

void split_at_blanks(std::string_view line, Fields& fields) {
  for (std::size_t i = 0; i < line.size();) {
    if (is_blank(line[i])) {
      ++i;
      continue;
    }
    if (is_comment(line.substr(i))) return;
    const std::size_t begin = i;
    bool quoted = false;
    for (; i < line.size() && (quoted || !is_blank(line[i])); ++i) quoted = quoted != (line[i] == '"');
    fields.push_back(unquoted(line.substr(begin, i - begin)));
  }
}

void split(std::string_view line, char separator, Fields& fields) {
  fields.clear();
  if (separator == ' ') return split_at_blanks(line, fields);
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] != separator || quoted) continue;
    fields.push_back(unquoted(line.substr(begin, i - begin)));
    begin = i + 1;
  }
  const std::string_view last = unquoted(line.substr(begin));
  if (!last.empty() || fields.empty()) fields.push_back(last);
}

Fields split(std::string_view line) {
  Fields fields;
  split(line, separator_of(line), fields);
  return fields;
}

bool has_numbers(const Fields& fields) { return std::any_of(fields.begin(), fields.end(), is_number); }

// A name in lower case, without units ("[m]", "(mm)") and without the marks of a comment.
std::string plain_name(std::string_view name) {
  while (!name.empty() && (name[0] == '/' || name[0] == '#' || name[0] == '%')) name.remove_prefix(1);
  return lower(unquoted(name.substr(0, name.find_first_of("[("))));
}

using Names = std::vector<std::string>;

Names plain_names(const Fields& fields) {
  Names names;
  for (const std::string_view field : fields) names.push_back(plain_name(field));
  return names;
}

constexpr std::size_t kNowhere = ~std::size_t{0};

std::size_t place_of(const Names& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? kNowhere : static_cast<std::size_t>(found - names.begin());
}

std::size_t place_of_any(const Names& names, std::initializer_list<std::string_view> wanted) {
  for (const std::string_view name : wanted) {
    if (const std::size_t place = place_of(names, name); place != kNowhere) return place;
  }
  return kNowhere;
}

// The places of x, y and z; kNowhere for those that no column is named after.
std::array<std::size_t, 3> places_of_axes(const Names& names) {
  struct Pair {
    std::string_view x, y, z;
  };
  constexpr Pair known[] = {
      {"x", "y", "z"},
      {"pos_x", "pos_y", "pos_z"},
      {"position_x", "position_y", "position_z"},
      {"x_coord", "y_coord", "z_coord"},
      {"coord_x", "coord_y", "coord_z"},
      {"points:0", "points:1", "points:2"},
      {"points_0", "points_1", "points_2"},
      {"easting", "northing", "height"},
      {"east", "north", "height"},
      {"e", "n", "h"},
  };
  std::array<std::size_t, 3> best{kNowhere, kNowhere, kNowhere};
  for (const Pair& pair : known) {
    std::array<std::size_t, 3> at{place_of(names, pair.x), place_of(names, pair.y), place_of(names, pair.z)};
    if (at[2] == kNowhere) at[2] = place_of_any(names, {"z", "height", "elevation", "altitude", "elev", "alt", "h"});
    if (at[0] != kNowhere && at[1] != kNowhere && at[2] != kNowhere) return at;
    const bool is_better = best[0] == kNowhere && best[1] == kNowhere;
    if (is_better && (at[0] != kNowhere || at[1] != kNowhere)) best = at;
  }
  return best;
}

bool are_degrees(const Names& names) {
  return place_of_any(names, {"lon", "long", "lng", "longitude"}) != kNowhere &&
         place_of_any(names, {"lat", "latitude"}) != kNowhere;
}

class Finder {
 public:
  Finder(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  std::optional<TableStart> run() {
    TableStart start;
    std::size_t begin = text_begin(bytes_, name_);
    for (std::size_t end = 0; begin < bytes_.size(); begin = after_line_end(bytes_, end)) {
      end = line_end(bytes_, begin);
      const std::string_view line = trimmed(bytes_.substr(begin, end - begin));
      if (line.empty()) continue;
      if (is_comment(line)) {
        if (!has_header_) set_names(start, begin, end);
        continue;
      }
      const Fields fields = split(line);
      if (fields.size() == 1 && is_number(fields[0]) && !start.count_begin) {
        start.count_begin = begin;
        const std::size_t next = after_line_end(bytes_, end);
        if (std::optional<TableStart> molecule = molecule_at(start, fields[0], next)) return molecule;
        continue;
      }
      const bool is_header = fields.size() >= 2 && !has_numbers(fields) && !has_header_;
      if (!is_header) break;
      has_header_ = true;
      set_names(start, begin, end);
    }
    start.points_begin = begin;
    return begin < bytes_.size() ? from_names(start) : std::nullopt;
  }

 private:
  static void set_names(TableStart& start, std::size_t begin, std::size_t end) {
    start.names_begin = begin;
    start.names_end = end;
  }

  std::string_view line_at(std::size_t begin) const { return bytes_.substr(begin, line_end(bytes_, begin) - begin); }

  std::optional<TableStart> from_names(TableStart start) const {
    const std::string_view row = line_at(start.points_begin);
    start.columns.separator = separator_of(row);
    const Fields first = split(row);
    const Fields header = names_of(start);
    Names names = plain_names(header);
    // As R writes tables; but a number before and none behind is a row with a label that has no name.
    const bool has_row_names = has_header_ && start.columns.separator == ' ' && names.size() + 1 == first.size() &&
                               (!is_number(first.front()) || is_number(first.back()));
    if (has_row_names) names.insert(names.begin(), "");
    const bool fits = names.size() == first.size() || (has_header_ && names.size() > 3 && separates(start));
    const std::array<std::size_t, 3> at = places_of_axes(names);
    const bool is_complete = std::find(at.begin(), at.end(), kNowhere) == at.end();
    if (fits && is_complete) {
      start.columns.position = at;
      for (const std::string_view name : header) start.columns.names.emplace_back(trimmed(name));
      if (has_row_names) start.columns.names.insert(start.columns.names.begin(), "");
      start.names_end = after_line_end(bytes_, start.names_end);
      return start;
    }
    if (fits && start.names_begin != start.names_end) refuse_names(start, names, at);
    start.names_end = start.names_begin;
    return from_quotes(start, row, first);
  }

  Fields names_of(const TableStart& start) const {
    std::string_view line = trimmed(bytes_.substr(start.names_begin, start.names_end - start.names_begin));
    while (is_comment(line)) line.remove_prefix(1);
    while (!line.empty() && line[0] == '/') line.remove_prefix(1);
    return split(trimmed(line));
  }

  bool separates(const TableStart& start) const {
    return start.columns.separator != ' ' && separator_of(line_at(start.names_begin)) == start.columns.separator;
  }

  void refuse_names(const TableStart& start, const Names& names, const std::array<std::size_t, 3>& at) const {
    const auto refuse = [&](const std::string& what) { fail_at_line(name_, bytes_, start.names_begin, what); };
    if (are_degrees(names)) {
      refuse(
          "longitude and latitude are angles, not lengths; project the points to metres (easting, northing, height)");
    }
    if (at[0] != kNowhere || at[1] != kNowhere) {
      const std::size_t axis = at[0] == kNowhere ? 0 : (at[1] == kNowhere ? 1 : 2);
      refuse(std::string("the columns have names, but none is '") + "xyz"[axis] + "'; name the columns x, y and z");
    }
    if (has_header_ && names.size() > 3 && separates(start)) {
      refuse("no three columns are named x, y and z (or easting, northing and height); name the columns so");
    }
  }

  // A table without names whose numbers are in quotes.
  std::optional<TableStart> from_quotes(TableStart start, std::string_view row, const Fields& first) const {
    if (row.find('"') == std::string_view::npos) return std::nullopt;
    const std::size_t label = !first.empty() && !is_number(first[0]) ? 1 : 0;
    if (first.size() < label + 3) return std::nullopt;
    start.columns.position = {label, label + 1, label + 2};
    return start;
  }

  // A molecule whose line of text begins at `begin`: the lines after it have an atom, or its number, before x y z.
  std::optional<TableStart> molecule_at(TableStart start, std::string_view count, std::size_t begin) const {
    std::size_t atoms = 0;
    const bool is_whole = std::from_chars(count.data(), count.data() + count.size(), atoms).ec == std::errc{};
    const std::size_t after = after_line_end(bytes_, line_end(bytes_, begin));
    if (!is_whole || after >= bytes_.size()) return std::nullopt;
    const std::string_view line = trimmed(line_at(begin));
    const std::array<std::size_t, 3> at = places_of_axes(plain_names(split(line)));
    const bool has_names = std::find(at.begin(), at.end(), kNowhere) == at.end();
    if (has_names || is_comment(line)) return std::nullopt;
    const Fields first = split(line_at(after));
    const std::size_t place = place_of_positions(line);
    if (separator_of(line_at(after)) != ' ' || first.size() < std::max<std::size_t>(place + 3, 4)) return std::nullopt;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!is_number(first[place + axis])) return std::nullopt;
    }
    Rows rows(bytes_, after, ' ');
    std::size_t count_of_rows = 0;
    while (count_of_rows <= atoms && rows.next()) ++count_of_rows;
    if (count_of_rows != atoms || (place == 1 && is_number(first[0]) && !are_atomic_numbers(after)))
      return std::nullopt;
    start.points_begin = after;
    start.columns.position = {place, place + 1, place + 2};
    return start;
  }

  bool are_atomic_numbers(std::size_t begin) const {
    Rows rows(bytes_, begin, ' ');
    while (rows.next()) {
      constexpr double most = 118;
      double value = 0;
      const bool is_read = parse_real(rows.fields()[0], value) == ParseResult::ok;
      if (!is_read || !(value >= 1 && value <= most) || value != static_cast<int>(value)) return false;
    }
    return true;
  }

  // The column of x in the extended format, e.g. 1 for Properties=species:S:1:pos:R:3.
  static std::size_t place_of_positions(std::string_view line) {
    constexpr std::string_view key = "Properties=";
    const std::size_t begin = line.find(key);
    if (begin == std::string_view::npos) return 1;
    std::string_view list = line.substr(begin + key.size());
    if (!list.empty() && list[0] == '"') list.remove_prefix(1);
    list = list.substr(0, list.find_first_of(" \t\""));
    std::size_t place = 0;
    while (!list.empty()) {
      std::string_view parts[3];
      for (std::string_view& part : parts) {
        part = list.substr(0, list.find(':'));
        list.remove_prefix(std::min(part.size() + 1, list.size()));
      }
      if (parts[0] == "pos") return place;
      std::size_t width = 0;
      std::from_chars(parts[2].data(), parts[2].data() + parts[2].size(), width);
      place += std::min<std::size_t>(width, 1000);
    }
    return 1;
  }

  std::string_view bytes_;
  const std::string& name_;
  bool has_header_ = false;  // a line that is no comment names the columns
};

}  // namespace

bool is_number(std::string_view word) {
  double value = 0;
  return parse_real(word, value) != ParseResult::malformed;
}

std::string_view Words::next_on_line() {
  std::size_t begin = text_.position();
  std::size_t separators = 0;
  for (; begin < bytes_.size() && (is_blank(bytes_[begin]) || is_separator(bytes_[begin])); ++begin) {
    if (is_separator(bytes_[begin])) note_separator(bytes_[begin], separators);
  }
  const std::size_t end = is_comment(bytes_.substr(begin, 2)) ? begin : word_end(begin);
  const std::string_view word = text_.take(begin, end);
  if (separators > (at_begin_ ? 0 : 1) && !word.empty()) text_.fail("expected a number between two separators");
  if (mixed_) text_.fail("commas and semicolons on one line; write numbers with points and one kind of separator");
  if (!word.empty()) note_gap(separators, word[0] >= '+' && word[0] <= '9');
  at_begin_ = false;
  return word;
}

void Words::note_gap(std::size_t separators, bool is_number) {
  if (!at_begin_ && after_number_ && is_number) {
    separated_ = separated_ || separators > 0;
    by_blanks_ = by_blanks_ || separators == 0;
    if (separated_ && by_blanks_) {
      text_.fail(
          "commas between some numbers and blanks between others; write decimals with points, not commas, and one "
          "kind of separator");
    }
  }
  after_number_ = is_number;
}

bool Words::next_line() {
  const bool is_there = text_.next_line();
  go_to(text_.position());
  return is_there;
}

std::string_view Words::next() {
  std::string_view word = next_on_line();
  while (word.empty() && next_line()) word = next_on_line();
  return word;
}

void Words::go_to(std::size_t position) {
  text_.take(position, position);
  at_begin_ = true;
  after_number_ = separated_ = by_blanks_ = false;
  separator_ = '\0';
}

void Words::note_separator(char c, std::size_t& count) {
  ++count;
  mixed_ = mixed_ || (separator_ != '\0' && separator_ != c);
  separator_ = c;
}

std::size_t Words::word_end(std::size_t begin) const {
  while (begin < bytes_.size() && !is_blank(bytes_[begin]) && !is_line_end(bytes_[begin]) &&
         !is_separator(bytes_[begin])) {
    ++begin;
  }
  return begin;
}

std::optional<TableStart> find_table(std::string_view bytes, const std::string& name) {
  return Finder(bytes, name).run();
}

bool Rows::next() {
  while (next_ < bytes_.size()) {
    begin_ = next_;
    const std::size_t end = line_end(bytes_, begin_);
    next_ = after_line_end(bytes_, end);
    const std::string_view line = trimmed(bytes_.substr(begin_, end - begin_));
    if (line.empty() || is_comment(line)) continue;
    split(line, separator_, fields_);
    return true;
  }
  return false;
}

}  // namespace knead::detail::xyz
