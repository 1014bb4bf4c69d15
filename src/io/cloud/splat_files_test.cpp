// Packed files of splats: .splat and .spz.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "io/codec.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::splat_files_test {
namespace {

double value(const Mesh& mesh, const std::string& name, std::size_t i) { return mesh.find_attribute(name)->values[i]; }

Mesh random_splats(std::size_t count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  Mesh mesh;
  for (std::size_t i = 0; i < count; ++i) mesh.positions.push_back({number(random), number(random), number(random)});
  const auto add = [&](const std::string& name, double middle) {
    Attribute& attribute = mesh.attributes.emplace_back(Attribute{name, Domain::vertex, NumberType::float32, 1, {}});
    for (std::size_t i = 0; i < count; ++i) attribute.values.push_back(middle + number(random));
  };
  for (int k = 0; k < 3; ++k) add(fmt::format("f_dc_{}", k), 0);
  add("opacity", 0.5);
  for (int k = 0; k < 3; ++k) add(fmt::format("scale_{}", k), -4);
  for (int k = 0; k < 4; ++k) add(fmt::format("rot_{}", k), 0);
  return mesh;
}

// The difference of two turns, of any length and sign.
double turn_error(const Mesh& a, const Mesh& b, std::size_t i) {
  double dot = 0;
  double sizes = 1;
  for (const Mesh* mesh : {&a, &b}) {
    double size2 = 0;
    for (int k = 0; k < 4; ++k) size2 += std::pow(value(*mesh, fmt::format("rot_{}", k), i), 2);
    sizes *= std::sqrt(size2);
  }
  for (int k = 0; k < 4; ++k) {
    dot += value(a, fmt::format("rot_{}", k), i) * value(b, fmt::format("rot_{}", k), i);
  }
  return std::sqrt(std::max(0.0, 2 - 2 * std::abs(dot) / sizes));
}

TEST(SplatFiles, SplatHoldsWhatItHasRoomFor) {
  const Mesh mesh = random_splats(50);
  const std::string bytes = serialize_mesh("splat", mesh);
  EXPECT_EQ(bytes.size(), 32 * 50U);
  const ShapeFile shape = parse_shape(bytes, "splat", "a.splat");
  EXPECT_TRUE(are_splats(shape.mesh));
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_LT(norm(shape.mesh.positions[i] - mesh.positions[i]), 1e-7);
    for (int k = 0; k < 3; ++k) {
      const std::string scale = fmt::format("scale_{}", k);
      const std::string color = fmt::format("f_dc_{}", k);
      EXPECT_NEAR(value(shape.mesh, scale, i), value(mesh, scale, i), 1e-6);
      EXPECT_NEAR(value(shape.mesh, color, i), value(mesh, color, i), 0.5 / (255 * 0.2820) + 1e-9);
    }
    EXPECT_NEAR(value(shape.mesh, "opacity", i), value(mesh, "opacity", i), 0.02);
    EXPECT_LT(turn_error(shape.mesh, mesh, i), 0.02);
  }
  EXPECT_EQ(serialize_shape("splat", shape, shape.mesh.positions), bytes);
}

TEST(SplatFiles, OnlyWhatChangesIsWritten) {
  const ShapeFile shape = parse_shape(serialize_mesh("splat", random_splats(4)), "splat", "a.splat");
  std::vector<Vec3d> moved = shape.mesh.positions;
  moved[2].y += 1;
  std::vector<Attribute> changes;
  for (int k = 0; k < 4; ++k)
    changes.push_back({fmt::format("rot_{}", k), Domain::vertex, NumberType::float32, 1, {0.5}});
  changes.push_back({"scale_1", Domain::vertex, NumberType::float32, 1, {-2}});
  const std::vector<std::uint32_t> third{3};
  const std::string bytes = serialize_shape("splat", shape, moved, {.attributes = changes, .changed = third});
  ASSERT_EQ(bytes.size(), shape.bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const bool may_differ = (i / 32 == 2 && i % 32 / 4 == 1) || (i / 32 == 3 && (i % 32 / 4 == 4 || i % 32 >= 28));
    if (may_differ) continue;
    EXPECT_EQ(bytes[i], shape.bytes[i]) << i;
  }
  const ShapeFile read = parse_shape(bytes, "splat", "b.splat");
  EXPECT_FLOAT_EQ(static_cast<float>(read.mesh.positions[2].y), static_cast<float>(moved[2].y));
  EXPECT_NEAR(value(read.mesh, "scale_1", 3), -2, 1e-6);
  EXPECT_EQ(value(read.mesh, "rot_3", 3), 0.5);
}

