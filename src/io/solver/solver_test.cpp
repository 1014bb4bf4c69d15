// The files of solvers: points move, and all else stays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "io/solver/solver.h"
#include "io/test_samples.h"
#include "knead/cells.h"
#include "knead/error.h"
#include "knead/io.h"
#include "math/system.h"
#include "support/shape_text.h"

namespace knead::solver_test {
namespace {

constexpr const char* kSolverFormats[] = {"su2", "msh", "foam", "bdf", "inp", "unv"};

TEST(Su2, PointsMoveAndAllElseStays) {
  const std::string text = su2_samples()[1].bytes;
  const ShapeFile shape = parse_shape(text, "su2", "a.su2");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_EQ(shape.mesh.face_count(), 0U);
  EXPECT_NE(text_of(shape.notes).find("elements and markers stay as they are"), std::string::npos);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[2].x = 0.25;
  EXPECT_EQ(serialize_shape("su2", shape, positions), replaced(text, "0 1.0 0 2", "0.25 1.0 0 2"));
  const ShapeFile zones = parse_shape(su2_samples()[3].bytes, "su2", "a.su2");
  EXPECT_EQ(zones.mesh.vertex_count(), 8U);
  positions = zones.mesh.positions;
  positions[7] = {0, 0, 2};
  const std::string moved = serialize_shape("su2", zones, positions);
  EXPECT_EQ(moved.rfind("0 0 2 3"), su2_samples()[3].bytes.rfind("0 0 1e0 3"));
  EXPECT_NE(moved.find("0 0 1e0 3"), std::string::npos);  // of the first zone
}

TEST(Su2, OfTwoDimensionsStaysFlat) {
  const std::string text = "NDIME= 2\nNPOIN= 3\n0 0 0\n1.50 0 1\n0 1 2\nNMARK= 0\n";
  const ShapeFile shape = parse_shape(text, "su2", "a.su2");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {1.5, 0, 0}, {0, 1, 0}}));
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1] = {1.5, 0.25, 1e-9};
  EXPECT_EQ(serialize_shape("su2", shape, positions), replaced(text, "1.50 0 1", "1.50 0.25 1"));
  positions[1].z = 0.01;
  try {
    serialize_shape("su2", shape, positions);
    ADD_FAILURE() << "was written";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("of point 1, but it has left its plane"), std::string::npos)
        << error.what();
  }
}

TEST(Su2, WhatIsRefused) {
  EXPECT_NE(refusal("NPOIN= 1\n0 0 0\n", "su2", "a.su2").find("a.su2:1: NDIME= must come before NPOIN="),
            std::string::npos);
  EXPECT_NE(refusal("NDIME= 3\nNPOIN= 999\n0 0 0\n", "su2", "a.su2").find("cut short"), std::string::npos);
  EXPECT_NE(refusal("NDIME= 3\nNPOIN= 2\n0 0 0\n0 1\n", "su2", "a.su2").find("a.su2:4: "), std::string::npos);
  EXPECT_NE(refusal("NDIME= 4\n", "su2", "a.su2").find("a.su2:1: "), std::string::npos);
  EXPECT_NE(refusal("% nothing\n", "su2", "a.su2").find("is it an SU2 mesh?"), std::string::npos);
  EXPECT_NE(refusal("NDIME= 3\nNPOIN= 0\n", "su2", "a.su2").find("no points"), std::string::npos);
  EXPECT_THROW(serialize_mesh("su2", parse_shape("0 0 0\n", "xyz", "a").mesh), InvalidInput);
}

// What a file that other programs wrote says besides its coordinates: its bytes without them.
std::string without_coordinates(const ShapeFile& shape) {
  std::string rest;
  std::size_t copied = 0;
  detail::find_layout<detail::solver::Layout>(shape)->kind->scan(
      shape.bytes, "a", [&](const detail::solver::PointSite& site) {
        for (std::size_t axis = 0; axis < site.dimensions; ++axis) {
          const std::string_view word = site.words[axis];
          const auto begin = static_cast<std::size_t>(word.data() - shape.bytes.data());
          rest.append(shape.bytes, copied, begin - copied);
          copied = begin + word.size();
        }
      });
  return rest.append(shape.bytes, copied);
}

struct OtherFile {
  std::string format;
  std::filesystem::path path;
};

