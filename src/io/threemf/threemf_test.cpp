// Tests of 3MF: archives, placements, properties of triangles, and what stays byte for byte.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/codec.h"
#include "io/test_samples.h"
#include "io/threemf/zip.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/shape_promises.h"
#include "support/split_faces.h"

namespace knead::threemf_test {

namespace {

std::string part_of(const std::string& bytes, const std::string& part) {
  const std::string name = "test.3mf";
  const detail::zip::Archive archive(bytes, name);
  return archive.content(*archive.find(part));
}

ShapeFile parsed(const std::string& bytes) { return parse_shape(bytes, "3mf", "a.3mf"); }

std::string refusal(const std::string& bytes) {
  try {
    parsed(bytes);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "read";
}

std::string model_file(const std::string& model) { return threemf_file({{"3D/3dmodel.model", model}}); }

// Every byte of every text, packed anew so that its checksum holds.
TEST(ThreeMf, DamagedModelsAreRefusedOrKeepTheirPromises) {
  for (const Sample& sample : threemf_samples()) {
    const std::string name = "sample";
    const detail::zip::Archive archive(sample.bytes, name);
    for (const detail::zip::Entry& entry : archive.entries()) {
      const std::string sound = archive.content(entry);
      for (std::size_t i = 0; i < sound.size(); ++i) {
        for (const char value : {'\0', '\n', ' ', '-', '9', '"', '<', '>', '/', '\xff'}) {
          std::string damaged = sound;
          damaged[i] = value;
          const std::string bytes = archive.with({{&entry, damaged}});
          try {
            const ShapeFile shape = parsed(bytes);
            ASSERT_EQ(broken_promise(shape), "") << damaged;
          } catch (const InvalidInput& error) {
            ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
          }
        }
      }
    }
  }
}

TEST(ThreeMf, ANumberOfAVertexIsReplacedAndNothingElse) {
  const ShapeFile shape = parsed(threemf_samples()[1].bytes);
  ASSERT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 0, 0.5}, {1, 0, 0}, {0, 1, 0}}));
  std::vector<Vec3d> moved = shape.mesh.positions;
  moved[2].y = 1.25;
  const std::string bytes = serialize_shape("3mf", shape, moved);
  std::string expected = part_of(shape.bytes, "m");
  const std::size_t at = expected.find("y=\"1\"");
  expected.replace(at, 5, "y=\"1.25\"");
  EXPECT_EQ(part_of(bytes, "m"), expected);
  EXPECT_EQ(part_of(bytes, "Metadata/a.png"), "\x89PNG");
}

// Two triangles: one of another part, mirrored, turned and scaled by two transforms, and one as it is.
TEST(ThreeMf, PlacementsAreAppliedAndTakenBack) {
  const ShapeFile shape = parsed(threemf_samples()[3].bytes);
  ASSERT_EQ(shape.mesh.face_count(), 2u);
  // (1, 0, 0) goes by the component to (1, 3, 1), then by the item to (6, 3, -0.9).
  EXPECT_NEAR(norm(shape.mesh.positions[1] - Vec3d{6, 3, -0.9}), 0, 1e-15);
  EXPECT_EQ(shape.mesh.positions[4], (Vec3d{1, 0, 0}));
  const auto first = shape.mesh.face(0);
  EXPECT_EQ(std::vector<std::uint32_t>(first.begin(), first.end()), (std::vector<std::uint32_t>{0, 2, 1}))
      << "mirrored";
  std::vector<Vec3d> moved = shape.mesh.positions;
  moved[1] += Vec3d{0.5, 0.25, 0};
  const std::string bytes = serialize_shape("3mf", shape, moved);
  const ShapeFile back = parsed(bytes);
  for (std::size_t v = 0; v < moved.size(); ++v) EXPECT_NEAR(norm(back.mesh.positions[v] - moved[v]), 0, 1e-15);
  EXPECT_EQ(part_of(bytes, "3D/3dmodel.model"), part_of(shape.bytes, "3D/3dmodel.model"));
  const Remade remade = split_all(shape.mesh);
  const ShapeFile split = parsed(serialize_remeshed("3mf", shape, remade.mesh, remade.face_source));
  EXPECT_EQ(split.mesh.face_count(), 6u);
  EXPECT_NEAR(measure(split.mesh).area, measure(shape.mesh).area, 1e-6);
}

TEST(ThreeMf, TrianglesKeepTheirPropertiesWhenTheyAreDivided) {
  const ShapeFile shape = parsed(threemf_samples()[2].bytes);
  EXPECT_EQ(shape.notes, std::vector<std::string>{"its unit is the inch, and so is that of all lengths"});
  const Attribute* color = shape.mesh.find_attribute("color");
  ASSERT_NE(color, nullptr);
  EXPECT_EQ(color->domain, Domain::corner);
  EXPECT_EQ(std::vector<double>(color->values.begin(), color->values.begin() + 8),
            (std::vector<double>{255, 0, 0, 255, 0, 255, 0, 128}));
  EXPECT_EQ(face_labels(shape), (std::vector<std::uint32_t>{1, 0}));
  EXPECT_FALSE(remesh_losses("a.3mf", shape).empty());
  const Remade remade = split_faces(shape.mesh, [](std::uint32_t f) { return f == 0; });
  const std::string text =
      part_of(serialize_remeshed("3mf", shape, remade.mesh, remade.face_source), "3D/3dmodel.model");
  EXPECT_NE(text.find("<triangle v1=\"0\" v2=\"1\" v3=\"3\" pid='5' p1='0' paint_color=\"8\"/>"), std::string::npos)
      << text;
  EXPECT_NE(text.find("<triangle v1=\"0\" v2=\"2\" v3=\"1\"/></triangles>"), std::string::npos) << text;
  EXPECT_NE(text.find("<metadata name='a'>&lt;b></metadata>\r\n"), std::string::npos) << text;
}

