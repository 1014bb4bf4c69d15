// One stroke that moves a shape: reads the surface, checks limit cylinders, moves the vertices, remeshes.
#include "session/stroke_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "flow/masked.h"
#include "flow/segment_map.h"
#include "flow/segment_mover.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/vec.h"
#include "session/deformed_shape_detail.h"
#include "strokes/describe.h"
#include "strokes/limit_cylinder.h"
#include "strokes/mirror.h"
#include "strokes/suffix.h"

namespace knead::detail {

namespace {

// The speed of the flow along a mask's border from which on there is a warning, relative to the tool's speed.
constexpr double kFastBorder = 2;
// The speed of a tool and its images together from which on there is a warning, relative to that of the tool.
constexpr double kFastImages = 1.1;
// The allowed error of a mesh that shows a detail, relative to its radius: edges of half the radius.
constexpr double kChordOfDetail = 1.0 / 64;
// The numbers of segments and vertices that are checked for these.
constexpr std::size_t kMaxSegments = 8;
constexpr std::size_t kMaxPlaces = 4000;

// Returns some of the points in the mask's box, evenly through the list.
std::vector<Vec3d> places_near(const Mask& mask, std::span<const Vec3d> points) {
  const Box box = mask.box();
  std::vector<Vec3d> near;
  for (const Vec3d& p : points) {
    if (contains(box, p)) near.push_back(p);
  }
  const std::size_t stride = (near.size() + kMaxPlaces - 1) / kMaxPlaces;
  if (stride <= 1) return near;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < near.size(); i += stride) near[kept++] = near[i];
  near.resize(kept);
  return near;
}

std::string describe_refusal(const StrokeCylinder& limit_cylinder, const CylinderCheck& check) {
  std::string text = fmt::format("{} cross the limit cylinder of \"radius\" {} and would be torn; ",
                                 check.crossing == 1 ? "1 triangle would" : fmt::format("{} triangles", check.crossing),
                                 limit_cylinder.radius);
  const std::optional<double> nearest = nearest_radius(check, limit_cylinder.radius);
  if (!nearest) return text + "no other radius works: leave \"radius\" out";
  text += fmt::format("use \"radius\": {}, the nearest that works", *nearest);
  if (!check.smaller) return text + " (no smaller one does)";
  if (!check.larger) return text + " (no larger one does)";
  return text + fmt::format(" (on the other side {})", nearest == check.smaller ? *check.larger : *check.smaller);
}

// Appends a part of a stroke; dabs of one brush become one stroke.
void append(const Stroke& part, const SessionStroke& source, std::vector<SessionStroke>& parts) {
  if (!parts.empty() && join(parts.back().stroke, part)) return;
  parts.push_back({part, source.line, source.remesh, source.name});
  parts.back().mirror = source.mirror;
}

// Sets the strengths of a stroke's parts so that together they end after that number of segments.
void cut(std::vector<SessionStroke>& parts, double part, std::size_t segments) {
  if (part == 1) return;
  if (parts.size() == 1) {
    parts.front().strength = part;
    return;
  }
  double left = part * static_cast<double>(segments);
  for (SessionStroke& each : parts) {
    const auto own = static_cast<double>(flow_of(each.stroke, each.mirror).segments.size());
    each.strength = std::clamp(left / own, 0.0, 1.0);
    left -= own;
  }
  std::erase_if(parts, [](const SessionStroke& each) { return each.strength == 0; });
}

// Divides the duration of a stroke among its parts, by their segments.
void share_duration(std::vector<SessionStroke>& parts, double duration) {
  if (parts.size() == 1) {
    parts.front().duration = duration;
    return;
  }
  std::vector<double> segments;
  segments.reserve(parts.size());
  for (const SessionStroke& part : parts) segments.push_back(static_cast<double>(flow_of(part).segments.size()));
  const double all = std::accumulate(segments.begin(), segments.end(), 0.0);
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i].duration = duration * segments[i] / all;
}