// The files in fuzz/corpus that gmsh and OpenFOAM wrote.
std::vector<OtherFile> files_of_others() {
  std::vector<OtherFile> files;
  for (const std::string format : kSolverFormats) {
    const std::filesystem::path folder = std::filesystem::path(KNEAD_FUZZ_CORPUS) / ("fuzz_" + format);
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("gmsh_") || name.starts_with("foam_")) files.push_back({format, entry.path()});
    }
  }
  std::sort(files.begin(), files.end(), [](const OtherFile& a, const OtherFile& b) { return a.path < b.path; });
  return files;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Solver, FilesOfOtherProgramsKeepAllButTheirCoordinates) {
  std::mt19937 random(20261126);
  std::uniform_real_distribution<double> any(-3, 3);
  const std::vector<OtherFile> files = files_of_others();
  EXPECT_GE(files.size(), 14U);
  for (const OtherFile& file : files) {
    SCOPED_TRACE(file.path.filename());
    const ShapeFile shape = parse_shape(bytes_of(file.path), file.format, "a");
    ASSERT_GE(shape.mesh.vertex_count(), 4U);
    EXPECT_EQ(serialize_shape(file.format, shape, shape.mesh.positions), shape.bytes);
    std::vector<Vec3d> positions = shape.mesh.positions;
    for (Vec3d& p : positions) p = {any(random), any(random) * 1e-4, p.z};
    if (stores_floats("a." + file.format, shape)) {
      for (Vec3d& p : positions) p = Vec3d(Vec3f(p));
    }
    const ShapeFile moved = parse_shape(serialize_shape(file.format, shape, positions), file.format, "b");
    EXPECT_EQ(without_coordinates(moved), without_coordinates(shape));
    ASSERT_EQ(moved.mesh.vertex_count(), positions.size());
    const bool rounds = detail::find_layout<detail::solver::Layout>(shape)->rounds;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        // Fields of 8 characters hold 4 digits besides sign, point and exponent.
        const double error = std::abs(moved.mesh.positions[i][axis] - positions[i][axis]);
        EXPECT_LE(error, rounds ? 1e-3 * std::abs(positions[i][axis]) : 0) << i;
      }
    }
  }
}

// The box that gmsh wrote has the same points in every format and version.
TEST(Solver, OneMeshInEveryFormatHasTheSamePoints) {
  std::vector<Vec3d> points;
  for (const OtherFile& file : files_of_others()) {
    if (!file.path.filename().string().starts_with("gmsh_")) continue;
    SCOPED_TRACE(file.path.filename());
    const Mesh mesh = parse_shape(bytes_of(file.path), file.format, "a").mesh;
    if (points.empty()) points = mesh.positions;
    EXPECT_EQ(mesh.positions, points);
  }
}

TEST(Solver, OnlyTheNumbersThatChangeAreReplaced) {
  const auto moved = [](const std::string& format, std::size_t sample, std::size_t point, const Vec3d& to) {
    const ShapeFile shape = parse_shape(samples_of(format)[sample].bytes, format, "a");
    std::vector<Vec3d> positions = shape.mesh.positions;
    positions.at(point) = to;
    return serialize_shape(format, shape, positions);
  };
  const auto source = [](const std::string& format, std::size_t sample) { return samples_of(format)[sample].bytes; };
  EXPECT_EQ(moved("msh", 0, 1, {1, 2.5, 1.0 / 3}), replaced(source("msh", 0), "2.50 3", "2.50 0.3333333333333333"));
  EXPECT_EQ(moved("msh", 2, 2, {0, 2, 0}), replaced(source("msh", 2), "0 1.0 0", "0 2 0"));
  EXPECT_EQ(moved("foam", 1, 1, {1, 0.25, 2}), replaced(source("foam", 1), "(1e0 0.5 2)", "(1e0 0.25 2)"));
  EXPECT_EQ(moved("inp", 1, 1, {5, -1, 0}), replaced(source("inp", 1), "2, , -1.", "2,5 , -1."));
  EXPECT_EQ(moved("inp", 2, 1, {1, 0.25, 0}), replaced(source("inp", 2), "2, 1., 0., 0., 0.", "2, 1., 0.25, 0., 0."));
  EXPECT_EQ(moved("unv", 3, 0, {1, -0.1, 3}), replaced(source("unv", 3), "   2.0D+00", " -1.0000000000000001D-01"));
}

