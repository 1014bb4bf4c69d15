// The tool "print": letters, grey pictures and faces of meshes as sums of wide pushes.
#include "strokes/print.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/elementary.h"
#include "strokes/describe.h"
#include "strokes/push_grids.h"

namespace knead {

namespace {

using namespace detail;

constexpr double kPushesApart = 0.4;        // pushes, of the bump
constexpr double kBumpOfHeight = 1.0 / 12;  // by default, at most
constexpr double kOuterOfHeight = 2;        // by default
constexpr double kStepsPerBump = 2;         // each with the pushes on the surface at that time
constexpr double kMinPrintSteps = 4;
constexpr double kMaxPrintSteps = 300;
constexpr double kMaxNodes = 2e7;        // of the grids of all steps: half a gigabyte
constexpr int kPixelsOfFace = 192;       // along the longer side
constexpr double kAround = 2.5;          // pushes: the bump
constexpr double kPathTolerance = 1e-4;  // of path lines, of the bump
constexpr double kHairline = 0.1;        // of the area may be thinner than the thinnest stroke
constexpr double kThinner = 1.1;         // of the thinnest stroke: a remark if twice the bump is more
constexpr double kMaxCells = 4e5;        // of all tiles, and places
constexpr double kFewSteps = 4;          // of a walk along the surface, for each height
constexpr double kSteepUp = 0.1;         // of a unit vector, across the normal: the least of "up"
constexpr double kMissing = 0.02;        // of the pattern: a missing part from which on there is a remark
constexpr double kTooCoarse = 1;         // of the bump: the length of an edge that cannot show the print

// The frame of a tile: a plane that touches the surface, with the pattern's directions.
struct TilePlane {
  Vec3d center;
  Vec3d right;
  Vec3d up;
  Vec3d normal;
};

// A place of the surface that is pushed.
struct PushedPlace {
  Vec3d start;
  Vec3d direction;
  double value = 0;   // of the pattern
  double wanted = 0;  // the displacement at the end, along the direction
  double got = 0;
  std::array<int, 2> cell{};  // column and row in its tile
};

// Places on a square lattice in a tile.
struct Raster {
  int columns = 0;
  int rows = 0;
  std::vector<double> values;          // of the pattern; in cells
  std::vector<std::int32_t> place_of;  // -1: none
  std::vector<std::size_t> own;        // its places
};

// The bump's weights of the neighbours on the lattice.
struct Stencil {
  struct Item {
    int column;
    int row;
    double weight;
  };
  std::vector<Item> items;
  double sum = 0;

  Stencil() {
    const int reach = static_cast<int>(kAround);
    for (int row = -reach; row <= reach; ++row) {
      for (int column = -reach; column <= reach; ++column) {
        const double rest = 1 - (column * column + row * row) / (kAround * kAround);
        if (!(rest > 0)) continue;
        items.push_back({column, row, rest * rest});
        sum += rest * rest;
      }
    }
  }
};

// Appends the width of the stroke at some pixels of a tile, in pixels: the third shortest of eight chords
// (StampTool::narrowest_width).
void add_widths(const GreyTile& tile, std::vector<double>& widths) {
  constexpr std::size_t kPixelsLookedAt = 1000;
  constexpr int kDirections = 8;
  if (tile.values.empty()) return;
  const float most = *std::max_element(tile.values.begin(), tile.values.end());
  const auto is_in = [&](double x, double y) {
    if (!(x >= 0 && y >= 0 && x < tile.width && y < tile.height)) return false;
    const auto at = static_cast<std::size_t>(static_cast<int>(y)) * static_cast<std::size_t>(tile.width);
    return tile.values[at + static_cast<std::size_t>(static_cast<int>(x))] > most / 2;
  };
  const std::size_t stride = 1 + tile.values.size() / kPixelsLookedAt;
  for (std::size_t i = 0; i < tile.values.size(); i += stride) {
    const std::size_t rows_before = i / static_cast<std::size_t>(tile.width);
    const double row = static_cast<double>(rows_before) + 0.5;
    const double column = static_cast<double>(i - rows_before * static_cast<std::size_t>(tile.width)) + 0.5;
    if (!is_in(column, row)) continue;
    std::array<double, kDirections> chords{};
    for (int k = 0; k < kDirections; ++k) {
      const SinCos<double> turn = sincos(kRadiansPerDegree * 180 / kDirections * k);
      for (const double side : {-0.5, 0.5}) {
        double way = 0;
        while (is_in(column + (way + side) * turn.cos, row + (way + side) * turn.sin)) way += side;
        chords[static_cast<std::size_t>(k)] += std::abs(way);
      }
    }
    std::nth_element(chords.begin(), chords.begin() + 2, chords.end());
    widths.push_back(chords[2]);
  }
}

double thinnest_stroke(const GreyPattern& pattern) {
  std::vector<double> widths;
  for (const GreyTile& tile : pattern.tiles) add_widths(tile, widths);
  if (widths.empty()) return 0;
  const auto at = widths.begin() + static_cast<std::ptrdiff_t>(kHairline * static_cast<double>(widths.size()));
  std::nth_element(widths.begin(), at, widths.end());
  return *at;
}

// The surface before the print.
class Ground {
 public:
  explicit Ground(const LiveSurface& surface) : surface_(surface), tree_(surface.triangles, surface.positions) {}

