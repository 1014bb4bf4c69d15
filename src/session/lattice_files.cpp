// Files of other programs with lattices: PyGeM's parameters of a free-form deformation (.prm), an INI file with the
// box, and the displacements of control points as multiples of the box's edges.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/text.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/stroke.h"
#include "knead/vec.h"
#include "session/stroke_run.h"
#include "strokes/describe.h"

namespace knead::detail {

namespace {

constexpr std::string_view kSpaces = " \t\r";

std::string_view without_spaces(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

// Returns the numbers of a line; nothing if there is anything else.
std::optional<std::vector<double>> numbers_of(std::string_view line) {
  std::vector<double> numbers;
  while (!line.empty()) {
    const std::string_view word = line.substr(0, line.find_first_of(kSpaces));
    line = without_spaces(line.substr(word.size()));
    double& number = numbers.emplace_back();
    const bool is_read = parse_real(word, number) == ParseResult::ok;
    if (!is_read || !std::isfinite(number)) return std::nullopt;
  }
  return numbers;
}

// The keys of the file in small letters, with the lines of their values. A line that begins with a space goes on with
// the value before.
class PrmFile {
 public:
  explicit PrmFile(std::string_view text) {
    while (!text.empty()) {
      const std::string_view line = text.substr(0, text.find('\n'));
      text.remove_prefix(std::min(line.size() + 1, text.size()));
      const std::string_view words = without_spaces(line);
      if (words.empty() || words.front() == '#' || words.front() == ';' || words.front() == '[') continue;
      if (kSpaces.find(line.front()) != std::string_view::npos && !entries_.empty()) {
        entries_.back().second.push_back(words);
        continue;
      }
      const std::size_t colon = words.find_first_of(":=");
      if (colon == std::string_view::npos) {
        throw InvalidInput(fmt::format("\"{}\" is neither a section, a comment nor \"key: value\"", words));
      }
      entries_.push_back({lower(without_spaces(words.substr(0, colon))), {}});
      const std::string_view first = without_spaces(words.substr(colon + 1));
      if (!first.empty()) entries_.back().second.push_back(first);
    }
  }

  const std::vector<std::string_view>& lines(std::string_view key) const {
    for (const auto& [name, lines] : entries_) {
      if (name == key) return lines;
    }
    throw InvalidInput(fmt::format("\"{}\" is missing; these are no parameters of PyGeM's FFD", key));
  }

  Vec3d vector(const std::string& key) const {
    Vec3d result;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name = key + " " + "xyz"[axis];
      const std::vector<std::string_view>& own = lines(name);
      const auto numbers = own.size() == 1 ? numbers_of(own.front()) : std::nullopt;
      if (!numbers || numbers->size() != 1) throw InvalidInput(fmt::format("\"{}\" must be one number", name));
      result[axis] = numbers->front();
    }
    return result;
  }

 private:
  std::vector<std::pair<std::string, std::vector<std::string_view>>> entries_;
};

// The rows are the edges' directions: the columns of the product of rotations about x, y and z, of which that about z
// acts first.
Mat3d axes_of(const Vec3d& degrees) {
  const SinCos<double> x = sincos(degrees.x * kRadiansPerDegree);
  const SinCos<double> y = sincos(degrees.y * kRadiansPerDegree);
  const SinCos<double> z = sincos(degrees.z * kRadiansPerDegree);
  const Mat3d product = Mat3d{{1, 0, 0}, {0, x.cos, -x.sin}, {0, x.sin, x.cos}} *
                        Mat3d{{y.cos, 0, y.sin}, {0, 1, 0}, {-y.sin, 0, y.cos}} *
                        Mat3d{{z.cos, -z.sin, 0}, {z.sin, z.cos, 0}, {0, 0, 1}};
  return {product.column(0), product.column(1), product.column(2)};
}

// Reads the weights of one axis, a multiple of its edge each; of two for a control point the last counts.
void read_weights(const PrmFile& file, std::size_t axis, const std::array<int, 3>& counts, std::vector<Vec3d>& to) {
  const std::string key = std::string("parameter ") + "xyz"[axis];
  for (const std::string_view line : file.lines(key)) {
    const std::optional<std::vector<double>> numbers = numbers_of(line);
    bool is_valid = numbers && numbers->size() == 4;
    for (std::size_t i = 0; i < 3 && is_valid; ++i) {
      const double index = (*numbers)[i];
      is_valid = index >= 0 && index < counts[i] && index == std::floor(index);
    }
    if (!is_valid) {
      throw InvalidInput(fmt::format(
          "\"{}\" must have three indices of a control point, from 0 on, and a weight in each line, got \"{}\"", key,
          line));
    }
    const auto index = [&](std::size_t i) { return static_cast<std::size_t>((*numbers)[i]); };
    const auto count = [&](std::size_t i) { return static_cast<std::size_t>(counts[i]); };
    to[(index(0) * count(1) + index(1)) * count(2) + index(2)][axis] = (*numbers)[3];
  }
}

LatticeStroke read_prm(std::string_view text) {
  const PrmFile file(text);
  LatticeStroke stroke;
  const Vec3d counts = file.vector("n control points");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double count = counts[axis];
    constexpr int kMaxPrmCount = LatticeMotion::kMaxDegree + 1;
    if (!(count >= 2 && count <= kMaxPrmCount && count == std::floor(count))) {
      throw InvalidInput(
          fmt::format("\"n control points\" must be whole numbers from 2 to {}, got {:g}", kMaxPrmCount, count));
    }
    stroke.counts[axis] = static_cast<int>(count);
  }
  stroke.lengths = file.vector("box length");
  stroke.origin = file.vector("box origin");
  stroke.axes = axes_of(file.vector("rotation angle"));
  stroke.displacements.resize(static_cast<std::size_t>(counts.x * counts.y * counts.z));
  for (std::size_t axis = 0; axis < 3; ++axis) read_weights(file, axis, stroke.counts, stroke.displacements);
  for (Vec3d& d : stroke.displacements) {
    d = stroke.axes.row0 * (d.x * stroke.lengths.x) + stroke.axes.row1 * (d.y * stroke.lengths.y) +
        stroke.axes.row2 * (d.z * stroke.lengths.z);
  }
  return stroke;
}

}  // namespace

LatticeStroke with_file(const LatticeStroke& stroke, const std::filesystem::path& folder) {
  try {
    LatticeStroke result = read_prm(read_text(folder / stroke.file));
    result.mode = stroke.mode;
    validate(result);
    return result;
  } catch (const std::exception& error) {
    throw InvalidInput(fmt::format("\"file\": {}: {}", stroke.file, error.what()));
  }
}

}  // namespace knead::detail
