// Pictures of Gaussian splats (Kerbl et al. 2023): projected, sorted and blended on the CPU.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "knead/editor/render.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "math/elementary.h"
#include "render/splat_attributes.h"

namespace knead::render {

namespace {

constexpr double kOpaque = 1e-4;  // light that passes
constexpr int kTile = 16;         // pixels
constexpr std::size_t kGrain = 4096;

// A splat in the picture: alpha exp(-(a dx^2 + 2 b dx dy + c dy^2) / 2).
struct Disc {
  double x = 0;
  double y = 0;
  double a = 0;
  double b = 0;
  double c = 0;
  double alpha = 0;
  double reach_x = 0;  // where it is no longer seen; 0: it is not seen
  double reach_y = 0;
  double depth = 0;
  std::array<float, 3> color{};
};

std::array<float, 3> color_of(const SplatAttributes& splats, std::size_t splat, const Vec3d& direction) {
  const std::array<double, 15> y = splat_harmonics(direction);
  std::array<float, 3> result{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    double sum = splats.base(splat, channel);
    for (std::size_t k = 0; k < splats.degree() * (splats.degree() + 2); ++k) {
      sum += y[k] * splats.harmonic(splat, channel, k);
    }
    result[channel] = static_cast<float>(std::max(0.0, sum));
  }
  return result;
}

class Projector {
 public:
  Projector(const Mesh& mesh, const Camera& camera, int width, int height)
      : mesh_(mesh),
        splats_(mesh),
        camera_(camera),
        frame_(camera_frame(camera)),
        distance_(norm(camera.target - camera.eye)),
        scale_(height / camera.height),
        center_x_(width * (1 + camera.shift_x) / 2),
        center_y_(height * (1 - camera.shift_y) / 2) {}

  Disc disc(std::size_t splat) const {
    Disc disc;
    const Vec3d from_eye = mesh_.positions[splat] - camera_.eye;
    const bool is_perspective = camera_.projection == Projection::perspective;
    disc.depth = dot(from_eye, frame_.forward);
    if (is_perspective && !(disc.depth > kNearestSplat * distance_)) return disc;
    const double scale = is_perspective ? scale_ * distance_ / disc.depth : scale_;
    const double right = dot(from_eye, frame_.right);
    const double up = dot(from_eye, frame_.up);
    disc.x = center_x_ + scale * right;
    disc.y = center_y_ - scale * up;
    // The rows of the projection's derivative.
    const Vec3d lean = is_perspective ? frame_.forward * (1 / disc.depth) : Vec3d{};
    const Vec3d across = (frame_.right - lean * right) * scale;
    const Vec3d down = (lean * up - frame_.up) * scale;
    double xx = kSplatBlur;
    double xy = 0;
    double yy = kSplatBlur;
    for (const Vec3d& axis : splats_.axes(splat)) {
      xx += dot(across, axis) * dot(across, axis);
      xy += dot(across, axis) * dot(down, axis);
      yy += dot(down, axis) * dot(down, axis);
    }
    set_shape(xx, xy, yy, splat, disc);
    if (disc.reach_x > 0) {
      disc.color = color_of(splats_, splat, is_perspective ? normalized(from_eye) : frame_.forward);
    }
    return disc;
  }

 private:
  void set_shape(double xx, double xy, double yy, std::size_t splat, Disc& disc) const {
    disc.alpha = splats_.opacity(splat);
    const double determinant = xx * yy - xy * xy;
    if (!(disc.alpha > kMinSplatAlpha) || !(determinant > 0) || !std::isfinite(determinant)) return;
    disc.a = yy / determinant;
    disc.b = -xy / determinant;
    disc.c = xx / determinant;
    const double reach = std::sqrt(2 * elementary::log(disc.alpha / kMinSplatAlpha));
    disc.reach_x = reach * std::sqrt(xx);
    disc.reach_y = reach * std::sqrt(yy);
  }

