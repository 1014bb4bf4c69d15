// Keeps the shape on the graphics card the one that Studio shows, and moves it there while a hand does.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/gpu/gpu.h"
#include "knead/gpu/gpu_surface.h"
#include "knead/render/live_view.h"
#include "studio.h"

namespace knead::studio {

// What hands do is seen as the card does it, at once; the worker does the same on the CPU, and what comes of that is
// the shape: when the worker has caught up, the card is given the CPU's positions to the bit. Nothing is read back for
// a picture; once a gesture, at its end, how the card fared. Strokes that read the surface are seen as the worker gets
// on.
//
// All throws GpuError or std::runtime_error, one line, where the card fails; then it is to be left, and
// DrawnShape shows the same.
class CardShape {
 public:
  // In the OpenGL context that is current, which has to be at every call, and when this is destroyed.
  explicit CardShape(const gpu::GpuOptions& options = {});

  const std::string& description() const { return device_.description(); }
  bool is_software() const { return device_.is_software(); }  // no card, but Mesa's stand-in for one

  // Gives the view what it is to show. pending as Studio's; diagonal: of the shape as it was opened. Returns whether
  // anything has changed since the last call.
  bool follow(const ShapeState& state, const PendingStrokes* pending, double diagonal, render::LiveView& view);

  // The next call of follow gives the view all, as a new one needs.
  void forget_view() { has_view_ = false; }

  // Whether what is seen is ahead of the CPU.
  bool is_ahead() const { return !done_.empty(); }

  // What a ray hits of the shape as it is seen. Reads about a kilobyte back.
  std::optional<SurfaceHit> hit(const Ray& ray);

  // The volume within the shape as it is seen; of a closed one. Reads 8 bytes back.
  double volume();

  // Where the vertices are seen. Reads them back.
  std::vector<Vec3d> positions();

  gpu::Transfers transfers() const { return device_.transfers(); }

 private:
  void take_shape(const ShapeState& state);
  bool rest_at(const ShapeState& state);
  bool go_ahead(std::span<const SessionStroke> strokes, double diagonal);
  bool come_back();
  void forget_work();
  void check_work();
  void reach_with(const Flow& flow);
  void write(const Snapshot& positions, const IndexRange& range);
  const gpu::GpuSurface& surface();
  Box resting_box() const;
  Box box() const;

  gpu::Gpu device_;
  ShapeState at_;  // whose positions rest_ has
  std::optional<gpu::GpuPoints> rest_;
  std::optional<gpu::GpuPoints> points_;    // what is seen: these, moved by done_
  std::optional<gpu::GpuSurface> surface_;  // from when it is first asked for
  std::vector<SessionStroke> done_;
  std::vector<Box> boxes_;  // of the resting vertices, for each chunk of the snapshot
  Box reached_;             // by the tools of done_
  double way_ = 0;          // of these
  bool has_view_ = false;
};

}  // namespace knead::studio
