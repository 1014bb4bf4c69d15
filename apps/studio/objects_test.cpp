// Several objects in one document: one session moves all, and everything that is written holds all.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "knead/error.h"
#include "studio_fixture.h"

namespace knead::studio::objects_test {

namespace {

class ObjectsTest : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    Mesh mesh = make_shape(ShapeKind::sphere, 2562);
    write_mesh(folder_ / "body.ply", mesh, {true, {}});
    // Turned, so that no vertex lies above another one.
    for (Vec3d& p : mesh.positions) {
      p = Vec3d{0.8 * p.x - 0.6 * p.y, 0.48 * p.x + 0.64 * p.y - 0.6 * p.z, 0.36 * p.x + 0.48 * p.y + 0.8 * p.z} * 1.1;
    }
    write_mesh(folder_ / "shirt.obj", mesh, {true, {}});
  }

  std::string file(const std::string& name) const { return "\"" + (folder_ / name).string() + "\""; }
  std::string open() const {
    return R"({"size": [800, 600]}
{"open": )" +
           file("body.ply") + "}\n{\"add\": " + file("shirt.obj") + R"(}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"set": {"radius": 0.5, "inner_ratio": 0.4}}
)";
  }
  // The shapes as one, as they were opened.
  Mesh together() const {
    const Mesh body = read_shape(folder_ / "body.ply").mesh;
    const Mesh shirt = read_shape(folder_ / "shirt.obj").mesh;
    const std::vector<const Mesh*> meshes{&body, &shirt};
    return JoinedMeshes(meshes).mesh();
  }
  // How far from the middle the pointer meets something in the middle of the view.
  static double met(const Studio& studio) {
    const DocumentState& shown = studio.document().shown();
    const auto hit = shown.picker->pick(ray_through(studio.view().screen(), 400, 300), shown.state);
    return hit ? norm(hit->point) : 0;
  }
};

constexpr const char* kPull = R"({"tool": "ball"}
{"drag": [[400, 300], [520, 240]]}
)";
constexpr const char* kPaint = R"({"tool": "paint"}
{"set": {"depth": 0.1}}
{"drag": [[340, 300], [460, 330]]}
)";

TEST_F(ObjectsTest, OneSessionMovesAllAndReplaysToTheSameBits) {
  for (const bool has_worker : {false, true}) {
    Studio studio(options(has_worker));
    run(studio, open() + kPull + kPaint);
    ASSERT_EQ(errors(studio), "");
    const DocumentState& shown = studio.document().shown();
    ASSERT_EQ(shown.objects.list.size(), 2U);
    EXPECT_EQ(shown.objects.list[1].name, "shirt.obj");
    ASSERT_EQ(shown.history.size(), 2U);
    const std::vector<Vec3d> after = positions(studio);
    const Mesh start = together();
    ASSERT_EQ(after.size(), start.vertex_count());
    const auto moved = [&](std::size_t from, std::size_t to) {
      std::size_t count = 0;
      for (std::size_t v = from; v < to; ++v) count += after[v] == start.positions[v] ? 0 : 1;
      return count;
    };
    EXPECT_GT(moved(0, 2562), 50U);
    EXPECT_GT(moved(2562, after.size()), 50U);

    run(studio, R"({"save": )" + file("work.knead") + "}");
    const Session session = read_session(folder_ / "work.knead");
    EXPECT_EQ(session.mesh, "body.ply");
    EXPECT_EQ(session.also, std::vector<std::string>{"shirt.obj"});
    EXPECT_TRUE(replay(start, session).shape.positions() == after);
    Studio again(options(has_worker));
    run(again, R"({"open": )" + file("work.knead") + "}");
    EXPECT_EQ(again.document().shown().objects.list.size(), 2U);
    EXPECT_TRUE(positions(again) == after);
    again.document().close();

    run(studio, R"({"key": "Ctrl+Z"}
{"key": "Ctrl+Z"})");
    EXPECT_TRUE(positions(studio) == start.positions);
    run(studio, R"({"key": "Ctrl+Shift+Z"}
{"key": "Ctrl+Shift+Z"})");
    EXPECT_TRUE(positions(studio) == after);
    studio.document().close();
  }
}

