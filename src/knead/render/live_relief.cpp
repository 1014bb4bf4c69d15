#include "knead/render/live_relief.h"

#include <algorithm>

#include "knead/render/drawing.h"
#include "knead/render/live_shaders.h"

namespace knead::render {
namespace {

gl::Program compile(const ShaderSource& source) { return gl::make_program(source.vertex, source.fragment); }

void use_relief(const gl::Program& program, const LiveFrame& frame, const LiveTargets& targets) {
  use(program, frame.view, frame.width, frame.height);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, targets.one_depth);
  bind_texture(program, "normal_map", 1, GL_TEXTURE_2D, targets.relief.normal);
  set_relief(program, frame.view, frame.height);
  glBindVertexArray(frame.programs.nothing.get());
}

void draw_occlusion(const LiveFrame& frame, const LiveTargets& targets, const LiveReliefPrograms& programs) {
  reset_state((frame.width + 1) / 2, (frame.height + 1) / 2);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.relief.occlusion_target[0].get());
  use_relief(programs.occlusion, frame, targets);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.relief.occlusion_target[1].get());
  use_relief(programs.smooth, frame, targets);
  bind_texture(programs.smooth, "occlusion_map", 2, GL_TEXTURE_2D, targets.relief.occlusion[0]);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace

LiveReliefPrograms::LiveReliefPrograms()
    : occlusion(compile(live_occlusion_source())),
      smooth(compile(live_smooth_source())),
      relief(compile(live_relief_source())) {}

void draw_live_relief(const LiveFrame& frame, const LiveTargets& targets, const LiveReliefPrograms& programs) {
  const Relief& wanted = frame.scene.relief;
  gather(targets, GL_DEPTH_BUFFER_BIT);
  gather_normals(targets);
  gl::draw_into_one();
  if (wanted.occlusion) draw_occlusion(frame, targets, programs);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.many.get());
  reset_state(frame.width, frame.height);
  const gl::Program& program = programs.relief;
  use_relief(program, frame, targets);
  bind_texture(program, "occlusion_map", 2, GL_TEXTURE_2D, targets.relief.occlusion[1]);
  set(program, "with_cavity", wanted.cavity ? 1.0 : 0.0);
  set(program, "with_occlusion", wanted.occlusion ? 1.0 : 0.0);
  // At the far end of the depth range, so that it changes the samples that the shape covers.
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_DST_COLOR, GL_SRC_COLOR);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

}  // namespace knead::render
