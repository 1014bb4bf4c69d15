// Lights the samples that the GPU has drawn, on the CPU: OpenGL in software is five times slower, and with a GPU other
// steps take longer.
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>

#include "knead/error.h"
#include "math/system.h"
#include "render/offline/shade.h"

namespace knead::render {
namespace {

constexpr int kMatcapSize = 256;

using Rgba = std::array<float, 4>;  // linear, multiplied by alpha

float linear(float srgb) { return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F); }
Vec3f linear(const Color& c) { return {linear(c.red), linear(c.green), linear(c.blue)}; }

// sums[i] += weight * from[i * step].
KNEAD_CLONES void add_scaled(const Rgba* from, float weight, int step, std::span<Rgba> sums) {
  for (std::size_t i = 0; i < sums.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) sums[i][c] += weight * from[i * step][c];
  }
}

// The bytes of linear values from 0 to 1, in even steps that are finer than those of the bytes.
const std::vector<std::uint8_t>& srgb_bytes() {
  static const std::vector<std::uint8_t> table = [] {
    std::vector<std::uint8_t> bytes;
    for (int byte = 0; byte < 256; ++byte) {
      const double end = (byte + 0.5) / 255;  // where the next is nearer
      const double c = end <= 0.04045 ? end / 12.92 : std::pow((end + 0.055) / 1.055, 2.4);
      bytes.resize(static_cast<std::size_t>(65535 * std::min(c, 1.0)) + 1, static_cast<std::uint8_t>(byte));
    }
    return bytes;
  }();
  return table;
}

// The nearest integer to x >= 0, without a call of lround().
int rounded(float x) {
  const float above = x + 0.5F;
  return static_cast<int>(above);
}

LightMatrix light_matrix(const Vec3d& direction, const Occluder& occluder) {
  const Vec3d u = any_orthogonal(direction);
  const Vec3d rows[3] = {u * (0.5 / occluder.radius), cross(direction, u) * (0.5 / occluder.radius),
                         direction * (-0.5 / occluder.radius)};
  LightMatrix matrix{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) matrix[3 * column + row] = static_cast<float>(rows[row][column]);
    matrix[9 + row] = static_cast<float>(0.5 - dot(rows[row], occluder.center));
  }
  return matrix;
}

// A place on a shape where its light is computed.
struct Point {
  int x = 0;  // the sample
  int y = 0;
  bool is_pixel = false;  // stands for all samples of its pixel
  float depth = 0;
  Vec3f p;
  Vec3f facing;  // the normal as it is drawn
  Vec3f n;       // and turned to the viewer: interpolated normals may lean away
  Vec3f v;       // to the viewer
  Vec3f color;   // linear
};

// How the normal beside a point leans along an axis, and from 0 to 1 how surely it is of the same surface.
struct Lean {
  float by = 0;
  float surely = 0;
};

// The data of some points for the lights' loops, which compilers vectorise, and the light that they collect.
struct Lanes {
  MapPlaces places;                          // where a light's shadow is looked up
  std::array<Lane, 3> lifted;                // off the surface
  std::array<std::array<Lane, 3>, 2> shift;  // along the surface, and a quarter of a turn on
  std::array<Lane, 3> n;
  std::array<Lane, 3> v;
  Lane nv;
  Lane nl;
  std::array<Lane, 3> diffuse;
  std::array<Lane, 3> gloss;
};

// The cosines between the light and the normals. Returns false if no point faces the light.
KNEAD_CLONES bool face(const Vec3f& d, Lanes& lanes) {
  const auto& [nx, ny, nz] = lanes.n;
  int facing = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    lanes.nl[i] = std::max(nx[i] * d.x + ny[i] * d.y + nz[i] * d.z, 0.0F);
    facing += lanes.nl[i] > 0 ? 1 : 0;
  }
  return facing > 0;
}

// Turns the shifts by an angle, another for each light: one for all leaves the noise's pattern in the picture.
KNEAD_CLONES void shift_places(float turn, Lanes& lanes) {
  const float c = std::cos(turn);
  const float s = std::sin(turn);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      lanes.places.q[k][i] = lanes.lifted[k][i] + lanes.shift[0][k][i] * c + lanes.shift[1][k][i] * s;
    }
  }
}