TEST_F(ObjectsTest, TheHistoryMovesAShapeThatIsAddedLater) {
  Studio early(options());
  run(early, open() + kPull + R"({"save": )" + file("work.knead") + "}");
  Studio late(options());
  run(late, R"({"size": [800, 600]}
{"open": )" + file("body.ply") +
                "}\n");
  Session session = read_session(folder_ / "work.knead");
  session.also.clear();
  write_file_atomically(folder_ / "alone.knead", serialize_session(session));
  run(late, R"({"open": )" + file("alone.knead") + "}\n");
  ASSERT_EQ(late.document().shown().history.size(), 1U);
  const double before = late.document().shown().diagonal;
  run(late, R"({"add": )" + file("shirt.obj") + "}");
  EXPECT_EQ(errors(late), "");
  EXPECT_GT(late.document().shown().diagonal, before);
  EXPECT_EQ(late.document().shown().history.size(), 1U);
  EXPECT_TRUE(positions(late) == positions(early));
  EXPECT_TRUE(late.document().shown().is_changed);
  run(late, R"({"key": "Ctrl+Z"})");
  EXPECT_TRUE(positions(late) == together().positions);
}

TEST_F(ObjectsTest, TheOthersStayAsTheyAreWhenOneIsRemoved) {
  for (const bool has_worker : {false, true}) {
    Studio studio(options(has_worker));
    run(studio, open() + kPull + R"({"object": 1, "active": true})");
    const std::vector<Vec3d> both = positions(studio);
    run(studio, R"({"object": 0, "remove": true})");
    EXPECT_EQ(errors(studio), "");
    const DocumentState& shown = studio.document().shown();
    ASSERT_EQ(shown.objects.list.size(), 1U);
    EXPECT_EQ(shown.objects.list.front().name, "shirt.obj");
    EXPECT_EQ(shown.objects.active, 0U);
    ASSERT_EQ(shown.history.size(), 1U);
    const std::vector<Vec3d> shirt = positions(studio);
    EXPECT_TRUE(std::equal(shirt.begin(), shirt.end(), both.begin() + 2562, both.end()));
    run(studio, R"({"save": )" + file("shirt.knead") + "}");
    const Session session = read_session(folder_ / "shirt.knead");
    EXPECT_EQ(session.mesh, "shirt.obj");
    EXPECT_TRUE(session.also.empty());
    run(studio, R"({"object": 0, "remove": true})");  // the only one
    EXPECT_EQ(shown.objects.list.size(), 1U);
    run(studio, R"({"add": )" + file("body.ply") + "}");
    EXPECT_EQ(positions(studio).size(), both.size());
    studio.document().close();
  }
}

TEST_F(ObjectsTest, WhatHasNoFileIsNotRemoved) {
  Studio studio(options());
  run(studio, R"({"new": "sphere", "vertices": 2562}
{"add": )" + file("shirt.obj") +
                  "}");
  run(studio, R"({"object": 0, "remove": true})");
  EXPECT_NE(errors(studio).find("has no file"), std::string::npos) << errors(studio);
  EXPECT_EQ(studio.document().shown().objects.list.size(), 2U);
}

TEST_F(ObjectsTest, ThePointerMeetsWhatIsVisibleOrActive) {
  Studio studio(options());
  run(studio, open());
  EXPECT_NEAR(met(studio), 1.1, 0.01);
  run(studio, R"({"object": 1, "visible": false})");
  EXPECT_NEAR(met(studio), 1, 0.01);
  EXPECT_EQ(visible_mesh(studio.document().shown().objects, studio.document().shown().state).face_count(), 5120U);
  run(studio, R"({"object": 1, "visible": true}
{"object": 0, "active": true})");
  EXPECT_NEAR(met(studio), 1, 0.01) << "through the other one";
  EXPECT_EQ(visible_mesh(studio.document().shown().objects, studio.document().shown().state).face_count(), 10240U);
  run(studio, kPull);
  EXPECT_NEAR(met(studio), 1, 0.5);
  EXPECT_EQ(studio.document().shown().picker->triangles().size(), 5120U) << "also of the shape after a stroke";
  run(studio, R"({"object": null})");
  EXPECT_EQ(studio.document().shown().picker->triangles().size(), 10240U);
  EXPECT_THROW(run(studio, R"({"object": 2, "visible": true})"), InvalidInput);
  EXPECT_FALSE(studio.document().shown().objects.active);
}

// A hidden object moves, too; with remeshing each face still belongs to its object.
TEST_F(ObjectsTest, HiddenObjectsMoveAndRemeshedOnesStayApart) {
  Studio studio(options());
  run(studio, open() + R"({"object": 1, "visible": false}
{"set": {"remesh": true, "max_edge": 0.05}}
)" + kPull);
  ASSERT_EQ(errors(studio), "");
  const DocumentState& shown = studio.document().shown();
  ASSERT_NE(shown.state.provenance, nullptr);
  const std::size_t all = shown.state.mesh->face_count();
  const std::size_t seen = visible_mesh(shown.objects, shown.state).face_count();
  EXPECT_GT(seen, 5120U);
  EXPECT_GT(all - seen, 5120U);
  run(studio, R"({"export": )" + file("out.ply") + "}");
  EXPECT_EQ(read_shape(folder_ / "out_body.ply").mesh.face_count(), seen);
  EXPECT_EQ(read_shape(folder_ / "out_shirt.ply").mesh.face_count(), all - seen);
  EXPECT_FALSE(fs::exists(folder_ / "out.ply"));
}

