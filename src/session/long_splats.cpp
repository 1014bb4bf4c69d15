// Splits splats that are longer than the flow around them is uniform, into copies of their rows with other centres,
// sizes and opacities.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "flow/block_mover.h"
#include "io/codec.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "math/elementary.h"
#include "math/geometry.h"
#include "math/system.h"

namespace knead {

namespace {

constexpr double kMaxBend = 0.1;  // the second difference over one standard deviation, by the largest after the flow
constexpr double kMaxBendBack = 0.13;  // of what moves back: so the pieces of what was moved forth stay as they are
constexpr double kAim = 0.8;           // of that bound, after a split: the flow does not bend all pieces alike
constexpr double kSmallest = 0.004;    // standard deviation below which no splat bends, by the flow's smallest feature
constexpr double kPathTolerance = 1e-5;  // by the flow's smallest feature
constexpr double kLargestPart = 0.8;     // of a standard deviation, after one split
constexpr double kSmallestPart = 1.0 / 16;
constexpr int kMaxRounds = 8;
constexpr int kOpacityRounds = 30;
constexpr double kMinOpacity = 1e-4;  // less is not seen
constexpr double kMaxOpacity = 0.9999;
constexpr double kMaxScale = 300;  // a logarithm whose exponential is finite
// Evaluations of the flow after which points count as running to infinity: of a group, and more for each of its points.
constexpr std::uint64_t kGroupEvaluations = 100'000;
constexpr std::uint64_t kPointEvaluations = 100;  // for each segment
constexpr std::size_t kGroupPieces = 512;

// A splat, or a piece of one.
struct SplatPiece {
  std::uint32_t source = 0;
  Vec3d center;
  std::array<double, 3> sizes{};  // standard deviations
  double opacity = 0;             // from 0 to 1
  bool is_split = false;
};

// The bend of one axis of a piece.
struct Bend {
  std::size_t piece = 0;
  std::size_t axis = 0;
  double amount = 0;
  double other = 0;  // the largest deviation of the other axes, by that of this axis
};

// The numbers of splats that splitting changes.
class Columns {
 public:
  explicit Columns(const Mesh& mesh) : mesh_(mesh), opacity_(mesh.find_attribute("opacity")) {
    for (std::size_t k = 0; k < 3; ++k) scales_[k] = mesh.find_attribute(fmt::format("scale_{}", k));
    for (std::size_t k = 0; k < 4; ++k) turns_[k] = mesh.find_attribute(fmt::format("rot_{}", k));
  }

  bool has_opacity() const { return opacity_ != nullptr; }

  double largest_scale(std::uint32_t splat) const {
    return std::max({scales_[0]->values[splat], scales_[1]->values[splat], scales_[2]->values[splat]});
  }

  SplatPiece piece(std::uint32_t splat) const {
    SplatPiece piece{splat, mesh_.positions[splat]};
    piece.opacity = elementary::sigmoid(opacity_->values[splat]);
    for (std::size_t k = 0; k < 3; ++k) piece.sizes[k] = elementary::exp(scales_[k]->values[splat]);
    return piece;
  }

  Vec3d axis(std::uint32_t splat, std::size_t k) const {
    std::array<double, 4> turn{};
    for (std::size_t i = 0; i < 4; ++i) turn[i] = turns_[i]->values[splat];
    return splat_axes(turn)[k];
  }

