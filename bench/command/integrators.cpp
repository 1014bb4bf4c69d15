// Compares Runge-Kutta methods by the time that they need for an error.
#include "comparisons.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>

#include "scenes.h"

namespace knead::command {
namespace {

constexpr std::size_t kVertices = 20'000;
// After a setting that took this many times as long as the loosest one, tighter settings are left out.
constexpr double kLongest = 100;
constexpr std::array kPrecisions{Precision::float32, Precision::float64};
constexpr std::array kIntegrators{Integrator::rk4, Integrator::tsitouras};

const char* name_of(Integrator integrator) { return integrator == Integrator::rk4 ? "rk4" : "tsit5"; }

const char* name_of(Precision precision) { return precision == Precision::float32 ? "float" : "double"; }

// The errors to reach. Tolerances hold for one segment, so in double there are also tighter ones.
std::vector<double> errors_of(Precision precision) {
  if (precision == Precision::float32) return {1e-3, 1e-4, 1e-5, 1e-6};
  return {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9};
}

std::vector<double> tolerances_of(Precision precision) {
  std::vector<double> tolerances = errors_of(precision);
  if (precision == Precision::float64) tolerances.insert(tolerances.end(), {1e-10, 1e-11});
  return tolerances;
}

// Returns the time that a method needs for the error in one scene; `runs` go from loose to tight.
std::optional<double> time_to(double error, const std::vector<IntegratorRun>& runs) {
  std::optional<double> soonest;
  const auto consider = [&](double seconds) { soonest = std::min(soonest.value_or(seconds), seconds); };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].max_error > error) continue;
    consider(runs[i].seconds);
    if (i == 0 || runs[i - 1].max_error <= error) continue;
    const double whole = std::log(runs[i - 1].max_error / std::max(runs[i].max_error, 1e-300));
    const double part = std::log(runs[i - 1].max_error / error) / whole;
    consider(runs[i - 1].seconds * std::pow(runs[i].seconds / runs[i - 1].seconds, part));
  }
  return soonest;
}

std::optional<double> mean_time_to(double error, Precision precision, Integrator integrator,
                                   const std::vector<IntegratorRun>& runs) {
  std::set<std::string> tools;
  for (const IntegratorRun& run : runs) tools.insert(run.scene + run.tool);
  double logarithms = 0;
  for (const std::string& tool : tools) {
    std::vector<IntegratorRun> own;
    std::copy_if(runs.begin(), runs.end(), std::back_inserter(own), [&](const IntegratorRun& run) {
      return run.scene + run.tool == tool && run.precision == precision && run.integrator == integrator;
    });
    const std::optional<double> seconds = time_to(error, own);
    if (!seconds) return std::nullopt;
    logarithms += std::log(*seconds);
  }
  return std::exp(logarithms / static_cast<double>(tools.size()));
}

IntegratorRun measure(IntegratorRun run, const BenchScene& scene, const std::vector<Vec3d>& expected) {
  AdvectOptions options;
  options.tolerance = run.tolerance * scene.size;
  options.integrator = run.integrator;
  options.precision = run.precision;
  options.threads = 1;
  std::vector<Vec3d> moved;
  run.seconds = median_seconds([&] {
    moved = scene.points;
    advect(scene.flow, moved, options);
  });
  run.max_error = greatest_distance(sample_of(moved, kErrorVertices), expected) / scene.size;
  return run;
}

}  // namespace

std::optional<Integrator> TimesToAccuracy::soonest() const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    if (seconds[i] && (!best || *seconds[i] < *seconds[*best])) best = i;
  }
  return best ? std::optional(kIntegrators[*best]) : std::nullopt;
}

std::vector<BenchScene> integrator_scenes(const std::string& name, const std::vector<Vec3d>& points) {
  std::vector<BenchScene> scenes = scenes_of_all_tools(name, sample_of(points, kVertices));
  std::erase_if(scenes, [](const BenchScene& scene) { return scene.tool == "rotate"; });  // has a closed form
  return scenes;
}