  // Returns the middle of the top: the point at which a line through the middle of the box enters from above.
  Vec3d top() const {
    Box box;
    for (const Triangle& t : surface_.triangles) {
      for (const std::uint32_t v : t) box.extend(surface_.positions[v]);
    }
    const Vec3d above = box.center() + Vec3d{0, 0, box.max.z - box.min.z};
    const std::optional<RayHit> hit = tree_.first_hit(above, {0, 0, -1});
    if (!hit) throw InvalidInput("\"point\" is needed: nothing of the shape is below the middle of its top");
    return {above.x, above.y, above.z - hit->t};
  }

  Vec3d nearest(const Vec3d& p) const { return tree_.closest(p)->point; }

  // The mean of the unit normals nearest to places of a rectangle.
  Vec3d normal(const TilePlane& frame, double wide, double high) const {
    Vec3d sum{0, 0, 0};
    for (const double x : {-0.4, 0.0, 0.4}) {
      for (const double y : {-0.4, 0.0, 0.4}) {
        const Vec3d p = frame.center + frame.right * (x * wide) + frame.up * (y * high);
        sum += normal_at(p);
      }
    }
    return norm(sum) > 0 ? normalized(sum) : frame.normal;
  }

  // Returns the unit normal at the point of the surface nearest to p. On an edge and at a vertex, where the nearest
  // triangle is any of several, their normals count by their angles there.
  Vec3d normal_at(const Vec3d& p) const {
    constexpr std::size_t kMaxAround = 32;
    constexpr double kSamePoint = 1e-7;  // of an edge
    const std::vector<SurfacePoint> near = tree_.nearest(p, kMaxAround);
    std::vector<Vec3d> normals;
    for (const SurfacePoint& at : near) {
      if (norm(at.point - near.front().point) > kSamePoint * longest_edge(at.triangle)) continue;
      const auto i = static_cast<std::size_t>(std::max_element(at.barycentric.begin(), at.barycentric.end()) -
                                              at.barycentric.begin());
      const Vec3d a = corner(at.triangle, (i + 1) % 3) - corner(at.triangle, i);
      const Vec3d b = corner(at.triangle, (i + 2) % 3) - corner(at.triangle, i);
      const Vec3d across = cross(a, b);
      const double length = norm(across);
      const bool is_corner = at.barycentric[i] > 1 - kSamePoint;
      if (length > 0) normals.push_back(across / length * (is_corner ? elementary::atan2(length, dot(a, b)) : 1.0));
    }
    // In an order that does not depend on that of the triangles.
    std::sort(normals.begin(), normals.end(),
              [](const Vec3d& a, const Vec3d& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
    const Vec3d sum = std::accumulate(normals.begin(), normals.end(), Vec3d{0, 0, 0});
    return norm(sum) > 0 ? normalized(sum) : sum;
  }

  // Returns the point nearest to p at which a line along a direction enters the surface, if it is within `reach`.
  std::optional<RayHit> entry(const Vec3d& p, const Vec3d& direction, double reach) const {
    std::optional<RayHit> found;
    for (RayHit hit : tree_.hits(p - direction * reach, direction)) {
      hit.t -= reach;
      if (hit.leaves || std::abs(hit.t) > reach) continue;
      if (!found || std::abs(hit.t) < std::abs(found->t)) found = hit;
    }
    return found;
  }

  double longest_edge(std::uint32_t triangle) const {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      longest = std::max(longest, norm(corner(triangle, k) - corner(triangle, (k + 1) % 3)));
    }
    return longest;
  }

 private:
  const Vec3d& corner(std::uint32_t triangle, std::size_t k) const {
    return surface_.positions[surface_.triangles[triangle][k]];
  }

  const LiveSurface& surface_;
  SurfaceTree tree_;
};

class Printer {
 public:
  Printer(const PrintStroke& stroke, SurfaceRun& run)
      : stroke_(stroke),
        pattern_(*run.pattern),
        run_(run),
        pixel_(stroke.height / pattern_.height),
        thinnest_(thinnest_stroke(pattern_) * pixel_),
        bump_(stroke.bump.value_or(std::min(thinnest_ / 2, kBumpOfHeight * stroke.height))),
        outer_(stroke.outer.value_or(std::max(kOuterOfHeight * stroke.height, kWideOuter * bump_))) {
    if (run.surface.triangles.empty()) {
      throw InvalidInput("\"tool\": only a surface can be printed on, and a cloud has none");
    }
    if (!(thinnest_ > 0)) throw InvalidInput(fmt::format("\"{}\": there is nothing in it to print", source()));
    if (!(outer_ > bump_)) {
      throw InvalidInput(
          fmt::format("\"outer\" must be a number greater than \"bump\" ({:.3g}), got {:.3g}", bump_, outer_));
    }
    if (2 * bump_ > kThinner * thinnest_) {
      run.remarks.push_back(fmt::format(
          "\"bump\" is {:.3g}, but the thinnest strokes are {:.3g} wide, and become shallow; at most half of that "
          "shows them",
          bump_, thinnest_));
    }
    const Ground ground(run.surface);
    origin_ = stroke.point ? *stroke.point : ground.top();
    place_tiles(ground);
    run.detail = bump_;
  }