// Resolves a stroke on a shape. `moves`: also moves the shape, unless the stroke has limit cylinders, which must be
// checked first. A pose with a mirror contains all parts and their images; its grids and their images add up to their
// mean, which is exactly symmetric.
void read_surface(PreparedStroke& stroke, DeformedShape& shape, bool moves, Progress* progress) {
  const Mirror& mirror = stroke.source->mirror;
  LiveSurface surface;
  surface.positions = shape.positions();
  surface.triangles = shape.triangles();
  if (shape.has_normals()) surface.normal = [&](std::uint32_t vertex) { return shape.normal(vertex); };
  const std::optional<Stroke> whole =
      mirror.empty() ? std::nullopt : with_images(stroke.stroke(), mirror, surface.positions);
  surface.apply = [&](const Stroke& own) {
    const Stroke part = whole ? prolonged(own, 1.0 / static_cast<double>(1U << mirror.size())) : own;
    Flow flow = masked(flow_of(part, mirror), shape.mask());
    stroke.limit_cylinders = limit_cylinders_of(part, mirror);
    append(part, *stroke.source, stroke.outcome.parts);
    if (moves && stroke.limit_cylinders.empty()) stroke.outcome.status = shape.move(flow, progress);
    std::move(flow.segments.begin(), flow.segments.end(), std::back_inserter(stroke.flow.segments));
    return stroke.outcome.status == AdvectStatus::done;
  };
  surface.progress = progress;
  surface.part = stroke.part;
  SurfaceRun run{surface, stroke.tool.get(), shape.motion().threads};
  run.pattern = stroke.pattern.get();
  run.mirror = mirror;
  run.mesh_follows = stroke.mesh_follows;
  try {
    with_row(whole ? *whole : stroke.stroke(), [&](const auto& row, const auto& own) { row.resolve(own, run); });
  } catch (const Cancelled&) {
    stroke.outcome.status = AdvectStatus::cancelled;
    return;
  }
  stroke.detail = run.detail;
  stroke.outcome.penetration = run.penetration;
  stroke.outcome.shortfall = std::move(run.shortfall);
  stroke.outcome.reached = run.reached;
  std::move(run.remarks.begin(), run.remarks.end(), std::back_inserter(stroke.outcome.warnings));
  cut(stroke.outcome.parts, stroke.part, stroke.flow.segments.size());
  share_duration(stroke.outcome.parts, stroke.source->duration);
  stroke.reads_surface = false;
}

// Sets the mask of the shape if the stroke is a mask.
void set_mask(PreparedStroke& stroke, DeformedShape& shape) {
  if (!std::holds_alternative<MaskStroke>(stroke.source->stroke) || !is_applied(*stroke.source)) return;
  if (shape.motion().backend && shape.mask().is_empty()) {
    stroke.outcome.warnings.push_back(
        "the GPU cannot evaluate a mask: the CPU moves the vertices in the strokes after it");
  }
  shape.set_mask(mask_of(std::get<MaskStroke>(stroke.outcome.parts.back().stroke), shape.motion().threads));
}

// Refuses vertices given by numbers once remeshing has changed the numbers.
void require_no_numbers(Stroke stroke) {
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    const std::string instead = instead_of_vertices(key);
    if (instead.empty()) continue;
    throw InvalidInput(fmt::format(
        "\"{}\" names vertices, but remeshing after an earlier stroke changed their numbers; {}", key.name, instead));
  }
}

// Returns a text with places at which triangles still cross, each far from the others.
std::string out_of_time_warning(const Remeshed& remeshed, double diagonal) {
  constexpr std::size_t most = 3;
  constexpr double far = 0.02;  // of the diagonal
  std::string text = "the mesh was not improved to the end, for want of time; ";
  if (remeshed.counts.crossings == 0) return text + "no triangles cross";
  std::vector<Vec3d> named;
  for (const Vec3d& place : remeshed.crossing_places) {
    const bool is_new = std::none_of(named.begin(), named.end(),
                                     [&](const Vec3d& other) { return norm(place - other) < far * diagonal; });
    if (is_new) named.push_back(place);
  }
  text += remeshed.counts.crossings == 1 ? "1 pair of triangles still crosses"
                                         : fmt::format("{} pairs of triangles still cross", remeshed.counts.crossings);
  for (std::size_t i = 0; i < std::min(most, named.size()); ++i) {
    text += fmt::format("{}({:.4g}, {:.4g}, {:.4g})", i == 0 ? ", near " : ", ", named[i].x, named[i].y, named[i].z);
  }
  if (named.size() > most) text += fmt::format(" and {} more places", named.size() - most);
  return text + "; allow more seconds";
}