  const Mesh& mesh_;
  SplatAttributes splats_;
  const Camera& camera_;
  CameraFrame frame_;
  double distance_;
  double scale_;  // pixels for a unit at the target
  double center_x_;
  double center_y_;
};

// Returns the tiles of one side that a disc is seen in, as a range.
std::array<int, 2> tiles_of(double at, double reach, int size) {
  const int count = (size + kTile - 1) / kTile;
  const auto tile = [&](double x) { return static_cast<int>(std::clamp(std::floor(x / kTile), -1.0, double(count))); };
  return {std::max(0, tile(at - reach)), std::min(count, tile(at + reach) + 1)};
}

// Blends what is in one tile, from front to back.
void draw_tile(std::span<const Disc> discs, std::span<const std::uint32_t> seen, int first_x, int first_y,
               const Options& options, Image& image) {
  for (int y = first_y; y < std::min(first_y + kTile, image.height); ++y) {
    for (int x = first_x; x < std::min(first_x + kTile, image.width); ++x) {
      std::array<double, 3> sum{};
      double through = 1;
      for (const std::uint32_t i : seen) {
        const Disc& disc = discs[i];
        const double dx = x + 0.5 - disc.x;
        const double dy = y + 0.5 - disc.y;
        const double power = disc.a * dx * dx + 2 * disc.b * dx * dy + disc.c * dy * dy;
        const double alpha = std::min(kMaxSplatAlpha, disc.alpha * elementary::exp(-0.5 * power));
        if (!(alpha > kMinSplatAlpha)) continue;
        for (std::size_t k = 0; k < 3; ++k) sum[k] += through * alpha * disc.color[k];
        through *= 1 - alpha;
        if (through < kOpaque) break;
      }
      const double part = image.height > 1 ? static_cast<double>(y) / (image.height - 1) : 0;
      const Color& top = options.background;
      const Color bottom = options.background_bottom.value_or(top);
      const std::array<double, 3> behind{top.red + part * (bottom.red - top.red),
                                         top.green + part * (bottom.green - top.green),
                                         top.blue + part * (bottom.blue - top.blue)};
      const double covered = 1 - through * (1 - top.alpha);
      std::uint8_t* const pixel =
          &image.pixels[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                             static_cast<std::size_t>(x))];
      for (std::size_t k = 0; k < 3; ++k) {
        const double value = (sum[k] + through * top.alpha * behind[k]) / std::max(covered, kOpaque);
        pixel[k] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
      }
      pixel[3] = static_cast<std::uint8_t>(std::lround(255 * covered));
    }
  }
}

}  // namespace

Image render_splats(const Mesh& splats, const Camera& camera, const Options& options) {
  Image image{options.width, options.height, {}};
  image.pixels.resize(4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const Projector projector(splats, camera, image.width, image.height);
  std::vector<Disc> discs(splats.vertex_count());
  parallel_for(discs.size(), kGrain, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) discs[i] = projector.disc(i);
  });
  std::vector<std::uint32_t> order(discs.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return discs[a].depth < discs[b].depth; });
  const int columns = (image.width + kTile - 1) / kTile;
  const int rows = (image.height + kTile - 1) / kTile;
  std::vector<std::vector<std::uint32_t>> tiles(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (const std::uint32_t i : order) {
    if (!(discs[i].reach_x > 0)) continue;
    const auto [left, right] = tiles_of(discs[i].x, discs[i].reach_x, image.width);
    const auto [top, bottom] = tiles_of(discs[i].y, discs[i].reach_y, image.height);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x)
        tiles[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)].push_back(
            i);
    }
  }
  parallel_for(tiles.size(), 1, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const int tile = static_cast<int>(t);
      draw_tile(discs, tiles[t], tile % columns * kTile, tile / columns * kTile, options, image);
    }
  });
  if (options.progress) options.progress(1);
  return image;
}

}  // namespace knead::render
