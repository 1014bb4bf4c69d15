// The parts of the live view: shaders, meshes that follow a deformation, buffers and targets on the GPU, and the steps
// of a picture. Internal to render.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gl/objects.h"
#include "knead/editor/render.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "render/offline/passes.h"
#include "render/surface.h"

namespace knead::render {

ShaderSource live_shape_source(Material material);
ShaderSource live_cloud_source();       // points -> discs
ShaderSource live_splat_source();       // splats -> quads
ShaderSource live_wire_source();        // edges of the polygons
ShaderSource live_depth_source();       // nothing but depth and stencil
ShaderSource live_cut_source();         // the cutting plane
ShaderSource live_background_source();  // at the far end of the depth range
ShaderSource live_image_source();       // a picture in the scene, at the far end of the depth range
ShaderSource live_rod_source();
ShaderSource live_glass_source();
ShaderSource live_occlusion_source();  // of every second sample each way
ShaderSource live_smooth_source();     // the same over 4 x 4 of them
ShaderSource live_relief_source();     // half the factor of brightness

// The vertices around every drawn vertex d: list[begin[d]] to list[begin[d + 1]]. Two consecutive ones are those after
// and before one corner of the group; kNoVertex separates unconnected chains.
struct Rings {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> list;
};

Rings make_rings(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups);

struct PolygonEdges {
  std::vector<std::uint32_t> list;  // pairs of drawn vertices, each edge of the mesh once
  bool closed = true;               // every edge has two faces, which go along it in opposite directions
};

PolygonEdges polygon_edges(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups);

struct LiveVertex {
  Vec3f position;  // renderer units
  Vec3f normal;    // unit; zero in a point cloud
};

// Finds the normals of the drawn vertices in the range, whose positions are set: the mean of the normals of the faces
// around each, weighted by about the corners' angles (within a tenth up to 120 degrees); (0, 0, 1) if there are none.
// points: of all vertices of the mesh. The bits do not depend on the range.
void set_ring_normals(const Rings& rings, std::span<const Vec3f> points, const VertexRange& drawn,
                      std::vector<LiveVertex>& vertices);

// Entries [first, first + count) of a list of indices.
struct IndexSpan {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

void extend(Box& box, const Box& other);

// A mesh for the GPU that follows a deformation. There is one drawn vertex per vertex and smooth group of faces, as in
// make_surface, in the order of the mesh's vertices. The groups, triangles and edges are those of the original mesh;
// only positions change. Normals are those of set_ring_normals, with the same bits for any number of threads and of
// moves.
class LiveMesh {
 public:
  LiveMesh() = default;

  // crease_angle: as for make_surface. The mesh need not outlive the call. Cost: about 1 us per vertex.
  LiveMesh(const Mesh& mesh, const Placement& placement, double crease_angle);

  // Moves the vertices in `changed`; positions has all vertices of the mesh. Returns the ascending ranges of changed
  // drawn vertices: those that moved and the one-ring around them, at most a few hundred ranges, with short gaps
  // closed. Throws InvalidInput for another number of positions or a range beyond it.
  std::vector<VertexRange> move(std::span<const Vec3d> positions, std::span<const VertexRange> changed, int threads);

  const std::vector<LiveVertex>& vertices() const { return vertices_; }
  // Three drawn vertices each; consecutive triangles are close to each other.
  std::span<const std::uint32_t> triangles() const { return triangles_; }
  std::span<const std::uint32_t> edges() const { return edges_; }  // two drawn vertices each; of the polygons
  double mean_edge() const { return mean_edge_; }                  // when it was made; renderer units
  const Rings& rings() const { return rings_; }                    // empty in a cloud
  bool is_cloud() const { return triangles_.empty(); }
  bool is_solid() const { return solid_; }  // when it was made: closed, and its faces turned outwards
  Box box() const;                          // of the finite vertices, renderer units

  // Returns a box around all triangles that have changed since the last call, before and after.
  Box take_changes() { return std::exchange(changes_, {}); }
  bool has_changes() const { return !changes_.empty(); }

  // Returns the indices of triangles() without those in boxes for which is_seen(box) is false.
  template <class IsSeen>
  std::vector<IndexSpan> seen(IsSeen is_seen) const {
    std::vector<IndexSpan> spans;
    for (std::uint32_t run = 0; run < run_boxes_.size(); ++run) {
      if (!is_seen(run_boxes_[run])) continue;
      const IndexSpan span{run_first_[run], run_first_[run + 1] - run_first_[run]};
      if (!spans.empty() && spans.back().first + spans.back().count == span.first) {
        spans.back().count += span.count;
      } else {
        spans.push_back(span);
      }
    }
    return spans;
  }

