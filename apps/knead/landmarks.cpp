// Reads landmarks from tables and from files of 3D Slicer.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "inputs.h"
#include "json/json.h"
#include "knead/error.h"
#include "knead/io.h"
#include "output.h"

namespace knead::command {

namespace {

const std::array<std::string, 6> kPlaces{"source_x", "source_y", "source_z", "target_x", "target_y", "target_z"};
const std::array<std::string, 2> kVertices{"source_vertex", "target_vertex"};
constexpr std::string_view kTolerance = "tolerance";
constexpr std::string_view kHeaders =
    "the first line must be source_x,source_y,source_z,target_x,target_y,target_z or source_vertex,target_vertex";

// The lines of a text, which end with LF, CR LF or CR; the first has the number 1.
std::vector<std::string> lines_of(const std::string& bytes) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < bytes.size();) {
    const std::size_t end = std::min(bytes.find_first_of("\r\n", begin), bytes.size());
    lines.push_back(bytes.substr(begin, end - begin));
    begin = end + (bytes.compare(end, 2, "\r\n") == 0 ? 2 : 1);
  }
  return lines;
}

std::string trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return std::string(text);
}

// The fields of a line, without blanks and quotes around them.
Fields fields_of(const std::string& line, char separator) {
  Fields fields{""};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == separator && !quoted) {
      fields.emplace_back();
    } else if (c != '"') {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) field = trimmed(field);
  return fields;
}

// The places of the columns with these names; nothing if one is missing.
template <std::size_t count>
std::optional<std::array<std::size_t, count>> columns_named(const Fields& names,
                                                            const std::array<std::string, count>& wanted) {
  std::array<std::size_t, count> places{};
  for (std::size_t i = 0; i < count; ++i) {
    const auto is_it = [&](const std::string& name) { return lower_case(name) == wanted[i]; };
    const auto found = std::find_if(names.begin(), names.end(), is_it);
    if (found == names.end()) return std::nullopt;
    places[i] = static_cast<std::size_t>(found - names.begin());
  }
  return places;
}

template <std::size_t count>
std::array<std::size_t, count> first_columns() {
  std::array<std::size_t, count> places{};
  for (std::size_t i = 0; i < count; ++i) places[i] = i;
  return places;
}

template <std::size_t count>
std::array<double, count> numbers_of(const Table& table, const Table::Row& row,
                                     const std::array<std::size_t, count>& columns, std::string_view what) {
  std::array<double, count> numbers{};
  const std::size_t width = table.names.empty() ? count : table.names.size();
  Fields fields = row.fields;
  while (fields.size() > width && fields.back().empty()) fields.pop_back();
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_there = columns[i] < fields.size() && fields.size() <= width;
    const std::optional<double> number = is_there ? number_in(fields[columns[i]], table.separator) : std::nullopt;
    if (!number) throw InvalidInput(table.place(row), fmt::format("a pair must be {}", what));
    if (!std::isfinite(*number)) throw InvalidInput(table.place(row), "a coordinate is not finite; give a number");
    numbers[i] = *number;
  }
  return numbers;
}

// An empty field stands for 0.
double tolerance_of(const Table& table, const Table::Row& row, std::size_t column) {
  if (column >= row.fields.size() || row.fields[column].empty()) return 0;
  const std::optional<double> number = number_in(row.fields[column], table.separator);
  if (number && std::isfinite(*number) && *number >= 0) return *number;
  throw InvalidInput(table.place(row), "a tolerance must be a length of 0 or more");
}

const Vec3d& vertex_of(const Mesh& mesh, double number, const Place& place, std::string_view name) {
  if (number < static_cast<double>(mesh.vertex_count())) return mesh.positions[static_cast<std::size_t>(number)];
  throw InvalidInput(
      place, fmt::format("\"{}\" must be a vertex from 0 to {}, got {}", name, mesh.vertex_count() - 1, number));
}

