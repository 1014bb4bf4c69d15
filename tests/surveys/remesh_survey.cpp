// Random strong sessions of five strokes, of all tools, on closed shapes without self-intersections, remeshed at the
// defaults: what they end as, proved by the certificate.
//
//   remesh_survey FOLDER [SESSIONS [SEED [FIRST [distances]]]]
//
// FOLDER holds the shapes, which are taken in turn; SESSIONS (300) are made from the number FIRST (0) on. A session
// depends on SEED (1) and its number alone, so that one of them, or a part, can be made again. A session meets what is
// asked for if it ends with no two triangles that cross, with the coordinates as float, with its Euler characteristic,
// and with no angle below 5 degrees where it was touched; every other is a refusal, with a line that says why and the
// session's file in the temporary folder knead_remesh_survey. How far it is goes to the other output. With `distances`
// those from the true image are measured too, which takes most of the time.
//
// Each stroke is drawn on the surface where the strokes before it have moved the shape's own vertices, so that it finds
// the shape where it is. A stamp that touches nothing there is drawn again.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>

#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "random_strokes.h"

namespace knead::surveys {
namespace {

constexpr std::size_t kStrokes = 5;
constexpr double kMinAngle = 5;
constexpr int kMaxDraws = 100;

struct Subject {
  std::string name;
  Mesh mesh;
};

std::vector<Subject> subjects(const std::filesystem::path& folder) {
  std::vector<Subject> result;
  for (const char* name : {"armadillo_43k.ply", "camel_35k.ply", "fandisk_6k.ply", "hand_50k.ply",
                           "bust_maxplanck_5k.ply", "bust_nefertiti_35k.ply", "scorpion_6k.ply", "sphere_16k.ply",
                           "sphere_642.ply", "torus_2k.ply", "bar_6k.ply"}) {
    if (!std::filesystem::exists(folder / name)) continue;
    Mesh mesh = read_shape(folder / name).mesh;
    if (self_intersections(triangulate(mesh), mesh.positions).count == 0) result.push_back({name, std::move(mesh)});
  }
  return result;
}

// The tools of stamps: a ball, and a letter that stands on its stem, as large.
void write_stamps(const std::filesystem::path& folder) {
  write_mesh(folder / "ball.ply", make_shape(ShapeKind::sphere, 2000));
  Mesh letter = make_shape(ShapeKind::letter_y, 3000);
  for (Vec3d& p : letter.positions) p = Vec3d{p.x, -p.z, p.y} * 2.4;
  write_mesh(folder / "letter.ply", letter);
}

// Takes the shape through one stroke as it is; false where that cannot be, or a stamp touches nothing.
bool try_out(Mesh& mesh, const Session& session) {
  try {
    ReplayResult result = replay(mesh, session, {});
    if (result.status != AdvectStatus::done) return true;  // the session's own replay will say so
    const bool touches = result.shape.positions() != mesh.positions;
    mesh.positions = std::move(result.shape).positions();
    return touches || session.strokes[0].stroke.index() != Stroke(StampStroke{}).index();
  } catch (const InvalidInput&) {
    return true;
  }
}

Session draw_session(const Subject& subject, const std::filesystem::path& folder, std::mt19937_64& random) {
  Session session;
  session.name = (folder / "survey.knead").string();
  Mesh mesh = subject.mesh;
  for (std::size_t i = 0; i < kStrokes; ++i) {
    const std::string& tool = tool_names()[random() % tool_names().size()];
    const char* const stamp = random() % 2 == 0 ? "ball.ply" : "letter.ply";
    const std::vector<Vec3d> normals = vertex_normals(mesh);
    Session one = session;
    for (int draws = 0; draws < kMaxDraws; ++draws) {
      one.strokes = {{random_stroke(tool, mesh, normals, stamp, random), i + 2}};
      if (try_out(mesh, one)) break;
    }
    session.strokes.push_back(one.strokes[0]);
  }
  return session;
}

double smallest_angle(const Mesh& mesh, const std::vector<bool>& moved) {
  double smallest = std::numbers::pi;
  const std::vector<Vec3d>& p = mesh.positions;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    if (face.size() != 3) continue;
    if (std::none_of(face.begin(), face.end(), [&](std::uint32_t v) { return moved[v]; })) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d a = p[face[(i + 1) % 3]] - p[face[i]];
      const Vec3d b = p[face[(i + 2) % 3]] - p[face[i]];
      smallest = std::min(smallest, std::atan2(norm(cross(a, b)), dot(a, b)));
    }
  }
  return smallest * 180 / std::numbers::pi;
}

