// Which meshes validate() accepts, and how it names what is wrong.
#include "knead/mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "knead/error.h"

namespace knead::mesh_test {
namespace {

std::string refusal(const Mesh& mesh) {
  try {
    validate(mesh);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(ValidMesh, HasItsInvariants) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::hand, ShapeKind::torus}) {
    EXPECT_EQ(refusal(make_shape(kind, 4000)), "");
  }
  EXPECT_EQ(refusal({}), "");
}

TEST(ValidMesh, IsRefusedWithTheElementAtFault) {
  const Mesh good = make_shape(ShapeKind::sphere, 642);
  struct Case {
    const char* said;
    std::function<void(Mesh&)> spoil;
  };
  for (const Case& each : {
           Case{"vertex 17 ", [](Mesh& m) { m.positions[17].y = std::nan(""); }},
           Case{"vertex 18 ", [](Mesh& m) { m.positions[18].z = -kInfinity; }},
           Case{"corner 5 ", [](Mesh& m) { m.corner_vertex[5] = 642; }},
           Case{"face 7 ", [](Mesh& m) { m.face_begin[8] = 0; }},
           Case{"begin with 0", [](Mesh& m) { m.face_begin[0] = 1; }},
           Case{"begin with 0", [](Mesh& m) { m.face_begin.clear(); }},
           Case{"the last face", [](Mesh& m) { m.corner_vertex.pop_back(); }},
           Case{"\"weight\"",
                [](Mesh& m) {
                  m.attributes.push_back({"weight", Domain::face, {}, 2, {1, 2, 3}});
                }},
       }) {
    Mesh bad = good;
    each.spoil(bad);
    EXPECT_NE(refusal(bad).find(each.said), std::string::npos) << each.said << ": " << refusal(bad);
  }
}

}  // namespace
}  // namespace knead::mesh_test