// Two splats of degree 1.
std::string spz(char version) {
  std::string bytes = "NGSP";
  bytes += {version, 0, 0, 0, 2, 0, 0, 0, 1, 12, 0, 0};
  for (const int whole : {4096, -8192, 1, 0, 0, 4096}) {  // 1, -2, 1 / 4096; 0, 0, 1
    for (int i = 0; i < 3; ++i) bytes += static_cast<char>(whole >> (8 * i) & 255);
  }
  bytes += {'\xff', '\x80'};
  bytes += {0, '\x80', '\xff', 10, 20, 30};
  bytes += {'\xa0', '\x90', '\x80', 0, 1, 2};  // 0, -1, -2; -10 ...
  if (version == 2) {
    bytes += {'\x80', '\x80', '\xff', '\x80', '\x80', '\x80'};
  } else {  // w is the largest
    bytes += {0, 0, 0, '\xc0', '\xff', 1, 0, '\xc0'};
  }
  for (int i = 0; i < 18; ++i) bytes += static_cast<char>(128 + i);
  return bytes;
}

#ifdef KNEAD_HAS_ZLIB
TEST(SplatFiles, SpzIsReadAndRewritten) {
  for (const char version : {'\2', '\3'}) {
    const std::string plain = spz(version);
    const ShapeFile shape = parse_shape(detail::zipped(plain, "a.spz"), "spz", "a.spz");
    const Mesh& mesh = shape.mesh;
    EXPECT_EQ(mesh.positions, (std::vector<Vec3d>{{1, -2, 1.0 / 4096}, {0, 0, 1}}));
    EXPECT_EQ(splat_degree(mesh), 1U);
    EXPECT_EQ(value(mesh, "scale_1", 0), -1);
    EXPECT_EQ(value(mesh, "f_rest_0", 0), 0);                            // red, the first harmonic
    EXPECT_EQ(value(mesh, "f_rest_1", 0), 3.0 / 128);                    // red, the second one
    EXPECT_EQ(value(mesh, "f_rest_5", 1), (128 + 9 + 7 - 128) / 128.0);  // green, the third one
    EXPECT_GT(value(mesh, "opacity", 0), 6);
    EXPECT_NEAR(value(mesh, "f_dc_1", 0), 0.5 / (255 * 0.15), 1e-9);
    EXPECT_NEAR(value(mesh, "rot_3", version == 2 ? 0 : 1), version == 2 ? 1 : std::sqrt(0.5), 1e-9);
    EXPECT_EQ(serialize_shape("spz", shape, mesh.positions), shape.bytes);
    std::vector<Vec3d> moved = mesh.positions;
    moved[0].x = -3;
    std::vector<Attribute> changes;
    for (int k = 0; k < 4; ++k) {
      changes.push_back({fmt::format("rot_{}", k),
                         Domain::vertex,
                         NumberType::float32,
                         1,
                         {k == 1   ? -0.8
                          : k == 3 ? 0.6
                                   : 0}});
    }
    const std::vector<std::uint32_t> second{1};
    const std::string written = serialize_shape("spz", shape, moved, {.attributes = changes, .changed = second});
    const Mesh read = parse_shape(written, "spz", "b.spz").mesh;
    EXPECT_EQ(read.positions, moved);
    EXPECT_NEAR(std::abs(value(read, "rot_1", 1)), 0.8, 0.01);
    EXPECT_NEAR(value(read, "rot_1", 1) * value(read, "rot_3", 1), -0.48, 0.01);
    EXPECT_EQ(value(read, "rot_0", 0), value(mesh, "rot_0", 0));
    moved[0].x = 3000;
    EXPECT_THROW(serialize_shape("spz", shape, moved), InvalidInput);
    const std::vector<std::uint32_t> copied{1, 0};
    const ShapeFile four = parse_shape(detail::spz_codec.with_copies(shape, copied), "spz", "c.spz");
    ASSERT_EQ(four.mesh.vertex_count(), 4U);
    EXPECT_EQ(four.mesh.positions[2], mesh.positions[1]);
    EXPECT_EQ(value(four.mesh, "f_rest_5", 2), value(mesh, "f_rest_5", 1));
    EXPECT_EQ(value(four.mesh, "scale_1", 3), value(mesh, "scale_1", 0));
    for (const std::size_t size : {3, 15, 30, 60}) {
      EXPECT_THROW(parse_shape(detail::zipped(plain.substr(0, size), "d.spz"), "spz", "d.spz"), InvalidInput) << size;
    }
  }
  EXPECT_THROW(parse_shape(detail::zipped(spz('\4'), "e.spz"), "spz", "e.spz"), InvalidInput);
  EXPECT_THROW(parse_shape("NGSP", "spz", "f.spz"), InvalidInput);
}
#endif

TEST(SplatFiles, WhatIsNoneIsRefused) {
  EXPECT_THROW(parse_shape(std::string(33, 'a'), "splat", "a.splat"), InvalidInput);
  EXPECT_THROW(parse_shape("", "splat", "a.splat"), InvalidInput);
  EXPECT_THROW(parse_shape(std::string(32, '\xff'), "splat", "a.splat"), InvalidInput);  // not finite
  Mesh cloud;
  cloud.positions = {{0, 0, 0}};
  EXPECT_THROW(serialize_mesh("splat", cloud), InvalidInput);
}

}  // namespace
}  // namespace knead::splat_files_test
