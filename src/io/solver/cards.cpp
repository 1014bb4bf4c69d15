// Where the points of Nastran's, Abaqus' and universal files stand.
#include <algorithm>
#include <map>

#include "io/solver/solver.h"
#include "knead/error.h"

namespace knead::detail::solver {
namespace {

// The parts of a line between commas, with the blanks around them.
std::vector<std::string_view> split_at_commas(std::string_view line) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    parts.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

std::string_view part(const std::vector<std::string_view>& parts, std::size_t i) {
  return i < parts.size() ? parts[i] : std::string_view();
}

// The part without the blanks around it. One that is empty keeps its place, so that a number can be put there.
std::string_view tight(std::string_view text) {
  const std::string_view word = trimmed(text);
  return word.empty() ? text.substr(0, 0) : word;
}

// Nastran

class NastranScan {
 public:
  NastranScan(std::string_view bytes, const std::string& name, const PointVisitor& visit)
      : lines_(bytes, name), visit_(visit), has_sections_(has_begin_bulk(Lines(bytes, name))) {}

  void run() {
    bool is_bulk = !has_sections_;
    while (lines_.next()) {
      const std::string_view line = card();
      if (!is_bulk) {
        is_bulk = is_begin_bulk(line);
        continue;
      }
      const std::string_view text = trimmed(line);
      if (!text.empty() && (text[0] == 'I' || text[0] == 'i') && upper(text).starts_with("INCLUDE")) {
        lines_.fail("names a file with more cards; put its lines here");
      }
      const std::string word = upper(trimmed(line.substr(0, std::min(line.find(','), std::size_t{8}))));
      if (word == "ENDDATA") break;
      if (word == "GRID" || word == "GRID*") read_grid(line, word == "GRID*");
      if (word == "GRDSET" || word == "GRDSET*") require_basic(fields_of(line, word == "GRDSET*"), "GRDSET");
    }
  }

 private:
  static bool is_begin_bulk(std::string_view line) {
    const std::string text = upper(trimmed(line));
    if (!text.starts_with("BEGIN")) return false;
    return trimmed(std::string_view(text).substr(5)).starts_with("BULK");
  }

  static bool has_begin_bulk(Lines lines) {
    while (lines.next()) {
      if (is_begin_bulk(lines.line())) return true;
    }
    return false;
  }

  // The line without its comment.
  std::string_view card() const { return lines_.line().substr(0, lines_.line().find('$')); }

  // Returns the card's name and its fields, blanks included. Leaves out fields beyond the end of the line.
  std::vector<std::string_view> fields_of(std::string_view line, bool is_large) {
    if (line.find(',') != line.npos) return split_at_commas(line);
    if (line.find('\t') != line.npos) lines_.fail("has tabs between its fields; replace them by blanks or commas");
    std::vector<std::string_view> fields;
    const std::size_t width = is_large ? 16 : 8;
    for (std::size_t begin = 0; begin < line.size(); begin += fields.size() == 1 ? 8 : width) {
      fields.push_back(line.substr(begin, fields.empty() ? 8 : width));
      if (begin + fields.back().size() >= 72) break;  // the rest names the continuation
    }
    return fields;
  }

  // Coordinates are those of the basic system.
  void require_basic(const std::vector<std::string_view>& fields, const char* card) {
    const std::string_view system = trimmed(part(fields, 2));
    if (system.empty() || system == "0") return;
    lines_.fail(std::string(card) + " is in the coordinate system " + in_quotes(system) +
                "; only the basic one, 0, can be deformed");
  }

  void read_grid(std::string_view line, bool is_large) {
    const bool is_free = line.find(',') != line.npos;
    std::vector<std::string_view> fields = fields_of(line, is_large);
    require_basic(fields, "GRID");
    if (is_large) {
      fields.resize(std::min<std::size_t>(fields.size(), 5));
      if (fields.size() < 5 || !lines_.next() || !card().starts_with('*')) {
        lines_.fail("expected the line after GRID* that begins with * and holds the third coordinate");
      }
      const std::vector<std::string_view> more = fields_of(card(), true);
      if (more.size() > 1) fields.push_back(more[1]);
    }
    PointSite site;
    site.spelling = is_free ? Spelling::bulk_words : is_large ? Spelling::field_16 : Spelling::field_8;
    site.dimensions = std::min<std::size_t>(fields.size() < 3 ? 0 : fields.size() - 3, 3);
    if (site.dimensions == 0) lines_.fail("GRID has no coordinates");
    for (std::size_t axis = 0; axis < site.dimensions; ++axis) {
      site.words[axis] = is_free ? tight(fields[3 + axis]) : fields[3 + axis];
    }
    visit_(site);
  }

