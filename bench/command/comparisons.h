// The comparisons of `knead bench`: Runge-Kutta methods (--integrators), brushes of other programs, and a GPU
// (--backend gpu).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "json/json.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/stroke.h"
#include "scenes.h"

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

struct PeerScene {
  std::string name;  // of the shape and the stroke
  Mesh mesh;
  ImplicitStroke stroke;
};

// Returns three scenes on a shape: a pull by the brush's radius with as many samples as a slow pointer gives; the same
// with one sample, as grab brushes are applied; a push by three radii into the shape in four pieces. Returns none for a
// shape that is not closed.
std::vector<PeerScene> peer_scenes(const std::string& name, const Mesh& mesh);

// Returns the same for the paper's armadillo in the folder, or for a procedural shape of its size.
std::vector<PeerScene> standard_peer_scenes(const std::string& folder);

// The result of one method in a scene, on one thread.
struct PeerRow {
  std::string method;
  std::string scene;
  double seconds = 0;  // median
  double volume_error = 0;
  std::size_t self_intersections_before = 0;  // counted up to a million
  std::size_t self_intersections_after = 0;
  double motion_beyond_outer = 0;  // the greatest of the vertices that are at least `outer` from the path; of the
                                   // box diagonal
};

std::vector<PeerRow> measure_peers(const PeerScene& scene);

Json json_of(const PeerRow& row);
std::string peers_heading();
std::string text_of(const PeerRow& row);

// Measures the scenes one after the other. If `all`, a real GPU also runs the paper's benchmark on ten million
// vertices. Prints each row as soon as it is measured, unless quiet. Throws GpuError if there is no GPU.
Json measure_on_gpu(std::vector<BenchScene> scenes, bool all, bool quiet);

}  // namespace knead::command
