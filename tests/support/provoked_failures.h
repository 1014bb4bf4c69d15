// For tests: makes a GPU fail. epoxy, the library that finds OpenGL's functions, calls them through pointers, which are
// replaced here.
#pragma once

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "support/memory_limit.h"

namespace knead::gpu {

using test::lift_memory_limit;
using test::limit_memory;

// Ends the display, truly, before the n-th call from now on that makes a context of it current. What was in it is lost.
inline void lose_display_at_call(int n) {
  static int left = 0;
  static const auto real = reinterpret_cast<PFNEGLMAKECURRENTPROC>(eglGetProcAddress("eglMakeCurrent"));
  left = n;
  epoxy_eglMakeCurrent = [](EGLDisplay display, EGLSurface draw, EGLSurface read, EGLContext context) -> EGLBoolean {
    if (context != EGL_NO_CONTEXT && --left == 0) eglTerminate(display);
    return real(display, draw, read, context);
  };
}

// There is no memory, truly, for buffers of so many bytes and more. On a driver that runs on the CPU.
inline void starve_buffers(GLsizeiptr bytes) {
  static GLsizeiptr least = 0;
  static const auto data_of = reinterpret_cast<PFNGLBUFFERDATAPROC>(eglGetProcAddress("glBufferData"));
  static const auto storage_of = reinterpret_cast<PFNGLBUFFERSTORAGEPROC>(eglGetProcAddress("glBufferStorage"));
  least = bytes;
  epoxy_glBufferData = [](GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
    if (size >= least) limit_memory(1 << 20);
    data_of(target, size, data, usage);
    if (size >= least) lift_memory_limit();
  };
  epoxy_glBufferStorage = [](GLenum target, GLsizeiptr size, const void* data, GLbitfield flags) {
    if (size >= least) limit_memory(1 << 20);
    storage_of(target, size, data, flags);
    if (size >= least) lift_memory_limit();
  };
}

// From the n-th time that it is asked, from now on, the driver says that the GPU was reset. No driver that runs on the
// CPU ever is, so this one is only said.
inline void report_reset_at_call(int n) {
  static int left = 0;
  left = n;
  epoxy_glGetGraphicsResetStatus = []() -> GLenum { return --left > 0 ? GL_NO_ERROR : GL_GUILTY_CONTEXT_RESET; };
}

// As if nothing of this had been.
inline void provoke_nothing() {
  lift_memory_limit();
  lose_display_at_call(0);
  starve_buffers(GLsizeiptr{1} << 60);
  epoxy_glGetGraphicsResetStatus =
      reinterpret_cast<PFNGLGETGRAPHICSRESETSTATUSPROC>(eglGetProcAddress("glGetGraphicsResetStatus"));
}

}  // namespace knead::gpu
