// What a deformation's result is, proved rather than hoped for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "knead/mesh/mesh.h"
#include "knead/session/replay.h"

namespace knead {

// How far one stroke's result lies from the true image of the surface that it began with: of the vertices and the
// centres of the faces that it moved. They are carried back by the inverse of its flow; their distances from the
// surface there are g, and g / |grad g|, to the first order the distances here, where g is taken as a function of the
// place after. Where the stroke presses a surface flat, g is many times that. Relative to the diagonal of the input's
// box.
struct StrokeDistance {
  std::size_t line = 0;  // of the session
  std::size_t points = 0;
  double rms = 0;
  double max = 0;
  double back_rms = 0;  // of g
  double back_max = 0;
};

// Of the result with its positions as they are written. The members are the keys of the report.
struct Certificate {
  std::uint64_t crossings_before = 0;  // pairs of triangles, by exact predicates (mesh/self_intersections.h)
  std::uint64_t crossings_after = 0;
  std::size_t flipped_triangles = 0;  // Report::flipped_triangles
  std::size_t degenerate_before = 0;
  std::size_t degenerate_after = 0;
  bool closed_before = false;
  bool closed_after = false;
  std::int64_t euler_before = 0;
  std::int64_t euler_after = 0;
  // after / before - 1, nothing where a volume makes no sense; and what it is made of. Integration: the mean of det J -
  // 1 over path lines of moved vertices (flow/volume_drift.h), added up over the strokes. Sampling: the rest, by which
  // the triangles miss the surface that they stand for.
  std::optional<double> volume_error;
  double volume_error_integration = 0;
  std::optional<double> volume_error_sampling;
  // A length: the greatest motion of a vertex around which no stroke's flow can move anything. 0 unless something is
  // wrong.
  double motion_outside = 0;
  // In degrees, of triangles with area; nothing where there is none. Touched: of the faces at vertices that were moved,
  // and of the faces that these came from.
  std::optional<double> smallest_angle_before;
  std::optional<double> smallest_angle_after;
  std::optional<double> touched_angle_before;
  std::optional<double> touched_angle_after;
  double distance_rms = 0;  // over all strokes; StrokeDistance
  double distance_max = 0;
  double carried_back_rms = 0;
  double carried_back_max = 0;
  std::vector<StrokeDistance> strokes;
};

// Follows a replay to certify its result: add() is for ReplayOptions::on_stroke, in order.
class CertificateBuilder {
 public:
  // The mesh and the options are those of the replay, and outlive the builder. Throws as replay().
  CertificateBuilder(const Mesh& mesh, const ReplayOptions& options);
  ~CertificateBuilder();
  CertificateBuilder(const CertificateBuilder&) = delete;
  CertificateBuilder& operator=(const CertificateBuilder&) = delete;

  // Costs about six times the stroke, in double precision, and a search for the nearest point of the surface for each
  // vertex and face that moved.
  void add(const AppliedStroke& stroke);

  // `as_float`: the result is written with float coordinates.
  Certificate finish(const ReplayResult& result, bool as_float) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace knead
