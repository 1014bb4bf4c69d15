// LiveView: the state of an interactive picture, and the order of its steps.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/error.h"
#include "render/live/live.h"
#include "render/live/live_splats.h"
#include "render/offline/passes.h"
#include "render/surface.h"

namespace knead::render {
namespace {

constexpr float kMaskShade = 0.62f;  // by which a masked vertex is darker
constexpr double kCreaseAngle = 40 * std::numbers::pi / 180;
constexpr int kRodSides = 16;
constexpr std::uint32_t kMaxSoftwareSplats = 300'000;  // that a driver on the CPU draws, at rest too

// A translucent surface that was drawn; while its faces stay the same, only its positions are sent.
struct Glass {
  Mesh mesh;
  Color color;
  LiveMesh live;
  LiveBuffers buffers;

  Glass(const TranslucentSurface& shown, const Placement& placement)
      : mesh(shown.mesh),
        color(shown.color),
        live(shown.mesh, placement, kCreaseAngle),
        buffers(make_live_buffers(live, {})) {}

  bool has_faces_of(const Mesh& other) const {
    return mesh.positions.size() == other.positions.size() && mesh.corner_vertex == other.corner_vertex &&
           mesh.face_begin == other.face_begin;
  }

  bool is(const TranslucentSurface& other) const {
    return has_faces_of(other.mesh) && mesh.positions == other.mesh.positions && color == other.color;
  }

  void become(const TranslucentSurface& other) {
    mesh.positions = other.mesh.positions;
    color = other.color;
    const VertexRange all{0, static_cast<std::uint32_t>(mesh.positions.size())};
    update(buffers, live, live.move(mesh.positions, {&all, 1}, 0));
  }
};

BoundingBall ball_of(const Box& box) {
  if (box.empty()) return {};
  return {box.center(), 0.5 * box.diagonal() + 1e-3};
}

// The ball for a view of the box. Its radius grows in steps, so that depths do not change during a small deformation.
BoundingBall seen_ball(const Box& box) {
  constexpr double least = 1.1;
  constexpr double step = 1.25;
  const double radius = box.empty() ? least : std::max({least, norm(box.center()) + 0.5 * box.diagonal()});
  return {{}, least * std::pow(step, std::ceil(std::log(radius / least) / std::log(step)))};
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

// The picture in the targets, which need not be drawn again, or only in parts.
struct Drawn {
  LiveScene scene;
  int width = 0;
  int height = 0;
  double near = 0;
  double far = 0;

  // Returns whether another picture differs by its tools at most.
  bool differs_by_tools(Drawn other) const {
    other.scene.surfaces = scene.surfaces;
    other.scene.arrows = scene.arrows;
    other.scene.lines = scene.lines;
    return width == other.width && height == other.height && near == other.near && far == other.far &&
           scene == other.scene;
  }
};

void add_rod(const Arrow& arrow, const Placement& placement, DrawSurface& surface) {
  add_arrow(arrow, placement, surface, kRodSides);
}
void add_rod(const Line& line, const Placement& placement, DrawSurface& surface) {
  add_line(line, placement, surface, kRodSides);
}

Box box_of(const DrawSurface& surface) {
  Box box;
  for (const DrawVertex& v : surface.vertices) box.extend(Vec3d(v.position));
  return box;
}

// The boxes of what differs in two lists of arrows or lines.
template <class Rod>
void add_differences(const std::vector<Rod>& before, const std::vector<Rod>& after, const Placement& placement,
                     std::vector<Box>& boxes) {
  for (std::size_t i = 0; i < std::max(before.size(), after.size()); ++i) {
    if (i < before.size() && i < after.size() && before[i] == after[i]) continue;
    DrawSurface surface;
    if (i < before.size()) add_rod(before[i], placement, surface);
    if (i < after.size()) add_rod(after[i], placement, surface);
    boxes.push_back(box_of(surface));
  }
}

// Arrows and lines, and their buffers.
struct Rods {
  std::vector<Arrow> arrows;
  std::vector<Line> lines;
  LiveBuffers buffers;
  Box box;

  void show(const LiveScene& scene, const Placement& placement, std::vector<Box>& changes) {
    if (arrows == scene.arrows && lines == scene.lines) return;
    add_differences(arrows, scene.arrows, placement, changes);
    add_differences(lines, scene.lines, placement, changes);
    arrows = scene.arrows;
    lines = scene.lines;
    DrawSurface surface;
    for (const Arrow& arrow : arrows) add_rod(arrow, placement, surface);
    for (const Line& line : lines) add_rod(line, placement, surface);
    buffers = make_live_buffers(surface);
    box = box_of(surface);
  }
};

// Binds the caller's framebuffer again at the end.
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

// Returns the samples that the box may cover, with a margin; all if it extends behind the eye.
LiveRect rect_of(const Box& box, const View& view, int width, int height, int margin) {
  LiveRect rect{width, height, 0, 0};
  for (std::size_t i = 0; i < 8 && !box.empty(); ++i) {
    const Vec3d p = box.corner(i);
    const auto row = [&](std::size_t r) {
      return view.matrix[r] * p.x + view.matrix[4 + r] * p.y + view.matrix[8 + r] * p.z + view.matrix[12 + r];
    };
    const double w = row(3);
    if (!(w > 1e-3)) return {0, 0, width, height};
    const double x = std::clamp(0.5 * (row(0) / w + 1), -1.0, 2.0) * width;
    const double y = std::clamp(0.5 * (row(1) / w + 1), -1.0, 2.0) * height;
    rect.left = std::min(rect.left, static_cast<int>(std::floor(x)) - margin);
    rect.bottom = std::min(rect.bottom, static_cast<int>(std::floor(y)) - margin);
    rect.right = std::max(rect.right, static_cast<int>(std::ceil(x)) + margin);
    rect.top = std::max(rect.top, static_cast<int>(std::ceil(y)) + margin);
  }
  return {std::max(rect.left, 0), std::max(rect.bottom, 0), std::min(rect.right, width), std::min(rect.top, height)};
}

void extend(LiveRect& rect, const LiveRect& other) {
  if (other.left >= other.right || other.bottom >= other.top) return;
  rect = {std::min(rect.left, other.left), std::min(rect.bottom, other.bottom), std::max(rect.right, other.right),
          std::max(rect.top, other.top)};
}

bool overlap(const LiveRect& a, const LiveRect& b) {
  return a.left < b.right && b.left < a.right && a.bottom < b.top && b.bottom < a.top;
}

// Returns the number of samples around a sample that its relief reads, and the width of lines.
int margin_of(const LiveScene& scene, int height) {
  constexpr int line = 4;
  return line + (scene.relief.cavity ? 3 * std::max(1, static_cast<int>(std::lround(kFinestCavity * height))) : 0);
}

}  // namespace

struct LiveView::State {
  LivePrograms programs;
  std::optional<LiveReliefPrograms> relief_programs;  // since the first picture with a relief
  std::optional<Matcap> matcap;                       // in matcap_texture
  gl::Texture matcap_texture;
  std::optional<LiveCompute> compute;  // of the shape, since its positions were first on the GPU
  std::optional<Box> box_on_gpu;       // renderer units; while the shape's positions are on the GPU
  int samples = 1;
  bool reports_loss = false;
  Placement placement;
  LiveMesh mesh;
  LiveBuffers buffers;
  std::vector<ShownImage> images;
  std::vector<Bytes4> colors;        // per drawn vertex; the fourth: influence
  std::vector<Bytes4> plain_colors;  // without the mask
  std::optional<LiveSplats> splats;  // if the shape is a capture; their tint is `colors`
  std::shared_ptr<const SplatJacobians> jacobians;
  std::vector<Glass> glass;
  Rods rods;
  LiveTargets targets;
  LiveTargets other_targets;
  UploadCounts counts;
  std::optional<Drawn> drawn;  // none if the shape's colours have changed since

