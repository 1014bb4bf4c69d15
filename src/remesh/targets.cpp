// Validates the settings of a remesh and chooses its targets from the lengths of the edges.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/vec.h"
#include "remesh/patch.h"

namespace knead {

namespace {

void require(bool good, const char* key, const std::string& expected, double value) {
  if (good) return;
  throw InvalidInput("\"" + std::string(key) + "\" must be " + expected + ", got " + std::to_string(value));
}

void require_length(const std::optional<double>& value, const char* key) {
  if (value) require(std::isfinite(*value) && *value > 0, key, "a length greater than 0", *value);
}

// Lengths in any order, in as many lists as chunks of work.
using LengthLists = std::vector<std::vector<double>>;

// Returns the mean of lengths, which are at most `max` up to rounding, with the same bits for every order: rounds them
// to multiples of 2^-61 of a power of two above `max`, and sums whole numbers.
double mean_of(const LengthLists& lengths, std::size_t count, double max) {
  const int scale = 61 - std::ilogb(max);
  const double part = std::scalbn(1.0, scale / 2);  // in two parts neither overflows
  const double rest = std::scalbn(1.0, scale - scale / 2);
  std::uint64_t high = 0;  // of the sum, in 2^32
  std::uint64_t low = 0;
  for (const std::vector<double>& some : lengths) {
    for (const double length : some) {
      const auto whole = static_cast<std::uint64_t>(length * part * rest);
      high += whole >> 32;
      low += whole & 0xffffffffU;
    }
  }
  const double sum = std::ldexp(static_cast<double>(high), 32) + static_cast<double>(low);
  return std::scalbn(sum / static_cast<double>(count), -scale);
}

// Returns the number at this index of the sorted numbers, all 0 or more. Sorts only those with the same leading bits.
double nth_of(const LengthLists& numbers, std::size_t index) {
  constexpr int shift = 48;
  const auto first_bits = [](double x) { return bit_cast<std::uint64_t>(x) >> shift; };
  std::vector<std::size_t> counts(std::size_t{1} << (64 - shift), 0);
  for (const std::vector<double>& some : numbers) {
    for (const double x : some) ++counts[first_bits(x)];
  }
  std::size_t bits = 0;
  for (; index >= counts[bits]; ++bits) index -= counts[bits];
  std::vector<double> found;
  found.reserve(counts[bits]);
  for (const std::vector<double>& some : numbers) {
    std::copy_if(some.begin(), some.end(), std::back_inserter(found), [&](double x) { return first_bits(x) == bits; });
  }
  const auto at = found.begin() + static_cast<std::ptrdiff_t>(index);
  std::nth_element(found.begin(), at, found.end());
  return *at;
}

// Calls visit(low, high) for each side of each face.
template <class Visit>
void for_each_side(const Mesh& mesh, Visit visit) {
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    std::uint32_t a = face.empty() ? 0 : face.back();
    for (const std::uint32_t b : face) {
      if (a != b) visit(std::min(a, b), std::max(a, b));
      a = b;
    }
  }
}

// Moves one of each number to the front, in any order. Returns their count.
std::size_t unique_to_front(std::span<std::uint32_t> numbers) {
  constexpr std::size_t kMaxUnsorted = 32;
  if (numbers.size() > kMaxUnsorted) {
    std::sort(numbers.begin(), numbers.end());
    return static_cast<std::size_t>(std::unique(numbers.begin(), numbers.end()) - numbers.begin());
  }
  std::size_t count = 0;
  for (const std::uint32_t number : numbers) {
    const auto end = numbers.begin() + static_cast<std::ptrdiff_t>(count);
    if (std::find(numbers.begin(), end, number) == end) numbers[count++] = number;
  }
  return count;
}

// Returns the lengths of all edges.
LengthLists edge_lengths(const Mesh& mesh, int threads) {
  constexpr std::size_t grain = 8192;                          // vertices
  std::vector<std::uint32_t> end(mesh.vertex_count() + 1, 0);  // of the larger ends of each vertex's sides; one before
  for_each_side(mesh, [&](std::uint32_t low, std::uint32_t) { ++end[low + std::size_t{1}]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<std::uint32_t> high(end.back());
  for_each_side(mesh, [&](std::uint32_t low, std::uint32_t other) { high[end[low]++] = other; });
  LengthLists lengths(mesh.vertex_count() / grain + 1);
  parallel_for(mesh.vertex_count(), grain, threads, [&](std::size_t first, std::size_t last) {
    std::vector<double>& own = lengths[first / grain];
    std::size_t begin = first == 0 ? 0 : end[first - 1];
    own.reserve(end[last - 1] - begin);
    for (std::size_t v = first; v < last; ++v) {
      const std::span<std::uint32_t> ends = std::span(high).subspan(begin, end[v] - begin);
      for (const std::uint32_t w : ends.first(unique_to_front(ends))) {
        own.push_back(norm(mesh.positions[w] - mesh.positions[v]));
      }
      begin = end[v];
    }
  });
  return lengths;
}

}  // namespace

void validate(const RemeshSettings& settings) {
  require_length(settings.max_edge, "max_edge");
  if (settings.max_angle_deg) {
    const double angle = *settings.max_angle_deg;
    require(angle > 0 && angle <= 180, "max_angle_deg", "an angle greater than 0 and at most 180", angle);
  }
  if (settings.max_chord) {
    const double chord = *settings.max_chord;
    require(chord > 0 && chord < 1, "max_chord", "a fraction of the box diagonal between 0 and 1", chord);
  }
  if (settings.min_edge) {
    require(std::isfinite(*settings.min_edge) && *settings.min_edge >= 0, "min_edge", "a length of 0 or more",
            *settings.min_edge);
  }
  if (settings.iterations) {
    require(*settings.iterations >= 0 && *settings.iterations <= 100, "iterations", "a whole number from 0 to 100",
            *settings.iterations);
  }
  if (settings.max_vertices) {
    require(*settings.max_vertices >= 1 && *settings.max_vertices <= kMaxVertices, "max_vertices",
            "a whole number from 1 to " + std::to_string(kMaxVertices), static_cast<double>(*settings.max_vertices));
  }
  if (settings.min_edge && settings.max_edge) {
    require(*settings.min_edge <= 0.5 * *settings.max_edge, "min_edge", "at most half of \"max_edge\"",
            *settings.min_edge);
  }
}

RemeshTargets resolve(const RemeshSettings& settings, const Mesh& mesh) {
  validate(settings);
  validate(mesh);
  return detail::resolve_on(settings, mesh, 0);
}

RemeshTargets detail::resolve_on(const RemeshSettings& settings, const Mesh& mesh, int threads) {
  const double diagonal = shape_box(mesh).diagonal();
  RemeshTargets targets;
  targets.max_angle = settings.max_angle_deg.value_or(kDefaultMaxAngleDeg) * std::numbers::pi / 180;
  targets.max_chord = settings.max_chord.value_or(kDefaultMaxChord) * diagonal;
  targets.iterations = settings.iterations.value_or(kDefaultRemeshIterations);
  targets.max_vertices = settings.max_vertices.value_or(
      std::clamp(kDefaultGrowth * mesh.vertex_count(), kDefaultMaxVertices, kMaxVertices));
  targets.diagonal = diagonal;
  double mean = diagonal;
  double percentile_95 = diagonal;
  const LengthLists lengths = edge_lengths(mesh, threads);
  const std::size_t count = std::accumulate(lengths.begin(), lengths.end(), std::size_t{0},
                                            [](std::size_t sum, const auto& some) { return sum + some.size(); });
  if (count > 0 && diagonal > 0 && std::isfinite(diagonal)) {
    mean = mean_of(lengths, count, diagonal);
    percentile_95 = nth_of(lengths, count - 1 - count / 20);
  }
  targets.max_edge = settings.max_edge.value_or(2 * percentile_95);
  targets.min_edge = settings.min_edge.value_or(std::min(mean, targets.max_edge) / 4);
  if (!settings.max_edge) targets.max_edge = std::max(targets.max_edge, 2 * targets.min_edge);
  return targets;
}

}  // namespace knead