 private:
  const Mesh& mesh_;
  const Attribute* opacity_;
  std::array<const Attribute*, 3> scales_{};
  std::array<const Attribute*, 4> turns_{};
};

// The pieces of a Gaussian of deviation 1: their centres, and the deviation and opacity that together cover it.
struct Division {
  std::vector<double> centers;
  std::vector<double> opacities;
};

double gaussian(double x) { return elementary::exp(-x * x / 2); }

// Returns opacities with which pieces of this deviation let through at each centre as much light as the one did.
std::vector<double> opacities_of(std::span<const double> centers, double deviation, double opacity) {
  const std::size_t count = centers.size();
  std::vector<double> result(count, 0.0);
  std::vector<double> covered;   // by the whole, at each centre
  std::vector<double> overlaps;  // of each piece at the centre of each
  for (const double at : centers) {
    covered.push_back(opacity * gaussian(at));
    for (const double of : centers) overlaps.push_back(gaussian((at - of) / deviation));
  }
  for (int round = 0; round < kOpacityRounds; ++round) {
    for (std::size_t k = 0; k < count; ++k) {
      double through = 1;  // the others
      for (std::size_t j = 0; j < count; ++j) {
        if (j != k) through *= 1 - result[j] * overlaps[k * count + j];
      }
      result[k] = std::clamp(1 - (1 - covered[k]) / through, kMinOpacity * opacity, kMaxOpacity);
    }
  }
  return result;
}

// Evenly spaced, two deviations apart at most, with the weights of a Gaussian and the whole's variance.
Division division_of(double deviation, double opacity) {
  const double variance = 1 - deviation * deviation;
  const auto count = static_cast<std::size_t>(std::ceil(2 * std::sqrt(variance) / deviation)) + 1;
  Division division;
  double weights = 0;
  double sum = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double x = 2 * std::sqrt(variance) * (2 * static_cast<double>(k) / static_cast<double>(count - 1) - 1);
    const double weight = elementary::exp(-x * x / (2 * variance));
    division.centers.push_back(x);
    weights += weight;
    sum += weight * x * x;
  }
  for (double& x : division.centers) x *= std::sqrt(variance * weights / sum);
  division.opacities = opacities_of(division.centers, deviation, opacity);
  return division;
}

// Splits the splats of a mesh for a flow.
class Splitter {
 public:
  Splitter(const Mesh& mesh, const Flow& flow, std::size_t max_splats, const ReplayOptions& options)
      : flow_(flow), columns_(mesh), count_(mesh.vertex_count()), max_splats_(max_splats) {
    if (options.part.direction == Direction::backwards) forth_ = inverse(flow);
    const FlowSupport support(flow);
    const double feature = std::min(support.smallest_feature(), reference_length(mesh));
    motion_ = {.tolerance = kPathTolerance * feature, .threads = options.motion.threads};
    if (!columns_.has_opacity()) return;
    const double smallest = elementary::log(kSmallest * feature);
    for (std::uint32_t splat = 0; splat < count_; ++splat) {
      const double scale = columns_.largest_scale(splat);
      if (!(scale > smallest) || !support.may_move(mesh.positions[splat], elementary::exp(std::min(scale, kMaxScale))))
        continue;
      const SplatPiece piece = columns_.piece(splat);
      const bool is_finite = std::isfinite(*std::max_element(piece.sizes.begin(), piece.sizes.end()));
      if (is_finite && piece.opacity > kMinOpacity) pieces_.push_back(piece);
    }
  }

  void run() {
    std::vector<std::size_t> open(pieces_.size());
    std::iota(open.begin(), open.end(), std::size_t{0});
    for (int round = 0; round < kMaxRounds && !open.empty(); ++round) {
      std::vector<std::size_t> next;
      for (const Bend& bend : bends_of(open)) split(bend, next);
      open = std::move(next);
    }
    std::erase_if(pieces_, [](const SplatPiece& piece) { return !piece.is_split; });
    std::vector<Vec3d> centers;
    for (const SplatPiece& piece : pieces_) centers.push_back(piece.center);
    const std::vector<bool> runs_away = move(flow_, centers, 1);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (runs_away[i]) whole_.insert(pieces_[i].source);
    }
    std::erase_if(pieces_, [&](const SplatPiece& piece) { return whole_.contains(piece.source); });
  }

  // Returns the pieces of the split splats; the first piece of each splat comes first.
  std::span<const SplatPiece> pieces() const { return pieces_; }
  // Returns the number of splats that stay whole because a part of them would run to infinity.
  std::size_t whole() const { return whole_.size(); }
  // Returns how many splats would have more pieces if there could be more splats.
  std::size_t limited() const { return limited_.size(); }

 private:
  // Moves points, `each` of every piece. Returns the pieces with a point that runs to infinity; their points do not
  // move.
  std::vector<bool> move(const Flow& flow, std::span<Vec3d> points, std::size_t each) const {
    std::vector<bool> runs_away(points.size() / each);
    detail::ReadyFlow ready(flow, motion_);
    if (!points.empty()) move_group(ready, points, each, 0, runs_away);
    return runs_away;
  }

