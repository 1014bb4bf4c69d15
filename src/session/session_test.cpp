// Session files: round trips of every stroke, defaults, undo and redo.
#include "knead/session.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>

#include "knead/error.h"
#include "support/scratch.h"

namespace knead::session_test {
namespace {

const std::string kHeader = "{\"knead\": 1}\n";

// Valid strokes of every tool, with every key at its default now and then.
class RandomStrokes {
 public:
  explicit RandomStrokes(unsigned seed) : random_(seed) {}

  Stroke next() {
    switch (std::uniform_int_distribution<int>(0, 12)(random_)) {
      case 0:
        return implicit();
      case 1:
        return PaintStroke{positive(), -positive(), {{vector(), vector()}, {vector(), vector()}}};
      case 2:
        return points();
      case 3:
        return RotateStroke{vector(), vector(), number(), 0, positive(), gauge()};
      case 4:
        return StretchStroke{vector(), vector(), positive(), 0.5 * 1e-9, positive()};
      case 5:
        return twist();
      case 6:
        return PaintStroke{positive(), positive(), {}, {vector(), vector()}};
      case 7:
        return handles();
      case 8:
        return stamp();
      case 9:
        return RelaxStroke{{vector(), vector()}, positive(), coin() ? 0.5 : 1, coin() ? 1.0 : 0.25, coin() ? 2 : 7};
      case 10:
        return pins();
      case 11:
        return grid();
      default:
        return bend();
    }
  }

 private:
  bool coin() { return std::bernoulli_distribution()(random_); }
  double number() { return std::normal_distribution<double>(0, 10)(random_); }
  double positive() { return 1e-6 + std::abs(number()); }
  double gauge() { return coin() ? 0 : (coin() ? -0.0 : number()); }
  Vec3d vector() { return {number(), coin() ? 0.0 : number(), coin() ? -0.0 : number() * 1e-200}; }

  Stroke implicit() {
    ImplicitStroke stroke{{vector(), vector(), vector()}, 1e-7, positive()};
    if (coin()) stroke.time = TimeLaw::blended;
    if (coin()) stroke.taper = 0.3;
    if (coin()) {
      stroke.falloff = kWideFalloff;
      stroke.inner = 0;
      stroke.bump = positive();
      stroke.outer = coin() ? 0 : 1.1 * stroke.bump;
      if (coin()) stroke.core = coin() ? 0 : 0.7;
      return stroke;
    }
    if (coin()) return stroke;
    stroke.region = ImplicitRegion::capsule;
    stroke.half_axis = vector();
    stroke.gauge = gauge();
    return stroke;
  }

  Stroke points() {
    PointsStroke stroke;
    stroke.points = {vector(), vector()};
    if (coin()) stroke.curves = {{vector(), vector()}, {vector(), vector(), vector()}};
    if (coin() && !stroke.curves.empty()) stroke.points.clear();
    stroke.outer = positive() + 1;
    stroke.displacements = {vector(), vector()};
    stroke.exponent = coin() ? 8 : 16;
    stroke.inner = coin() ? 0 : 0.5;
    stroke.center = coin() ? PointsCenter::parts : PointsCenter::barycentre;
    return stroke;
  }

  Stroke twist() {
    TwistStroke stroke{vector(), vector(), number(), -positive(), positive()};
    if (coin()) stroke.normal = vector();
    if (coin()) stroke.radius = positive();
    stroke.radius_auto = !stroke.radius && coin();
    stroke.gauge = gauge();
    return stroke;
  }

  Stroke handles() {
    HandlesStroke stroke;
    if (coin()) {
      stroke.full = {vector(), vector() + Vec3d{1, 1, 1}};
    } else {
      stroke.full_vertices = {3, 1};
    }
    if (coin()) {
      stroke.zero = {vector() - Vec3d{100, 100, 100}};
    } else {
      stroke.zero_vertices = {0, 4000000};
    }
    stroke.motion = HandlesTranslation{vector()};
    if (coin()) stroke.motion = HandlesRotation{vector(), vector(), number()};
    stroke.exponent = coin() ? 8 : 6;
    return stroke;
  }

  Stroke stamp() {
    StampStroke stroke;
    stroke.mesh = "tools/a \"Y\".ply";
    stroke.path = {vector(), vector(), vector()};
    if (coin()) stroke.pose = {{0, -1.5, 0}, {1.5, 0, 0}, {0, 0, 1.5}};
    if (coin()) stroke.outer = positive();
    if (coin()) stroke.step = positive();
    stroke.contact = coin() ? StampContact::stick : StampContact::slip;
    if (stroke.contact == StampContact::stick) stroke.exponent = coin() ? 16 : 8;
    return stroke;
  }