// Removes pairs that are given twice.
void remove_repeated(LandmarkPairs& pairs) {
  LandmarkPairs kept;
  kept.notes = std::move(pairs.notes);
  for (std::size_t i = 0; i < pairs.source.size(); ++i) {
    bool is_repeated = false;
    for (std::size_t k = 0; k < kept.source.size() && !is_repeated; ++k) {
      is_repeated = kept.source[k] == pairs.source[i] && kept.target[k] == pairs.target[i];
    }
    if (is_repeated) continue;
    kept.source.push_back(pairs.source[i]);
    kept.target.push_back(pairs.target[i]);
    kept.tolerance.push_back(pairs.tolerance[i]);
  }
  const std::size_t repeated = pairs.source.size() - kept.source.size();
  if (repeated > 0) {
    kept.notes.push_back(repeated == 1 ? std::string("1 pair is given twice and counts once")
                                       : fmt::format("{} pairs are given twice and count once", repeated));
  }
  pairs = std::move(kept);
}

// Landmarks of one shape.
struct Points {
  std::vector<Vec3d> places;
  std::vector<std::string> labels;
  std::string system;  // "LPS", "RAS" or empty
};

std::string system_of(const std::string& word) {
  if (word == "LPS" || word == "1") return "LPS";
  return word == "RAS" || word == "0" ? "RAS" : "";
}

void add_point(const Table& table, const Table::Row& row, const std::array<std::size_t, 3>& at,
               std::optional<std::size_t> label, Points& points) {
  Vec3d p;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::optional<double> number =
        at[axis] < row.fields.size() ? number_in(row.fields[at[axis]], table.separator) : std::nullopt;
    if (!number || !std::isfinite(*number)) throw InvalidInput(table.place(row), "a point must have three numbers");
    p[axis] = *number;
  }
  points.places.push_back(p);
  if (label && *label < row.fields.size()) points.labels.push_back(row.fields[*label]);
}

// Returns the value of a line "# NAME = VALUE" of an .fcsv file.
std::string fcsv_value(const std::string& bytes, std::string_view name) {
  for (const std::string& line : lines_of(bytes)) {
    const std::size_t equals = line.find('=');
    if (!line.starts_with('#') || equals == line.npos) continue;
    if (trimmed(std::string_view(line).substr(1, equals - 1)) == name) return trimmed(line.substr(equals + 1));
  }
  return {};
}

Points read_table_points(const std::string& path) {
  const std::string bytes = read_text(path);
  Table table = read_table(path);
  Points points;
  if (path.ends_with(".fcsv")) {
    points.system = system_of(fcsv_value(bytes, "CoordinateSystem"));
    const std::string columns = fcsv_value(bytes, "columns");
    table.names = fields_of(columns.empty() ? "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label" : columns, ',');
  }
  const auto at =
      table.names.empty() ? std::optional(first_columns<3>()) : columns_named<3>(table.names, {"x", "y", "z"});
  if (!at) throw InvalidInput(Place{path, 1}, "no columns are named x, y and z; name them so");
  const auto named = columns_named<1>(table.names, {"label"});
  for (const Table::Row& row : table.rows) {
    add_point(table, row, *at, named ? std::optional(named->front()) : std::nullopt, points);
  }
  return points;
}

Points read_slicer_json(const std::string& path) {
  Points points;
  try {
    const Json file = parse_json(read_text(path));
    const Json& markups = file.at("markups").items().at(0);
    if (const Json* system = markups.find("coordinateSystem")) points.system = system_of(system->text());
    for (const Json& point : markups.at("controlPoints").items()) {
      const std::vector<Json>& position = point.at("position").items();
      points.places.push_back({position.at(0).number(), position.at(1).number(), position.at(2).number()});
      if (const Json* label = point.find("label")) points.labels.push_back(label->text());
    }
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw InvalidInput(Place{path}, fmt::format("is no markups file of 3D Slicer: {}", error.what()));
  }
  return points;
}

bool is_slicer_file(const std::string& path) { return path.ends_with(".fcsv") || path.ends_with(".json"); }

