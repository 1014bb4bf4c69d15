// remesh(): volume, topology, limits, attributes and creases after strong deformations.
#include "knead/remesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/test_shapes.h"
#include "support/deformed.h"
#include "support/paper_remesh.h"

namespace knead::remesh_test {
namespace {

using test::crossings_as_float;
using test::Deformed;
using test::pull;
using test::smallest_moved_angle;

Deformed pulled_ball(std::size_t vertices = 2000) {
  return {make_shape(ShapeKind::sphere, vertices), pull({0, 0, 1}, {0.2, 0.1, 2.2}, 0.2, 0.9)};
}

void expect_same(const Remeshed& a, const Remeshed& b) {
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.corner_vertex, b.mesh.corner_vertex);
  EXPECT_EQ(a.face_source, b.face_source);
  EXPECT_EQ(a.creases, b.creases);
}

TEST(Remesh, AStrongPullKeepsVolumeTopologyAndGoodTriangles) {
  const Deformed ball = pulled_ball();
  const Remeshed result = ball.remeshed();
  const Measures before = measure(ball.mesh());
  const Measures after = measure(result.mesh);
  EXPECT_TRUE(after.closed() && after.manifold() && after.oriented());
  EXPECT_EQ(after.euler, before.euler);
  const double plain = measure_volume_and_area(ball.mesh(), ball.after()).volume / before.volume - 1;
  EXPECT_GT(std::abs(plain), 1e-3);
  EXPECT_LT(std::abs(result.counts.missing_volume / before.volume), std::abs(plain) / 10);
  EXPECT_NEAR(result.counts.compensated_volume, result.counts.missing_volume, 1e-8 * before.volume);
  EXPECT_LT(std::abs(after.volume / before.volume - 1), 1e-8);
  EXPECT_GT(smallest_moved_angle(result), 5);
  EXPECT_EQ(crossings_as_float(result.mesh), 0U);
  EXPECT_EQ(result.counts.crossings, 0U);
  EXPECT_TRUE(result.counts.complete);
  EXPECT_GT(result.counts.splits, 1000U);
}

// A plate of 4 x 4 x 1 with a square hole of 2 x 2; the polygons above and below run round it, and pass the two ends of
// a bridge twice.
Mesh plate_with_hole() {
  Mesh mesh;
  for (const double z : {0.0, 1.0}) {
    for (const Vec3d& p : {Vec3d{0, 0, z}, Vec3d{4, 0, z}, Vec3d{4, 4, z}, Vec3d{0, 4, z}, Vec3d{1, 1, z},
                           Vec3d{3, 1, z}, Vec3d{3, 3, z}, Vec3d{1, 3, z}}) {
      mesh.positions.push_back(p);
    }
  }
  mesh.add_face(std::vector<std::uint32_t>{8, 9, 10, 11, 8, 12, 15, 14, 13, 12});
  mesh.add_face(std::vector<std::uint32_t>{4, 5, 6, 7, 4, 0, 3, 2, 1, 0});
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t j = (i + 1) % 4;
    mesh.add_face(std::vector<std::uint32_t>{i, j, j + 8, i + 8});
    mesh.add_face(std::vector<std::uint32_t>{i + 4, i + 12, j + 12, j + 4});
  }
  return mesh;
}

// Improving triangles moves vertices, and so may make edges longer.
TEST(Remesh, IsCompleteWhereEveryMovedEdgeIsWithinItsLimit) {
  for (const double limit : {0.1, 0.15, 0.3}) {
    RemeshSettings settings;
    settings.max_edge = limit;
    const Remeshed result = pulled_ball(642).remeshed({}, settings);
    ASSERT_TRUE(result.counts.complete);
    double longest = 0;
    for (std::size_t f = 0; f < result.mesh.face_count(); ++f) {
      const auto face = result.mesh.face(f);
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = face[i];
        const std::uint32_t b = face[(i + 1) % 3];
        if (!result.moved[a] && !result.moved[b]) continue;
        longest = std::max(longest, norm(result.mesh.positions[b] - result.mesh.positions[a]));
      }
    }
    EXPECT_LE(longest, limit);
    EXPECT_GT(longest, 0.5 * limit);
  }
}

