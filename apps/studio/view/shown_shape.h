// The shape on the GPU: shows the current gesture before the CPU has applied it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/editor/gpu.h"
#include "knead/editor/render.h"
#include "studio.h"

namespace knead::studio {

// The GPU moves the vertices of the picture at once. The worker applies the same strokes on the CPU, whose positions
// count: when it has caught up, the GPU gets the same bits. No picture reads anything back; the end of a gesture
// reads back whether the GPU succeeded. Strokes that read the surface or
// have a mirror appear as the worker gets on.
//
// All functions throw GpuError or std::runtime_error, one line, if the GPU fails. Discard the object then.
class GpuPreview {
 public:
  // Uses the current OpenGL context, which must be current at every call and in the destructor.
  explicit GpuPreview(const gpu::GpuOptions& options = {});

  const std::string& description() const { return gpu_.description(); }
  bool is_software() const { return gpu_.is_software(); }  // Mesa on the CPU

  // Updates the view. `pending`: Studio::pending(); diagonal: of the shape as it was opened. Returns whether anything
  // has changed since the last call.
  bool follow(const ShapeState& state, const PendingStrokes* pending, double diagonal, render::LiveView& view);

  // Shows only visible objects from now on.
  void show(const DocumentObjects& objects);

  // Returns whether the picture shows strokes that the CPU has not applied.
  bool is_ahead() const { return !strokes_.empty(); }

  // Returns the point at which a ray hits the shape in the picture. Reads about a kilobyte back.
  std::optional<SurfaceHit> hit(const Ray& ray);

  // Returns the volume of the shape in the picture, which is closed. Reads 8 bytes back.
  double volume();

  // Returns the vertices of the picture. Reads them back.
  std::vector<Vec3d> positions();

  gpu::Transfers transfers() const { return gpu_.transfers(); }

 private:
  void upload(const ShapeState& state);
  bool take_state(const ShapeState& state);
  bool apply(std::span<const SessionStroke> strokes, double diagonal);
  bool take_back();
  void forget_strokes();
  void check_strokes();
  void extend_reach(const Flow& flow);
  void write(const Snapshot& positions, const IndexRange& range);
  const gpu::GpuSurface& surface();
  Box state_box() const;

  gpu::Gpu gpu_;
  ShapeState state_;                        // of the CPU
  std::optional<gpu::GpuPoints> start_;     // its positions
  std::optional<gpu::GpuPoints> points_;    // the same, moved by strokes_: the picture's
  std::optional<gpu::GpuSurface> surface_;  // from when it is first needed
  std::vector<SessionStroke> strokes_;
  std::vector<Box> boxes_;  // of the positions of state_, for each chunk of the snapshot
  Box reach_;               // of the tools of strokes_
  double distance_ = 0;     // that these move
  DocumentObjects objects_;
  bool has_view_ = false;
};

// The shape that the live view shows: sent from the CPU, or moved on the GPU.
class ShownShape {
 public:
  // Shows only visible objects from now on.
  void show(const DocumentObjects& objects);

  // Updates the view; without a GPU it sends the changes of `state` only. The arguments are those of
  // GpuPreview::follow. Returns whether anything has changed since the last call. Throws as GpuPreview.
  bool follow(const ShapeState& state, const PendingStrokes* pending, double diagonal, render::LiveView& view);

  // Throws as GpuPreview; the CPU then remains in use.
  void use_gpu(const gpu::GpuOptions& options = {}) {
    gpu_.emplace(options);
    gpu_->show(objects_);
  }
  void use_cpu();
  GpuPreview* gpu() { return gpu_ ? &*gpu_ : nullptr; }  // null: the CPU is in use
  const GpuPreview* gpu() const { return gpu_ ? &*gpu_ : nullptr; }

  // Returns how many vertices were moved by the last call of follow() that returned true and used the CPU.
  std::size_t touched() const { return touched_; }

 private:
  bool send(const ShapeState& state, render::LiveView& view);

  std::optional<GpuPreview> gpu_;
  DocumentObjects objects_;
  ShapeState state_;              // that was sent
  std::vector<Vec3d> positions_;  // the same
  std::size_t touched_ = 0;
};

// The fineness of a picture: with smooth edges, one sample per pixel, or one per 2 x 2 pixels.
enum class Fineness { smooth, plain, coarse };

void set_fineness(render::LiveScene& scene, Fineness fineness);

// Chooses the fineness of a moving scene, so that pictures follow each other quickly. A scene at rest is smooth.
class PictureQuality {
 public:
  explicit PictureQuality(bool draws_in_software = false)
      : moving_(draws_in_software ? Fineness::plain : Fineness::smooth) {}

  Fineness fineness(bool is_still) const { return is_still ? Fineness::smooth : moving_; }

  // Notes the time from the start of a new picture until the next one can begin. Moving pictures become coarser while
  // they are slow, and finer again after a number of fast ones. That number doubles if they were too slow soon after
  // they became finer.
  void note(double seconds, Fineness fineness);

 private:
  void become(Fineness fineness);

  Fineness moving_;
  int pictures_ = 0;  // since it changed
  int slow_ = 0;      // pictures in a row
  double slow_seconds_ = 0;
  int fast_ = 0;     // pictures in a row
  int needed_ = 15;  // fast pictures, to become finer
};

}  // namespace knead::studio