// Of all threads.
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Ending {
  std::string cause;  // empty: it meets what is asked for
  std::string details;
  std::vector<std::string> strokes;  // what each did
  std::optional<double> volume_error;
  double distance_rms = 0;
  double distance_max = 0;
  double growth = 1;   // of the vertices
  double seconds = 0;  // of the processor, without those of the certificate
};

std::string tool_of(const SessionStroke& stroke) {
  const std::string line = stroke_line(stroke.stroke);
  const std::size_t begin = line.find(':') + 3;
  return line.substr(begin, line.find('"', begin) - begin);
}

void judge(const Certificate& certificate, Ending& ending) {
  ending.volume_error = certificate.volume_error;
  ending.distance_rms = certificate.distance_rms;
  ending.distance_max = certificate.distance_max;
  const double angle = certificate.touched_angle_after.value_or(180);
  if (certificate.crossings_after > 0) {
    ending.cause = "triangles cross";
    ending.details = fmt::format("{} pairs", certificate.crossings_after);
  } else if (certificate.euler_after != certificate.euler_before || !certificate.closed_after) {
    ending.cause = "Euler characteristic";
    ending.details = fmt::format("{}, was {}", certificate.euler_after, certificate.euler_before);
  } else if (certificate.degenerate_after > certificate.degenerate_before) {
    ending.cause = "degenerate triangles";
    ending.details = fmt::format("{}, were {}", certificate.degenerate_after, certificate.degenerate_before);
  } else if (!(angle > kMinAngle)) {
    ending.cause = "angle";
    ending.details =
        fmt::format("{:.2f} degrees, were {:.2f} there", angle, certificate.touched_angle_before.value_or(180));
  }
}

Ending run_session(const Subject& subject, const Session& session, bool distances) {
  Ending ending;
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.may_cross = true;  // they are counted
  CertificateBuilder builder(subject.mesh, options);
  double begin = processor_seconds();
  options.on_stroke = [&](const AppliedStroke& stroke) {
    const double seconds = processor_seconds() - begin;
    ending.seconds += seconds;
    std::string text = fmt::format("{:9} {:>7} -> {:>7} vertices, {:5.2f} s", tool_of(session.strokes[stroke.line - 2]),
                                   stroke.before.mesh().vertex_count(), stroke.after.mesh().vertex_count(), seconds);
    if (stroke.remeshed != nullptr) {
      const RemeshCounts& counts = stroke.remeshed->counts;
      text += fmt::format(", {} crossings, {:.2f} degrees{}", counts.crossings,
                          smallest_angle(stroke.after.mesh(), stroke.remeshed->moved),
                          counts.complete ? "" : ", incomplete");
    }
    ending.strokes.push_back(text);
    if (distances) builder.add(stroke);
    begin = processor_seconds();
  };
  try {
    const ReplayResult result = replay(subject.mesh, session, options);
    if (result.status != AdvectStatus::done) {
      ending.cause = "step limit";
      ending.details = fmt::format("stroke {}", result.failed_line - 1);
      return ending;
    }
    ending.growth =
        static_cast<double>(result.shape.positions().size()) / static_cast<double>(subject.mesh.vertex_count());
    judge(builder.finish(result, true), ending);
  } catch (const InvalidInput& error) {
    ending.cause = "stroke refused";
    ending.details = error.what();
  }
  return ending;
}

