// Planes, cylinders, spheres and faces that points of walls are kept on.
#include "engineering/wall_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

// Without vectors and threads, and of a size that is known: sums have one order everywhere.
#define EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_PARALLELIZE
#define EIGEN_MPL2_ONLY
#include <Eigen/LU>

namespace knead::detail {

namespace {

constexpr double kRound = 1e-5;      // of the radius: the allowed distance of points from a cylinder or sphere
constexpr double kAlongAxis = 1e-7;  // an axis this near to a coordinate axis is that axis
constexpr double kGreatest =
    1e3;  // radius over the patch's size; a patch with a greater one is nearly flat, and its own faces suffice
constexpr int kNewtonSteps = 40;       // of the least squares for a cylinder; about 5 are needed
constexpr double kSearchSlack = 1e-9;  // rounding of a distance
constexpr double kCreaseDegrees = 40;  // between the faces at an edge, or between the edges at a corner

bool is_before(const Vec3d& a, const Vec3d& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }

bool is_edge(const Triangle& face) { return face[1] == face[2]; }

// The unknowns that solve linear equations with the least squares of their errors.
template <int unknowns>
class LeastSquares {
 public:
  using Row = Eigen::Matrix<double, unknowns, 1>;

  void add(const Row& row, double right) {
    matrix_ += row * row.transpose();
    right_ += row * right;
  }

  // Returns nothing if the equations do not determine the unknowns.
  std::optional<Row> solve() const {
    const Eigen::FullPivLU<Eigen::Matrix<double, unknowns, unknowns>> factors(matrix_);
    if (!factors.isInvertible()) return std::nullopt;
    return factors.solve(right_);
  }

 private:
  Eigen::Matrix<double, unknowns, unknowns> matrix_ = decltype(matrix_)::Zero();
  Row right_ = Row::Zero();
};

Vec3d across(const RoundForm& form, const Vec3d& p) {
  const Vec3d arm = p - form.center;
  return arm - form.axis * dot(form.axis, arm);
}

// Two unit vectors at right angles to each other and to the axis.
std::array<Vec3d, 2> frame_of(const Vec3d& axis) {
  const Vec3d other = std::abs(axis.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d u = normalized(cross(axis, other));
  return {u, cross(axis, u)};
}

// Returns whether all points are at one distance from the centre or axis, to kRound of it. The points' size is about 1.
bool fits(const RoundForm& form, const std::vector<Vec3d>& points) {
  double least = kInfinity;
  double greatest = 0;
  for (const Vec3d& p : points) {
    const double radius = norm(across(form, p));
    least = std::min(least, radius);
    greatest = std::max(greatest, radius);
  }
  return greatest < kGreatest && greatest - least <= 2 * kRound * greatest;
}

std::optional<RoundForm> sphere_of(const std::vector<Vec3d>& points) {
  LeastSquares<4> equations;
  for (const Vec3d& p : points) equations.add({p.x, p.y, p.z, 1}, norm2(p));
  const auto found = equations.solve();
  if (!found) return std::nullopt;
  const RoundForm form{Vec3d{(*found)[0], (*found)[1], (*found)[2]} * 0.5, {0, 0, 0}};
  return fits(form, points) ? std::optional(form) : std::nullopt;
}

// Returns the middle of the circle on which the points nearly lie, seen along the axis.
bool find_center(const std::vector<Vec3d>& points, RoundForm& form) {
  const auto [u, v] = frame_of(form.axis);
  LeastSquares<3> equations;
  for (const Vec3d& p : points) {
    const double x = dot(u, p);
    const double y = dot(v, p);
    equations.add({x, y, 1}, x * x + y * y);
  }
  const auto found = equations.solve();
  if (!found) return false;
  form.center = u * (0.5 * (*found)[0]) + v * (0.5 * (*found)[1]);
  return true;
}

// Of points in the plane z = 0.
std::optional<RoundForm> circle_of(const std::vector<Vec3d>& points) {
  RoundForm form{{0, 0, 0}, {0, 0, 1}};
  return find_center(points, form) && fits(form, points) ? std::optional(form) : std::nullopt;
}

// One step of Gauss and Newton for the distances from the axis; false where it fails.
bool improve(const std::vector<Vec3d>& points, RoundForm& form, double& radius, double& step) {
  const auto [u, v] = frame_of(form.axis);
  LeastSquares<5> equations;
  for (const Vec3d& p : points) {
    const Vec3d arm = across(form, p);
    const double distance = norm(arm);
    if (!(distance > 0)) return false;
    const double x = dot(u, arm) / distance;
    const double y = dot(v, arm) / distance;
    const double along = dot(form.axis, p - form.center);
    equations.add(LeastSquares<5>::Row{{x, y, along * x, along * y, 1}}, distance - radius);
  }
  const auto found = equations.solve();
  if (!found) return false;
  const auto& change = *found;
  form.center += u * change[0] + v * change[1];
  form.axis = normalized(form.axis + u * change[2] + v * change[3]);
  radius += change[4];
  step = change.cwiseAbs().maxCoeff();
  return change.allFinite();
}

// The greatest face's normal, and the normal that is farthest from it, are both across the axis, nearly.
std::optional<Vec3d> axis_of(std::vector<Vec3d> normals) {
  if (normals.empty()) return std::nullopt;
  for (Vec3d& n : normals) n = is_before(n, n * -1.0) ? n * -1.0 : n;
  std::sort(normals.begin(), normals.end(), is_before);
  const Vec3d first = *std::max_element(normals.begin(), normals.end(),
                                        [](const Vec3d& a, const Vec3d& b) { return norm2(a) < norm2(b); });
  Vec3d axis{};
  for (const Vec3d& n : normals) {
    const Vec3d across_both = norm(n) > 0 ? cross(first, n) / norm(n) : Vec3d{};
    if (norm2(across_both) > norm2(axis)) axis = across_both;
  }
  if (!(norm(axis) > 0)) return std::nullopt;
  return normalized(axis);
}

void snap_axis(RoundForm& form) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::abs(form.axis[k]) < 1 - kAlongAxis * kAlongAxis) continue;
    form.axis = {0, 0, 0};
    form.axis[k] = 1;
  }
}

