#include "knead/render/live_passes.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "knead/math/error.h"
#include "knead/render/drawing.h"

namespace knead::render {
namespace {

constexpr double kLineWidth = 1.3;  // in pixels, to either side, of the line where glass meets a shape
constexpr Color kBackColor{0.50f, 0.56f, 0.64f, 1};

void use_live(const gl::Program& program, const LiveFrame& frame) {
  use(program, frame.view, frame.width, frame.height);
  const CameraFrame& axes = frame.view.frame;
  set_simple_light(program, frame.view);
  set(program, "fill", normalized(axes.right * 0.9 - axes.up * 0.1 - axes.forward * 0.35));
  set(program, "influence", frame.scene.show_stretch ? 2.0 : frame.scene.show_influence ? 1.0 : 0.0);
  for (std::size_t i = 0; i < kStretchColors.size(); ++i) {
    set(program, ("stretch[" + std::to_string(i) + "]").c_str(), kStretchColors[i]);
  }
}

void use_live_clipped(const gl::Program& program, const LiveFrame& frame) {
  use_live(program, frame);
  if (!frame.cut) return;
  const Vec3f normal(frame.cut->normal);
  glUniform4f(uniform(program, "clip"), normal.x, normal.y, normal.z, static_cast<float>(frame.cut->offset));
  gl::set_clipping(true);
}

void blend_premultiplied() {
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
}

// Without a GPU half of a picture's time goes into the backs of faces, which of a solid seen from outside
// are all hidden.
bool only_fronts_show(const LiveFrame& frame, const LiveShape& shape) {
  const Box& box = shape.box;
  const Vec3d& eye = frame.view.eye;
  const bool within = eye.x >= box.min.x && eye.y >= box.min.y && eye.z >= box.min.z && eye.x <= box.max.x &&
                      eye.y <= box.max.y && eye.z <= box.max.z;
  return frame.programs.in_software && shape.mesh.is_solid() && !frame.cut && !within;
}

void draw_faces(const LiveFrame& frame, const LiveShape& shape) {
  const gl::Program& program = frame.programs.shape.at(static_cast<std::size_t>(frame.scene.material));
  use_live_clipped(program, frame);
  if (frame.matcap != nullptr) {
    bind_texture(program, "ball", 0, GL_TEXTURE_2D, *frame.matcap);
    set(program, "plain_srgb", kClay);
  }
  set(program, "back_srgb", kBackColor);
  if (frame.scene.wireframe) {
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.0f, 1.0f);
  }
  if (only_fronts_show(frame, shape)) {
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
  }
  draw_triangles(shape.buffers);
  glDisable(GL_CULL_FACE);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

void draw_wires(const LiveFrame& frame, const LiveShape& shape) {
  const gl::Program& program = frame.programs.wire;
  use_live_clipped(program, frame);
  set(program, "edge_samples", shape.mesh.mean_edge() / frame.view.pixel);
  gl::draw_into_one();
  blend_premultiplied();
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_LEQUAL);
  draw_edges(shape.buffers);
  if (frame.has_normals) gl::draw_into_two();
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

void draw_cloud(const LiveFrame& frame, const LiveShape& shape) {
  const gl::Program& program = frame.programs.cloud;
  use_live_clipped(program, frame);
  const auto count = static_cast<double>(std::max(1, shape.buffers.vertex_count));
  const double radius = std::clamp(0.9 / std::sqrt(count), 0.003, 0.04);
  set(program, "point_size", 2 * radius / frame.view.pixel);
  draw_points(shape.buffers);
}

// Counts, for every sample, how many more backs than fronts are left behind the cut: where that is not zero, the ray
// went in through the cut.
void count_openings(const LiveFrame& frame, const LiveShape& shape) {
  use_live_clipped(frame.programs.depth, frame);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_ALWAYS);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, 0, 0xff);
  glStencilOpSeparate(GL_BACK, GL_KEEP, GL_KEEP, GL_INCR_WRAP);
  glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_KEEP, GL_DECR_WRAP);
  draw_triangles(shape.buffers);
  glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl::set_clipping(false);
}

void draw_cut_face(const LiveFrame& frame) {
  const LiveCut& cut = *frame.cut;
  const gl::Program& program = frame.programs.cut;
  use_live(program, frame);
  const Vec3d& center = frame.bounds.center;
  const Vec3d across = any_orthogonal(cut.normal);
  set(program, "middle", center + cut.normal * (cut.offset - dot(cut.normal, center)));
  set(program, "across", across * (1.1 * frame.bounds.radius));
  set(program, "along", cross(cut.normal, across) * (1.1 * frame.bounds.radius));
  set(program, "cut_normal", cut.normal);
  set(program, "cut_srgb", cut.color);
  glStencilFunc(GL_NOTEQUAL, 0, 0xff);
  glBindVertexArray(frame.programs.nothing.get());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDisable(GL_STENCIL_TEST);
}

}  // namespace

