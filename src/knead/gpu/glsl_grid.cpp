#include "knead/gpu/glsl.h"

namespace knead::gpu {

// grid_view.h and kernel_grid.h for the GPU, in the place of all other fields. The numbers of a grid's nodes stand in
// n[] as GridNodes has them, with the empty nodes around; packed_grid.cpp puts them there. Lines of nodes loop: written
// out, shaders take Mesa on the CPU half a minute to compile.
const char* const kGlslGrid = R"(
double per_spacing;

ivec3 three(int i) { return ivec3(table[i], table[i + 1], table[i + 2]); }

// The cell's first node, counted from the grid's first one.
int node_of(ivec3 cell) {
  ivec3 own = clamp(cell, three(first_field + kFirstCell), three(first_field + kLastCell));
  return table[first_field + kFirstNode] + own.x + table[first_field + kRow] * own.y + table[first_field + kPlane] * own.z;
}

bool is_used(int node) { return (table[table[first_field + kUsed] + (node >> 5)] >> (node & 31) & 1) != 0; }

// The cell of a place that is relative to the middle node, `at` in spacings.
ivec3 cell_of(R3 at) {
  R3 first = R3(three(first_field + kFirstCell));
  R3 last = R3(three(first_field + kLastCell));
  return ivec3(roundEven(clamp(at, first, last + R(1)) - R(0.5)));
}

// Whether a grid can be felt at the exact place, as the CPU decides it.
bool is_felt(dvec3 from) {
  dvec3 first = dvec3(three(first_field + kFirstCell));
  dvec3 last = dvec3(three(first_field + kLastCell));
  precise dvec3 at = clamp(from * per_spacing, first, last + 1.0) - 0.5;
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

// The coefficient of the node whose numbers begin `offset` after those of the first one.
R3 node_at(int offset, R t) {
  R3 a = part(field_numbers(0) + offset);
#ifdef GRID_CHANGES
  a += (part(table[first_field + kEndNumbers] + offset) - a) * t;
#endif
  return a;
}

// v = curl A: each line of four nodes along x is summed, and its derivative.
R3 grid_velocity(R3 at, R t) {
  R3 place = at * n[segment_numbers + kPerSpacing];
  ivec3 cell = cell_of(place);
  int node = node_of(cell);
  if (!is_used(node)) return R3(0);
  R3 within = place - R3(cell);
  Weights x = weights_at(within.x);
  Weights y = weights_at(within.y);
  Weights z = weights_at(within.z);
  R3 v = R3(0);
  for (int line = 0; line < 16; ++line) {
    int j = line & 3;
    int k = line >> 2;
    int offset = 3 * (node + table[first_field + kRow] * j + table[first_field + kPlane] * k);
    R3 a = node_at(offset, t);
    R3 b = node_at(offset + 3, t);
    R3 c = node_at(offset + 6, t);
    R3 d = node_at(offset + 9, t);
    R3 value = a * x.value.x + b * x.value.y + c * x.value.z + d * x.value.w;
    R3 slope = a * x.slope.x + b * x.slope.y + c * x.slope.z + d * x.slope.w;
    R3 by_z = value * (y.value[j] * z.slope[k]);
    R3 by_y = value * (y.slope[j] * z.value[k]);
    R3 by_x = slope * (y.value[j] * z.value[k]);
    v += R3(by_y.z - by_z.y, by_z.x - by_x.z, by_x.y - by_y.x);
  }
  return v;
}

R3 velocity_at(R3 at, R t) {
  ++evaluations;
  return grid_velocity(at, t);
}

// Where v depends on the time it may still grow: up to what it is at the segment's end.
R hidden_speed(R3 at, R t) {
#ifdef GRID_CHANGES
  return length(grid_velocity(at, n[segment_numbers + kEndOfTime]));
#else
  return R(0);
#endif
}

R local_width(R3 at, R t) { return kNever; }

// A point that rests in a cell in use may be moved later.
R next_contact(R3 at, R t, R end) {
  int node = node_of(cell_of(at * n[segment_numbers + kPerSpacing]));
  return t != end && is_used(node) ? t : kNever;
}
)";

}  // namespace knead::gpu
