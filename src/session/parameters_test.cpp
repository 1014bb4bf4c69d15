// Parameters of a session: the header gives them, strokes name them.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/replay.h"
#include "knead/session.h"

namespace knead::parameters_test {
namespace {

const std::string kHeader =
    R"({"knead": 1, "parameters": {"length": 0.2, "angle": {"value": 40, "min": 0, "max": 90}, "n": 4}})"
    "\n";
const std::string kPull =
    R"({"tool": "implicit", "path": [[0, 1, 0], [0, "$length", 0.5]], "inner": 0.1, "outer": 0.6})";
const std::string kTurn =
    R"({"tool": "rotate", "name": "$ turn", "strength": "$length", "center": [0, 1, 0], "axis": [0, 1, 0], )"
    R"("angle_deg": "$angle", "inner": 0.2, "outer": 0.6, "falloff": "$n"})";
const std::string kMask = R"({"mask": {"points": [[0, 1, "$length"]], "width": 0.2}})";

Session session_of(const std::string& lines, const std::string& header = kHeader) {
  return parse_session(header + lines, "s.knead");
}

std::string error_of(const std::string& header, const std::string& lines = "") {
  try {
    session_of(lines, header + "\n");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no error";
}

std::string error_of(const Session& session, const ParameterValues& values) {
  try {
    with_values(session, values);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no error";
}

TEST(Parameters, StandForNumbersOfStrokes) {
  const Session session = session_of(kPull + "\n" + kTurn + "\n" + kMask + "\n");
  EXPECT_EQ(std::get<ImplicitStroke>(session.strokes[0].stroke).path[1], (Vec3d{0, 0.2, 0.5}));
  EXPECT_EQ(std::get<RotateStroke>(session.strokes[1].stroke).angle_deg, 40);
  EXPECT_EQ(std::get<RotateStroke>(session.strokes[1].stroke).falloff, 4);
  EXPECT_EQ(session.strokes[1].strength, 0.2);
  EXPECT_EQ(session.strokes[1].name, "$ turn");
  EXPECT_EQ(std::get<MaskStroke>(session.strokes[2].stroke).points.front(), (Vec3d{0, 1, 0.2}));
  ASSERT_EQ(session.parameters.size(), 3U);
  EXPECT_EQ(session.parameters[1], (Parameter{"angle", 40, 0, 90}));
}

// Byte for byte, for lines that are written as the library writes them.
TEST(Parameters, AreWrittenWhereTheyWereRead) {
  const std::string lines = kPull + "\n" + kTurn + "\n" + kMask + "\n";
  EXPECT_EQ(serialize_session(session_of(lines)), kHeader + lines);
  // Also where the value is the default of the key, which is left out otherwise.
  const std::string half = R"({"tool": "twist", "center": [0, 0, 0], "axis": [0, 0, 1], "rate_deg": 9, "inner": -2, )"
                           R"("outer": 2, "gauge": "$gauge"})"
                           "\n";
  const std::string zero = R"({"knead": 1, "parameters": {"gauge": 0}})"
                           "\n";
  EXPECT_EQ(serialize_session(session_of(half, zero)), zero + half);
}

TEST(Parameters, GiveTheBitsOfTheNumbers) {
  const std::string numbers = R"({"tool": "implicit", "path": [[0, 1, 0], [0, 0.1, 0.5]], "inner": 0.1, "outer": 0.6})";
  const Session named = with_values(session_of(kPull), {{"length", 0.1}});
  const Session plain = session_of(numbers);
  EXPECT_EQ(named.strokes[0].stroke, plain.strokes[0].stroke);
  EXPECT_EQ(stroke_line(named.strokes[0]), stroke_line(plain.strokes[0]));
  EXPECT_EQ(flow_of(named), flow_of(plain));
}

// A value that is set is the one that the session is written with, and can be set again.
TEST(Parameters, CanBeSetAgain) {
  const Session session = session_of("{\"remesh\": {}}\n" + kPull + "\n" + kTurn + "\n");
  const Session changed = with_values(session, {{"length", 0.7}, {"angle", 90}});
  EXPECT_EQ(std::get<RotateStroke>(changed.strokes[1].stroke).angle_deg, 90);
  EXPECT_EQ(changed.strokes[1].line, session.strokes[1].line);
  EXPECT_EQ(changed.strokes[0].remesh, session.strokes[0].remesh);
  EXPECT_EQ(parse_session(serialize_session(changed), "s.knead").strokes[1].stroke, changed.strokes[1].stroke);
  EXPECT_EQ(with_values(changed, {{"length", 0.2}, {"angle", 40}}), session);
  EXPECT_EQ(with_values(session, {}), session);
}

// A key that was edited is a number; the others keep their names.
TEST(Parameters, StayBesideNumbersThatWereEdited) {
  Session session = session_of(kTurn);
  std::get<RotateStroke>(session.strokes[0].stroke).angle_deg = 41;
  session.strokes[0].off = true;
  EXPECT_EQ(serialize_session(session),
            kHeader +
                R"({"tool": "rotate", "name": "$ turn", "off": true, "strength": "$length", "center": [0, 1, 0], )"
                R"("axis": [0, 1, 0], "angle_deg": 41, "inner": 0.2, "outer": 0.6, "falloff": "$n"})"
                "\n");
  const Session changed = with_values(session, {{"angle", 3}, {"length", 0.5}});
  EXPECT_EQ(std::get<RotateStroke>(changed.strokes[0].stroke).angle_deg, 41);
  EXPECT_EQ(changed.strokes[0].strength, 0.5);
}

// A file can be read again, whatever was done to the session.
TEST(Parameters, AreNumbersInSessionsThatDoNotHaveThem) {
  const Session session = session_of(kPull);
  const std::string numbers = R"({"tool": "implicit", "path": [[0, 1, 0], [0, 0.2, 0.5]], "inner": 0.1, "outer": 0.6})";
  EXPECT_EQ(stroke_line(session.strokes[0]), numbers);
  Session other;
  other.strokes = session.strokes;
  EXPECT_EQ(serialize_session(other), "{\"knead\": 1}\n" + numbers + "\n");
  other.parameters = {{"width", 3}};
  EXPECT_EQ(serialize_session(other), "{\"knead\": 1, \"parameters\": {\"width\": 3}}\n" + numbers + "\n");
  other.parameters = {{"length", 3}};  // another number than the stroke has
  EXPECT_EQ(serialize_session(other), "{\"knead\": 1, \"parameters\": {\"length\": 3}}\n" + numbers + "\n");
}

TEST(Parameters, OfTheHeaderAreReadStrictly) {
  const auto header = [](const std::string& parameters) { return R"({"knead": 1, "parameters": )" + parameters + "}"; };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"[]", R"("parameters" must be a JSON object {...}, got an array of 0)"},
      {R"({"2x": 1})", R"("2x" is no name of a parameter; use letters, digits and underscores, and no digit first)"},
      {R"({"": 1})", R"("" is no name of a parameter)"},
      {R"({"a-b": 1})", R"("a-b" is no name of a parameter)"},
      {R"({"a": "1"})", R"("parameters" "a" must be a number, or {"value": ..., "min": ..., "max": ...}, got "1")"},
      {R"({"a": {"min": 1}})", R"("parameters" "a" "value" is missing)"},
      {R"({"a": {"value": 1, "mean": 1}})", R"(unknown key "mean"; a parameter has the keys "value", "min", "max")"},
      {R"({"a": {"value": 1, "min": 3, "max": 2}})", R"(parameter "a": "min" must not be above "max", got 3 and 2)"},
      {R"({"a": {"value": 1, "min": 2, "max": 3}})", R"(parameter "a" must be from 2 to 3, got 1)"},
      {R"({"a": {"value": 1, "min": 2}})", R"(parameter "a" must be at least 2, got 1)"},
      {R"({"a": {"value": 1, "max": 0.5}})", R"(parameter "a" must be at most 0.5, got 1)"},
      {R"({"a": 1, "a": 2})", R"(the key "a" is given twice)"},
  };
  for (const auto& [parameters, message] : cases) {
    EXPECT_TRUE(error_of(header(parameters)).starts_with("s.knead:1: " + message)) << error_of(header(parameters));
  }
}

TEST(Parameters, ThatAreUnknownOrUnusableNameLineAndReason) {
  const std::string header = R"({"knead": 1, "parameters": {"length": 0.2, "text": 1}})";
  EXPECT_EQ(error_of(header, R"({"tool": "bend", "width": "$lenght"})"),
            R"(s.knead:2: no parameter "lenght"; the session has "length", "text")");
  EXPECT_EQ(error_of(R"({"knead": 1})", R"({"tool": "bend", "width": "$length"})"),
            R"(s.knead:2: no parameter "length"; the session has none: its first line needs the key "parameters")");
  EXPECT_TRUE(
      error_of(header, R"({"remesh": {"max_edge": "$length"}})").starts_with("s.knead:2: \"remesh\" \"max_edge\""));
  EXPECT_TRUE(error_of(header, R"({"undo": "$text"})").starts_with("s.knead:2: \"undo\" must be a whole number"));
  const Session session = session_of(kTurn);
  EXPECT_EQ(error_of(session, {{"angel", 1}}),
            R"(s.knead: no parameter "angel"; the session has "length", "angle", "n")");
  EXPECT_EQ(error_of(session, {{"angle", 91}}), R"(s.knead: parameter "angle" must be from 0 to 90, got 91)");
  EXPECT_EQ(error_of(session, {{"n", kInfinity}}), R"(s.knead: parameter "n" must be a finite number, got inf)");
  EXPECT_TRUE(error_of(session, {{"n", 4.5}}).starts_with("s.knead:2: \"falloff\" must be a whole number"));
  EXPECT_TRUE(error_of(session, {{"length", 2}}).starts_with("s.knead:2: \"strength\" must be a number from 0 to 1.5"));
}

// "$" is no name in a session without parameters: texts stay as they are.
TEST(Parameters, DoNotTouchTexts) {
  const std::string stamp = R"({"tool": "stamp", "name": "$5", "mesh": "$tool.ply", "path": [[0, 0, 1], [0, 0, 0.9]]})"
                            "\n";
  EXPECT_EQ(serialize_session(session_of(stamp, "{\"knead\": 1}\n")), "{\"knead\": 1}\n" + stamp);
  EXPECT_EQ(serialize_session(session_of(stamp)), kHeader + stamp);
}

}  // namespace
}  // namespace knead::parameters_test
