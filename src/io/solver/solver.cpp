// What the formats of solvers' meshes share: reading, writing, and the spelling of numbers.
#include "io/solver/solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "io/mesh_builder.h"
#include "knead/error.h"

namespace knead::detail::solver {
namespace {

constexpr double kFlat = 1e-6;  // of the diagonal of the box: how far a point may leave a plane that the file implies
constexpr std::size_t kLongestShortWord = 20;

bool is_binary(Spelling spelling) { return spelling == Spelling::float32 || spelling == Spelling::float64; }
bool is_field(Spelling spelling) { return spelling == Spelling::field_8 || spelling == Spelling::field_16; }
std::size_t field_width(Spelling spelling) { return spelling == Spelling::field_8 ? 8 : 16; }
NumberType number_type_of(Spelling spelling) {
  return spelling == Spelling::float32 ? NumberType::float32 : NumberType::float64;
}

// The number as C spells it: Fortran's D is E, and Nastran leaves it out before a sign.
std::string in_c(std::string_view word) {
  std::string text;
  for (const char c : word) {
    const bool is_exponent = c == 'd' || c == 'D' || c == 'e' || c == 'E';
    const bool is_bare_sign = (c == '+' || c == '-') && !text.empty() && text.back() != 'e';
    if (is_bare_sign) text += 'e';
    text += is_exponent ? 'e' : c;
  }
  return text;
}

// The coordinate of a text; an empty one is 0, as in Nastran and Abaqus.
double number_of(std::string_view word, std::string_view bytes, const std::string& name) {
  word = trimmed(word);
  if (word.empty()) return 0;
  double value = 0;
  if (parse_real(word, value) == ParseResult::malformed && parse_real(in_c(word), value) == ParseResult::ok &&
      std::isfinite(value)) {
    return value;
  }
  return TextCursor(bytes, name).coordinate(word);
}

double number_at(const PointSite& site, std::size_t axis, std::string_view bytes, const std::string& name) {
  const std::string_view word = site.words[axis];
  if (!is_binary(site.spelling)) return number_of(word, bytes, name);
  const double value = read_binary(word.data(), number_type_of(site.spelling), site.swapped);
  if (std::isfinite(value)) return value;
  fail_at_byte(name, static_cast<std::size_t>(word.data() - bytes.data()),
               "a coordinate is not finite; repair the file");
}

// As Nastran spells reals: with a point, without a zero before it, and a signed exponent without E.
std::string in_nastran(const std::string& number) {
  const std::size_t e = number.find('e');
  std::string mantissa = number.substr(0, e);
  const bool has_point = mantissa.find('.') != mantissa.npos;
  if (!has_point) mantissa += '.';
  while (has_point && mantissa.back() == '0') mantissa.pop_back();
  const std::size_t first = mantissa[0] == '-' ? 1 : 0;
  if (mantissa.size() > first + 2 && mantissa[first] == '0') mantissa.erase(first, 1);
  if (e == number.npos) return mantissa;
  const int exponent = std::atoi(number.c_str() + e + 1);
  return mantissa + fmt::format("{:+d}", exponent);
}

double read_back(const std::string& text) {
  double value = 0;
  parse_real(in_c(text), value);
  return value;
}

// The spelling that is nearest to the value among those of at most `width` characters, at least 8. `spell` turns C's
// spelling into the format's.
template <class Spell>
std::string fitted(double value, std::size_t width, const Spell& spell) {
  std::string text;
  append_real(text, value);
  std::string best = spell(text);
  if (best.size() <= width) return best;
  best.clear();
  for (const char* const form : {"{:.{}f}", "{:.{}e}"}) {
    for (int digits = static_cast<int>(width); digits >= 0; --digits) {
      const std::string candidate = spell(fmt::format(fmt::runtime(form), value, digits));
      if (candidate.size() > width) continue;
      const bool is_better = best.empty() || std::abs(read_back(candidate) - value) < std::abs(read_back(best) - value);
      if (is_better) best = candidate;
      break;
    }
  }
  return best;
}

// A number in a field, on the side on which the old one stands.
std::string in_field(const std::string& number, std::string_view old, std::size_t width) {
  const std::string blanks(width - number.size(), ' ');
  return !old.empty() && !is_blank(old[0]) ? number + blanks : blanks + number;
}

// The text that takes the place of a word.
std::string spelled(double value, const PointSite& site, std::size_t axis, std::optional<int> decimals) {
  std::string text;
  append_decimals(text, value, decimals);
  switch (site.spelling) {
    case Spelling::bulk_words:
      return in_nastran(text);
    case Spelling::field_8:
    case Spelling::field_16: {
      const std::size_t width = field_width(site.spelling);
      std::string number = in_nastran(text);
      if (number.size() > width) number = fitted(value, width, in_nastran);
      return in_field(number, site.words[axis], width);
    }
    case Spelling::short_words:
      return text.size() <= kLongestShortWord
                 ? text
                 : fitted(value, kLongestShortWord, [](const std::string& t) { return t; });
    case Spelling::columns: {
      text = fmt::format("{:.16e}", value);
      std::replace(text.begin(), text.end(), 'e', 'D');
      const std::size_t width = std::max(site.words[axis].size(), text.size() + 1);
      return std::string(width - text.size(), ' ') + text;
    }
    default:
      return text;
  }
}

void require_kept(std::size_t point, std::size_t dimensions, const Vec3d& p, double tolerance) {
  for (std::size_t axis = dimensions; axis < 3; ++axis) {
    if (std::abs(p[axis]) <= tolerance) continue;
    throw InvalidInput("the file has only " + std::to_string(dimensions) + " coordinates of point " +
                       std::to_string(point) + ", but it has left its plane; use strokes that keep " + "xyz"[axis] +
                       " = 0");
  }
}

void replace_text(Splice& splice, const PointSite& site, const Vec3d& from, const Vec3d& to,
                  std::optional<int> decimals) {
  for (std::size_t axis = 0; axis < site.dimensions; ++axis) {
    if (from[axis] == to[axis]) continue;
    const std::string text = spelled(to[axis], site, axis, decimals);
    if (read_back(std::string(trimmed(text))) != from[axis]) splice.replace_text(site.words[axis], text);
  }
}

// Reads the points, without faces.
void read(const Kind& kind, ShapeFile& shape, const std::string& name) {
  Layout layout{&kind};
  bool is_field_file = false;
  kind.scan(shape.bytes, name, [&](const PointSite& site) {
    Vec3d p{};
    for (std::size_t axis = 0; axis < site.dimensions; ++axis) p[axis] = number_at(site, axis, shape.bytes, name);
    if (shape.mesh.positions.size() == kMaxElements) {
      throw InvalidInput(Place{name}, "more than 4294967295 points; split the mesh");
    }
    shape.mesh.positions.push_back(p);
    layout.floats = layout.floats || site.spelling == Spelling::float32;
    is_field_file = is_field_file || is_field(site.spelling);
    layout.rounds = layout.rounds || is_field(site.spelling) || site.spelling == Spelling::short_words;
  });
  if (shape.mesh.positions.empty()) throw InvalidInput(Place{name}, "has no points; there is no shape in it");
  shape.notes.push_back(std::string("its points are read and moved; ") + kind.stays + " stay as they are");
  if (is_field_file) {
    shape.notes.emplace_back("coordinates that move are rounded to what fits into their fields of 8 or 16 characters");
  }
  set_layout(shape, layout);
}

// Replaces the coordinates that moved. Throws InvalidInput where a coordinate that the file lacks is no longer 0.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d>,
                    const WriteOptions& options) {
  const auto& layout = layout_of<Layout>(source);
  if (layout.floats) check_fits_floats(positions);
  Box box;
  for (const Vec3d& p : positions) box.extend(p);
  Splice splice(source.bytes, options.decimals);
  std::string binary;
  std::size_t point = 0;
  layout.kind->scan(source.bytes, source.format, [&](const PointSite& site) {
    const std::size_t i = point++;
    require_kept(i, site.dimensions, positions[i], kFlat * box.diagonal());
    const Vec3d& from = source.mesh.positions[i];
    if (!is_binary(site.spelling)) return replace_text(splice, site, from, positions[i], options.decimals);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (from[axis] == positions[i][axis]) continue;
      binary.clear();
      append_binary(binary, number_type_of(site.spelling), positions[i][axis], site.swapped);
      splice.replace_text(site.words[axis], binary);
    }
  });
  return splice.finish();
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  return {std::string(layout_of<Layout>(source).kind->stays) + " are left out"};
}