TEST(Nastran, FieldsHoldAsManyDigitsAsFit) {
  const ShapeFile small = parse_shape("GRID           1              .5      1.     2.0\n", "bdf", "a");
  const auto row = [&](const Vec3d& p) { return serialize_shape("bdf", small, std::vector<Vec3d>{p}).substr(24, 24); };
  EXPECT_EQ(row({1, 1, 2}), "      1.      1.     2.0");
  EXPECT_EQ(row({1.0 / 3, -2.0 / 3, 12345.678901}), ".3333333-.66666712345.68");
  EXPECT_EQ(row({-1e-10 / 3, 1.23456789e200, -0.5}), "-3.33-111.23+200     -.5");
  const ShapeFile large = parse_shape(bdf_samples()[3].bytes, "bdf", "a");
  std::vector<Vec3d> positions = large.mesh.positions;
  EXPECT_EQ(positions, (std::vector<Vec3d>{{0, 1, 2.5}, {0, 1, -3}}));
  positions[0].z = 0.1 + 0.2;
  positions[1].x = -1.0 / 3;
  EXPECT_EQ(serialize_shape("bdf", large, positions),
            replaced(replaced(bdf_samples()[3].bytes, "*       2.5D0", "*       .3              "),
                     "             0.0 1.000000000E+00", "-.33333333333333 1.000000000E+00"));
}

TEST(Solver, WhatAnotherFileHoldsIsRefused) {
  EXPECT_NE(refusal("BEGIN BULK\nINCLUDE 'grids.bdf'\nGRID,1,,0.,0.,0.\nENDDATA\n", "bdf", "a.bdf").find("a.bdf:2: "),
            std::string::npos);
  EXPECT_NE(refusal("include 'grids.bdf'\nGRID,1,,0.,0.,0.\n", "bdf", "a.bdf").find("a.bdf:1: "), std::string::npos);
  const std::string grid = "GRID,1,,0.,0.,0.\n";
  EXPECT_EQ(parse_shape("INCLUDE 'loads.dat'\nBEGIN BULK\n" + grid, "bdf", "a").mesh.vertex_count(), 1U);
  EXPECT_NE(refusal("*NODE\n1, 0, 0, 0\n*INSTANCE, LIBRARY=old, NAME=a\n", "inp", "a.inp").find("a.inp:3: "),
            std::string::npos);
  const std::string head = "FoamFile { format ascii; class vectorField; }\n";
  EXPECT_NE(refusal(head + "#include \"points2\"\n1((0 0 0))", "foam", "points").find("points:2: "), std::string::npos);
}

// Dataset 2420, here behind the nodes, says what the systems are that these name.
TEST(Universal, NodesInOtherCoordinateSystemsAreRefused) {
  const auto file = [](const std::string& type, const std::string& x) {
    return "    -1\n  2411\n         1         7         1        11\n 1.D+00 9.D+01 0.D+00\n    -1\n"
           "    -1\n  2420\n 1\nPart\n 7 " +
           type + " 0\nCS7\n " + x + " 0.D+00 0.D+00\n 0. 1.D+00 0.\n 0. 0. 1.D+00\n 0. 0. 0.\n    -1\n";
  };
  EXPECT_EQ(parse_shape(file("0", "1.D+00"), "unv", "a").mesh.positions, (std::vector<Vec3d>{{1, 90, 0}}));
  EXPECT_EQ(refusal(file("1", "1.D+00"), "unv", "a.unv"),
            "a.unv:3: a node is in the coordinate system 7, a cylindrical one; only the global Cartesian one can be "
            "deformed");
  EXPECT_NE(refusal(file("2", "1.D+00"), "unv", "a.unv").find("a spherical one"), std::string::npos);
  EXPECT_NE(refusal(file("0", "-1.D+00"), "unv", "a.unv").find("one that is turned or moved"), std::string::npos);
  const std::string other = replaced(file("1", "1.D+00"), " 7 1 0\n", " 8 1 0\n");
  EXPECT_EQ(parse_shape(other, "unv", "a").mesh.vertex_count(), 1U);
}