  // Draws the scene into the targets' single samples. If they show a similar picture, draws only the parts that may
  // differ. `is_exact`: waits until splats are sorted for it.
  void make_picture(const LiveScene& scene, int width, int height, bool is_exact);

  // Sets the colour of each drawn vertex d to color_of(d, value), where its vertex's value is limited to [0, 1].
  template <class ColorOf>
  void set_colors(std::span<const float> per_vertex, const char* what, const ColorOf& color_of) {
    const std::size_t count = mesh.vertex_count();
    if (!per_vertex.empty() && per_vertex.size() != count) {
      throw InvalidInput("live view: " + std::to_string(per_vertex.size()) + " values of " + what + " for a shape of " +
                         std::to_string(count) + " vertices; give one per vertex");
    }
    VertexRange different{static_cast<std::uint32_t>(colors.size()), 0};
    mesh.for_each_drawn({0, static_cast<std::uint32_t>(count)}, [&](std::uint32_t v, std::uint32_t d) {
      const float value = per_vertex.empty() || !(per_vertex[v] > 0) ? 0.0f : std::min(per_vertex[v], 1.0f);
      const Bytes4 color = color_of(d, value);
      if (color == colors[d]) return;
      colors[d] = color;
      different = {std::min(different.begin, d), std::max(different.end, d + 1)};
    });
    if (different.begin < different.end) drawn.reset();
    update_colors(buffers, colors, different);
    if (splats && different.begin < different.end) splats->take_tints(buffers, different);
  }

