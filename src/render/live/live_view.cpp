#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "knead/error.h"
#include "knead/gl.h"
#include "knead/render.h"
#include "render/live/live.h"
#include "render/offline/passes.h"
#include "render/surface.h"

namespace knead::render {
namespace {

constexpr float kMaskShade = 0.62f;  // how much darker a masked vertex is

constexpr double kCreaseAngle = 40 * std::numbers::pi / 180;
constexpr int kRodSides = 16;

// A translucent surface as it was last drawn; while its faces stay the same only its places are sent.
struct Glass {
  Mesh mesh;
  LiveMesh live;
  LiveBuffers buffers;

  Glass(const Mesh& shown, const Placement& placement)
      : mesh(shown), live(shown, placement, kCreaseAngle), buffers(make_live_buffers(live, {})) {}

  bool has_faces_of(const Mesh& other) const {
    return mesh.positions.size() == other.positions.size() && mesh.corner_vertex == other.corner_vertex &&
           mesh.face_begin == other.face_begin;
  }

  void move(const std::vector<Vec3d>& positions) {
    if (mesh.positions == positions) return;
    mesh.positions = positions;
    const VertexRange all{0, static_cast<std::uint32_t>(positions.size())};
    update(buffers, live, live.move(positions, {&all, 1}, 0));
  }
};

void extend(Box& box, const Box& other) {
  if (other.empty()) return;
  box.extend(other.min);
  box.extend(other.max);
}

BoundingBall ball_of(const Box& box) {
  if (box.empty()) return {};
  return {box.center(), 0.5 * box.diagonal() + 1e-3};
}

// The least and greatest of dot(direction, corner).
std::pair<double, double> extent_along(const Box& box, const Vec3d& direction) {
  const double middle = dot(direction, box.center());
  const Vec3d half = (box.max - box.min) * 0.5;
  const double reach = std::abs(direction.x) * half.x + std::abs(direction.y) * half.y + std::abs(direction.z) * half.z;
  return {middle - reach, middle + reach};
}

struct ShownImage {
  std::shared_ptr<const Image> image;
  gl::Texture texture;
};

// What the targets show, so that it need not be drawn again.
struct Drawn {
  LiveScene scene;
  int width = 0;
  int height = 0;

  friend bool operator==(const Drawn&, const Drawn&) = default;
};

// Arrows and lines with what they look like.
struct Rods {
  std::vector<Arrow> arrows;
  std::vector<Line> lines;
  LiveBuffers buffers;
  Box box;

  void show(const LiveScene& scene, const Placement& placement) {
    if (arrows == scene.arrows && lines == scene.lines) return;
    arrows = scene.arrows;
    lines = scene.lines;
    DrawSurface surface;
    for (const Arrow& arrow : arrows) add_arrow(arrow, placement, surface, kRodSides);
    for (const Line& line : lines) add_line(line, placement, surface, kRodSides);
    buffers = make_live_buffers(surface);
    box = {};
    for (const DrawVertex& v : surface.vertices) box.extend(Vec3d(v.position));
  }
};

}  // namespace

struct LiveView::State {
  LivePrograms programs;
  std::optional<LiveReliefPrograms> relief_programs;  // from the first picture that has a relief
  std::optional<Matcap> matcap;                       // in matcap_texture
  gl::Texture matcap_texture;
  std::optional<LiveCompute> compute;  // of the shape, from the first places that are on the GPU
  std::optional<Box> box_on_gpu;       // renderer units; while the shape's places are those on the GPU
  int samples = 1;
  bool reports_loss = false;
  Placement placement;
  LiveMesh mesh;
  LiveBuffers buffers;
  std::vector<ShownImage> images;
  std::vector<Bytes4> colors;        // per drawn vertex; the fourth: influence
  std::vector<Bytes4> plain_colors;  // without the mask
  std::vector<Glass> glass;
  Rods rods;
  LiveTargets targets;
  LiveTargets other_targets;
  UploadCounts counts;
  std::optional<Drawn> drawn;  // none where the shape or its colours have changed since