TEST(Universal, LinesBetweenDatasetsBelongToNone) {
  const std::string text =
      "Workpiece\n    -1\n   164\n 1\n    -1\nFile of today\n-- 1\n    -1\n  2411\n 1 1 1 11\n 1. 2. 3.\n    -1\nend\n";
  const ShapeFile shape = parse_shape(text, "unv", "a.unv");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{1, 2, 3}}));
  EXPECT_NE(refusal("    -1\nWorkpiece\n", "unv", "a.unv").find("a.unv:2: expected the number of a dataset"),
            std::string::npos);
}

TEST(Su2, ElementsThatAreNotKnownAreNamed) {
  const std::string text = "NDIME= 3\nNPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\nNELEM= 1\n24 0 1 2 3 0 1 2 3 0 1 0\n";
  const ShapeFile shape = parse_shape(text, "su2", "a.su2");
  EXPECT_THROW(read_cells("a.su2", shape), InvalidInput);
}

// OpenFOAM writes the points alone where the mesh moves.
TEST(Foam, AnEarlierTimeHasTheFacesOfAMovingMesh) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("knead_times_" + std::to_string(::getpid()));
  const auto put = [&](const fs::path& file, const std::string& bytes) {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
  };
  const std::string head = "FoamFile { format ascii; class ";
  const std::string points = head + "vectorField; }\n4((0 0 0)(1 0 0)(0 1 0)(0 0 1))";
  const auto put_mesh = [&](const fs::path& to, const std::string& patch) {
    put(to / "faces", head + "faceList; }\n4(3(0 2 1)3(0 1 3)3(0 3 2)3(1 2 3))");
    put(to / "owner", head + "labelList; }\n4(0 0 0 0)");
    put(to / "neighbour", head + "labelList; }\n0()");
    put(to / "boundary", head + "polyBoundaryMesh; }\n1(" + patch + " { nFaces 4; startFace 0; })");
  };
  const fs::path now = folder / "0.5" / "polyMesh" / "points";
  put(now, points);
  const ShapeFile shape = read_shape(now);
  try {
    read_cells(now, shape);
    ADD_FAILURE() << "there are no faces";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("constant/polyMesh"), std::string::npos) << error.what();
  }
  put_mesh(folder / "constant" / "polyMesh", "first");
  put_mesh(folder / "1" / "polyMesh", "later");
  EXPECT_EQ(read_cells(now, shape).size(), 1U);
  EXPECT_EQ(read_patches(now, shape).at(0).name, "first");
  put_mesh(folder / "0.25" / "polyMesh", "second");
  EXPECT_EQ(read_patches(now, shape).at(0).name, "second");
  EXPECT_EQ(read_patches(folder / "0.5" / ".." / "0.5" / "polyMesh" / "points", shape).at(0).name, "second");
  fs::remove_all(folder);
}

TEST(Nastran, OtherSectionsAndCardsStay) {
  const ShapeFile shape = parse_shape(bdf_samples()[2].bytes, "bdf", "a");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 1500, -1}, {0, 1, 2}}));
  EXPECT_NE(text_of(shape.notes).find("rounded to what fits into their fields"), std::string::npos);
  const ShapeFile free = parse_shape(bdf_samples()[4].bytes, "bdf", "a");
  EXPECT_EQ(free.mesh.positions, (std::vector<Vec3d>{{1, 2, 3}, {0, 1e-3, 0}, {1, -2, 0.3}}));
  std::vector<Vec3d> positions = free.mesh.positions;
  positions[1] = {7, 1e-3, 1e-20};
  const std::string text = serialize_shape("bdf", free, positions);
  EXPECT_NE(text.find("GRID,4,0,7.,1.e-3,1.-20$"), std::string::npos) << text;
}

// Faces only where the test is not of them.
std::vector<Patch> without_faces(std::vector<Patch> patches) {
  for (Patch& patch : patches) patch.faces.clear();
  return patches;
}

