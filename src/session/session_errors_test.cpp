// Messages about invalid session files: file, line, key, and what was expected.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/session.h"

namespace knead::session_errors_test {
namespace {

std::string error_of(const std::string& text) {
  try {
    parse_session(text, "s.knead");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no error";
}

struct Case {
  std::string line;
  std::string message;  // how it begins, after file and line
};

TEST(SessionErrors, OfTheHeaderNameLineOne) {
  const std::vector<Case> cases{
      {"", "the file is empty"},
      {" \n\n", "the file is empty"},
      {"{\"tool\": \"bend\"}\n", "\"knead\" is missing; the first line must be the header"},
      {"{\"knead\": 2}\n", "\"knead\" must be 1, the format that this version reads, got 2"},
      {"{\"knead\": \"1\"}\n", "\"knead\" must be a whole number, got \"1\""},
      {"{\"knead\": 1.5}\n", "\"knead\" must be a whole number"},
      {"{\"knead\": 1, \"mash\": \"a.ply\"}\n", "unknown key \"mash\"; the header has the keys \"knead\", \"mesh\""},
      {"{\"knead\": 1, \"mesh\": 3}\n", "\"mesh\" must be text in double quotes, got 3"},
      {"{\"knead\": 1, \"note\": null}\n", "\"note\" must be text in double quotes, got null"},
      {"{\"knead\": 1", "the JSON object of this line is incomplete"},
      {"[1]\n", "the line must be a JSON object"},
      {"\n{\"knead\": 1}\n", "the line is empty"},
      {"ply\n", "column 1 is not JSON"},
  };
  for (const Case& c : cases) {
    EXPECT_TRUE(error_of(c.line).starts_with("s.knead:1: " + c.message)) << c.line << "gives: " << error_of(c.line);
  }
}

void expect_errors(const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    const std::string error = error_of("{\"knead\": 1}\n" + c.line + "\n");
    EXPECT_TRUE(error.starts_with("s.knead:2: " + c.message)) << c.line << "\ngives: " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
}

TEST(SessionErrors, OfGridsNameTheKeyAndWhatWasExpected) {
  const std::string grid = R"({"tool": "grid", "origin": [0, 0, 0], "spacing": 1, )";
  const std::string zeros = R"("AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA")";  // three numbers
  expect_errors({
      {grid + R"("counts": [1, 1], "coefficients": )" + zeros + "}", R"("counts" must be three whole numbers, got )"},
      {grid + R"("counts": [1, 0, 1], "coefficients": )" + zeros + "}",
       R"("counts" must be three whole numbers of at least 1, of at most 16 million nodes together, got [1, 0, 1])"},
      {grid + R"("counts": [99999999, 99999999, 99999999], "coefficients": )" + zeros + "}",
       R"("counts" must be three whole numbers of at least 1, of at most 16 million)"},
      {grid + R"("counts": [1, 1, 2], "coefficients": )" + zeros + "}",
       R"("coefficients" must hold three numbers for each of the 2 nodes that "counts" gives, got 3)"},
      {grid + R"("counts": [1, 1, 1], "coefficients": ")" + "A*AA" + "\"}", R"("coefficients" is no base64)"},
      {grid + R"("counts": [1, 1, 1], "coefficients": "AAAAAAAA"})",
       R"("coefficients" must hold vectors of three numbers, of 8 bytes each, got 6 bytes)"},
      {grid + R"("counts": [1, 1, 1], "coefficients": 3})",
       R"("coefficients" must be numbers as base64, text in double quotes, got 3)"},
      {grid + R"("counts": [1, 1, 1], "coefficients": "AAAAAAAA+H8AAAAAAAAAAAAAAAAAAAAA"})",
       R"("coefficients" must be three finite numbers, got [nan, 0, 0])"},
      {grid + R"("counts": [1, 1, 1], "coefficients": )" + zeros + R"(, "end_coefficients": "AAAAAAAA"})",
       R"("end_coefficients" must hold vectors)"},
      {R"({"tool": "grid", "origin": [0, 0, 0], "spacing": 0, "counts": [1, 1, 1], "coefficients": )" + zeros + "}",
       R"("spacing" must be a number greater than 0, got 0)"},
  });
}

TEST(SessionErrors, OfMasksNameTheKeyAndWhatWasExpected) {
  expect_errors({
      {R"({"mask": 1})", R"("mask" must be null, or an object {...}, got 1)"},
      {R"({"mask": {}})", R"(a mask has either "points" or "vertices", got neither; {"mask": null} removes it)"},
      {R"({"mask": null, "width": 1})", R"(unknown key "width"; an event has the keys "mask")"},
      {R"({"mask": {"points": [[0, 0, 0]], "vertices": [1], "width": 1}})",
       R"(a mask has either "points" or "vertices", not both)"},
      {R"({"mask": {"points": [[0, 0, 0]]}})", R"("width" is missing; it must be a length greater than 0)"},
      {R"({"mask": {"points": [], "width": 1}})", R"("mask" "points" must be 1 or more points, got an array of 0)"},
      {R"({"mask": {"points": [[0, 0]], "width": 1}})", R"("mask" "points"[0] must be three numbers [x, y, z])"},
      {R"({"mask": {"points": [[0, 0, 0]], "width": 0}})", R"("width" must be a number greater than 0, got 0)"},
      {R"({"mask": {"points": [[0, 0, 0]], "width": 1, "soft": 2}})", R"(unknown key "soft"; "mask" has the keys)"},
      {R"({"mask": {"points": [[0, 0, 0]], "width": 1, "values": [1, 1]}})",
       R"("values" must hold a number for each of the 1 items of "points", got 2)"},
      {R"({"mask": {"points": [[0, 0, 0]], "width": 1, "values": [2]}})",
       R"("values" must hold numbers from 0 (free) to 1 (stays), got 2)"},
      {R"({"mask": {"vertices": [-1], "width": 1}})", R"("mask" "vertices"[0] must be the number of a vertex)"},
      {R"({"mask": {"vertices": [[1, 2, 3]], "width": 1}})",
       R"("mask" "vertices"[0] must be the number of a vertex, or two: [first, last], got an array of 3)"},
      {R"({"mask": {"vertices": [[7, 2]], "width": 1}})",
       R"("vertices" must hold ranges [first, last] with first <= last, got [7, 2])"},
      {R"({"tool": "mask", "width": 1})", R"("tool" must be one of "implicit", )"},
  });
}

TEST(SessionErrors, OfTurnsOfPinsNameTheKeyAndWhatWasExpected) {
  const std::string pins = R"({"tool": "pins", "points": [[0, 0, 0]], "to": [[0, 0, 1]], "radius": 1, "turn": )";
  expect_errors({
      {pins + "1}", R"("turn" must be a list [...], got 1)"},
      {pins + "[1]}", R"("turn"[0] must be)"},
      {pins + R"([{"axis": [0, 0, 1]}]})", R"("turn"[0] "angle_deg" is missing; a turn needs it)"},
      {pins + R"([{"axis": [0, 0, 1], "angle_deg": 1, "rate": 2}]})", R"(unknown key "rate"; a turn has the keys)"},
      {pins + R"([null, null]})", R"("turn" must hold as many rotations or nulls as "points", 1, got 2)"},
      {pins + R"([{"axis": [0, 0, 0], "angle_deg": 1}]})", R"("axis" must be a vector of any length but 0)"},
  });
}

TEST(SessionErrors, OfEventsNameTheKeyAndWhatWasExpected) {
  expect_errors({
      {R"({})", R"(the line is an empty object)"},
      {R"({"stroke": 1})",
       R"(unknown key "stroke"; an event has the keys "tool", "relax", "mask", "undo", "redo", "remesh")"},
      {R"({"undo": 1})", R"("undo" must be a whole number from 1 to the 0 strokes in effect, got 1)"},
      {R"({"redo": 1})", R"("redo" must be a whole number from 1 to the 0 strokes to be redone, got 1)"},
      {R"({"undo": 0})", R"("undo" must be a whole number from 1)"},
      {R"({"undo": -1})", R"("undo" must be a whole number from 1)"},
      {R"({"undo": 0.5})", R"("undo" must be a whole number)"},
      {R"({"undo": true})", R"("undo" must be a whole number, got true)"},
      {R"({"undo": 1e300})", R"("undo" must be a whole number)"},
      {R"({"undo": 1, "redo": 1})", R"(unknown key "redo")"},
      {R"({"tool": 5})", R"("tool" must be text in double quotes, got 5)"},
      {R"({"tool": "nudge"})", R"("tool" must be one of "implicit", "paint", "points")"},
      {R"({"tool": "relax", "points": [[0, 0, 0]], "radius": 1})", R"("tool" must be one of "implicit", "paint",)"},
      {R"({"relax": null})", R"("relax" must be an object {...}, got null)"},
      {R"({"relax": {}})", R"("relax" "points" is missing; "relax" needs it)"},
      {R"({"relax": {"points": [], "radius": 1}})", R"("points")"},
      {R"({"relax": {"points": [[0, 0]], "radius": 1}})", R"("relax" "points"[0] must be)"},
      {R"({"relax": {"points": [[0, 0, 0]]}})", R"("relax" "radius" is missing)"},
      {R"({"relax": {"points": [[0, 0, 0]], "radius": 0}})", R"("radius" must be)"},
      {R"({"relax": {"points": [[0, 0, 0]], "radius": 1, "amount": 0}})", R"("amount" must be greater than 0)"},
      {R"({"relax": {"points": [[0, 0, 0]], "radius": 1, "amount": 1.1}})", R"("amount" must be greater than 0)"},
      {R"({"relax": {"points": [[0, 0, 0]], "radius": 1, "surface": -1}})", R"("surface" must be from 0 to 1)"},
      {R"({"relax": {"points": [[0, 0, 0]], "radius": 1, "iterations": 0}})", R"("iterations" must be from 1 to 100)"},
      {R"({"relax": {"points": [[0, 0, 0]], "radius": 1, "iterations": 1.5}})",
       R"("relax" "iterations" must be a whole)"},
      {R"({"relax": {"points": [[0, 0, 0]], "radius": 1, "tool": "relax"}})", R"(unknown key "tool")"},
      {R"({"relax": {"points": [[0, 0, 0]], "radius": 1}, "undo": 1})", R"(unknown key "undo")"},
      {R"(null)", R"(the line must be a JSON object)"},
      {"\n{\"undo\": 1}", "the line is empty"},
  });
}

TEST(SessionErrors, OfRemeshEventsNameTheKeyAndWhatWasExpected) {
  expect_errors({
      {R"({"remesh": true})", R"("remesh" must be null, or an object {...}, got true)"},
      {R"({"remesh": {"edge": 1}})",
       R"(unknown key "edge"; a remesh event has the keys "max_edge", "max_angle_deg", "max_chord", "min_edge", "iter)"},
      {R"({"remesh": {}, "undo": 1})", R"(unknown key )"},
      {R"({"remesh": {"max_edge": "long"}})", R"("remesh" "max_edge" must be a number, got "long")"},
      {R"({"remesh": {"max_edge": null}})", R"("remesh" "max_edge" must be a number, got null)"},
      {R"({"remesh": {"max_edge": 0}})", R"("remesh" "max_edge" must be )"},
      {R"({"remesh": {"max_edge": -1}})", R"("remesh" "max_edge" must be )"},
      {R"({"remesh": {"max_angle_deg": 181}})", R"("remesh" "max_angle_deg" must be )"},
      {R"({"remesh": {"max_angle_deg": 0}})", R"("remesh" "max_angle_deg" must be )"},
      {R"({"remesh": {"max_chord": 1}})", R"("remesh" "max_chord" must be )"},
      {R"({"remesh": {"max_chord": 0}})", R"("remesh" "max_chord" must be )"},
      {R"({"remesh": {"min_edge": -0.1}})", R"("remesh" "min_edge" must be )"},
      {R"({"remesh": {"iterations": 1.5}})", R"("remesh" "iterations" must be a whole number)"},
      {R"({"remesh": {"iterations": 101}})", R"("remesh" "iterations" must be )"},
      {R"({"remesh": {"iterations": -1}})", R"("remesh" "iterations" must be )"},
  });
}

TEST(SessionErrors, OfStrokesThatReadTheSurface) {
  expect_errors({
      {R"({"tool": "paint", "outer": 1, "depth": 1})", R"("samples" is missing)"},
      {R"({"tool": "paint", "outer": 1, "depth": 1, "path": []})", R"("path" must be 1 or more points)"},
      {R"({"tool": "paint", "outer": 1, "depth": 1, "path": [[0,0,0]], "samples": []})",
       R"(a paint stroke has either "samples" or "path", not both)"},
      {R"({"tool": "handles", "full": [[0,0,0]], "zero": [[1,0,0]]})", R"("motion" is missing)"},
      {R"({"tool": "handles", "zero": [[1,0,0]], "motion": {"translate": [1,0,0]}})",
       R"(a handles stroke has either "full" or "full_vertices", got neither)"},
      {R"({"tool": "handles", "full": [], "zero": [[1,0,0]], "motion": {"translate": [1,0,0]}})",
       R"("full" must hold)"},
      {R"({"tool": "handles", "full_vertices": [], "zero": [[1,0,0]], "motion": {"translate": [1,0,0]}})",
       R"("full_vertices" must be 1 or more vertices)"},
      {R"({"tool": "handles", "full_vertices": [-1], "zero": [[1,0,0]], "motion": {"translate": [1,0,0]}})",
       R"("full_vertices"[0] must be the number of a vertex)"},
      {R"({"tool": "handles", "full": [[0,0,0]], "zero": [[1,0,0]], "motion": {"translate": [1,0,0], "angle_deg": 1}})",
       R"(unknown key "angle_deg"; the motion has the keys "translate")"},
      {R"({"tool": "handles", "full": [[0,0,0]], "zero": [[1,0,0]], "motion": {"rotate": [0,0,1], "center": [0,0,0]}})",
       R"("motion" "angle_deg" is missing)"},
      {R"({"tool": "stamp", "mesh": "a.ply"})", R"("path" is missing)"},
      {R"({"tool": "stamp", "path": [[0,0,0], [1,0,0]]})", R"("mesh" is missing)"},
      {R"({"tool": "stamp", "mesh": "a.ply", "path": [[0,0,0], [1,0,0]], "pose": [[1,0,0]]})",
       R"("pose" must be a 3x3 matrix)"},
      {R"({"tool": "twist", "center": [0,0,0], "axis": [0,0,1], "rate_deg": 1, "inner": 0, "outer": 1, "radius": "all"})",
       R"("radius" must be a number, or "auto", got "all")"},
  });
}

TEST(SessionErrors, OfOtherTextSayWhatItIs) {
  EXPECT_EQ(error_of("{\n  \"knead\": 1\n}\n"), "s.knead:1: the object goes on in line 2; write each on one line");
  EXPECT_EQ(error_of("{\"knead\": 1}\n{\"tool\": \"rotate\",\n \"inner\": 1}\n"),
            "s.knead:2: the object goes on in line 3; write each on one line");
  EXPECT_EQ(error_of("{\"knead\": 1}\n{\"relax\": {\"points\": [[0, 0,\n{\"undo\": 1}\n"),
            "s.knead:2: the JSON object of this line is incomplete; complete it or remove the line");
  EXPECT_EQ(error_of(std::string("\xff\xfe{\0", 4)), "s.knead:1: is UTF-16 text; convert it to UTF-8");
  EXPECT_NE(error_of("version https://git-lfs.github.com/spec/v1\noid 0\n").find("pointer of Git LFS"),
            std::string::npos);
  EXPECT_NE(error_of("<!DOCTYPE html>\n<html>\n").find("is a web page"), std::string::npos);
}

TEST(SessionErrors, OfJsonNameColumnAndKey) {
  for (const char* path : {R"(C:\scans\a.ply)", R"(C:\users\a.ply)", R"(\\server\x)"}) {
    EXPECT_NE(error_of("{\"knead\": 1, \"mesh\": \"" + std::string(path) + "\"}\n")
                  .find("at \"mesh\", a backslash in a text begins no escape"),
              std::string::npos)
        << path;
  }
  expect_errors({
      {R"({"undo": 1)", "the JSON object of this line is incomplete"},
      {R"({"undo" 1})", "at \"undo\", column 9 is not JSON"},
      {R"({"undo": 1} x)", "at \"undo\", column 13 is not JSON"},
      {R"({"undo": 1, "undo": 1})", R"(the key "undo" is given twice)"},
      {R"({"tool": "rotate", "angle_deg": 1e999})", R"(at "angle_deg", a number is too large)"},
      {R"({"tool": "rotate", "angle_deg": NaN})", R"(at "angle_deg", column 33 is not JSON)"},
      {R"({"tool": "rotate", "angle_deg": -Infinity})", R"(at "angle_deg", column 34 is not JSON)"},
      {"{\"tool\": \"\xFF\"}", "at \"tool\", column 11 is not JSON"},
      {R"({"tool": "paint", "outer": 1, "depth": 1, "samples": [{"point": [0,0,0], "point": [0,0,0]}]})",
       R"(the key "point" is given twice)"},
  });
}

TEST(SessionErrors, OfStrokesNameTheKeyAndWhatWasExpected) {
  const std::string rotate = R"({"tool": "rotate", "center": [0,0,0], "axis": [0,0,1], "angle_deg": 1, )";
  const std::string bend = R"({"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [1,0,0], "angle_deg": 1)";
  const std::string implicit = R"({"tool": "implicit", "inner": 0.1, "outer": 0.5, )";
  expect_errors({
      {rotate + R"("inner": 0.6, "outer": 0.2})", R"("outer" must be a number greater than "inner" (0.6), got 0.2)"},
      {rotate + R"("inner": -2, "outer": 0})", R"("outer" must be a number greater than 0, got 0)"},
      {rotate + R"("inner": 0.1})", R"("outer" is missing; tool "rotate" needs it)"},
      {rotate + R"("inner": 0.1, "outer": "1"})", R"("outer" must be a number, without quotes, got "1")"},
      {rotate + R"("inner": 0.1, "outer": 1, "gage": 1})",
       R"(unknown key "gage"; tool "rotate" has the keys "tool", )"},
      {R"({"tool": "rotate", "center": [0,0], "axis": [0,0,1], "angle_deg": 1, "inner": 0.1, "outer": 1})",
       R"("center" must be three numbers [x, y, z], got an array of 2)"},
      {R"({"tool": "rotate", "center": [0,0,"0"], "axis": [0,0,1], "angle_deg": 1, "inner": 0.1, "outer": 1})",
       R"("center"[2] must be a number, without quotes, got "0")"},
      {rotate + R"("inner": 0.1, "outer": 1, "duration": 0})", R"("duration" must be a number above 0, at most 1e9)"},
      {rotate + R"("inner": 0.1, "outer": 1, "duration": 1e308})",
       R"("duration" must be a number above 0, at most 1e9)"},
      {R"({"tool": "rotate", "center": [0,0,0], "axis": [0,0,0], "angle_deg": 1, "inner": 0.1, "outer": 1})",
       R"("axis" must be a vector of any length but 0)"},
      {implicit + R"("path": [[0,0,0]]})", R"("path" must hold 2 or more points, got 1)"},
      {implicit + R"("path": [[0,0,0], [0,1]]})", R"("path"[1] must be three numbers)"},
      {implicit + R"("path": 1})", R"("path" must be a list)"},
      {implicit + R"("path": [[0,0,0], [0,0,1]], "half_axis": [0,0,1]})", R"("half_axis" needs "region": "capsule")"},
      {implicit + R"("path": [[0,0,0], [0,0,1]], "region": "box"})",
       R"("region" must be one of "ball", "capsule", got "box")"},
      {implicit + R"("path": [[0,0,0], [0,0,1]], "region": "capsule"})", R"("half_axis" is missing)"},
      {implicit + R"("path": [[0,0,0], [0,0,1]], "time": 1})", R"("time" must be one of "swept", "blended", got 1)"},
      {R"({"tool": "paint", "outer": 1, "depth": 1})", R"("samples" is missing)"},
      {R"({"tool": "paint", "outer": 1, "depth": 1, "samples": [{"point": [0,0,0]}]})",
       R"("samples"[0] "normal" is missing)"},
      {R"({"tool": "paint", "outer": 1, "depth": 1, "samples": [[0,0,0]]})", R"("samples"[0] must be a JSON object)"},
      {R"({"tool": "paint", "outer": 1, "depth": 1, "samples": [], "path": []})",
       R"(a paint stroke has either "samples" or "path")"},
      {R"({"tool": "points", "outer": 1, "displacements": [[0,0,1]]})", R"("points" or "curves" is missing)"},
      {R"({"tool": "points", "points": [[0,0,0]], "outer": 1, "displacements": [[0,0,1]], "exponent": 7})",
       R"("exponent" must be an even number, 2 or more, got 7)"},
      {R"({"tool": "points", "points": [[0,0,0]], "outer": 1, "displacements": [[0,0,1]], "exponent": 1e12})",
       R"("exponent" must be a whole number)"},
      {bend + "}", R"(a bend has either "width" (and "center_fraction") or "inner" and "outer", got neither)"},
      {bend + R"(, "width": 1, "inner": 0})",
       R"(a bend has either "width" (and "center_fraction") or "inner" and "outer", not)"},
      {bend + R"(, "center_fraction": 0.5})", R"("width" is missing)"},
      {bend + R"(, "inner": 1})", R"("outer" is missing)"},
      {R"({"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [0,2,0], "angle_deg": 1, "width": 1})",
       R"("normal" must not be parallel to "axis")"},
  });
}

TEST(SessionErrors, OfUndoneStrokesCountToo) {
  const std::string stroke = stroke_line(RotateStroke{{}, {0, 0, 1}, 10, 1, 2});
  const std::string text = "{\"knead\": 1}\n" + stroke + "\n{\"undo\": 1}\n" + stroke + "\n{\"redo\": 1}\n";
  EXPECT_TRUE(error_of(text).starts_with("s.knead:5: \"redo\" must be")) << error_of(text);
}

// Only what could be the beginning of a line is taken for a line cut off.
TEST(SessionErrors, OfALastLineThatIsNoJsonAreNotForgiven) {
  EXPECT_TRUE(error_of("{\"knead\": 1}\n{undo: 1}").starts_with("s.knead:2: column 2 is not JSON"));
}

TEST(SessionErrors, ALineWithoutEndIsRefusedAtOnce) {
  try {
    parse_session("{\"knead\": 1}\n{\"tool\": \"" + std::string(20'000'000, 'x'), "long.knead");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 42), "long.knead:2: the line has 20000010 bytes,");
  }
}

}  // namespace
}  // namespace knead::session_errors_test