// Lambert's clay with a dull sheen (GGX of roughness 0.45, Schlick's Fresnel with 0.04), by the cosines between normal,
// light and viewer: the half vector has the length 1 / s before it is a unit vector.
KNEAD_CLONES void shine(const Light& light, Lanes& lanes) {
  constexpr float a2 = 0.041F;
  const Vec3f d = light.direction;
  const Vec3f r = light.radiance;
  const auto& [vx, vy, vz] = lanes.v;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float nl = static_cast<float>(lanes.places.nearest[i]) < lanes.places.depth[i] ? 0 : lanes.nl[i];
    const float toward = 1 + vx[i] * d.x + vy[i] * d.y + vz[i] * d.z;
    const float s = 1 / std::sqrt(std::max(2 * toward, 1e-4F));
    const float nh = std::min(std::max((nl + lanes.nv[i]) * s, 0.0F), 1.0F);
    const float lh = std::min(std::max(toward * s, 0.05F), 1.0F);
    const float t = nh * nh * (a2 - 1) + 1;
    const float away = (1 - lh) * (1 - lh);
    const float f = 0.04F + 0.96F * away * away * (1 - lh);
    const float g = f * a2 / (4 * t * t * std::max(lh * lh, 0.1F)) * nl;
    for (std::size_t k = 0; k < 3; ++k) {
      lanes.diffuse[k][i] += r[k] * nl;
      lanes.gloss[k][i] += r[k] * g;
    }
  }
}

// A few rows of pixels are lit together, in blocks, so that the texels of neighbouring points are in the caches.
constexpr int kRowsLit = 4;
constexpr int kBlock = 16;  // pixels

// The samples of some rows of pixels: those of row y are at y % size.
constexpr int kRowsAtOnce = 32;  // between two reports
using Rows = std::array<std::vector<Rgba>, kRowsAtOnce + 2>;

class Shader {
 public:
  explicit Shader(const Drawn& drawn);

  Image picture() const;

 private:
  bool is_even(int x, int y) const;
  Point point_at(int x, int y) const;
  void find_points(int y, int left, int right, std::vector<Point>& points) const;
  void add_lamps(std::span<const Point> points, Vec3f* light) const;
  Vec3f ball(const Point& point) const;
  Lean lean(const Point& point, int dx, int dy, const Vec3f& axis, float size) const;
  float spread(const Point& point, int away, float size) const;
  float cavity(const Point& point) const;
  float occlusion(const Point& point) const;

  // Of a sample in a row of pixels.
  std::size_t sample(int x, int y) const { return static_cast<std::size_t>(y) * drawn_.pass.width + x; }
  std::vector<Rgba>& row_of(Rows& rows, int y) const { return rows[static_cast<std::size_t>(y) % rows.size()]; }
  void light_points(std::span<const Point> points, Rows& rows) const;
  void light_rows(int first, int last, Rows& rows) const;
  bool is_empty(int x, int y) const;
  void draw_background(int y, Rgba* samples) const;
  void add_front(int y, std::vector<Rgba>& row) const;
  void resolve_row(int y, const std::function<const Rgba*(int)>& samples_of, std::uint8_t* pixels) const;

  const Drawn& drawn_;
  const Options& options_;
  int factor_;
  std::array<float, 256> linear_of_{};  // by bytes of sRGB
  std::vector<Bytes4> matcap_;
  std::optional<Ground> ground_;
};

Shader::Shader(const Drawn& drawn) : drawn_(drawn), options_(drawn.pass.options), factor_(drawn.factor) {
  for (std::size_t i = 0; i < 256; ++i) linear_of_[i] = linear(static_cast<float>(i) / 255);
  if (options_.matcap) matcap_ = matcap_picture(*options_.matcap, kMatcapSize);
  if (drawn.lighting.has_ground(options_)) ground_.emplace(drawn);

  report(drawn.pass, 0.55);
}

