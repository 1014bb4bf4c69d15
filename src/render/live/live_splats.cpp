// LiveSplats: the textures that hold splats, and the thread that sorts them.
#include "render/live/live_splats.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "knead/error.h"
#include "math/geometry.h"
#include "render/splat_attributes.h"

namespace knead::render {
namespace {

constexpr std::size_t kStep = 65536;  // splats
constexpr std::size_t kKeys = 65536;  // of half a key
constexpr int kPasses = 3;
constexpr int kStepsAFrame = 3;  // without a thread
constexpr std::size_t kGrain = 4096;
constexpr std::uint32_t kQuadIndices = 6 * kSplatRow;

// On a page, waiting for a new thread may never end.
#if defined(__EMSCRIPTEN__)
constexpr bool kHasThread = false;
#else
constexpr bool kHasThread = true;
#endif

// Returns a number that grows with the depth.
std::uint32_t key_of(float depth) {
  const auto bits = bit_cast<std::uint32_t>(depth);
  return bits >> 31 != 0 ? ~bits : bits | 0x80000000U;
}

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(std::isnan(value) ? 0 : value, 0.0, 1.0)));
}

// The sum of a a^T of the axes.
std::array<Vec3f, 2> covariance_of(const std::array<Vec3d, 3>& axes) {
  Vec3d first;
  Vec3d second;
  for (const Vec3d& a : axes) {
    first += Vec3d{a.x * a.x, a.x * a.y, a.x * a.z};
    second += Vec3d{a.y * a.y, a.y * a.z, a.z * a.z};
  }
  return {Vec3f(first), Vec3f(second)};
}

// Returns J S J^T.
std::array<Vec3f, 2> deformed(const std::array<Vec3f, 2>& covariance, const Mat3d& j) {
  const auto& [a, b] = covariance;
  const Mat3d s{{a.x, a.y, a.z}, {a.y, b.x, b.y}, {a.z, b.y, b.z}};
  const Mat3d t = j * s * transposed(j);
  return {Vec3f(t.column(0)), Vec3f(Vec3d{t.column(1).y, t.column(2).y, t.column(2).z})};
}

SplatColors colors_of(const SplatAttributes& splats, const LiveMesh& drawn) {
  SplatColors colors;
  colors.harmonics = splats.degree() * (splats.degree() + 2);
  const std::size_t numbers = 3 * (1 + colors.harmonics);
  colors.numbers.resize(numbers * drawn.vertices().size());
  colors.opacities.resize(drawn.vertices().size());
  drawn.for_each_drawn({0, static_cast<std::uint32_t>(drawn.vertex_count())}, [&](std::uint32_t v, std::uint32_t d) {
    float* number = &colors.numbers[numbers * d];
    for (std::size_t c = 0; c < 3; ++c) *number++ = static_cast<float>(splats.base(v, c));
    for (std::size_t i = 0; i < 3 * colors.harmonics; ++i) {
      *number++ = static_cast<float>(splats.harmonic(v, i / colors.harmonics, i % colors.harmonics));
    }
    colors.opacities[d] = to_byte(splats.opacity(v));
  });
  return colors;
}

// The format of a texture, with some texels for each splat.
struct Texels {
  GLenum format;
  GLenum type;
  std::uint32_t count;  // for each splat
  std::size_t bytes;    // of a splat
};

constexpr Texels kTwoVectors{GL_RGB, GL_FLOAT, 2, sizeof(LiveVertex)};
constexpr Texels kFourBytes{GL_RGBA, GL_UNSIGNED_BYTE, 1, sizeof(Bytes4)};
constexpr Texels kIndex{GL_RED_INTEGER, GL_UNSIGNED_INT, 1, sizeof(std::uint32_t)};
static_assert(sizeof(LiveVertex) == 2 * sizeof(Vec3f) && sizeof(std::array<Vec3f, 2>) == 2 * sizeof(Vec3f));

