// Sessions of every tool on real meshes against an independent integration (oracle.h), through the session's own path:
// text, strokes, segments, advection. Vertices are sampled, those that span the box always among them; a mesh's
// diagonal is then that of the whole.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <map>

#include "agreement/oracle.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "knead/vec.h"
#include "support/test_meshes.h"

namespace knead::agreement_test {
namespace {

std::string text(const Vec3d& v) { return fmt::format("[{},{},{}]", v.x, v.y, v.z); }

// A mesh's box and some of its surface points, from which strokes are made to its measure.
struct Subject {
  Mesh samples;  // vertices only
  double diagonal = 0;
  Vec3d center;
  std::vector<Vec3d> point;  // a few surface points with their normals
  std::vector<Vec3d> normal;
};

Subject make_subject(const Mesh& mesh, std::size_t count) {
  Subject subject;
  const Box box = bounding_box(mesh.positions);
  subject.diagonal = box.diagonal();
  subject.center = box.center();
  const auto spans_box = [&](const Vec3d& p) {
    return p.x == box.min.x || p.y == box.min.y || p.z == box.min.z || p.x == box.max.x || p.y == box.max.y ||
           p.z == box.max.z;
  };
  const std::size_t stride = std::max<std::size_t>(1, mesh.vertex_count() / count);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    if (i % stride == 0 || spans_box(mesh.positions[i])) subject.samples.positions.push_back(mesh.positions[i]);
  }
  const std::vector<Vec3d> normals = vertex_normals(mesh);
  for (const double at : {0.11, 0.37, 0.52, 0.83}) {
    const auto i = static_cast<std::size_t>(at * static_cast<double>(mesh.vertex_count()));
    subject.point.push_back(mesh.positions[i]);
    subject.normal.push_back(normals[i]);
  }
  return subject;
}

using Lines = std::vector<std::string>;

// Strong strokes of every tool, lengths relative to the box diagonal.
std::map<std::string, Lines> sessions_for(const Subject& s) {
  const double d = s.diagonal;
  const Vec3d& c = s.center;
  const auto& p = s.point;
  const auto& n = s.normal;
  std::map<std::string, Lines> result;
  result["implicit ball"] = {fmt::format(R"({{"tool":"implicit","inner":{},"outer":{},"path":[{},{},{}]}})", 0.04 * d,
                                         0.2 * d, text(p[0]), text(p[0] + n[0] * (0.1 * d)),
                                         text(p[0] + n[0] * (0.15 * d) + Vec3d{0.05 * d, 0.05 * d, 0}))};
  result["implicit through"] = {fmt::format(R"({{"tool":"implicit","inner":{},"outer":{},"path":[{},{}]}})", 0.06 * d,
                                            0.15 * d, text(c + Vec3d{-0.7, 0.05, 0} * d),
                                            text(c + Vec3d{0.3, 0, 0.1} * d))};
  result["implicit capsule"] = {fmt::format(
      R"({{"tool":"implicit","inner":{},"outer":{},"region":"capsule","half_axis":{},"gauge":0.25,"path":[{},{}]}})",
      0.03 * d, 0.12 * d, text(Vec3d{0.05, 0.1, 0.02} * d), text(p[1]), text(p[1] + n[1] * (0.12 * d)))};
  result["implicit blended"] = {
      fmt::format(R"({{"tool":"implicit","inner":{},"outer":{},"time":"blended","path":[{},{},{}]}})", 0.05 * d,
                  0.2 * d, text(p[2]), text(p[2] + n[2] * (0.04 * d)), text(p[2] + n[2] * (0.08 * d)))};
  result["wide ball"] = {fmt::format(R"({{"tool":"implicit","falloff":"wide","bump":{},"outer":{},"path":[{},{},{}]}})",
                                     0.07 * d, 0.25 * d, text(p[0]), text(p[0] + n[0] * (0.1 * d)),
                                     text(p[0] + n[0] * (0.15 * d) + Vec3d{0.05 * d, 0.05 * d, 0}))};
  result["wide blended"] = {
      fmt::format(R"({{"tool":"implicit","falloff":"wide","bump":{},"time":"blended","path":[{},{}]}})", 0.06 * d,
                  text(p[2]), text(p[2] + n[2] * (0.05 * d)))};
  Lines paint;
  for (std::size_t i = 0; i < p.size(); ++i) {
    paint.push_back(fmt::format(R"({{"tool":"paint","outer":{},"depth":{},"samples":[{{"point":{},"normal":{}}}]}})",
                                0.1 * d, (i % 2 == 0 ? -0.04 : 0.04) * d, text(p[i]), text(n[i])));
  }
  result["paint"] = paint;
  Lines wide_paint;
  for (std::size_t i = 0; i < p.size(); ++i) {
    wide_paint.push_back(fmt::format(
        R"({{"tool":"paint","falloff":"wide","bump":{},"depth":{},"samples":[{{"point":{},"normal":{}}}]}})", 0.06 * d,
        (i % 2 == 0 ? -0.04 : 0.04) * d, text(p[i]), text(n[i])));
  }
  result["wide paint"] = wide_paint;
  result["points"] = {fmt::format(
      R"({{"tool":"points","outer":{},"points":[{},{},{}],"displacements":[{},{}],"exponent":6}})", 0.12 * d,
      text(p[0]), text(p[0] + Vec3d{0.05, 0, 0} * d), text(p[3]), text(n[0] * (0.05 * d)), text(n[3] * (0.05 * d)))};
  result["points with curves"] = {
      fmt::format(R"({{"tool":"points","outer":{},"points":[{}],"curves":[[{},{},{}]],"displacements":[{}]}})",
                  0.12 * d, text(p[1] + Vec3d{0.02, 0.03, 0} * d), text(p[1]), text(p[1] + Vec3d{0.06, 0.01, 0} * d),
                  text(p[1] + Vec3d{0.1, 0.08, 0.02} * d), text(n[1] * (0.06 * d)))};
  const std::string full =
      fmt::format("[{},{},{}]", text(p[0]), text(p[0] + Vec3d{0.04, 0, 0.01} * d), text(p[0] + Vec3d{0, 0.05, 0} * d));
  const std::string zero = fmt::format("[{},{},{},{}]", text(p[1]), text(p[2]), text(p[3]), text(c));
  result["handles"] = {fmt::format(R"({{"tool":"handles","full":{},"zero":{},"motion":{{"translate":{}}}}})", full,
                                   zero, text(n[0] * (0.15 * d) + Vec3d{0, 0.02, 0.05} * d))};
  result["turned handles"] = {fmt::format(
      R"({{"tool":"handles","full":{},"zero":{},"exponent":6,"motion":{{"rotate":[1,-0.5,2],"center":{},"angle_deg":70}}}})",
      full, zero, text(p[0] + Vec3d{0.05, 0.02, 0.03} * d))};
  result["rotate"] = {fmt::format(
      R"({{"tool":"rotate","center":{},"axis":[1,2,-1],"angle_deg":110,"inner":{},"outer":{},"gauge":0.5}})",
      text(p[2]), 0.1 * d, 0.25 * d)};
  result["stretch"] = {
      fmt::format(R"({{"tool":"stretch","center":{},"axis":[0,1,1],"factor":1.7,"inner":{},"outer":{}}})", text(p[3]),
                  0.08 * d, 0.25 * d)};
  result["twist"] = {fmt::format(R"({{"tool":"twist","center":{},"axis":[0,2,0],"rate_deg":{},"inner":{},"outer":{}}})",
                                 text(c), 120 / d, -0.1 * d, 0.15 * d)};
  result["oblique twist"] = {fmt::format(
      R"({{"tool":"twist","center":{},"axis":[0,2,0],"normal":[0.3,1,0],"rate_deg":{},"inner":{},"outer":{},"gauge":1}})",
      text(c), 80 / d, -0.15 * d, 0.15 * d)};
  result["bend"] = {
      fmt::format(R"({{"tool":"bend","center":{},"axis":[0,0,3],"normal":[0,-1,0],"angle_deg":60,"width":{}}})",
                  text(c + Vec3d{0, 0.1, 0} * d), 0.4 * d)};
  result["bend in a cylinder"] = {fmt::format(
      R"({{"tool":"bend","center":{},"axis":[0,0,3],"normal":[0,-1,0],"angle_deg":-45,"width":{},"radius":{},"gauge":0}})",
      text(c + Vec3d{0, 0.1, 0} * d), 0.3 * d, 0.2 * d)};
  result["pins"] = {fmt::format(R"({{"tool":"pins","points":[{},{},{}],"to":[{},{},{}],"radius":{}}})", text(p[0]),
                                text(p[1]), text(p[2]), text(p[0] + n[0] * (0.15 * d)),
                                text(p[1] + Vec3d{0.06, -0.04, 0.03} * d), text(p[2]), 0.6 * d)};
  Lines all;
  for (const char* name : {"implicit ball", "rotate", "points", "stretch", "implicit capsule"}) {
    all.insert(all.end(), result[name].begin(), result[name].end());
  }
  result["several strokes"] = all;
  Lines steep;
  int falloff = 2;
  for (const char* name : {"implicit capsule", "rotate", "points", "stretch", "twist"}) {
    for (const std::string& line : result[name]) {
      steep.push_back(fmt::format(R"({},"falloff":{}}})", line.substr(0, line.size() - 1), ++falloff));
    }
  }
  result["every falloff"] = steep;
  return result;
}

double greatest_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::fmax(worst, norm(a[i] - b[i]));
  return worst;
}

