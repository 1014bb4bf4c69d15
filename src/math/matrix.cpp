// Inverses and polar factors of 3x3 matrices.
#include "math/matrix.h"

namespace knead {

Mat3d inverse(const Mat3d& m) {
  const Vec3d a = cross(m.row1, m.row2);
  const double d = dot(m.row0, a);
  return transposed({a / d, cross(m.row2, m.row0) / d, cross(m.row0, m.row1) / d});
}

Mat3d nearest_rotation(const Mat3d& m) {
  constexpr int kMaxIterations = 40;
  constexpr double kClose = 1e-30;  // the square of a change, after which the next one is beyond rounding
  Mat3d r = m;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Mat3d cofactors{cross(r.row1, r.row2), cross(r.row2, r.row0), cross(r.row0, r.row1)};
    const Mat3d next = (r + cofactors * (1 / dot(r.row0, cofactors.row0))) * 0.5;
    const double change = norm2(next.row0 - r.row0) + norm2(next.row1 - r.row1) + norm2(next.row2 - r.row2);
    r = next;
    if (!(change > kClose)) break;
  }
  return r;
}

Mat3d log_strain(const Mat3d& m) {
  const Mat3d v = m * transposed(nearest_rotation(m));
  return (v + inverse(v) * -1.0) * 0.5;
}

}  // namespace knead