// The tetrahedron that gmsh wrote has the same groups in every version.
TEST(Patches, HaveTheNamesAndPointsOfTheirFiles) {
  const std::filesystem::path corpus = KNEAD_FUZZ_CORPUS;
  const std::vector<Patch> surfaces{{"symmetry", {0, 1, 2}}, {"inlet", {0, 1, 3}}, {"wall", {0, 1, 2, 3}}};
  for (const char* name : {"22t", "22b", "22tp", "22bp", "41t", "41b"}) {
    const std::filesystem::path path = corpus / "fuzz_msh" / ("gmsh_" + std::string(name) + ".msh");
    std::vector<Patch> all = surfaces;
    all.push_back({"fluid", {0, 1, 2, 3}});
    const ShapeFile shape = read_shape(path);
    EXPECT_EQ(without_faces(read_patches(path, shape)), all) << name;
    EXPECT_EQ(read_patches(path, shape)[2].faces.size(), 2U) << name;  // the wall
    const VolumeCells cells = read_cells(path, shape);
    ASSERT_EQ(cells.size(), 1U) << name;
    EXPECT_EQ(cells.cells.kinds.front(), CellKind::tetrahedron);
  }
  const std::filesystem::path su2 = corpus / "fuzz_su2/gmsh_tet.su2";
  EXPECT_EQ(without_faces(read_patches(su2, read_shape(su2))), surfaces);
  EXPECT_EQ(read_cells(su2, read_shape(su2)).size(), 1U);
  for (const char* folder : {"polyMesh", "polyMesh_text"}) {
    const std::filesystem::path path = corpus.parent_path().parent_path() / "tests/support" / folder / "points";
    const ShapeFile shape = read_shape(path);
    const std::vector<Patch> patches = read_patches(path, shape);
    ASSERT_EQ(patches.size(), 4U);
    EXPECT_EQ(patches[2].name, "symmetry");
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < shape.mesh.vertex_count(); ++i) {
      if (shape.mesh.positions[i].z == 0) expected.push_back(i);
    }
    EXPECT_EQ(patches[2].points, expected);
  }
  EXPECT_TRUE(read_patches("a.bdf", parse_shape(bdf_samples()[0].bytes, "bdf", "a")).empty());
}