// Returns true if the pixel lies within one almost flat surface: its samples share one evaluation of the lights.
bool Shader::is_even(int x, int y) const {
  const int middle_x = x * factor_ + factor_ / 2;
  const int middle_y = y * factor_ + factor_ / 2;
  const float depth = drawn_.depth_at(middle_x, middle_y);
  if (depth == 1) return false;
  const Vec3f n = drawn_.normal_at(middle_x, middle_y);
  const Vec3f p = drawn_.place_at(middle_x, middle_y);
  const Bytes4& color = drawn_.samples.reflectance[drawn_.index(middle_x, middle_y)];
  const float limit = 1.5F * static_cast<float>(factor_) * drawn_.rays.size(depth);
  for (int j = y * factor_; j < (y + 1) * factor_; ++j) {
    for (int i = x * factor_; i < (x + 1) * factor_; ++i) {
      if (i == middle_x && j == middle_y) continue;
      if (drawn_.depth_at(i, j) == 1 || dot(drawn_.normal_at(i, j), n) <= 0.93F) return false;
      if (std::abs(dot(drawn_.place_at(i, j) - p, n)) >= limit) return false;
      const Bytes4& other = drawn_.samples.reflectance[drawn_.index(i, j)];
      for (std::size_t k = 0; k < 3; ++k) {
        if (std::abs(other[k] - color[k]) > 7) return false;
      }
    }
  }
  return true;
}

Point Shader::point_at(int x, int y) const {
  Point point;
  point.x = x;
  point.y = y;
  point.depth = drawn_.depth_at(x, y);
  point.p = drawn_.place_at(x, y);
  const Vec3f ray = normalized(drawn_.rays.direction(center(x), center(y)));
  point.v = -ray;
  point.facing = point.n = normalized(drawn_.normal_at(x, y));
  const float away = dot(point.n, ray);
  if (away > 0) point.n = normalized(point.n - ray * (1.02F * away));
  const Bytes4& color = drawn_.samples.reflectance[drawn_.index(x, y)];
  for (std::size_t k = 0; k < 3; ++k) point.color[k] = linear_of_[color[k]];
  return point;
}

// Appends the points of a row's pixels from left to right.
void Shader::find_points(int y, int left, int right, std::vector<Point>& points) const {
  for (int x = left; x < right; ++x) {
    if (is_even(x, y)) {
      points.push_back(point_at(x * factor_ + factor_ / 2, y * factor_ + factor_ / 2));
      points.back().is_pixel = true;
      continue;
    }
    for (int j = y * factor_; j < (y + 1) * factor_; ++j) {
      for (int i = x * factor_; i < (x + 1) * factor_; ++i) {
        if (drawn_.depth_at(i, j) < 1) points.push_back(point_at(i, j));
      }
    }
  }
}

// Returns a shift along the surface, so that the edges of single shadows become soft, and the same a quarter of a turn
// on. Interleaved gradient noise: Jimenez, "Next generation post processing in Call of Duty" (2014).
std::array<Vec3f, 2> shift_of(const Point& point, float lift) {
  const float x = center(point.x);
  const float y = center(point.y);
  const float turn = kTurn * gradient_noise(x, y);
  const float r = 1.5F * lift * std::sqrt(gradient_noise(y + 17, x + 17));
  const Vec3f t = normalized(cross(point.n, std::abs(point.n.x) < 0.6F ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0}));
  const Vec3f s = (t * std::cos(turn) + cross(point.n, t) * std::sin(turn)) * r;
  return {s, cross(point.n, s)};
}

// Sets the light that comes from at most kLanes points.
void Shader::add_lamps(std::span<const Point> points, Vec3f* light) const {
  const bool has_shadows = drawn_.maps != nullptr;
  Lanes lanes{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& point = points[i];
    const Vec3f lifted = point.p + point.n * drawn_.lift;
    const std::array<Vec3f, 2> shift = shift_of(point, drawn_.lift);
    for (std::size_t k = 0; k < 3; ++k) {
      lanes.lifted[k][i] = lifted[k];
      lanes.shift[0][k][i] = shift[0][k];
      lanes.shift[1][k][i] = shift[1][k];
      lanes.n[k][i] = point.n[k];
      lanes.v[k][i] = point.v[k];
    }
    lanes.nv[i] = dot(point.n, point.v);
  }
  for (std::size_t l = 0; l < drawn_.lighting.lights.size(); ++l) {
    const Light& lamp = drawn_.lighting.lights[l];
    if (!face(lamp.direction, lanes)) continue;
    if (has_shadows) {
      shift_places(static_cast<float>(l) * kGoldenAngle, lanes);
      look_up(drawn_.matrices[l], drawn_.map(l), lanes.places);
    }
    shine(lamp, lanes);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) light[i][k] = points[i].color[k] * lanes.diffuse[k][i] + lanes.gloss[k][i];
  }
}