TEST_F(ObjectsTest, WritesAllObjects) {
  Studio studio(options());
  run(studio, open() + kPull + R"({"export": )" + file("out.obj") + "}");
  ASSERT_EQ(errors(studio), "");
  const std::vector<Vec3d> after = positions(studio);
  const Mesh body = read_shape(folder_ / "out_body.obj").mesh;
  const Mesh shirt = read_shape(folder_ / "out_shirt.obj").mesh;
  EXPECT_TRUE(std::equal(body.positions.begin(), body.positions.end(), after.begin()));
  EXPECT_TRUE(std::equal(shirt.positions.begin(), shirt.positions.end(), after.begin() + 2562));
  FrameExport how;
  how.frames = 3;
  studio.document().export_frames(folder_ / "motion.glb", how);
  studio.document().export_frames(folder_ / "frame.ply", how);
  run(studio, "");
  EXPECT_EQ(errors(studio), "");
  for (const char* name : {"motion_body.glb", "motion_shirt.glb", "frame_0000_body.ply", "frame_0002_shirt.ply"}) {
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  }
  // A folder in the place of one file: nothing is written.
  fs::create_directory(folder_ / "none_shirt.ply");
  run(studio, R"({"export": )" + file("none.ply") + "}");
  EXPECT_NE(errors(studio).find("none_shirt.ply"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "none_body.ply"));
}

TEST_F(ObjectsTest, SaysWhatCrossesBetweenObjects) {
  Studio studio(options());
  run(studio, open() + R"({"tool": "ball"}
{"set": {"radius": 0.9, "inner_ratio": 0.2}}
{"drag": [[400, 300], [700, 300]]}
)");
  studio.document().take_notices();
  studio.document().count_crossings();
  run(studio, "");
  std::string told;
  for (const Notice& notice : studio.document().take_notices()) told += notice.text;
  EXPECT_NE(told.find("between objects"), std::string::npos) << told;
}

TEST_F(ObjectsTest, ACrashKeepsAllObjects) {
  std::vector<Vec3d> after;
  {
    Studio studio(options());
    run(studio, open() + kPull + kPaint);
    after = positions(studio);
  }
  Studio next(options());
  ASSERT_EQ(next.document().abandoned().size(), 1U);
  EXPECT_EQ(next.document().abandoned()[0].problem, "");
  run(next, R"({"recover": "newest"})");
  EXPECT_EQ(errors(next), "");
  EXPECT_EQ(next.document().shown().objects.list.size(), 2U);
  EXPECT_EQ(next.document().shown().history.size(), 2U);
  EXPECT_TRUE(positions(next) == after);
  run(next, R"({"save": )" + file("recovered.knead") + "}");
  const Session session = read_session(folder_ / "recovered.knead");
  EXPECT_EQ(session.mesh, "recovered_shape.ply");
  EXPECT_EQ(session.also, std::vector<std::string>{"recovered_shape_2.obj"});
  EXPECT_TRUE(replay(together(), session).shape.positions() == after);
}

TEST_F(ObjectsTest, WhatCannotBeAddedLeavesTheDocument) {
  Studio studio(options());
  run(studio, open() + kPull);
  const std::vector<Vec3d> after = positions(studio);
  write_file_atomically(folder_ / "cloud.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  run(studio, R"({"add": )" + file("cloud.xyz") + "}");
  EXPECT_NE(errors(studio).find("point cloud cannot be one of several"), std::string::npos);
  run(studio, R"({"add": )" + file("missing.ply") + "}");
  EXPECT_NE(errors(studio).find("missing.ply"), std::string::npos);
  EXPECT_EQ(studio.document().shown().objects.list.size(), 2U);
  EXPECT_TRUE(positions(studio) == after);
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_TRUE(positions(studio) == together().positions);
}

TEST_F(ObjectsTest, SeveralShapesCanBeDroppedAtOnce) {
  Studio studio(options());
  run(studio, R"({"drop": [)" + file("body.ply") + ", " + file("shirt.obj") + "]}");
  EXPECT_EQ(studio.document().shown().objects.list.size(), 2U);
}

}  // namespace

}  // namespace knead::studio::objects_test
