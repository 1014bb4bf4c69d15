// Composes the shaders of segments: definitions, the step rule, the method; and contacts and grids in GLSL.
#include "gpu/glsl.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>

#include "flow/pins.h"
#include "flow/step_rule.h"

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
// The loop over the stages stays a loop, so that v is compiled once; the slopes stay in registers, because none is
// indexed. Slopes of later stages have weight 0.
std::string step_source(const Tableau& method) {
  std::string weights;
  std::string times;
  std::string slopes;
  std::string sum;
  std::string keep;
  for (int i = 0; i < method.stages; ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (int j = 0; j < method.stages; ++j) {
      weights += (weights.empty() ? "" : ", ") + literal(method.a[row][static_cast<std::size_t>(j)]);
    }
    times += (i == 0 ? "" : ", ") + literal(method.c[row]);
    sum += fmt::format("{}k{} * kWeights[row + {}]", i == 0 ? "" : " + ", i, i);
    if (i == 0) continue;
    slopes += fmt::format("  R3 k{} = R3(0);\n", i);
    keep += fmt::format("    k{0} = i == {0} ? k : k{0};\n", i);
  }
  return fmt::format(R"(
const int kStages = {};
const R kWeights[] = R[]({});
const R kTimes[] = R[]({});

void try_step(R3 at, R3 k0, R t, R h, out R3 slope, out R3 estimate, out R3 last) {{
{}  for (int i = 1; i < kStages - 4 + four; ++i) {{
    int row = i * kStages;
    R3 k = velocity_at(at + ({}) * h, t + kTimes[i] * h);
{}  }}
  slope = {};
  estimate = {};
  last = k{};
}}
)",
                     method.stages, weights, times, slopes, sum, keep, weighted(method.b, method.stages),
                     weighted(method.e, method.stages), method.stages - 1);
}

std::string define(const char* name, int value) { return fmt::format("#define {} {}\n", name, value); }

namespace layout_names {

using namespace layout;

constexpr std::pair<const char*, int> kNames[] = {{"kOuter", kOuter},
                                                  {"kInner", kInner},
                                                  {"kInverseWidth", kInverseWidth},
                                                  {"kMotion", kMotion},
                                                  {"kRegion", kRegion},
                                                  {"kFalloff", kFalloff},
                                                  {"kPerBump", kPerBump},
                                                  {"kWideFalloff", kWideFalloff},
                                                  {"kFieldBegin", kFieldBegin},
                                                  {"kMotionKind", kMotionKind},
                                                  {"kRegionKind", kRegionKind},
                                                  {"kBounds", kBounds},
                                                  {"kFirstSet", kFirstSet},
                                                  {"kFieldNumbers", kFieldNumbers},
                                                  {"kFieldEntries", kFieldEntries},
                                                  {"kNodeNumbers", kNodeNumbers},
                                                  {"kNodeEntries", kNodeEntries},
                                                  {"kSegmentEntries", kSegmentEntries},
                                                  {"kCarries", kCarries},
                                                  {"kHasCylinder", kHasCylinder},
                                                  {"kClosedForm", kClosedForm},
                                                  {"kReach", kReach},
                                                  {"kTolerance", kTolerance},
                                                  {"kMin", kMin},
                                                  {"kStrain", layout::kStrain},
                                                  {"kPerRadius", kPerRadius},
                                                  {"kMiddle", kMiddle},
                                                  {"kPerHalf", kPerHalf},
                                                  {"kPowers", kPowers},
                                                  {"kDegree", kDegree},
                                                  {"kFirstTurn", kFirstTurn},
                                                  {"kTurns", kTurns},
                                                  {"kBegin", kBegin},
                                                  {"kEnd", kEnd},
                                                  {"kRow", kRow},
                                                  {"kPlane", kPlane},
                                                  {"kFirstNode", kFirstNode},
                                                  {"kFirstCell", kFirstCell},
                                                  {"kLastCell", kLastCell},
                                                  {"kEndNumbers", kEndNumbers},
                                                  {"kUsed", kUsed},
                                                  {"kMaxPinDegree", detail::kMaxPinDegree},
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
                                                  {"kTurningBall", kTurningBall},
                                                  {"kParallelTwist", kParallelTwist},
                                                  {"kTurningSpace", kTurningSpace},
                                                  {"kStretchedCore", kStretchedCore}};

}  // namespace layout_names

std::string layout_defines() {
  std::string text;
  for (const auto& [name, value] : layout_names::kNames) text += define(name, value);
  return text;
}

// A function of the field that is a constant if there is only one kind.
std::string kind_function(const char* name, const char* entry, unsigned kinds) {
  for (int kind = 0; kind < 8; ++kind) {
    if (kinds == 1U << kind) return fmt::format("int {}(int f) {{ return {}; }}\n", name, kind);
  }
  return fmt::format("int {}(int f) {{ return table[field_table(f) + {}]; }}\n", name, entry);
}

