#include "knead/math/morton.h"

namespace knead {
namespace {

// Inserts two zero bits before each of the lowest 21 bits.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

}  // namespace

std::uint64_t morton_code(const std::array<float, 3>& point) {
  std::uint64_t code = 0;
  for (const float x : point) {
    constexpr float cells = 1 << 21;
    const float place = (x * 0.5F + 0.5F) * cells;
    code = code << 1 | spread(static_cast<std::uint64_t>(std::clamp(place, 0.0F, cells - 1)));
  }
  return code;
}

}  // namespace knead