Points points_of(const std::string& path) {
  Points points = path.ends_with(".json") ? read_slicer_json(path) : read_table_points(path);
  if (points.places.empty()) throw InvalidInput(Place{path}, "it holds no point; give 1 or more");
  if (points.labels.size() != points.places.size()) points.labels.clear();
  return points;
}

// The points of `target` in the order of the labels of `source`, if both have the same ones, each once.
bool sort_by_labels(const Points& source, Points& target) {
  if (source.labels.empty() || source.labels.size() != target.labels.size()) return false;
  std::map<std::string, Vec3d> by_label;
  for (std::size_t i = 0; i < target.labels.size(); ++i) by_label[target.labels[i]] = target.places[i];
  if (by_label.size() != source.labels.size()) return false;
  std::vector<Vec3d> sorted;
  for (const std::string& label : source.labels) {
    const auto found = by_label.find(label);
    if (found == by_label.end()) return false;
    sorted.push_back(found->second);
  }
  target.places = std::move(sorted);
  return true;
}

double mean_square(const LandmarkPairs& pairs, const Vec3d& signs) {
  double sum = 0;
  for (std::size_t i = 0; i < pairs.source.size(); ++i) {
    const Vec3d& p = pairs.source[i];
    sum += norm2(pairs.target[i] - Vec3d{signs.x * p.x, signs.y * p.y, signs.z * p.z});
  }
  return sum / static_cast<double>(pairs.source.size());
}

}  // namespace

std::optional<double> number_in(std::string field, char separator) {
  if (separator != ',') std::replace(field.begin(), field.end(), ',', '.');
  if (field.starts_with('+')) field.erase(0, 1);
  double number = 0;
  const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), number);
  if (field.empty() || error != std::errc{} || stop != field.data() + field.size()) return std::nullopt;
  return number;
}

Table read_table(const std::string& path) {
  Table table;
  table.path = path;
  std::size_t number = 0;
  bool is_first = true;
  for (const std::string& line : lines_of(read_text(path))) {
    ++number;
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    if (is_first) table.separator = line.find(';') != line.npos ? ';' : (line.find('\t') != line.npos ? '\t' : ',');
    Fields fields = fields_of(line, table.separator);
    while (fields.size() > 1 && fields.back().empty() && is_first) fields.pop_back();
    const auto is_number = [&](const std::string& field) { return number_in(field, table.separator).has_value(); };
    if (is_first && std::none_of(fields.begin(), fields.end(), is_number)) {
      table.names = std::move(fields);
    } else {
      table.rows.push_back({number, std::move(fields)});
    }
    is_first = false;
  }
  return table;
}

LandmarkPairs read_pairs(const std::string& path, const Mesh& source, const Mesh& target) {
  if (is_slicer_file(path)) {
    throw InvalidInput(Place{path}, "holds the points of one shape; give those of the target with --target-landmarks");
  }
  Table table = read_table(path);
  const std::size_t columns = table.rows.empty() ? 0 : table.rows.front().fields.size();
  if (table.names.empty() && columns == 7) {
    table.names.assign(kPlaces.begin(), kPlaces.end());
    table.names.emplace_back(kTolerance);
  }
  auto places = columns_named(table.names, kPlaces);
  auto vertices = columns_named(table.names, kVertices);
  if (table.names.empty() && columns == 6) places = first_columns<6>();
  if (table.names.empty() && columns == 2) vertices = first_columns<2>();
  if (!places && !vertices) throw InvalidInput(Place{path, 1}, std::string(kHeaders));
  const auto tolerance = columns_named<1>(table.names, {std::string(kTolerance)});
  LandmarkPairs pairs;
  for (const Table::Row& row : table.rows) {
    pairs.tolerance.push_back(tolerance ? tolerance_of(table, row, tolerance->front()) : 0);
    if (places) {
      const auto n = numbers_of(table, row, *places, "six numbers, three of the source and three of the target");
      pairs.source.push_back({n[0], n[1], n[2]});
      pairs.target.push_back({n[3], n[4], n[5]});
      continue;
    }
    constexpr std::string_view what = "two whole numbers, from 0 on";
    const auto n = numbers_of(table, row, *vertices, what);
    if (std::any_of(n.begin(), n.end(), [](double number) { return number < 0 || number != std::floor(number); })) {
      throw InvalidInput(table.place(row), fmt::format("a pair must be {}", what));
    }
    pairs.source.push_back(vertex_of(source, n[0], table.place(row), kVertices[0]));
    pairs.target.push_back(vertex_of(target, n[1], table.place(row), kVertices[1]));
  }
  if (pairs.source.empty()) throw InvalidInput(Place{path}, "it holds no pair; give 1 or more");
  remove_repeated(pairs);
  return pairs;
}

