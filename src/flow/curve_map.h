// The map of a curve and its surroundings at one time, in closed form (docs/mathematics.md, "Curves"). Internal to the
// library.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "flow/segment_mover.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// The number of powers of a cell's coordinate in its polynomials.
inline constexpr int kCurvePowers = 10;

// The coordinates of a point about a curve at t = 0: the length along it, and the place across it in its frame.
template <class T>
struct CurvePoint {
  T s{};
  T across[2]{};
};

// A curve at a time, as polynomials in cells of equal length. Places are relative to CurveMotion::place. S: double, or
// a dual number of one variable, the time.
template <class S>
class CurveTable {
 public:
  CurveTable(const CurveMotion& curve, const S& time);

  // Sets the place of a point. T: S, or a dual number. Returns false where 2 u >= 1, because the map is not defined
  // there.
  template <class T>
  bool place(const CurvePoint<T>& at, Vec3<T>& x) const;

  // Returns the point whose place is x: of all such points the nearest to the curve; nothing if there is none.
  std::optional<CurvePoint<double>> find(const Vec3d& x) const;

  // The same for the straight line beyond an end, wherever x is.
  CurvePoint<double> beyond(bool last, const Vec3d& x) const;

  // The frame at an end: beyond it the surroundings are rigid, but for its stretch.
  struct End {
    Vec3<S> place;
    std::array<Vec3<S>, 3> frame;         // with the twist
    S along = S(1);                       // what lengths become beyond it
    std::array<S, 2> narrow{S(1), S(1)};  // what the coordinates across are divided by
    friend bool operator==(const End&, const End&) = default;
  };
  const End& end(bool last) const { return ends_[last ? 1 : 0]; }
  double length() const { return length_; }

 private:
  // The columns of the powers of z from the cell's origin, its border nearer to the anchor.
  enum Column : std::size_t {
    kPlace = 0,
    kFirst = 3,
    kSecond = 6,
    kBend = 9,
    kTwistAngle = 11,
    kStretch,
    kTangent,
    kColumns = 16
  };
  using Powers = std::array<S, kColumns>;
  using Cell = std::array<Powers, kCurvePowers>;

  // The values of the columns at a place of the curve.
  template <class T>
  struct Section : std::array<T, kColumns> {
    Vec3<T> vector(Column first) const { return {(*this)[first], (*this)[first + 1U], (*this)[first + 2U]}; }
  };

  // What lengths along the curve become by a stretch, and what the coordinates across are divided by.
  template <class T>
  T along(const T& stretch) const {
    return keeps_length_ ? T(1) : stretch;
  }
  template <class T>
  std::array<T, 2> narrowing(const T& stretch) const;

  void fill_nodes(const CurveMotion& curve, const S& time, int cell, int parts, double origin, Cell& to) const;
  void integrate(Cell& cell, End& border, S& twist) const;
  template <std::size_t kCount = kColumns, class T>
  Section<T> section(const T& s) const;
  template <std::size_t kCount = kColumns, class T>
  static Section<T> value_at(const Cell& cell, const T& z);
  // A place of the curve, and its squared distance from a point.
  struct Start {
    double s = 0;
    double distance = kInfinity;
  };
  std::array<Start, 2> starts_near(const Vec3d& x) const;
  double distance_to(const Vec3d& x, double s) const;
  // Newton's step for (x - C(s)).T(s) = 0 from the section at s; nothing at or beyond the centre of curvature.
  std::optional<double> step_from(const Section<double>& here, const Vec3d& x) const;
  std::optional<double> length_at(const Vec3d& x, double s) const;
  std::optional<CurvePoint<double>> on_section(const Vec3d& x, double s) const;

  double length_;
  double per_cell_;  // cells by length
  int origin_cell_;  // the first cell after the anchor
  bool twists_ = false;
  bool stretches_ = false;
  bool keeps_thickness_;
  bool keeps_length_;
  bool one_across_;
  std::array<double, 2> part_;
  std::vector<Cell> cells_;
  std::vector<Vec3d> stations_;  // places of some cells, where the search for the nearest place begins
  double station_gap_ = 0;       // the greatest distance from one to the next
  std::array<End, 2> ends_;
};

// The space in which a segment with a curve may move points.
class CurveSupport {
 public:
  explicit CurveSupport(const Segment& segment);

  // Returns true only if no point of the ball moves.
  bool misses(const Vec3d& center, double radius) const;

 private:
  Vec3d first_;  // the end of the curve
  Vec3d tangent_;
  double length_;
  std::optional<double> radius_;
  bool is_straight_;             // the curve is straight at the beginning; else everything may move
  std::array<bool, 2> rests_{};  // the parts beyond the curve's first and last end rest
};

// The motion of points about a curve from one time to another.
class CurveMap {
 public:
  // The segment must have a curve.
  explicit CurveMap(const Segment& segment);

  enum class Status { moved, rests, impossible };
  Status move(Vec3d& x) const;

  // The same, with the Jacobian there.
  Status move(Vec3d& x, Mat3d& jacobian) const;

 private:
  std::optional<CurvePoint<double>> find(const Vec3d& x) const;
  bool rests(double s) const { return (s <= 0 && rest_[0]) || (s >= begin_.length() && rest_[1]); }

  Vec3d origin_;
  CurveTable<double> begin_;
  CurveTable<double> end_;
  std::optional<double> radius_;
  std::array<bool, 2> rest_{};  // what is beyond the curve's first and last end
  bool is_straight_ = false;    // at the beginning
};

// Returns v at points about a curve, for each unit of the segment's time t.
std::vector<Vec3d> curve_velocities(const CurveMotion& curve, std::span<const Vec3d> points, double t);

}  // namespace knead::detail
