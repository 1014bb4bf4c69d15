// OpenGL's functions: of the system, or of a page (WebGL 2, which is OpenGL ES 3.0). What is drawn on a page uses only
// what both have; the functions here do what each has in its own way. Internal to the rooms gl, gpu and render.
#pragma once

#if defined(__EMSCRIPTEN__)
#include <GLES3/gl3.h>
#else
#include <epoxy/gl.h>
#endif

namespace knead::gl {

#if defined(__EMSCRIPTEN__)

// Shaders take away what is clipped, and points always have the size that a shader gives them.
inline void set_clipping(bool) {}
inline void let_shaders_size_points() {}
inline void write_colors_as_they_are() {}
inline void clear_depth_to(float depth) { glClearDepthf(depth); }
inline void attach(GLenum place, GLuint texture) {
  glFramebufferTexture2D(GL_FRAMEBUFFER, place, GL_TEXTURE_2D, texture, 0);
}
inline bool was_reset() { return false; }

#else

inline void set_clipping(bool on) { on ? glEnable(GL_CLIP_DISTANCE0) : glDisable(GL_CLIP_DISTANCE0); }
inline void let_shaders_size_points() { glEnable(GL_PROGRAM_POINT_SIZE); }
inline void write_colors_as_they_are() { glDisable(GL_FRAMEBUFFER_SRGB); }
inline void clear_depth_to(float depth) { glClearDepth(depth); }
inline void attach(GLenum place, GLuint texture) { glFramebufferTexture(GL_FRAMEBUFFER, place, texture, 0); }
inline bool was_reset() { return glGetGraphicsResetStatus() != GL_NO_ERROR; }

#endif

// Draws into the first colour of the bound framebuffer; into the first two.
inline void draw_into_one() {
  const GLenum first = GL_COLOR_ATTACHMENT0;
  glDrawBuffers(1, &first);
}
inline void draw_into_two() {
  const GLenum both[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glDrawBuffers(2, both);
}

}  // namespace knead::gl