  // first: the number of the group's first piece.
  void move_group(detail::ReadyFlow& flow, std::span<Vec3d> points, std::size_t each, std::size_t first,
                  std::vector<bool>& runs_away) const {
    const std::size_t pieces = points.size() / each;
    const bool is_small = pieces <= kGroupPieces;
    const std::uint64_t of_points = kPointEvaluations * flow.flow().segments.size() * points.size();
    const std::uint64_t most = is_small ? kGroupEvaluations + of_points : std::numeric_limits<std::uint64_t>::max();
    if (detail::advect_within(flow, points, most).status == AdvectStatus::done) return;
    runs_away[first] = pieces == 1;
    if (pieces == 1) return;
    const std::size_t part = is_small ? pieces / 2 : kGroupPieces;
    for (std::size_t i = 0; i < pieces; i += part) {
      move_group(flow, points.subspan(i * each, std::min(part, pieces - i) * each), each, first + i, runs_away);
    }
  }

  // Returns those that bend too much, the worst first.
  std::vector<Bend> bends_of(std::span<const std::size_t> open) {
    std::vector<Vec3d> points;
    for (const std::size_t i : open) {
      const SplatPiece& piece = pieces_[i];
      points.push_back(piece.center);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d arm = columns_.axis(piece.source, k) * piece.sizes[k];
        points.insert(points.end(), {piece.center + arm, piece.center - arm});
      }
    }
    const std::vector<bool> runs_away = move(flow_, points, 7);
    const std::vector<bool> is_straight = forth_ ? stay_straight(points) : std::vector<bool>(open.size());
    std::vector<Bend> bends;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (runs_away[i]) whole_.insert(pieces_[open[i]].source);
      if (whole_.contains(pieces_[open[i]].source)) continue;
      const Bend bend = bend_of(open[i], std::span(points).subspan(7 * i, 7));
      if (bend.amount > kMaxBend && !is_straight[i]) bends.push_back(bend);
    }
    std::stable_sort(bends.begin(), bends.end(), [](const Bend& a, const Bend& b) { return a.amount > b.amount; });
    return bends;
  }

  // Returns of which pieces moved back the flow forth would bend the result too little to split it.
  std::vector<bool> stay_straight(std::span<const Vec3d> moved) const {
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < moved.size(); i += 7) {
      std::array<Vec3d, 3> arms;
      for (std::size_t k = 0; k < 3; ++k) arms[k] = (moved[i + 1 + 2 * k] - moved[i + 2 + 2 * k]) / 2;
      detail::orthogonalise(arms);
      points.push_back(moved[i]);
      for (const Vec3d& arm : arms) points.insert(points.end(), {moved[i] + arm, moved[i] - arm});
    }
    const std::vector<bool> runs_away = move(*forth_, points, 7);
    std::vector<bool> result;
    for (std::size_t i = 0; i < runs_away.size(); ++i) {
      result.push_back(!runs_away[i] && bend_of(i, std::span(points).subspan(7 * i, 7)).amount <= kMaxBendBack);
    }
    return result;
  }

  // `points`: where the flow takes the centre and the ends of the axes.
  static Bend bend_of(std::size_t piece, std::span<const Vec3d> points) {
    std::array<double, 3> sizes{};  // after the flow
    for (std::size_t k = 0; k < 3; ++k) sizes[k] = norm(points[1 + 2 * k] - points[2 + 2 * k]) / 2;
    Bend worst{piece};
    for (std::size_t k = 0; k < 3; ++k) {
      const double bend = norm(points[1 + 2 * k] + points[2 + 2 * k] - points[0] * 2.0);
      const double amount = bend / *std::max_element(sizes.begin(), sizes.end());
      if (amount > worst.amount) {
        worst = {piece, k, amount, std::max(sizes[(k + 1) % 3], sizes[(k + 2) % 3]) / sizes[k]};
      }
    }
    return worst;
  }

  // The second difference falls with the square of the deviation, which also is the largest one or not.
  void split(const Bend& bend, std::vector<std::size_t>& next) {
    const double aim = kAim * kMaxBend / (bend.amount * std::max(1.0, bend.other));
    const double part = std::max(aim, std::sqrt(aim * bend.other));
    const double deviation = std::clamp(part, kSmallestPart, kLargestPart);
    const SplatPiece whole = pieces_[bend.piece];
    const Division division = division_of(deviation, whole.opacity);
    if (count_ + division.centers.size() - 1 > max_splats_) {
      limited_.insert(whole.source);
      return;
    }
    count_ += division.centers.size() - 1;
    const Vec3d arm = columns_.axis(whole.source, bend.axis) * whole.sizes[bend.axis];
    for (std::size_t k = 0; k < division.centers.size(); ++k) {
      SplatPiece piece = whole;
      piece.center += arm * division.centers[k];
      piece.sizes[bend.axis] *= deviation;
      piece.opacity = division.opacities[k];
      piece.is_split = true;
      next.push_back(k == 0 ? bend.piece : pieces_.size());
      if (k > 0) pieces_.emplace_back();
      pieces_[next.back()] = piece;
    }
  }

  const Flow& flow_;
  std::optional<Flow> forth_;  // of a flow that moves back
  Columns columns_;
  AdvectOptions motion_;
  std::vector<SplatPiece> pieces_;
  std::set<std::uint32_t> whole_;
  std::set<std::uint32_t> limited_;
  std::size_t count_;  // of all splats
  std::size_t max_splats_;
};

