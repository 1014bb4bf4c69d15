// What the tests of the live view share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/vec.h"
#include "support/pictures.h"

namespace knead::render {

inline constexpr int kWidth = 240;
inline constexpr int kHeight = 200;

inline int largest_difference(const Image& a, const Image& b) {
  int worst = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) worst = std::max(worst, std::abs(a.pixels[i] - b.pixels[i]));
  return worst;
}

// Pixels that differ by more than `step` in any channel.
inline int different_pixels(const Image& a, const Image& b, int step = 2) {
  int count = 0;
  for (std::size_t i = 0; i < a.pixels.size(); i += 4) {
    bool differs = false;
    for (std::size_t k = i; k < i + 4; ++k) differs = differs || std::abs(a.pixels[k] - b.pixels[k]) > step;
    count += differs ? 1 : 0;
  }
  return count;
}

inline double mean_brightness(const Image& image) {
  double sum = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) sum += i % 4 < 3 ? image.pixels[i] : 0;
  return sum / (0.75 * static_cast<double>(image.pixels.size()));
}

// On a background of one colour, from the front.
inline LiveScene scene_of(const Mesh& mesh, Projection projection = Projection::orthographic) {
  LiveScene scene;
  scene.background_top = scene.background_bottom = {0, 0, 1, 1};
  scene.camera = fit_camera(bounding_box(mesh.positions), {0, 0, -1}, {0, 1, 0}, 1.2, {projection, 25, 0.1});
  return scene;
}

inline bool is_background(const Pixel& p) { return p.red == 0 && p.green == 0 && p.blue == 255; }

inline int covered_pixels(const Image& image) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) count += is_background(at(image, x, y)) ? 0 : 1;
  }
  return count;
}

class LiveViewTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!no_context().empty()) GTEST_SKIP() << no_context();
    context_ = std::make_unique<gl::OffscreenContext>();
    view_ = std::make_unique<LiveView>(1);
  }
  void TearDown() override {
    view_.reset();
    context_.reset();
  }

  Image picture(const LiveScene& scene) { return view_->picture(scene, kWidth, kHeight); }
  Image picture_of(const Mesh& mesh, const LiveScene& scene) {
    view_->set_shape(mesh);
    return picture(scene);
  }

  std::unique_ptr<gl::OffscreenContext> context_;
  std::unique_ptr<LiveView> view_;
};

}  // namespace knead::render