void print_refusal(std::size_t number, const Subject& subject, const Session& session, const Ending& ending) {
  fmt::print("{} {}: {}: {}; volume {:.1e}, {:.1f} s\n", number, subject.name, ending.cause, ending.details,
             ending.volume_error.value_or(0), ending.seconds);
  for (const std::string& stroke : ending.strokes) fmt::print("    {}\n", stroke);
  if (ending.strokes.size() < session.strokes.size()) {
    fmt::print("    {}\n", stroke_line(session.strokes[ending.strokes.size()].stroke).substr(0, 160));
  }
}

struct Figures {
  double median = 0;
  double max = 0;
};

Figures figures(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  return {values[values.size() / 2], values.back()};
}

void print_table(const std::vector<Ending>& endings) {
  std::map<std::string, std::size_t> causes;
  std::vector<double> volume, seconds, growth, rms, max;
  for (const Ending& ending : endings) {
    ++causes[ending.cause];
    seconds.push_back(ending.seconds);
    if (!ending.cause.empty()) continue;
    volume.push_back(std::abs(ending.volume_error.value_or(0)));
    growth.push_back(ending.growth);
    rms.push_back(ending.distance_rms);
    max.push_back(ending.distance_max);
  }
  const std::size_t met = causes[""];
  const auto percent = [&](std::size_t count) {
    return 100 * static_cast<double>(count) / static_cast<double>(endings.size());
  };
  fmt::print("\n{} sessions, {} met ({:.1f}%), {} refused ({:.1f}%)\n", endings.size(), met, percent(met),
             endings.size() - met, percent(endings.size() - met));
  for (const auto& [cause, count] : causes) {
    if (!cause.empty()) fmt::print("  {:22} {:5} {:6.1f}%\n", cause, count, percent(count));
  }
  const auto row = [](const char* what, const std::vector<double>& values) {
    const Figures f = figures(values);
    fmt::print("{:36} median {:9.3g}  max {:9.3g}\n", what, f.median, f.max);
  };
  row("volume error (met)", volume);
  row("vertices, times (met)", growth);
  row("processor seconds (all)", seconds);
  if (figures(max).max == 0) return;
  row("distance, rms (met)", rms);
  row("distance, max (met)", max);
}

int run(const std::filesystem::path& folder, std::size_t sessions, std::size_t seed, std::size_t first,
        bool distances) {
  const std::vector<Subject> shapes = subjects(folder);
  if (shapes.empty()) {
    fmt::print(stderr, "remesh_survey: {}: no shape without self-intersections here\n", folder.string());
    return 3;
  }
  const auto scratch = std::filesystem::temp_directory_path() / "knead_remesh_survey";
  std::filesystem::create_directories(scratch);
  write_stamps(scratch);
  fmt::print("{} shapes, sessions {} to {}, seed {}\n", shapes.size(), first, first + sessions - 1, seed);
  std::vector<Ending> endings;
  for (std::size_t i = first; i < first + sessions; ++i) {
    std::seed_seq numbers{seed, i};
    std::mt19937_64 random(numbers);
    const Subject& subject = shapes[i % shapes.size()];
    Session session = draw_session(subject, scratch, random);
    session.mesh = std::filesystem::relative(folder / subject.name, scratch).string();
    const std::filesystem::path file = scratch / fmt::format("{}.knead", i);
    std::ofstream(file) << serialize_session(session);
    endings.push_back(run_session(subject, session, distances));
    if (!endings.back().cause.empty()) print_refusal(i, subject, session, endings.back());
    std::fflush(stdout);
    const Ending& ending = endings.back();
    if (ending.cause.empty()) std::filesystem::remove(file);
    fmt::print(stderr, "{} {}: {}, {:.1f} s\n", i, subject.name, ending.cause.empty() ? "met" : ending.cause,
               ending.seconds);
  }
  print_table(endings);
  return 0;
}

}  // namespace
}  // namespace knead::surveys

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: remesh_survey FOLDER [SESSIONS [SEED [FIRST [distances]]]]\n");
    return 2;
  }
  const auto number = [&](int i, unsigned long otherwise) {
    return argc > i ? std::strtoul(argv[i], nullptr, 10) : otherwise;
  };
  return knead::surveys::run(argv[1], number(2, 300), number(3, 1), number(4, 0), argc > 5);
}
