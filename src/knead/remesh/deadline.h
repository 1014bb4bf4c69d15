// The moment at which a remesh ends with what it has. Internal to the remesh room.
#pragma once

#include <chrono>

namespace knead::remesh_detail {

// Counts from when it is made. Loops ask it and end early.
class Deadline {
 public:
  // Infinity: never.
  explicit Deadline(double seconds) : seconds_(seconds) {}

  // Returns whether the time is over.
  bool is_over() {
    if (seconds_ > kLongest) return false;
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin_;
    if (passed.count() >= seconds_) has_ended_work_ = true;
    return has_ended_work_;
  }

  // Returns whether is_over() has ever been true: then somebody has ended early.
  bool has_ended_work() const { return has_ended_work_; }

 private:
  static constexpr double kLongest = 1e9;  // 30 years

  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double seconds_;
  bool has_ended_work_ = false;
};

}  // namespace knead::remesh_detail