std::optional<RoundForm> cylinder_of(const std::vector<Vec3d>& points, const std::vector<Vec3d>& normals) {
  const std::optional<Vec3d> axis = axis_of(normals);
  if (!axis) return std::nullopt;
  RoundForm form{{0, 0, 0}, *axis};
  if (!find_center(points, form)) return std::nullopt;
  double radius = 0;
  for (const Vec3d& p : points) radius += norm(across(form, p)) / static_cast<double>(points.size());
  double step = 1;
  for (int i = 0; i < kNewtonSteps && step > 1e-13; ++i) {
    if (!improve(points, form, radius, step)) return std::nullopt;
  }
  snap_axis(form);
  return fits(form, points) ? std::optional(form) : std::nullopt;
}

}  // namespace

Vec3d wall_normal(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return b == c ? cross(b - a, Vec3d{0, 0, 1}) : cross(b - a, c - a);
}

std::optional<RoundForm> round_form_of(std::span<const Triangle> faces, std::span<const Vec3d> points) {
  Box box;
  std::vector<std::uint32_t> numbers;
  for (const Triangle& face : faces) numbers.insert(numbers.end(), face.begin(), face.end());
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  for (const std::uint32_t i : numbers) box.extend(points[i]);
  if (numbers.size() < 5 || !(box.diagonal() > 0)) return std::nullopt;
  const Vec3d middle = (box.min + box.max) * 0.5;
  const double size = box.diagonal();
  const auto scaled = [&](std::uint32_t i) { return (points[i] - middle) / size; };
  std::vector<Vec3d> places;
  places.reserve(numbers.size());
  for (const std::uint32_t i : numbers) places.push_back(scaled(i));
  std::sort(places.begin(), places.end(), is_before);
  std::optional<RoundForm> form = is_edge(faces.front()) ? circle_of(places) : sphere_of(places);
  if (!form && !is_edge(faces.front())) {
    std::vector<Vec3d> normals;
    for (const Triangle& face : faces) {
      std::array<Vec3d, 3> corners{scaled(face[0]), scaled(face[1]), scaled(face[2])};
      std::sort(corners.begin(), corners.end(), is_before);
      normals.push_back(wall_normal(corners[0], corners[1], corners[2]));
    }
    form = cylinder_of(places, normals);
  }
  if (form) form->center = middle + form->center * size;
  return form;
}