std::optional<LiveCut> live_cut(const LiveScene& scene, const Placement& placement) {
  if (!scene.clip) return std::nullopt;
  const Clip& clip = *scene.clip;
  const double length = norm(clip.normal);
  if (!(length > 0) || !std::isfinite(length)) {
    throw InvalidInput("live view: the clipping plane has no normal; give one that is not zero");
  }
  const double offset = (clip.offset - dot(clip.normal, placement.center)) * placement.scale / length;
  return LiveCut{clip.normal / length, offset, clip.color};
}

void begin_live_picture(const LiveFrame& frame, const LiveTargets& targets) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.many.get());
  reset_state(frame.width, frame.height);
  glDisable(GL_STENCIL_TEST);
  gl::write_colors_as_they_are();
  glEnable(GL_DEPTH_TEST);
  const Color& back = frame.scene.background_top;
  glClearStencil(0);
  gl::clear_depth_to(1);
  glClearColor(back.red, back.green, back.blue, 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  if (!targets.size.relief) return;
  constexpr std::array<float, 4> none{0, 0, 0, 0};
  gl::draw_into_two();
  glClearBufferfv(GL_COLOR, 1, none.data());
}

void draw_live_shape(const LiveFrame& frame, const LiveShape& shape) {
  if (shape.mesh.is_cloud()) {
    draw_cloud(frame, shape);
  } else {
    draw_faces(frame, shape);
    if (frame.cut) {
      count_openings(frame, shape);
      draw_cut_face(frame);
    }
    if (frame.scene.wireframe) draw_wires(frame, shape);
  }
  gl::set_clipping(false);
}

void draw_live_background(const LiveFrame& frame) {
  if (frame.scene.background_top == frame.scene.background_bottom) return;
  const gl::Program& program = frame.programs.background;
  use_live(program, frame);
  set(program, "top_srgb", frame.scene.background_top);
  set(program, "bottom_srgb", frame.scene.background_bottom);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_FALSE);
  glBindVertexArray(frame.programs.nothing.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

void draw_live_images(const LiveFrame& frame, std::span<const LiveImage> images) {
  if (images.empty()) return;
  const gl::Program& program = frame.programs.image;
  use_live(program, frame);
  const Placement& placement = frame.view.placement;
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_FALSE);
  blend_premultiplied();
  glBindVertexArray(frame.programs.nothing.get());
  for (const LiveImage& image : images) {
    bind_texture(program, "image", 0, GL_TEXTURE_2D, image.texture);
    set(program, "center", placement.apply(image.placed.center));
    set(program, "right_half", image.placed.right * placement.scale);
    set(program, "up_half", image.placed.up * placement.scale);
    set(program, "opacity", image.placed.opacity);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

void draw_live_rods(const LiveFrame& frame, const LiveBuffers& rods) {
  if (rods.triangle_indices == 0) return;
  const gl::Program& program = frame.programs.rod;
  use_live(program, frame);
  glEnable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  // What is hidden, once in each sample.
  glClear(GL_STENCIL_BUFFER_BIT);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_EQUAL, 0, 0xff);
  glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  blend_premultiplied();
  set(program, "opacity", 0.35);
  draw_triangles(rods);
  glDisable(GL_BLEND);
  glDisable(GL_STENCIL_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  set(program, "opacity", 1.0);
  draw_triangles(rods);
  glDisable(GL_CULL_FACE);
}

void draw_live_glass(const LiveFrame& frame, std::span<const LiveGlass> surfaces, const gl::Texture& depths) {
  struct Side {
    const LiveGlass* glass;
    GLenum hidden;
    double distance;
  };
  std::vector<Side> sides;
  for (const LiveGlass& glass : surfaces) {
    sides.push_back({&glass, GL_FRONT, glass.far});
    sides.push_back({&glass, GL_BACK, glass.near});
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.distance > b.distance; });
  const gl::Program& program = frame.programs.glass;
  use_live(program, frame);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, depths);
  set(program, "pixel_size", frame.view.pixel);
  set(program, "line_width", kLineWidth);
  blend_premultiplied();
  glDepthMask(GL_FALSE);
  glEnable(GL_CULL_FACE);
  for (const Side& side : sides) {
    set_with_alpha(program, "glass", side.glass->color);
    glCullFace(side.hidden);
    draw_triangles(side.glass->buffers);
  }
  glDisable(GL_CULL_FACE);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

void present_live(const LivePrograms& programs, const LiveTargets& targets) {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glViewport(0, 0, targets.size.width, targets.size.height);
  glUseProgram(programs.present.get());
  bind_texture(programs.present, "picture", 0, GL_TEXTURE_2D, targets.one_color);
  glBindVertexArray(programs.nothing.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace knead::render