bool stores_floats(const ShapeFile& source) { return layout_of<Layout>(source).floats; }

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  layout_of<Layout>(source).kind->scan(source.bytes, source.format, [&](const PointSite& site) {
    if (is_binary(site.spelling)) return;
    for (std::size_t axis = 0; axis < site.dimensions; ++axis) visit(trimmed(site.words[axis]));
  });
}

constexpr std::array<std::string_view, 1> kFoamExtensions = {"points"};
constexpr std::array<std::string_view, 1> kNastranExtensions = {"nas"};

constexpr Kind kSu2{"su2", "elements and markers", scan_su2};
constexpr Kind kGmsh{"msh", "elements, groups and the geometry", scan_gmsh};
constexpr Kind kFoam{"foam", "faces and cells, in other files,", scan_foam, kFoamExtensions};
constexpr Kind kNastran{"bdf", "all cards but GRID", scan_nastran, kNastranExtensions};
constexpr Kind kAbaqus{"inp", "all keywords but *NODE", scan_abaqus};
constexpr Kind kUnv{"unv", "all datasets but 2411", scan_unv};

template <const Kind& kind>
constexpr Codec codec_of() {
  return {.name = kind.format,
          .extensions = kind.extensions,
          .read = [](ShapeFile& shape, const std::string& name) { read(kind, shape, name); },
          .rewrite = rewrite,
          .source_losses = source_losses,
          .stores_floats = stores_floats,
          .visit_coordinates = visit_coordinates};
}

}  // namespace