// Volumes of a slicer are ranges of triangles, which move with them.
TEST(ThreeMf, ASlicersVolumesAreNumberedAnew) {
  const std::string config =
      "<config><object id=\"2\"><volume firstid=\"0\" lastid=\"0\"><metadata key=\"name\" value=\"a\"/></volume>"
      "<volume firstid=\"1\" lastid=\"1\"/></object><object id=\"7\"><volume firstid=\"1\" "
      "lastid=\"1\"/></object></config>";
  const ShapeFile shape =
      parsed(threemf_file({{"3D/3dmodel.model", part_of(threemf_samples()[2].bytes, "3D/3dmodel.model")},
                           {"Metadata/Slic3r_PE_model.config", config}}));
  const Remade remade = split_faces(shape.mesh, [](std::uint32_t f) { return f == 0; });
  EXPECT_EQ(
      part_of(serialize_remeshed("3mf", shape, remade.mesh, remade.face_source), "Metadata/Slic3r_PE_model.config"),
      "<config><object id=\"2\"><volume firstid=\"0\" lastid=\"2\"><metadata key=\"name\" value=\"a\"/></volume>"
      "<volume firstid=\"3\" lastid=\"3\"/></object><object id=\"7\"><volume firstid=\"1\" "
      "lastid=\"1\"/></object></config>");
}

TEST(ThreeMf, AnObjectThatIsPlacedTwiceIsReadTwiceAndNotWritten) {
  const std::string model =
      "<model><resources><object id=\"1\">" + threemf_mesh("<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>") +
      "</object></resources><build><item objectid=\"1\"/><item objectid=\"1\" transform=\"1 0 0 0 1 0 "
      "0 0 1 9 0 0\"/></build></model>";
  const ShapeFile shape = parsed(model_file(model));
  EXPECT_EQ(shape.mesh.face_count(), 2u);
  EXPECT_EQ(shape.mesh.positions[4], (Vec3d{10, 0, 0}));
  std::vector<Vec3d> moved = shape.mesh.positions;
  EXPECT_EQ(serialize_shape("3mf", shape, moved), shape.bytes);
  moved[0].x = 1;
  EXPECT_THROW(serialize_shape("3mf", shape, moved), InvalidInput);
  EXPECT_NO_THROW(serialize_shape("stl", shape, moved));
}

TEST(ThreeMf, NewFilesHaveColors) {
  Mesh mesh = parse_shape("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\n", "obj", "a").mesh;
  mesh.attributes.push_back({"color", Domain::face, NumberType::uint8, 3, {255, 0, 0, 0, 0, 255}});
  const ShapeFile back = parsed(serialize_mesh("3mf", mesh));
  EXPECT_EQ(back.mesh.positions, mesh.positions);
  EXPECT_EQ(back.mesh.face_count(), 2u);
  const Attribute* color = back.mesh.find_attribute("color");
  ASSERT_NE(color, nullptr);
  EXPECT_EQ(color->domain, Domain::face);
  EXPECT_EQ(color->values, (std::vector<double>{255, 0, 0, 0, 0, 255}));
}

TEST(ThreeMf, WhatIsWrongIsSaid) {
  const std::string mesh = threemf_mesh("<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>");
  const auto with = [&](const std::string& object, const std::string& item) {
    return refusal(model_file("<model><resources>" + object + "</resources>\n<build>" + item + "</build></model>"));
  };
  const std::string object = "<object id=\"1\">" + mesh + "</object>";
  const auto expect = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(with(object, ""), "places no object");
  expect(with(object, "<item objectid=\"2\"/>"), "'2' is placed that is not there");
  expect(with(object, "<item objectid=\"1\" transform=\"1 0 0\"/>"), "fewer than 12");
  expect(with(object, "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 0 1 2 3\"/>"), "makes an object flat");
  expect(with(object + object, "<item objectid=\"1\"/>"), "a second object has the id");
  expect(
      with("<object id=\"1\"><components><component objectid=\"1\"/></components></object>", "<item objectid=\"1\"/>"),
      "contain each other");
  expect(with("<object id=\"1\">" + threemf_mesh("<triangle v1=\"0\" v2=\"1\" v3=\"3\"/>") + "</object>", ""),
         "3dmodel.model:2: '3' is no vertex of its mesh");
  expect(with("<object id=\"1\">" + threemf_mesh("<triangle v1=\"0\" v2=\"1\"/>") + "</object>", ""), "v3 is missing");
  expect(refusal(threemf_file({})), "'/3D/3dmodel.model' is missing");
  expect(refusal(detail::zip::archive_of({{"a", "b"}})), "_rels/.rels is missing");
  std::string damaged = threemf_samples()[0].bytes;
  damaged[60] = static_cast<char>(damaged[60] ^ 1);
  EXPECT_NE(refusal(damaged), "read");
}

}  // namespace

}  // namespace knead::threemf_test
