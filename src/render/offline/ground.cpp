// The soft shadow on the ground.
#include <array>

#include "knead/error.h"
#include "math/system.h"
#include "render/offline/shade.h"

namespace knead::render {

// Returns false if shapes hide the ground from all samples of a texel.
bool Ground::sees_ground(int x, int y) const {
  for (int j = y * step_; j < std::min((y + 1) * step_, drawn_.pass.height); ++j) {
    for (int i = x * step_; i < std::min((x + 1) * step_, drawn_.pass.width); ++i) {
      if (drawn_.depth_at(i, j) == 1) return true;
    }
  }
  return false;
}

// Returns the place of the ground that a texel shows.
std::optional<Vec3f> Ground::ground_at(int x, int y) const {
  const float across = center(x) * static_cast<float>(step_);
  const float along = center(y) * static_cast<float>(step_);
  const Vec3f origin = drawn_.rays.origin(across, along);
  const Vec3f ray = drawn_.rays.direction(across, along);
  const float down = dot(up_, ray);
  const float t = (static_cast<float>(drawn_.lighting.occluder.ground) - dot(up_, origin)) / down;
  if (down > -1e-4F || t <= 0) return std::nullopt;
  return origin + ray * t;
}

// Texels that are lit together, and the light that they lack.
struct Ground::Batch {
  MapPlaces places{};
  std::array<std::size_t, kLanes> texels{};
  std::size_t count = 0;
  Lane missing{};
  Lane distance{};
};

KNEAD_CLONES void Ground::add_missing(float weight, Batch& batch) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    const auto nearest = static_cast<float>(batch.places.nearest[i]);
    const float gap = batch.places.depth[i] - nearest;
    const float missing = gap > 0 && nearest < 65535 ? weight : 0;
    batch.missing[i] += missing;
    batch.distance[i] += missing * gap;
  }
}

void Ground::shade(Batch& batch) {
  batch.missing = batch.distance = {};
  for (std::size_t l = 0; l < weights_.size(); ++l) {
    if (weights_[l] == 0) continue;
    look_up(drawn_.matrices[l], drawn_.map(l), batch.places);
    add_missing(weights_[l], batch);
  }
  const auto range = static_cast<float>(2 * drawn_.lighting.occluder.radius / 65535);
  for (std::size_t i = 0; i < batch.count; ++i) {
    missing_[batch.texels[i]] = batch.missing[i];
    distance_[batch.texels[i]] = batch.distance[i] * range;
  }
  batch.count = 0;
}

// In blocks, because texels near each other are near each other in the lights' maps.
void Ground::shade_rows(int first, int last) {
  constexpr int block = 16;
  Batch batch;
  for (int left = 0; left < width_; left += block) {
    for (int y = first; y < last; ++y) {
      for (int x = left; x < std::min(left + block, width_); ++x) {
        const std::size_t texel = index(x, y);
        missing_[texel] = sees_ground(x, y) ? 0 : kUnseen;
        const std::optional<Vec3f> ground = is_seen(texel) ? ground_at(x, y) : std::nullopt;
        if (!ground) continue;
        const Vec3f p = *ground + up_ * drawn_.lift;
        for (std::size_t k = 0; k < 3; ++k) batch.places.q[k][batch.count] = p[k];
        batch.texels[batch.count++] = texel;
        if (batch.count == kLanes) shade(batch);
      }
    }
  }
  shade(batch);
}

// Taps on a spiral in the unit circle, and their weights.
constexpr std::size_t kTaps = 64;
struct Spiral {
  std::array<float, kTaps> x;
  std::array<float, kTaps> y;
  std::array<float, kTaps> weight;
};

const Spiral& spiral() {
  static const Spiral taps = [] {
    Spiral result{};
    for (std::size_t i = 0; i < kTaps; ++i) {
      const float angle = kGoldenAngle * static_cast<float>(i);
      const float r2 = (static_cast<float>(i) + 0.5F) / kTaps;
      result.x[i] = std::sqrt(r2) * std::cos(angle);
      result.y[i] = std::sqrt(r2) * std::sin(angle);
      result.weight[i] = 1 - 0.7F * r2;
    }
    return result;
  }();
  return taps;
}

