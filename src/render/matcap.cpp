// The pictures of balls that matcaps are, lit by formulas.
#include "render/surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "knead/editor/render.h"
#include "knead/error.h"

namespace knead::render {
namespace {

struct Names {
  std::string_view name;
  std::string_view title;
};

constexpr std::array<Names, kMatcapCount> kNames{{{"terracotta", "Terracotta"},
                                                  {"red-wax", "Red wax"},
                                                  {"porcelain", "Porcelain"},
                                                  {"chrome", "Chrome"},
                                                  {"jade", "Jade"},
                                                  {"skin", "Skin"},
                                                  {"dark-metal", "Dark metal"},
                                                  {"normals", "Normals"}}};

constexpr std::array<Matcap, kMatcapCount> kAll{Matcap::terracotta, Matcap::red_wax, Matcap::porcelain,
                                                Matcap::chrome,     Matcap::jade,    Matcap::skin,
                                                Matcap::dark_metal, Matcap::normals};

// All vectors: x to the right, y up, z to the viewer. Colours are linear light.
const Vec3d kKey = normalized(Vec3d{-0.45, 0.62, 0.64});
const Vec3d kFill = normalized(Vec3d{0.85, 0.10, 0.45});
const Vec3d kBelow = normalized(Vec3d{0.10, -0.95, 0.10});

double smooth(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// A highlight around the direction halfway between lamp and viewer.
double shine(const Vec3d& n, const Vec3d& lamp, double power) {
  return std::pow(std::max(0.0, dot(n, normalized(lamp + Vec3d{0, 0, 1}))), power);
}

// 0 in the middle of the ball, 1 at its outline.
double edge(const Vec3d& n, double power) { return std::pow(1 - std::clamp(n.z, 0.0, 1.0), power); }

Vec3d times(const Vec3d& a, const Vec3d& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

// A body that scatters light. softness: the extent of light beyond the terminator, 0 to 1; `within`: its colour there.
struct Body {
  Vec3d color;
  Vec3d within;
  double softness = 0;
  Vec3d gloss;  // strength by colour
  double gloss_power = 1;
  double rim = 0;
};

Vec3d lambert(const Vec3d& n, const Vec3d& lamp, double softness) {
  const double lit = std::max(0.0, (dot(n, lamp) + softness) / (1 + softness));
  return Vec3d{1, 1, 1} * std::pow(lit, 1 + 0.5 * softness);
}

Vec3d body_at(const Body& body, const Vec3d& n) {
  const Vec3d sharp = lambert(n, kKey, 0.08);
  const Vec3d soft = lambert(n, kKey, body.softness);
  const Vec3d sky = Vec3d{0.17, 0.18, 0.20} * (0.5 + 0.5 * n.y) + Vec3d{0.05, 0.045, 0.04};
  Vec3d light = sky + sharp * 0.80 + times(Vec3d{0.13, 0.15, 0.19}, lambert(n, kFill, 0.3)) +
                times(Vec3d{0.09, 0.07, 0.055}, lambert(n, kBelow, 0.5));
  Vec3d color = times(body.color, light) + times(body.within, soft - sharp) * 0.9;
  color += body.gloss * shine(n, kKey, body.gloss_power);
  color += body.gloss * (0.25 * shine(n, kFill, 0.5 * body.gloss_power));
  return color + Vec3d{0.75, 0.85, 1.0} * (body.rim * edge(n, 3.5) * (0.55 + 0.45 * n.y));
}

// The light from a direction of a studio with a bright ceiling, two windows and a dark floor. blur: 0 is sharp.
Vec3d studio_at(const Vec3d& d, double blur) {
  const double horizon = smooth(-0.05 - blur, 0.10 + blur, d.y);
  const Vec3d floor = Vec3d{0.16, 0.14, 0.12} * (0.35 + 0.65 * smooth(0, -1, d.y));
  const Vec3d wall = Vec3d{0.30, 0.33, 0.38} + Vec3d{0.55, 0.58, 0.60} * smooth(0.1, 0.9, d.y);
  Vec3d seen = floor * (1 - horizon) + wall * horizon;
  const auto window = [&](const Vec3d& towards, double half, double strength) {
    seen += Vec3d{1, 0.98, 0.95} *
            (strength * smooth(std::cos(half + 0.5 * blur), std::cos(0.75 * half), dot(d, normalized(towards))));
  };
  window({-0.75, 0.62, 0.25}, 0.42, 1.1);
  window({0.95, 0.15, 0.05}, 0.26, 0.6);
  window({0.15, 0.35, -0.93}, 0.20, 0.35);
  return seen;
}

Vec3d mirrored_at(const Vec3d& n, double blur) { return studio_at(n * (2 * n.z) - Vec3d{0, 0, 1}, blur); }

Vec3d porcelain_at(const Vec3d& n) {
  const Body body{{0.80, 0.82, 0.84}, {0.55, 0.62, 0.75}, 0.25, {0.02, 0.02, 0.02}, 20, 0.06};
  const double glaze = 0.045 + 0.5 * edge(n, 4);
  return body_at(body, n) * (1 - 0.5 * glaze) + mirrored_at(n, 0.03) * (0.35 * glaze) +
         Vec3d{0.75, 0.75, 0.74} * smooth(0.5, 0.75, shine(n, kKey, 60));
}

Vec3d dark_metal_at(const Vec3d& n) {
  const Vec3d steel{0.20, 0.215, 0.24};
  return times(steel, mirrored_at(n, 0.5)) * (0.55 + 0.9 * edge(n, 3)) + Vec3d{0.55, 0.54, 0.52} * shine(n, kKey, 22) +
         Vec3d{0.10, 0.12, 0.16} * shine(n, kFill, 12) + Vec3d{0.006, 0.006, 0.007};
}

Vec3d linear_at(Matcap matcap, const Vec3d& n) {
  switch (matcap) {
    case Matcap::terracotta:
      return body_at({{0.60, 0.27, 0.15}, {0.30, 0.09, 0.04}, 0.15, {0.05, 0.045, 0.04}, 9, 0.05}, n);
    case Matcap::red_wax:
      return body_at({{0.50, 0.035, 0.030}, {0.50, 0.05, 0.02}, 0.55, {0.34, 0.30, 0.28}, 46, 0.07}, n);
    case Matcap::porcelain:
      return porcelain_at(n);
    case Matcap::chrome:
      return times(mirrored_at(n, 0), Vec3d{0.93, 0.94, 0.96}) * 0.95;
    case Matcap::jade:
      return body_at({{0.10, 0.38, 0.20}, {0.16, 0.50, 0.22}, 0.80, {0.38, 0.42, 0.38}, 80, 0.12}, n);
    case Matcap::skin:
      return body_at({{0.70, 0.43, 0.32}, {0.65, 0.16, 0.09}, 0.40, {0.10, 0.10, 0.10}, 16, 0.09}, n);
    case Matcap::dark_metal:
      return dark_metal_at(n);
    case Matcap::normals:
      break;
  }
  return {};
}

double srgb(double x) {
  const double c = std::clamp(x, 0.0, 1.0);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}

Bytes4 color_at(Matcap matcap, const Vec3d& n) {
  Vec3d c = n * 0.5 + Vec3d{0.5, 0.5, 0.5};
  if (matcap != Matcap::normals) {
    const Vec3d light = linear_at(matcap, n);
    c = {srgb(light.x), srgb(light.y), srgb(light.z)};
  }
  return to_bytes({static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z), 1});
}

// x, y from -1 to 1; beyond the outline, the normal at the outline.
Vec3d ball_normal(double x, double y) {
  const double length = std::hypot(x, y);
  if (length > 1) return {x / length, y / length, 0};
  return {x, y, std::sqrt(1 - length * length)};
}

}  // namespace

std::span<const Matcap> all_matcaps() { return kAll; }

std::string_view name_of(Matcap matcap) { return kNames[static_cast<std::size_t>(matcap)].name; }

std::string_view title_of(Matcap matcap) { return kNames[static_cast<std::size_t>(matcap)].title; }

std::optional<Matcap> matcap_named(std::string_view name) {
  for (const Matcap matcap : kAll) {
    if (name_of(matcap) == name) return matcap;
  }
  return std::nullopt;
}

std::vector<Bytes4> matcap_picture(Matcap matcap, int size) {
  std::vector<Bytes4> picture;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      // The shaders read between 0.01 and 0.99 of each side.
      const double x = (2 * (column + 0.5) / size - 1) / 0.98;
      const double y = (2 * (row + 0.5) / size - 1) / 0.98;
      picture.push_back(color_at(matcap, ball_normal(x, y)));
    }
  }
  return picture;
}

Image matcap_ball(Matcap matcap, int size) {
  if (size < 2) throw InvalidInput("matcap_ball: give a size of at least 2 pixels");
  Image image{size, size, {}};
  const double pixel = 2.0 / size;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const double x = (column + 0.5) * pixel - 1;
      const double y = 1 - (row + 0.5) * pixel;
      Bytes4 color = color_at(matcap, ball_normal(x, y));
      color[3] = static_cast<std::uint8_t>(std::lround(255 * std::clamp((1 - std::hypot(x, y)) / pixel, 0.0, 1.0)));
      image.pixels.insert(image.pixels.end(), color.begin(), color.end());
    }
  }
  return image;
}

}  // namespace knead::render