  void run() {
    std::vector<Vec3d> at(places_.size());
    for (std::size_t i = 0; i < at.size(); ++i) at[i] = places_[i].start - origin_;
    const double steps = std::max(std::ceil(std::abs(stroke_.depth) / bump_ * kStepsPerBump), kMinPrintSteps);
    if (steps > kMaxPrintSteps) {
      throw InvalidInput(fmt::format("\"depth\" must be at most {:.3g}, {} times \"bump\", got {:.3g}",
                                     rounded_down(kMaxPrintSteps / kStepsPerBump * bump_),
                                     kMaxPrintSteps / kStepsPerBump, std::abs(stroke_.depth)));
    }
    const PushGrids pushes(at, bump_, outer_, run_.threads);
    if (const double nodes = steps * pushes.nodes(); nodes > kMaxNodes) too_fine(std::cbrt(nodes / kMaxNodes));
    for (double step = 0; step < steps; ++step) {
      stop_if_cancelled(run_.surface.progress);
      std::vector<PotentialGrid> grids = pushes.grids(at, vectors(step / steps, (step + 1) / steps));
      for (PotentialGrid& grid : grids) grid.origin += origin_;
      std::vector<double> moved = motion(grids, at);
      if (step == 0) {
        gain_ = gain(moved, 1 / steps);
        for (PotentialGrid& grid : grids) grid = multiplied(std::move(grid), gain_);
        moved = motion(grids, at);
      }
      for (std::size_t i = 0; i < at.size(); ++i) {
        places_[i].got += moved[i];
        at[i] = places_[i].start - origin_ + places_[i].direction * places_[i].got;
      }
      for (PotentialGrid& grid : grids) {
        if (!run_.surface.apply(GridStroke{std::move(grid)})) return;
      }
    }
  }

