// Fits by near-rigid flows: poses that are known are found again.
#include "knead/fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include "fit/coarse_body.h"
#include "fit/fit_align.h"
#include "fit/fit_tips.h"
#include "fit/functional_map.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "support/unwelded.h"

namespace knead::fit_test {
namespace {

using detail::CoarseBody;

Mesh moved(const Mesh& mesh, const std::vector<Stroke>& strokes) {
  Session session;
  for (const Stroke& stroke : strokes) session.strokes.push_back({stroke});
  Mesh result = mesh;
  result.positions = replay(mesh, session).shape.positions();
  return result;
}

// A cylinder whose upper half is bent.
Mesh cylinder() { return make_shape(ShapeKind::cylinder, 800); }
Mesh bent_cylinder(double degrees) {
  BendStroke bend;
  bend.center = {0, 0, 0};
  bend.axis = {0, 1, 0};
  bend.normal = {0, 0, -1};
  bend.angle_deg = degrees;
  bend.extent = BendWidth{3};
  return moved(cylinder(), {bend});
}

template <class Chosen>
PosePart part_where(const Mesh& mesh, const Chosen& chosen) {
  PosePart part;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (chosen(mesh.positions[v])) part.vertices.push_back({v, v});
  }
  return part;
}

Mesh figure() { return make_shape(ShapeKind::figure, 4000); }

// Both arms go by so many degrees: one up and one down.
Mesh figure_with_arms(double degrees) {
  const Mesh mesh = figure();
  PoseStroke pose;
  PosePart trunk = part_where(mesh, [](const Vec3d& p) { return std::abs(p.x) < 0.12 && p.y > 0.05 && p.y < 0.6; });
  trunk.hold = true;
  PosePart left = part_where(mesh, [](const Vec3d& p) { return p.x > 0.4 && p.y > -0.3; });
  left.rotation = HandlesRotation{{0, 0, 1}, {0.21, 0.475, 0}, degrees};
  PosePart right = part_where(mesh, [](const Vec3d& p) { return p.x < -0.4 && p.y > -0.3; });
  right.rotation = HandlesRotation{{0, 0, 1}, {-0.21, 0.475, 0}, 0.6 * degrees};
  pose.parts = {trunk, left, right};
  pose.detail = 0.075;
  return moved(mesh, {pose});
}

// The shape with its faces in another order, so that no vertex is known to belong to that of the same number.
Mesh with_other_faces(Mesh mesh) {
  const auto corners = static_cast<std::ptrdiff_t>(mesh.face_begin[1] - mesh.face_begin[0]);
  std::rotate(mesh.corner_vertex.begin(), mesh.corner_vertex.begin() + corners, mesh.corner_vertex.end());
  return mesh;
}

// Each vertex the farthest from those before it.
std::vector<FitPair> far_pairs(const Mesh& source, const Mesh& target, std::size_t count) {
  std::vector<FitPair> pairs;
  std::vector<double> distance(source.vertex_count(), kInfinity);
  while (pairs.size() < count) {
    const auto chosen = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    pairs.push_back({source.positions[chosen], target.positions[chosen]});
    for (std::size_t i = 0; i < distance.size(); ++i) {
      distance[i] = std::min(distance[i], norm(source.positions[i] - source.positions[chosen]));
    }
  }
  return pairs;
}

// The mean distance of vertices from where they belong, of the diagonal.
double error_of(const BodyFit& fit, const Mesh& target) {
  double sum = 0;
  for (std::size_t i = 0; i < fit.positions.size(); ++i) sum += norm(fit.positions[i] - target.positions[i]);
  return sum / static_cast<double>(fit.positions.size()) / shape_box(target).diagonal();
}

void expect_sound(const BodyFitReport& report) {
  EXPECT_TRUE(report.is_sound);
  EXPECT_EQ(report.crossings_new, 0);
  EXPECT_LT(report.stretch_99, 2.5);
  EXPECT_LT(report.landmark_distance, kFitExact);
  EXPECT_LT(std::abs(report.volume_error.value_or(1)), 1e-3);
  EXPECT_LE(report.after.mean, report.after_landmarks * 1.001);
}

TEST(Fit, FollowsAPoseByLandmarks) {
  const Mesh source = figure();
  const Mesh target = with_other_faces(figure_with_arms(60));
  const BodyFit fit = fit_body(source, target, {.landmarks = far_pairs(source, target, 16)});
  EXPECT_GT(fit.report.before.mean, 0.01);
  EXPECT_LT(fit.report.after.mean, 1.5e-3);
  EXPECT_LT(error_of(fit, target), 0.012);
  expect_sound(fit.report);
}

TEST(Fit, FindsAPoseWithoutLandmarks) {
  const Mesh target = with_other_faces(figure_with_arms(60));
  const BodyFit fit = fit_body(figure(), target, {});
  EXPECT_GE(fit.report.tips, 3);
  EXPECT_LT(fit.report.after.mean, 3e-3);
  EXPECT_LT(error_of(fit, target), 0.03);
  expect_sound(fit.report);
}

// Equal faces say where each vertex belongs, also where the surface alone does not: a tube that is turned about its own
// axis. Landmarks that say otherwise are believed instead.
TEST(Fit, VerticesOfEqualFacesArePairs) {
  const Mesh source = make_shape(ShapeKind::torus, 1500);
  TwistStroke twist;
  twist.center = {0, 0, 0};
  twist.axis = {0, 1, 0};
  twist.normal = {0, 0, -1};
  twist.inner = -0.9;
  twist.outer = 0.9;
  twist.rate_deg = 30;
  const Mesh target = moved(source, {twist});
  const BodyFit fit = fit_body(source, target, {});
  EXPECT_LT(error_of(fit, target), 2e-3);
  EXPECT_GT(error_of(fit_body(source, with_other_faces(target), {}), target), 5e-3);
  expect_sound(fit.report);
  Mesh turned = source;
  for (Vec3d& p : turned.positions) p = {-p.y, p.x, p.z};
  const std::vector<FitPair> still = far_pairs(source, source, 6);
  EXPECT_LT(error_of(fit_body(source, turned, {.landmarks = still}), source), 5e-3);
  EXPECT_LT(error_of(fit_body(source, turned, {}), turned), 5e-3);
}

// A person of another size is no thicker or thinner: the source grows as a whole before surfaces are matched.
TEST(Fit, GrowsAsAWholeWhereVolumesMayChange) {
  const Mesh source = cylinder();
  Mesh target = source;
  for (Vec3d& p : target.positions) p = p * 1.25 + Vec3d{0.1, 0.05, 0};
  for (const bool has_landmarks : {false, true}) {
    BodyFitOptions options{.surface = !has_landmarks, .align = FitAlign::never, .volume = FitVolume::free};
    if (has_landmarks) options.landmarks = far_pairs(source, target, 6);
    const BodyFit fit = fit_body(source, target, options);
    EXPECT_EQ(fit.report.crossings_new, 0);
    EXPECT_LT(fit.report.after.mean, 1e-3);
    EXPECT_LT(error_of(fit, target), 2e-3);
    EXPECT_NEAR(*fit.report.volume_error, 0.953, 0.01);  // 1.25^3 - 1
    EXPECT_GT(*fit.report.det_least, 1);
    EXPECT_LT(*fit.report.det_greatest, 2.7);
    EXPECT_EQ(moved(source, fit.strokes).positions, fit.positions);
  }
}

// Where volumes are kept nothing grows: the target has a third more. What flat triangles miss is less than a hundredth.
TEST(Fit, DoesNotGrowWhereVolumesAreKept) {
  Mesh target = cylinder();
  for (Vec3d& p : target.positions) p *= 1.1;
  const BodyFit fit = fit_body(cylinder(), target, {});
  EXPECT_LT(std::abs(fit.report.volume_error.value_or(1)), 1e-2);
}

// The strokes, replayed as any session is, give the same bits; so do other numbers of threads.
TEST(Fit, IsItsStrokes) {
  const Mesh source = cylinder();
  const Mesh target = bent_cylinder(40);
  const std::vector<FitPair> pairs = far_pairs(source, target, 6);
  const BodyFit fit = fit_body(source, target, {.landmarks = pairs, .threads = 1});
  EXPECT_EQ(moved(source, fit.strokes).positions, fit.positions);
  const BodyFit again = fit_body(source, target, {.landmarks = pairs, .threads = 2});
  EXPECT_EQ(again.strokes, fit.strokes);
  EXPECT_EQ(again.positions, fit.positions);
  EXPECT_EQ(again.report.after.mean, fit.report.after.mean);
  expect_sound(fit.report);
}

TEST(Fit, LandmarksAloneMoveNothingElseOfTheirOwn) {
  const Mesh source = cylinder();
  const Mesh target = bent_cylinder(30);
  const BodyFit fit = fit_body(source, target, {.landmarks = far_pairs(source, target, 8), .surface = false});
  EXPECT_EQ(fit.report.stage, "landmarks");
  EXPECT_LT(fit.report.landmark_distance, kFitExact);
  EXPECT_LT(fit.report.after.mean, 0.5 * fit.report.before.mean);
  // Holding still is a fit to itself.
  const BodyFit still = fit_body(source, source, {.landmarks = far_pairs(source, source, 8), .surface = false});
  EXPECT_LT(still.report.after.max, 1e-4);
  EXPECT_NEAR(still.report.greatest_stretch, 1, 1e-3);
}

TEST(Fit, TurnsAndMovesTheSourceFirst) {
  const Mesh source = make_shape(ShapeKind::hand, 4000);
  const detail::RigidMap map{detail::Quaternion{0.5, {0.5, -0.5, 0.5}}, {0, 0, 0}, {5, -3, 2}};
  Mesh target = with_other_faces(source);
  for (Vec3d& p : target.positions) p = map(p);
  for (const bool has_landmarks : {false, true}) {
    BodyFitOptions options{.surface = !has_landmarks};
    if (has_landmarks) options.landmarks = far_pairs(source, target, 5);
    const BodyFit fit = fit_body(source, target, options);
    EXPECT_TRUE(fit.report.is_aligned);
    EXPECT_LT(fit.report.after.mean, has_landmarks ? 1e-4 : 1e-3);
    EXPECT_LT(error_of(fit, target), 5e-3);
    EXPECT_EQ(moved(source, fit.strokes).positions, fit.positions);
  }
  const BodyFit fit = fit_body(source, source, {});
  EXPECT_FALSE(fit.report.is_aligned);
  EXPECT_EQ(fit.report.tips, 0);
}

// A wrong landmark with a tolerance yields to the surface; an exact one does not.
TEST(Fit, TolerancesGiveWay) {
  const Mesh source = cylinder();
  const Mesh target = with_other_faces(bent_cylinder(30));
  const double size = shape_box(source).diagonal();
  std::vector<FitPair> pairs = far_pairs(source, target, 8);
  std::size_t wrong = 0;
  while (source.positions[wrong] != pairs[3].source) ++wrong;
  pairs[3].target += vertex_normals(target)[wrong] * (0.04 * size);
  const BodyFit exact = fit_body(source, target, {.landmarks = pairs});
  EXPECT_LT(exact.report.landmark_distance, kFitExact);
  pairs[3].tolerance = 0.06 * size;
  const BodyFit soft = fit_body(source, target, {.landmarks = pairs});
  EXPECT_LT(soft.report.after.max, 0.5 * exact.report.after.max);
  EXPECT_GT(soft.report.landmark_distance, 0.01);
  EXPECT_LE(soft.report.landmark_excess, kFitExact);
}

// A tenth of a map may be wrong.
TEST(Fit, StartsFromAMap) {
  const Mesh source = figure();
  const Mesh target = figure_with_arms(60);
  BodyFitOptions options;
  for (std::size_t i = 0; i < source.vertex_count(); i += 7) {
    const std::size_t to = i % 10 == 0 ? (i * 31) % source.vertex_count() : i;
    options.map.push_back({source.positions[i], target.positions[to]});
  }
  const BodyFit fit = fit_body(source, target, options);
  EXPECT_LT(error_of(fit, target), 0.012);
  EXPECT_LT(fit.report.after.mean, 3e-3);
  expect_sound(fit.report);
}

TEST(Fit, ScalesToTheTargetsVolume) {
  const Mesh source = cylinder();
  Mesh target = bent_cylinder(30);
  for (Vec3d& p : target.positions) p *= 1.2;
  const BodyFit fit = fit_body(source, target, {.volume = FitVolume::total});
  EXPECT_NEAR(fit.report.scale, 1.2, 1e-3);
  EXPECT_LT(fit.report.after.mean, 2e-3);
  Mesh open = source;
  open.face_begin.pop_back();
  open.corner_vertex.resize(open.face_begin.back());
  EXPECT_THROW(fit_body(open, target, {.volume = FitVolume::total}), InvalidInput);
  EXPECT_NO_THROW(fit_body(open, target, {}));
}

TEST(Fit, TurnsATargetThatIsInsideOut) {
  Mesh target = with_other_faces(bent_cylinder(30));
  const BodyFit expected = fit_body(cylinder(), target, {});
  for (std::size_t f = 0; f < target.face_count(); ++f) {
    std::swap(target.corner_vertex[target.face_begin[f]], target.corner_vertex[target.face_begin[f] + 1]);
  }
  const BodyFit fit = fit_body(cylinder(), target, {});
  const std::vector<std::string>& notes = fit.report.notes;
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(),
                          [](const std::string& note) { return note.find("faces look inward") != std::string::npos; }));
  EXPECT_NEAR(fit.report.after.mean, expected.report.after.mean, 5e-4);
}

