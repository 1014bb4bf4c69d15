#include "knead/gpu/glsl.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>

#include "knead/flow/pins.h"
#include "knead/flow/step_rule.h"

namespace knead::gpu {

namespace {

std::string literal(double value) { return fmt::format("R({:.17e}lf)", value); }

// The sum of the slopes k0, k1... by their weights.
template <std::size_t N>
std::string weighted(const std::array<double, N>& weights, int count) {
  std::string text;
  for (int j = 0; j < count; ++j) {
    const double weight = weights[static_cast<std::size_t>(j)];
    if (weight != 0) text += fmt::format("{}k{} * {}", text.empty() ? "" : " + ", j, literal(weight));
  }
  return text.empty() ? "R3(0)" : text;
}

// One step of the method, from a point `at` that moves with k0: the mean slope, its estimated error, the last slope.
std::string step_source(const Tableau& method) {
  std::string text = "void try_step(R3 at, R3 k0, R t, R h, out R3 slope, out R3 estimate, out R3 last) {\n";
  for (int i = 1; i < method.stages; ++i) {
    const auto row = static_cast<std::size_t>(i);
    text += fmt::format("  R3 k{} = velocity_at(at + ({}) * h, t + {} * h);\n", i, weighted(method.a[row], i),
                        literal(method.c[row]));
  }
  text += fmt::format("  slope = {};\n  estimate = {};\n  last = k{};\n}}\n", weighted(method.b, method.stages),
                      weighted(method.e, method.stages), method.stages - 1);
  return text;
}

// The same as a loop, for compilers that take long: the slopes are kept in memory, though.
std::string looped_step_source(const Tableau& method) {
  std::string weights;
  std::string times;
  for (int i = 0; i < method.stages + 2; ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (std::size_t j = 0; j < static_cast<std::size_t>(method.stages); ++j) {
      const double weight = i < method.stages ? method.a[row][j] : (i == method.stages ? method.b[j] : method.e[j]);
      weights += (weights.empty() ? "" : ", ") + literal(weight);
    }
    if (i < method.stages) times += (times.empty() ? "" : ", ") + literal(method.c[row]);
  }
  return fmt::format("const int kStages = {};\nconst R kWeights[] = R[]({});\nconst R kTimes[] = R[]({});\n",
                     method.stages, weights, times) +
         R"(
R3 weighted(R3 k[kStages], int row, int count) {
  R3 sum = R3(0);
  for (int j = 0; j < count; ++j) sum += k[j] * kWeights[row * kStages + j];
  return sum;
}

void try_step(R3 at, R3 k0, R t, R h, out R3 slope, out R3 estimate, out R3 last) {
  R3 k[kStages];
  k[0] = k0;
  for (int i = 1; i < kStages; ++i) k[i] = velocity_at(at + weighted(k, i, i) * h, t + kTimes[i] * h);
  slope = weighted(k, kStages, kStages);
  estimate = weighted(k, kStages + 1, kStages);
  last = k[kStages - 1];
}
)";
}

std::string define(const char* name, int value) { return fmt::format("#define {} {}\n", name, value); }

std::string layout_defines() {
  using namespace layout;
  const std::pair<const char*, int> names[] = {{"kOuter", kOuter},
                                               {"kInner", kInner},
                                               {"kInverseWidth", kInverseWidth},
                                               {"kMotion", kMotion},
                                               {"kRegion", kRegion},
                                               {"kFalloff", kFalloff},
                                               {"kFieldBegin", kFieldBegin},
                                               {"kMotionKind", kMotionKind},
                                               {"kRegionKind", kRegionKind},
                                               {"kBounds", kBounds},
                                               {"kFirstSet", kFirstSet},
                                               {"kSecondSet", kSecondSet},
                                               {"kFieldEntries", kFieldEntries},
                                               {"kNodeNumbers", kNodeNumbers},
                                               {"kNodeEntries", kNodeEntries},
                                               {"kSegmentEntries", kSegmentEntries},
                                               {"kCarries", kCarries},
                                               {"kHasBarrel", kHasBarrel},
                                               {"kClosedForm", kClosedForm},
                                               {"kReach", kReach},
                                               {"kTolerance", kTolerance},
                                               {"kLeast", kLeast},
                                               {"kStrain", layout::kStrain},
                                               {"kPerRadius", kPerRadius},
                                               {"kMiddle", kMiddle},
                                               {"kPerHalf", kPerHalf},
                                               {"kPowers", kPowers},
                                               {"kDegree", kDegree},
                                               {"kFirstTurn", kFirstTurn},
                                               {"kTurns", kTurns},
                                               {"kPerSpacing", kPerSpacing},
                                               {"kEndOfTime", kEndOfTime},
                                               {"kRow", kRow},
                                               {"kPlane", kPlane},
                                               {"kFirstNode", kFirstNode},
                                               {"kFirstCell", kFirstCell},
                                               {"kLastCell", kLastCell},
                                               {"kEndNumbers", kEndNumbers},
                                               {"kUsed", kUsed},
                                               {"kMostPinDegree", detail::kMostPinDegree},
                                               {"kSegmentPlaces", kSegmentPlaces},
                                               {"kCountStripes", kCountStripes},
                                               {"kCounters", kCounters},
                                               {"kTranslation", kTranslation},
                                               {"kRotation", kRotation},
                                               {"kTwist", kTwist},
                                               {"kStrainMotion", kStrainMotion},
                                               {"kBall", kBall},
                                               {"kCapsule", kCapsule},
                                               {"kHalfSpace", kHalfSpace},
                                               {"kSet", kSet},
                                               {"kHandles", kHandles},
                                               {"kRigidCore", kRigidCore},
                                               {"kTurningBall", kTurningBall},
                                               {"kParallelTwist", kParallelTwist},
                                               {"kTurningSpace", kTurningSpace},
                                               {"kStretchedCore", kStretchedCore},
                                               {"kHandlesPoint", kHandlesPoint}};
  std::string text;
  for (const auto& [name, value] : names) text += define(name, value);
  return text;
}

// A function of the field that is a constant where there is but one kind.
std::string kind_function(const char* name, const char* entry, unsigned kinds) {
  for (int kind = 0; kind < 8; ++kind) {
    if (kinds == 1U << kind) return fmt::format("int {}(int f) {{ return {}; }}\n", name, kind);
  }
  return fmt::format("int {}(int f) {{ return table[field_table(f) + {}]; }}\n", name, entry);
}

std::string kind_defines(const ShaderKind& kind) {
  constexpr std::array motions{"MOTION_TRANSLATION", "MOTION_ROTATION", "MOTION_TWIST", "MOTION_STRAIN"};
  constexpr std::array regions{"REGION_BALL", "REGION_CAPSULE", "REGION_HALF_SPACE", "REGION_SET", "REGION_HANDLES"};
  std::string text;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if ((kind.motions >> i & 1U) != 0) text += fmt::format("#define {}\n", motions[i]);
  }
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if ((kind.regions >> i & 1U) != 0) text += fmt::format("#define {}\n", regions[i]);
  }
  if (kind.curves) text += "#define WITH_CURVES\n";
  if (kind.trees) text += "#define WITH_TREES\n";
  if (kind.blended) text += "#define BLENDED\n";
  if (kind.turns) text += "#define WITH_TURNS\n";
  if (kind.grid) text += "#define WITH_GRID\n";
  if (kind.grid_changes) text += "#define GRID_CHANGES\n";
  if (kind.barrel) text += "#define WITH_BARREL\n";
  if (kind.falloff) text += "#define FALLOFF\n";
  if (kind.single) text += "#define SINGLE_FIELD\n";
  text += kind.single ? "#define FIELD_COUNT(count) 1\n" : "#define FIELD_COUNT(count) (count)\n";
  if (kind.in_double) text += "#define IN_DOUBLE\n";
  text += kind.in_double ? "#define R double\n#define R2 dvec2\n#define R3 dvec3\n#define R4 dvec4\n"
                         : "#define R float\n#define R2 vec2\n#define R3 vec3\n#define R4 vec4\n";
  return text;
}