TEST(Remesh, FacesThatRunRoundAHoleAreSplit) {
  const Deformed plate(plate_with_hole(), TwistStroke{{2, 2, 0.5}, {1, 0, 0}, 20, -3, 3});
  const Remeshed result = plate.remeshed();
  const Measures before = measure(plate.mesh());
  const Measures after = measure(result.mesh);
  EXPECT_NEAR(before.volume, 12, 1e-12);
  EXPECT_GT(result.counts.splits, 100U);
  EXPECT_TRUE(result.counts.complete);
  EXPECT_TRUE(after.closed() && after.manifold() && after.oriented());
  EXPECT_EQ(after.euler, before.euler);
  EXPECT_NEAR(after.volume, before.volume, 1e-3 * before.volume);
}

TEST(Remesh, EndsWhenItsSecondsAreOverWithASoundMesh) {
  const Deformed ball = pulled_ball();
  const Remeshed whole = ball.remeshed();
  EXPECT_FALSE(whole.counts.out_of_time);
  RemeshOptions options;
  options.seconds = 1e6;
  expect_same(ball.remeshed(options), whole);
  options.seconds = 0;  // not even the splits
  const Remeshed none = ball.remeshed(options);
  EXPECT_TRUE(none.counts.out_of_time);
  EXPECT_FALSE(none.counts.complete);
  EXPECT_EQ(none.counts.splits, 0U);
  EXPECT_EQ(none.mesh.corner_vertex, ball.mesh().corner_vertex);
  for (const double seconds : {0.002, 0.01, 0.03, 0.1}) {
    options.seconds = seconds;
    const Remeshed part = ball.remeshed(options);
    const Measures measures = measure(part.mesh);
    EXPECT_TRUE(measures.closed() && measures.manifold() && measures.oriented()) << seconds;
    EXPECT_EQ(measures.euler, 2) << seconds;
    EXPECT_EQ(crossings_as_float(part.mesh), part.counts.crossings) << seconds;
    EXPECT_EQ(part.crossing_places.empty(), part.counts.crossings == 0) << seconds;
    EXPECT_LE(part.counts.splits, whole.counts.splits) << seconds;
  }
  options.seconds = std::nan("");
  EXPECT_THROW(ball.remeshed(options), InvalidInput);
}

TEST(Remesh, ShorterChordsComeCloserToTheTrueImage) {
  const Deformed ball = pulled_ball();
  // A surface that is refined much further and not improved: the reference.
  RemeshSettings fine;
  fine.max_chord = 1e-5;
  fine.iterations = 0;
  const Mesh image = ball.remeshed({}, fine, test::remesh_as_in_the_paper).mesh;
  const SurfaceTree tree(triangulate(image), image.positions);
  const double diagonal = bounding_box(ball.mesh().positions).diagonal();
  const auto distance = [&](double max_chord) {
    RemeshSettings settings;
    settings.max_chord = max_chord;
    const Remeshed result = ball.remeshed({}, settings);
    double squares = 0;
    double count = 0;
    for (std::size_t f = 0; f < result.mesh.face_count(); ++f) {
      const auto t = result.mesh.face(f);
      const auto& p = result.mesh.positions;
      const double d = tree.closest((p[t[0]] + p[t[1]] + p[t[2]]) / 3.0)->distance / diagonal;
      squares += d * d;
      ++count;
    }
    return std::sqrt(squares / count);
  };
  const double coarse = distance(1e-3);
  const double by_default = distance(kDefaultMaxChord);
  EXPECT_LT(by_default, 1e-4);
  EXPECT_LT(by_default, coarse / 1.5);
}

