// The surface of a deformed shape is relaxed.
#include <cmath>

#include "knead/math/error.h"
#include "knead/remesh/relax.h"
#include "knead/session/deformed_shape.h"

namespace knead {

namespace session_detail {

// For the faces and creases from which it was made.
struct RelaxMesh {
  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const Provenance> provenance;
  remesh_detail::RelaxTopology topology;
};

}  // namespace session_detail

namespace {

// What a mask holds stays; nothing without a mask.
remesh_detail::RelaxTopology masked_topology(const Mask& mask, const remesh_detail::RelaxTopology& topology,
                                             std::span<const Vec3d> positions) {
  if (mask.is_empty()) return {};
  remesh_detail::RelaxTopology result = topology;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (mask.holds(positions[v])) result.freedom[v] = remesh_detail::RelaxTopology::Freedom::stays;
  }
  return result;
}

}  // namespace

// The creases are those that remeshing keeps: of the shape before any deformation.
const session_detail::RelaxMesh& DeformedShape::relax_mesh() const {
  if (relax_mesh_ && relax_mesh_->mesh == mesh_ && relax_mesh_->provenance == provenance_) return *relax_mesh_;
  const bool has_creases = provenance_ && provenance_->creases;
  const std::vector<MeshEdge> creases = has_creases ? *provenance_->creases : find_creases(*start_);
  relax_mesh_ = std::make_shared<const session_detail::RelaxMesh>(session_detail::RelaxMesh{
      mesh_, provenance_, remesh_detail::relax_topology(triangles(), positions_.size(), creases)});
  return *relax_mesh_;
}

AdvectStatus DeformedShape::relax(const RelaxStroke& stroke, double from, double to, Progress* progress) {
  if (mesh_->face_count() == 0) throw InvalidInput("a point cloud has no surface to relax; remove this line");
  if (from >= to) return AdvectStatus::done;
  earlier_steps_ = steps();
  blocks_.reset();
  const remesh_detail::RelaxTopology masked = masked_topology(mask_, relax_mesh().topology, positions_);
  remesh_detail::Relaxer relaxer(mask_.is_empty() ? relax_mesh().topology : masked, triangles(), positions_,
                                 policy_->single_precision, motion_.threads);
  for (double i = std::floor(from); i < to; ++i) {
    if (progress != nullptr && progress->cancel) return AdvectStatus::cancelled;
    const double part = std::min(1.0, to - i);
    relaxer.apply({stroke.points[static_cast<std::size_t>(i)], stroke.radius, part * stroke.amount, stroke.surface,
                   stroke.iterations});
    ++dabs_;
  }
  return AdvectStatus::done;
}

}  // namespace knead