TEST(Fit, UnweldedTargetsAreSurfaces) {
  const Mesh target = with_other_faces(bent_cylinder(30));
  const BodyFit expected = fit_body(cylinder(), target, {});
  const BodyFit fit = fit_body(cylinder(), test::unwelded(target), {});
  EXPECT_NEAR(fit.report.after.mean, expected.report.after.mean, 5e-4);
  EXPECT_EQ(fit.strokes.size(), expected.strokes.size());
}

// What cannot be reached without spoiling the shape is no success, and no worse than the landmarks.
TEST(Fit, NeverEndsWorseThanItsLandmarks) {
  const Mesh source = cylinder();
  const Mesh target = make_shape(ShapeKind::torus, 800);
  const BodyFit fit = fit_body(source, target, {.max_stretch = 1.3});
  EXPECT_LE(fit.report.after.mean, fit.report.after_landmarks * 1.001);
  EXPECT_EQ(fit.report.is_sound, complaint_about(fit.report, {.max_stretch = 1.3}).empty());
  EXPECT_LE(fit.report.greatest_stretch, 1.3);
}

// Landmarks that ask for too much are followed as far as the shape stays sound, and the complaint says how far.
TEST(Fit, StopsAtTheLastSoundStep) {
  const Mesh source = figure();
  std::vector<FitPair> pairs = far_pairs(source, source, 6);
  for (FitPair& pair : pairs) pair.target.x *= 6;
  const BodyFitOptions options{.landmarks = pairs, .surface = false, .align = FitAlign::never, .max_stretch = 1.5};
  const BodyFit fit = fit_body(source, source, options);
  EXPECT_GT(fit.report.reached, 0.05);
  EXPECT_LT(fit.report.reached, 0.9);
  EXPECT_FALSE(fit.report.obstacle.empty());
  EXPECT_LE(fit.report.greatest_stretch, 3);
  EXPECT_EQ(fit.report.crossings_new, 0);
  EXPECT_FALSE(fit.report.is_sound);
}