  Lines lines_;
  const PointVisitor& visit_;
  bool has_sections_ = false;  // a line BEGIN BULK stands before the cards
};

// Abaqus

class AbaqusScan {
 public:
  AbaqusScan(std::string_view bytes, const std::string& name, const PointVisitor& visit)
      : lines_(bytes, name), name_(name), visit_(visit) {}

  void run() {
    while (lines_.next()) {
      const std::string_view line = trimmed(lines_.line());
      if (line.empty() || line.starts_with("**")) continue;
      if (line[0] == '*') {
        read_keyword(line);
      } else if (keyword_ == "NODE") {
        read_node(line);
      } else if (keyword_ == "INSTANCE") {
        lines_.fail("moves an instance of a part; place the part where it stands");
      }
    }
    if (!has_nodes_) throw InvalidInput(Place{name_}, "has no *NODE; is it a file of Abaqus?");
  }

 private:
  void read_keyword(std::string_view line) {
    const std::vector<std::string_view> parts = split_at_commas(line.substr(1));
    keyword_ = upper(trimmed(parts[0]));
    for (const char* const maker : {"NGEN", "NFILL", "NCOPY", "NMAP", "SYSTEM", "INCLUDE", "IMPORT"}) {
      if (keyword_ == maker) lines_.fail("*" + keyword_ + " is not understood; write all nodes out by *NODE");
    }
    while (trimmed(lines_.line()).ends_with(',') && lines_.next()) read_parameters(split_at_commas(lines_.line()));
    read_parameters(parts);
    has_nodes_ = has_nodes_ || keyword_ == "NODE";
  }

  void read_parameters(const std::vector<std::string_view>& parts) {
    for (const std::string_view parameter : parts) {
      const std::string text = upper(trimmed(parameter));
      const std::string key(trimmed(std::string_view(text).substr(0, text.find('='))));
      if (keyword_ == "INSTANCE" && key == "LIBRARY") lines_.fail("takes an instance from another file (LIBRARY=)");
      if (keyword_ != "NODE") continue;
      if (key == "INPUT") lines_.fail("the nodes lie in another file (INPUT=); name that file, or put them here");
      const bool is_cartesian = key != "SYSTEM" || trimmed(std::string_view(text).substr(text.find('=') + 1)) == "R";
      if (!is_cartesian) lines_.fail("the nodes are not in Cartesian coordinates (SYSTEM=)");
    }
  }

  void read_node(std::string_view line) {
    std::vector<std::string_view> parts = split_at_commas(line);
    if (parts.size() > 1 && trimmed(parts.back()).empty()) parts.pop_back();  // after a comma at the end
    PointSite site;
    site.spelling = Spelling::short_words;
    site.dimensions = std::min<std::size_t>(parts.size() - 1, 3);
    if (site.dimensions == 0) lines_.fail("expected a number, a comma and the coordinates of a node");
    for (std::size_t axis = 0; axis < site.dimensions; ++axis) site.words[axis] = tight(parts[1 + axis]);
    visit_(site);
  }

