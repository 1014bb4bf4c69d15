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

// The normals of the source's vertices when they are at the positions: the authored ones, turned, else the surface's.
// Empty for a source without faces and normals.
class FrameNormals {
 public:
  explicit FrameNormals(const ShapeFile& source);

  std::vector<Vec3d> at(std::span<const Vec3d> positions) const;

 private:
  const ShapeFile& source_;
  bool is_authored_ = false;  // with a normal for each vertex
  Mesh mesh_;                 // the faces, if none are authored
};

}  // namespace knead::io_detail