  // Calls visit(v, d) for every drawn vertex d of every vertex v in the range.
  template <class Visit>
  void for_each_drawn(const VertexRange& range, Visit visit) const {
    for (std::uint32_t v = range.begin; v < range.end; ++v) {
      for (std::uint32_t d = drawn_begin_[v]; d < drawn_begin_[v + 1]; ++d) visit(v, d);
    }
  }
  std::size_t vertex_count() const { return points_.size(); }

 private:
  void place(std::span<const Vec3d> positions, const VertexRange& range);
  void shade(const VertexRange& range);
  void measure(const std::vector<std::uint8_t>& blocks, int threads);
  void mark(const VertexRange& range);
  std::vector<VertexRange> marked_runs();
  void group_triangles();
  void find_runs();
  std::span<const std::uint32_t> indices_of(std::uint32_t run) const;
  void measure_runs(int threads);

  Placement placement_;
  std::vector<Vec3f> points_;                  // per vertex of the mesh
  std::vector<Box> boxes_;                     // of every block of kBlock vertices
  std::vector<std::uint32_t> drawn_begin_{0};  // the drawn vertices of vertex v: drawn_begin_[v] to drawn_begin_[v + 1]
  std::vector<LiveVertex> vertices_;
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint32_t> edges_;
  Rings rings_;                           // empty in a cloud
  std::vector<std::uint32_t> run_first_;  // the triangles of run r begin at triangles_[run_first_[r]]
  std::vector<Box> run_boxes_;
  std::vector<std::uint8_t> run_marks_;   // runs that have changed; zero between calls
  std::vector<std::uint32_t> run_begin_;  // the runs at drawn vertex d begin at runs_[run_begin_[d]]
  std::vector<std::uint16_t> runs_;
  Box changes_;
  std::vector<std::uint8_t> marks_;  // per vertex, zero between calls
  double mean_edge_ = 0;
  bool solid_ = false;
};

struct LivePrograms {
  std::array<gl::Program, 3> shape;  // by Material
  gl::Program cloud;
  gl::Program splat;
  gl::Program wire;
  gl::Program depth;
  gl::Program cut;
  gl::Program background;
  gl::Program image;
  gl::Program rod;
  gl::Program glass;
  gl::VertexArray nothing;   // for vertices made by the vertex program
  bool in_software = false;  // the driver has no GPU

  LivePrograms();
};

// The buffers of a LiveMesh, or of rods, which have no edges.
struct LiveBuffers {
  gl::VertexArray layout;
  gl::Buffer vertices;
  gl::Buffer colors;  // red, green, blue, influence
  gl::Buffer triangles;
  gl::Buffer edges;
  GLsizei vertex_count = 0;
  GLsizei triangle_indices = 0;
  GLsizei edge_indices = 0;
};

// colors: one per drawn vertex, or none.
LiveBuffers make_live_buffers(const LiveMesh& mesh, std::span<const Bytes4> colors);
LiveBuffers make_live_buffers(const DrawSurface& surface);

// Sends the ranges of drawn vertices.
UploadCounts update(const LiveBuffers& buffers, const LiveMesh& mesh, std::span<const VertexRange> drawn);
void update_colors(const LiveBuffers& buffers, std::span<const Bytes4> colors, const VertexRange& drawn);

void draw_triangles(const LiveBuffers& buffers);
void draw_triangles(const LiveBuffers& buffers, std::span<const IndexSpan> spans);
void draw_edges(const LiveBuffers& buffers);
void draw_points(const LiveBuffers& buffers);

// Part of a picture, in samples from its lower left corner.
struct LiveRect {
  int left = 0;
  int bottom = 0;
  int right = 0;
  int top = 0;
};

// The properties of a picture's targets.
struct LiveTargetSize {
  int width = 0;
  int height = 0;
  int samples = 0;      // the driver may give others
  bool relief = false;  // with targets for LiveScene::relief