  Lines lines_;
  const std::string& name_;
  const PointVisitor& visit_;
  std::string keyword_;
  bool has_nodes_ = false;
};

// Universal files

constexpr std::string_view kDelimiter = "-1";

// The words of a line.
std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (line = trimmed(line); !line.empty(); line = trimmed(line.substr(words.back().size()))) {
    words.push_back(line.substr(0, token_end(line, 0)));
  }
  return words;
}

// Goes to the next dataset and returns its number; empty at the end. Lines between datasets belong to none.
std::string next_dataset(Lines& lines) {
  while (lines.next()) {
    if (trimmed(lines.line()) != kDelimiter) continue;
    if (!lines.next()) lines.fail("a dataset has no number; the file is cut short");
    const std::vector<std::string_view> words = words_of(lines.line());
    const std::string number(words.empty() ? "" : words[0]);
    const bool is_number = !number.empty() && number[0] >= '0' && number[0] <= '9';
    if (!is_number) lines.fail("expected the number of a dataset, found " + in_quotes(trimmed(lines.line())));
    return number;
  }
  return {};
}

// Goes to the next line of a dataset; false at its end.
bool next_row(Lines& lines) {
  if (!lines.next()) lines.fail("a dataset has no end, a line -1; the file is cut short");
  return trimmed(lines.line()) != kDelimiter;
}

// Why the coordinates of nodes are no places, by the number of the coordinate system that the nodes name.
using OtherSystems = std::map<std::string, std::string, std::less<>>;

// Returns whether the axes and the origin of a coordinate system, four rows of three numbers, are others than the
// global ones.
bool is_moved_system(Lines& lines) {
  bool is_moved = false;
  for (std::size_t row = 0; row < 4; ++row) {
    if (!next_row(lines)) lines.fail("a coordinate system has four rows of three numbers; the file is cut short");
    const std::vector<std::string_view> words = words_of(lines.line());
    for (std::size_t i = 0; i < words.size(); ++i) {
      is_moved = is_moved || lines.number(words[i]) != (i == row ? 1.0 : 0.0);
    }
  }
  return is_moved;
}

// Reads dataset 2420: the part and its name; of each system its number, type and color, its name, and the rows.
void read_systems(Lines& lines, OtherSystems& others) {
  if (!next_row(lines) || !next_row(lines)) return;
  while (next_row(lines)) {
    const std::vector<std::string_view> words = words_of(lines.line());
    if (words.size() < 2) lines.fail("expected the number and type of a coordinate system");
    const std::string number(words[0]);
    const std::string type(words[1]);
    if (!next_row(lines)) return;
    const bool is_moved = is_moved_system(lines);
    if (type == "1") others[number] = "a cylindrical one";
    if (type == "2") others[number] = "a spherical one";
    if (type == "0" && is_moved) others[number] = "one that is turned or moved";
  }
}

void scan_unv_points(Lines& lines, const OtherSystems& others, const PointVisitor& visit) {
  while (next_row(lines)) {
    const std::vector<std::string_view> node = words_of(lines.line());
    const auto other = node.size() < 2 ? others.end() : others.find(node[1]);
    if (other != others.end()) {
      lines.fail("a node is in the coordinate system " + other->first + ", " + other->second +
                 "; only the global Cartesian one can be deformed");
    }
    if (!lines.next()) lines.fail("a node has no coordinates; the file is cut short");
    const std::string_view line = lines.line();
    PointSite site;
    site.spelling = Spelling::columns;
    std::size_t begin = 0;
    for (std::string_view& word : site.words) {
      std::size_t end = begin;
      while (end < line.size() && is_blank(line[end])) ++end;
      end = token_end(line, end);
      word = line.substr(begin, end - begin);
      if (trimmed(word).empty()) lines.fail("expected three coordinates of a node");
      begin = end;
    }
    visit(site);
  }
}

}  // namespace

void scan_nastran(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  NastranScan(bytes, name, visit).run();
}

void scan_abaqus(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  AbaqusScan(bytes, name, visit).run();
}

void scan_unv(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  OtherSystems others;  // they may stand behind the nodes
  Lines systems(bytes, name);
  for (std::string dataset = next_dataset(systems); !dataset.empty(); dataset = next_dataset(systems)) {
    if (dataset == "18") systems.fail("has coordinate systems in dataset 18; write them as 2420");
    if (dataset == "15" || dataset == "781") {
      systems.fail("has its nodes in dataset " + dataset + "; write them as 2411");
    }
    if (dataset == "2420") {
      read_systems(systems, others);
      continue;
    }
    while (next_row(systems)) continue;
  }
  Lines lines(bytes, name);
  bool has_nodes = false;
  for (std::string dataset = next_dataset(lines); !dataset.empty(); dataset = next_dataset(lines)) {
    has_nodes = has_nodes || dataset == "2411";
    if (dataset == "2411") {
      scan_unv_points(lines, others, visit);
      continue;
    }
    while (next_row(lines)) continue;
  }
  if (!has_nodes) throw InvalidInput(Place{name}, "has no nodes (dataset 2411); is it a universal file?");
}

}  // namespace knead::detail::solver