  // Returns the scene's images on the GPU, and drops all others.
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

  // Returns the scene's surfaces with faces on the GPU, and updates the rods. Adds boxes around all changes.
  std::vector<LiveGlass> show(const LiveScene& scene, const Vec3d& forward, std::vector<Box>& changes) {
    rods.show(scene, placement, changes);
    std::vector<LiveGlass> shown;
    std::vector<const TranslucentSurface*> surfaces;
    for (const TranslucentSurface& surface : scene.surfaces) {
      if (surface.mesh.face_count() > 0) surfaces.push_back(&surface);
    }
    for (std::size_t i = surfaces.size(); i < glass.size(); ++i) changes.push_back(glass[i].live.box());
    if (glass.size() > surfaces.size()) glass.erase(glass.begin() + surfaces.size(), glass.end());
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      if (i < glass.size() && glass[i].is(*surfaces[i])) continue;
      if (i < glass.size()) changes.push_back(glass[i].live.box());
      if (i == glass.size()) {
        glass.emplace_back(*surfaces[i], placement);
      } else if (glass[i].has_faces_of(surfaces[i]->mesh)) {
        glass[i].become(*surfaces[i]);
      } else {
        glass[i] = Glass(*surfaces[i], placement);
      }
      changes.push_back(glass[i].live.box());
    }
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      const auto [near, far] = extent_along(glass[i].live.box(), forward);
      shown.push_back({glass[i].buffers, surfaces[i]->color, near, far});
    }
    return shown;
  }

  // Keeps the targets of the same size with other samples, because views alternate between few and many.
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
  const bool are_captured = are_splats(mesh) && LiveSplats::have_room(mesh.vertex_count());
  if (are_captured) shape.vertex_colors.assign(mesh.vertex_count(), Color{});
  const std::vector<Bytes4> colors = colors_of(shape);
  s.colors.resize(s.mesh.vertices().size());
  s.mesh.for_each_drawn({0, static_cast<std::uint32_t>(mesh.vertex_count())}, [&](std::uint32_t v, std::uint32_t d) {
    s.colors[d] = {colors[v][0], colors[v][1], colors[v][2], 0};
  });
  s.plain_colors = s.colors;
  s.buffers = make_live_buffers(s.mesh, s.colors);
  s.splats.reset();
  s.jacobians.reset();
  if (are_captured) s.splats.emplace(mesh, s.mesh, s.placement.scale, s.buffers);
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
  const bool is_elsewhere = s.box_on_gpu.has_value();
  if (is_elsewhere || s.mesh.is_cloud()) s.drawn.reset();
  const std::vector<VertexRange> moved = s.mesh.move(positions, is_elsewhere ? std::span(&all, 1) : changed, threads);
  s.counts = update(s.buffers, s.mesh, moved);
  for (const VertexRange& range : moved) {
    if (s.splats) s.splats->take_places(s.buffers, range);
  }
  s.box_on_gpu.reset();
}

bool LiveView::set_splats(const std::shared_ptr<const SplatJacobians>& jacobians) {
  State& s = *state_;
  if (!s.splats || s.jacobians == jacobians) return false;
  s.jacobians = jacobians;
  s.splats->deform(jacobians.get(), s.mesh);
  s.drawn.reset();
  return true;
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
  if (s.splats) s.splats->take_places(s.buffers, {0, static_cast<std::uint32_t>(s.mesh.vertices().size())});
  s.counts = {};
  s.box_on_gpu = box.empty() ? Box{} : Box{s.placement.apply(box.min), s.placement.apply(box.max)};
}

void LiveView::set_influence(std::span<const float> per_vertex) {
  state_->set_colors(per_vertex, "influence", [&](std::uint32_t d, float value) {
    Bytes4 color = state_->colors[d];
    color[3] = static_cast<std::uint8_t>(std::lround(255 * value));
    return color;
  });
}

void LiveView::set_mask(std::span<const float> per_vertex) {
  state_->set_colors(per_vertex, "a mask", [&](std::uint32_t d, float value) {
    Bytes4 color = state_->colors[d];
    for (std::size_t i = 0; i < 3; ++i) {
      const float lit = static_cast<float>(state_->plain_colors[d][i]) * (1 - kMaskShade * value);
      color[i] = static_cast<std::uint8_t>(std::lround(lit));
    }
    return color;
  });
}

