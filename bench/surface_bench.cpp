// Nearest points and rays: SurfaceTree beside Embree, where that is found. One thread; medians of times taken in turn.
// Then how many answers change with the instructions that Embree picks, and between Embree and SurfaceTree.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "knead/mesh/shapes.h"
#include "knead/mesh/surface_tree.h"
#include "knead/mesh/triangle_queries.h"

#ifdef KNEAD_HAS_EMBREE
#include <embree3/rtcore.h>
#endif

namespace {

using namespace knead;

constexpr int kRepetitions = 5;
constexpr std::size_t kQueries = 20'000;

struct Answer {
  std::uint32_t triangle = 0xffffffffU;
  double value = -1;  // distance, or the ray's t
};
using Answers = std::vector<Answer>;

// What is asked: places within a hundredth of the diagonal of the surface, and rays from there along one direction.
struct Questions {
  Mesh mesh;
  std::vector<Triangle> triangles;
  std::vector<Vec3d> points;
  Vec3d direction{0.1, 0.2, -1};
};

Questions questions_about(ShapeKind kind, std::size_t vertices) {
  Questions questions;
  questions.mesh = make_shape(kind, vertices);
  questions.triangles = triangulate(questions.mesh);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  const double reach = 0.01 * bounding_box(questions.mesh.positions).diagonal();
  for (std::size_t i = 0; i < kQueries; ++i) {
    const Vec3d& p = questions.mesh.positions[random() % questions.mesh.positions.size()];
    questions.points.push_back(p + Vec3d{number(random), number(random), number(random)} * reach);
  }
  return questions;
}

// Something that answers. refit: the same positions once more.
struct Contender {
  std::string name;
  std::function<void()> build;
  std::function<void()> refit;
  std::function<Answers()> closest;
  std::function<Answers()> rays;
};

Contender own(const Questions& questions) {
  auto tree = std::make_shared<SurfaceTree>(questions.triangles, questions.mesh.positions);
  const auto ask = [&questions](auto one) {
    Answers answers;
    for (const Vec3d& p : questions.points) answers.push_back(one(p));
    return answers;
  };
  return {"SurfaceTree", [&questions, tree] { *tree = SurfaceTree(questions.triangles, questions.mesh.positions); },
          [&questions, tree] { tree->refit(questions.mesh.positions); },
          [=] {
            return ask([&](const Vec3d& p) {
              const auto found = tree->closest(p);
              return Answer{found->triangle, found->distance};
            });
          },
          [=, &questions] {
            return ask([&](const Vec3d& p) {
              const auto hit = tree->first_hit(p, questions.direction);
              return hit ? Answer{hit->triangle, hit->t} : Answer{};
            });
          }};
}

#ifdef KNEAD_HAS_EMBREE

class EmbreeScene {
 public:
  EmbreeScene(const Questions& questions, const std::string& isa)
      : questions_(questions),
        device_(rtcNewDevice(fmt::format("threads=1,set_affinity=0,isa={},max_isa={}", isa, isa).c_str())),
        geometry_(rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE)) {
    const std::size_t count = questions.mesh.positions.size();
    positions_ = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), count));
    auto* triangles = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Triangle), questions.triangles.size()));
    for (const Triangle& t : questions.triangles) triangles = std::copy(t.begin(), t.end(), triangles);
    fill();
    rtcSetGeometryBuildQuality(geometry_, RTC_BUILD_QUALITY_REFIT);
    build();
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseGeometry(geometry_);
    rtcReleaseDevice(device_);
  }

  void build() {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
    rtcCommitGeometry(geometry_);
    rtcAttachGeometry(scene_, geometry_);
    rtcCommitScene(scene_);
  }

  void refit() {
    fill();
    rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
  }

  // Embree finds the triangles near by; which is nearest is decided in double.
  Answer closest(const Vec3d& p) const {
    Search search{&questions_, p, {}};
    RTCPointQuery query{};
    query.x = static_cast<float>(p.x);
    query.y = static_cast<float>(p.y);
    query.z = static_cast<float>(p.z);
    query.radius = std::numeric_limits<float>::infinity();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &query, &context, &look_at, &search);
    return search.best;
  }

  Answer first_hit(const Vec3d& p) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray{};
    const Vec3f origin(p);
    const Vec3f direction(questions_.direction);
    ray.ray.org_x = origin.x;
    ray.ray.org_y = origin.y;
    ray.ray.org_z = origin.z;
    ray.ray.dir_x = direction.x;
    ray.ray.dir_y = direction.y;
    ray.ray.dir_z = direction.z;
    ray.ray.tfar = std::numeric_limits<float>::infinity();
    ray.ray.mask = 0xffffffffU;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &ray);
    return ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? Answer{} : Answer{ray.hit.primID, ray.ray.tfar};
  }

 private:
  struct Search {
    const Questions* questions;
    Vec3d p;
    Answer best;
  };

  static bool look_at(RTCPointQueryFunctionArguments* arguments) {
    auto& search = *static_cast<Search*>(arguments->userPtr);
    const Triangle& t = search.questions->triangles[arguments->primID];
    const auto& positions = search.questions->mesh.positions;
    const double distance =
        std::sqrt(nearest_on_triangle({positions[t[0]], positions[t[1]], positions[t[2]]}, search.p).distance2);
    Answer& best = search.best;
    const bool tie = distance == best.value && arguments->primID < best.triangle;
    if (best.value >= 0 && distance >= best.value && !tie) return false;
    best = {arguments->primID, distance};
    arguments->query->radius = static_cast<float>(distance) * 1.0001F;
    return true;
  }

  void fill() {
    for (std::size_t i = 0; i < questions_.mesh.positions.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) positions_[3 * i + k] = static_cast<float>(questions_.mesh.positions[i][k]);
    }
  }

  const Questions& questions_;
  RTCDevice device_;
  RTCGeometry geometry_;
  RTCScene scene_ = nullptr;
  float* positions_ = nullptr;
};