  Stroke pins() {
    PinsStroke stroke{{{0, 0, 0}, {1, 2, 3}}, {{number(), 0, 0}, {4, 5, 6}}, std::nullopt, coin()};
    if (!stroke.radius_auto) stroke.radius = 1e-3;
    if (coin()) stroke.turn = {std::nullopt, PinRotation{vector(), number()}};
    return stroke;
  }

  Stroke grid() {
    GridStroke stroke;
    stroke.grid.origin = vector();
    stroke.grid.spacing = positive();
    stroke.grid.counts = {1, 2, 3};
    stroke.grid.coefficients = vectors(6);
    if (coin()) stroke.grid.end_coefficients = vectors(6);
    return stroke;
  }

  SharedVectors vectors(std::size_t count) {
    std::vector<Vec3d> list(count);
    for (Vec3d& v : list) v = vector();
    return SharedVectors(std::move(list));
  }

  Stroke bend() {
    BendStroke stroke{vector(), {0, 1, 0}, {1, 0, 0}, number(), {}};
    stroke.extent = BendWidth{positive(), coin() ? kCenterFraction : number()};
    if (coin()) stroke.extent = BendThresholds{-positive(), positive()};
    stroke.gauge = coin() ? 1 : gauge();
    if (coin()) stroke.radius = positive();
    stroke.radius_auto = !stroke.radius && coin();
    if (coin()) stroke.falloff = 7;
    return stroke;
  }

  std::mt19937_64 random_;
};

TEST(Session, RoundTripsEveryStrokeToTheBit) {
  constexpr unsigned kSeed = 11;
  RandomStrokes strokes(kSeed);
  for (int i = 0; i < 500; ++i) {
    const Stroke stroke = strokes.next();
    const std::string line = stroke_line(stroke);
    const Session session = parse_session(kHeader + line + "\n", "s.knead");
    ASSERT_EQ(session.strokes.size(), 1u);
    EXPECT_EQ(session.strokes[0].stroke, stroke) << "seed " << kSeed << ", line " << line;
    EXPECT_EQ(session.strokes[0].line, 2u);
    EXPECT_EQ(session.strokes[0].remesh, std::nullopt);
    EXPECT_EQ(stroke_line(session.strokes[0].stroke), line);  // tells 0 from -0 too
  }
}

TEST(Session, RoundTripsAsAWhole) {
  RandomStrokes strokes(12);
  Session session;
  session.name = "s.knead";
  session.mesh = "../a \"mesh\"\\\n.ply";
  session.note = "Grüße, \t and \x01";
  for (std::size_t i = 0; i < 20; ++i) session.strokes.push_back({strokes.next(), i + 2});
  EXPECT_EQ(parse_session(serialize_session(session), "s.knead"), session);
}

RemeshSettings random_settings(std::mt19937_64& random) {
  const auto chance = [&] { return random() % 2 == 0; };
  const auto fraction = [&] { return std::uniform_real_distribution<double>(0.01, 0.4)(random); };
  RemeshSettings settings;
  if (chance()) settings.max_edge = 1 + fraction();
  if (chance()) settings.max_angle_deg = 100 * fraction();
  if (chance()) settings.max_chord = fraction();
  if (chance()) settings.min_edge = fraction();
  if (chance()) settings.iterations = static_cast<int>(random() % 100);
  return settings;
}

TEST(Session, RoundTripsRemeshSettings) {
  constexpr unsigned kSeed = 16;
  std::mt19937_64 random(kSeed);
  RandomStrokes strokes(17);
  for (int round = 0; round < 100; ++round) {
    Session session;
    session.name = "s.knead";
    std::optional<RemeshSettings> current;
    std::size_t line = 1;
    for (int i = 0; i < 6; ++i) {
      const std::optional<RemeshSettings> before = current;
      if (random() % 2 == 0) current = random_settings(random);
      if (random() % 4 == 0) current.reset();
      if (current != before) ++line;
      session.strokes.push_back({strokes.next(), ++line, current});
    }
    EXPECT_EQ(parse_session(serialize_session(session), "s.knead"), session) << "seed " << kSeed;
  }
}

// An undo takes back strokes, not settings; a stroke that is redone comes back with its own.
TEST(Session, StrokesHaveTheRemeshSettingsThatTheyWereDrawnWith) {
  const std::string stroke = stroke_line(RotateStroke{{}, {0, 0, 1}, 1, 1, 2}) + "\n";
  RemeshSettings fine;
  fine.max_edge = 0.5;
  fine.iterations = 2;
  const std::string text = kHeader + stroke + "{\"remesh\": {}}\n" + stroke + remesh_line(fine) + "\n{\"undo\": 1}\n" +
                           "{\"redo\": 1}\n" + stroke + "{\"undo\": 2}\n" + stroke + "{\"remesh\": null}\n" + stroke;
  const Session session = parse_session(text, "s.knead");
  ASSERT_EQ(session.strokes.size(), 3u);
  EXPECT_EQ(session.strokes[0].remesh, std::nullopt);
  EXPECT_EQ(session.strokes[1].remesh, fine);
  EXPECT_EQ(session.strokes[2].remesh, std::nullopt);
  const std::string redone =
      kHeader + "{\"remesh\": {}}\n" + stroke + "{\"undo\": 1}\n{\"remesh\": null}\n{\"redo\": 1}\n";
  EXPECT_EQ(parse_session(redone, "s.knead").strokes.at(0).remesh, RemeshSettings{});
  EXPECT_EQ(remesh_line(std::nullopt), "{\"remesh\": null}");
  EXPECT_EQ(remesh_line(RemeshSettings{}), "{\"remesh\": {}}");
  EXPECT_EQ(remesh_line(fine), "{\"remesh\": {\"max_edge\": 0.5, \"iterations\": 2}}");
}

TEST(Session, ReadsTheExampleOfItsSpecification) {
  const Session session = parse_session(
      R"({"knead": 1}
{"tool": "implicit", "inner": 0.2, "outer": 0.6, "path": [[-1, 0, 0], [0, 0.2, 0], [0.8, 0.1, 0.1]]}
{"tool": "bend", "center": [0, 0, 0], "axis": [0, 1, 0], "normal": [1, 0, 0], "width": 1.0, "angle_deg": 70}
{"undo": 1}
)",
      "s.knead");
  ASSERT_EQ(session.strokes.size(), 1u);
  EXPECT_EQ(session.strokes[0].line, 2u);
  EXPECT_EQ(std::get<ImplicitStroke>(session.strokes[0].stroke),
            (ImplicitStroke{{{-1, 0, 0}, {0, 0.2, 0}, {0.8, 0.1, 0.1}}, 0.2, 0.6}));
}

TEST(Session, FillsInTheDefaults) {
  const Session session =
      parse_session(kHeader + R"({"tool": "points", "points": [[0,0,0]], "outer": 1, "displacements": [[0,0,1]]}
{"tool": "rotate", "center": [0,0,0], "axis": [0,0,1], "angle_deg": 1, "inner": 0, "outer": 1}
{"tool": "twist", "center": [0,0,0], "axis": [0,0,1], "rate_deg": 1, "inner": 0, "outer": 1}
{"tool": "bend", "center": [0,0,0], "axis": [0,0,1], "normal": [1,0,0], "angle_deg": 1, "width": 2})",
                    "s.knead");
  const auto& points = std::get<PointsStroke>(session.strokes.at(0).stroke);
  EXPECT_EQ(points.exponent, 8);
  EXPECT_EQ(points.inner, 0);
  EXPECT_EQ(points.center, PointsCenter::parts);
  EXPECT_EQ(std::get<RotateStroke>(session.strokes.at(1).stroke).gauge, 0);
  const auto& twist = std::get<TwistStroke>(session.strokes.at(2).stroke);
  EXPECT_EQ(twist.gauge, 0);
  EXPECT_FALSE(twist.normal || twist.radius);
  const auto& bend = std::get<BendStroke>(session.strokes.at(3).stroke);
  EXPECT_EQ(bend.gauge, 1);
  EXPECT_FALSE(std::get<BendWidth>(bend.extent).center_fraction);
  EXPECT_EQ(bend.falloff, 4);
}