// Returns the part of the mesh above a height.
Mesh above(const Mesh& mesh, double height) {
  Mesh result;
  std::vector<std::uint32_t> number(mesh.vertex_count(), 0);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!(mesh.positions[v].y > height)) continue;
    number[v] = static_cast<std::uint32_t>(result.vertex_count());
    result.positions.push_back(mesh.positions[v]);
  }
  for (const Triangle& t : triangulate(mesh)) {
    const auto is_there = [&](std::uint32_t v) { return mesh.positions[v].y > height; };
    if (!std::all_of(t.begin(), t.end(), is_there)) continue;
    result.add_face(std::vector<std::uint32_t>{number[t[0]], number[t[1]], number[t[2]]});
  }
  return result;
}

// A scan that ends above the legs: these stay, and the fit counts where the scan is.
TEST(Fit, PartialTargetsDoNotPull) {
  const Mesh source = figure();
  const Mesh whole = figure_with_arms(40);
  const Mesh target = above(whole, -0.2);
  std::vector<FitPair> pairs;
  for (const FitPair& pair : far_pairs(source, whole, 20)) {
    if (pair.target.y > -0.1) pairs.push_back(pair);
  }
  const BodyFit fit = fit_body(source, target, {.landmarks = pairs, .partial = true});
  EXPECT_TRUE(fit.report.is_sound);
  EXPECT_LT(*fit.report.after_covered, 3e-3);
  EXPECT_LT(*fit.report.matched, 0.9);
  EXPECT_GT(*fit.report.matched, 0.4);
  EXPECT_LT(error_of(fit, whole), 0.012);
}