// The rows of the pieces: the first piece of a splat takes its place, the others come after all splats.
struct PieceRows {
  std::vector<std::uint32_t> copied;  // the splats that the others are pieces of
  std::vector<std::pair<std::uint32_t, const SplatPiece*>> rows;
};

PieceRows rows_of(std::span<const SplatPiece> pieces, std::size_t splats) {
  PieceRows result;
  const auto count = static_cast<std::uint32_t>(splats);
  std::vector<bool> has_row(count);
  for (const SplatPiece& piece : pieces) {
    const bool is_first = !has_row[piece.source];
    has_row[piece.source] = true;
    const auto last = count + static_cast<std::uint32_t>(result.copied.size());
    result.rows.emplace_back(is_first ? piece.source : last, &piece);
    if (!is_first) result.copied.push_back(piece.source);
  }
  std::sort(result.rows.begin(), result.rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return result;
}

constexpr std::array kPieceColumns{"scale_0", "scale_1", "scale_2", "opacity"};

// Returns the numbers of a piece in these columns.
std::array<double, 4> numbers_of(const SplatPiece& piece) {
  return {elementary::log(piece.sizes[0]), elementary::log(piece.sizes[1]), elementary::log(piece.sizes[2]),
          elementary::logit(piece.opacity)};
}

template <class T>
void append_copies(std::vector<T>& values, std::span<const std::uint32_t> copied, std::size_t components) {
  reserve_large(values, values.size() + copied.size() * components);
  for (const std::uint32_t i : copied) {
    for (std::size_t c = 0; c < components; ++c) values.push_back(values[i * components + c]);
  }
}

// Puts the pieces into the mesh, and leaves the file as it is.
void add_pieces(ShapeFile& shape, const PieceRows& pieces, bool has_float_places) {
  Mesh& mesh = shape.mesh;
  append_copies(mesh.positions, pieces.copied, 1);
  for (Attribute& attribute : mesh.attributes) {
    append_copies(attribute.values, pieces.copied, static_cast<std::size_t>(attribute.components));
  }
  std::array<Attribute*, kPieceColumns.size()> columns{};
  for (std::size_t k = 0; k < columns.size(); ++k) {
    columns[k] = &*std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                                [&](const Attribute& attribute) { return attribute.name == kPieceColumns[k]; });
  }
  detail::AnyLayout layout = *shape.layout;
  const auto as_stored = [](double number, bool is_float) {
    return is_float ? double{static_cast<float>(number)} : number;
  };
  for (const auto& [row, piece] : pieces.rows) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      mesh.positions[row][axis] = as_stored(piece->center[axis], has_float_places);
    }
    const std::array<double, 4> numbers = numbers_of(*piece);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      columns[k]->values[row] = as_stored(numbers[k], columns[k]->type == NumberType::float32);
    }
    layout.edits.vertices.push_back(row);
  }
  layout.edits.copied = pieces.copied;
  layout.edits.attributes.assign(kPieceColumns.begin(), kPieceColumns.end());
  shape.layout = std::make_shared<const detail::AnyLayout>(std::move(layout));
}