TEST(Remesh, WhatIsNotTouchedKeepsVerticesOrderAndBits) {
  const Deformed ball = pulled_ball();
  const Remeshed result = ball.remeshed();
  const Mesh& before = ball.mesh();
  std::uint32_t last = 0;
  std::set<std::uint32_t> kept;
  for (std::size_t v = 0; v < result.mesh.vertex_count(); ++v) {
    const std::uint32_t source = result.vertex_source[v];
    if (source == kNewVertex) continue;
    EXPECT_TRUE(kept.empty() || source > last);
    last = source;
    kept.insert(source);
    if (before.positions[source].z < -0.3) {
      EXPECT_EQ(result.mesh.positions[v], before.positions[source]);
    }
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> faces;  // by source
  for (std::size_t f = 0; f < result.mesh.face_count(); ++f) {
    for (const std::uint32_t v : result.mesh.face(f)) {
      faces[result.face_source[f]].push_back(result.vertex_source[v]);
    }
  }
  for (std::uint32_t f = 0; f < before.face_count(); ++f) {
    const auto face = before.face(f);
    const bool is_below =
        std::all_of(face.begin(), face.end(), [&](std::uint32_t v) { return before.positions[v].z < -0.3; });
    if (is_below) {
      EXPECT_EQ(faces[f], std::vector<std::uint32_t>(face.begin(), face.end()));
    }
  }
}

TEST(Remesh, TheSameBitsForEveryNumberOfThreads) {
  const Deformed ball = pulled_ball();
  RemeshOptions one;
  one.threads = 1;
  RemeshOptions four;
  four.threads = 4;
  const Remeshed result = ball.remeshed(one);
  expect_same(result, ball.remeshed(four));
  expect_same(result, ball.remeshed(one));
}

TEST(Remesh, NothingMovedIsNothingChanged) {
  const Deformed far(make_shape(ShapeKind::torus, 600), pull({9, 9, 9}, {9, 9, 10}, 0.1, 0.5));
  const Remeshed result = far.remeshed();
  EXPECT_EQ(result.mesh.positions, far.mesh().positions);
  EXPECT_EQ(result.mesh.corner_vertex, far.mesh().corner_vertex);
  EXPECT_EQ(result.counts.splits + result.counts.collapses + result.counts.flips, 0U);
}

// A box with one square a side: no vertex and no edge is near the tool.
TEST(Remesh, AToolInTheMiddleOfALargeFaceIsNotMissed) {
  const Deformed box(unit_cube(), pull({0.3, 0.4, 1}, {0.3, 0.4, 1.1}, 0.02, 0.1));
  EXPECT_EQ(box.after(), box.mesh().positions);
  const Remeshed result = box.remeshed();
  double highest = 0;
  for (const Vec3d& p : result.mesh.positions) highest = std::max(highest, p.z);
  EXPECT_GT(highest, 1.095);
  EXPECT_NEAR(measure(result.mesh).volume, 1, 1e-7);
  EXPECT_EQ(measure(result.mesh).euler, 2);
  std::size_t quads = 0;
  for (std::size_t f = 0; f < result.mesh.face_count(); ++f) quads += result.mesh.face(f).size() == 4 ? 1 : 0;
  EXPECT_GE(quads, 1U);  // the far side is not cut into triangles
}

TEST(Remesh, CreasesAreSplitAlongAndStayWhereTheFlowTakesThem) {
  const Mesh bar = make_shape(ShapeKind::box, 3000);
  const std::vector<MeshEdge> creases = find_creases(bar);
  EXPECT_GT(creases.size(), 100U);
  BendStroke bend;
  bend.center = {0, 0, 0};
  bend.axis = {0, 0, 1};
  bend.normal = {-1, 0, 0};
  bend.angle_deg = 70;
  bend.extent = BendWidth{2};
  const Deformed bent(bar, bend);
  const Remeshed result = bent.remeshed();
  EXPECT_GE(result.creases.size(), creases.size());
  std::vector<Vec3d> back;
  for (const auto& [a, b] : result.creases) {
    for (const double t : {0.0, 0.25, 0.5}) {
      back.push_back(result.mesh.positions[a] * (1 - t) + result.mesh.positions[b] * t);
    }
  }
  AdvectOptions exact;
  exact.precision = Precision::float64;
  exact.tolerance = 1e-9;
  advect(inverse(bent.flow()), back, exact);
  const double diagonal = bounding_box(bar.positions).diagonal();
  for (const Vec3d& p : back) {
    // The bar is [-3, 3] x [-0.5, 0.5]^2: at its edges two coordinates are at their limits.
    std::array<double, 3> off{std::abs(3 - std::abs(p.x)), std::abs(0.5 - std::abs(p.y)),
                              std::abs(0.5 - std::abs(p.z))};
    std::sort(off.begin(), off.end());
    EXPECT_LT(std::hypot(off[0], off[1]), 1e-4 * diagonal);
  }
}

TEST(Remesh, ASmoothShapeHasNoCreasesAndABoxHasItsTwelve) {
  EXPECT_TRUE(find_creases(make_shape(ShapeKind::sphere, 1000)).empty());
  const Mesh bar = make_shape(ShapeKind::box, 1000);
  double length = 0;
  for (const auto& [a, b] : find_creases(bar)) length += norm(bar.positions[a] - bar.positions[b]);
  EXPECT_NEAR(length, 4 * (6 + 1 + 1), 1e-9);
}

// Colours and texture coordinates that are linear in the position before: interpolation must keep them linear.
TEST(Remesh, AttributesFollowTheSurface) {
  Mesh ball = make_shape(ShapeKind::sphere, 2000);
  Attribute place{"place", Domain::vertex, NumberType::float64, 3, {}};
  for (const Vec3d& p : ball.positions) place.values.insert(place.values.end(), {p.x, p.y, p.z});
  Attribute uv{"uv", Domain::corner, NumberType::float32, 2, {}};
  for (const std::uint32_t v : ball.corner_vertex) {
    uv.values.insert(uv.values.end(), {ball.positions[v].x, ball.positions[v].y});
  }
  Attribute label{"label", Domain::face, NumberType::uint8, 1, {}};
  for (std::size_t f = 0; f < ball.face_count(); ++f) label.values.push_back(static_cast<double>(f % 2));
  ball.attributes = {place, uv, label};
  const Deformed pulled(ball, pull({0, 0, 1}, {0, 0, 1.8}, 0.2, 0.9));
  RemeshOptions options;
  const Remeshed result = pulled.remeshed(options);
  ASSERT_EQ(result.mesh.attributes.size(), 3U);
  const Attribute& places = result.mesh.attributes[0];
  ASSERT_EQ(places.values.size(), 3 * result.mesh.vertex_count());
  ASSERT_EQ(result.mesh.attributes[1].values.size(), 2 * result.mesh.corner_vertex.size());
  ASSERT_EQ(result.mesh.attributes[2].values.size(), result.mesh.face_count());
  // The flow must move the interpolated position to the vertex.
  std::vector<Vec3d> carried;
  for (std::size_t v = 0; v < result.mesh.vertex_count(); ++v) {
    carried.push_back({places.values[3 * v], places.values[3 * v + 1], places.values[3 * v + 2]});
  }
  pulled.deformation().carry(carried);
  const double diagonal = bounding_box(ball.positions).diagonal();
  for (std::size_t v = 0; v < carried.size(); ++v) {
    EXPECT_LT(norm(carried[v] - result.mesh.positions[v]), 2e-2 * diagonal);
  }
  for (std::size_t f = 0; f < result.mesh.face_count(); ++f) {
    EXPECT_EQ(result.mesh.attributes[2].values[f], static_cast<double>(result.face_source[f] % 2));
  }
  for (std::size_t c = 0; c < result.mesh.corner_vertex.size(); ++c) {
    const std::uint32_t v = result.mesh.corner_vertex[c];
    EXPECT_NEAR(result.mesh.attributes[1].values[2 * c], places.values[3 * v], 1e-9);
    EXPECT_NEAR(result.mesh.attributes[1].values[2 * c + 1], places.values[3 * v + 1], 1e-9);
  }
}

TEST(Remesh, SeamsOfTextureCoordinatesStaySeams) {
  Mesh ball = make_shape(ShapeKind::sphere, 2000);
  Attribute uv{"uv", Domain::corner, NumberType::float32, 1, {}};
  for (std::size_t f = 0; f < ball.face_count(); ++f) {
    const auto face = ball.face(f);
    const double side = ball.positions[face[0]].x + ball.positions[face[1]].x + ball.positions[face[2]].x > 0 ? 1 : 0;
    uv.values.insert(uv.values.end(), {side, side, side});
  }
  ball.attributes = {uv};
  const Remeshed result = Deformed(ball, pull({0, 0, 1}, {0, 0, 1.8}, 0.2, 0.9)).remeshed();
  for (std::size_t c = 0; c < result.mesh.corner_vertex.size(); ++c) {
    const double value = result.mesh.attributes[0].values[c];
    EXPECT_TRUE(value == 0 || value == 1) << value;
    EXPECT_EQ(value, result.mesh.attributes[0].values[c - c % 3]);
  }
}

TEST(Remesh, NormalsAreTurnedAlong) {
  Mesh ball = make_shape(ShapeKind::sphere, 2000);
  Attribute normal{"normal", Domain::vertex, NumberType::float32, 3, {}};
  for (const Vec3d& p : ball.positions) normal.values.insert(normal.values.end(), {p.x, p.y, p.z});
  ball.attributes = {normal};
  const Remeshed result = Deformed(ball, pull({0, 0, 1}, {0, 0, 1.8}, 0.2, 0.9)).remeshed();
  std::vector<Vec3d> mean(result.mesh.vertex_count());
  for (std::size_t f = 0; f < result.mesh.face_count(); ++f) {
    const auto t = result.mesh.face(f);
    const auto& p = result.mesh.positions;
    for (const std::uint32_t v : t) mean[v] += cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
  }
  double squares = 0;
  for (std::size_t v = 0; v < mean.size(); ++v) {
    const std::vector<double>& values = result.mesh.attributes[0].values;
    const Vec3d n{values[3 * v], values[3 * v + 1], values[3 * v + 2]};
    EXPECT_NEAR(norm(n), 1, 2e-5);
    squares += norm2(n - normalized(mean[v]));
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(mean.size())), 0.05);
}