// Returns the colour that the matcap's ball has where its normal is the point's.
Vec3f Shader::ball(const Point& point) const {
  const Vec3f x = normalized(cross(-point.v, drawn_.rays.top));
  const Vec3f y = cross(x, -point.v);
  const float u = (0.5F + 0.49F * dot(point.n, x)) * kMatcapSize - 0.5F;
  const float v = (0.5F + 0.49F * dot(point.n, y)) * kMatcapSize - 0.5F;
  const int column = std::clamp(static_cast<int>(std::floor(u)), 0, kMatcapSize - 2);
  const int row = std::clamp(static_cast<int>(std::floor(v)), 0, kMatcapSize - 2);
  const Bytes4* at = &matcap_[static_cast<std::size_t>(row) * kMatcapSize + column];
  const float a = u - static_cast<float>(column);
  const float b = v - static_cast<float>(row);
  const Vec3f plain = linear(kClay);
  Vec3f seen;
  for (std::size_t k = 0; k < 3; ++k) {
    const float below = at[0][k] * (1 - a) + at[1][k] * a;
    const float above = at[kMatcapSize][k] * (1 - a) + at[kMatcapSize + 1][k] * a;
    seen[k] = linear((below * (1 - b) + above * b) / 255) * point.color[k] / plain[k];
  }
  return seen;
}

// The neighbourhood in the picture, as in kRelief of surface.h.

// Returns from 0 on an outline, where every surface turns away, to 1.
float is_inside(const Vec3f& normal, const Vec3f& to_eye) { return smooth_step(0.1F, 0.6F, dot(normal, to_eye)); }

float across(const Lean& a, const Lean& b) {
  return 2 * (a.surely * a.by - b.surely * b.by) / std::max(a.surely + b.surely, 1.0F);
}

Lean Shader::lean(const Point& point, int dx, int dy, const Vec3f& axis, float size) const {
  const Part& part = drawn_.pass.part;
  const int x = std::clamp(point.x + dx, part.left, part.left + part.width - 1);
  const int y = std::clamp(point.y + dy, part.bottom, part.bottom + part.height - 1);
  const Vec3f d = drawn_.place_at(x, y) - point.p;
  const float off = std::max(std::abs(dot(point.facing, d)), 0.3F * std::sqrt(dot(d, d)) * dot(point.facing, point.v));
  const float away = static_cast<float>(std::abs(dx + dy)) * size;
  if (!(drawn_.depth_at(x, y) < 1 && off < 0.8F * away)) return {};
  const Vec3f other = normalized(drawn_.normal_at(x, y));
  return {std::clamp(dot(other - point.facing, axis), -0.25F, 0.25F),
          (1 - smooth_step(0.3F, 0.8F, off / away)) * is_inside(other, point.v)};
}

float Shader::spread(const Point& point, int away, float size) const {
  const Vec3f x = normalized(drawn_.rays.side);
  const Vec3f y = normalized(drawn_.rays.top);
  return across(lean(point, away, 0, x, size), lean(point, -away, 0, x, size)) +
         across(lean(point, 0, away, y, size), lean(point, 0, -away, y, size));
}

float Shader::cavity(const Point& point) const {
  const int away = std::max(1, rounded(static_cast<float>(kFinestCavity * drawn_.pass.height)));
  const float size = drawn_.rays.size(point.depth);
  float c = 0.8F * spread(point, away, size) + 0.5F * spread(point, 3 * away, size);
  c *= is_inside(point.facing, point.v);
  return c < 0 ? 1 / (1 - 1.1F * c) : 1 + 0.55F * c / (0.6F + c);
}