bool holds_all(const StrokeCylinder& limit_cylinder, const std::vector<Vec3d>& points) {
  return std::all_of(points.begin(), points.end(), [&](const Vec3d& p) {
    return norm(cross(limit_cylinder.normal, p - limit_cylinder.center)) <= limit_cylinder.radius;
  });
}

Flow without_limit_cylinders(Flow flow) {
  for (Segment& segment : flow.segments) segment.limit_cylinder.reset();
  return flow;
}

// Returns the flow without limit cylinders, and of sums only with the given parts.
Flow without_limit_cylinders(Flow flow, unsigned parts) {
  for (Segment& segment : flow.segments) {
    if (!segment.parts.empty()) segment = chosen_parts(segment, parts);
  }
  return without_limit_cylinders(std::move(flow));
}

// Returns the tool of a stamp; null for other strokes.
std::shared_ptr<const Mesh> tool_mesh_of(Stroke stroke, const std::filesystem::path& folder) {
  const auto* const file = find_value<std::string>(stroke, "mesh");
  if (file == nullptr) return nullptr;
  try {
    return std::make_shared<const Mesh>(read_shape(folder / *file).mesh);
  } catch (const std::exception& error) {
    throw InvalidInput(fmt::format("\"mesh\": {}", error.what()));
  }
}

}  // namespace

PreparedStroke prepare_stroke(const SessionStroke& source, const std::filesystem::path& folder) {
  PreparedStroke prepared;
  prepared.source = &source;
  if (!is_applied(source)) return prepared;
  prepared.part = std::min(source.strength, 1.0);
  SessionStroke own = source;
  if (auto* lattice = std::get_if<LatticeStroke>(&own.stroke); lattice != nullptr && !lattice->file.empty()) {
    *lattice = with_file(*lattice, folder);
    prepared.beyond = std::make_shared<const Stroke>(own.stroke);
  }
  if (source.strength > 1) prepared.beyond = std::make_shared<const Stroke>(prolonged(own.stroke, source.strength));
  const Stroke& stroke = prepared.stroke();
  validate(stroke);
  prepared.relax = std::get_if<RelaxStroke>(&stroke);
  if (prepared.relax != nullptr) {
    prepared.expected_segments = prepared.relax->points.size();
    return prepared;
  }
  prepared.reads_surface = reads_surface(stroke);
  if (prepared.reads_surface) {
    prepared.tool = tool_mesh_of(stroke, folder);
    if (const auto* print = std::get_if<PrintStroke>(&stroke)) prepared.pattern = read_pattern(*print, folder);
    prepared.expected_segments = segments_of(stroke, prepared.tool.get());
    return prepared;
  }
  prepared.flow = flow_of(stroke, source.mirror);
  validate(prepared.flow);
  prepared.limit_cylinders = limit_cylinders_of(stroke, source.mirror);
  prepared.outcome.parts = {std::move(own)};
  return prepared;
}

StrokeRun::StrokeRun(PreparedStroke stroke, const RunOptions& options, DeformedShape& shape, Progress* progress)
    : stroke_(std::move(stroke)), options_(options), shape_(shape), progress_(progress) {
  const bool may_remesh = is_applied(*stroke_.source) && stroke_.relax == nullptr;
  if (!options_.backwards && may_remesh) settings_ = shape_.settings_of(*stroke_.source);
  stroke_.mesh_follows = settings_.has_value();
}

double StrokeRun::length() const {
  const std::size_t whole = stroke_.relax != nullptr ? stroke_.relax->points.size() : stroke_.flow.segments.size();
  return stroke_.part * static_cast<double>(whole);
}

