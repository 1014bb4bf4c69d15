// Uses an installed Knead: sums 1..n in chunks and turns a vector.
#include <cstdio>
#include <numeric>
#include <vector>

#include "knead/math/mat3.h"
#include "knead/math/parallel.h"
#include "knead/math/vec3.h"

int main() {
  constexpr std::size_t kCount = 1000;
  std::vector<long> squares(kCount);
  knead::parallel_for(kCount, 64, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) squares[i] = static_cast<long>(i * i);
  });
  const long sum = std::accumulate(squares.begin(), squares.end(), 0L);

  const knead::Mat3d quarter_turn({0, -1, 0}, {1, 0, 0}, {0, 0, 1});
  const bool turned = quarter_turn * knead::Vec3d{1, 0, 0} == knead::Vec3d{0, 1, 0};

  std::printf("sum of squares %ld, turned %s\n", sum, turned ? "yes" : "no");
  return sum == 332833500 && turned ? 0 : 1;
}