// Sends the rows of these splats. data: those of all splats; an offset where a buffer is bound.
void send(const gl::Texture& texture, const Texels& texels, const VertexRange& splats, std::uintptr_t data) {
  const std::uint32_t first = splats.begin / kSplatRow;
  const std::uint32_t last = splats.end / kSplatRow;  // may be part of a row
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  const auto send_part = [&](std::uint32_t y, std::uint32_t rows, std::uint32_t splats_in_row) {
    if (rows == 0 || splats_in_row == 0) return;
    const std::uintptr_t at = data + texels.bytes * kSplatRow * y;
    const auto* const from =
        reinterpret_cast<const void*>(at);  // NOLINT(performance-no-int-to-ptr): as OpenGL takes it
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, static_cast<GLint>(y), static_cast<GLsizei>(splats_in_row * texels.count),
                    static_cast<GLsizei>(rows), texels.format, texels.type, from);
  };
  send_part(first, last - first, kSplatRow);
  send_part(last, 1, splats.end % kSplatRow);
}

template <class T>
void send_all(const gl::Texture& texture, const Texels& texels, const std::vector<T>& values) {
  send(texture, texels, {0, static_cast<std::uint32_t>(values.size())},
       reinterpret_cast<std::uintptr_t>(values.data()));
}

// The GPU copies from the buffer.
void send_from(const gl::Buffer& buffer, const gl::Texture& texture, const Texels& texels, const VertexRange& splats) {
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer.get());
  send(texture, texels, splats, 0);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

}  // namespace

SplatSorter::SplatSorter(std::shared_ptr<const SplatColors> colors, std::shared_ptr<const SplatTurns> turns,
                         std::vector<Vec3f> places, const SplatView& view)
    : colors_(std::move(colors)),
      turns_(std::move(turns)),
      places_(std::move(places)),
      view_(view),
      keys_(places_.size()),
      half_sorted_(places_.size()),
      order_(places_.size()),
      seen_colors_(places_.size()) {
  for (std::vector<std::uint32_t>& begin : begins_) begin.resize(kKeys + 1);
}

// Returns the direction in which a splat is seen, as it was before the splat was turned.
Vec3d SplatSorter::direction_to(std::size_t splat) {
  Vec3d direction = view_.forward;
  if (view_.is_perspective) {
    direction = Vec3d(places_[splat]) - view_.eye;
    direction = direction / std::max(norm(direction), 1e-30);
  }
  while (next_turn_ < turns_->size() && (*turns_)[next_turn_].first < splat) ++next_turn_;
  const bool is_turned = next_turn_ < turns_->size() && (*turns_)[next_turn_].first == splat;
  return is_turned ? (*turns_)[next_turn_].second * direction : direction;
}

void SplatSorter::see(std::size_t splat) {
  const std::uint32_t key = key_of(static_cast<float>(dot(Vec3d(places_[splat]) - view_.eye, view_.forward)));
  keys_[splat] = key;
  ++begins_[0][key % kKeys + 1];
  ++begins_[1][key / kKeys + 1];
  const std::size_t count = colors_->harmonics;
  const float* const base = &colors_->numbers[3 * (1 + count) * splat];
  std::array<double, 15> y{};
  if (count > 0) y = splat_harmonics(direction_to(splat));
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = base[c];
    for (std::size_t k = 0; k < count; ++k) sum += y[k] * base[3 + c * count + k];
    seen_colors_[splat][c] = to_byte(sum / kBrightestSplat);
  }
  seen_colors_[splat][3] = colors_->opacities[splat];
}