 private:
  std::string_view source() const { return stroke_.text.empty() ? "file" : "text"; }

  // Lays the tiles along the surface, from the middle to both sides, and finds the places that they push.
  void place_tiles(const Ground& ground) {
    std::size_t missing = 0;
    std::size_t coarse = 0;
    const std::vector<GreyTile>& tiles = pattern_.tiles;
    const auto middle_of = [&](const GreyTile& tile) { return pixel_ * (tile.left + 0.5 * tile.width); };
    const auto right =
        std::partition_point(tiles.begin(), tiles.end(), [&](const GreyTile& tile) { return middle_of(tile) < 0; });
    const auto lay = [&](auto begin, auto end) {
      TilePlane frame = first_frame(ground);
      double at = 0;
      for (auto tile = begin; tile != end; ++tile) {
        const double way = middle_of(*tile) - at;
        at += way;
        const double pieces = std::ceil(std::abs(way) * kFewSteps / stroke_.height);
        for (double k = 0; k < pieces; ++k) frame = beside(ground, frame, way / pieces);
        add_tile(ground, *tile, frame, missing, coarse);
      }
    };
    lay(right, tiles.end());
    lay(std::make_reverse_iterator(right), tiles.rend());
    if (places_.empty()) throw InvalidInput("\"point\": no surface is under the pattern there");
    const auto share = [&](std::size_t count, std::size_t of) {
      return static_cast<double>(count) / static_cast<double>(of);
    };
    if (share(missing, missing + places_.size()) > kMissing) {
      run_.remarks.push_back(fmt::format("{:.0f}% of the pattern lies beside the surface, and is left out",
                                         100 * share(missing, missing + places_.size())));
    }
    if (!run_.mesh_follows && share(coarse, places_.size()) > kMissing) {
      run_.remarks.push_back(
          fmt::format("the edges under the print are longer than its \"bump\", {:.3g}; let the mesh follow, refine it, "
                      "or make the print larger",
                      bump_));
    }
  }

  static Vec3d across(const Vec3d& v, const Vec3d& normal) { return v - normal * dot(v, normal); }

