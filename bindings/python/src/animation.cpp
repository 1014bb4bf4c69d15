// The motion of a session: frames as arrays, and as one file.
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstring>
#include <filesystem>
#include <vector>

#include "arrays.h"
#include "knead/error.h"
#include "knead/io.h"
#include "module.h"
#include "options.h"
#include "work.h"

namespace knead::python {
namespace {

// What an animation is made of.
struct Timing {
  FrameOptions frames;
  double fps = 24;
};

Timing timing(int count, const std::string& ease, int hold, double fps) {
  if (count < 1 || count > kMaxFrames || hold < 0 || hold > kMaxFrames) {
    throw InvalidInput(
        fmt::format("the number of frames must be from 1 to {0}, and hold from 0 to {0}; got {1} and {2}", kMaxFrames,
                    count, hold));
  }
  if (ease != "linear" && ease != "smooth") {
    throw InvalidInput(fmt::format("ease must be \"linear\" or \"smooth\", got \"{}\"", ease));
  }
  FrameOptions frames;
  frames.count = count;
  frames.ease = ease == "smooth" ? Ease::smooth : Ease::linear;
  frames.hold = hold;
  frames.same_faces = true;
  return {frames, fps};
}

py::object frames_of(const py::object& vertices, const Session& session, const py::object& faces,
                     const Accuracy& accuracy, const Timing& how, const py::object& callback) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  ReplayOptions options;
  options.motion = motion_options(accuracy);
  options.frames = how.frames;
  std::vector<std::vector<Vec3d>> frames;
  options.frames.deliver = [&](const ReplayFrame& frame) { frames.push_back(frame.shape.positions()); };
  if (!replay_watched(callback, mesh, session, options)) return py::none();
  const std::size_t count = frames.empty() ? 0 : frames.front().size();
  DoubleArray result({static_cast<py::ssize_t>(frames.size()), static_cast<py::ssize_t>(count), py::ssize_t{3}});
  double* to = result.mutable_data();
  for (const std::vector<Vec3d>& frame : frames) {
    if (count > 0) std::memcpy(to, frame.data(), count * sizeof(Vec3d));
    to += 3 * count;
  }
  return result;
}

// NOLINTNEXTLINE(readability-function-size): the arguments of Python's function
bool animate(const std::filesystem::path& path, const py::object& vertices, const Session& session,
             const py::object& faces, const Accuracy& accuracy, const Timing& how, const py::object& callback) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  const ShapeFile source = parse_shape(serialize_mesh("ply", mesh, {true, {}, {}}), "ply", path.string());
  ReplayOptions options;
  options.motion = motion_options(accuracy);
  options.frames = how.frames;
  const auto write = animation_writer(path, source, Replay(borrow(mesh), session, options).remeshes(),
                                      {frame_count(how.frames), how.fps});
  DeformedShape last;  // written once the callback can no longer say no
  options.frames.deliver = [&](const ReplayFrame& frame) {
    if (frame.index + 1 < frame_count(how.frames)) {
      write(frame);
    } else {
      last = frame.shape;
    }
  };
  if (!replay_watched(callback, mesh, session, options)) return false;
  write({frame_count(how.frames) - 1, last});
  return true;
}

void write_frames(const std::filesystem::path& path, const py::list& frames, const py::object& faces, double fps) {
  std::vector<Points> all;
  for (const py::handle frame : frames) {
    all.push_back(points_from(py::reinterpret_borrow<py::object>(frame), fmt::format("frames[{}]", all.size())));
    if (all.back().span().size() == all.front().span().size()) continue;
    throw InvalidInput(fmt::format("frames[{}] has {} vertices, the first one {}", all.size() - 1,
                                   all.back().span().size(), all.front().span().size()));
  }
  if (all.empty()) throw InvalidInput("frames is empty; give 1 or more");
  const ShapeFile source =
      parse_shape(serialize_mesh("ply", mesh_from(all.front(), faces), {true, {}, {}}), "ply", path.string());
  const py::gil_scoped_release released;
  AnimationFile file(path, source, {static_cast<int>(all.size()), fps});
  for (const Points& frame : all) file.add(frame.span());
  file.finish();
}

}  // namespace

void add_animation(py::module_& module) {
  py::class_<Timing>(module, "Timing").def(py::init(&timing));
  module.def("frames", &frames_of);
  module.def("animate", &animate);
  module.def("write_frames", &write_frames);
}

}  // namespace knead::python
