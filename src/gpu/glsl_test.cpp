// The shaders' source has the step rule and its constants.
#include "gpu/glsl.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>
#include <set>
#include <string>

#include "flow/step_rule.h"

namespace knead::gpu::glsl_test {
namespace {

using detail::step_rule::kStepRuleText;

std::string source_of_a_ball() {
  ShaderKind kind;
  kind.motions = 1U << kTranslation;
  kind.regions = 1U << kBall;
  kind.single = true;
  return shader_source(kind);
}

// The numbers that stand in a text, but for those within names.
std::set<std::string> numbers_in(const std::string& text) {
  const std::regex number(R"((^|[^A-Za-z_0-9.])([0-9]+(\.[0-9]*)?(e-?[0-9]+)?))");
  std::set<std::string> result;
  for (std::sregex_iterator i(text.begin(), text.end(), number), end; i != end; ++i) result.insert((*i)[2]);
  return result;
}

TEST(Glsl, HasTheStepRuleAndItsConstantsFromTheFlowRoom) {
  const std::string source = source_of_a_ball();
  EXPECT_NE(source.find(kStepRuleText), std::string::npos);
  for (const detail::StepConstant& constant : detail::kStepConstants) {
    const std::string definition = std::string("const double ") + constant.name + " = ";
    const std::size_t at = source.find(definition);
    ASSERT_NE(at, std::string::npos) << constant.name;
    EXPECT_EQ(std::strtod(source.c_str() + at + definition.size(), nullptr), constant.value) << constant.name;
  }
}

// What is written out here are orders, and the coefficients of the methods that are tried on a whole segment.
TEST(Glsl, HasNoNumberOfTheStepRuleOfItsOwn) {
  const std::string path = kGlslPath;
  const std::size_t end = path.find("// The motion of the point that is at x");
  ASSERT_NE(end, std::string::npos);
  EXPECT_EQ(numbers_in(path.substr(0, end)), (std::set<std::string>{"0", "0.25", "0.5", "1", "2.0", "3.0"}));
  EXPECT_EQ(numbers_in(kStepRuleText), (std::set<std::string>{"1", "2"}));
}

}  // namespace
}  // namespace knead::gpu::glsl_test
