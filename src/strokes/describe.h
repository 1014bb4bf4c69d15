// The row of a tool: everything that the library knows of it; and functions that the rows share, such as checks of
// numbers.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/vec.h"

namespace knead {
struct GreyPattern;  // strokes/print.h
}

namespace knead::detail {

// Checks of a stroke's numbers. Every failure is an InvalidInput whose message begins with the key in quotes and says
// what was expected and what was got.
void require_finite(std::string_view key, double value);
void require_finite(std::string_view key, const Vec3d& value);
void require_finite(std::string_view key, const std::vector<Vec3d>& values);

// Finite and greater than 0.
void require_positive(std::string_view key, double value);

// A factor from 1e-6 to 1e6: beyond that a shape has no extent left, and path lines need too many steps.
void require_factor(std::string_view key, double value);

// Finite, and not the zero vector.
void require_direction(std::string_view key, const Vec3d& value);

inline constexpr double kMaxDegrees = 360000;

// A number of degrees for which the evaluation has a sine: from -360,000 to 360,000.
void require_angle(std::string_view key, double degrees);

void require_count(std::string_view key, std::size_t count, std::size_t least, std::string_view what);

// A whole number from 3 to 7 (knead/field.h).
void require_falloff(std::string_view key, int value);

// An even number, `least` or more.
void require_even(std::string_view key, int value, int least);

// Both finite, inner < outer.
void require_thresholds(double inner, double outer);

// For a region whose r is a distance: outer > 0 and 0 <= inner < outer. (A negative inner would leave a cone at r = 0.)
void require_distance_thresholds(double inner, double outer);

// For the wide falloff: 0 <= inner <= 0.8 bump < bump < outer.
void require_wide_thresholds(const Thresholds<double>& thresholds);

// Returns the greatest number of three digits that is at most x >= 0: a bound that works as it is printed.
double rounded_down(double x);

// v / |v| for any finite v but zero, also where |v|^2 overflows or underflows.
Vec3d unit(const Vec3d& v);

// Help of Studio on the thresholds of most tools.
inline constexpr std::string_view kInnerHelp = "everything nearer moves rigidly with the tool";
inline constexpr std::string_view kOuterHelp = "everything farther stays";
inline constexpr std::string_view kBumpHelp = "radius of what moves with the tool";
inline constexpr std::string_view kWide = R"("falloff": "wide")";
inline constexpr std::string_view kNotWide = R"(a "falloff" from 3 to 7)";

// Warnings begin above this ratio of the speed of the flow back past a set to the tool's speed. For a set of radius R
// it is R / (2 outer), or R / (2 gap) between two sets (method, section 2).
inline constexpr double kStrongReturn = 4;

inline constexpr double kRadiansPerDegree = 0.017453292519943295769;

// "30\u00b0"; "0.2 mm", or without the unit where that is empty.
std::string degrees_text(double angle);
std::string length_text(double length, const std::string& unit);

// A stroke that reads a surface, while it is applied to it.
struct SurfaceRun {
  const LiveSurface& surface;
  const Mesh* mesh = nullptr;  // of a stamp's tool
  int threads = 0;
  std::vector<std::string> remarks{};    // for the user
  std::string shortfall{};               // says how the stroke missed its targets; empty if it reached them
  double reached = 1;                    // the fraction of the stroke that was applied, from 0 to 1
  std::optional<double> penetration{};   // how deep a stamp leaves the surface in its tool
  const GreyPattern* pattern = nullptr;  // of a print
  Mirror mirror{};                       // in which surface.apply makes images
  bool mesh_follows = false;             // the mesh is remeshed after the stroke
  double detail = 0;                     // the least radius that the remeshed mesh must show; 0: as the settings say
};

// The zone of a bend or twist, between what moves with the tool and what stays.
struct StrokeZone {
  Vec3d center;
  Vec3d normal;         // unit
  Vec3d side{0, 0, 0};  // of a bend: unit, across the axis and the normal
  std::optional<double> radius{};
  Thresholds<double> between{};
  double angle = 0;    // radians: of a bend; of a twist: over the zone
  double degrees = 0;  // as the stroke gives them: of a bend, or of a twist for one unit of length
  double gauge = 0;    // of a bend

  double width() const { return between.outer - between.inner; }
  bool bends() const { return side != Vec3d{0, 0, 0}; }
};

using Warnings = std::vector<std::string>;
using HasKey = std::function<bool(std::string_view)>;
using PlaceMap = std::function<Vec3d(const Vec3d&)>;

// A tool whose strokes blend: S has the member `falloff`.
template <class S>
inline constexpr bool kBlends = requires(S stroke) {
  stroke.falloff;
};

// A tool whose strokes may have the wide falloff: S has the member `bump`, too.
template <class S>
inline constexpr bool kMayBeWide = requires(S stroke) {
  stroke.falloff;
  stroke.bump;
};

// The outer threshold of the wide falloff where a stroke gives none, as a factor of its bump.
inline constexpr double kWideOuter = 4;

// Returns the thresholds of a stroke that may be wide.
template <class S>
Thresholds<double> thresholds_of(const S& stroke) {
  Thresholds<double> thresholds{0, stroke.outer, stroke.falloff};
  if (stroke.falloff != kWideFalloff) {
    if constexpr (requires { stroke.inner; }) thresholds.inner = stroke.inner;
    return thresholds;
  }
  thresholds.bump = stroke.bump;
  if (stroke.outer == 0) thresholds.outer = kWideOuter * stroke.bump;
  if constexpr (requires { stroke.core; }) thresholds.inner = stroke.core.value_or(0) * stroke.bump;
  return thresholds;
}

// The row of the tool with strokes S. A null member does not apply to the tool.
template <class S>
struct ToolRow {
  std::string_view name;  // these three as in Tool
  bool is_flow = true;
  bool is_event = false;