Contender embree(const Questions& questions, const std::string& isa) {
  auto scene = std::make_shared<EmbreeScene>(questions, isa);
  const auto ask = [&questions](auto one) {
    Answers answers;
    for (const Vec3d& p : questions.points) answers.push_back(one(p));
    return answers;
  };
  return {"Embree " + isa, [scene] { scene->build(); }, [scene] { scene->refit(); },
          [=] { return ask([&](const Vec3d& p) { return scene->closest(p); }); },
          [=] { return ask([&](const Vec3d& p) { return scene->first_hit(p); }); }};
}

#endif

std::vector<Contender> contenders(const Questions& questions) {
  std::vector<Contender> result{own(questions)};
#ifdef KNEAD_HAS_EMBREE
  for (const char* isa : {"sse4.2", "avx2", "avx512"}) result.push_back(embree(questions, isa));
#endif
  return result;
}

double milliseconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Of each contender, the median time of one of its functions; they take turns.
std::vector<double> times(const std::vector<Contender>& all, const std::function<void(const Contender&)>& work) {
  std::vector<std::vector<double>> taken(all.size());
  for (int i = 0; i < kRepetitions; ++i) {
    for (std::size_t k = 0; k < all.size(); ++k) taken[k].push_back(milliseconds_of([&] { work(all[k]); }));
  }
  std::vector<double> medians;
  for (std::vector<double>& of_one : taken) {
    std::nth_element(of_one.begin(), of_one.begin() + kRepetitions / 2, of_one.end());
    medians.push_back(of_one[kRepetitions / 2]);
  }
  return medians;
}

void compare_times(const std::vector<Contender>& all, std::size_t triangles) {
  const std::vector<double> build = times(all, [](const Contender& c) { c.build(); });
  const std::vector<double> refit = times(all, [](const Contender& c) { c.refit(); });
  const std::vector<double> closest = times(all, [](const Contender& c) { c.closest(); });
  const std::vector<double> rays = times(all, [](const Contender& c) { c.rays(); });
  fmt::print("\n{} triangles\n\n| | build ms | refit ms | closest us | ray us |\n| --- | ---: | ---: | ---: | ---: |\n",
             triangles);
  for (std::size_t k = 0; k < all.size(); ++k) {
    fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", all[k].name, build[k], refit[k],
               1e3 * closest[k] / kQueries, 1e3 * rays[k] / kQueries);
  }
}

struct Differences {
  std::size_t triangles = 0;
  std::size_t values = 0;
  double largest = 0;
};

Differences differences(const Answers& a, const Answers& b) {
  Differences result;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].triangle != b[i].triangle) ++result.triangles;
    if (a[i].value != b[i].value) ++result.values;
    result.largest = std::max(result.largest, std::abs(a[i].value - b[i].value));
  }
  return result;
}

void compare_answers(const std::vector<Contender>& all) {
  fmt::print(
      "\nOf {} answers differ, by the triangle or by distance or t:\n\n| | closest | | ray | | by at most |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: |\n",
      kQueries);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      const Differences closest = differences(all[i].closest(), all[k].closest());
      const Differences rays = differences(all[i].rays(), all[k].rays());
      fmt::print("| {}, {} | {} | {} | {} | {} | {:.1e} |\n", all[i].name, all[k].name, closest.triangles,
                 closest.values, rays.triangles, rays.values, rays.largest);
    }
  }
}

}  // namespace

int main() {
  for (const std::size_t vertices : {10'000UL, 100'000UL}) {
    const Questions questions = questions_about(ShapeKind::hand, vertices);
    const std::vector<Contender> all = contenders(questions);
    compare_times(all, questions.triangles.size());
    compare_answers(all);
  }
}
