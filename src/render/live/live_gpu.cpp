// The buffers, programs, textures and framebuffers of the live view.
#include <algorithm>
#include <cstddef>
#include <string>

#include "knead/editor/gl.h"
#include "knead/error.h"
#include "render/live/live.h"
#include "render/surface.h"

namespace knead::render {
namespace {

constexpr int kMatcapSize = 256;

void describe_floats(GLuint location, std::size_t offset) {
  const auto* start = reinterpret_cast<const void*>(offset);  // NOLINT(performance-no-int-to-ptr): as OpenGL takes it
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, sizeof(LiveVertex), start);
}

gl::Buffer make_indices(std::span<const std::uint32_t> indices) {
  return gl::make_buffer(GL_ELEMENT_ARRAY_BUFFER, indices.data(), indices.size_bytes());
}

LiveBuffers make_buffers(std::span<const LiveVertex> vertices, std::span<const Bytes4> colors,
                         std::span<const std::uint32_t> triangles, std::span<const std::uint32_t> edges) {
  LiveBuffers buffers;
  buffers.layout = gl::make_vertex_array();
  buffers.vertices = gl::make_buffer(GL_ARRAY_BUFFER, vertices.data(), vertices.size_bytes());
  describe_floats(0, offsetof(LiveVertex, position));
  describe_floats(1, offsetof(LiveVertex, normal));
  if (!colors.empty()) {
    buffers.colors = gl::make_buffer(GL_ARRAY_BUFFER, colors.data(), colors.size_bytes());
    glEnableVertexAttribArray(2);
    glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(Bytes4), nullptr);
  }
  buffers.edges = make_indices(edges);
  buffers.triangles = make_indices(triangles);
  buffers.vertex_count = static_cast<GLsizei>(vertices.size());
  buffers.triangle_indices = static_cast<GLsizei>(triangles.size());
  buffers.edge_indices = static_cast<GLsizei>(edges.size());
  return buffers;
}

gl::Renderbuffer make_renderbuffer(int width, int height, int samples, GLenum format) {
  GLuint name = 0;
  glGenRenderbuffers(1, &name);
  gl::Renderbuffer buffer(name);
  glBindRenderbuffer(GL_RENDERBUFFER, name);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, width, height);
  return buffer;
}

gl::Texture make_depth_texture(int width, int height) {
  GLuint name = 0;
  glGenTextures(1, &name);
  gl::Texture texture(name);
  glBindTexture(GL_TEXTURE_2D, name);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH24_STENCIL8, width, height, 0, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8,
               nullptr);
  return texture;
}

void require_complete() {
  if (glGetError() != GL_OUT_OF_MEMORY && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return;
  throw InvalidInput("live view: the graphics driver has no room for a picture of this size; make the window smaller");
}

GLint limit(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

// Adds the normals to the bound framebuffer, and binds it again.
LiveReliefTargets make_relief_targets(int width, int height, int samples) {
  GLint many = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &many);
  LiveReliefTargets targets;
  targets.normal = gl::make_texture(width, height, GL_RGBA16F);
  if (samples == 1) {
    gl::attach(GL_COLOR_ATTACHMENT1, targets.normal.get());
  } else {
    targets.normal_of_many = make_renderbuffer(width, height, samples, GL_RGBA16F);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_RENDERBUFFER, targets.normal_of_many.get());
    targets.gathered = gl::make_framebuffer({&targets.normal}, nullptr);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    targets.occlusion[i] = gl::make_texture((width + 1) / 2, (height + 1) / 2, GL_RGBA8);
    targets.occlusion_target[i] = gl::make_framebuffer({&targets.occlusion[i]}, nullptr);
  }
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(many));
  return targets;
}

void copy(const LiveRect& r, GLbitfield what) {
  glBlitFramebuffer(r.left, r.bottom, r.right, r.top, r.left, r.bottom, r.right, r.top, what, GL_NEAREST);
}

}  // namespace

LivePrograms::LivePrograms()
    : shape{compile(live_shape_source(Material::clay)), compile(live_shape_source(Material::matcap)),
            compile(live_shape_source(Material::flat))},
      cloud(compile(live_cloud_source())),
      splat(compile(live_splat_source())),
      wire(compile(live_wire_source())),
      depth(compile(live_depth_source())),
      cut(compile(live_cut_source())),
      background(compile(live_background_source())),
      image(compile(live_image_source())),
      rod(compile(live_rod_source())),
      glass(compile(live_glass_source())),
      nothing(gl::make_vertex_array()),
      in_software(gl::is_software()) {}

LiveBuffers make_live_buffers(const LiveMesh& mesh, std::span<const Bytes4> colors) {
  return make_buffers(mesh.vertices(), colors, mesh.triangles(), mesh.edges());
}

LiveBuffers make_live_buffers(const DrawSurface& surface) {
  std::vector<LiveVertex> vertices;
  std::vector<Bytes4> colors;
  for (const DrawVertex& v : surface.vertices) {
    vertices.push_back({v.position, v.normal});
    colors.push_back(v.color);
  }
  return make_buffers(vertices, colors, surface.indices, {});
}

