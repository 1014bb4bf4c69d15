// Numbers in text.
#include "io/text.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

namespace knead::detail::text_test {
namespace {

TEST(ParseReal, Table) {
  const auto parse = [](std::string_view token) {
    double value = -77;
    const ParseResult result = parse_real(token, value);
    return result == ParseResult::ok ? value : (result == ParseResult::overflow ? HUGE_VAL : -77);
  };
  EXPECT_EQ(parse("1"), 1);
  EXPECT_EQ(parse("+2.5"), 2.5);
  EXPECT_EQ(parse("-.5e1"), -5);
  EXPECT_EQ(parse("5."), 5);
  EXPECT_EQ(parse("1E+3"), 1000);
  EXPECT_EQ(parse("1e-999"), 0);
  EXPECT_EQ(parse("-1e-999"), 0);
  EXPECT_EQ(parse("0e999"), 0);
  EXPECT_EQ(parse("1e999"), HUGE_VAL);
  EXPECT_EQ(parse("1" + std::string(400, '0')), HUGE_VAL);
  EXPECT_EQ(parse("0." + std::string(400, '0') + "1"), 0);
  EXPECT_EQ(parse("1" + std::string(400, '0') + "e-400"), 1);
  EXPECT_EQ(parse("1e99999999999999999999999999"), HUGE_VAL);
  EXPECT_EQ(parse("1e-99999999999999999999999999"), 0);
  EXPECT_EQ(parse("1" + std::string(320, '0') + "e-5"), HUGE_VAL);
  for (const char* bad : {"", "+", "-", ".", "e5", "1,5", "1.2.3", "0x10", "1e", "--1", "+-1", "one", "1 "}) {
    EXPECT_EQ(parse(bad), -77) << bad;
  }
  EXPECT_TRUE(std::isnan(parse("nan")));
  for (const char* special : {"-1.#IND", "1.#QNAN", "1.#INF00", "-1.#IND0000", "-nan(ind)", "nan(snan)"})
    EXPECT_TRUE(std::isnan(parse(special)));
  for (const char* bad : {"1.#", "1.#IN", "2.#INF", "1.#INF0x"}) EXPECT_EQ(parse(bad), -77) << bad;
  float single = 0;
  EXPECT_EQ(parse_real("1e39", single), ParseResult::overflow);
  EXPECT_EQ(parse_real("1e-60", single), ParseResult::ok);
  EXPECT_EQ(single, 0);
}

TEST(AppendReal, ReadsBackAsTheSameBits) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    const auto value = std::bit_cast<double>(bits);
    const auto single = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    std::string text;
    double back = 0;
    float single_back = 0;
    if (std::isfinite(value)) {
      append_real(text, value);
      ASSERT_EQ(parse_real(text, back), ParseResult::ok);
      EXPECT_EQ(std::bit_cast<std::uint64_t>(back), bits) << text;
    }
    text.clear();
    if (std::isfinite(single)) {
      append_real(text, single);
      ASSERT_EQ(parse_real(text, single_back), ParseResult::ok);
      EXPECT_EQ(std::bit_cast<std::uint32_t>(single_back), std::bit_cast<std::uint32_t>(single)) << text;
    }
  }
  std::string text;
  append_real(text, 0.1f);
  EXPECT_EQ(text, "0.1");
}

TEST(LineOf, CountsEveryKindOfLineEnd) {
  const std::string text = "a\nb\r\nc\rd";
  EXPECT_EQ(line_of(text, 0), 1u);
  EXPECT_EQ(line_of(text, 2), 2u);
  EXPECT_EQ(line_of(text, 5), 3u);
  EXPECT_EQ(line_of(text, 7), 4u);
  EXPECT_EQ(line_of(text, 700), 4u);
}

TEST(InQuotes, IsShortAndPrintable) {
  EXPECT_EQ(in_quotes("a\x1b[2J"), "'a?[2J'");
  EXPECT_EQ(in_quotes(std::string(100, 'x')), "'" + std::string(40, 'x') + "...'");
}

}  // namespace
}  // namespace knead::detail::text_test
