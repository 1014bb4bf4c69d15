#include "knead/session/report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "knead/flow/simd.h"
#include "knead/mesh/shapes.h"

namespace knead {
namespace {

Session one_stroke() {
  Session session;
  SessionStroke& stroke = session.strokes.emplace_back();
  stroke.stroke = ImplicitStroke{{{1, 0, 0}, {1.3, 0, 0}, {1.5, 0, 0}}, 0.2, 0.6};
  stroke.line = 2;
  return session;
}

TEST(Report, HasTheKeysOfTheCommand) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 2562);
  ReplayOptions options;
  options.motion.threads = 1;
  const ReplayResult result = replay(mesh, one_stroke(), options);
  const auto json = nlohmann::json::parse(to_json(make_report(mesh, result, options, {1, 2, 3, 6})));
  EXPECT_EQ(json.size(), 25u);
  EXPECT_EQ(json.at("vertices"), mesh.vertex_count());
  EXPECT_EQ(json.at("faces"), mesh.face_count());
  EXPECT_GT(json.at("moved_vertices"), 10);
  EXPECT_LT(json.at("moved_vertices"), mesh.vertex_count() / 2);
  EXPECT_EQ(json.at("strokes"), 1);
  EXPECT_EQ(json.at("segments"), 2);
  EXPECT_EQ(json.at("vertex_steps"), result.shape.work().accepted_steps);
  EXPECT_DOUBLE_EQ(json.at("steps_mean").get<double>() * static_cast<double>(mesh.vertex_count()),
                   json.at("vertex_steps").get<double>());
  EXPECT_GE(json.at("steps_max"), json.at("steps_mean"));
  EXPECT_GT(json.at("evaluations"), json.at("vertex_steps"));
  EXPECT_GE(json.at("rejected_steps"), 0);
  EXPECT_EQ(json.at("seconds"), (nlohmann::json{{"read", 1.0}, {"deform", 2.0}, {"write", 3.0}, {"total", 6.0}}));
  EXPECT_EQ(json.at("threads"), 1);
  EXPECT_EQ(json.at("simd"), simd_name());
  EXPECT_EQ(json.at("backend"), "cpu");
  EXPECT_EQ(json.at("precision"), "float");
  EXPECT_EQ(json.at("tolerance"), 1e-5);
  EXPECT_NEAR(json.at("volume_error").get<double>(), 0, 0.02);  // the sampling error of a coarse sphere
  EXPECT_DOUBLE_EQ(json.at("volume_error").get<double>(),
                   json.at("volume_after").get<double>() / json.at("volume_before").get<double>() - 1);
  EXPECT_GT(json.at("area_after"), json.at("area_before"));
  EXPECT_NEAR(json.at("max_displacement").get<double>(), 0.5, 1e-4);  // the rigid core's way
  EXPECT_EQ(json.at("flipped_triangles"), 0);
  EXPECT_TRUE(json.at("self_intersections_before").is_null());
  EXPECT_TRUE(json.at("self_intersections_after").is_null());
}

TEST(Report, HasNoVolumeErrorWhereTheShapeIsOpen) {
  Mesh mesh = make_shape(ShapeKind::sphere, 162);
  mesh.corner_vertex.resize(mesh.corner_vertex.size() - 3);
  mesh.face_begin.pop_back();
  const ReplayOptions options;
  const Report report = make_report(mesh, replay(mesh, one_stroke(), options), options, {});
  EXPECT_FALSE(report.volume_error);
  EXPECT_TRUE(nlohmann::json::parse(to_json(report)).at("volume_error").is_null());
  EXPECT_GT(report.threads, 0);
}

TEST(Report, OfNothingIsZero) {
  const ReplayOptions options;
  const Report report = make_report({}, replay(Mesh(), {}, options), options, {});
  EXPECT_EQ(report.vertices, 0u);
  EXPECT_EQ(report.steps_mean, 0);
  EXPECT_EQ(report.max_displacement, 0);
  EXPECT_FALSE(report.volume_error);
}

}  // namespace
}  // namespace knead
