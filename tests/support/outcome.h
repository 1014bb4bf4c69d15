// All that advect gives, compared to the bit.
#pragma once

#include <bit>
#include <cstdlib>
#include <ostream>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"

namespace knead::test {

inline std::vector<std::uint64_t> bits(const std::vector<Vec3d>& points) {
  std::vector<std::uint64_t> result;
  for (const Vec3d& p : points) {
    for (const double x : {p.x, p.y, p.z}) result.push_back(std::bit_cast<std::uint64_t>(x));
  }
  return result;
}

// FNV-1a over the bytes of the numbers, the lowest first.
inline std::uint64_t hash(const std::vector<std::uint64_t>& numbers) {
  std::uint64_t result = 0xcbf29ce484222325U;
  for (const std::uint64_t number : numbers) {
    for (int shift = 0; shift < 64; shift += 8) result = (result ^ (number >> shift & 0xff)) * 0x100000001b3U;
  }
  return result;
}

struct Outcome {
  std::vector<std::uint64_t> points;  // their bits
  std::vector<std::uint32_t> steps;
  AdvectStatus status = AdvectStatus::done;
  std::uint64_t accepted = 0;
  std::uint64_t rejected = 0;
  std::uint64_t evaluations = 0;

  Outcome& operator+=(const AdvectResult& result) {
    if (status == AdvectStatus::done) status = result.status;
    accepted += result.accepted_steps;
    rejected += result.rejected_steps;
    evaluations += result.evaluations;
    return *this;
  }
  friend bool operator==(const Outcome&, const Outcome&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Outcome& outcome) {
    const std::vector<std::uint64_t> counts(outcome.steps.begin(), outcome.steps.end());
    return out << "points " << std::hex << hash(outcome.points) << ", steps " << hash(counts) << std::dec << ", "
               << outcome.accepted << " accepted, " << outcome.rejected << " rejected, " << outcome.evaluations
               << " evaluations, status " << static_cast<int>(outcome.status);
  }
};

inline Outcome outcome_of(const Flow& flow, std::vector<Vec3d> points, AdvectOptions options) {
  Outcome outcome;
  outcome.steps.resize(points.size());
  options.steps = outcome.steps;
  outcome += advect(flow, points, options);
  outcome.points = bits(points);
  return outcome;
}

// The value of KNEAD_SIMD while it lives; afterwards it is as before.
class Simd {
 public:
  explicit Simd(const std::string& name) {
    const char* const before = std::getenv("KNEAD_SIMD");
    was_set_ = before != nullptr;
    if (was_set_) before_ = before;
    setenv("KNEAD_SIMD", name.c_str(), 1);
  }
  ~Simd() {
    if (was_set_) {
      setenv("KNEAD_SIMD", before_.c_str(), 1);
    } else {
      unsetenv("KNEAD_SIMD");
    }
  }
  Simd(const Simd&) = delete;
  Simd& operator=(const Simd&) = delete;

 private:
  bool was_set_ = false;
  std::string before_;
};

// Every value of KNEAD_SIMD that this machine takes.
inline std::vector<std::string> simd_names() {
  std::vector<std::string> result;
  for (const std::string name : {"scalar", "avx2", "avx512", "neon"}) {
    const Simd simd(name);
    try {
      result.emplace_back(simd_name());
    } catch (const InvalidInput&) {
      continue;  // not of this machine
    }
  }
  return result;
}

}  // namespace knead::test