void LiveView::State::make_picture(const LiveScene& scene, int width, int height, bool is_exact) {
  std::optional<LiveCut> cut;
  if (scene.clip) cut = live_cut(*scene.clip, placement);
  if (scene.sections.size() > kMaxSections) throw InvalidInput("live view: too many sections; give at most three");
  std::vector<LiveCut> sections;
  for (const Clip& plane : scene.sections) sections.push_back(live_cut(plane, placement));
  const double aspect = static_cast<double>(width) / height;
  const View rough = make_view(scene.camera, placement, {}, aspect, height);
  std::vector<Box> changes{mesh.take_changes()};
  const std::optional<Drawn> before = std::exchange(drawn, {});
  const std::vector<LiveGlass> shown_glass = show(scene, rough.frame.forward, changes);
  const View view = make_view(scene.camera, placement, seen_ball(shown_box()), aspect, height);
  const bool is_matcap = scene.material == Material::matcap;
  const bool relief = scene.relief != Relief{} && !mesh.is_cloud();
  Drawn now{scene, width, height, view.near, view.far};
  LiveRect rect{0, 0, width, height};
  const bool is_local = !mesh.is_cloud() && !box_on_gpu && !cut && !scene.relief.occlusion;
  if (is_local && before && before->differs_by_tools(now)) {
    rect = {width, height, 0, 0};
    for (const Box& box : changes) extend(rect, rect_of(box, view, width, height, margin_of(scene, height)));
  }
  const LiveFrame frame{programs,
                        view,
                        scene,
                        ball_of(shape_box()),
                        width,
                        height,
                        rect,
                        cut,
                        is_matcap ? &texture_of(scene.matcap) : nullptr,
                        relief,
                        std::move(sections)};
  if (relief && !relief_programs) relief_programs.emplace();
  const bool is_slow = splats && programs.in_software;  // and smooth edges do little for splats
  make_targets({width, height, is_slow ? 1 : scene.samples > 0 ? scene.samples : samples, relief});
  if (rect.left < rect.right && rect.bottom < rect.top) {
    const auto is_seen = [&](const Box& box) {
      return box_on_gpu || box.empty() || overlap(rect_of(box, view, width, height, 1), rect);
    };
    begin_live_picture(frame, targets);
    if (!splats) draw_live_shape(frame, {mesh, buffers, shape_box(), mesh.seen(is_seen)});
    if (relief) draw_live_relief(frame, targets, *relief_programs);
    draw_live_background(frame);
    draw_live_images(frame, show_images(scene));
    if (splats) {
      splats->sort_for({view.eye, view.frame.forward, view.perspective}, mesh, is_exact);
      const bool is_quick =
          scene.samples == 1 || scene.coarseness > 1 || (is_slow && splats->count() > kMaxSoftwareSplats);
      const bool has_depth = !shown_glass.empty() || rods.buffers.triangle_indices > 0;
      draw_live_splats(frame, *splats, has_depth, is_quick && !is_exact);
    }
    if (!shown_glass.empty()) gather(targets, rect, GL_DEPTH_BUFFER_BIT);
    draw_live_rods(frame, rods.buffers);
    if (!shown_glass.empty()) draw_live_glass(frame, shown_glass, targets.one_depth);
    gather(targets, rect, GL_COLOR_BUFFER_BIT);
    glDisable(GL_SCISSOR_TEST);
  }
  drawn = std::move(now);
}

bool LiveView::draw(const LiveScene& scene, int width, int height, int left, int bottom) {
  if (width < 1 || height < 1) return false;
  if (scene.coarseness < 1) throw InvalidInput("live view: the coarseness is below 1");
  const FramebufferGuard caller;
  const int wide = (width - 1) / scene.coarseness + 1;
  const int high = (height - 1) / scene.coarseness + 1;
  const std::optional<Drawn>& drawn = state_->drawn;
  const bool has_news = state_->mesh.has_changes() || (state_->splats && state_->splats->has_news());
  const bool is_there = drawn && drawn->width == wide && drawn->height == high && drawn->scene == scene && !has_news;
  if (!is_there) state_->make_picture(scene, wide, high, false);
  caller.bind();
  present_live(state_->targets, width, height, left, bottom);
  return !is_there;
}

Image LiveView::picture(const LiveScene& scene, int width, int height) {
  if (width < 1 || height < 1) throw InvalidInput("live view: a picture without pixels; give a width and a height");
  const FramebufferGuard caller;
  state_->drawn.reset();
  state_->make_picture(scene, width, height, true);
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

bool LiveView::is_sorting() const { return state_->splats && state_->splats->is_sorting(); }

bool LiveView::is_lost() const { return state_->reports_loss && gl::was_reset(); }

Box LiveView::box() const {
  const Box placed = state_->shape_box();
  if (placed.empty()) return {};
  const Placement& placement = state_->placement;
  return {placed.min / placement.scale + placement.center, placed.max / placement.scale + placement.center};
}

}  // namespace knead::render