TEST(Remesh, CoincidentBoundariesStayTogether) {
  // Two halves of a ball that share no vertex.
  const Mesh whole = make_shape(ShapeKind::sphere, 2000);
  Mesh halves;
  std::map<std::pair<std::uint32_t, bool>, std::uint32_t> number;
  for (std::size_t f = 0; f < whole.face_count(); ++f) {
    const auto face = whole.face(f);
    const bool side = whole.positions[face[0]].x + whole.positions[face[1]].x + whole.positions[face[2]].x > 0;
    std::vector<std::uint32_t> renamed;
    for (const std::uint32_t v : face) {
      const auto [at, is_new] = number.try_emplace({v, side}, static_cast<std::uint32_t>(halves.positions.size()));
      if (is_new) halves.positions.push_back(whole.positions[v]);
      renamed.push_back(at->second);
    }
    halves.add_face(renamed);
  }
  const Remeshed result = Deformed(halves, pull({0, 0, 1}, {0.1, 0, 1.9}, 0.2, 0.9)).remeshed();
  // Every boundary edge has a counterpart with the same positions in the other half.
  using Place = std::array<double, 3>;
  std::map<std::pair<Place, Place>, int> uses;
  const auto place = [&](std::uint32_t v) {
    const Vec3d& p = result.mesh.positions[v];
    return Place{p.x, p.y, p.z};
  };
  for (std::size_t f = 0; f < result.mesh.face_count(); ++f) {
    const auto t = result.mesh.face(f);
    for (std::size_t i = 0; i < 3; ++i) {
      const Place a = place(t[i]);
      const Place b = place(t[(i + 1) % 3]);
      uses[{a, b}] += 1;
      uses[{b, a}] -= 1;
    }
  }
  for (const auto& [edge, count] : uses) EXPECT_EQ(count, 0);
  EXPECT_GT(result.counts.splits, 500U);
}

