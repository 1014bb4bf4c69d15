// How a session is applied: the options that all functions share.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <string>

#include "knead/replay.h"

namespace knead::python {

// The keywords of deform(), as Python checks them.
struct Accuracy {
  double relative_tolerance = kDefaultRelativeTolerance;
  std::string precision = "float32";
  std::string integrator = "tsit5";
  int threads = 0;
  std::optional<double> diagonal;
};

// Throws InvalidInput for an unknown name.
MotionOptions motion_options(const Accuracy& accuracy);

}  // namespace knead::python
