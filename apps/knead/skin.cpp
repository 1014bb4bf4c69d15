// knead skin FILE.glb -o OUT: poses a character by its skeleton, by a flow that keeps the volume.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command.h"
#include "deform.h"
#include "inputs.h"
#include "json/json.h"
#include "knead/error.h"
#include "knead/fit.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/session.h"
#include "output.h"

namespace knead::command {
namespace {

struct SkinFlags {
  std::string file;
  std::string output;
  std::optional<std::string> pose;
  std::optional<double> time;
  std::optional<int> frames;
  std::optional<double> fps;
  std::optional<std::size_t> animation;
  std::optional<std::string> session;
  int threads = 0;  // 0: all
  CommonOptions common;
};

bool is_gltf(const std::string& path) {
  const std::string extension = lower_case(std::filesystem::path(path).extension().string());
  return extension == ".glb" || extension == ".gltf";
}

void check_options(const SkinFlags& flags) {
  if (flags.pose && flags.time) throw UsageError("give --pose or --time, not both");
  if (flags.frames && (flags.pose || flags.time))
    throw UsageError("--frames poses the animation; leave out --pose and --time");
  if (flags.frames && !is_gltf(flags.output) && !is_animation(flags.output) && !is_pattern(flags.output)) {
    throw UsageError(
        "--frames needs an --output of .glb, .gltf, .pc2, .mdd, .usda or .pvd, or a pattern such as F_%04d.ply");
  }
  if (flags.frames && flags.session) throw UsageError("--session holds one pose; leave out --frames");
  require_different(flags.file, flags.output);
  require_writable(flags.output);
  if (flags.session) {
    constexpr std::string_view extensions[] = {"knead"};
    require_extension(*flags.session, extensions);
    require_writable(*flags.session);
  }
}

Vec3d vector_of(const Json& json, const std::string& path, const std::string& bone) {
  std::vector<double> numbers;
  for (const Json& item : json.items()) {
    if (!item.is_number()) throw InvalidInput(Place{path}, fmt::format("\"{}\": \"axis\" must be three numbers", bone));
    numbers.push_back(item.number());
  }
  if (numbers.size() != 3 || !(std::hypot(numbers[0], numbers[1], numbers[2]) > 0)) {
    throw InvalidInput(Place{path}, fmt::format("\"{}\": \"axis\" must be three numbers, not all 0", bone));
  }
  return {numbers[0], numbers[1], numbers[2]};
}

// The pose that a file gives: {"bone": {"axis": [x, y, z], "angle_deg": 90}}, turns against the parent about the bone's
// origin; axes in the shape's coordinates at rest.
SkinPose read_pose(const std::string& path, const Skin& skin) {
  Json json;
  try {
    json = parse_json(read_text(path));
  } catch (const JsonError& error) {
    throw InvalidInput(Place{path}, error.what());
  }
  if (!json.is_object())
    throw InvalidInput(Place{path}, "a pose is an object: {\"bone\": {\"axis\": [1, 0, 0], \"angle_deg\": 90}}");
  std::vector<BoneTurn> turns;
  for (const auto& [bone, turn] : json.members()) {
    const auto found = std::find(skin.names.begin(), skin.names.end(), bone);
    if (found == skin.names.end()) throw InvalidInput(Place{path}, fmt::format("the file has no bone \"{}\"", bone));
    if (std::find(found + 1, skin.names.end(), bone) != skin.names.end()) {
      throw InvalidInput(Place{path}, fmt::format("two bones are called \"{}\"; give each a name of its own", bone));
    }
    const Json* const axis = turn.is_object() ? turn.find("axis") : nullptr;
    const Json* const angle = turn.is_object() ? turn.find("angle_deg") : nullptr;
    if (axis == nullptr || !axis->is_array() || angle == nullptr || !angle->is_number()) {
      throw InvalidInput(Place{path}, fmt::format("\"{}\" must be {{\"axis\": [x, y, z], \"angle_deg\": ...}}", bone));
    }
    turns.push_back(
        {static_cast<std::uint32_t>(found - skin.names.begin()), vector_of(*axis, path, bone), angle->number()});
  }
  return turned_pose(skin, turns);
}

std::string line_of(const char* name, const SkinMeasures& m) {
  const std::string volume = m.volume_error ? fmt::format("volume {:+.3f}%", 100 * *m.volume_error) : "no volume";
  return fmt::format("{:<8} {}, {} new, stretch {:.2f} to {:.2f}\n", name, volume, counted(m.crossings_new, "crossing"),
                     m.least_stretch, m.greatest_stretch);
}

std::string summary(const SkinFlags& flags, const SkinReport& report) {
  return fmt::format("{}: {} moved, {}\n", flags.output, counted(report.bones, "limb"),
                     counted(report.segments, "step")) +
         line_of("linear", report.linear) + line_of("dual", report.dual) + line_of("flow", report.flow) +
         fmt::format("bones    rigid vertices within {:.2g}% of the diagonal, 95% of them within {:.2g}%\n",
                     100 * report.part_distance, 100 * report.part_distance_95);
}

// Throws QualityError with the first complaint about results, given by their names. The results have been written.
void require_sound(const SkinFlags& flags, const std::vector<std::pair<std::string, std::string>>& results) {
  for (const auto& [name, complaint] : results) {
    if (!complaint.empty()) throw QualityError(fmt::format("{}: {}{}", flags.output, name, complaint));
  }
}

// Calls the work with options whose progress is shown, and which Ctrl-C cancels.
template <class Work>
auto watched(const SkinFlags& flags, SkinOptions options, const Work& work) {
  Progress progress;
  const CancelOnInterruption cancel(progress);
  options.progress = &progress;
  const ProgressBar bar(progress, 0, !flags.common.quiet);
  try {
    return work(options);
  } catch (const Cancelled&) {
    throw Interrupted{};
  }
}

std::vector<double> times_of(const SkinFlags& flags, const SkinFile& file) {
  std::vector<double> times;
  if (file.animations.empty() || flags.pose || flags.time) return times;
  const double fps = flags.fps.value_or(24);
  const int count = flags.frames ? *flags.frames : 1 + static_cast<int>(std::lround(file.duration * fps));
  for (int i = 0; i < count; ++i) times.push_back(count > 1 ? file.duration * i / (count - 1) : 0);
  return times;
}

// The source with a morph target for each corrective, whose weights follow its joints.
void write_correctives(const SkinFlags& flags, const ShapeFile& source, const SkinFile& file, const SkinPose& pose,
                       SkinOptions options) {
  const std::vector<double> times = times_of(flags, file);
  // The pose in which each joint turns most, of all moments.
  std::vector<SkinPose> poses{pose};
  for (const double time : times) poses.push_back(file.at(time));
  const SkinPose widest = widest_pose(file.skin, poses);
  const std::vector<Corrective> correctives = watched(
      flags, options, [&](const SkinOptions& own) { return make_correctives(source.mesh, file.skin, widest, own); });
  if (correctives.empty() && !flags.pose && !flags.time && times.empty())
    throw InvalidInput(Place{flags.file}, "no joint turns by 5 degrees; give --pose, --time, or an animation");
  if (correctives.empty() && !flags.common.quiet) {
    print_message("note: no joint that moves a vertex turns by 5 degrees; the file gets no corrective shapes");
  }
  MorphTargets targets;
  std::vector<std::pair<std::string, std::string>> results;
  for (const Corrective& corrective : correctives) {
    std::vector<Vec3d> shape = source.mesh.positions;
    for (std::size_t v = 0; v < shape.size(); ++v) shape[v] += corrective.offsets[v];
    targets.shapes.push_back(std::move(shape));
    std::string name = "knead";
    for (const std::uint32_t bone : corrective.bones) {
      name += " " + (file.skin.names[bone].empty() ? fmt::format("{}", bone) : file.skin.names[bone]);
    }
    results.emplace_back(fmt::format("shape \"{}\": ", name), corrective.problem);
    targets.names.push_back(std::move(name));
  }
  targets.weights = corrective_weights(correctives, file.skin, file.pose);
  for (const double time : times) {
    targets.times.push_back(time);
    const std::vector<double> weights = corrective_weights(correctives, file.skin, file.at(time));
    targets.keys.insert(targets.keys.end(), weights.begin(), weights.end());
  }
  targets.animation = flags.animation.value_or(0);
  write_file_atomically(flags.output, serialize_morphed(source, targets, format_of(flags.output)));
  if (!flags.common.quiet && !flags.common.json) {
    print(fmt::format("{}: {}, {}\n", flags.output, counted(correctives.size(), "corrective shape"),
                      times.empty() ? "no animation" : counted(times.size(), "key")));
  }
  if (flags.common.json) print(to_indented_text(Json{{"correctives", targets.names}, {"keys", times.size()}}));
  require_sound(flags, results);
}

// A posed shape for each moment of the animation.
void write_frames(const SkinFlags& flags, const ShapeFile& source, const SkinFile& file, SkinOptions options) {
  if (file.animations.empty()) throw InvalidInput(Place{flags.file}, "has no animation; leave out --frames");
  const std::vector<double> times = times_of(flags, file);
  std::optional<AnimationFile> animation;
  std::optional<FramePattern> pattern;
  if (is_pattern(flags.output)) {
    pattern = parse_frame_pattern(flags.output);
  } else {
    animation.emplace(flags.output, source, AnimationOptions{static_cast<int>(times.size()), flags.fps.value_or(24)});
  }
  std::vector<std::pair<std::string, std::string>> results;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const SkinResult result = watched(flags, options, [&](const SkinOptions& own) {
      return pose_skin(source.mesh, file.skin, file.at(times[i]), own, false);
    });
    results.emplace_back(fmt::format("frame {}: ", i), complaint_about(result.report));
    if (pattern) {
      write_shape(frame_path(*pattern, static_cast<int>(i)), source, result.positions);
    } else {
      animation->add(result.positions);
    }
  }
  if (animation) animation->finish();
  if (!flags.common.quiet) print(fmt::format("{}: {}\n", flags.output, counted(times.size(), "frame")));
  require_sound(flags, results);
}

void run_skin(const SkinFlags& flags) {
  check_options(flags);
  const ShapeFile source = read_shape(flags.file);
  SkinFile file;
  try {
    file = read_skin(source, flags.animation.value_or(0));
  } catch (const InvalidInput& error) {
    throw InvalidInput(Place{flags.file}, error.what());
  }
  if (!flags.common.quiet) print_notes(file.notes);
  if (flags.time && file.animations.empty())
    throw InvalidInput(Place{flags.file}, "has no animation; leave out --time");
  const SkinPose pose = flags.pose ? read_pose(*flags.pose, file.skin) : flags.time ? file.at(*flags.time) : file.pose;
  SkinOptions options;
  options.threads = flags.threads;
  if (is_gltf(flags.output)) return write_correctives(flags, source, file, pose, options);
  if (flags.frames) return write_frames(flags, source, file, options);
  require_shape_extension(flags.output);
  if (!flags.common.quiet) print_notes(conversion_losses(flags.output, source));
  SkinResult result =
      watched(flags, options, [&](const SkinOptions& own) { return pose_skin(source.mesh, file.skin, pose, own); });
  if (!flags.common.quiet) print_notes(result.report.notes);
  write_shape(flags.output, source, result.positions);
  if (flags.session) {
    Session session;
    session.note = "a pose of a skeleton";
    for (Stroke& stroke : result.strokes) session.strokes.push_back({std::move(stroke)});
    write_file_atomically(*flags.session, serialize_session(session));
  }
  if (flags.common.json) {
    print(to_json(result.report));
  } else if (!flags.common.quiet) {
    print(summary(flags, result.report));
  }
  require_sound(flags, {{"", complaint_about(result.report)}});
}

}  // namespace

