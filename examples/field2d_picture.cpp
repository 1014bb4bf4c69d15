// Figure 3 of the paper, the field in the plane: field2d_picture FOLDER
//
// Writes height fields of p over the plane (y up), fig03a.ply in the inner and outer region only and fig03b.ply in all,
// coloured by region, and fig03c.jpg, v as line integral convolution (Cabral and Leedom, "Imaging vector fields using
// line integral convolution", SIGGRAPH 1993): white noise, averaged along the stream lines.
#include <knead/editor/render.h>
#include <knead/io.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "field2d.h"

namespace {

using Vec2d = knead::Vec2<double>;

// The paper's numbers: r = x^2 + y^2, so the regions' borders are circles of radius 1 and 2.
constexpr knead::Thresholds<double> kThresholds{1, 4};
constexpr double kInnerRadius = 1;
constexpr double kOuterRadius = 2;
constexpr double kShown = 2.4;  // half the width of what is drawn
const knead::Translation2d kMotion{{-0.8, 0.6}};

knead::Field2dValue<double> field_at(const Vec2d& d) {
  return knead::evaluate_2d(kMotion, knead::DiscRegion::squared_distance, kThresholds, d);
}

// --- p as a height field
// ----------------------------------------------------------------------------------------------

using Rgb = std::array<double, 3>;
constexpr Rgb kRed{222, 104, 90};
constexpr Rgb kClay{226, 205, 170};
constexpr Rgb kGreen{128, 186, 128};

// Adds the ring between two radii, with vertices of its own.
void add_ring(double from, double to, const Rgb& color, knead::Mesh& mesh) {
  constexpr std::uint32_t sides = 360;
  constexpr std::uint32_t bands = 60;
  const auto first = static_cast<std::uint32_t>(mesh.vertex_count());
  for (std::uint32_t j = 0; j <= bands; ++j) {
    const double radius = from + (to - from) * j / bands;
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      const Vec2d d{radius * std::cos(angle), radius * std::sin(angle)};
      // On its own side of a border where p jumps, in picture a.
      const double inside = std::clamp(radius, from + 1e-9, to - 1e-9) / std::max(radius, 1e-9);
      mesh.positions.push_back({d.x, field_at({d.x * inside, d.y * inside}).potential, -d.y});
      mesh.attributes.front().values.insert(mesh.attributes.front().values.end(), color.begin(), color.end());
    }
  }
  for (std::uint32_t j = 0; j < bands; ++j) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const std::uint32_t a = first + j * sides + i;
      const std::uint32_t b = first + j * sides + (i + 1) % sides;
      mesh.add_face(std::array{a, a + sides, b + sides, b});
    }
  }
}

knead::Mesh height_field(bool with_intermediate_region) {
  knead::Mesh mesh;
  mesh.attributes.push_back({"color", knead::Domain::vertex, knead::NumberType::uint8, 3, {}});
  add_ring(1e-3, kInnerRadius, kRed, mesh);
  if (with_intermediate_region) add_ring(kInnerRadius, kOuterRadius, kClay, mesh);
  add_ring(kOuterRadius, 1.25 * kShown, kGreen, mesh);
  return mesh;
}

// --- v as line integral convolution
// -----------------------------------------------------------------------------------

constexpr int kPixels = 480;
constexpr double kPixel = 2 * kShown / kPixels;  // its width in the plane
constexpr double kStep = 0.5 * kPixel;
constexpr int kSteps = 36;  // to each side

Vec2d place_of(double column, double row) { return {-kShown + column * kPixel, kShown - row * kPixel}; }

// From 0 to 1; the same at every run (a mixing function of two integers after Jenkins).
double noise_at(const Vec2d& d) {
  auto n = static_cast<std::uint32_t>((d.x + kShown) / kPixel) * 73856093u ^
           static_cast<std::uint32_t>((kShown - d.y) / kPixel) * 19349663u;
  n = (n ^ 61u) ^ (n >> 16u);
  n *= 9u;
  n ^= n >> 4u;
  n *= 0x27d4eb2du;
  n ^= n >> 15u;
  return (n & 0xffffu) / 65535.0;
}

Vec2d unit_velocity(const Vec2d& d) {
  const Vec2d v = field_at(d).velocity;
  const double speed = std::sqrt(v.x * v.x + v.y * v.y);
  return speed > 1e-12 ? Vec2d{v.x / speed, v.y / speed} : Vec2d{};
}

// One step along the stream line by the midpoint rule.
Vec2d follow(const Vec2d& d, double step) {
  const Vec2d k = unit_velocity(d);
  const Vec2d m = unit_velocity({d.x + 0.5 * step * k.x, d.y + 0.5 * step * k.y});
  return {d.x + step * m.x, d.y + step * m.y};
}

// The mean noise along the stream line through d, with its contrast brought back: the mean of n independent values
// varies by 1 / sqrt(n) of one.
double convolve(const Vec2d& d) {
  double sum = noise_at(d);
  for (const double step : {-kStep, kStep}) {
    Vec2d at = d;
    for (int i = 0; i < kSteps; ++i) {
      at = follow(at, step);
      sum += noise_at(at);
    }
  }
  const double mean = sum / (2 * kSteps + 1);
  return std::clamp(0.5 + (mean - 0.5) * std::sqrt(kSteps * kStep / kPixel), 0.0, 1.0);
}

// The colour of a point: the outer region, where v is zero, is white; the borders are lines.
Rgb color_at(const Vec2d& d) {
  const double radius = std::sqrt(d.x * d.x + d.y * d.y);
  if (std::abs(radius - kInnerRadius) < kPixel) return {200, 30, 25};
  if (std::abs(radius - kOuterRadius) < kPixel) return {30, 140, 60};
  if (radius > kOuterRadius) return {255, 255, 255};
  const double light = 0.25 + 0.75 * convolve(d);
  const Rgb& tint = radius < kInnerRadius ? Rgb{250, 216, 208} : Rgb{255, 248, 236};
  return {tint[0] * light, tint[1] * light, tint[2] * light};
}

knead::render::Image line_integral_convolution() {
  constexpr std::array<double, 2> samples{0.25, 0.75};  // 2 x 2 in each pixel
  knead::render::Image image{kPixels, kPixels, {}};
  for (int row = 0; row < kPixels; ++row) {
    for (int column = 0; column < kPixels; ++column) {
      Rgb sum{};
      for (const double x : samples) {
        for (const double y : samples) {
          const Rgb color = color_at(place_of(column + x, row + y));
          for (std::size_t i = 0; i < 3; ++i) sum[i] += color[i] / 4;
        }
      }
      for (const double value : sum) image.pixels.push_back(static_cast<std::uint8_t>(value + 0.5));
      image.pixels.push_back(255);
    }
  }
  return image;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw std::runtime_error("usage: field2d_picture FOLDER");
  const std::filesystem::path folder = argv[1];
  knead::write_mesh(folder / "fig03a.ply", height_field(false));
  knead::write_mesh(folder / "fig03b.ply", height_field(true));
  std::ofstream file(folder / "fig03c.jpg", std::ios::binary);
  file << knead::render::encode_jpeg(line_integral_convolution());
  if (!file.flush()) throw std::runtime_error((folder / "fig03c.jpg").string() + " could not be written");
} catch (const std::exception& error) {
  std::fprintf(stderr, "field2d_picture: %s\n", error.what());
  return 1;
}