TEST(Session, ToleratesWhatEditorsLeaveBehind) {
  const std::string plain = kHeader + stroke_line(RandomStrokes(13).next()) + "\n{\"undo\": 1}\n{\"redo\": 1.0}\n";
  std::string with_cr;
  for (const char c : plain) with_cr += c == '\n' ? "\r\n" : std::string(1, c);
  const Session session = parse_session(plain, "s.knead");
  EXPECT_EQ(parse_session(with_cr, "s.knead"), session);
  EXPECT_EQ(parse_session("\xEF\xBB\xBF" + plain, "s.knead"), session);
  EXPECT_EQ(parse_session(plain + "\n \r\n\t", "s.knead"), session);
  EXPECT_EQ(parse_session(plain.substr(0, plain.size() - 1), "s.knead"), session);
  EXPECT_TRUE(session.warnings.empty());
}

// The events of a session, and what they mean, in the plainest way: a list and a cursor.
TEST(Session, UndoesAndRedoesLikeAListWithACursor) {
  constexpr unsigned kSeed = 14;
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 200; ++round) {
    std::string text = kHeader;
    std::vector<std::size_t> lines;  // of strokes that are done or can be redone
    std::size_t done = 0;
    for (std::size_t line = 2; line < 30; ++line) {
      const std::size_t kind = random() % 4;
      if (kind == 1 && done > 0) {
        const std::size_t n = 1 + random() % done;
        text += "{\"undo\": " + std::to_string(n) + "}\n";
        done -= n;
      } else if (kind == 2 && done < lines.size()) {
        const std::size_t n = 1 + random() % (lines.size() - done);
        text += "{\"redo\": " + std::to_string(n) + "}\n";
        done += n;
      } else {
        text += stroke_line(RotateStroke{{}, {0, 0, 1}, static_cast<double>(line), 1, 2}) + "\n";
        lines.resize(done);
        lines.push_back(line);
        ++done;
      }
    }
    const Session session = parse_session(text, "s.knead");
    ASSERT_EQ(session.strokes.size(), done) << "seed " << kSeed << "\n" << text;
    for (std::size_t i = 0; i < done; ++i) {
      EXPECT_EQ(session.strokes[i].line, lines[i]) << "seed " << kSeed << "\n" << text;
      EXPECT_EQ(std::get<RotateStroke>(session.strokes[i].stroke).angle_deg, static_cast<double>(lines[i]));
    }
  }
}

