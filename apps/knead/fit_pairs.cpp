#include "fit_pairs.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>
#include <system_error>

#include "knead/math/error.h"

namespace knead::command {
namespace {

constexpr std::string_view kPlaces = "source_x,source_y,source_z,target_x,target_y,target_z";
constexpr std::string_view kVertices = "source_vertex,target_vertex";

std::string without_blanks(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c != ' ' && c != '\t' && c != '\r') result += c;
  }
  return result;
}

// The numbers of one line.
template <class T, std::size_t count>
std::array<T, count> numbers_of(const std::string& line, const Place& place, std::string_view what) {
  std::array<T, count> numbers{};
  const char* at = line.data();
  const char* const end = at + line.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto [stop, error] = std::from_chars(at, end, numbers[i]);
    const bool is_last = i + 1 == count;
    if (error != std::errc{} || (is_last ? stop != end : stop == end || *stop != ',')) {
      throw InvalidInput(place, fmt::format("a pair must be {}, separated by commas", what));
    }
    at = stop + 1;
  }
  return numbers;
}

const Vec3d& vertex_of(const Mesh& mesh, std::uint64_t number, const Place& place, std::string_view name) {
  if (number < mesh.vertex_count()) return mesh.positions[number];
  throw InvalidInput(
      place, fmt::format("\"{}\" must be a vertex from 0 to {}, got {}", name, mesh.vertex_count() - 1, number));
}

void add_places(const std::string& line, const Place& place, LandmarkPairs& pairs) {
  const auto n = numbers_of<double, 6>(line, place, "six numbers");
  for (const double number : n) {
    if (!std::isfinite(number)) throw InvalidInput(place, "a coordinate is not finite; give a number");
  }
  pairs.source.push_back({n[0], n[1], n[2]});
  pairs.target.push_back({n[3], n[4], n[5]});
}

void add_vertices(const std::string& line, const Place& place, const Mesh& source, const Mesh& target,
                  LandmarkPairs& pairs) {
  const auto n = numbers_of<std::uint64_t, 2>(line, place, "two whole numbers, from 0 on");
  pairs.source.push_back(vertex_of(source, n[0], place, "source_vertex"));
  pairs.target.push_back(vertex_of(target, n[1], place, "target_vertex"));
}

}  // namespace

LandmarkPairs read_pairs(const std::string& path, const Mesh& source, const Mesh& target) {
  std::ifstream file(path);
  if (!file) {
    throw IoError(IoError::Operation::read, path, "cannot be read: " + std::generic_category().message(errno));
  }
  std::string line;
  Place place{path, 1};
  std::getline(file, line);
  const std::string header = without_blanks(line);
  if (header != kPlaces && header != kVertices) {
    throw InvalidInput(place, fmt::format("the first line must be {} or {}", kPlaces, kVertices));
  }
  LandmarkPairs pairs;
  while (std::getline(file, line)) {
    ++place.line;
    const std::string pair = without_blanks(line);
    if (pair.empty()) continue;
    if (header == kPlaces) {
      add_places(pair, place, pairs);
    } else {
      add_vertices(pair, place, source, target, pairs);
    }
  }
  if (file.bad()) throw IoError(IoError::Operation::read, path, "cannot be read to its end");
  if (pairs.source.empty()) throw InvalidInput(Place{path}, "it holds no pair; give 1 or more");
  return pairs;
}

}  // namespace knead::command
