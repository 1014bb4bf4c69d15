// What JSON is read and refused, and how it is written.
#include "json/json.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "knead/vec.h"

namespace knead::json_test {
namespace {

using Kind = JsonError::Kind;

JsonError error_of(std::string_view text) {
  try {
    parse_json(text);
  } catch (const JsonError& error) {
    return error;
  }
  ADD_FAILURE() << text << " was read";
  return {Kind::not_json, 0, std::nullopt};
}

TEST(Json, ReadsEveryKindOfValue) {
  const Json json = parse_json(R"({"a": [1, -2, 1.5, 1e3], "b": {"c": null}, "d": "\u00e9", "e": true})");
  ASSERT_TRUE(json.is_object());
  const std::vector<Json>& numbers = json.at("a").items();
  EXPECT_TRUE(numbers[0].is_whole());
  EXPECT_EQ(numbers[0].whole(), 1u);
  EXPECT_FALSE(numbers[1].is_whole());
  EXPECT_EQ(numbers[1].number(), -2);
  EXPECT_EQ(numbers[2].number(), 1.5);
  EXPECT_FALSE(numbers[3].is_whole());
  EXPECT_TRUE(json.at("b").at("c").is_null());
  EXPECT_EQ(json.at("d").text(), "\xc3\xa9");
  EXPECT_TRUE(json.at("e").flag());
  EXPECT_EQ(json.find("f"), nullptr);
  EXPECT_EQ(numbers[0].find("f"), nullptr);
}

TEST(Json, RefusesValuesOfAnotherKind) {
  const Json json = parse_json("[1]");
  EXPECT_THROW(json.text(), InvalidInput);
  EXPECT_THROW(json.flag(), InvalidInput);
  EXPECT_THROW(json.number(), InvalidInput);
  EXPECT_THROW(json.members(), InvalidInput);
  EXPECT_THROW(json.at("a"), InvalidInput);
  EXPECT_THROW(json.items()[0].items(), InvalidInput);
  EXPECT_THROW(Json(-1).whole(), InvalidInput);
}

TEST(Json, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(error_of(R"({"a": tru})").kind(), Kind::not_json);
  EXPECT_EQ(error_of(R"({"a": tru})").byte(), 10u);
  EXPECT_EQ(error_of(R"({"a": tru})").key(), "a");
  EXPECT_EQ(error_of(R"({"a": 1)").kind(), Kind::incomplete);
  EXPECT_EQ(error_of("").kind(), Kind::incomplete);
  EXPECT_EQ(error_of("1 2").kind(), Kind::not_json);
  EXPECT_EQ(error_of("[1e999]").kind(), Kind::too_large);
  EXPECT_EQ(error_of(R"({"a": 1, "b": 2, "a": 3})").kind(), Kind::repeated_key);
  EXPECT_EQ(error_of(R"({"a": 1, "b": 2, "a": 3})").key(), "a");
  EXPECT_EQ(error_of("\"\xff\"").kind(), Kind::not_json);
}

TEST(Json, BoundsTheDepth) {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_TRUE(parse_json(nested(kDeepestJson)).is_array());
  EXPECT_EQ(error_of(nested(kDeepestJson + 1)).kind(), Kind::too_deep);
  EXPECT_EQ(error_of(std::string(1000000, '[')).kind(), Kind::too_deep);
}

TEST(Json, FilesWrittenByHandMayHaveCommentsAndRepeatedKeys) {
  const std::string text = R"(// mine
      {"a": 1, /* twice */ "b": 2, "a": 3})";
  const Json json = parse_json(text, JsonDialect::by_hand);
  EXPECT_EQ(to_text(json), R"({"a":3,"b":2})");
  EXPECT_THROW(parse_json(text), JsonError);
}

TEST(Json, WritesWhatTheLibraryBeneathWrites) {
  using Other = nlohmann::ordered_json;
  const Json json{{"numbers", std::vector<double>{0.1, 1.0, -0.0, 1e300, 5e-324}},
                  {"whole", std::vector<Json>{0, -7, std::numeric_limits<std::uint64_t>::max()}},
                  {"not_finite", kInfinity},
                  {"nothing", std::optional<double>()},
                  {"text", "quote \" tab \t \xc3\xa9 broken \xff"},
                  {"empty", std::vector<Json>{Json::array(), Json::object()}}};
  const Other other{{"numbers", {0.1, 1.0, -0.0, 1e300, 5e-324}},
                    {"whole", {0, -7, std::numeric_limits<std::uint64_t>::max()}},
                    {"not_finite", kInfinity},
                    {"nothing", nullptr},
                    {"text", "quote \" tab \t \xc3\xa9 broken \xff"},
                    {"empty", {Other::array(), Other::object()}}};
  for (const int indent : {-1, 0, 2}) {
    for (const bool ascii : {false, true}) {
      EXPECT_EQ(to_text(json, {indent, ascii}), other.dump(indent, ' ', ascii, Other::error_handler_t::replace));
    }
  }
  EXPECT_EQ(to_text(parse_json(to_text(json))), to_text(json));
}

TEST(Json, CopiesDoNotChangeWithTheirOriginal) {
  Json json{{"a", 1}};
  const Json before = json;
  json.set("a", 2);
  json.set("b", 3);
  EXPECT_EQ(to_text(before), R"({"a":1})");
  EXPECT_EQ(to_text(json), R"({"a":2,"b":3})");
  Json list = Json::array();
  list.push_back(list);
  list.push_back(list);
  EXPECT_EQ(to_text(list), "[[],[[]]]");
}

TEST(Json, FindsEachOfManyMembers) {
  Json built;
  std::string text;
  for (int i = 0; i < 1000; ++i) {
    const std::string key = std::to_string(i * 7919 % 1000);
    built.set(key, i);
    text += (text.empty() ? "{\"" : ",\"") + key + "\":" + std::to_string(i);
  }
  text += "}";
  EXPECT_EQ(to_text(built), text);
  const Json read = parse_json(text);
  for (int i = 0; i < 1000; ++i) {
    const std::string key = std::to_string(i * 7919 % 1000);
    EXPECT_EQ(read.at(key).number(), i);
    EXPECT_EQ(built.at(key).number(), i);
  }
  EXPECT_FALSE(read.has("x"));
}

}  // namespace
}  // namespace knead::json_test