TEST(Remesh, ThePapersRemeshingLosesVolumeWhereOursKeepsIt) {
  const Deformed ball = pulled_ball();
  const double volume = measure(ball.mesh()).volume;
  const double theirs = measure(ball.remeshed({}, {}, test::remesh_as_in_the_paper).mesh).volume / volume - 1;
  const double ours = measure(ball.remeshed().mesh).volume / volume - 1;
  EXPECT_GT(std::abs(theirs), 1e-5);
  EXPECT_LT(std::abs(ours), std::abs(theirs) / 100);
}

TEST(Remesh, CrossingsOfCoarseSamplingAreRefinedAway) {
  const Deformed ball(make_shape(ShapeKind::sphere, 642), pull({0, 0, 1.2}, {0, 0.1, -1.2}, 0.2, 0.6));
  EXPECT_GT(self_intersections(triangulate(ball.mesh()), ball.after()).count, 0U);
  const Remeshed result = ball.remeshed();
  EXPECT_EQ(crossings_as_float(result.mesh), 0U);
  EXPECT_GT(smallest_moved_angle(result), 5);
}

// If crossings cannot be removed, remesh() gives up early, and its counts describe the result that it returns.
TEST(Remesh, WhereHundredsCrossTheCountsAreThoseOfTheResult) {
  const Mesh ball = make_shape(ShapeKind::sphere, 162);
  const auto crumple = [](std::span<Vec3d> points) {  // no flow does this: it folds space
    for (Vec3d& p : points) {
      p += Vec3d{std::sin(7 * p.y + 3 * p.z), std::sin(7 * p.z + 3 * p.x), std::sin(7 * p.x + 3 * p.y)} * 0.7;
    }
  };
  std::vector<Vec3d> after = ball.positions;
  crumple(after);
  RemeshOptions options;
  RemeshSettings coarse;
  coarse.max_chord = 0.01;
  options.targets = resolve(coarse, ball);
  const Remeshed result = remesh(ball, after, {crumple}, options);
  EXPECT_GT(result.counts.crossings, 300U);
  EXPECT_EQ(result.counts.crossings, crossings_as_float(result.mesh));
  EXPECT_EQ(measure(result.mesh).euler, 2);
}