std::string kind_defines(const ShaderKind& kind) {
  constexpr std::array motions{"MOTION_TRANSLATION", "MOTION_ROTATION", "MOTION_TWIST", "MOTION_STRAIN"};
  constexpr std::array regions{"REGION_BALL", "REGION_CAPSULE", "REGION_HALF_SPACE", "REGION_SET"};
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
  if (kind.limit_cylinder) text += "#define WITH_CYLINDER\n";
  if (kind.falloff) text += "#define FALLOFF\n";
  if (kind.single) text += "#define SINGLE_FIELD\n";
  text += kind.single ? "#define FIELD_COUNT(count) 1\n" : "#define FIELD_COUNT(count) (count)\n";
  if (kind.in_double) text += "#define IN_DOUBLE\n";
  text += kind.in_double ? "#define R double\n#define R2 dvec2\n#define R3 dvec3\n#define R4 dvec4\n"
                         : "#define R float\n#define R2 vec2\n#define R3 vec3\n#define R4 vec4\n";
  return text;
}

// The greatest part of a region's width, or of a grid's spacing, that a step may pass.
double greatest_reach(const ShaderKind& kind) {
  if (kind.grid) return detail::kGridReach;
  return kind.regions == 1U << kCapsule ? detail::kCapsuleReach : detail::kReach;
}

// The rule of the steps and its numbers, from step_rule.h.
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
layout(std430, binding = 4) restrict readonly buffer Quads { R4 quads[]; };  // the same
layout(std430, binding = 5) restrict readonly buffer Places { double e[]; };
layout(std430, binding = 6) restrict readonly buffer Table { int table[]; };
layout(std430, binding = 7) restrict buffer Counts { uint counts[]; };
uniform uint point_count;
uniform int segment_count;
uniform bool counts_steps;
uniform int four;  // which compilers do not know, so that they keep a loop

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
R greatest_reach;
R tolerance;
R least_motion;
int segment_places;
dvec3 centre;

// The path line.
uint accepted = 0u;
uint rejected = 0u;
uint evaluations = 0u;
bool complete = true;

// The motion of a point by a segment: `moved`, and with the tool during `carried`.
struct Motion { R3 moved; R carried; };

int field_table(int f) { return first_field + f * kFieldEntries; }
int field_numbers(int f) { return table[field_table(f) + kFieldBegin]; }
R3 part(int i) { return R3(n[i], n[i + 1], n[i + 2]); }
dvec3 place(int i) { return dvec3(e[i], e[i + 1], e[i + 2]); }
dvec3 exact_displacement() { return place(segment_places + 3); }

// The k-th number of field f. Those of a single field are read once a segment.
#ifdef SINGLE_FIELD
R of_field[kFieldNumbers];
#define NUMBER(f, k) of_field[k]
#else
#define NUMBER(f, k) n[field_numbers(f) + (k)]
#endif
#define PART(f, k) R3(NUMBER(f, k), NUMBER(f, (k) + 1), NUMBER(f, (k) + 2))
)";

// Reads the numbers of the only field, four at a time.
std::string read_field() {
  std::string text = "void open_field() {\n  int first = field_numbers(0) / 4;\n";
  for (int i = 0; i < layout::kFieldNumbers; ++i) {
    text += fmt::format("  of_field[{}] = quads[first + {}].{};\n", i, i / 4, "xyzw"[i % 4]);
  }
  return text + "}\n";
}

std::string fields_source(const ShaderKind& kind) {
  if (kind.pins) return kGlslPins;
  if (kind.grid) return kGlslGrid;
  return (kind.single ? read_field() : "void open_field() {}\n") +
         kind_function("motion_kind", "kMotionKind", kind.motions) +
         kind_function("region_kind", "kRegionKind", kind.regions) + kGlslField + kGlslPowers + kGlslTrees + kGlslSets +
         kGlslVelocity + kGlslContact + kGlslClosedForm;
}

}  // namespace

std::string shader_source(const ShaderKind& kind) {
  const std::string fields = fields_source(kind);
  return "#version 430 core\n" + layout_defines() + kind_defines(kind) + method_defines(kind) + step_rule(kind) +
         kInterface + kGlslSphereContact + fields + step_source(tableau(kind.integrator)) + kGlslPath;
}

