// The steps of the interactive picture, its relief, and the topology of live meshes.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "render/live/live.h"
#include "render/live/live_splats.h"
#include "render/offline/passes.h"
#include "render/splat_attributes.h"

namespace knead::render {
namespace {

// Resets the state for the frame's part of the picture.
void reset_state(const LiveFrame& frame) {
  render::reset_state(frame.width, frame.height);
  const LiveRect& r = frame.rect;
  glEnable(GL_SCISSOR_TEST);
  glScissor(r.left, r.bottom, r.right - r.left, r.top - r.bottom);
}

void use_relief(const gl::Program& program, const LiveFrame& frame, const LiveTargets& targets) {
  use(program, frame.view, frame.width, frame.height);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, targets.one_depth);
  bind_texture(program, "normal_map", 1, GL_TEXTURE_2D, targets.relief.normal);
  set_relief(program, frame.view, frame.height);
  glBindVertexArray(frame.programs.nothing.get());
}

void draw_occlusion(const LiveFrame& frame, const LiveTargets& targets, const LiveReliefPrograms& programs) {
  render::reset_state((frame.width + 1) / 2, (frame.height + 1) / 2);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.relief.occlusion_target[0].get());
  use_relief(programs.occlusion, frame, targets);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.relief.occlusion_target[1].get());
  use_relief(programs.smooth, frame, targets);
  bind_texture(programs.smooth, "occlusion_map", 2, GL_TEXTURE_2D, targets.relief.occlusion[0]);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

// The vertices after and before a corner.
using Sides = std::pair<std::uint32_t, std::uint32_t>;

// Longer lists are not ordered, so that every corner is a chain of its own: ordering takes the square of their length.
constexpr std::size_t kMaxOrdered = 256;

// Reorders the corners into chains in which the vertex before one is the vertex after the next. An open chain begins at
// its end.
void order_chains(std::span<Sides> corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const bool follows = i > 0 && corners[i].first == corners[i - 1].second;
    if (!follows) {
      const auto open = std::find_if(corners.begin() + i, corners.end(), [&](const Sides& c) {
        return std::none_of(corners.begin() + i, corners.end(), [&](const Sides& o) { return o.second == c.first; });
      });
      if (open != corners.end()) std::swap(corners[i], *open);
    }
    const auto next = std::find_if(corners.begin() + i + 1, corners.end(),
                                   [&](const Sides& c) { return c.first == corners[i].second; });
    if (next != corners.end()) std::swap(corners[i + 1], *next);
  }
}

void append_chains(std::span<const Sides> corners, std::vector<std::uint32_t>& list) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i == 0 || corners[i].first != corners[i - 1].second) {
      if (i > 0) list.push_back(kNoVertex);
      list.push_back(corners[i].first);
    }
    list.push_back(corners[i].second);
  }
}

constexpr double kLineWidth = 1.3;  // in pixels to either side: the line where glass meets a shape
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

// Returns whether the backs of faces are all hidden: those of a solid seen from outside. Without a GPU they take half
// of a picture's time.
bool only_fronts_show(const LiveFrame& frame, const LiveShape& shape) {
  const bool within = contains(shape.box, frame.view.eye);
  return frame.programs.in_software && shape.mesh.is_solid() && !frame.cut && !within;
}

void set_sections(const gl::Program& program, const LiveFrame& frame) {
  glUniform1i(uniform(program, "sections"), static_cast<GLint>(frame.sections.size()));
  for (std::size_t i = 0; i < frame.sections.size(); ++i) {
    const LiveCut& plane = frame.sections[i];
    const Vec3f normal(plane.normal);
    const std::string place = std::to_string(i) + "]";
    glUniform4f(uniform(program, ("section[" + place).c_str()), normal.x, normal.y, normal.z,
                static_cast<float>(plane.offset));
    set(program, ("section_srgb[" + place).c_str(), plane.color);
  }
}

