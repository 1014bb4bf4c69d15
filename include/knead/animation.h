// Writes a moving shape to one file: PC2, MDD, glTF with morph targets, USD, or a time series of ParaView.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "knead/io.h"

namespace knead {

// The frames of an animation.
struct AnimationOptions {
  int frames = 1;   // the number of frames that will be added; 1 or more
  double fps = 24;  // frames per second; above 0
};

// Returns whether the path's extension, in upper or lower case, is one of .pc2, .mdd, .glb, .usda and .pvd.
bool is_animation(const std::filesystem::path& path);

// Returns one sentence for each property of the source that an animation in this format leaves out.
std::vector<std::string> animation_losses(const std::filesystem::path& path, const ShapeFile& source);

// An animation that is written frame by frame. The vertices and faces are those of the source in every frame.
//
// .pc2   PointCache2, version 1: positions as little-endian floats; starts at 0, one sample for each frame.
// .mdd   LightWave's motion designer file: times in seconds, positions as big-endian floats.
// .glb   glTF 2.0: the source, with one morph target (positions, normals) for each different frame after the first, and
//        an animation of their weights. A source in glTF keeps everything that it has.
// .usda  OpenUSD's text: a Mesh (or Points) with time samples of points, normals and extent.
// .pvd   ParaView's time series: OUT.pvd and a file OUT_0000.vtp for each frame, positions as doubles, with the
//        displacement since the first frame.
//
// The files appear complete when finish() returns, and not at all without it. Memory: two frames; for .glb also, in
// each frame, 32 bytes for each vertex that differs from the first frame, and some copies of the file; for .usda 16
// bytes for each normal that differs.
class AnimationFile {
 public:
  // Throws IoError(write) if no file can be made there, and InvalidInput for options out of range, another extension,
  // and a source that the format cannot hold.
  AnimationFile(const std::filesystem::path& path, const ShapeFile& source, const AnimationOptions& options);
  AnimationFile(const AnimationFile&) = delete;
  AnimationFile& operator=(const AnimationFile&) = delete;
  AnimationFile(AnimationFile&&) noexcept = default;
  AnimationFile& operator=(AnimationFile&&) noexcept = default;
  ~AnimationFile() = default;

  // Adds the next frame: a position for each vertex of the source. Throws IoError(write), and InvalidInput for
  // positions that the format cannot hold.
  // NOLINTNEXTLINE(readability-make-member-function-const): it changes the file
  void add(std::span<const Vec3d> positions) { writer_.add(positions); }

  // Completes the file, after all frames were added. Throws IoError(write), and InvalidInput for more than 4 GiB of
  // GLB. NOLINTNEXTLINE(readability-make-member-function-const)
  void finish() { writer_.finish(); }

  // The functions of a format.
  struct Writer {
    std::function<void(std::span<const Vec3d>)> add;
    std::function<void()> finish;
  };

 private:
  Writer writer_;
};

// The morph targets of a glTF file, and their weights over time.
struct MorphTargets {
  std::vector<std::vector<Vec3d>> shapes;  // each with a position for each vertex of the source; may be empty
  std::vector<std::string> names{};        // one for each shape, or empty
  std::vector<double> weights;             // one for each shape, for a viewer that plays no animation
  std::vector<double> times{};             // seconds, 0 or more, ascending; empty: no animation of the weights
  std::vector<double> keys{};              // the weights of all shapes at the first time, then at the second one ...
  std::size_t animation = 0;               // number of the file's animation that gets the keys; new if it has none
};

// Returns the bytes of a file in the format "glb" or "gltf" with the source and these morph targets (positions and
// normals). A source in glTF keeps everything, such as its skeleton and animations. Throws InvalidInput for lists of
// wrong lengths, for positions that the format cannot hold, and for a source that has morph targets of its own.
std::string serialize_morphed(const ShapeFile& source, const MorphTargets& targets, std::string_view format = "glb");

}  // namespace knead