void expect_agreement(const Mesh& mesh, const std::string& mesh_name) {
  const Subject subject = make_subject(mesh, 250);
  for (const auto& [name, lines] : sessions_for(subject)) {
    SCOPED_TRACE(mesh_name + ", " + name);
    std::string session_text = "{\"knead\": 1}\n";
    for (const std::string& line : lines) session_text += line + "\n";
    const Session session = parse_session(session_text, "test.knead");
    const auto exact = oracle::deform(lines, subject.samples.positions, subject.diagonal);
    ReplayOptions options;
    const auto by_default = replay(subject.samples, session, options);
    ASSERT_EQ(by_default.status, AdvectStatus::done);
    EXPECT_LT(greatest_distance(by_default.shape.positions(), exact) / subject.diagonal, 2e-5);
    EXPECT_GT(greatest_distance(exact, subject.samples.positions) / subject.diagonal, 0.02);  // something happened
    options.motion.precision = Precision::float64;
    options.motion.relative_tolerance = 1e-10;
    const auto precise = replay(subject.samples, session, options);
    EXPECT_LT(greatest_distance(precise.shape.positions(), exact) / subject.diagonal, 1e-8);
    if (name == "bend in a cylinder")
      continue;  // a scan that crosses the limit cylinder is torn, so it has no way back
    Mesh deformed = subject.samples;
    deformed.positions = precise.shape.positions();
    options.part.direction = Direction::backwards;
    EXPECT_LT(greatest_distance(replay(deformed, session, options).shape.positions(), subject.samples.positions) /
                  subject.diagonal,
              1e-8);
    deformed.positions = by_default.shape.positions();
    ReplayOptions back;
    back.part.direction = Direction::backwards;
    EXPECT_LT(greatest_distance(replay(deformed, session, back).shape.positions(), subject.samples.positions) /
                  subject.diagonal,
              2e-5);
  }
}

TEST(Agreement, OnTheMadeHand) { expect_agreement(make_shape(ShapeKind::hand), "hand"); }

TEST(Agreement, OnTheMadeKnot) { expect_agreement(make_shape(ShapeKind::knot), "knot"); }

class AgreementOnScans : public testing::TestWithParam<std::string> {};

TEST_P(AgreementOnScans, WithinTheBars) {
  const auto path = test_mesh(GetParam());
  KNEAD_NEEDS_TEST_MESH(GetParam());
  expect_agreement(read_shape(path).mesh, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Meshes, AgreementOnScans,
                         testing::Values("bunny_35k.ply", "armadillo_43k.ply", "hand_50k.ply", "fandisk_6k.ply",
                                         "dragon_50k.ply", "camel_35k.ply"),
                         [](const auto& test) { return test.param.substr(0, test.param.find('.')); });

}  // namespace
}  // namespace knead::agreement_test