  // Of the scene's images; those that it does not have any more are forgotten.
  std::vector<LiveImage> show_images(const LiveScene& scene) {
    std::vector<ShownImage> kept;
    for (const PlacedImage& placed : scene.images) {
      const auto same = [&](const ShownImage& one) { return one.image == placed.image; };
      if (std::any_of(kept.begin(), kept.end(), same)) continue;
      const auto known = std::find_if(images.begin(), images.end(), same);
      kept.push_back(known != images.end() ? std::move(*known)
                                           : ShownImage{placed.image, make_image_texture(*placed.image)});
    }
    images = std::move(kept);
    std::vector<LiveImage> shown;
    for (const PlacedImage& placed : scene.images) {
      const auto found =
          std::find_if(images.begin(), images.end(), [&](const ShownImage& one) { return one.image == placed.image; });
      shown.push_back({found->texture, placed});
    }
    return shown;
  }

  // What the scene has besides the shape, on the GPU; surfaces without faces are left out.
  std::vector<LiveGlass> show(const LiveScene& scene, const Vec3d& forward) {
    rods.show(scene, placement);
    std::vector<LiveGlass> shown;
    std::vector<const TranslucentSurface*> surfaces;
    for (const TranslucentSurface& surface : scene.surfaces) {
      if (surface.mesh.face_count() > 0) surfaces.push_back(&surface);
    }
    if (glass.size() > surfaces.size()) glass.erase(glass.begin() + surfaces.size(), glass.end());
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      const Mesh& mesh_shown = surfaces[i]->mesh;
      if (i == glass.size()) {
        glass.emplace_back(mesh_shown, placement);
      } else if (!glass[i].has_faces_of(mesh_shown)) {
        glass[i] = Glass(mesh_shown, placement);
      } else {
        glass[i].move(mesh_shown.positions);
      }
    }
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      const auto [near, far] = extent_along(glass[i].live.box(), forward);
      shown.push_back({glass[i].buffers, surfaces[i]->color, near, far});
    }
    return shown;
  }

  // Those of the size before, with other samples, are kept: views change between few and many.
  void make_targets(const LiveTargetSize& size) {
    if (targets.size == size) return;
    std::swap(targets, other_targets);
    if (targets.size == size) return;
    targets = {};
    const LiveTargetSize& other = other_targets.size;
    if (other.width != size.width || other.height != size.height) other_targets = {};
    targets = make_live_targets(size);
  }

  const gl::Texture& texture_of(Matcap wanted) {
    if (matcap != wanted) matcap_texture = make_matcap_texture(wanted);
    matcap = wanted;
    return matcap_texture;
  }

  Box shape_box() const { return box_on_gpu ? *box_on_gpu : mesh.box(); }

  Box shown_box() const {
    Box box = shape_box();
    for (const Glass& surface : glass) extend(box, surface.live.box());
    extend(box, rods.box);
    return box;
  }
};

namespace {

// Binds the caller's framebuffer again, whatever happens.
struct FramebufferGuard {
  GLint draw = 0;
  GLint read = 0;
  FramebufferGuard() {
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read);
  }
  FramebufferGuard(const FramebufferGuard&) = delete;
  FramebufferGuard& operator=(const FramebufferGuard&) = delete;
  ~FramebufferGuard() { bind(); }

  void bind() const {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read));
  }
};

}  // namespace

LiveView::LiveView(int samples) {
  gl::require_version(33);
  state_ = std::make_unique<State>();
  state_->samples = samples;
  state_->reports_loss = gl::reports_loss();
}
LiveView::~LiveView() = default;
LiveView::LiveView(LiveView&&) noexcept = default;
LiveView& LiveView::operator=(LiveView&&) noexcept = default;