UploadCounts update(const LiveBuffers& buffers, const LiveMesh& mesh, std::span<const VertexRange> drawn) {
  UploadCounts counts;
  const std::vector<LiveVertex>& vertices = mesh.vertices();
  glBindBuffer(GL_ARRAY_BUFFER, buffers.vertices.get());
  for (const VertexRange& range : drawn) {
    const std::size_t bytes = (range.end - range.begin) * sizeof(LiveVertex);
    // Uses fresh memory for all vertices, so that the GPU may still draw from the old.
    if (bytes == vertices.size() * sizeof(LiveVertex)) {
      glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), vertices.data(), GL_STREAM_DRAW);
    } else {
      glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(range.begin * sizeof(LiveVertex)),
                      static_cast<GLsizeiptr>(bytes), vertices.data() + range.begin);
    }
    counts.bytes += bytes;
    ++counts.ranges;
  }
  return counts;
}

void update_colors(const LiveBuffers& buffers, std::span<const Bytes4> colors, const VertexRange& drawn) {
  if (drawn.begin >= drawn.end) return;
  glBindBuffer(GL_ARRAY_BUFFER, buffers.colors.get());
  glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(drawn.begin * sizeof(Bytes4)),
                  static_cast<GLsizeiptr>((drawn.end - drawn.begin) * sizeof(Bytes4)), colors.data() + drawn.begin);
}

void draw_triangles(const LiveBuffers& buffers) {
  if (buffers.triangle_indices == 0) return;
  glBindVertexArray(buffers.layout.get());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers.triangles.get());
  glDrawElements(GL_TRIANGLES, buffers.triangle_indices, GL_UNSIGNED_INT, nullptr);
}

void draw_triangles(const LiveBuffers& buffers, std::span<const IndexSpan> spans) {
  glBindVertexArray(buffers.layout.get());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers.triangles.get());
  for (const IndexSpan& span : spans) {
    const std::uintptr_t offset = sizeof(std::uint32_t) * static_cast<std::uintptr_t>(span.first);
    const auto* start = reinterpret_cast<const void*>(offset);  // NOLINT(performance-no-int-to-ptr): as OpenGL takes it
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(span.count), GL_UNSIGNED_INT, start);
  }
}

void draw_edges(const LiveBuffers& buffers) {
  if (buffers.edge_indices == 0) return;
  glBindVertexArray(buffers.layout.get());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers.edges.get());
  glDrawElements(GL_LINES, buffers.edge_indices, GL_UNSIGNED_INT, nullptr);
}

void draw_points(const LiveBuffers& buffers) {
  if (buffers.vertex_count == 0) return;
  glBindVertexArray(buffers.layout.get());
  glDrawArrays(GL_POINTS, 0, buffers.vertex_count);
}

LiveTargets make_live_targets(const LiveTargetSize& size) {
  const auto [width, height, samples, relief] = size;
  if (std::max(width, height) > std::min(limit(GL_MAX_RENDERBUFFER_SIZE), limit(GL_MAX_TEXTURE_SIZE))) {
    throw InvalidInput("live view: a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                       " pixels is larger than the graphics driver allows; make the window smaller");
  }
  LiveTargets targets;
  targets.size = size;
  const int most = std::clamp(samples, 1, std::max(1, limit(GL_MAX_SAMPLES)));
  targets.is_single = most == 1;
  targets.one_color = gl::make_texture(width, height, GL_RGBA8);
  targets.depth = make_renderbuffer(width, height, most, GL_DEPTH24_STENCIL8);
  targets.many = gl::make_framebuffer({}, nullptr);
  if (targets.is_single) {
    gl::attach(GL_COLOR_ATTACHMENT0, targets.one_color.get());
  } else {
    targets.color = make_renderbuffer(width, height, most, GL_RGBA8);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, targets.color.get());
  }
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, targets.depth.get());
  gl::draw_into_one();
  if (relief) targets.relief = make_relief_targets(width, height, most);
  require_complete();
  if (relief && targets.is_single) targets.relief.shaded = gl::make_framebuffer({&targets.one_color}, nullptr);
  targets.one_depth = make_depth_texture(width, height);
  targets.one = gl::make_framebuffer({&targets.one_color}, nullptr);
  gl::attach(GL_DEPTH_STENCIL_ATTACHMENT, targets.one_depth.get());
  require_complete();
  return targets;
}

gl::Texture make_image_texture(const Image& image) {
  if (std::max(image.width, image.height) > limit(GL_MAX_TEXTURE_SIZE)) {
    throw InvalidInput("live view: an image is larger than the graphics driver allows; make it smaller");
  }
  GLuint name = 0;
  glGenTextures(1, &name);
  gl::Texture texture(name);
  glBindTexture(GL_TEXTURE_2D, name);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               image.pixels.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glGenerateMipmap(GL_TEXTURE_2D);
  return texture;
}

gl::Texture make_matcap_texture(Matcap matcap) {
  gl::Texture texture = gl::make_texture(kMatcapSize, kMatcapSize, GL_RGBA8);
  const std::vector<Bytes4> picture = matcap_picture(matcap, kMatcapSize);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kMatcapSize, kMatcapSize, GL_RGBA, GL_UNSIGNED_BYTE, picture.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

void gather(const LiveTargets& targets, const LiveRect& rect, GLbitfield what) {
  if (targets.is_single && what == GL_COLOR_BUFFER_BIT) return;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.many.get());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.one.get());
  copy(rect, what);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.many.get());
}

void gather_normals(const LiveTargets& targets, const LiveRect& rect) {
  if (targets.is_single) return;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.many.get());
  glReadBuffer(GL_COLOR_ATTACHMENT1);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.relief.gathered.get());
  copy(rect, GL_COLOR_BUFFER_BIT);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.many.get());
}

}  // namespace knead::render