bool Lines::next() {
  if (next_ >= bytes_.size()) return false;
  const std::size_t end = std::min(bytes_.find_first_of("\r\n", next_), bytes_.size());
  line_ = bytes_.substr(next_, end - next_);
  next_ = end + (bytes_.substr(end, 2) == "\r\n" ? 2 : 1);
  return true;
}

double Lines::number(std::string_view word) const { return number_of(word, bytes_, name_); }

void Lines::fail(const std::string& what) const {
  fail_at_line(name_, bytes_, static_cast<std::size_t>(line_.data() - bytes_.data()), what);
}

PointSite words_from(std::string_view first, std::size_t dimensions, TextCursor& text) {
  PointSite site;
  site.dimensions = dimensions;
  site.words[0] = first;
  for (std::size_t axis = 0; axis < dimensions; ++axis) {
    if (axis > 0) site.words[axis] = text.next_on_line();
    if (site.words[axis].empty()) text.coordinate({});  // fails
  }
  return site;
}

void require_room(std::size_t points, std::size_t left, std::size_t bytes_for_each, const TextCursor& text) {
  if (points > left / bytes_for_each + 1) text.fail(too_many(std::to_string(points) + " points", left));
}

}  // namespace knead::detail::solver

namespace knead::detail {

const Codec su2_codec = solver::codec_of<solver::kSu2>();
const Codec gmsh_codec = solver::codec_of<solver::kGmsh>();
const Codec foam_codec = solver::codec_of<solver::kFoam>();
const Codec nastran_codec = solver::codec_of<solver::kNastran>();
const Codec abaqus_codec = solver::codec_of<solver::kAbaqus>();
const Codec unv_codec = solver::codec_of<solver::kUnv>();

}  // namespace knead::detail