// By their corners. A face has nodes in the order of its corners, its edges, and what is inside.
TEST(Cells, OfTheThirdOrderAreThoseOfTheirCorners) {
  const auto third = [](int k) { return std::to_string(k / 3.0); };
  std::string nodes;
  for (const auto& [i, j, k] :
       std::vector<std::array<int, 3>>{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                       {1, 2, 0}, {0, 2, 0}, {0, 1, 0}, {0, 0, 2}, {0, 0, 1}, {0, 1, 2}, {0, 2, 1},
                                       {1, 0, 2}, {2, 0, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}) {
    nodes += std::to_string(std::count(nodes.begin(), nodes.end(), '\n') + 1) + " " + third(i) + " " + third(j) + " " +
             third(k) + "\n";
  }
  std::string tetrahedron = "2 29 2 1 1";
  for (int k = 1; k <= 20; ++k) tetrahedron += " " + std::to_string(k);
  const std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n20\n" + nodes +
                           "$EndNodes\n$Elements\n2\n1 21 2 7 7 1 2 3 5 6 7 8 9 10 17\n" + tetrahedron +
                           "\n$EndElements\n";
  const ShapeFile shape = parse_shape(text, "msh", "a.msh");
  const VolumeCells cells = read_cells("a.msh", shape);
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_EQ(cells.by_corners, 1U);
  const CellCheck check = check_cells(cells, shape.mesh.positions);
  EXPECT_EQ(check.inverted, 0U);
  EXPECT_EQ(check.by_corners, 1U);
  const std::vector<Patch> patches = read_patches("a.msh", shape);
  const auto found = std::find_if(patches.begin(), patches.end(), [](const Patch& patch) { return patch.name == "7"; });
  ASSERT_NE(found, patches.end());
  EXPECT_EQ(found->faces.size(), 9U);
  double area = 0;
  for (const Triangle& t : found->faces) {
    const std::vector<Vec3d>& p = shape.mesh.positions;
    const Vec3d twice = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    EXPECT_GT(twice.z, 0.1);
    area += 0.5 * twice.z;
  }
  EXPECT_NEAR(area, 0.5, 1e-5);
}

// As SU2's own meshes and gmsh's have them: gmsh's own format has wedges that look to the other side.
TEST(Cells, WedgesOfSu2HaveTheirCornersAsVtkHasThem) {
  const std::string text =
      "NDIME= 3\nNELEM= 1\n13 0 1 2 3 4 5 0\nNPOIN= 6\n0 0 0\n0 1 0\n1 0 0\n0 0 1\n0 1 1\n1 0 1\nNMARK= 0\n";
  const ShapeFile shape = parse_shape(text, "su2", "a.su2");
  EXPECT_EQ(inverted_cells(read_cells("a.su2", shape), shape.mesh.positions), std::vector<std::uint8_t>{0});
}

TEST(Patches, DamagedFilesAreRefusedOrRead) {
  for (const char* name : {"fuzz_msh/gmsh_41t.msh", "fuzz_msh/gmsh_41b.msh", "fuzz_msh/gmsh_22t.msh",
                           "fuzz_msh/gmsh_22b.msh", "fuzz_su2/gmsh_tet.su2"}) {
    const std::filesystem::path path = std::filesystem::path(KNEAD_FUZZ_CORPUS) / name;
    const ShapeFile source = read_shape(path);
    for (std::size_t i = 0; i < source.bytes.size(); i += 3) {
      for (const char value : {'\0', '9', '\xff', ' '}) {
        ShapeFile shape = source;
        shape.bytes[i] = value;
        try {
          for (const std::uint32_t corner : read_cells(path, shape).cells.corners) {
            EXPECT_LT(corner, shape.mesh.vertex_count());
          }
          for (const Patch& patch : read_patches(path, shape)) {
            EXPECT_TRUE(patch.points.empty() || patch.points.back() < shape.mesh.vertex_count());
          }
        } catch (const InvalidInput& error) {
          EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
      }
    }
  }
}

std::string refusal_of(const std::string& format, const std::string& text) {
  return refusal(text, format, "a." + format);
}

TEST(Solver, WhatIsRefusedNamesTheLine) {
  const std::string msh = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
  const std::vector<std::array<std::string, 3>> cases{
      {"msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n",
       "a.msh:2: is of gmsh's version '4'; save it as version 2.2 or 4.1"},
      {"msh", "$NOD\n1\n", "a.msh:1: is of gmsh's version 1; save it as version 2.2 or 4.1"},
      {"msh", "solid\n", "a.msh:1: expected a section, such as $Nodes, found 'solid'"},
      {"msh", msh + "$Nodes\n1 1 1 1\n0 1 0 1\n1\n0 0\n$EndNodes\n",
       "a.msh:8: expected a coordinate, found the end of the line or file"},
      {"msh", msh + "$Nodes\n1 1 1 1\n0 1 0 9\n1\n", "a.msh:6: 9 points are declared, but only 3 bytes follow"},
      {"msh", msh + "$Nodes\n1 1 1 1\n0 1 0 1\n1\n0 0 x\n$EndNodes\n", "a.msh:8: expected a coordinate, found 'x'"},
      {"msh", msh, "a.msh: has no points"},
      {"msh", msh + "$Nodes\n0 0 0 0\n", "a.msh:6: the section $Nodes has no $EndNodes"},
      {"foam", "1((0 0 0))", "a.foam:1: expected FoamFile"},
      {"foam", "FoamFile\n{\nclass faceList;\n}\n", "a.foam:3: holds 'faceList'"},
      {"foam", "FoamFile{format ascii;}\n2\n((0 0 0)\n(1 nan 0))", "a.foam:4: a coordinate is 'nan'"},
      {"foam", "FoamFile{format ascii;}\n2\n((0 0 0))", "a.foam:3: expected '(', found ')'"},
      {"foam", "FoamFile{format binary;}\n2\n(abc)", "a.foam:3: 2 points are declared, but only 4 bytes follow"},
      {"bdf", "GRID,1,5,0.,0.,0.\n", "a.bdf:1: GRID is in the coordinate system '5'"},
      {"bdf", "GRID,1,,0.,0.,0.\n  include 'b.bdf'\n", "a.bdf:2: names a file with more cards"},
      {"bdf", "CEND\nGRID    1\t0\t0.\n", "a.bdf:2: has tabs"},
      {"bdf", "GRID*   1               0               0.              0.\nENDDATA\n", "expected the line after GRID*"},
      {"bdf", "GRID,1,,0.,x,0.\n", "a.bdf:1: expected a coordinate, found 'x'"},
      {"bdf", "SOL 101\n", "a.bdf: has no points"},
      {"inp", "*NODE, SYSTEM=C\n1,0,0,0\n", "a.inp:1: the nodes are not in Cartesian coordinates"},
      {"inp", "*NODE, INPUT=b.inp\n", "a.inp:1: the nodes lie in another file"},
      {"inp", "*NODE\n1,0,0\n*NGEN\n1,2,1\n", "a.inp:3: *NGEN is not understood"},
      {"inp", "*INSTANCE, NAME=a, PART=b\n1., 0., 0.\n", "a.inp:2: moves an instance of a part"},
      {"inp", "8 1 0 0 0\n", "a.inp: has no *NODE"},
      {"unv", "-1\n781\n", "a.unv:2: has its nodes in dataset 781"},
      {"unv", "-1\n2411\n1 1 1 1\n0 0\n-1\n", "a.unv:4: expected three coordinates"},
      {"unv", "-1\n2411\n1 1 1 1\n0 0 0\n", "a dataset has no end"},
      {"unv", "abc\n", "a.unv: has no nodes (dataset 2411)"}};
  for (const auto& [format, text, message] : cases) {
    const std::string found = refusal_of(format, text);
    EXPECT_NE(found.find(message), std::string::npos) << found << " instead of " << message;
  }
  for (const std::string format : kSolverFormats) {
    EXPECT_THROW(serialize_mesh(format, parse_shape("0 0 0\n", "xyz", "a").mesh), InvalidInput);
  }
}

TEST(Solver, APointKeepsThePlaneThatItsFileImplies) {
  const ShapeFile shape = parse_shape("*NODE\n1,0,0\n2,1,0\n3,0,1\n", "inp", "a");
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1] = {2, 0.5, 0};
  EXPECT_EQ(serialize_shape("inp", shape, positions), "*NODE\n1,0,0\n2,2,0.5\n3,0,1\n");
  positions[1].z = 1;
  EXPECT_THROW(serialize_shape("inp", shape, positions), InvalidInput);
}

TEST(Solver, NamesOfFiles) {
  EXPECT_EQ(format_of("case/constant/polyMesh/points"), "foam");
  EXPECT_EQ(format_of("case/constant/polyMesh/points.gz"), "foam");
  EXPECT_EQ(format_of("v01.points"), "foam");
  EXPECT_EQ(format_of("A.MSH"), "msh");
  EXPECT_EQ(format_of("a.nas"), "bdf");
  EXPECT_EQ(format_of("a.ply.gz"), "ply");
  EXPECT_EQ(shape_suffix("a.b/points"), ".points");
  EXPECT_EQ(shape_suffix("points.gz"), ".points.gz");
  EXPECT_EQ(shape_suffix("a.PLY.gz"), ".PLY.gz");
  EXPECT_THROW(format_of("a.gz"), InvalidInput);
}

#if defined(KNEAD_HAS_ZLIB)

TEST(Gzip, FilesAreReadAndWrittenCompressed) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("knead_gzip_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::string text = "FoamFile{format ascii;}\n40000(";
  for (int i = 0; i < 40000; ++i) text += "(0 0 " + std::to_string(i) + ")\n";
  text += ")";
  const ShapeFile shape = parse_shape(text, "foam", "a");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[7].x = 0.5;
  write_shape(folder / "points.gz", shape, positions);
  EXPECT_LT(std::filesystem::file_size(folder / "points.gz"), text.size() / 2);
  EXPECT_EQ(read_shape(folder / "points.gz").bytes, replaced(text, "(0 0 7)", "(0.5 0 7)"));
  const std::filesystem::path foam = std::filesystem::path(KNEAD_FUZZ_CORPUS) / "fuzz_foam";
  EXPECT_EQ(read_shape(foam / "points.gz").bytes, bytes_of(foam / "foam_ascii.points"));  // OpenFOAM wrote both
  const std::string zipped = bytes_of(folder / "points.gz");
  EXPECT_EQ(detail::unzipped(zipped + zipped, "a").size(), 2 * (text.size() + 2));  // two members
  write_mesh(folder / "a.ply.gz", shape.mesh);
  EXPECT_EQ(read_shape(folder / "a.ply.gz").mesh.positions, shape.mesh.positions);
  for (std::size_t size = 0; size < zipped.size(); size += 997) {
    EXPECT_THROW(detail::unzipped(zipped.substr(0, size), "a"), InvalidInput) << size;
  }
  EXPECT_THROW(detail::unzipped(text, "a"), InvalidInput);
  EXPECT_THROW(CloudPieces(folder / "a.ply.gz", 100), InvalidInput);
  std::filesystem::remove_all(folder);
}

#endif

}  // namespace
}  // namespace knead::solver_test