float Shader::occlusion(const Point& point) const {
  constexpr int taps = 32;
  const float size = drawn_.rays.size(point.depth);
  const float reach = std::min(static_cast<float>(kOcclusionReach), 0.12F * drawn_.rays.height * size);
  const float x = center(point.x);
  const float y = center(point.y);
  const float turn = kTurn * gradient_noise(x, y);
  float sum = 0;
  for (int i = 0; i < taps; ++i) {
    const float angle = kGoldenAngle * static_cast<float>(i) + turn;
    const float r = (static_cast<float>(i) + 0.5F) / taps * reach / size;
    const int column = static_cast<int>(std::clamp(x + r * std::cos(angle), 0.5F, drawn_.rays.width - 0.5F));
    const int row = static_cast<int>(std::clamp(y + r * std::sin(angle), 0.5F, drawn_.rays.height - 0.5F));
    if (drawn_.depth_at(column, row) == 1) continue;
    const Vec3f d = drawn_.place_at(column, row) - point.p;
    const float dd = dot(d, d);
    const float f = std::max(1 - dd / (reach * reach), 0.0F);
    // Triangles lie a little beside the surface that the normals tell of.
    const float above = std::max(dot(d, point.facing) - 0.07F * std::sqrt(dd) - size, 0.0F);
    sum += f * f * f * above / (dd + 0.0004F * reach * reach);
  }
  return std::max(1 - 2.2F * reach * sum / taps, 0.0F);
}

// Returns true if no sample of the pixel shows a shape: they share one evaluation of the ground's shadow.
bool Shader::is_empty(int x, int y) const {
  for (int j = y * factor_; j < (y + 1) * factor_; ++j) {
    for (int i = x * factor_; i < (x + 1) * factor_; ++i) {
      if (drawn_.depth_at(i, j) < 1) return false;
    }
  }
  return true;
}

void Shader::draw_background(int y, Rgba* samples) const {
  const Color& top = options_.background;
  const Color bottom = options_.background_bottom.value_or(top);
  std::array<Rgba, kMaxSupersampling> behind{};  // by row of samples
  for (int j = 0; j < factor_; ++j) {
    const float part = center(y * factor_ + j) / drawn_.rays.height;
    const auto mixed = [&](float a, float b) { return a * (1 - part) + b * part; };
    const float alpha = mixed(bottom.alpha, top.alpha);
    const Vec3f color =
        linear(Color{mixed(bottom.red, top.red), mixed(bottom.green, top.green), mixed(bottom.blue, top.blue), 1}) *
        alpha;
    behind[static_cast<std::size_t>(j)] = {color.x, color.y, color.z, alpha};
  }
  const auto darkness = [&](float i, float j) { return ground_ ? ground_->darkness_at(i, j) : 0; };
  const float middle = 0.5F * static_cast<float>(factor_);
  for (int x = 0; x < options_.width; ++x) {
    const bool is_one = is_empty(x, y);
    float dark =
        is_one ? darkness(static_cast<float>(x * factor_) + middle, static_cast<float>(y * factor_) + middle) : 0;
    for (int j = 0; j < factor_; ++j) {
      const Rgba& c = behind[static_cast<std::size_t>(j)];
      for (int i = x * factor_; i < (x + 1) * factor_; ++i) {
        if (!is_one && drawn_.depth_at(i, y * factor_ + j) < 1) continue;
        if (!is_one) dark = darkness(center(i), center(y * factor_ + j));
        samples[sample(i, j)] = {c[0] * (1 - dark) + 0.018F * dark, c[1] * (1 - dark) + 0.015F * dark,
                                 c[2] * (1 - dark) + 0.012F * dark, c[3] + (1 - c[3]) * dark};
      }
    }
  }
}

