// `knead bench --integrators`: which Runge-Kutta method is accurate soonest.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench_scenes.h"
#include "knead/io/json.h"

namespace knead::command {

// A scene moved by one method with one setting, on one thread.
struct IntegratorRun {
  std::string scene;
  std::string tool;
  Integrator integrator = Integrator::rk4;
  Precision precision = Precision::float32;
  double tolerance = 0;  // of the box diagonal, asked of one path line and segment
  double max_error = 0;  // of the box diagonal, found over all segments
  double seconds = 0;    // median
};

// How soon the methods get to an error of at most `error` of the box diagonal, with whatever tolerance: the geometric
// mean over all scenes, in the order of the integrators; nothing for one that is not as accurate in every scene.
struct TimesToAccuracy {
  Precision precision = Precision::float32;
  double error = 0;
  std::vector<std::optional<double>> seconds;

  std::optional<Integrator> soonest() const;
};

// About 20,000 vertices of a shape, and a stroke of every tool that is integrated.
std::vector<BenchScene> integrator_scenes(const std::string& name, const std::vector<Vec3d>& points);

// All methods, in float and double, with tolerances from 1e-3 on; those that would take long are left out.
std::vector<IntegratorRun> measure_integrators(const BenchScene& scene);

// The time to an error lies between two settings where theirs do, on a line in logarithms.
std::vector<TimesToAccuracy> times_to_accuracy(const std::vector<IntegratorRun>& runs);

// At the library's default precision and tolerance: what its default should be.
std::optional<Integrator> soonest_by_default(const std::vector<TimesToAccuracy>& all);

std::string to_string(const std::optional<Integrator>& integrator);  // as on the command line, or none
Json json_of(const IntegratorRun& run);
Json json_of(const TimesToAccuracy& times);
std::string text_of(const std::vector<IntegratorRun>& runs);  // of one scene
std::string text_of(const std::vector<TimesToAccuracy>& all);

}  // namespace knead::command