Subcommand skin_command() {
  const auto flags = std::make_shared<SkinFlags>();
  std::vector<Option> described{
      {"FILE", &flags->file, "A .glb or .gltf file with a skeleton", "", OptionKind::required},
      {"-o,--output", &flags->output,
       "The posed shape; or .glb, .gltf: the same file with corrective shapes as morph targets, whose weights follow "
       "the joints",
       "FILE", OptionKind::required},
      {"--pose", &flags->pose,
       "A JSON file {\"bone\": {\"axis\": [x, y, z], \"angle_deg\": 90}}: turns from rest, in the shape's axes",
       "FILE"},
      {"--time", &flags->time, "The moment of the animation, in seconds (default: as the nodes stand)", "S",
       OptionKind::optional, is_not_negative, "give 0 or more seconds"},
      {"--frames", &flags->frames,
       "So many moments of the animation, evenly spaced; --output is an animation or a pattern", "N",
       OptionKind::optional, from_to(1, 100000), "give 1 to 100000"},
      {"--fps", &flags->fps, "Frames a second (default: 24)", "F", OptionKind::optional, is_above_zero,
       "give a number above 0, such as 24"},
      {"--animation", &flags->animation, "Which animation of the file, from 0 (default: 0)", "N"},
      {"--session", &flags->session, "Writes the strokes of the pose, too: they move any other shape along", "FILE"},
  };
  add_threads_option(described, flags->threads);
  add_common_options(described, flags->common);
  return {"skin", "Pose a character by its skeleton, or make corrective shapes for it", described,
          "  knead skin person.glb --time 1.5 -o posed.ply\n"
          "  knead skin person.glb --pose squat.json --session squat.knead -o squat.ply\n"
          "  knead skin person.glb -o person_corrected.glb\n"
          "  knead skin person.glb --frames 48 -o F_%03d.ply",
          [flags] { run_skin(*flags); }};
}

}  // namespace knead::command
