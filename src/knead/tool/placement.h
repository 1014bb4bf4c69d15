// Places strokes: where on a shape a twist or bend moves one part and nothing else, and images of strokes in mirrors
// and about an axis.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/math/progress.h"
#include "knead/mesh/triangulate.h"
#include "knead/tool/barrel.h"

namespace knead {

// A radius for a barrel. The part is the connected piece of the shape with r < outer at the start of the stroke that
// has the vertex nearest to the barrel's centre.
struct BarrelProposal {
  std::optional<double> radius;  // with it only the part moves; a short number near the middle of the gap
  double part = 0;               // the part's greatest distance from the axis
  double others = std::numeric_limits<double>::infinity();  // least distance of anything else from the axis beyond that
  std::size_t within = 0;  // triangles of other pieces that are entirely nearer than `part`: they move along
  std::string problem;     // if there is no radius, one sentence: why, and what to do
};

// Returns a radius for the barrel; its own radius is ignored. The radius is the geometric mean of `part` and `others`,
// or 1.25 times `part` if there is nothing else. check_barrel counts no crossing triangle for it, and no later one if
// the gap allows. There is no radius if the shape has nothing below outer, or if another piece is partly nearer to the
// axis than the part's farthest point. Time: linear; about 25 times that to explain why there is no radius.
BarrelProposal propose_barrel(const Barrel& barrel, std::span<const Vec3d> positions,
                              std::span<const Triangle> triangles);

// Returns a twist or bend with its radius "auto" replaced by the one of propose_barrel, and any other stroke unchanged.
// Adds notes to `remarks`. Throws InvalidInput if there is no radius; the message begins with the key in quotes.
Stroke with_found_radius(const Stroke& stroke, std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                         std::vector<std::string>& remarks);

// A line along a part of a shape, such as a finger or an arm.
struct BarrelQuery {
  Vec3d point;           // inside the part
  Vec3d direction;       // along the part, towards its tip; any length but 0
  Vec3d axis{0, 0, 0};   // of a bend whose sweep must reach nothing else, if possible; 0 disables this
  double angle_deg = 0;  // of that bend
};

// The numbers of a twist or bend that moves the part alone; r = normal.(x - center).
struct BarrelPlacement {
  Vec3d center;
  Vec3d normal;  // unit, away from the tip
  double inner = 0;
  double outer = 0;
  double radius = 0;
  double thickness = 0;  // greatest distance of the part from the line, in the plane through the point
  std::string problem;   // why there is no such place, one sentence; the numbers are then undefined
};

// Returns the place nearest to the point, towards the tip, where a barrel holds the part and nothing else: the part is
// joined to the rest in one place only, the plane r = outer cuts it about as thick as it is at the point, and
// everything else is at least 1.1 times as far from the line as the part. The zone from inner to outer is twice as wide
// as the part is thick, or 1.2 times where the part is short; r = 0 is where a bend is symmetric (kCenterFraction).
// check_barrel accepts the radius. Time: linear for each place tried, 5 ms for 100,000 triangles; the places are a
// quarter of the thickness apart. Throws InvalidInput for a direction or axis that is 0 or not finite; Cancelled if
// `progress` is cancelled.
BarrelPlacement place_barrel(const BarrelQuery& query, std::span<const Vec3d> positions,
                             std::span<const Triangle> triangles, const Progress* progress = nullptr);

// One image of what a tool does.
struct SymmetryImage {
  RigidMotion motion;
  // Bit mask of the coordinate planes through the origin (1: x, 2: y, 4: z), if the motion is only these; then images
  // are exact. 0: any other motion.
  unsigned planes = 0;
};

// Returns the file with the mirror image of a stamp's tool in the planes of a bit mask.
using ImageFile = std::function<std::string(const std::string& file, unsigned planes)>;

// Returns the images in the coordinate planes of a bit mask (1: x, 2: y, 4: z) and in all combinations of them.
std::vector<SymmetryImage> mirror_images(unsigned planes);

// Returns the image of a stroke. `image_file` is called for the reflection of a stamp only.
Stroke image_of(const Stroke& stroke, const SymmetryImage& image, const ImageFile& image_file);

// Returns the stroke and its images. Images that are the stroke itself or each other, up to `tolerance` in each number,
// count once.
std::vector<Stroke> with_images(const Stroke& stroke, std::span<const SymmetryImage> images, double tolerance,
                                const ImageFile& image_file);

// Returns strokes that do the same one after the other: one for each piece of the path of a ball, capsule or stamp and
// for each displacement of points; any other stroke as it is.
std::vector<Stroke> pieces_of(const Stroke& stroke);

// Returns the strokes of a gesture with all images, so that the sides grow together: the pieces of a stroke and of its
// images take turns, and so do the samples of paint and the points of relaxing. Images as in with_images. Without
// images, the strokes as they are.
std::vector<Stroke> symmetric_strokes(std::span<const Stroke> strokes, std::span<const SymmetryImage> images,
                                      double tolerance, const ImageFile& image_file);

}  // namespace knead
