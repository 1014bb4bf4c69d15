// Cavity and occlusion of the interactive picture, over the shape that is drawn.
#pragma once

#include "knead/render/live_passes.h"

namespace knead::render {

struct LiveReliefPrograms {
  gl::Program occlusion;
  gl::Program smooth;
  gl::Program relief;

  LiveReliefPrograms();
};

// Darkens and brightens the shape by LiveScene::relief. The shape was drawn into targets that were made for relief;
// what is drawn later has no normals any more.
void draw_live_relief(const LiveFrame& frame, const LiveTargets& targets, const LiveReliefPrograms& programs);

}  // namespace knead::render