std::vector<IntegratorRun> measure_integrators(const BenchScene& scene) {
  const std::vector<Vec3d> expected = exact_positions(scene.flow, sample_of(scene.points, kErrorVertices), scene.size);
  std::vector<IntegratorRun> runs;
  for (const Precision precision : kPrecisions) {
    for (const Integrator integrator : kIntegrators) {
      std::optional<double> loosest;
      for (const double tolerance : tolerances_of(precision)) {
        const IntegratorRun& run =
            runs.emplace_back(measure({scene.name, scene.tool, integrator, precision, tolerance}, scene, expected));
        loosest = loosest.value_or(run.seconds);
        if (run.seconds > kLongest * *loosest) break;
      }
    }
  }
  return runs;
}

std::vector<TimesToAccuracy> times_to_accuracy(const std::vector<IntegratorRun>& runs) {
  std::vector<TimesToAccuracy> all;
  for (const Precision precision : kPrecisions) {
    for (const double error : errors_of(precision)) {
      TimesToAccuracy& times = all.emplace_back(TimesToAccuracy{precision, error, {}});
      for (const Integrator integrator : kIntegrators) {
        times.seconds.push_back(mean_time_to(error, precision, integrator, runs));
      }
    }
  }
  return all;
}

std::string to_string(const std::optional<Integrator>& integrator) {
  return integrator ? name_of(*integrator) : "none";
}

Json json_of(const IntegratorRun& run) {
  return {{"scene", run.scene},
          {"tool", run.tool},
          {"precision", name_of(run.precision)},
          {"integrator", name_of(run.integrator)},
          {"tolerance", run.tolerance},
          {"max_error", run.max_error},
          {"seconds", run.seconds}};
}

Json json_of(const TimesToAccuracy& times) {
  Json seconds;
  for (std::size_t i = 0; i < kIntegrators.size(); ++i) {
    seconds.set(name_of(kIntegrators[i]), times.seconds[i]);
  }
  return {{"precision", name_of(times.precision)},
          {"max_error", times.error},
          {"seconds", seconds},
          {"soonest", to_string(times.soonest())}};
}

std::string text_of(const std::vector<IntegratorRun>& runs) {
  std::string text =
      fmt::format("\n{}, {}: error and ms with each tolerance\n{:13}", runs.front().tool, runs.front().scene, "");
  for (const double tolerance : tolerances_of(Precision::float64)) text += fmt::format(" {:>15.0e}", tolerance);
  for (const IntegratorRun& run : runs) {
    if (run.tolerance == tolerances_of(run.precision).front()) {
      text += fmt::format("\n{:6} {:6}", name_of(run.precision), name_of(run.integrator));
    }
    text += fmt::format(" {:7.0e} {:7.2f}", run.max_error, 1e3 * run.seconds);
  }
  return text + "\n";
}

std::optional<Integrator> soonest_by_default(const std::vector<TimesToAccuracy>& all) {
  const AdvectOptions options;
  const auto row = std::find_if(all.begin(), all.end(), [&](const TimesToAccuracy& times) {
    return times.precision == options.precision && times.error == BenchScene{}.tolerance;
  });
  return row == all.end() ? std::nullopt : row->soonest();
}

std::string text_of(const std::vector<TimesToAccuracy>& all) {
  std::string text = "\nms to an error, geometric mean of all scenes\n             ";
  for (const Integrator integrator : kIntegrators) text += fmt::format(" {:>7}", name_of(integrator));
  for (const TimesToAccuracy& times : all) {
    text += fmt::format("\n{:6} {:6.0e}", name_of(times.precision), times.error);
    for (const std::optional<double>& seconds : times.seconds) {
      text += seconds ? fmt::format(" {:7.2f}", 1e3 * *seconds) : fmt::format(" {:>7}", "-");
    }
    text += "  " + to_string(times.soonest());
  }
  return text + fmt::format("\nthe default for {} to {:.0e} should be {}\n", name_of(AdvectOptions{}.precision),
                            BenchScene{}.tolerance, to_string(soonest_by_default(all)));
}

}  // namespace knead::command