  friend bool operator==(const LiveTargetSize&, const LiveTargetSize&) = default;
};

// For the relief: normals of the shape, and the occlusion of every second sample each way.
struct LiveReliefTargets {
  gl::Renderbuffer normal_of_many;  // the second colour of LiveTargets::many; `normal` if there is a single sample
  gl::Texture normal;
  gl::Framebuffer gathered;
  gl::Framebuffer shaded;  // the colour alone, if there is a single sample
  std::array<gl::Texture, 2> occlusion;
  std::array<gl::Framebuffer, 2> occlusion_target;
};

// The targets of a picture: several samples per pixel, and the resolved picture. With one sample per pixel colours and
// normals are drawn directly into the resolved one.
struct LiveTargets {
  LiveTargetSize size;
  bool is_single = false;
  gl::Renderbuffer color;
  gl::Renderbuffer depth;  // and stencil
  gl::Framebuffer many;
  gl::Texture one_color;
  gl::Texture one_depth;
  gl::Framebuffer one;
  LiveReliefTargets relief;  // if size.relief
};

// Throws InvalidInput if the driver has no memory for them, or allows no pictures of this size.
LiveTargets make_live_targets(const LiveTargetSize& size);

// Resolves the samples of each pixel: of the colour, the depth or both. Leaves `many` bound.
void gather(const LiveTargets& targets, const LiveRect& rect, GLbitfield what);

// The same for the normals.
void gather_normals(const LiveTargets& targets, const LiveRect& rect);

// Returns the image for PlacedImage, with mipmaps.
gl::Texture make_image_texture(const Image& image);

// Returns the picture of a ball of the material for Material::matcap.
gl::Texture make_matcap_texture(Matcap matcap);

// Does the work of LiveMesh::move by compute shaders, for points that are on the GPU. Normals are those of
// set_ring_normals up to rounding.
class LiveCompute {
 public:
  // Throws GpuError if the driver has no OpenGL 4.3 or no room for a mesh of this size.
  explicit LiveCompute(const LiveMesh& mesh);

  // Moves all vertices to these points, and updates the drawn ones.
  void move(std::span<const PointBuffer> points, const Placement& placement, const LiveBuffers& drawn) const;

 private:
  gl::Program place_;
  gl::Program shade_;
  gl::Buffer placed_;      // three floats per vertex of the mesh
  gl::Buffer source_;      // per drawn vertex: the vertex of the mesh
  gl::Buffer ring_begin_;  // as Rings
  gl::Buffer ring_list_;
  std::uint32_t drawn_count_ = 0;
  bool has_rings_ = false;  // false for a cloud
};

// In renderer units: dot(normal, p) > offset is clipped.
struct LiveCut {
  Vec3d normal;  // unit
  double offset = 0;
  Color color;
};

// The steps of a picture get its frame; each draws over the content of the bound framebuffer.
struct LiveFrame {
  const LivePrograms& programs;
  const View& view;
  const LiveScene& scene;
  BoundingBall bounds;  // of the shape
  int width = 0;
  int height = 0;
  LiveRect rect;  // the part that is drawn
  std::optional<LiveCut> cut;
  const gl::Texture* matcap = nullptr;  // of Material::matcap
  bool has_normals = false;             // the shape's normals are drawn too, for its relief
  std::vector<LiveCut> sections{};      // the scene's
};

// A plane in renderer units. Throws InvalidInput for one without direction.
LiveCut live_cut(const Clip& clip, const Placement& placement);

struct LiveShape {
  const LiveMesh& mesh;
  const LiveBuffers& buffers;
  Box box;                      // renderer units
  std::vector<IndexSpan> seen;  // of the mesh's triangles
};

// Clears the targets and sets the state.
void begin_live_picture(const LiveFrame& frame, const LiveTargets& targets);

// Draws the shape, its edges, and the flat face of the cut.
void draw_live_shape(const LiveFrame& frame, const LiveShape& shape);

// Draws where nothing is yet.
void draw_live_background(const LiveFrame& frame);

struct LiveImage {
  const gl::Texture& texture;
  const PlacedImage& placed;
};

// Draws over the background, each over those before it.
void draw_live_images(const LiveFrame& frame, std::span<const LiveImage> images);

// Draws rods, faintly where they are hidden.
void draw_live_rods(const LiveFrame& frame, const LiveBuffers& rods);

struct LiveGlass {
  const LiveBuffers& buffers;
  Color color;
  double near = 0;  // extent along the view
  double far = 0;
};

// Draws backs and fronts from far to near. depths: of everything solid.
void draw_live_glass(const LiveFrame& frame, std::span<const LiveGlass> surfaces, const gl::Texture& depths);

// Copies the picture into the bound framebuffer in this size. Leaves the depth test and blending off.
void present_live(const LiveTargets& targets, int width, int height, int left, int bottom);

struct LiveReliefPrograms {
  gl::Program occlusion;
  gl::Program smooth;
  gl::Program relief;

  LiveReliefPrograms();
};

// Darkens and brightens the shape by LiveScene::relief. The shape must have been drawn into targets for relief; later
// drawing has no normals.
void draw_live_relief(const LiveFrame& frame, const LiveTargets& targets, const LiveReliefPrograms& programs);

}  // namespace knead::render