WallSurface::WallSurface(Form form, std::span<const std::uint32_t> numbers, std::span<const Triangle> faces,
                         std::span<const Vec3d> points)
    : form_(form), numbers_(numbers.begin(), numbers.end()) {
  const auto place_of = [&](std::uint32_t number) {
    const auto found = std::lower_bound(numbers_.begin(), numbers_.end(), number);
    return static_cast<std::uint32_t>(found - numbers_.begin());
  };
  for (const std::uint32_t i : numbers_) start_.push_back(points[i]);
  for (const Triangle& face : faces) faces_.push_back({place_of(face[0]), place_of(face[1]), place_of(face[2])});
  tree_.emplace(faces_, start_);
  first_around_.assign(numbers_.size() + 1, 0);
  const auto corners_of = [](const Triangle& face) { return std::span(face).first(is_edge(face) ? 2 : 3); };
  for (const Triangle& face : faces_) {
    for (const std::uint32_t v : corners_of(face)) ++first_around_[v + 1];
  }
  for (std::size_t v = 0; v < numbers_.size(); ++v) first_around_[v + 1] += first_around_[v];
  around_.resize(first_around_.back());
  std::vector<std::size_t> next(first_around_.begin(), first_around_.end() - 1);
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    for (const std::uint32_t v : corners_of(faces_[f])) around_[next[v]++] = f;
  }
  const auto normal_of = [&](std::uint32_t f) {
    return wall_normal(start_[faces_[f][0]], start_[faces_[f][1]], start_[faces_[f][2]]);
  };
  for (std::size_t v = 0; v < numbers_.size(); ++v) {
    for (std::size_t k = first_around_[v]; k < first_around_[v + 1]; ++k) {
      sides_.push_back(dot(normal_of(around_[k]), normal_of(around_[first_around_[v]])) < 0 ? -1 : 1);
    }
  }
  if (form_ == Form::polygons) find_lines();
}

// The edges of the patch, and those where its faces meet at an angle.
void WallSurface::find_lines() {
  struct Side {
    std::uint32_t low, high, face;
    bool is_forward;
  };
  std::vector<Side> sides;
  std::vector<Triangle> lines;
  const auto add_line = [&](std::uint32_t a, std::uint32_t b) { lines.push_back({a, b, b}); };
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    if (is_edge(faces_[f])) add_line(faces_[f][0], faces_[f][1]);
    for (std::size_t k = 0; k < 3 && !is_edge(faces_[f]); ++k) {
      const std::uint32_t a = faces_[f][k];
      const std::uint32_t b = faces_[f][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), f, a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
  });
  const double least = std::cos(kCreaseDegrees * std::numbers::pi / 180);
  const auto unit = [&](const Side& side) {
    const Triangle& face = faces_[side.face];
    const Vec3d normal = wall_normal(start_[face[0]], start_[face[1]], start_[face[2]]);
    return norm(normal) > 0 ? normal / (side.is_forward ? norm(normal) : -norm(normal)) : normal;
  };
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i;
    while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
    // Two faces that look to the same side pass their common edge in opposite directions.
    if (end - i != 2 || -dot(unit(sides[i]), unit(sides[i + 1])) < least) add_line(sides[i].low, sides[i].high);
    i = end;
  }
  places_.assign(numbers_.size(), Place::face);
  std::vector<std::vector<std::uint32_t>> ends(numbers_.size());
  for (const Triangle& line : lines) {
    ends[line[0]].push_back(line[1]);
    ends[line[1]].push_back(line[0]);
  }
  for (std::size_t v = 0; v < numbers_.size(); ++v) {
    if (ends[v].empty()) continue;
    const auto along = [&](std::size_t k) { return start_[ends[v][k]] - start_[v]; };
    const bool goes_on = ends[v].size() == 2 && -dot(along(0), along(1)) >= least * norm(along(0)) * norm(along(1));
    places_[v] = goes_on ? Place::line : Place::corner;
  }
  if (!lines.empty()) lines_.emplace(lines, start_);
}

Vec3d WallSurface::put_back(std::size_t i, const Vec3d& p, const Vec3d& before) const {
  switch (form_) {
    case Form::fixed:
    case Form::open:
      return p;
    case Form::plane:
      return p - form_of_.axis * dot(form_of_.axis, p - start_[i]);
    case Form::round: {
      const Vec3d arm = across(form_of_, p);
      const double distance = norm(arm);
      if (!(distance > 0)) return p;
      return p + arm * (norm(across(form_of_, start_[i])) / distance - 1);
    }
    case Form::polygons:
      break;
  }
  if (places_[i] == Place::corner) return start_[i];
  const SurfaceTree& surface = places_[i] == Place::line ? *lines_ : *tree_;
  auto found = surface.closest(p, (1 + kSearchSlack) * norm(p - before));
  if (!found) found = surface.closest(p);  // where rounding, or another wall, has taken the point off this one before
  return found ? found->point : p;
}

std::vector<Vec3d> WallSurface::normals(std::span<const Vec3d> places) const {
  std::vector<Vec3d> result(numbers_.size());
  for (std::size_t v = 0; v < numbers_.size(); ++v) {
    Vec3d sum{};
    for (std::size_t k = first_around_[v]; k < first_around_[v + 1]; ++k) {
      const Triangle& face = faces_[around_[k]];
      sum += wall_normal(places[face[0]], places[face[1]], places[face[2]]) * sides_[k];
    }
    if (norm(sum) > 0) result[v] = sum / norm(sum);
  }
  return result;
}

}  // namespace knead::detail