// How much of a region's width a step may pass at most, over the regions of a kind, or of a grid's spacing.
double greatest_reach(const ShaderKind& kind) {
  if (kind.grid) return detail::kGridReach;
  if ((kind.regions >> kHandles & 1U) != 0) return detail::kHandlesReach;
  return kind.regions == 1U << kCapsule ? detail::kCapsuleReach : detail::kReach;
}

// The rule of the steps and its numbers, as step_rule.h has them.
std::string step_rule(const ShaderKind& kind) {
  std::string text = "#define STEP_RULE\n";
  for (const detail::StepConstant& constant : detail::kStepConstants) {
    text += fmt::format("const double {} = {:.17e}lf;\n", constant.name, constant.value);
  }
  const double reach = greatest_reach(kind);
  text += fmt::format("const R kShortestPart = {};\nconst R kExpectedError = {};\nconst uint kStepLimit = {}u;\n",
                      literal(kind.in_double ? detail::kShortestPart<double> : detail::kShortestPart<float>),
                      literal(detail::kExpectedThirdOrderError * reach * reach * reach), detail::kStepLimit);
  return text +
         "R minimum(R a, R b) { return b < a ? b : a; }\n"
         "R maximum(R a, R b) { return a < b ? b : a; }\n" +
         detail::step_rule::kStepRuleText + "\n";
}