// The contacts of contact.cpp, in R with d relative to the tool: a tool that grazes by less than the rounding moves
// nothing visible.
const char* const kGlslSphereContact = R"(
// The first s >= 0 with |d + s velocity| = radius, for |d| >= radius.
R sphere_contact(R3 d, R3 velocity, R radius) {
  R a = dot(velocity, velocity);
  R b = -dot(d, velocity);
  if (!(b > R(0))) return kNever;
  R along = b / a;
  R3 across = d + velocity * along;
  R inside = radius * radius - dot(across, across);
  if (inside < R(0)) return kNever;
  return max(R(0), along - sqrt(inside / a));
}
)";

const char* const kGlslContact = R"(
#ifdef REGION_CAPSULE
// A capsule is the union of two end balls and a cylinder.
R capsule_contact(R3 half_axis, R3 d, R3 velocity, R outer) {
  R first = min(sphere_contact(d - half_axis, velocity, outer), sphere_contact(d + half_axis, velocity, outer));
  R len = length(half_axis);
  if (len == R(0)) return first;
  R3 axis = half_axis / len;
  R3 across = d - axis * dot(axis, d);
  if (length(across) <= outer) return abs(dot(axis, d)) <= len ? R(0) : first;
  R side = sphere_contact(across, velocity - axis * dot(axis, velocity), outer);
  if (side < kNever && abs(dot(axis, d + velocity * side)) <= len) first = min(first, side);
  return first;
}
#endif

#if defined(REGION_HALF_SPACE) || defined(REGION_SET)
// The time that may pass before r can be below outer.
R safe_advance(int f, R3 d, R r, R speed) {
  R outer = NUMBER(f, kOuter);
#ifdef REGION_SET
  if (region_kind(f) == kSet) {
    int set = field_table(f) + kFirstSet;
    R factor = table[set + 4] == 0 ? R(1) : R(0.8lf);
    return factor * sqrt(nearest_squared(set, d)) * (R(1) - outer / r) / max(speed, R(1e-30));
  }
#endif
  R turning = abs(NUMBER(f, kRegion + 6)) * length(cross(PART(f, kRegion + 3), d));
  return (r - outer) / max(speed + turning, R(1e-30));
}

R traced_contact(int f, R3 d, R3 velocity, R t, R direction, R left) {
  R outer = NUMBER(f, kOuter);
  R slack = R(1e-4) / NUMBER(f, kInverseWidth);
  R speed = length(velocity);
  R s = R(0);
  for (int i = 0; i < 4096 && s <= left; ++i) {
    R3 there = d + velocity * s;
    R r = region_at(f, there, t + direction * s).value;
    if (r < outer + slack) return s;
    s += max(safe_advance(f, there, r, speed), R(1e-6));
  }
  return s <= left ? s : kNever;
}
#endif

R contact_of(int f, R3 d, R3 velocity, R t, R direction, R left) {
  int kind = region_kind(f);
  R outer = NUMBER(f, kOuter);
#ifdef REGION_BALL
  if (kind == kBall) return length(d) < outer ? R(0) : sphere_contact(d, velocity, outer);
#endif
#ifdef REGION_CAPSULE
  if (kind == kCapsule) {
    if (region_at(f, d, R(0)).value < outer) return R(0);
    return capsule_contact(PART(f, kRegion), d, velocity, outer);
  }
#endif
#if defined(REGION_HALF_SPACE) || defined(REGION_SET)
  if (kind == kHalfSpace || kind == kSet) return traced_contact(f, d, velocity, t, direction, left);
#endif
  return R(0);  // everything moves but the zero set, where v is 0 of itself
}

// The earliest time, from t towards `end`, at which the resting point can be inside the support of a field; kNever if
// it never is.
R next_contact(R3 at, R t, R end) {
  R direction = end >= t ? R(1) : R(-1);
  R left = abs(end - t);
  R first = kNever;
  for (int f = 0; f < field_count; ++f) {
    R3 d = at_field(f, at);
#ifdef BLENDED
    for (int k = 0; k < 2; ++k) {
      first = min(first, contact_of(f, k == 0 ? d : d - displacement, R3(0), t, direction, left));
    }
#else
    first = min(first, contact_of(f, d - displacement * t, displacement * -direction, t, direction, left));
#endif
  }
  return first < left ? t + direction * first : kNever;
}
)";

// The grids of grid.h, instead of all other fields. n[] has the numbers of GridNodes, with the empty nodes and a fourth
// number each (packed_flow.cpp).
const char* const kGlslGrid = R"(
double exact_per_spacing;
R per_spacing;
int row;
int plane;
int first_node;
ivec3 first_cell;
ivec3 last_cell;
int used_cells;
int nodes;
#ifdef GRID_CHANGES
int end_nodes;
#endif

ivec3 three(int i) { return ivec3(table[i], table[i + 1], table[i + 2]); }