std::size_t StrokeRun::segments() const {
  return stroke_.relax != nullptr ? 0 : static_cast<std::size_t>(std::ceil(end()));
}

Flow StrokeRun::flow(double moment) const {
  if (stroke_.relax != nullptr) return {};
  const double to = std::min(moment * length(), end());
  return options_.backwards ? flow_between(stroke_.flow, end(), moment == 1 ? 0 : to) : prefix(stroke_.flow, to);
}

void StrokeRun::begin() {
  read();
  warn_of_cpu();
  if (status() != AdvectStatus::done) return;
  check_shape();
  if (options_.backwards) return;
  check_limit_cylinder();
  warn_of_border();
  warn_of_images();
}

// Warns if a tool and its image, beside a mirror plane or a sliding wall, move the same part of the shape.
void StrokeRun::warn_of_images() {
  const std::vector<Segment>& segments = stroke_.flow.segments;
  double fastest = 1;
  for (std::size_t i = 0; i < segments.size(); i += segments.size() / kMaxSegments + 1) {
    fastest = std::max(fastest, speed_of_images(segments[i]));
  }
  if (!(fastest > kFastImages)) return;
  stroke_.outcome.warnings.push_back(
      fmt::format("the tool overlaps its image beyond the plane of the mirror or wall, so each moves {:.0f}% as far: "
                  "begin in the plane, or farther away",
                  100 / fastest));
}

// A stroke that is applied as a whole moves the shape itself while it reads the surface; else a copy is moved, unless
// the surface is read only once.
void StrokeRun::read() {
  if (settings_) start_ = shape_.positions();
  stroke_.flow = masked(std::move(stroke_.flow), options_.backwards ? stroke_.mask : shape_.mask());
  if (options_.backwards) at_ = end();
  if (!stroke_.reads_surface) return;
  if (shape_.is_remeshed() && shape_.provenance()->is_renumbered) require_no_numbers(stroke_.source->stroke);
  const bool in_place = options_.part * stroke_.part == 1 && !options_.has_frames;
  const bool reads_once = with_row(stroke_.stroke(), [](const auto& row, const auto&) { return row.reads_once; });
  if (!in_place && !reads_once) {
    DeformedShape copy = shape_;
    read_surface(stroke_, copy, true, progress_);
  } else {
    read_surface(stroke_, shape_, in_place, progress_);
    if (in_place && stroke_.limit_cylinders.empty()) at_ = end();
  }
  if (!settings_ || stroke_.detail == 0) return;
  double& chord = settings_->max_chord.emplace(settings_->max_chord.value_or(kDefaultMaxChord));
  chord = std::min(chord, kChordOfDetail * stroke_.detail / shape_.reference_length());
}

void StrokeRun::check_shape() {
  with_row(stroke_.stroke(), [&](const auto& row, const auto& own) {
    const bool was_checked = row.reads_surface != nullptr && row.reads_surface(own);  // when it was resolved
    const auto check = options_.backwards ? row.check_inverse : row.check;
    const bool is_masked = options_.backwards && !stroke_.mask.is_empty();  // then the places do not tell what moved
    if (check == nullptr || was_checked || is_masked || stroke_.flow.segments.empty()) return;
    LiveSurface surface;
    surface.positions = shape_.positions();
    surface.triangles = shape_.triangles();
    surface.part = stroke_.part * (options_.backwards ? options_.part : 1);
    check(own, surface);
  });
}

void StrokeRun::check_limit_cylinder() {
  for (const StrokeCylinder& limit_cylinder : stroke_.limit_cylinders) {
    const CylinderCheck found = knead::check_limit_cylinder(limit_cylinder, shape_.positions(), shape_.triangles());
    if (found.crossing > 0) throw InvalidInput(describe_refusal(limit_cylinder, found));
    if (found.later == 0) continue;
    stroke_.outcome.warnings.push_back(
        fmt::format("{} triangles cross the limit cylinder of \"radius\" {} where the bend moves the surface later, "
                    "and may be torn; check them, or choose another radius",
                    found.later, limit_cylinder.radius));
  }
}