  TilePlane first_frame(const Ground& ground) const {
    TilePlane frame{ground.nearest(origin_), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    frame.normal = stroke_.direction ? -unit(*stroke_.direction) : ground.normal(frame, 0, 0);
    Vec3d up = stroke_.up ? unit(*stroke_.up) : Vec3d{0, 0, 1};
    constexpr double kAlong = 0.7;
    if (!stroke_.up && std::abs(frame.normal.z) > kAlong) up = {0, 1, 0};
    if (norm(across(up, frame.normal)) < kSteepUp) {
      throw InvalidInput("\"up\" must not point along the direction in which the pattern is pressed");
    }
    set_up(frame, up);
    return frame;
  }

  void set_up(TilePlane& frame, const Vec3d& up) const {
    frame.up = normalized(across(up, frame.normal));
    frame.right = cross(frame.up, frame.normal) * (stroke_.flip ? -1 : 1);
  }

  // The frame at a distance to the right.
  TilePlane beside(const Ground& ground, const TilePlane& frame, double by) const {
    TilePlane next = frame;
    const Vec3d to = frame.center + frame.right * by;
    next.center = stroke_.direction ? to : ground.nearest(to);
    if (stroke_.direction) return next;
    next.normal = ground.normal(next, stroke_.height / kFewSteps, stroke_.height);
    // The line continues straight along the surface.
    const Vec3d right = normalized(across(frame.right, next.normal));
    next.up = cross(next.normal, right) * (stroke_.flip ? -1 : 1);
    next.right = right;
    return next;
  }

  void add_tile(const Ground& ground, const GreyTile& tile, TilePlane frame, std::size_t& missing,
                std::size_t& coarse) {
    const double wide = tile.width * pixel_;
    const double high = tile.height * pixel_;
    if (!stroke_.direction) {
      frame.normal = ground.normal(frame, wide, high);
      set_up(frame, frame.up);
    }
    const double apart = kPushesApart * bump_;
    const double columns = std::ceil(wide / apart) + 1;
    const double rows = std::ceil(high / apart) + 1;
    const double cells = columns * rows + static_cast<double>(places_.size());
    if (cells > kMaxCells) too_fine(std::sqrt(cells / kMaxCells));
    Raster raster{static_cast<int>(columns), static_cast<int>(rows), {}, {}, {}};
    raster.values.resize(static_cast<std::size_t>(columns * rows));
    raster.place_of.assign(raster.values.size(), -1);
    const double step = apart / pixel_;
    // The lattice is centred in the tile.
    const double x0 = 0.5 * (tile.width - raster.columns * step);
    const double y0 = 0.5 * (tile.height - raster.rows * step);
    const double reach = std::max(wide, high);
    for (int row = 0; row < raster.rows; ++row) {
      for (int column = 0; column < raster.columns; ++column) {
        const double x = x0 + column * step;
        const double y = y0 + row * step;
        const double value = mean_in(tile, x, y, x + step, y + step);
        const auto cell =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(raster.columns) + static_cast<std::size_t>(column);
        raster.values[cell] = value;
        if (!(value > 0)) continue;
        const Vec3d p = frame.center + frame.right * ((x + 0.5 * step - 0.5 * tile.width) * pixel_) +
                        frame.up * ((tile.top - y - 0.5 * step) * pixel_);
        const std::optional<RayHit> hit = ground.entry(p, -frame.normal, reach);
        if (!hit) {
          ++missing;
          continue;
        }
        coarse += ground.longest_edge(hit->triangle) > kTooCoarse * bump_ ? 1 : 0;
        raster.place_of[cell] = static_cast<std::int32_t>(places_.size());
        raster.own.push_back(places_.size());
        places_.push_back({p - frame.normal * hit->t, -frame.normal, value, 0, 0, {column, row}});
      }
    }
    for (const std::size_t i : raster.own) {
      double sum = 0;
      for_each_around(raster, places_[i],
                      [&](std::size_t cell, double weight) { sum += weight * raster.values[cell]; });
      places_[i].wanted = stroke_.depth * sum / stencil_.sum;
    }
    rasters_.push_back(std::move(raster));
  }

  // The factor by which the bump must be larger.
  [[noreturn]] void too_fine(double factor) const {
    throw InvalidInput(
        fmt::format("\"bump\": {:.3g} is too fine for so large a pattern; use about {:.2g}, or make several prints",
                    bump_, bump_ * factor));
  }

  template <class Visit>
  void for_each_around(const Raster& raster, const PushedPlace& place, const Visit& visit) const {
    for (const Stencil::Item& item : stencil_.items) {
      const int column = place.cell[0] + item.column;
      const int row = place.cell[1] + item.row;
      if (column < 0 || row < 0 || column >= raster.columns || row >= raster.rows) continue;
      visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(raster.columns) + static_cast<std::size_t>(column),
            item.weight);
    }
  }

  // Returns the vectors of the pushes from one fraction of the depth to another one: the displacement of this step, and
  // the part that earlier steps have missed, smoothed. (Weights that meet the depth at every place would grow without
  // bound, because pushes have no net flux.)
  std::vector<Vec3d> vectors(double from, double to) const {
    std::vector<Vec3d> result(places_.size());
    for (const Raster& raster : rasters_) {
      for (const std::size_t i : raster.own) {
        double lack = 0;
        double weights = 0;
        for_each_around(raster, places_[i], [&](std::size_t cell, double weight) {
          if (raster.place_of[cell] < 0) return;
          const PushedPlace& other = places_[static_cast<std::size_t>(raster.place_of[cell])];
          lack += weight * (other.wanted * from - other.got);
          weights += weight;
        });
        const double by = places_[i].value * stroke_.depth * (to - from) + lack / weights;
        result[i] = places_[i].direction * (gain_ * by / stencil_.sum);
      }
    }
    return result;
  }

