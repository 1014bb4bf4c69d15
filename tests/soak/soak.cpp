// Random sessions on random shapes, taken by every road to a shape; all must end at the same bits.
//
//   knead_soak KNEAD AMOUNT [SEED [FIRST [FOLDER OF MESHES]]]
//
// A session is made on a Workbench: strokes of every tool in pieces, given up, undone, redone and edited; some are
// remeshed. A journal follows it. Then its strokes are replayed in the library with other numbers of threads, recovered
// from the journal, and applied by the command KNEAD with other threads and instruction sets, from PLY and from OBJ.
// AMOUNT is a number of sessions, or a time in seconds as 600s. A session depends on SEED (1) and its number alone;
// FIRST (0) is the first number, which makes one of them again.
// Exit code 0: no two roads differed. The files of a session that differs stay in the folder that is named.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string_view>

#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "surveys/random_strokes.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

struct Count {
  std::size_t sessions = 0;
  std::size_t strokes = 0;
  std::size_t refused = 0;  // gestures that the shape could not take
  std::size_t remeshed = 0;
  std::size_t runs = 0;  // of the command
  std::size_t differences = 0;
};

bool is_same(const Mesh& a, const Mesh& b) {
  return a.positions == b.positions && a.face_begin == b.face_begin && a.corner_vertex == b.corner_vertex &&
         a.attributes == b.attributes;
}