// Twice the same surface, slightly apart, crosses itself everywhere. That is no reason to leave it where it is.
TEST(Fit, MovesScansThatCrossThemselves) {
  const auto doubled = [](const Mesh& mesh) {
    Mesh result = mesh;
    for (const Triangle& t : triangulate(mesh)) {
      result.add_face(std::vector<std::uint32_t>{t[0] + static_cast<std::uint32_t>(mesh.vertex_count()),
                                                 t[1] + static_cast<std::uint32_t>(mesh.vertex_count()),
                                                 t[2] + static_cast<std::uint32_t>(mesh.vertex_count())});
    }
    const std::vector<Vec3d> normals = vertex_normals(mesh);
    for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
      result.positions.push_back(mesh.positions[i] + normals[i] * (0.01 * std::sin(90 * mesh.positions[i].z)));
    }
    return result;
  };
  const BodyFit fit = fit_body(doubled(make_shape(ShapeKind::cylinder, 2500)), bent_cylinder(20), {});
  EXPECT_GT(fit.report.crossings_before, 1000);
  EXPECT_GT(fit.report.strokes, 0);
  EXPECT_LT(fit.report.after.mean, 0.5 * fit.report.before.mean);
}

TEST(Fit, CanBeCancelled) {
  const Mesh source = figure();
  Progress progress;
  std::thread canceller([&] {
    while (progress.done == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    progress.cancel = true;
  });
  EXPECT_THROW(fit_body(source, figure_with_arms(20), {.progress = &progress}), Cancelled);
  canceller.join();
  EXPECT_LT(progress.done, progress.total);
}

std::string refusal(const Mesh& source, const Mesh& target, const BodyFitOptions& options) {
  try {
    fit_body(source, target, options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

TEST(Fit, SaysWhatIsWrong) {
  const Mesh source = cylinder();
  const Mesh target = bent_cylinder(30);
  const std::vector<FitPair> pairs = far_pairs(source, target, 6);
  const auto with = [&](const FitPair& pair) {
    std::vector<FitPair> changed = pairs;
    changed.push_back(pair);
    return refusal(source, target, {.landmarks = changed});
  };
  const Vec3d p = source.positions[123];
  EXPECT_NE(with({p, {std::nan(""), 0, 0}}).find("pair 6 is not finite"), std::string::npos);
  EXPECT_NE(with({p, p, -1}).find("tolerance of pair 6"), std::string::npos);
  EXPECT_NE(with({pairs[2].source, p}).find("landmarks 2 and 6"), std::string::npos);
  EXPECT_NE(with({p, pairs[2].target}).find("landmarks 2 and 6"), std::string::npos);
  EXPECT_NE(refusal(source, target, {.max_stretch = 1}).find("above 1"), std::string::npos);
  Mesh cloud;
  cloud.positions = source.positions;
  EXPECT_NE(refusal(cloud, target, {}).find("without faces"), std::string::npos);
  EXPECT_EQ(refusal(cloud, target, {.landmarks = pairs, .surface = false}), "none");
  EXPECT_NE(refusal({}, target, {}).find("without vertices"), std::string::npos);
  Mesh line;  // its one face has no area
  line.positions = {{0, 0, 0}, {1, 2, 3}};
  line.add_face(std::vector<std::uint32_t>{0, 1, 1, 0});
  EXPECT_NE(refusal(line, target, {}).find("no area"), std::string::npos);
  EXPECT_NE(refusal(source, line, {}).find("no area"), std::string::npos);
  EXPECT_EQ(refusal(line, target, {.map = {{line.positions[0], p}}, .surface = false}), "none");
  const Mesh hand = make_shape(ShapeKind::hand, 4000);
  Mesh mirrored = hand;
  for (Vec3d& q : mirrored.positions) q.x = -q.x;
  EXPECT_NE(refusal(hand, mirrored, {.landmarks = far_pairs(hand, mirrored, 8)}).find("mirror image"),
            std::string::npos);
}

// From five points the map finds the others; from points that are left for right it is a mirror image, and refused.
TEST(FitMap, IsFoundFromAFewSeeds) {
  const Mesh source = figure();
  const Mesh target = figure_with_arms(60);
  const auto a = detail::spectral_surface(source.positions, triangulate(source), nullptr);
  const auto b = detail::spectral_surface(target.positions, triangulate(target), nullptr);
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->spectrum.values[0], 0, 1e-6);
  EXPECT_NEAR(a->spectrum.values[50] / b->spectrum.values[50], 1, 0.05);
  std::vector<FitPair> seeds = far_pairs(source, target, 5);
  const detail::SurfaceMap map = detail::functional_map(*a, *b, seeds, false, 1, nullptr);
  EXPECT_GT(map.quality, 0.5);
  EXPECT_GT(map.pairs.size(), 500);
  double sum = 0;
  for (const FitPair& pair : map.pairs) {
    const auto at = std::find(source.positions.begin(), source.positions.end(), pair.source) - source.positions.begin();
    sum += norm(pair.target - target.positions[static_cast<std::size_t>(at)]);
  }
  EXPECT_LT(sum / static_cast<double>(map.pairs.size()), 0.02 * shape_box(target).diagonal());
  for (FitPair& pair : seeds) pair.source.x = -pair.source.x;
  EXPECT_LT(detail::functional_map(*a, *b, seeds, true, 1, nullptr).quality, detail::kMinMapQuality);
}

TEST(FitTips, AreTheEndsOfLimbs) {
  const Mesh mesh = figure();
  const CoarseBody body(mesh.positions, triangulate(mesh), 250);
  std::vector<Vec3d> tips;
  for (const std::uint32_t i : detail::tips_of(body)) tips.push_back(body.nodes()[i]);
  const auto has = [&](const Vec3d& p) {
    return std::any_of(tips.begin(), tips.end(), [&](const Vec3d& tip) { return norm(tip - p) < 0.2; });
  };
  EXPECT_TRUE(has({0.9, -0.12, 0.05}) && has({-0.9, -0.12, 0.05}));
  EXPECT_TRUE(has({0.2, -0.97, 0.15}) && has({-0.2, -0.97, 0.15}));
  EXPECT_TRUE(has({0, 0.98, 0}));
}

// A limb that turns by 120 degrees goes round, not through.
TEST(FitPaths, TurnAboutJoints) {
  const Mesh mesh = cylinder();
  CoarseBody body(mesh.positions, triangulate(mesh), 300);
  std::vector<detail::Anchor> anchors;
  const Vec3d joint{0, 0, 0};
  for (const Vec3d& p : mesh.positions) {
    if (p.z < -1) anchors.push_back({p, p});
    if (p.z < 1) continue;
    const double angle = 2.0943951023931953;
    anchors.push_back(
        {p, {p.x * std::cos(angle) + p.z * std::sin(angle), p.y, p.z * std::cos(angle) - p.x * std::sin(angle)}});
  }
  body.pose(anchors, nullptr);
  const auto paths = body.paths(anchors, 8);
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    EXPECT_EQ(paths[i].front(), anchors[i].from);
    EXPECT_EQ(paths[i].back(), anchors[i].to);
    const double before = norm(anchors[i].from - joint);
    // A straight line comes as near as half of that.
    if (before < 2) continue;
    for (const Vec3d& p : paths[i]) EXPECT_GT(norm(p - joint), 0.7 * before);
  }
}

// Rounding must not decide how points on a line are turned about it: as little as possible.
TEST(FitTurns, HardlyTurnPointsOnALineAboutIt) {
  using namespace detail;
  std::mt19937 random(21);
  const auto number = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  const auto direction = [&] { return normalized(Vec3d{number(), number(), number()}); };
  for (int round = 0; round < 50; ++round) {
    const Vec3d along = direction();
    const Vec3d beside = any_orthogonal(along);
    const Vec3d bent = normalized(along + beside * 0.5);
    const double turned = std::acos(dot(along, bent));
    std::vector<Vec3d> from;
    std::vector<Vec3d> to;
    for (int i = 0; i < 8; ++i) {
      const double at = 3 * number();
      from.push_back(along * at + beside * 0.5);
      to.push_back(bent * at + beside * 0.5 + direction() * 1e-12);
    }
    const Quaternion turn = nearest_rigid(from, to).turn;
    EXPECT_NEAR(2 * std::acos(std::min(1.0, turn.w)), turned, 1e-6);
  }
}

TEST(FitTurns, AreNearestRotations) {
  using namespace detail;
  const Quaternion turn{0.5, {0.5, -0.5, 0.5}};
  std::vector<Vec3d> from{{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 1, 1}};
  std::vector<Vec3d> to;
  for (const Vec3d& p : from) to.push_back(turn * p + Vec3d{1, 2, 3});
  EXPECT_LT(rms_of(nearest_rigid(from, to), from, to), 1e-14);
  // A mirror image is no rotation.
  for (Vec3d& p : to) p.x = -p.x;
  const RigidMap map = nearest_rigid(from, to);
  EXPECT_NEAR(map.turn.w * map.turn.w + norm2(map.turn.v), 1, 1e-14);
  EXPECT_GT(rms_of(map, from, to), 0.5);
  const Quaternion half = part_of(turn, 0.5) * part_of(turn, 0.5);
  EXPECT_NEAR(half.w, turn.w, 1e-14);
}

}  // namespace
}  // namespace knead::fit_test