void StrokeRun::warn_of_cpu() {
  const std::vector<Segment>& segments = stroke_.flow.segments;
  const auto is_sum = [](const Segment& segment) { return !segment.parts.empty(); };
  const bool is_handles = std::holds_alternative<HandlesStroke>(stroke_.source->stroke);
  const bool is_map = std::any_of(segments.begin(), segments.end(), detail::is_map);
  const bool is_known = is_handles || is_map || std::any_of(segments.begin(), segments.end(), is_sum);
  if (!shape_.motion().backend || !is_known) return;
  stroke_.outcome.warnings.push_back(fmt::format(
      "the GPU cannot evaluate {}: the CPU moves the vertices in this stroke", is_handles ? "handles"
                                                                               : is_map
                                                                                   ? "a " + tool_name(stroke_.stroke())
                                                                                   : "mirror images at the same time"));
}

// Warns if the flow along the mask's border is much faster than the tool: it distorts the shape there.
void StrokeRun::warn_of_border() {
  if (shape_.mask().is_empty() || stroke_.flow.segments.empty()) return;
  const std::vector<Vec3d>& positions = shape_.positions();
  const std::vector<Vec3d> near = places_near(shape_.mask(), positions);
  BorderSpeed fastest;
  const std::size_t stride = (stroke_.flow.segments.size() + kMaxSegments - 1) / kMaxSegments;
  for (std::size_t i = 0; i < stroke_.flow.segments.size(); i += stride) {
    const BorderSpeed speed = border_speed(stroke_.flow.segments[i], near);
    if (speed.at_border * fastest.of_tool > fastest.at_border * speed.of_tool || fastest.of_tool == 0) fastest = speed;
  }
  if (!(fastest.at_border > kFastBorder * fastest.of_tool)) return;
  stroke_.outcome.warnings.push_back(fmt::format(
      "the flow along the mask's border is up to {:.2g} times as fast as the tool; make the mask's \"width\" larger, "
      "or the tool smaller",
      fastest.at_border / fastest.of_tool));
}

// Stops the shape only between whole segments, so that the result does not depend on frames.
const DeformedShape& StrokeRun::frame(double moment) {
  const double to = std::min(moment * length(), end());
  advance(options_.backwards ? std::min(std::ceil(to), at_) : std::floor(to));
  if (status() != AdvectStatus::done) return frame_;
  if (!shape_.motion().backend && stroke_.relax == nullptr) shape_.prepare();
  frame_ = shape_;
  move_between(at_, to, frame_);
  std::optional<Remeshed> remeshed;
  follow(to, frame_, remeshed);
  return frame_;
}

void StrokeRun::finish() {
  advance(options_.backwards ? 0 : end());
  if (!options_.backwards && status() == AdvectStatus::done) set_mask(stroke_, shape_);
  follow(end(), shape_, remeshed_);
  if (options_.backwards && status() == AdvectStatus::done) check_limit_cylinder();
}

void StrokeRun::follow(double to, DeformedShape& shape, std::optional<Remeshed>& remeshed) {
  if (!settings_ || status() != AdvectStatus::done) return;
  RemeshOutcome outcome = shape.remesh(start_, prefix(stroke_.flow, to), *settings_, progress_);
  stroke_.outcome.status = outcome.status;
  remeshed = std::move(outcome.remeshed);
  if (remeshed && remeshed->counts.out_of_time) {
    stroke_.outcome.warnings.push_back(out_of_time_warning(*remeshed, shape.reference_length()));
  }
}

void StrokeRun::advance(double to) {
  if (status() == AdvectStatus::done) move_between(at_, to, shape_);
  at_ = to;
}