void LiveView::set_shape(const Mesh& mesh) {
  Box box;
  for (const Vec3d& p : mesh.positions) {
    if (is_finite(p)) box.extend(p);
  }
  State& s = *state_;
  s.placement = make_placement(box);
  s.mesh = LiveMesh(mesh, s.placement, kCreaseAngle);
  Shape shape;
  shape.mesh = &mesh;
  shape.use_mesh_colors = true;
  const std::vector<Bytes4> colors = colors_of(shape);
  s.colors.resize(s.mesh.vertices().size());
  s.mesh.for_each_drawn({0, static_cast<std::uint32_t>(mesh.vertex_count())}, [&](std::uint32_t v, std::uint32_t d) {
    s.colors[d] = {colors[v][0], colors[v][1], colors[v][2], 0};
  });
  s.plain_colors = s.colors;
  s.buffers = make_live_buffers(s.mesh, s.colors);
  s.glass.clear();
  s.rods = {};
  s.counts = {};
  s.compute.reset();
  s.box_on_gpu.reset();
  s.drawn.reset();
}

void LiveView::move(std::span<const Vec3d> positions, std::span<const VertexRange> changed, int threads) {
  State& s = *state_;
  const VertexRange all{0, static_cast<std::uint32_t>(positions.size())};
  s.drawn.reset();
  const bool is_elsewhere = s.box_on_gpu.has_value();
  s.counts = update(s.buffers, s.mesh, s.mesh.move(positions, is_elsewhere ? std::span(&all, 1) : changed, threads));
  s.box_on_gpu.reset();
}

void LiveView::move_on_gpu(std::span<const PointBuffer> points, const Box& box) {
  State& s = *state_;
  std::uint32_t next = 0;
  for (const PointBuffer& part : points) {
    if (part.vertices.begin != next) throw InvalidInput("live view: the buffers do not follow each other");
    next = part.vertices.end;
  }
  if (next != s.mesh.vertex_count()) {
    throw InvalidInput("live view: the buffers hold " + std::to_string(next) + " places for a shape of " +
                       std::to_string(s.mesh.vertex_count()) + " vertices; set the shape anew");
  }
  s.drawn.reset();
  if (!s.compute) s.compute.emplace(s.mesh);
  s.compute->move(points, s.placement, s.buffers);
  s.counts = {};
  s.box_on_gpu = box.empty() ? Box{} : Box{s.placement.apply(box.min), s.placement.apply(box.max)};
}

void LiveView::set_influence(std::span<const float> per_vertex) {
  State& s = *state_;
  const std::size_t count = s.mesh.vertex_count();
  if (!per_vertex.empty() && per_vertex.size() != count) {
    throw InvalidInput("live view: " + std::to_string(per_vertex.size()) + " values of influence for a shape of " +
                       std::to_string(count) + " vertices; give one per vertex");
  }
  VertexRange different{static_cast<std::uint32_t>(s.colors.size()), 0};
  s.mesh.for_each_drawn({0, static_cast<std::uint32_t>(count)}, [&](std::uint32_t v, std::uint32_t d) {
    const float value = per_vertex.empty() || !(per_vertex[v] > 0) ? 0.0f : std::min(per_vertex[v], 1.0f);
    const auto byte = static_cast<std::uint8_t>(std::lround(255 * value));
    if (s.colors[d][3] == byte) return;
    s.colors[d][3] = byte;
    different = {std::min(different.begin, d), std::max(different.end, d + 1)};
  });
  if (different.begin < different.end) s.drawn.reset();
  update_colors(s.buffers, s.colors, different);
}

void LiveView::set_mask(std::span<const float> per_vertex) {
  State& s = *state_;
  const std::size_t count = s.mesh.vertex_count();
  if (!per_vertex.empty() && per_vertex.size() != count) {
    throw InvalidInput("live view: " + std::to_string(per_vertex.size()) + " values of a mask for a shape of " +
                       std::to_string(count) + " vertices; give one per vertex");
  }
  VertexRange different{static_cast<std::uint32_t>(s.colors.size()), 0};
  s.mesh.for_each_drawn({0, static_cast<std::uint32_t>(count)}, [&](std::uint32_t v, std::uint32_t d) {
    const float value = per_vertex.empty() || !(per_vertex[v] > 0) ? 0.0f : std::min(per_vertex[v], 1.0f);
    Bytes4 color = s.colors[d];
    for (std::size_t i = 0; i < 3; ++i) {
      const float lit = static_cast<float>(s.plain_colors[d][i]) * (1 - kMaskShade * value);
      color[i] = static_cast<std::uint8_t>(std::lround(lit));
    }
    if (color == s.colors[d]) return;
    s.colors[d] = color;
    different = {std::min(different.begin, d), std::max(different.end, d + 1)};
  });
  if (different.begin < different.end) s.drawn.reset();
  update_colors(s.buffers, s.colors, different);
}

