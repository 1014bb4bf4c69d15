// The fields of moving point sets, cut into cells of the tool's space in which few elements stand for all. Internal to
// the flow room.
#pragma once

#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "knead/field/packed_set.h"
#include "knead/flow/masked.h"
#include "knead/flow/point_tree.h"
#include "knead/flow/single_field.h"
#include "knead/math/box.h"

namespace knead::detail {

template <class S>
using SetField = SingleField<S, Translation<S>, PackedSet<S>>;

// Whether SetCells takes the segment: translations of point sets, swept.
bool is_of_sets(const Segment& segment);

// A cube of space in the tool's frame, and the fields that reach into it, each with the elements that count there and
// a scale for their sums.
template <class S>
struct SetCell {
  int index = 0;  // among all cells
  Vec3d center;
  std::vector<SetField<S>> fields;  // empty: v = 0 everywhere in the cell
  bool inside = false;              // r < outer of some field everywhere in the cell
};

// Cells are anchored at the tool and made when a path line first needs them, each from the segment alone, so that the
// result of a point depends neither on other points nor on threads. Within a cell the field is one smooth function with
// its exact gradient, hence divergence-free. It differs from the field of all elements by so little that positions err
// by about a tenth of the tolerance at most. A path line keeps the cell in which it begins as long as it is within
// reach of it: in a short segment to its end.
template <class S>
class SetCells {
 public:
  SetCells(const Segment& segment, double tolerance, const SegmentMask& mask = {});
  SetCells(const SetCells&) = delete;
  SetCells& operator=(const SetCells&) = delete;
  ~SetCells();

  // Of one path line: the cell that it is in, null outside all of them.
  using Place = const SetCell<S>*;

  // The earliest time from t on at which the resting point x can be inside the support; moves `place` along.
  std::optional<double> next_contact(Place& place, const Segment& segment, const Vec3d& x, double t) const;

  // The cell in which x is at the time t.
  Place cell_at(const Vec3d& x, double t) const { return cell_at(in_tool(x, t)); }

  // Moves `place` along with a path line that has come to x. Whether it is still the same.
  bool keeps(Place& place, const Vec3d& x, double t) const;

  Vec3<S> velocity(Place place, const Vec3d& x0, const Vec3<S>& moved, double t) const {
    Vec3<S> sum{};
    if (place == nullptr) return sum;
    for (const SetField<S>& field : place->fields) sum += field.velocity(x0, moved, t);
    return sum;
  }

 private:
  struct Part {
    SetField<S> field;  // with all elements
    Vec3d offset;       // of its centre from the anchor
    Box box;            // of its elements, about its centre
    double reach = 0;   // beyond this true distance r >= outer
    double error = 0;   // of v that is allowed, by the tool's speed
    double outer = 0;
    PointTree tree;
  };

  Part make_part(const Field& field, double error) const;
  void lay_grid();
  int cell_count() const { return counts_[0] * counts_[1] * counts_[2]; }
  Vec3d in_tool(const Vec3d& x, double t) const { return x - anchor_ - displacement_ * t; }
  bool holds(Place place, const Vec3d& d) const;
  Place cell_at(const Vec3d& d) const;
  std::unique_ptr<SetCell<S>> make_cell(const Vec3d& center) const;
  void add_part(const Part& part, SetCell<S>& cell) const;
  double safe_advance(Place place, const Vec3d& d, const Vec3d& velocity) const;

  Vec3d anchor_;
  Vec3d displacement_;
  double duration_;  // at most, of a path line
  std::vector<Part> parts_;
  Box box_;               // of the supports, in the tool's frame
  double size_ = 0;       // of a cell
  double excursion_ = 0;  // how far a step's stages may leave what a cell holds
  double home_ = 0;       // half the edge of the cube in which a path line keeps its cell
  double radius_ = 0;     // of the ball about a cell's centre in which its lists are valid
  double inverse_size_ = 0;
  std::array<int, 3> counts_{};
  std::unique_ptr<std::atomic<const SetCell<S>*>[]> cells_;
};

extern template class SetCells<float>;
extern template class SetCells<double>;

}  // namespace knead::detail