std::string read_bytes(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class Soak {
 public:
  Soak(std::string command, fs::path meshes, std::uint64_t seed)
      : command_(std::move(command)),
        seed_(seed),
        folder_(fs::temp_directory_path() / fmt::format("knead_soak_{}", ::getpid())) {
    fs::create_directories(folder_);
    stamp_ = (folder_ / "ball.ply").string();
    write_mesh(stamp_, make_shape(ShapeKind::sphere, 642));
    if (meshes.empty()) return;
    for (const fs::directory_entry& entry : fs::directory_iterator(meshes)) {
      if (entry.path().extension() == ".ply" && entry.file_size() < 1'500'000) meshes_.push_back(entry.path());
    }
    std::sort(meshes_.begin(), meshes_.end());
  }
  ~Soak() {
    std::error_code ignored;
    if (count_.differences == 0) fs::remove_all(folder_, ignored);
  }
  Soak(const Soak&) = delete;
  Soak& operator=(const Soak&) = delete;

  const Count& count() const { return count_; }

  void run(std::size_t number) {
    number_ = number;
    random_.seed(seed_ * 1'000'003 + number);
    const ShapeFile shape = draw_shape();
    Journal journal = Journal::create(folder_ / "journals", shape, "soak");
    Workbench bench(shape.mesh, folder_, face_labels(shape));
    try {
      make_session(bench, journal, shape.mesh);
      compare(bench, journal, shape);
    } catch (const std::exception& error) {
      expect(false, fmt::format("what one road refuses ({})", error.what()));
    }
    journal.discard();
    ++count_.sessions;
  }

 private:
  bool chance(double part) { return std::uniform_real_distribution<double>(0, 1)(random_) < part; }
  std::size_t below(std::size_t count) { return random_() % count; }

  void expect(bool same, const std::string& what) {
    if (same) return;
    ++count_.differences;
    fmt::print("seed {}, session {}: {} differs; its files are in {}\n", seed_, number_, what, folder_.string());
    const fs::path kept = folder_ / fmt::format("session_{}", number_);
    fs::create_directories(kept);
    for (const char* name : {"shape.ply", "session.knead"}) {
      if (fs::exists(folder_ / name)) fs::copy_file(folder_ / name, kept / name, fs::copy_options::overwrite_existing);
    }
  }

  // With coordinates that floats hold, so that a file of floats is the shape.
  ShapeFile draw_shape() {
    Mesh mesh;
    if (!meshes_.empty() && chance(0.3)) {
      mesh = read_shape(meshes_[below(meshes_.size())]).mesh;
    } else {
      const ShapeKind kind = static_cast<ShapeKind>(below(shape_names().size()));
      mesh = make_shape(kind, std::max<std::size_t>(shape_counts(kind).minimum, 200 + below(3000)));
    }
    for (Vec3d& p : mesh.positions) p = Vec3d(Vec3f(p));
    write_mesh(folder_ / "shape.ply", mesh);
    return read_shape(folder_ / "shape.ply");
  }

  SessionStroke draw_stroke(const Workbench& bench) {
    const Mesh mesh = bench.state().to_mesh();
    static const std::vector<std::string> kEvents{"relax", "mask"};
    const std::string& tool =
        chance(0.15) ? kEvents[below(2)] : surveys::tool_names()[below(surveys::tool_names().size())];
    SessionStroke stroke{surveys::random_stroke(tool, mesh, vertex_normals(mesh), stamp_, random_)};
    if (falloff_of(stroke.stroke) && chance(0.3)) set_falloff(stroke.stroke, 3 + static_cast<int>(below(5)));
    if (chance(0.2) && mesh.vertex_count() < 10'000) stroke.remesh.emplace().max_vertices = 40'000;
    if (chance(0.1)) stroke.off = true;
    if (chance(0.2)) stroke.strength = static_cast<double>(below(101)) / 100;
    return stroke;
  }

  // The beginning of a stroke along a path, as a hand that moves it gives.
  static std::optional<SessionStroke> beginning(SessionStroke stroke) {
    ImplicitStroke* path = std::get_if<ImplicitStroke>(&stroke.stroke);
    if (path == nullptr || path->path.size() < 3) return {};
    path->path.pop_back();
    return stroke;
  }

  WorkResult follow(WorkResult result, Journal& journal) {
    if (!result.is_done()) ++count_.refused;
    journal.replace(result.lines.undone, result.lines.appended);
    return result;
  }

  void make_session(Workbench& bench, Journal& journal, const Mesh& start) {
    const std::size_t strokes = start.vertex_count() > 10'000 ? 3 : 6;
    for (std::size_t i = 0; i < strokes; ++i) {
      const SessionStroke stroke = draw_stroke(bench);
      if (const auto part = beginning(stroke)) follow(bench.set_live({*part}), journal);
      const bool taken = follow(bench.set_live({stroke}), journal).is_done();
      if (!taken || chance(0.1) || !follow(chance(0.3) ? bench.finish_later() : bench.finish(), journal).is_done()) {
        follow(bench.set_live({}), journal);
      }
      if (!bench.is_settled()) follow(bench.settle(), journal);
      if (chance(0.25) && bench.can_undo()) follow(bench.undo(), journal);
      if (chance(0.5) && bench.can_redo()) follow(bench.redo(), journal);
      if (chance(0.1) && bench.done().size() > 1) edit(bench, journal);
    }
  }

  void edit(Workbench& bench, Journal& journal) {
    const std::size_t entry = below(bench.done().size());
    std::vector<SessionStroke> strokes = bench.done()[entry]->strokes;
    for (SessionStroke& stroke : strokes) stroke.off = !stroke.off;
    follow(bench.edit(entry, std::move(strokes)), journal);
  }

  void compare(const Workbench& bench, const Journal& journal, const ShapeFile& shape) {
    Session session;
    session.name = (folder_ / "session.knead").string();
    session.strokes = bench.strokes();
    count_.strokes += session.strokes.size();
    std::ofstream(session.name) << serialize_session(session);
    const auto mesh = std::make_shared<const Mesh>(shape.mesh);
    ReplayOptions options;
    options.remesh.face_labels = face_labels(shape);
    options.motion.threads = 1;
    const ReplayResult result = replay(mesh, session, options);
    count_.remeshed += result.shape.is_remeshed();
    const Mesh end = result.shape.to_mesh();
    expect(is_same(bench.state().to_mesh(), end), "the Workbench");
    options.motion.threads = 2 + static_cast<int>(below(4));
    expect(is_same(replay(mesh, read_session(session.name), options).shape.to_mesh(), end), "a replay of the file");
    const RecoveredWork recovered = recover_journal(journal.folder());
    expect(is_same(replay(mesh, recovered.session, options).shape.to_mesh(), end), "the journal");
    compare_command(shape, session, result.shape);
  }

  void compare_command(const ShapeFile& shape, const Session& session, const DeformedShape& end) {
    const auto expected = [&](const ShapeFile& source) {
      if (!end.is_remeshed()) return serialize_shape(source.format, source, end.positions());
      return serialize_remeshed(source.format, source, end.to_mesh(), end.provenance()->face_source);
    };
    const std::string bytes = expected(shape);
    for (const char* simd : {"", "KNEAD_SIMD=scalar "}) {
      const fs::path out = folder_ / "out.ply";
      const std::string way = fmt::format("{}--threads {}", simd, 1 + below(4));
      run_command(fmt::format("{}{} deform {} {} --keep-mesh --threads {} -q -o {}", simd, command_,
                              (folder_ / "shape.ply").string(), session.name, way.substr(way.rfind(' ') + 1),
                              out.string()));
      expect(read_bytes(out) == bytes, "the command with " + way);
    }
    if (end.is_remeshed()) return;  // its crossings are judged in the numbers of the file, here doubles
    const fs::path text = folder_ / "shape.obj";
    const fs::path out = folder_ / "out.obj";
    write_mesh(text, shape.mesh);
    run_command(fmt::format("{} deform {} {} --keep-mesh --digits shortest -q -o {}", command_, text.string(),
                            session.name, out.string()));
    expect(read_shape(out).mesh.positions == end.positions(), "the command with OBJ");
  }

  void run_command(const std::string& line) {
    ++count_.runs;
    expect(std::system(line.c_str()) == 0, "the exit code of " + line);
  }

  std::string command_;
  std::uint64_t seed_ = 1;
  std::size_t number_ = 0;
  fs::path folder_;
  std::string stamp_;
  std::vector<fs::path> meshes_;
  std::mt19937_64 random_;
  Count count_;
};

int soak(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: knead_soak KNEAD SESSIONS|SECONDSs [SEED [FIRST [FOLDER OF MESHES]]]\n");
    return 2;
  }
  const bool is_time = std::string_view(argv[2]).ends_with('s');
  const std::size_t amount = std::strtoull(argv[2], nullptr, 10);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(amount);
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  const std::size_t first = argc > 4 ? std::strtoull(argv[4], nullptr, 10) : 0;
  Soak all(argv[1], argc > 5 ? argv[5] : "", seed);
  fmt::print("seed {}\n", seed);
  for (std::size_t i = first; is_time ? std::chrono::steady_clock::now() < end : i < first + amount; ++i) all.run(i);
  const Count& count = all.count();
  fmt::print("{} sessions of {} strokes, {} remeshed; {} gestures refused; {} runs of the command; {} differences\n",
             count.sessions, count.strokes, count.remeshed, count.refused, count.runs, count.differences);
  return count.differences == 0 ? 0 : 1;
}

}  // namespace
}  // namespace knead

int main(int argc, char** argv) {
  try {
    return knead::soak(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "knead_soak: {}\n", error.what());
    return 1;
  }
}
