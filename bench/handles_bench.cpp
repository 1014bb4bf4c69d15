// What marked regions do: where surfaces are close in space but not along the surface, what a large motion in one
// stroke costs against the same in ten, and the volume that is lost; on the made hand. With files, the last for them
// too. In double, so that what is seen is the field and the tolerance; times are of the processor, all threads summed.
// Usage: handles_bench [FILE...]
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/io/shape_file.h"
#include "knead/math/box.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/shapes.h"
#include "knead/tool/stroke.h"

namespace {

using namespace knead;
using Motion = std::variant<HandlesTranslation, HandlesRotation>;
using Marks = std::function<bool(const Vec3d&)>;

HandlesStroke stroke_on(const Mesh& mesh, const Marks& full, const Marks& zero, const Motion& motion) {
  HandlesStroke stroke;
  for (const Vec3d& p : mesh.positions) {
    if (full(p)) {
      stroke.full.push_back(p);
    } else if (zero(p)) {
      stroke.zero.push_back(p);
    }
  }
  stroke.motion = motion;
  return stroke;
}

struct Outcome {
  std::vector<Vec3d> positions;
  double seconds = 0;
  double steps = 0;  // per vertex
};

// The motion in equal pieces, a stroke each; the marks go along.
Outcome deform(const Mesh& mesh, HandlesStroke stroke, int pieces) {
  if (auto* by = std::get_if<HandlesTranslation>(&stroke.motion)) by->by = by->by / static_cast<double>(pieces);
  if (auto* turn = std::get_if<HandlesRotation>(&stroke.motion)) turn->angle_deg /= pieces;
  AdvectOptions options;
  options.tolerance = 1e-5 * bounding_box(mesh.positions).diagonal();
  options.precision = Precision::float64;
  Outcome outcome{mesh.positions, 0, 0};
  const std::clock_t start = std::clock();
  std::uint64_t steps = 0;
  for (int i = 0; i < pieces; ++i) {
    const Flow flow = flow_of(stroke);
    steps += advect(flow, outcome.positions, options).accepted_steps;
    if (pieces > 1) advect(flow, stroke.full, options);
  }
  outcome.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  outcome.steps = static_cast<double>(steps) / static_cast<double>(mesh.vertex_count());
  return outcome;
}

double volume_error(const Mesh& mesh, const std::vector<Vec3d>& positions) {
  return measure_volume_and_area(mesh, positions).volume / measure_volume_and_area(mesh, mesh.positions).volume - 1;
}

double height(const Finger& finger, const Vec3d& p) { return dot(finger.axis, p - finger.base); }

bool in_finger(const Finger& finger, const Vec3d& p) {
  const double h = height(finger, p);
  return h > 0 && norm(p - finger.base - finger.axis * h) < finger.radius + 0.02;
}

// The far half of a finger.
Marks tip_of(const Finger& finger) {
  return [&finger](const Vec3d& p) { return in_finger(finger, p) && height(finger, p) > 0.5 * finger.length; };
}

// How far the far half of each finger goes on average, as a part of the motion.
void neighbours(const Mesh& hand) {
  fmt::print("The middle finger's far half is lifted by 0.3; how far the others' far halves go, as a part of that\n");
  fmt::print("{:64}", "zero set");
  for (const Finger& finger : hand_fingers()) fmt::print("{:>9}", finger.name);
  fmt::print("{:>12}\n", "volume");
  const Finger& middle = hand_fingers()[2];
  const Vec3d by{0, 0, 0.3};
  const auto row = [&](const char* name, const Marks& zero) {
    const HandlesStroke stroke = stroke_on(hand, tip_of(middle), zero, HandlesTranslation{by});
    const Outcome outcome = deform(hand, stroke, 1);
    fmt::print("{:64}", fmt::format("{} ({} vertices)", name, stroke.zero.size()));
    for (const Finger& finger : hand_fingers()) {
      double sum = 0;
      int count = 0;
      for (std::size_t i = 0; i < hand.positions.size(); ++i) {
        if (!tip_of(finger)(hand.positions[i])) continue;
        sum += norm(outcome.positions[i] - hand.positions[i]) / norm(by);
        ++count;
      }
      fmt::print("{:9.3f}", sum / count);
    }
    fmt::print("{:12.1e}\n", volume_error(hand, outcome.positions));
  };
  row("wrist", [](const Vec3d& p) { return p.y < -0.6; });
  row("wrist and palm", [](const Vec3d& p) { return p.y < 0; });
  row("wrist, palm and the tips of the other fingers", [&](const Vec3d& p) {
    bool tip = p.y < 0;
    for (const Finger& finger : hand_fingers()) tip = tip || tip_of(finger)(p);
    return tip;
  });
  row("all but the middle finger", [&](const Vec3d& p) { return !in_finger(middle, p); });
}

void pieces(const Mesh& mesh, const char* name, const HandlesStroke& stroke) {
  const double diagonal = bounding_box(mesh.positions).diagonal();
  const Outcome once = deform(mesh, stroke, 1);
  for (const int count : {1, 10}) {
    const Outcome outcome = count == 1 ? once : deform(mesh, stroke, count);
    double difference = 0;
    for (std::size_t i = 0; i < once.positions.size(); ++i) {
      difference = std::fmax(difference, norm(outcome.positions[i] - once.positions[i]));
    }
    fmt::print("{:32}{:>8}{:10.2f} s{:10.1f}{:12.1e}{:14.1e}\n", name, count, outcome.seconds, outcome.steps,
               volume_error(mesh, outcome.positions), difference / diagonal);
  }
}

void large_motions(const Mesh& hand) {
  fmt::print("\nThe middle finger's far half, the palm resting: one stroke against many (tolerance 1e-5)\n");
  fmt::print("{:32}{:>8}{:>12}{:>10}{:>12}{:>14}\n", "motion", "strokes", "time", "steps", "volume", "difference/D");
  const Finger& middle = hand_fingers()[2];
  const Marks palm = [](const Vec3d& p) { return p.y < 0; };
  const auto motion = [&](const char* name, const Motion& by) {
    pieces(hand, name, stroke_on(hand, tip_of(middle), palm, by));
  };
  motion("moved by 0.3", HandlesTranslation{{0, 0, 0.3}});
  motion("moved by 1.5", HandlesTranslation{{0.3, 0.5, 1.4}});
  motion("turned by 90 about its base", HandlesRotation{{1, 0, 0}, middle.base, 90});
  motion("turned by 360 about itself", HandlesRotation{middle.axis, middle.base, 360});
}

// The tenth at one end of the longest side of the box moves, that at the other end rests.
void volumes(const Mesh& mesh, const std::string& name) {
  const Box box = bounding_box(mesh.positions);
  const Vec3d size = box.max - box.min;
  const std::size_t along = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  const Marks full = [&](const Vec3d& p) { return p[along] > box.max[along] - 0.1 * size[along]; };
  const Marks zero = [&](const Vec3d& p) { return p[along] < box.min[along] + 0.1 * size[along]; };
  Vec3d axis{0, 0, 0};
  axis[along] = 1;
  Vec3d across{0, 0, 0};
  across[(along + 1) % 3] = 1;
  const double diagonal = box.diagonal();
  const auto row = [&](const char* motion_name, const Motion& motion) {
    const HandlesStroke stroke = stroke_on(mesh, full, zero, motion);
    const Outcome outcome = deform(mesh, stroke, 1);
    fmt::print("{:26}{:26}{:>8}{:>8}{:8.1f} s{:8.1f}{:12.1e}\n", name, motion_name, stroke.full.size(),
               stroke.zero.size(), outcome.seconds, outcome.steps, volume_error(mesh, outcome.positions));
  };
  row("moved across by 0.2 D", HandlesTranslation{across * (0.2 * diagonal)});
  row("pulled out by 0.2 D", HandlesTranslation{axis * (0.2 * diagonal)});
  row("bent by 60", HandlesRotation{across, box.center(), 60});
  row("twisted by 180", HandlesRotation{axis, box.center(), 180});
}

}  // namespace

int main(int count, char** arguments) {
  const Mesh hand = make_shape(ShapeKind::hand, 5000);
  neighbours(hand);
  large_motions(hand);
  fmt::print("\nVolume: a tenth at one end moves, a tenth at the other rests\n");
  fmt::print("{:26}{:26}{:>8}{:>8}{:>10}{:>8}{:>12}\n", "shape", "motion", "full", "zero", "time", "steps", "volume");
  volumes(hand, "hand");
  for (int i = 1; i < count; ++i) {
    const std::filesystem::path path = arguments[i];
    volumes(read_shape(path).mesh, path.filename().string());
  }
  return 0;
}