LandmarkPairs read_points(const std::string& source, const std::string& target) {
  const Points from = points_of(source);
  Points to = points_of(target);
  LandmarkPairs pairs;
  const bool by_labels = sort_by_labels(from, to);
  if (from.places.size() != to.places.size()) {
    throw InvalidInput(Place{target}, fmt::format("has {} points, but {} has {}; give as many of both",
                                                  to.places.size(), source, from.places.size()));
  }
  pairs.source = from.places;
  pairs.target = to.places;
  pairs.tolerance.assign(pairs.source.size(), 0);
  if (!by_labels && !from.labels.empty()) {
    pairs.notes.emplace_back("the points of both files have other labels; they belong together by their order");
  }
  if (!from.system.empty() && !to.system.empty() && from.system != to.system) {
    std::vector<Vec3d>& turned = from.system == "RAS" ? pairs.source : pairs.target;
    for (Vec3d& p : turned) p = {-p.x, -p.y, p.z};
    pairs.notes.push_back(
        fmt::format("{} is in RAS and the other file in LPS; x and y of its points change their signs",
                    from.system == "RAS" ? source : target));
  }
  remove_repeated(pairs);
  return pairs;
}

void check_frames(const LandmarkPairs& pairs, const std::string& path, double diagonal) {
  Vec3d shift{0, 0, 0};
  for (std::size_t i = 0; i < pairs.source.size(); ++i) shift += pairs.target[i] - pairs.source[i];
  shift = shift / static_cast<double>(pairs.source.size());
  constexpr double far = 2;  // diagonals
  if (norm(shift) > far * diagonal) {
    throw InvalidInput(Place{path},
                       fmt::format("the target's landmarks lie {:.3g} away from the source's, {:.2g} times its "
                                   "diagonal; move the source by ({:.6g}, {:.6g}, {:.6g}) first",
                                   norm(shift), norm(shift) / diagonal, shift.x, shift.y, shift.z));
  }
  constexpr std::size_t fewest = 4;
  const double as_they_are = mean_square(pairs, {1, 1, 1});
  constexpr double near = 0.1;       // diagonals
  constexpr double better = 0.0625;  // of the mean square
  if (pairs.source.size() < fewest || as_they_are < near * near * diagonal * diagonal) return;
  for (int mask = 1; mask < 8; ++mask) {
    const Vec3d signs{(mask & 1) != 0 ? -1.0 : 1.0, (mask & 2) != 0 ? -1.0 : 1.0, (mask & 4) != 0 ? -1.0 : 1.0};
    if (mean_square(pairs, signs) > better * as_they_are) continue;
    std::string axes;
    for (int axis = 0; axis < 3; ++axis) {
      if ((mask >> axis & 1) != 0) axes += fmt::format("{}{}", axes.empty() ? "" : ", ", "xyz"[axis]);
    }
    throw InvalidInput(Place{path},
                       fmt::format("the target's landmarks are the source's with the opposite sign of {}{}; "
                                   "change the signs of one shape and its landmarks",
                                   axes, mask == 3 ? ", as between RAS and LPS" : ""));
  }
}

}  // namespace knead::command