void draw_faces(const LiveFrame& frame, const LiveShape& shape) {
  const gl::Program& program = frame.programs.shape.at(static_cast<std::size_t>(frame.scene.material));
  use_live_clipped(program, frame);
  if (frame.matcap != nullptr) {
    bind_texture(program, "ball", 0, GL_TEXTURE_2D, *frame.matcap);
    set(program, "plain_srgb", kClay);
  }
  set(program, "back_srgb", kBackColor);
  set_sections(program, frame);
  if (frame.scene.wireframe) {
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.0f, 1.0f);
  }
  if (only_fronts_show(frame, shape)) {
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
  }
  draw_triangles(shape.buffers, shape.seen);
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

// Counts the backs minus the fronts behind the cut in every sample: where that is not zero, the ray entered through the
// cut.
void count_openings(const LiveFrame& frame, const LiveShape& shape) {
  use_live_clipped(frame.programs.depth, frame);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_ALWAYS);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, 0, 0xff);
  glStencilOpSeparate(GL_BACK, GL_KEEP, GL_KEEP, GL_INCR_WRAP);
  glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_KEEP, GL_DECR_WRAP);
  draw_triangles(shape.buffers, shape.seen);
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

LiveReliefPrograms::LiveReliefPrograms()
    : occlusion(compile(live_occlusion_source())),
      smooth(compile(live_smooth_source())),
      relief(compile(live_relief_source())) {}

void draw_live_relief(const LiveFrame& frame, const LiveTargets& targets, const LiveReliefPrograms& programs) {
  const Relief& wanted = frame.scene.relief;
  gather(targets, frame.rect, GL_DEPTH_BUFFER_BIT);
  gather_normals(targets, frame.rect);
  gl::draw_into_one();
  if (wanted.occlusion) draw_occlusion(frame, targets, programs);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.is_single ? targets.relief.shaded.get() : targets.many.get());
  reset_state(frame);
  const gl::Program& program = programs.relief;
  use_relief(program, frame, targets);
  bind_texture(program, "occlusion_map", 2, GL_TEXTURE_2D, targets.relief.occlusion[1]);
  set(program, "with_cavity", wanted.cavity ? 1.0 : 0.0);
  set(program, "with_occlusion", wanted.occlusion ? 1.0 : 0.0);
  // At the far end of the depth range, so that it changes the samples that the shape covers. With a single sample the
  // program tests this itself.
  if (!targets.is_single) glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_DST_COLOR, GL_SRC_COLOR);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glEnable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.many.get());
}