  // The numbers of a stroke, and its flow.
  std::vector<StrokeKey> (*keys)(S&);                // without "falloff"
  void (*prepare)(S&, const HasKey&) = nullptr;      // as in Tool
  void (*validate)(const S&) = nullptr;              // throws for values that the tool cannot use
  bool (*reads_surface)(const S&) = nullptr;         // null: if there is no `flow`
  void (*resolve)(const S&, SurfaceRun&) = nullptr;  // applies a valid stroke that reads the surface
  bool reads_once = false;                           // `resolve` reads the surface only before it applies anything
  // Throws for a shape to which a valid stroke that does not read it cannot be applied.
  void (*check)(const S&, const LiveSurface&) = nullptr;
  void (*check_inverse)(const S&,
                        const LiveSurface&) = nullptr;  // the same for the inverse of the stroke, without a mask
  Flow (*flow)(const S&) = nullptr;                     // of a valid stroke that does not read the surface
  // Returns about how many segments the stroke becomes; with the mesh of a stamp's tool, at most. Null: one.
  std::size_t (*segments)(const S&, const Mesh* mesh) = nullptr;
  void (*warn)(const S&, Warnings&) = nullptr;                        // adds sentences about a valid stroke
  std::string (*words)(const S&, const std::string& unit) = nullptr;  // as words_of(); null: the name

  // Changes of the numbers.
  void (*prolong)(S&, double strength) = nullptr;  // as prolonged(); null: multiplies the angles
  bool (*blends)(const S&) = nullptr;              // null: if there is a falloff
  void (*keep_zone)(S&, int falloff) = nullptr;    // adapts the stroke so that its zone stays with this falloff
  void (*zone)(const S&, StrokeZone&) = nullptr;
  void (*set_zone)(S&, const StrokeZone&) = nullptr;

  // Images. `move` is for strokes whose keys depend on each other; `signs`: of the axes; nothing if the motion does
  // more than mirror. `with_images` returns one stroke with the effect of all images, on a shape with these vertices.
  void (*move)(S&, const std::optional<Vec3d>& signs, const PlaceMap& place) = nullptr;
  S (*with_images)(const S&, const Mirror&, std::span<const Vec3d> positions) = nullptr;

  // Growth of a stroke while it is drawn (strokes/suffix.h). `path`: the path of the tool, with one segment for each
  // piece.
  std::vector<Vec3d> S::*path = nullptr;
  bool (*grows)(const S& before, const S& now) = nullptr;
  S (*rest)(const S& before, const S& now) = nullptr;
  bool (*continues)(const S& last, const S& next) = nullptr;
  void (*join)(S& last, const S& next) = nullptr;
  std::vector<Stroke> (*pieces)(const S&) = nullptr;
  std::optional<Stroke> (*interleaved)(const S&, std::span<const SymmetryImage>) = nullptr;
};

// Calls body with the row of the stroke's tool, and the stroke as its own struct.
template <class AnyStroke, class Body>
decltype(auto) with_row(AnyStroke& stroke, const Body& body) {
  return std::visit([&]<class S>(S& own) -> decltype(auto) { return body(std::remove_const_t<S>::tool, own); }, stroke);
}

// Returns a choice among the values of an enumeration, which the words name in order.
template <class E>
Choice choice(E& value, std::vector<std::string_view> words) {
  return {std::move(words), static_cast<std::size_t>(value), [&value](std::size_t i) { value = static_cast<E>(i); }};
}

// Extends a path in its last direction, to `strength` times its length. A path of length 0 does not change.
void prolong_path(std::vector<Vec3d>& path, double strength);

// Returns a segment with one field that is carried along with its displacement.
Segment transported_segment(Field field, const Vec3d& displacement, TimeLaw time_law = TimeLaw::swept);

// Returns a segment with one field that rests.
Segment resting_segment(Field field);

// Warns of a strong flow back beside the tool, which a thin intermediate region causes (inner / outer above 0.9).
void warn_of_thin_shell(const Thresholds<double>& thresholds, Warnings& warnings);

// Returns advice for a key that names vertices by their numbers: "name points instead, with ..."; empty if it does not.
std::string instead_of_vertices(const StrokeKey& key);

// Returns about how many segments a stroke becomes; if it reads the surface, an upper bound (for a stamp only with the
// mesh of its tool).
std::size_t segments_of(const Stroke& stroke, const Mesh* mesh = nullptr);

// Returns whether the stroke is a bend or twist.
inline bool has_zone(const Stroke& stroke) {
  return with_row(stroke, [](const auto& row, const auto& /*own*/) { return row.zone != nullptr; });
}

// Returns the zone of a bend or twist; nothing for other strokes. The stroke is valid.
std::optional<StrokeZone> zone_of(const Stroke& stroke);

// Applies a twist or bend with the radius "auto": finds the radius.
void resolve_radius(const Stroke& stroke, SurfaceRun& run);

}  // namespace knead::detail
