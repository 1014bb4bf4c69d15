#include "knead/gpu/glsl.h"

namespace knead::gpu {

// grid_view.h and kernel_grid.h for the GPU, in the place of all other fields. The numbers of a grid's nodes stand in n[]
// as GridNodes has them, with the empty nodes around; packed_grid.cpp puts them there. Nothing loops, since some drivers
// count the rounds of loops.
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

R along_line(int at, int stride, R4 by) {
  return dot(R4(n[at], n[at + stride], n[at + 2 * stride], n[at + 3 * stride]), by);
}

// Of a plane of 16 nodes, each line summed along its own axis: the sum and its derivative along the next one.
R2 over_plane(int at, int own, int next, R4 by, Weights across) {
  R4 lines = R4(along_line(at, own, by), along_line(at + next, own, by), along_line(at + 2 * next, own, by),
                along_line(at + 3 * next, own, by));
  return R2(dot(lines, across.value), dot(lines, across.slope));
}

// The derivatives of a component of A along the next axis and the last one.
R2 slopes_of(int at, ivec3 strides, R4 own, Weights next, Weights last) {
  R2 a = over_plane(at, strides.x, strides.y, own, next);
  R2 b = over_plane(at + strides.z, strides.x, strides.y, own, next);
  R2 c = over_plane(at + 2 * strides.z, strides.x, strides.y, own, next);
  R2 d = over_plane(at + 3 * strides.z, strides.x, strides.y, own, next);
  return R2(dot(R4(a.y, b.y, c.y, d.y), last.value), dot(R4(a.x, b.x, c.x, d.x), last.slope));
}

// v = curl A in the cell whose numbers begin at `at`.
R3 curl(int at, Weights x, Weights y, Weights z) {
  ivec3 strides = ivec3(3, 3 * table[first_field + kRow], 3 * table[first_field + kPlane]);
  R2 of_x = slopes_of(at, strides.xyz, x.value, y, z);
  R2 of_y = slopes_of(at + 1, strides.yzx, y.value, z, x);
  R2 of_z = slopes_of(at + 2, strides.zxy, z.value, x, y);
  return R3(of_z.y - of_y.x, of_x.y - of_z.x, of_y.y - of_x.x);
}

R3 grid_velocity(R3 at, R t) {
  R3 place = at * n[segment_numbers + kPerSpacing];
  ivec3 cell = cell_of(place);
  int node = node_of(cell);
  if (!is_used(node)) return R3(0);
  R3 within = place - R3(cell);
  Weights x = weights_at(within.x);
  Weights y = weights_at(within.y);
  Weights z = weights_at(within.z);
  R3 v = curl(field_numbers(0) + 3 * node, x, y, z);
#ifdef GRID_CHANGES
  v += (curl(table[first_field + kEndNumbers] + 3 * node, x, y, z) - v) * t;
#endif
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