// Adds rods and glass.
void Shader::add_front(int y, std::vector<Rgba>& row) const {
  const Part& part = drawn_.pass.part;
  for (int j = 0; j < factor_; ++j) {
    const Shorts4* front = &drawn_.samples.front[drawn_.index(part.left, y * factor_ + j)];
    for (Rgba& behind : std::span(row).subspan(sample(part.left, j), static_cast<std::size_t>(part.width))) {
      const float through = 1 - static_cast<float>((*front)[3]) / 65535;
      for (std::size_t k = 0; k < 4; ++k) behind[k] = static_cast<float>((*front)[k]) / 65535 + through * behind[k];
      ++front;
    }
  }
}

// Writes the colours of at most kLanes points into their samples.
void Shader::light_points(std::span<const Point> points, Rows& rows) const {
  std::array<Vec3f, kLanes> light;
  if (!options_.matcap) add_lamps(points, light.data());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& point = points[i];
    const int y = point.y / factor_;
    std::vector<Rgba>& samples = row_of(rows, y);
    Vec3f seen = options_.matcap ? ball(point) : light[i];
    if (options_.relief.cavity) seen *= cavity(point);
    if (options_.relief.occlusion) seen *= occlusion(point);
    const int first = point.is_pixel ? factor_ / 2 : 0;
    const int count = point.is_pixel ? factor_ : 1;
    for (int j = point.y - first; j < point.y - first + count; ++j) {
      for (int k = point.x - first; k < point.x - first + count; ++k) {
        samples[sample(k, j - y * factor_)] = {seen.x, seen.y, seen.z, 1};
      }
    }
  }
}

void Shader::light_rows(int first, int last, Rows& rows) const {
  for (int y = first; y < last; ++y) {
    row_of(rows, y).resize(static_cast<std::size_t>(factor_) * drawn_.pass.width);
    draw_background(y, row_of(rows, y).data());
  }
  const Part& part = drawn_.pass.part;
  const int bottom = std::max(first, part.bottom / factor_);
  const int top = std::min(last, (part.bottom + part.height) / factor_);
  const int right = (part.left + part.width) / factor_;
  std::vector<Point> points;
  for (int left = part.left / factor_; left < right; left += kBlock) {
    for (int y = bottom; y < top; ++y) find_points(y, left, std::min(left + kBlock, right), points);
    const bool is_last = left + kBlock >= right;
    std::size_t lit = 0;
    for (; lit + (is_last ? 1 : kLanes) <= points.size(); lit += kLanes) {
      light_points(std::span(points).subspan(lit, std::min(kLanes, points.size() - lit)), rows);
    }
    points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(std::min(lit, points.size())));
  }
  for (int y = bottom; y < top && drawn_.samples.front; ++y) add_front(y, row_of(rows, y));
}

// The filter is a tent of one pixel to either side. samples_of: a row of samples.
void Shader::resolve_row(int y, const std::function<const Rgba*(int)>& samples_of, std::uint8_t* pixels) const {
  const auto weight = [&](int k) { return 1 - std::abs(center(k) / static_cast<float>(factor_) - 0.5F); };
  const int reach = factor_ - 1;
  std::vector<Rgba> sums(
      static_cast<std::size_t>(drawn_.pass.width + 2 * reach));  // the last ones go on beyond the ends
  const std::span inner = std::span(sums).subspan(reach, drawn_.pass.width);
  float all = 0;
  for (int k = -reach; k < factor_ + reach; ++k) {
    all += weight(k);
    add_scaled(samples_of(std::clamp(y * factor_ + k, 0, drawn_.pass.height - 1)), weight(k), 1, inner);
  }
  std::fill_n(sums.begin(), reach, inner.front());
  std::fill_n(sums.rbegin(), reach, inner.back());
  std::vector<Rgba> colors(static_cast<std::size_t>(options_.width));
  for (int k = 0; k < factor_ + 2 * reach; ++k) add_scaled(&sums[k], weight(k - reach) / (all * all), factor_, colors);
  const std::uint8_t* const bytes = srgb_bytes().data();
  for (const Rgba& color : colors) {
    const float part = color[3] > 0 ? 1 / color[3] : 0;
    for (std::size_t c = 0; c < 3; ++c) *pixels++ = bytes[rounded(65535 * unit_clamp(color[c] * part))];
    *pixels++ = static_cast<std::uint8_t>(rounded(255 * unit_clamp(color[3])));
  }
}

