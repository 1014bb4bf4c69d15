// The formats of animations. Internal to the writer of animations.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "knead/io/animation.h"

namespace knead::io_detail {

// Return what writes a file of the format. The source must outlive it.
AnimationFile::Writer pc2_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options);
AnimationFile::Writer mdd_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options);
AnimationFile::Writer glb_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options);
AnimationFile::Writer usda_writer(const std::filesystem::path& path, const ShapeFile& source,
                                  const AnimationOptions& options);
AnimationFile::Writer pvd_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options);

// Whether the source has a normal of its own for each vertex, and faces.
bool has_vertex_normals(const ShapeFile& source);

// The normals of the source's vertices when they are at the positions: its own ones, turned, else the surface's. Empty
// for a source without faces.
class FrameNormals {
 public:
  explicit FrameNormals(const ShapeFile& source);

  const std::vector<Vec3d>& first() const { return first_; }
  std::vector<Vec3d> at(std::span<const Vec3d> positions) const;

 private:
  const ShapeFile& source_;
  std::vector<Vec3d> first_;  // before anything moves
};

}  // namespace knead::io_detail