bool SplatSorter::step() {
  if (pass_ == kPasses) return true;
  const std::size_t end = std::min(places_.size(), at_ + kStep);
  for (; at_ < end; ++at_) {
    if (pass_ == 0) {
      see(at_);
    } else if (pass_ == 1) {
      half_sorted_[begins_[0][keys_[at_] % kKeys]++] = static_cast<std::uint32_t>(at_);
    } else {
      const std::uint32_t splat = half_sorted_[at_];
      order_[order_.size() - 1 - begins_[1][keys_[splat] / kKeys]++] = splat;
    }
  }
  if (at_ < places_.size()) return false;
  at_ = 0;
  if (pass_ == 0) {
    for (std::vector<std::uint32_t>& begin : begins_) {
      for (std::size_t i = 0; i < kKeys; ++i) begin[i + 1] += begin[i];
    }
  }
  return ++pass_ == kPasses;
}

bool LiveSplats::have_room(std::size_t count) {
  GLint rows = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &rows);
  return count / kSplatRow < static_cast<std::size_t>(rows);
}

LiveSplats::LiveSplats(const Mesh& mesh, const LiveMesh& drawn, double scale, const LiveBuffers& buffers)
    : count_(static_cast<std::uint32_t>(drawn.vertices().size())), covariances_(count_), scale_(scale) {
  const SplatAttributes splats(mesh);
  const auto rows = static_cast<int>(count_ / kSplatRow + 1);
  colors_ = std::make_shared<const SplatColors>(colors_of(splats, drawn));
  drawn.for_each_drawn({0, static_cast<std::uint32_t>(drawn.vertex_count())}, [&](std::uint32_t v, std::uint32_t d) {
    std::array<Vec3d, 3> axes = splats.axes(v);
    for (Vec3d& axis : axes) axis = axis * scale_;
    covariances_[d] = covariance_of(axes);
  });
  constexpr int wide = kSplatRow;
  place_map_ = gl::make_texture(2 * wide, rows, GL_RGB32F);
  shape_map_ = gl::make_texture(2 * wide, rows, GL_RGB32F);
  color_map_ = gl::make_texture(wide, rows, GL_RGBA8);
  tint_map_ = gl::make_texture(wide, rows, GL_RGBA8);
  order_map_ = gl::make_texture(wide, rows, GL_R32UI);
  quick_step_ = std::max(1U, (count_ + kQuickSplats - 1) / kQuickSplats);
  if (quick_step_ > 1) quick_order_map_ = gl::make_texture(wide, rows / static_cast<int>(quick_step_) + 1, GL_R32UI);
  std::vector<std::uint16_t> corners;
  for (std::uint32_t quad = 0; quad < kSplatRow; ++quad) {
    for (const std::uint32_t corner : {0, 1, 2, 2, 1, 3}) {
      corners.push_back(static_cast<std::uint16_t>(4 * quad + corner));
    }
  }
  layout_ = gl::make_vertex_array();
  corners_ = gl::make_buffer(GL_ELEMENT_ARRAY_BUFFER, corners.data(), corners.size() * sizeof(corners[0]));
  take_places(buffers, {0, count_});
  take_tints(buffers, {0, count_});
  send_all(shape_map_, kTwoVectors, covariances_);
}

void LiveSplats::deform(const SplatJacobians* jacobians, const LiveMesh& drawn) {
  std::vector<std::array<Vec3f, 2>> covariances = covariances_;
  SplatTurns turns;
  if (jacobians != nullptr) {
    turns.resize(jacobians->splats.size());
    parallel_for(turns.size(), kGrain, 0, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t vertex = jacobians->splats[i];
        const Mat3d& jacobian = jacobians->jacobians[i];
        turns[i].first = count_;
        if (vertex >= drawn.vertex_count()) continue;
        drawn.for_each_drawn({vertex, vertex + 1}, [&](std::uint32_t, std::uint32_t d) {
          covariances[d] = deformed(covariances[d], jacobian);
          turns[i] = {d, colors_->harmonics > 0 ? transposed(nearest_rotation(jacobian)) : Mat3d{}};
        });
      }
    });
    std::erase_if(turns, [&](const auto& turn) { return turn.first == count_; });
  }
  turns_ = std::make_shared<const SplatTurns>(std::move(turns));
  send_all(shape_map_, kTwoVectors, covariances);
  is_stale_ = true;
}

