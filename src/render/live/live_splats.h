// Gaussian splats in the live view: their data on the GPU, and their order from far to near. Internal to render.
#pragma once

#include <array>
#include <cstdint>
#include <future>
#include <memory>
#include <utility>
#include <vector>

#include "gl/objects.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "render/live/live.h"
#include "render/surface.h"

namespace knead::render {

inline constexpr std::uint32_t kSplatRow = 1024;  // splats in a row of a texture
inline constexpr std::uint32_t kQuickSplats = 100'000;
inline constexpr double kBrightestSplat = 2;  // colours are stored as bytes of this

// The numbers of splats that give their colours.
struct SplatColors {
  std::size_t harmonics = 0;   // of a channel
  std::vector<float> numbers;  // of each splat: 3 bases, then the harmonics of red, of green, of blue
  std::vector<std::uint8_t> opacities;
};

// The rotations of the splats that are turned, from directions now to those before; the splats ascend.
using SplatTurns = std::vector<std::pair<std::uint32_t, Mat3d>>;

// From where splats are seen, in renderer units.
struct SplatView {
  Vec3d eye;
  Vec3d forward;
  bool is_perspective = false;

  friend bool operator==(const SplatView&, const SplatView&) = default;
};

// Sorts splats from far to near, and finds the colours that they have from the eye, in steps of some milliseconds.
// The order: by the depth as a 32-bit key, in two passes of a counting sort; stable.
class SplatSorter {
 public:
  SplatSorter(std::shared_ptr<const SplatColors> colors, std::shared_ptr<const SplatTurns> turns,
              std::vector<Vec3f> places, const SplatView& view);

  // Returns true if everything is done.
  bool step();

  const std::vector<std::uint32_t>& order() const { return order_; }
  const std::vector<Bytes4>& colors() const { return seen_colors_; }

 private:
  void see(std::size_t splat);
  Vec3d direction_to(std::size_t splat);

  std::shared_ptr<const SplatColors> colors_;
  std::shared_ptr<const SplatTurns> turns_;
  std::size_t next_turn_ = 0;
  std::vector<Vec3f> places_;
  SplatView view_;
  std::vector<std::uint32_t> keys_;
  std::array<std::vector<std::uint32_t>, 2> begins_;  // by the lower and the upper half of the key
  std::vector<std::uint32_t> half_sorted_;
  std::vector<std::uint32_t> order_;
  std::vector<Bytes4> seen_colors_;
  int pass_ = 0;
  std::size_t at_ = 0;  // in the pass
};

// The splats of a LiveMesh; `splat` is the number of a drawn vertex.
class LiveSplats {
 public:
  // Returns whether the driver has textures for so many splats.
  static bool have_room(std::size_t count);

  // mesh: of splats. scale: from its units to renderer units. buffers: of `drawn`. Throws InvalidInput as
  // splat_degree().
  LiveSplats(const Mesh& mesh, const LiveMesh& drawn, double scale, const LiveBuffers& buffers);

  std::uint32_t count() const { return count_; }

  // Shows the splats as these Jacobians have changed them from the start; null: not at all.
  void deform(const SplatJacobians* jacobians, const LiveMesh& drawn);

  // Take what has changed in the buffers.
  void take_places(const LiveBuffers& buffers, const VertexRange& drawn);
  void take_tints(const LiveBuffers& buffers, const VertexRange& drawn);

  // Takes the order that has been made since, and lets the next one be made if the splats or the view have changed.
  // `is_exact`: waits for the order of this view. The first time it always waits.
  void sort_for(const SplatView& view, const LiveMesh& drawn, bool is_exact);

  // Return whether an order is being made, and whether sort_for() would get on with it.
  bool is_sorting() const { return sorter_ != nullptr; }
  bool has_news() const;

  // Draws the splats by the program, which is in use; `is_quick`: at most about kQuickSplats of them, larger.
  void draw(const gl::Program& program, bool is_quick) const;

 private:
  bool advance();
  void start(const SplatView& view, const LiveMesh& drawn);
  void finish();

  std::uint32_t count_ = 0;
  std::shared_ptr<const SplatColors> colors_;
  std::shared_ptr<const SplatTurns> turns_ = std::make_shared<const SplatTurns>();
  std::vector<std::array<Vec3f, 2>> covariances_;  // at the start: xx xy xz, yy yz zz
  double scale_ = 1;
  gl::Texture place_map_;  // two texels a splat, as the buffer of vertices has them
  gl::Texture shape_map_;  // the same of the covariances
  gl::Texture color_map_;  // red, green, blue, opacity
  gl::Texture tint_map_;   // as LiveBuffers::colors
  gl::Texture order_map_;
  gl::Texture quick_order_map_;  // of every quick_step_th splat
  std::uint32_t quick_step_ = 1;
  gl::VertexArray layout_;
  gl::Buffer corners_;    // of the quads of one row
  SplatView view_;        // of the sorter that was started last
  bool is_stale_ = true;  // splats have changed since
  bool has_order_ = false;
  std::unique_ptr<SplatSorter> sorter_;  // at work
  std::future<void> work_;               // on its thread, if there are threads
};

// Draws splats over what is there, which they do not hide by depth. `has_depth`: what is drawn later is hidden by them
// where one of them alone covers more than half.
// The other argument: see LiveSplats::draw.
void draw_live_splats(const LiveFrame& frame, const LiveSplats& splats, bool has_depth, bool is_quick);

}  // namespace knead::render
