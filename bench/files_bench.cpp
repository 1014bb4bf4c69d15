// How fast, and with how much memory, files are read and written, beside copying them and beside other libraries (those
// that were found when this was built). All in one run, single-threaded. Every measurement is a fresh process, as for
// a command that reads, deforms and writes once: the median of processor time of several, so that what else the machine
// does counts less, and the peak of resident memory beyond that of a process that does nothing.
// Usage: files_bench [PLY [OBJ]]; without arguments shapes are made. Files are written to the folder for temporary
// ones.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "knead/io.h"
#include "knead/mesh.h"

#ifdef KNEAD_HAS_OPENMESH
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#endif
#ifdef KNEAD_HAS_ASSIMP
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#endif
#ifdef KNEAD_HAS_TINYOBJ
#include <tiny_obj_loader.h>
#endif

namespace {

using namespace knead;
namespace fs = std::filesystem;

constexpr int kRepetitions = 7;

double seconds_now() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Cost {
  double ms = 0;
  double mb = 0;
};

// In a child, `prepare` untimed and then `work`; the peak is that of both.
Cost cost_once(const std::function<void()>& prepare, const std::function<void()>& work) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) return {};
  const pid_t child = ::fork();
  if (child == 0) {
    prepare();
    const double begin = seconds_now();
    work();
    const double ms = 1e3 * (seconds_now() - begin);
    ::_exit(::write(ends[1], &ms, sizeof ms) == sizeof ms ? 0 : 1);
  }
  Cost cost;
  rusage usage{};
  ::wait4(child, nullptr, 0, &usage);
  if (::read(ends[0], &cost.ms, sizeof cost.ms) != sizeof cost.ms) fmt::print("a measurement failed\n");
  ::close(ends[0]);
  ::close(ends[1]);
  cost.mb = static_cast<double>(usage.ru_maxrss) / 1024;
  return cost;
}

Cost cost_of(const std::function<void()>& prepare, const std::function<void()>& work) {
  const auto nothing = [] {};
  std::vector<double> times;
  Cost cost;
  for (int i = 0; i < kRepetitions; ++i) {
    const Cost once = cost_once(prepare, work);
    times.push_back(once.ms);
    cost.mb = once.mb;
  }
  std::nth_element(times.begin(), times.begin() + kRepetitions / 2, times.end());
  cost.ms = times[kRepetitions / 2];
  cost.mb -= cost_once(nothing, nothing).mb;
  return cost;
}

std::string bytes_of(const fs::path& path) {
  std::string bytes(fs::file_size(path), '\0');
  const std::size_t count = [&] {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    const std::size_t read = file == nullptr ? 0 : std::fread(bytes.data(), 1, bytes.size(), file);
    if (file != nullptr) std::fclose(file);
    return read;
  }();
  bytes.resize(count);
  return bytes;
}

class Table {
 public:
  Table(const fs::path& file, const std::function<void()>& copy) : file_(file), copy_ms_(cost_of([] {}, copy).ms) {
    fmt::print("\n{}: {:.1f} MB\n\n| | ms | of copying | peak MB |\n| --- | ---: | ---: | ---: |\n",
               file.filename().string(), static_cast<double>(fs::file_size(file)) / 1e6);
  }

  void row(
      const std::string& name, const std::function<void()>& work, const std::function<void()>& prepare = [] {}) const {
    const Cost cost = cost_of(prepare, work);
    fmt::print("| {} | {:.1f} | {:.2f} | {:.1f} |\n", name, cost.ms, cost.ms / copy_ms_, cost.mb);
    std::fflush(stdout);
  }

  const fs::path& file() const { return file_; }

 private:
  fs::path file_;
  double copy_ms_;
};

void rows_of_others(const Table& table, [[maybe_unused]] const fs::path& out) {
  const std::string file = table.file().string();
#ifdef KNEAD_HAS_OPENMESH
  using OpenMeshMesh = OpenMesh::TriMesh_ArrayKernelT<>;
  table.row("OpenMesh: read", [&] {
    OpenMeshMesh mesh;
    if (!OpenMesh::IO::read_mesh(mesh, file)) fmt::print("failed\n");
  });
  OpenMeshMesh mesh;
  if (OpenMesh::IO::read_mesh(mesh, file)) {
    const auto options = out.extension() == ".ply" ? OpenMesh::IO::Options::Binary : OpenMesh::IO::Options::Default;
    table.row("OpenMesh: write", [&] { OpenMesh::IO::write_mesh(mesh, out.string(), options); });
  }
#endif
#ifdef KNEAD_HAS_ASSIMP
  table.row("assimp: read", [&] {
    Assimp::Importer importer;
    if (importer.ReadFile(file, 0) == nullptr) fmt::print("failed: {}\n", importer.GetErrorString());
  });
#endif
#ifdef KNEAD_HAS_TINYOBJ
  if (out.extension() == ".obj") {
    table.row("tinyobjloader: read", [&] {
      tinyobj::ObjReader reader;
      if (!reader.ParseFromFile(file)) fmt::print("failed: {}\n", reader.Error());
    });
  }
#endif
}

void compare(const fs::path& file) {
  const std::string format = format_of(file);
  const fs::path out = fs::temp_directory_path() / fmt::format("knead_files_bench_{}.{}", ::getpid(), format);
  const auto copy = [&] { write_file_atomically(out, bytes_of(file)); };
  const Table table(file, copy);
  table.row("copy: read into memory", [&] { bytes_of(file); });
  table.row("copy: read and write", copy);
  table.row("Knead: read", [&] { read_shape(file); });
  ShapeFile shape;
  std::vector<Vec3d> moved;
  const auto read_and_move = [&] {
    shape = read_shape(file);
    moved = shape.mesh.positions;
    for (Vec3d& p : moved) p = {p.x * 0.75 + p.y * 0.25, p.y * 1.25, p.z + 0.125};
  };
  table.row(
      "Knead: write, all vertices moved", [&] { write_shape(out, shape, moved); }, read_and_move);
  rows_of_others(table, out);
  fs::remove(out);
}

// Keeps this process as small as it is.
void in_child(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    work();
    ::_exit(0);
  }
  ::waitpid(child, nullptr, 0);
}

// An OBJ file of about that many bytes.
fs::path made_obj(double bytes) {
  fs::path path = fs::temp_directory_path() / fmt::format("knead_files_bench_{}_made.obj", ::getpid());
  in_child([&] { write_mesh(path, make_shape(ShapeKind::hand, static_cast<int>(bytes / 107))); });
  return path;
}

fs::path made_ply(int vertices) {
  fs::path path = fs::temp_directory_path() / fmt::format("knead_files_bench_{}_made.ply", ::getpid());
  in_child([&] { write_mesh(path, make_shape(ShapeKind::hand, vertices)); });
  return path;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int paper_vertices = 437'645;
  constexpr double obj_bytes = 64e6;
  const bool with_ply = argc > 1;
  const bool with_obj = argc > 2;
  const fs::path ply = with_ply ? fs::path(argv[1]) : made_ply(paper_vertices);
  const fs::path obj = with_obj ? fs::path(argv[2]) : made_obj(obj_bytes);
  compare(ply);
  compare(obj);
  if (!with_ply) fs::remove(ply);
  if (!with_obj) fs::remove(obj);
}