void LiveSplats::take_places(const LiveBuffers& buffers, const VertexRange& drawn) {
  send_from(buffers.vertices, place_map_, kTwoVectors, drawn);
  is_stale_ = true;
}

void LiveSplats::take_tints(const LiveBuffers& buffers, const VertexRange& drawn) {
  send_from(buffers.colors, tint_map_, kFourBytes, drawn);
}

bool LiveSplats::has_news() const {
  return sorter_ && (!work_.valid() || work_.wait_for(std::chrono::seconds(0)) == std::future_status::ready);
}

// Returns whether the order is complete. Without a thread, gets on with it.
bool LiveSplats::advance() {
  if (work_.valid()) return has_news();
  for (int i = 0; i < kStepsAFrame; ++i) {
    if (sorter_->step()) return true;
  }
  return false;
}

void LiveSplats::start(const SplatView& view, const LiveMesh& drawn) {
  std::vector<Vec3f> places;
  places.reserve(count_);
  for (const LiveVertex& vertex : drawn.vertices()) places.push_back(vertex.position);
  sorter_ = std::make_unique<SplatSorter>(colors_, turns_, std::move(places), view);
  view_ = view;
  is_stale_ = false;
  if (!kHasThread) return;
  work_ = std::async(std::launch::async, [sorter = sorter_.get()] {
    while (!sorter->step()) {
    }
  });
}

// Waits for the order, and sends it.
void LiveSplats::finish() {
  if (work_.valid()) {
    work_.get();
  } else {
    while (!sorter_->step()) {
    }
  }
  send_all(order_map_, kIndex, sorter_->order());
  if (quick_step_ > 1) {
    std::vector<std::uint32_t> order = sorter_->order();
    std::erase_if(order, [&](std::uint32_t splat) { return splat % quick_step_ != 0; });
    send_all(quick_order_map_, kIndex, order);
  }
  send_all(color_map_, kFourBytes, sorter_->colors());
  sorter_.reset();
  has_order_ = true;
}

void LiveSplats::sort_for(const SplatView& view, const LiveMesh& drawn, bool is_exact) {
  const bool waits = is_exact || !has_order_;
  if (sorter_ && (waits || advance())) finish();
  if (!sorter_ && (is_stale_ || !(view_ == view))) start(view, drawn);
  if (sorter_ && waits) finish();
}

void LiveSplats::draw(const gl::Program& program, bool is_quick) const {
  is_quick = is_quick && quick_step_ > 1;
  const std::uint32_t step = is_quick ? quick_step_ : 1;
  const std::array<std::pair<const char*, const gl::Texture*>, 5> maps{
      {{"order_map", is_quick ? &quick_order_map_ : &order_map_},
       {"place_map", &place_map_},
       {"shape_map", &shape_map_},
       {"color_map", &color_map_},
       {"tint_map", &tint_map_}}};
  for (int unit = 0; unit < static_cast<int>(maps.size()); ++unit) {
    const auto& [name, texture] = maps.at(static_cast<std::size_t>(unit));
    gl::bind_texture(program, name, unit, GL_TEXTURE_2D, *texture);
  }
  const std::uint32_t count = (count_ + step - 1) / step;
  glUniform1i(gl::uniform(program, "count"), static_cast<GLint>(count));
  glUniform1f(gl::uniform(program, "enlargement"), static_cast<float>(step));
  glBindVertexArray(layout_.get());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, corners_.get());
  const auto rows = static_cast<GLsizei>((count + kSplatRow - 1) / kSplatRow);
  glDrawElementsInstanced(GL_TRIANGLES, kQuadIndices, GL_UNSIGNED_SHORT, nullptr, rows);
}

}  // namespace knead::render
