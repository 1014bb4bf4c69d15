// Every function of the library that takes a mesh or points refuses what is none, whatever it is asked to do with it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/remesh.h"

namespace knead::invalid_mesh_test {
namespace {

const ImplicitStroke kPull{{{0, 0, 1}, {0, 0, 1.2}}, 0.2, 0.8};

Session session() {
  Session session;
  session.strokes.push_back({Stroke{kPull}});
  return session;
}

Mesh ball() { return make_shape(ShapeKind::sphere, 162); }

std::vector<Triangle> as_triangles(const Mesh& mesh) {
  std::vector<Triangle> triangles;
  for (std::size_t c = 0; c + 2 < mesh.corner_vertex.size(); c += 3) {
    triangles.push_back({mesh.corner_vertex[c], mesh.corner_vertex[c + 1], mesh.corner_vertex[c + 2]});
  }
  return triangles;
}

struct Door {
  const char* name;
  std::function<void(const Mesh&)> enter;
};

std::vector<Door> doors_of_meshes() {
  return {
      {"validate", [](const Mesh& m) { validate(m); }},
      {"measure", [](const Mesh& m) { measure(m); }},
      {"measure of the same faces", [](const Mesh& m) { measure(m, measure(ball())); }},
      {"volume and area", [](const Mesh& m) { measure_volume_and_area(m, m.positions); }},
      {"count_flipped", [](const Mesh& m) { count_flipped(m, m.positions, m.positions); }},
      {"count_folded_edges", [](const Mesh& m) { count_folded_edges(m); }},
      {"vertex_normals", [](const Mesh& m) { vertex_normals(m); }},
      {"some vertex_normals",
       [](const Mesh& m) { vertex_normals(m, m.positions, std::vector<bool>(m.vertex_count(), true)); }},
      {"transport_normals",
       [](const Mesh& m) {
         const std::vector<Vec3d> normals(m.vertex_count(), {0, 0, 1});
         transport_normals(m, m.positions, normals, m.corner_vertex);
       }},
      {"transport_tangents",
       [](const Mesh& m) {
         const std::vector<Vec3d> normals(m.vertex_count(), {0, 0, 1});
         transport_tangents(m, m.positions, normals, normals);
       }},
      {"triangulate", [](const Mesh& m) { triangulate(m); }},
      {"triangle_faces", [](const Mesh& m) { triangle_faces(m); }},
      {"find_creases", [](const Mesh& m) { find_creases(m); }},
      {"resolve", [](const Mesh& m) { resolve({}, m); }},
      {"remesh", [](const Mesh& m) { remesh(m, RemeshSettings{}); }},
      {"describe", [](const Mesh& m) { describe(m); }},
      {"check_surface", [](const Mesh& m) { check_surface(m, {}); }},
      {"replay", [](const Mesh& m) { replay(m, session()); }},
      {"replay with remesh",
       [](const Mesh& m) {
         ReplayOptions options;
         options.remesh.settings.emplace();
         replay(m, session(), options);
       }},
      {"DeformedShape", [](const Mesh& m) { DeformedShape(std::make_shared<const Mesh>(m)); }},
      {"Workbench", [](const Mesh& m) { Workbench bench(m); }},
      {"certify", [](const Mesh& m) { certify(m, m.positions, session()); }},
      {"distance_between", [](const Mesh& m) { distance_between(m, ball()); }},
      {"distance_between, second", [](const Mesh& m) { distance_between(ball(), m); }},
      {"fit_body", [](const Mesh& m) { fit_body(m, ball(), {}); }},
      {"fit_body, second", [](const Mesh& m) { fit_body(ball(), m, {}); }},
      {"serialize_mesh as PLY", [](const Mesh& m) { serialize_mesh("ply", m); }},
      {"serialize_mesh as OBJ", [](const Mesh& m) { serialize_mesh("obj", m); }},
      {"serialize_mesh as GLB", [](const Mesh& m) { serialize_mesh("glb", m); }},
      {"serialize_mesh as STL", [](const Mesh& m) { serialize_mesh("stl", m); }},
      {"serialize_mesh as OFF", [](const Mesh& m) { serialize_mesh("off", m); }},
      {"serialize_remeshed",
       [](const Mesh& m) {
         const ShapeFile source = parse_shape(serialize_mesh("ply", ball()), "ply", "ball");
         std::vector<std::uint32_t> faces(m.face_begin.empty() ? 0 : m.face_count());
         serialize_remeshed("ply", source, m, faces);
       }},
      {"SurfaceTree", [](const Mesh& m) { SurfaceTree(as_triangles(m), m.positions); }},
      {"self_intersections", [](const Mesh& m) { self_intersections(as_triangles(m), m.positions); }},
      {"check_limit_cylinder",
       [](const Mesh& m) {
         check_limit_cylinder({{0, 0, 0}, {0, 0, 1}, 0.5, 0.5, {0, 0, 1}}, m.positions, as_triangles(m));
       }},
      {"propose_limit_cylinder",
       [](const Mesh& m) {
         propose_limit_cylinder({{0, 0, 0}, {0, 0, 1}, 0.5, 0.5, {0, 0, 1}}, m.positions, as_triangles(m));
       }},
      {"place_limit_cylinder",
       [](const Mesh& m) {
         CylinderQuery query;
         query.direction = {0, 0, 1};
         place_limit_cylinder(query, m.positions, as_triangles(m));
       }},
      {"vertex_stretches", [](const Mesh& m) { vertex_stretches(as_triangles(m), m.positions, m.positions); }},
      {"zone_profile",
       [](const Mesh& m) {
         zone_profile(TwistStroke{{}, {0, 0, 1}, 60, -0.5, 0.5}, m.positions, as_triangles(m));
       }},
  };
}

std::string refusal(const std::function<void()>& enter) {
  try {
    enter();
    return "";
  } catch (const InvalidInput& error) {
    return error.what();
  }
}

TEST(Doors, AreOpenToAMesh) {
  for (const Door& door : doors_of_meshes()) {
    const std::string why = refusal([&] { door.enter(ball()); });
    EXPECT_TRUE(why.empty() || std::string_view(door.name) == "serialize_remeshed") << door.name << ": " << why;
  }
}

TEST(Doors, RefuseIndicesBeyondThePositionsWithTheNumber) {
  for (const std::uint32_t beyond : {162U, 1'000'000U, std::numeric_limits<std::uint32_t>::max()}) {
    Mesh mesh = ball();
    mesh.corner_vertex[100] = beyond;
    for (const Door& door : doors_of_meshes()) {
      const std::string why = refusal([&] { door.enter(mesh); });
      EXPECT_NE(why, "") << door.name << " takes index " << beyond;
      const bool has_number =
          why.find("100") != std::string::npos || why.find(std::to_string(beyond)) != std::string::npos;
      EXPECT_TRUE(has_number || why.find("33") != std::string::npos) << door.name << ": " << why;
    }
  }
}

// These give no normal, or nothing flipped, where a position is no number.
bool may_be_no_number(std::string_view name) {
  return name == "count_flipped" || name == "vertex_normals" || name == "some vertex_normals";
}

TEST(Doors, RefusePositionsThatAreNotFiniteWithTheNumber) {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    Mesh mesh = ball();
    const std::uint32_t v = mesh.corner_vertex[100];
    mesh.positions[v].y = bad;
    for (const Door& door : doors_of_meshes()) {
      if (may_be_no_number(door.name)) continue;
      const std::string why = refusal([&] { door.enter(mesh); });
      EXPECT_NE(why.find(std::to_string(v)), std::string::npos) << door.name << " takes " << bad << ": " << why;
    }
  }
}

TEST(Doors, RefuseFacesThatDoNotFollowEachOther) {
  std::vector<Mesh> meshes(3, ball());
  meshes[0].face_begin[20] = 1000;
  meshes[1].face_begin.back() += 3;
  meshes[2].face_begin.front() = 1;
  for (const Mesh& mesh : meshes) {
    for (const Door& door : doors_of_meshes()) {
      const std::string name = door.name;
      const bool takes_triangles = name == "SurfaceTree" || name == "self_intersections" ||
                                   name == "check_limit_cylinder" || name == "propose_limit_cylinder" ||
                                   name == "place_limit_cylinder" || name == "vertex_stretches" ||
                                   name == "zone_profile";
      if (takes_triangles) continue;
      EXPECT_NE(refusal([&] { door.enter(mesh); }), "") << name;
    }
  }
}

TEST(Doors, RefuseSpansOfAnotherSize) {
  const Mesh mesh = ball();
  const std::vector<Vec3d> few(mesh.vertex_count() - 1);
  const std::vector<Vec3d> enough(mesh.vertex_count());
  const std::vector<Door> doors{
      {"vertex_normals", [&](const Mesh& m) { vertex_normals(m, few); }},
      {"flags", [&](const Mesh& m) { vertex_normals(m, m.positions, std::vector<bool>(3)); }},
      {"transport_normals", [&](const Mesh& m) { transport_normals(m, few, enough, m.corner_vertex); }},
      {"normals", [&](const Mesh& m) { transport_normals(m, m.positions, few, m.corner_vertex); }},
      {"corners", [&](const Mesh& m) { transport_normals(m, m.positions, enough, {}); }},
      {"transport_tangents", [&](const Mesh& m) { transport_tangents(m, m.positions, few, enough); }},
      {"volume and area", [&](const Mesh& m) { measure_volume_and_area(m, few); }},
      {"count_flipped", [&](const Mesh& m) { count_flipped(m, m.positions, few); }},
      {"vertex_stretches", [&](const Mesh& m) { vertex_stretches(as_triangles(m), m.positions, few); }},
      {"certify", [&](const Mesh& m) { certify(m, few, session()); }},
  };
  for (const Door& door : doors) EXPECT_NE(refusal([&] { door.enter(mesh); }), "") << door.name;
}

TEST(Doors, RefusePointsThatAreNotFinite) {
  const Flow flow = flow_of(Stroke{kPull});
  std::vector<Vec3d> points(10, {0, 0, 1});
  points[7].z = std::nan("");
  const std::vector<Door> doors{
      {"advect", [&](const Mesh&) { advect(flow, std::span(points), {.tolerance = 1e-5}); }},
      {"velocities", [&](const Mesh&) { velocities(flow, points, 0.5); }},
      {"jacobians", [&](const Mesh&) { jacobians(flow, points, {.tolerance = 1e-5}); }},
      {"PointBlocks", [&](const Mesh&) { PointBlocks{points}; }},
      {"stretches_of", [&](const Mesh&) { stretches_of(flow, points, {.length = 1}); }},
  };
  for (const Door& door : doors) {
    const std::string why = refusal([&] { door.enter({}); });
    EXPECT_NE(why.find("point"), std::string::npos) << door.name << ": " << why;
  }
}

TEST(Doors, RefuseOtherPointsThanThoseOfTheBlocks) {
  const Flow flow = flow_of(Stroke{kPull});
  std::vector<Vec3d> points(10, {0, 0, 1});
  PointBlocks blocks(points);
  points.pop_back();
  EXPECT_NE(refusal([&] { advect(flow, blocks, points, {.tolerance = 1e-5}); }), "");
  EXPECT_NE(refusal([&] { blocks.update(points); }), "");
}

}  // namespace
}  // namespace knead::invalid_mesh_test