// Returns the light that is missing, smoothed the more the farther away the things are that block it: that hides the
// single lights, and contacts stay sharp. Taps lie on a spiral in the ground plane, turned differently in every texel.
float Ground::smoothed(int x, int y, const Vec3f& p) const {
  const float here = missing_[index(x, y)];
  const auto reach = static_cast<float>(drawn_.lighting.occluder.radius);
  const float blocker = (distance_[index(x, y)] + 0.002F * light_ * reach) / (here + 0.002F * light_);
  const float radius = std::clamp(0.3F * blocker, 0.0F, 0.4F * reach);
  const Vec3f a = normalized(cross(up_, std::abs(up_.x) < 0.6F ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0}));
  const float at_x = center(x);
  const float at_y = center(y);
  const auto on_screen = [&](const Vec3f& q) {
    const Mat4f& m = drawn_.pass.view.matrix;
    const auto row = [&](std::size_t k) { return m[k] * q.x + m[4 + k] * q.y + m[8 + k] * q.z + m[12 + k]; };
    return std::array{(0.5F + 0.5F * row(0) / row(3)) * drawn_.rays.width / static_cast<float>(step_) - at_x,
                      (0.5F + 0.5F * row(1) / row(3)) * drawn_.rays.height / static_cast<float>(step_) - at_y};
  };
  const auto right = on_screen(p + a * radius);
  const auto ahead = on_screen(p + cross(up_, a) * radius);
  const float turn = kTurn * gradient_noise(at_x, at_y);
  const float c = std::cos(turn);
  const float s = std::sin(turn);
  const std::array u{c * right[0] + s * ahead[0], c * right[1] + s * ahead[1]};
  const std::array v{c * ahead[0] - s * right[0], c * ahead[1] - s * right[1]};
  // First the places of all taps, which compilers compute in lanes. Outside the picture they are on the border round
  // it, which is unseen.
  const Spiral& taps = spiral();
  std::array<int, kTaps> columns{};
  std::array<int, kTaps> rows{};
  const auto right_end = static_cast<float>(width_);
  const auto top_end = static_cast<float>(height_);
  for (std::size_t i = 0; i < kTaps; ++i) {
    const float column = at_x + taps.x[i] * u[0] + taps.y[i] * v[0];
    const float row = at_y + taps.x[i] * u[1] + taps.y[i] * v[1];
    columns[i] = static_cast<int>(std::min(std::max(column + 1, 0.0F), right_end + 1));
    rows[i] = static_cast<int>(std::min(std::max(row + 1, 0.0F), top_end + 1));
  }
  float sum = here;
  float weight = 1;
  for (std::size_t i = 0; i < kTaps; ++i) {
    const float missing = missing_[index(columns[i] - 1, rows[i] - 1)];
    if (missing == kUnseen) continue;
    sum += taps.weight[i] * missing;
    weight += taps.weight[i];
  }
  return sum / weight;
}

Ground::Ground(const Drawn& drawn)
    : drawn_(drawn),
      up_(drawn.pass.view.ground_up),
      step_(drawn.factor * std::max(2, drawn.pass.options.height / 600)),
      width_((drawn.pass.width + step_ - 1) / step_),
      height_((drawn.pass.height + step_ - 1) / step_) {
  for (const Light& light : drawn_.lighting.lights) {
    // Grazing light has a smaller weight, because its shadows are long and tell little.
    const float nl = std::max(dot(up_, light.direction) - kGrazingCosine, 0.0F);
    weights_.push_back(nl * nl * dot(light.radiance, Vec3f{0.3F, 0.6F, 0.1F}));
    light_ += weights_.back();
  }
  missing_.resize((static_cast<std::size_t>(width_) + 2) * (height_ + 2), kUnseen);
  distance_.resize(missing_.size());
  darkness_.resize(missing_.size());
  const auto for_rows = [&](const auto& body) {
    constexpr int at_once = 64;  // rows between two reports
    constexpr int together = 4;
    for (int first = 0; first < height_; first += at_once) {
      const int end_row = std::min(first + at_once, height_);
      const auto groups = static_cast<std::size_t>((end_row - first + together - 1) / together);
      parallel_for(groups, 2, 0, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const int from = first + together * static_cast<int>(i);
          body(from, std::min(from + together, end_row));
        }
      });
      report(drawn_.pass, *drawn_.pass.reported);
    }
  };
  for_rows([&](int from, int to) { shade_rows(from, to); });
  for_rows([&](int from, int to) {
    for (int y = from; y < to; ++y) darken_row(y);
  });
}

// Fades the shadow towards the picture's sides, so that none is cut off.
void Ground::darken_row(int y) {
  const auto fade = [&](int at, int size) {
    return smooth_step(0, 0.12F * static_cast<float>(height_), center(std::min(at, size - 1 - at)));
  };
  for (int x = 0; x < width_; ++x) {
    const std::size_t i = index(x, y);
    const std::optional<Vec3f> ground = is_seen(i) ? ground_at(x, y) : std::nullopt;
    if (!ground) continue;
    darkness_[i] = fade(x, width_) * fade(y, height_) * unit_clamp(0.85F * smoothed(x, y, *ground) / light_);
  }
}

float Ground::darkness_at(float x, float y) const {
  const float u = x / static_cast<float>(step_) + 0.5F;  // from the unseen border on, so that it is not negative
  const float v = y / static_cast<float>(step_) + 0.5F;
  const int column = static_cast<int>(u);
  const int row = static_cast<int>(v);
  const float a = u - static_cast<float>(column);
  const float b = v - static_cast<float>(row);
  const std::size_t below = index(column - 1, row - 1);
  const std::size_t above = index(column - 1, row);
  const auto weight = [&](std::size_t texel, float w) { return is_seen(texel) ? w : 0; };
  const std::array weights{weight(below, (1 - a) * (1 - b)), weight(below + 1, a * (1 - b)), weight(above, (1 - a) * b),
                           weight(above + 1, a * b)};
  const float sum = weights[0] * darkness_[below] + weights[1] * darkness_[below + 1] + weights[2] * darkness_[above] +
                    weights[3] * darkness_[above + 1];
  return sum / (1e-6F + weights[0] + weights[1] + weights[2] + weights[3]);
}

}  // namespace knead::render
