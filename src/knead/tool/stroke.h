// Strokes: what a person did with a tool, one plain struct per tool, and the flow that each becomes (method, section
// 4).
//
// A stroke holds exactly the numbers of its line in a session file: lengths in the mesh's own units, angles in degrees,
// axes and normals as given (any length but zero). It contains no mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "knead/field/blend.h"
#include "knead/flow/segment.h"
#include "knead/math/mat3.h"
#include "knead/math/vec3.h"

namespace knead {

enum class ImplicitRegion { ball, capsule };

// The implicit tool (paper, section 4.1): a ball or capsule moved along a path, one segment for each piece of it; a
// piece of length zero is skipped. inner > 0.
struct ImplicitStroke {
  std::vector<Vec3d> path;  // 2 or more points
  double inner = 0;
  double outer = 0;
  ImplicitRegion region = ImplicitRegion::ball;
  Vec3d half_axis{0, 0, 0};  // capsule only: the segment is [c - half_axis, c + half_axis]
  double gauge = 0;          // capsule only
  TimeLaw time = TimeLaw::swept;

  friend bool operator==(const ImplicitStroke&, const ImplicitStroke&) = default;
};

struct PaintSample {
  Vec3d point;
  Vec3d normal;

  friend bool operator==(const PaintSample&, const PaintSample&) = default;
};

// Painting (paper, section 4.2): at each sample the surface is moved by depth against the normal; a negative depth
// pulls it out. Either samples or a path of 1 or more points, which reads the surface (tool/paint.h).
struct PaintStroke {
  double outer = 0;
  double depth = 0;
  std::vector<PaintSample> samples;
  std::vector<Vec3d> path{};

  friend bool operator==(const PaintStroke&, const PaintStroke&) = default;
};

// parts: each connected part of the set has its own centre; barycentre: one centre for all, as in the paper.
enum class PointsCenter { parts, barycentre };

// A moving point set (paper, section 4.3): one segment per displacement; the points and polylines move along.
struct PointsStroke {
  std::vector<Vec3d> points;
  std::vector<std::vector<Vec3d>> curves;  // polylines of 2 or more points
  double outer = 0;
  std::vector<Vec3d> displacements;
  int exponent = 8;
  double inner = 0;
  PointsCenter center = PointsCenter::parts;

  friend bool operator==(const PointsStroke&, const PointsStroke&) = default;
};

// Where the full set of marked regions goes.
struct HandlesTranslation {
  Vec3d by;

  friend bool operator==(const HandlesTranslation&, const HandlesTranslation&) = default;
};
struct HandlesRotation {
  Vec3d axis;
  Vec3d center;
  double angle_deg = 0;

  friend bool operator==(const HandlesRotation&, const HandlesRotation&) = default;
};

// Marked regions (the paper's future work): the full set goes exactly where the motion takes it, the zero set stays.
// Each set is given either as points or as vertices of the shape, which are looked up where the stroke begins.
struct HandlesStroke {
  std::vector<Vec3d> full;
  std::vector<Vec3d> zero;
  std::vector<std::uint32_t> full_vertices;
  std::vector<std::uint32_t> zero_vertices;
  std::variant<HandlesTranslation, HandlesRotation> motion;
  int exponent = 8;

  friend bool operator==(const HandlesStroke&, const HandlesStroke&) = default;
};

// Stamping (paper, section 4.4): a closed tool mesh is posed and moved along the path; at every step its contacts with
// the surface become moving point sets (tool/stamp.h).
struct StampStroke {
  std::string mesh;                             // the tool's file, relative to the session file
  std::vector<Vec3d> path;                      // 2 or more positions of the tool's origin
  Mat3d pose{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // rotation and scale, applied to the tool before it is moved
  std::optional<double> outer = std::nullopt;   // 1.5 times half the tool's largest extent across the motion
  std::optional<double> step = std::nullopt;    // longest motion between two collision tests; outer / 25
  int exponent = 16;

  friend bool operator==(const StampStroke&, const StampStroke&) = default;
};

// A ball whose inner region turns about its centre by the angle.
struct RotateStroke {
  Vec3d center;
  Vec3d axis;
  double angle_deg = 0;
  double inner = 0;
  double outer = 0;
  double gauge = 0;

  friend bool operator==(const RotateStroke&, const RotateStroke&) = default;
};

// A ball whose inner region is stretched along the axis by the factor and thinned across it by 1 / sqrt(factor).
struct StretchStroke {
  Vec3d center;
  Vec3d axis;
  double factor = 1;
  double inner = 0;
  double outer = 0;

  friend bool operator==(const StretchStroke&, const StretchStroke&) = default;
};

// Twist (paper, section 4.5): with r = normal.(x - center), material of the inner region at height h turns about the
// axis by rate_deg h.
struct TwistStroke {
  Vec3d center;
  Vec3d axis;
  double rate_deg = 0;  // degrees per length
  double inner = 0;
  double outer = 0;
  std::optional<Vec3d> normal = std::nullopt;  // the axis where not given
  double gauge = 0;
  // Of the cylinder about {center + s normal} that is moved; everything where not given.
  std::optional<double> radius = std::nullopt;
  bool radius_auto = false;  // instead of a radius: the one that propose_barrel finds on the shape (tool/placement.h)

  friend bool operator==(const TwistStroke&, const TwistStroke&) = default;
};

// At the fraction s(c) = 0.48675... the weight is one half, which makes a bend symmetric about its centre.
inline constexpr double kCenterFraction = 0.4867502159528536;

// Thresholds inner = -center_fraction width, outer = (1 - center_fraction) width.
struct BendWidth {
  double width = 0;
  double center_fraction = kCenterFraction;

  friend bool operator==(const BendWidth&, const BendWidth&) = default;
};

// Bend (paper, section 4.5): r = normal.(x - center), the normal turning by half the angle; the inner region, on the
// side that the normal points away from, turns about the axis by the angle.
struct BendStroke {
  Vec3d center;
  Vec3d axis;
  Vec3d normal;
  double angle_deg = 0;
  std::variant<BendWidth, Thresholds<double>> extent;
  double gauge = 1;
  // Of the cylinder about {center + s normal} that is moved; everything where not given.
  std::optional<double> radius = std::nullopt;
  bool radius_auto = false;  // instead of a radius: the one that propose_barrel finds on the shape (tool/placement.h)

  friend bool operator==(const BendStroke&, const BendStroke&) = default;
};

using Stroke = std::variant<ImplicitStroke, PaintStroke, PointsStroke, HandlesStroke, StampStroke, RotateStroke,
                            StretchStroke, TwistStroke, BendStroke>;

// "implicit", "paint", "points", "handles", "stamp", "rotate", "stretch", "twist" or "bend".
std::string tool_name(const Stroke& stroke);

// Throws InvalidInput for a value that the tool cannot use; the message begins with the key in quotes and says what was
// expected and what was got.
void validate(const Stroke& stroke);

// Whether the stroke must be resolved on a surface before it is a flow: paint with a path, stamp, handles with
// vertices, an automatic radius.
bool reads_surface(const Stroke& stroke);

// The segments, in order, of a stroke that reads no surface. Throws InvalidInput as validate(stroke), and for others.
// Time: linear, for a point set times the logarithm of its size.
Flow flow_of(const Stroke& stroke);

// What is legal but likely to disappoint (strong flow back beside the tool), a sentence each with what to do. The
// stroke is valid. Of handles with vertices nothing is known until these are looked up.
std::vector<std::string> warnings(const Stroke& stroke);

}  // namespace knead