std::string method_defines(const ShaderKind& kind) {
  const Tableau& method = tableau(kind.integrator);
  return fmt::format(
      "const int kErrorOrder = {};\nconst bool kExtrapolates = {};\nconst bool kFirstSameAsLast = {};\nconst R "
      "kEpsilon = {};\n",
      method.error_order, method.order > method.error_order, method.first_same_as_last,
      literal(kind.in_double ? 0x1p-52 : 0x1p-23));
}

constexpr const char* kInterface = R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) restrict buffer Points { double points[]; };
layout(std430, binding = 1) restrict buffer Steps { uint steps[]; };
layout(std430, binding = 2) restrict readonly buffer Bounds { double bounds[]; };
layout(std430, binding = 3) restrict buffer Radii { uint radii[]; };
layout(std430, binding = 4) restrict readonly buffer Numbers { R n[]; };
layout(std430, binding = 5) restrict readonly buffer Places { double e[]; };
layout(std430, binding = 6) restrict readonly buffer Table { int table[]; };
layout(std430, binding = 7) restrict buffer Counts { uint counts[]; };
uniform uint point_count;
uniform int segment_count;

const R kNever = R(1e30);

// The segment.
int field_count;
int first_field;
int closed_form;
int segment_numbers;
bool carries;
R3 displacement;
R3 tool_velocity;
R tool_speed;
R tolerance;
dvec3 centre;
dvec3 exact_displacement;

// The path line.
uint accepted = 0u;
uint rejected = 0u;
uint evaluations = 0u;
bool complete = true;

int field_table(int f) { return first_field + f * kFieldEntries; }
int field_numbers(int f) { return table[field_table(f) + kFieldBegin]; }
R3 part(int i) { return R3(n[i], n[i + 1], n[i + 2]); }
)";

std::string fields_source(const ShaderKind& kind) {
  if (kind.pins) return kGlslPins;
  if (kind.grid) return kGlslGrid;
  return kind_function("motion_kind", "kMotionKind", kind.motions) +
         kind_function("region_kind", "kRegionKind", kind.regions) + kGlslField + kGlslPowers + kGlslTrees + kGlslSets +
         kGlslVelocity + kGlslContact + kGlslClosedForm;
}

}  // namespace

std::string shader_source(const ShaderKind& kind) {
  const std::string fields = fields_source(kind);
  return "#version 430 core\n" + layout_defines() + kind_defines(kind) + method_defines(kind) + step_rule(kind) +
         kInterface + kGlslSphereContact + fields +
         (kind.unrolled ? step_source(tableau(kind.integrator)) : looped_step_source(tableau(kind.integrator))) +
         kGlslPath;
}

}  // namespace knead::gpu