void StrokeRun::move_between(double from, double to, DeformedShape& shape) {
  if (from == to) return;
  if (stroke_.relax != nullptr) {
    stroke_.outcome.status = shape.relax(*stroke_.relax, from, to, progress_);
    return;
  }
  Flow flow = flow_between(stroke_.flow, from, to);
  if (!options_.backwards || stroke_.limit_cylinders.empty()) {
    stroke_.outcome.status = shape.move(flow, progress_);
    return;
  }
  const DeformedShape start = shape;  // from which all parts start
  for (const InverseImage& image : inverse_images()) {
    DeformedShape moved = to == 0 ? image.shape : start;
    const AdvectStatus status =
        to == 0 ? image.status : moved.move(without_limit_cylinders(flow, image.parts), progress_);
    if (status != AdvectStatus::done) stroke_.outcome.status = status;
    shape.take(image.members, moved);
  }
}

StrokeRun::InverseImage StrokeRun::inverse_image_by(unsigned parts) const {
  InverseImage image{parts, shape_};
  image.status = image.shape.move(without_limit_cylinders(flow_between(stroke_.flow, end(), 0), parts), progress_);
  return image;
}

std::vector<bool> StrokeRun::members_of(const StrokeCylinder& limit_cylinder, const InverseImage& image) const {
  const double tolerance = advect_options(shape_.motion(), shape_.reference_length()).tolerance;
  std::vector<bool> members = limit_cylinder_members(limit_cylinder, shape_.positions(), image.shape.positions(),
                                                     shape_.triangles(), 10 * tolerance + 1e-3 * limit_cylinder.radius);
  WeldedMesh(shape_.mesh()).share(members);
  return members;
}

// Inverts the parts without limit cylinders; limit_cylinder_members() then says which points each of these contained.
// If each contains the whole shape, as those about one line do, all points moved.
const std::vector<StrokeRun::InverseImage>& StrokeRun::inverse_images() {
  if (inverse_images_) return *inverse_images_;
  inverse_images_.emplace();
  const std::size_t count = stroke_.limit_cylinders.size();
  InverseImage all = inverse_image_by((1U << count) - 1);
  const auto holds_shape = [&](const StrokeCylinder& limit_cylinder) {
    return holds_all(limit_cylinder, all.shape.positions());
  };
  const bool is_simple = count == 1 || all.status != AdvectStatus::done ||
                         std::all_of(stroke_.limit_cylinders.begin(), stroke_.limit_cylinders.end(), holds_shape);
  if (is_simple) {
    all.members.assign(shape_.positions().size(), true);
    if (count == 1) all.members = members_of(stroke_.limit_cylinders.front(), all);
    inverse_images_->push_back(std::move(all));
    return *inverse_images_;
  }
  const std::vector<unsigned> parts = parts_that_moved();
  for (unsigned chosen = 1; chosen < 1U << count; ++chosen) {
    std::vector<bool> members(parts.size());
    for (std::size_t k = 0; k < parts.size(); ++k) members[k] = parts[k] == chosen;
    if (std::find(members.begin(), members.end(), true) == members.end()) continue;
    inverse_images_->push_back(inverse_image_by(chosen));
    inverse_images_->back().members = std::move(members);
  }
  return *inverse_images_;
}

// The parts of the flow that moved each point, as bits.
std::vector<unsigned> StrokeRun::parts_that_moved() const {
  std::vector<unsigned> parts(shape_.positions().size(), 0);
  for (std::size_t i = 0; i < stroke_.limit_cylinders.size(); ++i) {
    const std::vector<bool> members = members_of(stroke_.limit_cylinders[i], inverse_image_by(1U << i));
    for (std::size_t k = 0; k < members.size(); ++k) parts[k] |= members[k] ? 1U << i : 0U;
  }
  return parts;
}

}  // namespace knead::detail

namespace knead {

StrokeOutcome DeformedShape::apply(const SessionStroke& stroke, const std::filesystem::path& folder,
                                   Progress* progress) {
  detail::StrokeRun run(detail::prepare_stroke(stroke, folder), {}, *this, progress);
  run.begin();
  run.finish();
  std::vector<std::string> known = warnings(run.stroke().stroke());
  StrokeOutcome outcome = run.take_outcome();
  outcome.warnings.insert(outcome.warnings.begin(), known.begin(), known.end());
  return outcome;
}

}  // namespace knead