void open_field() {
  exact_per_spacing = e[segment_places + 8];
  per_spacing = R(exact_per_spacing);
  row = table[first_field + kRow];
  plane = table[first_field + kPlane];
  first_node = table[first_field + kFirstNode];
  first_cell = three(first_field + kFirstCell);
  last_cell = three(first_field + kLastCell);
  used_cells = table[first_field + kUsed];
  nodes = field_numbers(0) / 4;
#ifdef GRID_CHANGES
  end_nodes = table[first_field + kEndNumbers] / 4;
#endif
}

// The cell's first node, counted from the grid's first one.
int node_of(ivec3 cell) {
  ivec3 own = clamp(cell, first_cell, last_cell);
  return first_node + own.x + row * own.y + plane * own.z;
}

bool is_used(int node) { return (table[used_cells + (node >> 5)] >> (node & 31) & 1) != 0; }

// The cell of a place that is relative to the middle node, `at` in spacings.
ivec3 cell_of(R3 at) {
  return ivec3(roundEven(clamp(at, R3(first_cell), R3(last_cell) + R(1)) - R(0.5)));
}

// Whether the exact place lies in a used cell, as the CPU decides it.
bool is_in_use(dvec3 from) {
  precise dvec3 at = clamp(from * exact_per_spacing, dvec3(first_cell), dvec3(last_cell) + 1.0) - 0.5;
  return is_used(node_of(ivec3(roundEven(at))));
}

// Six times the spline's weights of four nodes, and their derivatives.
struct Weights { R4 value; R4 slope; };

Weights weights_at(R u) {
  R q = R(1) - u;
  R u2 = u * u;
  R q2 = q * q;
  return Weights(R4(q2 * q, u2 * (R(3) * u - R(6)) + R(4), q2 * (R(3) * q - R(6)) + R(4), u2 * u),
                 R4(R(-3) * q2, u * (R(9) * u - R(12)), q * (R(12) - R(9) * q), R(3) * u2));
}

// The coefficient of a node.
R3 node_at(int node, R t) {
  R3 a = quads[nodes + node].xyz;
#ifdef GRID_CHANGES
  a += (quads[end_nodes + node].xyz - a) * t;
#endif
  return a;
}

// v = curl A: lines of four nodes along x are summed, then planes of four lines, each with its derivatives. The loop over
// planes stays a loop, since written out it is slower (docs/performance.md).
R3 grid_velocity(R3 at, R t) {
  R3 place = at * per_spacing;
  ivec3 cell = cell_of(place);
  int node = node_of(cell);
  R3 within = place - R3(cell);
  Weights x = weights_at(within.x);
  Weights y = weights_at(within.y);
  Weights z = weights_at(within.z);
  R3 v = R3(0);
  for (int k = 0; k < four; ++k) {
    R zv = k == 0 ? z.value.x : k == 1 ? z.value.y : k == 2 ? z.value.z : z.value.w;
    R zs = k == 0 ? z.slope.x : k == 1 ? z.slope.y : k == 2 ? z.slope.z : z.slope.w;
    int from = node + plane * k;
    R3 value = R3(0);
    R3 along_x = R3(0);
    R3 along_y = R3(0);
    for (int j = 0; j < 4; ++j) {
      R yv = j == 0 ? y.value.x : j == 1 ? y.value.y : j == 2 ? y.value.z : y.value.w;
      R ys = j == 0 ? y.slope.x : j == 1 ? y.slope.y : j == 2 ? y.slope.z : y.slope.w;
      R3 a = node_at(from, t);
      R3 b = node_at(from + 1, t);
      R3 c = node_at(from + 2, t);
      R3 d = node_at(from + 3, t);
      from += row;
      R3 sum = a * x.value.x + b * x.value.y + c * x.value.z + d * x.value.w;
      R3 slope = a * x.slope.x + b * x.slope.y + c * x.slope.z + d * x.slope.w;
      value += sum * yv;
      along_y += sum * ys;
      along_x += slope * yv;
    }
    R3 by_z = value * zs;
    R3 by_y = along_y * zv;
    R3 by_x = along_x * zv;
    v += R3(by_y.z - by_z.y, by_z.x - by_x.z, by_x.y - by_y.x);
  }
  return is_used(node) ? v : R3(0);
}

R3 velocity_at(R3 at, R t) {
  ++evaluations;
  return grid_velocity(at, t);
}

// v that depends on the time may grow, up to v at the segment's end.
R hidden_speed(R3 at, R t) {
#ifdef GRID_CHANGES
  return length(grid_velocity(at, n[segment_numbers + kEnd]));
#else
  return R(0);
#endif
}

// A point that rests in a cell in use may be moved later.
R next_contact(R3 at, R t, R end) {
  int node = node_of(cell_of(at * per_spacing));
  return t != end && is_used(node) ? t : kNever;
}
)";

}  // namespace knead::gpu