// Returns a file with rows for the pieces; nothing if the format cannot.
std::optional<ShapeFile> with_pieces(const ShapeFile& source, const PieceRows& pieces) {
  const std::string name = "split." + source.format;
  const detail::Codec& codec = detail::codec_named(source.format, name);
  if (codec.with_copies == nullptr) return std::nullopt;
  std::string bytes = codec.with_copies(source, pieces.copied);
  if (bytes.empty()) return std::nullopt;
  const ShapeFile whole = parse_shape(std::move(bytes), source.format, name);
  std::vector<Vec3d> positions = whole.mesh.positions;
  ChangedSplats changed;
  for (const char* column : kPieceColumns) {
    changed.attributes.push_back({column, Domain::vertex, NumberType::float32, 1, {}});
  }
  for (const auto& [row, piece] : pieces.rows) {
    positions[row] = piece->center;
    changed.splats.push_back(row);
    const std::array<double, 4> numbers = numbers_of(*piece);
    for (std::size_t k = 0; k < numbers.size(); ++k) changed.attributes[k].values.push_back(numbers[k]);
  }
  const WriteOptions options{.attributes = changed.attributes, .changed = changed.splats};
  return parse_shape(serialize_shape(source.format, whole, positions, options), source.format, name);
}

}  // namespace

bool split_splats(ShapeFile& shape, const Session& session, const ReplayOptions& options,
                  std::optional<std::size_t> max_splats, std::vector<std::string>* notes) {
  const detail::Codec& codec = detail::codec_named(shape.format, "source");
  if ((codec.with_copies == nullptr && codec.writes_edits == nullptr) || !are_splats(shape.mesh)) return false;
  splat_degree(shape.mesh);
  const std::size_t most = max_splats.value_or(2 * shape.mesh.vertex_count());
  if (most <= shape.mesh.vertex_count()) return false;
  Session resolved = session;
  SessionPart part = options.part;
  const auto reads = [](const SessionStroke& stroke) { return reads_surface(stroke.stroke); };
  if (std::any_of(session.strokes.begin(), session.strokes.end(), reads)) {
    ReplayOptions plain = options;
    plain.frames = {};
    plain.on_stroke = {};
    resolved.strokes = replay(borrow(shape.mesh), session, plain).resolved;
    part.until.reset();  // these are others than it counts; those that it leaves out may split more splats
  }
  const Flow flow = flow_of(resolved, part, options.motion.threads);
  Splitter splitter(shape.mesh, flow, most, options);
  splitter.run();
  const std::span<const SplatPiece> pieces = splitter.pieces();
  if (!pieces.empty()) {
    if (!shape.layout->edits.vertices.empty()) {
      shape = parse_shape(serialize_shape(shape.format, shape, shape.mesh.positions), shape.format, "split");
    }
    const PieceRows rows = rows_of(pieces, shape.mesh.vertex_count());
    if (codec.writes_edits != nullptr && codec.writes_edits(shape)) {
      add_pieces(shape, rows, codec.stores_floats(shape));
    } else if (std::optional<ShapeFile> whole = with_pieces(shape, rows)) {
      shape = *std::move(whole);
    } else {
      if (notes != nullptr) notes->emplace_back("long splats are not split: several nodes or primitives hold them");
      return false;
    }
  }
  if (notes == nullptr) return !pieces.empty();
  const auto splats = [](std::size_t count) { return fmt::format("{} long splat{}", count, count == 1 ? "" : "s"); };
  if (splitter.whole() > 0) {
    notes->push_back(fmt::format("{} kept whole: the strokes would take a part far away", splats(splitter.whole())));
  }
  if (splitter.limited() > 0) {
    notes->push_back(
        fmt::format("at most {} splats are allowed, too few for the pieces of {}", most, splats(splitter.limited())));
  }
  return !pieces.empty();
}

}  // namespace knead
