// Small steps that the passes share: uniforms, state, drawing what is on the GPU.
#pragma once

#include "knead/render/passes.h"

namespace knead::render {

void set(const gl::Program& program, const char* name, const Vec3d& v);
void set(const gl::Program& program, const char* name, double x);
void set(const gl::Program& program, const char* name, const Color& c);
void set_with_alpha(const gl::Program& program, const char* name, const Color& c);

// Makes the program current and tells it of the camera; the last also of the clipping plane, if there is one.
void use(const gl::Program& program, const View& view, int width, int height);
void use(const gl::Program& program, const Pass& pass);
void use_clipped(const gl::Program& program, const Pass& pass);

// The light of things that neither cast nor catch shadows.
void set_simple_light(const gl::Program& program, const View& view);
// What the functions of kRelief need besides the maps. samples_high: of the picture.
void set_relief(const gl::Program& program, const View& view, int samples_high);
void set_ground(const gl::Program& program, const Pass& pass, const Occluder& occluder);

void draw(const SurfaceBuffers& surface);
void draw_full_screen(const Pass& pass);

// Everything off, depth test by GL_LESS once it is enabled.
void reset_state(int width, int height);

// The bound framebuffer.
void clear(float red, float green, float blue, float alpha);
void clear_depth();

}  // namespace knead::render