// A file cut anywhere is the session of its whole lines, or lacks its header.
TEST(Session, CutAtEveryByteIsASessionOrACleanError) {
  RandomStrokes strokes(15);
  std::string text = header_line("a.ply", "Grüße") + "\n";
  const std::size_t header = text.size() - 1;
  for (int i = 0; i < 8; ++i) text += stroke_line(strokes.next()) + "\n";
  text += "{\"undo\": 2}\n";
  const Session whole = parse_session(text, "s.knead");
  for (std::size_t size = 0; size < text.size(); ++size) {
    const std::string cut = text.substr(0, size);
    if (size < header) {
      EXPECT_THROW(parse_session(cut, "s.knead"), InvalidInput);
      continue;
    }
    const Session session = parse_session(cut, "s.knead");
    const bool incomplete = cut.back() != '\n' && text[size] != '\n';
    EXPECT_EQ(session.warnings.size(), incomplete ? 1u : 0u) << cut;
    for (std::size_t i = 0; i < std::min(session.strokes.size(), whole.strokes.size()); ++i) {
      EXPECT_EQ(session.strokes[i], whole.strokes[i]);
    }
  }
  EXPECT_EQ(parse_session(text.substr(0, text.size() - 3), "s.knead").warnings.at(0),
            "s.knead:10: the last line is incomplete and was left out");
}

TEST(Session, SurvivesDeepNestingAndLongLines) {
  EXPECT_THROW(parse_session(kHeader + std::string(1'000'000, '[') + "\n", "s.knead"), InvalidInput);
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  EXPECT_THROW(parse_session(kHeader + "{\"tool\": " + deep + "}\n", "s.knead"), InvalidInput);
  ImplicitStroke stroke{{}, 0.1, 0.5};
  for (int i = 0; i < 100'000; ++i) stroke.path.push_back({0.001 * i, 0, 0});
  EXPECT_EQ(parse_session(kHeader + stroke_line(stroke), "s.knead").strokes.at(0).stroke, Stroke(stroke));
}

TEST(Session, IsReadFromAFile) {
  const test::Scratch scratch("session");
  const std::filesystem::path path = scratch.path() / "s.knead";
  std::ofstream(path, std::ios::binary) << kHeader << "{\"undo\": 1}\n";
  try {
    read_session(path);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with(path.string() + ":2: \"undo\" must be")) << error.what();
  }
  std::filesystem::remove(path);
  EXPECT_THROW(read_session(path), IoError);
  EXPECT_THROW(read_session(path.parent_path()), IoError);  // a folder
}

TEST(Session, MasksAreUndoneAsStrokesAreAndReadBackToTheBit) {
  const std::string text =
      "{\"knead\": 1}\n"
      "{\"mask\": {\"points\": [[0, 1, 0], [0.1, -0.0, 3]], \"values\": [1, 0.25], \"width\": 0.1}}\n"
      "{\"mask\": {\"vertices\": [[0, 811], 900], \"width\": 0.2}}\n"
      "{\"mask\": null}\n";
  const Session session = parse_session(text, "s.knead");
  ASSERT_EQ(session.strokes.size(), 3U);
  const auto& points = std::get<MaskStroke>(session.strokes[0].stroke);
  EXPECT_EQ(points.values, (std::vector<double>{1, 0.25}));
  const auto& vertices = std::get<MaskStroke>(session.strokes[1].stroke);
  EXPECT_EQ(vertices.vertices, (std::vector<VertexRange>{{0, 811}, {900, 900}}));
  EXPECT_TRUE(reads_surface(vertices));
  EXPECT_TRUE(is_empty(std::get<MaskStroke>(session.strokes[2].stroke)));
  EXPECT_EQ(serialize_session(session), text);
  EXPECT_EQ(parse_session(text + "{\"undo\": 2}\n{\"redo\": 1}\n", "s.knead").strokes.size(), 2U);
}

}  // namespace
}  // namespace knead::session_test