Image Shader::picture() const {
  const int height = options_.height;
  const std::size_t line = 4 * static_cast<std::size_t>(options_.width);
  Image image{options_.width, height, std::vector<std::uint8_t>(line * static_cast<std::size_t>(height))};
  Rows rows;
  const auto samples_of = [&](int j) { return row_of(rows, j / factor_).data() + sample(0, j % factor_); };
  const auto for_rows = [](int first, int last, const auto& body) {
    const auto groups = static_cast<std::size_t>((last - first + kRowsLit - 1) / kRowsLit);
    parallel_for(groups, 1, 0, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const int from = first + kRowsLit * static_cast<int>(i);
        body(from, std::min(from + kRowsLit, last));
      }
    });
  };
  int lit = 0;
  for (int first = 0; first < height; first += kRowsAtOnce) {
    const int last = std::min(first + kRowsAtOnce, height);
    const int needed = std::min(last + 1, height);
    for_rows(lit, needed, [&](int from, int to) { light_rows(from, to, rows); });
    lit = needed;
    for_rows(first, last, [&](int from, int to) {
      for (int y = from; y < to; ++y) {
        resolve_row(y, samples_of, image.pixels.data() + static_cast<std::size_t>(height - 1 - y) * line);
      }
    });
    report(drawn_.pass, 0.55 + 0.45 * last / height);
  }
  return image;
}

}  // namespace

KNEAD_CLONES void look_up(const LightMatrix& light, const std::uint16_t* map, MapPlaces& places) {
  constexpr float size = kShadowMapSize;
  const LightMatrix& m = light;
  const auto& [x, y, z] = places.q;
  std::array<int, kLanes> texels{};
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float column = (m[0] * x[i] + m[3] * y[i] + m[6] * z[i] + m[9]) * size;
    const float row = (m[1] * x[i] + m[4] * y[i] + m[7] * z[i] + m[10]) * size;
    places.depth[i] = (m[2] * x[i] + m[5] * y[i] + m[8] * z[i] + m[11]) * 65535.0F;
    texels[i] = static_cast<int>(std::max(std::min(row, size - 1), 0.0F)) * kShadowMapSize +
                static_cast<int>(std::max(std::min(column, size - 1), 0.0F));
  }
  for (std::size_t i = 0; i < kLanes; ++i) places.nearest[i] = map[texels[i]];
}

Drawn::Drawn(const Pass& of, const Samples& samples_of, const Lighting& lights)
    : pass(of),
      samples(samples_of),
      lighting(lights),
      rays(of),
      factor(of.options.supersampling),
      lift(static_cast<float>(1.4 * 2 * lights.occluder.radius / kShadowMapSize)) {
  constexpr std::size_t at_once = 8;  // so that it can be stopped soon
  const Options& options = of.options;
  if (!lights.has_shadows(options) || (options.matcap && !options.ground)) return;
  const std::size_t count = lights.lights.size();
  for (const Light& light : lights.lights) matrices.push_back(light_matrix(Vec3d(light.direction), lights.occluder));
  constexpr std::size_t texels = std::size_t{kShadowMapSize} * kShadowMapSize;
  maps.reset(new std::uint16_t[count * texels]);
  for (std::size_t first = 0; first < count; first += at_once) {
    const std::size_t some = std::min(at_once, count - first);
    draw_shadow_maps(lights.occluder, {&matrices[first], some}, kShadowMapSize, lights.point_radius,
                     {&maps[first * texels], some * texels});
    report(of, 0.3 + 0.2 * static_cast<double>(first + some) / static_cast<double>(count));
  }
}

Vec3f Drawn::normal_at(int x, int y) const {
  constexpr float unit = 2 / 65535.0F;
  const auto& n = samples.normal[index(x, y)];
  return {static_cast<float>(n[0]) * unit - 1, static_cast<float>(n[1]) * unit - 1,
          static_cast<float>(n[2]) * unit - 1};
}

Image shade(const Pass& pass, const Samples& samples, const Lighting& lighting) {
  const Drawn drawn(pass, samples, lighting);

  return Shader(drawn).picture();
}

}  // namespace knead::render
