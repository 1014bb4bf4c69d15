// All frames of a replay in one file.
#include <memory>
#include <optional>
#include <utility>

#include "knead/session/replay.h"

namespace knead {

namespace {

struct Output {
  const ShapeFile& source;
  std::filesystem::path path;
  AnimationOptions options;
  ShapeFile remeshed{};  // the first frame, if the frames have faces of their own
  std::optional<AnimationFile> file{};

  void add(const ReplayFrame& frame) {
    if (!file) {
      remeshed = parse_shape(serialize_mesh("ply", frame.shape.to_mesh(), {true, {}, {}}), "ply", path.string());
      file.emplace(path, remeshed, options);
    }
    file->add(frame.shape.positions());
    if (frame.index + 1 == options.frames) file->finish();
  }
};

}  // namespace

std::function<void(const ReplayFrame&)> animation_writer(const std::filesystem::path& path, const ShapeFile& source,
                                                         bool is_remeshed, const AnimationOptions& options) {
  const auto output = std::make_shared<Output>(Output{source, path, options});
  if (!is_remeshed) output->file.emplace(path, source, options);
  return [output](const ReplayFrame& frame) { output->add(frame); };
}

}  // namespace knead
