// What is seen besides the shape: the tool's region, the gizmo, what is placed, the cut; and the influence as colour.
#pragma once

#include <optional>
#include <vector>

#include "knead/render.h"
#include "studio.h"
#include "view/cursor.h"

namespace knead::studio {

// Remembers what it drew, so that nothing is made anew while nothing changes.
class Overlay {
 public:
  // The scene for the live view as Studio is at the moment.
  render::LiveScene scene(const Studio& studio);

  // The influence or the stretch to be shown; nothing where it is what was returned last. Empty: none.
  std::optional<std::vector<float>> influence(const Studio& studio);

  // How dark the mask makes each vertex, from 0 to 1; nothing where it is what was returned last.
  std::optional<std::vector<float>> mask(const Studio& studio);
  // Returns whether the stretch that the view asks for is known.
  bool knows_stretch() const { return knows_stretch_; }

  // Why a tool that turns cannot be used where it is placed; empty: it can.
  static std::string placement_problem(const Studio& studio);

 private:
  std::optional<std::vector<float>> stretch(const Studio& studio);
  std::optional<std::vector<float>> parts(const Studio& studio);

  std::vector<Stroke> drawn_;  // strokes whose regions are in parts_
  render::Scene parts_;
  render::SurfaceCache surfaces_;
  SurfaceCursor cursor_;
  std::vector<Stroke> influencing_;
  std::uint64_t influenced_version_ = 0;
  bool has_influence_ = false;
  std::uint64_t mask_version_ = 0;
  std::shared_ptr<const Mesh> mask_mesh_;
  Mask mask_;
  bool was_masking_ = false;
  bool has_mask_ = false;
  std::vector<float> part_shades_;
  std::shared_ptr<const Mesh> part_mesh_;
  StretchView stretched_ = StretchView::off;  // what has_influence_ is about, if not the tool
  bool knows_stretch_ = false;
};

// The strokes that the tool would begin with where the pointer is, mirror images included; empty where it is nowhere.
std::vector<Stroke> hovering(const Studio& studio);

}  // namespace knead::studio