Rings make_rings(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups) {
  const std::size_t drawn_count = groups.corner.size();
  std::vector<std::uint32_t> begin(drawn_count + 1, 0);
  for (const std::uint32_t d : groups.corner_vertex) {
    if (d != kNoVertex) ++begin[d + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Sides> sides(begin.back());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t c = 0; c < groups.corner_vertex.size(); ++c) {
    if (groups.corner_vertex[c] == kNoVertex) continue;
    const auto [before, after] = around(mesh, faces, c);
    sides[next[groups.corner_vertex[c]]++] = {after, before};
  }
  Rings rings;
  rings.begin.reserve(drawn_count + 1);
  rings.list.reserve(sides.size() + drawn_count);
  rings.begin.push_back(0);
  for (std::size_t d = 0; d < drawn_count; ++d) {
    const std::span<Sides> corners(sides.data() + begin[d], begin[d + 1] - begin[d]);
    if (corners.size() <= kMaxOrdered) order_chains(corners);
    append_chains(corners, rings.list);
    rings.begin.push_back(static_cast<std::uint32_t>(rings.list.size()));
  }
  return rings;
}

PolygonEdges polygon_edges(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups) {
  // Stores each edge at its smaller vertex, with the larger and its two corners. Counts first, then fills.
  std::vector<std::uint32_t> begin(mesh.vertex_count() + 1, 0);
  const auto for_each_edge = [&](auto visit) {
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      if (faces.normals[f] == Vec3f{}) continue;
      for (std::uint32_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) {
        const std::uint32_t next = c + 1 == mesh.face_begin[f + 1] ? mesh.face_begin[f] : c + 1;
        visit(c, next);
      }
    }
  };
  const auto smaller = [&](std::uint32_t a, std::uint32_t b) {
    return std::min(mesh.corner_vertex[a], mesh.corner_vertex[b]);
  };
  for_each_edge([&](std::uint32_t a, std::uint32_t b) { ++begin[smaller(a, b) + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  struct Edge {
    std::uint32_t larger = 0;
    std::uint32_t from = 0;  // corners
    std::uint32_t to = 0;
  };
  std::vector<Edge> edges(begin.back());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for_each_edge([&](std::uint32_t a, std::uint32_t b) {
    edges[next[smaller(a, b)]++] = {std::max(mesh.corner_vertex[a], mesh.corner_vertex[b]), a, b};
  });
  PolygonEdges result;
  result.list.reserve(edges.size());
  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    const std::span<Edge> here(edges.data() + begin[v], begin[v + 1] - begin[v]);
    std::stable_sort(here.begin(), here.end(), [](const Edge& a, const Edge& b) { return a.larger < b.larger; });
    for (std::size_t i = 0; i < here.size();) {
      std::size_t end = i + 1;
      while (end < here.size() && here[end].larger == here[i].larger) ++end;
      result.list.push_back(groups.corner_vertex[here[i].from]);
      result.list.push_back(groups.corner_vertex[here[i].to]);
      const bool two_ways = end - i == 2 && mesh.corner_vertex[here[i].from] == mesh.corner_vertex[here[i + 1].to];
      result.closed = result.closed && two_ways;
      i = end;
    }
  }
  return result;
}

LiveCut live_cut(const Clip& clip, const Placement& placement) {
  const double length = norm(clip.normal);
  if (!(length > 0) || !std::isfinite(length)) {
    throw InvalidInput("live view: a plane has no normal; give one that is not zero");
  }
  const double offset = (clip.offset - dot(clip.normal, placement.center)) * placement.scale / length;
  return LiveCut{clip.normal / length, offset, clip.color};
}

void begin_live_picture(const LiveFrame& frame, const LiveTargets& targets) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.many.get());
  reset_state(frame);
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

void draw_live_splats(const LiveFrame& frame, const LiveSplats& splats, bool has_depth, bool is_quick) {
  const gl::Program& program = frame.programs.splat;
  use_live_clipped(program, frame);
  const Camera& camera = frame.scene.camera;
  set(program, "nearest", kNearestSplat * norm(camera.target - camera.eye) * frame.view.placement.scale);
  set(program, "faintest", kMinSplatAlpha);
  set(program, "least", kMinSplatAlpha);
  set(program, "greatest", kMaxSplatAlpha);
  set(program, "blur", kSplatBlur);
  set(program, "brightest", kBrightestSplat);
  glDepthMask(GL_FALSE);
  blend_premultiplied();
  splats.draw(program, is_quick);
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  if (has_depth) {
    set(program, "least", 0.5);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    splats.draw(program, is_quick);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
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
  // First the hidden parts, once in each sample.
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

void present_live(const LiveTargets& targets, int width, int height, int left, int bottom) {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  const auto [wide, high, samples, relief] = targets.size;
  const bool is_enlarged = wide != width || high != height;
  // Chromium clears a canvas before the first drawing into it, and does not count a copy as one.
  glEnable(GL_SCISSOR_TEST);
  glScissor(left, bottom, width, height);
  glClear(GL_COLOR_BUFFER_BIT);
  glDisable(GL_SCISSOR_TEST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.one.get());
  glBlitFramebuffer(0, 0, wide, high, left, bottom, left + width, bottom + height, GL_COLOR_BUFFER_BIT,
                    is_enlarged ? GL_LINEAR : GL_NEAREST);
}

}  // namespace knead::render