  // Returns the displacement of each place along its direction by the grids and their mirror images.
  std::vector<double> motion(const std::vector<PotentialGrid>& grids, const std::vector<Vec3d>& at) const {
    std::vector<Vec3d> points(at);
    for (Vec3d& p : points) p += origin_;
    const std::vector<Vec3d> before = points;
    AdvectOptions options;
    options.tolerance = kPathTolerance * bump_;
    options.precision = Precision::float64;
    options.threads = run_.threads;
    for (const PotentialGrid& grid : grids) advect(flow_of(Stroke(GridStroke{grid}), run_.mirror), points, options);
    std::vector<double> moved(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) moved[i] = dot(points[i] - before[i], places_[i].direction);
    return moved;
  }

  // Returns the factor of the first step with which it reaches the wanted depth.
  double gain(const std::vector<double>& moved, double part) const {
    double of_moved = 0;
    double of_wanted = 0;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      of_moved += moved[i] * places_[i].wanted * part;
      of_wanted += places_[i].wanted * places_[i].wanted * part * part;
    }
    return std::clamp(of_wanted / of_moved, 0.25, 2.0);
  }

  const PrintStroke& stroke_;
  const GreyPattern& pattern_;
  SurfaceRun& run_;
  Vec3d origin_{};
  double pixel_;  // its length
  double thinnest_;
  double bump_;
  double outer_;
  double gain_ = 1;
  Stencil stencil_;
  std::vector<Raster> rasters_;
  std::vector<PushedPlace> places_;
};

std::vector<StrokeKey> keys(PrintStroke& s) {
  return {{"text", Quantity::other, &s.text, Presence::optional},
          {"font", Quantity::other, &s.font, Presence::optional},
          {"file", Quantity::other, &s.file, Presence::optional},
          {"point", Quantity::finite, &s.point, Presence::optional, "the middle of the pattern"},
          {"up", Quantity::direction, &s.up, Presence::optional, "of the pattern"},
          {"direction", Quantity::direction, &s.direction, Presence::optional, "in which all of it is pressed"},
          {"height", Quantity::positive, &s.height, Presence::required, "of a capital letter, or of the picture"},
          {"depth", Quantity::finite, &s.depth, Presence::required, "below 0: the pattern is raised"},
          {"bump", Quantity::positive, &s.bump, Presence::optional, "radius over which its edges are soft"},
          {"outer", Quantity::positive, &s.outer, Presence::optional, "how far its volume goes"},
          {"flip", Quantity::other, &s.flip, Presence::optional, "left and right change places"}};
}

void validate(const PrintStroke& stroke) {
  constexpr std::size_t kMaxText = 1000;
  if (stroke.text.empty() == stroke.file.empty()) throw InvalidInput("\"text\" or \"file\" must be given, one of them");
  if (!stroke.font.empty() && stroke.text.empty()) throw InvalidInput("\"font\" needs \"text\"");
  if (stroke.text.size() > kMaxText) {
    throw InvalidInput(fmt::format("\"text\" must have at most {} bytes, got {}", kMaxText, stroke.text.size()));
  }
  if (stroke.bump && stroke.outer && !(*stroke.outer > *stroke.bump)) {
    throw InvalidInput(
        fmt::format("\"outer\" must be a number greater than \"bump\" ({}), got {}", *stroke.bump, *stroke.outer));
  }
}

void resolve(const PrintStroke& stroke, SurfaceRun& run) {
  if (stroke.depth != 0) Printer(stroke, run).run();
}

std::size_t segments(const PrintStroke& /*stroke*/, const Mesh* /*mesh*/) { return 60; }

std::string words(const PrintStroke& stroke, const std::string& unit) {
  const std::string what = stroke.text.empty() ? stroke.file : stroke.text;
  return fmt::format("{} {} {}", stroke.depth < 0 ? "Raise" : "Print", what, length_text(std::abs(stroke.depth), unit));
}

void prolong(PrintStroke& stroke, double strength) { stroke.depth *= strength; }

void move(PrintStroke& stroke, const std::optional<Vec3d>& /*signs*/, const PlaceMap& place) {
  const Vec3d origin = place({0, 0, 0});
  const auto turned = [&](const Vec3d& v) { return place(v) - origin; };
  if (stroke.point) stroke.point = place(*stroke.point);
  if (stroke.up) stroke.up = turned(*stroke.up);
  if (stroke.direction) stroke.direction = turned(*stroke.direction);
  if (dot(cross(turned({1, 0, 0}), turned({0, 1, 0})), turned({0, 0, 1})) < 0) stroke.flip = !stroke.flip;
}

}  // namespace

namespace detail {

double mean_in(const GreyTile& tile, double x0, double y0, double x1, double y1) {
  double sum = 0;
  for (int y = std::max(0, static_cast<int>(y0)); y < std::min(tile.height, static_cast<int>(std::ceil(y1))); ++y) {
    const double high = std::min(y1, y + 1.0) - std::max(y0, 1.0 * y);
    for (int x = std::max(0, static_cast<int>(x0)); x < std::min(tile.width, static_cast<int>(std::ceil(x1))); ++x) {
      const double wide = std::min(x1, x + 1.0) - std::max(x0, 1.0 * x);
      const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(tile.width) + static_cast<std::size_t>(x);
      sum += static_cast<double>(tile.values[at]) * std::max(0.0, wide) * std::max(0.0, high);
    }
  }
  return sum / ((x1 - x0) * (y1 - y0));
}

GreyPattern face_of(const Mesh& mesh, const PrintStroke& stroke) {
  const SurfaceTree tree(triangulate(mesh), mesh.positions);
  Box box;
  for (const Triangle& t : triangulate(mesh)) {
    for (const std::uint32_t v : t) box.extend(mesh.positions[v]);
  }
  const Vec3d size = box.max - box.min;
  if (box.empty() || !(size.x > 0 && size.y > 0)) throw InvalidInput("\"file\": the mesh has no face to print");
  GreyTile tile;
  const double pixel = std::max(size.x, size.y) / kPixelsOfFace;
  tile.width = static_cast<int>(std::ceil(size.x / pixel));
  tile.height = static_cast<int>(std::ceil(size.y / pixel));
  tile.values.resize(static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height));
  const double behind = stroke.height / size.y / std::abs(stroke.depth);  // by the mesh's unit, of the depth
  parallel_for(static_cast<std::size_t>(tile.height), 1, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      for (std::size_t column = 0; column < static_cast<std::size_t>(tile.width); ++column) {
        const Vec3d from{box.min.x + (static_cast<double>(column) + 0.5) * pixel,
                         box.max.y - (static_cast<double>(row) + 0.5) * pixel, box.min.z - size.z - pixel};
        const std::optional<RayHit> hit = tree.first_hit(from, {0, 0, 1});
        if (!hit) continue;
        const double value = 1 - (from.z + hit->t - box.min.z) * behind;
        tile.values[row * static_cast<std::size_t>(tile.width) + column] = static_cast<float>(std::max(0.0, value));
      }
    }
  });
  tile.left = -0.5 * tile.width;
  tile.top = 0.5 * tile.height;
  return {{std::move(tile)}, size.y / pixel};
}

}  // namespace detail

constinit const detail::ToolRow<PrintStroke> PrintStroke::tool{.name = "print",
                                                               .keys = keys,
                                                               .validate = validate,
                                                               .resolve = resolve,
                                                               .segments = segments,
                                                               .words = words,
                                                               .prolong = prolong,
                                                               .move = move};

}  // namespace knead
