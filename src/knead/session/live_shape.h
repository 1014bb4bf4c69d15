// A shape that strokes are done on one after the other. Internal to the session room.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knead/mesh/triangulate.h"
#include "knead/session/moved_shape.h"
#include "knead/session/remeshed_shape.h"
#include "knead/session/replay.h"
#include "knead/session/workbench.h"

namespace knead::session_detail {

class LiveShape {
 public:
  LiveShape(Mesh mesh, const std::filesystem::path& folder, std::vector<std::uint32_t> face_labels, int threads);

  const ShapeState& base() const { return base_; }

  // Goes to a state of this shape. `again`: it will be gone to many times, so that it is kept at hand.
  void rest_at(const ShapeState& state, bool again = false);

  // Lays the vertices out for being moved, where that is not done.
  void prepare() {
    if (!shape_.blocks) shape_.blocks.emplace(shape_.positions);
  }

  // Moves the shape, which then is between states. Throws InvalidInput for a stroke that cannot be done here; then, and
  // where the status is not `done`, the shape is somewhere part-way: go to a state again.
  AdvectStatus apply(const Flow& flow, Progress* progress);
  AdvectStatus apply(const SessionStroke& stroke, Progress* progress);  // with its remesh settings

  // The shape as it is. Memory is shared with `before`.
  ShapeState state(const ShapeState& before);

  std::uint64_t steps() const { return steps_; }  // accepted, since the beginning
  // The last of the strokes that one which read the surface became, since this was last asked for.
  std::optional<Stroke> take_part() { return std::exchange(part_, std::nullopt); }
  std::vector<std::string> take_warnings() { return std::exchange(warnings_, {}); }

 private:
  struct Kept {
    ShapeState state;
    MovedShape shape;
  };

  void move_by(const Flow& flow, const MoveOptions& options);
  void apply_planned(const SessionStroke& stroke, Progress* progress);
  // The stroke's flow; moves the shape through it unless it has a barrel or is to be remeshed.
  Flow read(const SessionStroke& stroke, bool may_move, const MoveOptions& options);
  void remesh(const SessionStroke& stroke, const Flow& flow, const MoveOptions& options);
  MoveOptions options(Progress* progress) const;
  std::span<const Triangle> triangles();

  Session session_;  // for messages, and what the files of stamps are relative to
  ReplayOptions replay_;
  double diagonal_ = 1;
  std::vector<std::uint32_t> face_labels_;
  ShapeState base_;
  std::shared_ptr<const RemeshedShape> trail_;  // of the shape as it is
  MovedShape shape_;
  std::optional<ShapeState> at_;  // where the shape rests
  std::optional<Kept> kept_;
  std::shared_ptr<const RemeshedShape> triangulated_;  // what triangles_ are of
  std::vector<Triangle> triangles_;
  std::uint64_t steps_ = 0;
  std::optional<Stroke> part_;
  std::vector<std::string> warnings_;
};

// Whether both are the same, to the bit.
bool are_same(const ShapeState& a, const ShapeState& b);

}  // namespace knead::session_detail
