// `knead bench --integrators`: which Runge-Kutta method reaches an accuracy fastest.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench_scenes.h"
#include "knead/io.h"

namespace knead::command {

// A scene moved by one method with one setting, on one thread.
struct IntegratorRun {
  std::string scene;
  std::string tool;
  Integrator integrator = Integrator::rk4;
  Precision precision = Precision::float32;
  double tolerance = 0;  // the setting, for one path line and segment; of the box diagonal
  double max_error = 0;  // measured over all segments; of the box diagonal
  double seconds = 0;    // median
};

// The time that each method needs for an error of at most `error` (of the box diagonal), with the best tolerance: the
// geometric mean over all scenes, in the order of the integrators. Nothing for a method that misses it in a scene.
struct TimesToAccuracy {
  Precision precision = Precision::float32;
  double error = 0;
  std::vector<std::optional<double>> seconds;

  std::optional<Integrator> soonest() const;
};

// Returns scenes of about 20,000 vertices of a shape, with a stroke of every tool that needs integration.
std::vector<BenchScene> integrator_scenes(const std::string& name, const std::vector<Vec3d>& points);

// Measures all methods in float and double, with tolerances of 1e-3 and below; leaves out runs that would take long.
std::vector<IntegratorRun> measure_integrators(const BenchScene& scene);

// Returns the times to several errors, interpolated between two settings in logarithms.
std::vector<TimesToAccuracy> times_to_accuracy(const std::vector<IntegratorRun>& runs);

// Returns the fastest method at the library's default precision and tolerance, which should be its default.
std::optional<Integrator> soonest_by_default(const std::vector<TimesToAccuracy>& all);

std::string to_string(const std::optional<Integrator>& integrator);  // as on the command line, or none
Json json_of(const IntegratorRun& run);
Json json_of(const TimesToAccuracy& times);
std::string text_of(const std::vector<IntegratorRun>& runs);  // of one scene
std::string text_of(const std::vector<TimesToAccuracy>& all);

}  // namespace knead::command