// Parts of a stroke beside a mask are remeshed so; a heap of triangles then costs one search and no improvement.
TEST(Remesh, StopsBeforeItImprovesAHeap) {
  const Mesh ball = make_shape(ShapeKind::sphere, 2000);
  std::vector<Vec3d> after = ball.positions;
  for (std::size_t v = 0; v < after.size(); v += 2) after[v] = after[v] * (v % 3 == 0 ? 0.2 : -0.6);
  RemeshOptions options;
  options.targets = resolve({}, ball);
  options.targets.max_edge = options.targets.max_chord = options.targets.max_angle = 100;  // nothing is split
  options.stop_where_thousands_cross = true;
  const RemeshCounts counts = remesh(ball, after, {[](std::span<Vec3d>) {}}, options).counts;
  EXPECT_TRUE(counts.stopped);
  EXPECT_GT(counts.crossings, 5000U);
  EXPECT_EQ(counts.flips + counts.collapses, 0U);
}

TEST(Remesh, SpansOfAnotherSizeAreRefused) {
  const Deformed ball = pulled_ball(200);
  RemeshOptions options;
  options.targets = resolve({}, ball.mesh());
  const std::vector<Vec3d> few(3);
  EXPECT_THROW(remesh(ball.mesh(), few, ball.deformation(), options), InvalidInput);
  std::vector<Vec3d> nowhere = ball.after();
  nowhere.back().z = std::nan("");
  try {
    remesh(ball.mesh(), nowhere, ball.deformation(), options);
    ADD_FAILURE() << "a position that is not finite was taken";
  } catch (const InvalidInput& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("position " + std::to_string(nowhere.size() - 1)), std::string::npos);
  }
  Mesh beyond = ball.mesh();
  beyond.corner_vertex.back() = static_cast<std::uint32_t>(beyond.vertex_count());
  EXPECT_THROW(remesh(beyond, ball.after(), ball.deformation(), options), InvalidInput);
  const std::vector<std::uint32_t> labels(3);
  options.face_labels = labels;
  EXPECT_THROW(remesh(ball.mesh(), ball.after(), ball.deformation(), options), InvalidInput);
}

TEST(Remesh, OfWhatIsKnownToBeSoundIsTheSame) {
  const Deformed ball = pulled_ball();
  RemeshOptions options;
  options.assume_valid = true;
  expect_same(ball.remeshed(options), ball.remeshed());
}

// Cancelled while points are carried for the k-th time, it never carries others.
TEST(Remesh, IsCancelledBeforeItCarriesMorePoints) {
  const Deformed ball = pulled_ball();
  int all = 0;
  for (int k = 1; k < 100; ++k) {
    Progress progress;
    RemeshOptions options;
    options.targets = resolve({}, ball.mesh());
    options.progress = &progress;
    Deformation deformation = ball.deformation();
    int calls = 0;
    deformation.carry = [&](std::span<Vec3d> points) {
      ball.deformation().carry(points);
      if (++calls == k) progress.cancel = true;
    };
    try {
      remesh(ball.mesh(), ball.after(), deformation, options);
      all = calls;
      break;
    } catch (const Cancelled&) {
      EXPECT_EQ(calls, k);
    }
  }
  EXPECT_GT(all, 3);
}

TEST(Remesh, CountsItsStepsUnlessSomebodyElseCounts) {
  const Deformed ball = pulled_ball();
  Progress progress;
  RemeshOptions options;
  options.progress = &progress;
  ball.remeshed(options);
  EXPECT_GT(progress.total, 5U);
  EXPECT_EQ(progress.done, progress.total);
  progress.total = 1000;
  progress.done = 7;
  ball.remeshed(options);
  EXPECT_EQ(progress.total, 1000U);
  EXPECT_EQ(progress.done, 7U);
}

}  // namespace
}  // namespace knead::remesh_test