namespace {

// Draws the scene into the targets' single samples.
void make_picture(LiveView::State& s, const LiveScene& scene, int width, int height) {
  std::optional<LiveCut> cut;
  if (scene.clip) cut = live_cut(*scene.clip, s.placement);
  if (scene.sections.size() > kMaxSections) throw InvalidInput("live view: too many sections; give at most three");
  std::vector<LiveCut> sections;
  for (const Clip& plane : scene.sections) sections.push_back(live_cut(plane, s.placement));
  const double aspect = static_cast<double>(width) / height;
  const View rough = make_view(scene.camera, s.placement, {}, aspect, height);
  const std::vector<LiveGlass> glass = s.show(scene, rough.frame.forward);
  const View view = make_view(scene.camera, s.placement, ball_of(s.shown_box()), aspect, height);
  const bool is_matcap = scene.material == Material::matcap;
  const bool relief = scene.relief != Relief{} && !s.mesh.is_cloud();
  const LiveFrame frame{s.programs, view,
                        scene,      ball_of(s.shape_box()),
                        width,      height,
                        cut,        is_matcap ? &s.texture_of(scene.matcap) : nullptr,
                        relief,     std::move(sections)};
  if (relief && !s.relief_programs) s.relief_programs.emplace();
  s.make_targets({width, height, scene.samples > 0 ? scene.samples : s.samples, relief});
  begin_live_picture(frame, s.targets);
  draw_live_shape(frame, {s.mesh, s.buffers, s.shape_box()});
  if (relief) draw_live_relief(frame, s.targets, *s.relief_programs);
  draw_live_background(frame);
  draw_live_images(frame, s.show_images(scene));
  if (!glass.empty()) gather(s.targets, GL_DEPTH_BUFFER_BIT);
  draw_live_rods(frame, s.rods.buffers);
  if (!glass.empty()) draw_live_glass(frame, glass, s.targets.one_depth);
  gather(s.targets, GL_COLOR_BUFFER_BIT);
}

}  // namespace

void LiveView::draw(const LiveScene& scene, int width, int height, int left, int bottom) {
  if (width < 1 || height < 1) return;
  const FramebufferGuard caller;
  const Drawn wanted{scene, width, height};
  if (state_->drawn != wanted) {
    state_->drawn.reset();
    make_picture(*state_, scene, width, height);
    state_->drawn = wanted;
  }
  caller.bind();
  present_live(state_->programs, state_->targets, left, bottom);
}

Image LiveView::picture(const LiveScene& scene, int width, int height) {
  if (width < 1 || height < 1) throw InvalidInput("live view: a picture without pixels; give a width and a height");
  const FramebufferGuard caller;
  state_->drawn.reset();
  make_picture(*state_, scene, width, height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, state_->targets.one.get());
  const std::size_t row = 4 * static_cast<std::size_t>(width);
  std::vector<std::uint8_t> upside_down(row * static_cast<std::size_t>(height));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, upside_down.data());
  Image image{width, height, {}};
  image.pixels.reserve(upside_down.size());
  for (auto at = upside_down.end(); at != upside_down.begin();) {
    at -= static_cast<std::ptrdiff_t>(row);
    image.pixels.insert(image.pixels.end(), at, at + static_cast<std::ptrdiff_t>(row));
  }
  return image;
}

UploadCounts LiveView::counts() const { return state_->counts; }

bool LiveView::draws_in_software() const { return state_->programs.in_software; }

bool LiveView::is_lost() const { return state_->reports_loss && gl::was_reset(); }

Box LiveView::box() const {
  const Box placed = state_->shape_box();
  if (placed.empty()) return {};
  const Placement& placement = state_->placement;
  return {placed.min / placement.scale + placement.center, placed.max / placement.scale + placement.center};
}

}  // namespace knead::render
