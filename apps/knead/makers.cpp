// knead bend, twist, stretch, taper and wrap: one stroke of the tool "curve" for a whole solid, from a few numbers;
// knead print and knead lattice: one of the tools "print" and "lattice". They take the options of `knead deform`, too.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command.h"
#include "deform.h"
#include "inputs.h"
#include "json/json.h"
#include "knead/error.h"
#include "knead/session.h"
#include "knead/stroke.h"

namespace knead::command {

namespace {

constexpr double kChord = 1e-4;  // of the shape's size: the error of faces that are refined

// The words of the five commands; what is not given is placed by the shape's box.
struct MakerOptions {
  DeformOptions deform;
  std::optional<double> angle;
  std::optional<double> around;
  std::optional<double> twist;
  std::optional<double> longer_by;
  std::optional<double> thicker_by;
  std::optional<double> thickness;
  std::optional<std::string> axis;
  std::optional<std::string> along;  // a table of points
  std::optional<std::string> from;
  bool fits = false;
  bool keeps_faces = false;
  bool tapers = false;
  std::string keep;
  std::string fixed;
};

std::vector<Vec3d> path_points(const std::string& path) {
  const Table table = read_table(path);
  std::vector<Vec3d> points;
  for (const Table::Row& row : table.rows) {
    Vec3d& point = points.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto number = axis < row.fields.size() ? number_in(row.fields[axis], table.separator) : std::nullopt;
      if (!number) throw InvalidInput(table.place(row), "each line has the three coordinates of a point");
      point[axis] = *number;
    }
  }
  return points;
}

// "x" is 1,0,0; "-z" is 0,0,-1; else the numbers.
std::string axis_numbers(std::string text) {
  const std::string sign = text.starts_with('-') ? "-1" : "1";
  const std::string name = text.substr(sign.size() - 1);
  if (name == "x") return sign + ",0,0";
  if (name == "y") return "0," + sign + ",0";
  if (name == "z") return "0,0," + sign;
  return text;
}

// What a quoted key of a stroke is called on the command line; other words stay.
std::string option_of(const std::string& quoted, const MakerOptions& options) {
  const std::string key = quoted.substr(1, quoted.size() - 2);
  const bool is_twist = options.twist && !options.angle && !options.along;
  if (key == "angle_deg" || (key == "twist_deg" && is_twist)) return "--angle";
  if (key == "twist_deg") return "--twist";
  if (key == "longer_by") return "--by";
  if (key == "thicker_by") return "--thicker";
  if (key == "around") return "--radius";
  if (key == "to") return "--along";
  if (key == "point") return "--at";
  if (key == "displacements") return "--file";
  constexpr std::array<std::string_view, 16> kSame{"mode",      "axis", "from",  "fixed",  "keep",  "thickness",
                                                   "text",      "font", "file",  "height", "depth", "up",
                                                   "direction", "bump", "outer", "flip"};
  return std::find(kSame.begin(), kSame.end(), key) == kSame.end() ? quoted : "--" + key;
}

// A message about the stroke, in the words that were typed.
std::string in_options(std::string message, const MakerOptions& options) {
  constexpr std::string_view kStroke = "--stroke: ";
  if (!message.starts_with(kStroke)) return message;
  message.erase(0, kStroke.size());
  for (std::size_t at = message.find('"'); at != std::string::npos; at = message.find('"', at)) {
    const std::size_t end = message.find('"', at + 1);
    if (end == std::string::npos) break;
    const std::string option = option_of(message.substr(at, end + 1 - at), options);
    message.replace(at, end + 1 - at, option);
    at += option.size();
  }
  return message;
}

void run_stroke(MakerOptions& options, const std::string& stroke) {
  options.deform.strokes = {stroke};
  options.deform.is_brief = true;
  options.deform.check = true;
  options.deform.remesh.remesh = !options.keeps_faces;
  if (!options.keeps_faces && !options.deform.remesh.max_chord) options.deform.remesh.max_chord = kChord;
  try {
    run_deform(options.deform);
  } catch (const QualityLimit& error) {
    throw QualityLimit(in_options(error.what(), options));
  } catch (const QualityError& error) {
    throw QualityError(in_options(error.what(), options));
  } catch (const InvalidInput& error) {
    throw InvalidInput(in_options(error.what(), options));
  }
}

void run_maker(MakerOptions& options) {
  std::string words = "curve";
  const auto add = [&](std::string_view key, const auto& value) { words += fmt::format(" {}={}", key, value); };
  if (options.angle) add("angle_deg", *options.angle);
  if (options.around) add("around", *options.around);
  if (options.twist) add("twist_deg", *options.twist);
  if (options.longer_by) add("longer_by", *options.longer_by);
  if (options.thicker_by) add("thicker_by", *options.thicker_by);
  if (options.thickness) add("thickness", *options.thickness);
  if (options.tapers) add("taper", true);
  if (options.axis) add("axis", axis_numbers(*options.axis));
  if (options.from) add("from", *options.from);
  if (options.fits) add("length", "fit");
  if (!options.keep.empty()) add("keep", options.keep);
  if (!options.fixed.empty()) add("fixed", options.fixed);
  if (options.along) {
    std::string to;
    for (const Vec3d& p : path_points(*options.along)) to += fmt::format("{},{},{};", p.x, p.y, p.z);
    add("to", to);
  }
  run_stroke(options, words);
}

// The options of one command, and what all have in common.
std::vector<Option> with_deform(MakerOptions& options, std::vector<Option> own) {
  own.insert(own.begin(), {"SHAPE", &options.deform.shape, "A solid, such as an STL, 3MF, OBJ, PLY or OFF file", "",
                           OptionKind::required});
  own.push_back({"--keep-faces", &options.keeps_faces, "Do not refine faces that are too coarse for the motion"});
  for (Option& option : describe(options.deform)) {
    const bool is_ours = option.name == "SHAPE" || option.name == "SESSION" || option.name == "--stroke" ||
                         option.name == "--remesh" || option.name == "--check" || option.name == "--table" ||
                         option.name == "--set" || option.name == "--also" || option.name == "--stream" ||
                         option.name == "--piece-mb";
    if (!is_ours) own.push_back(std::move(option));
  }
  return own;
}

std::vector<Option> with_common(MakerOptions& options, std::vector<Option> own) {
  own.push_back({"--from", &options.from,
                 "The line through the shape, as two or more points x,y,z;x,y,z (default: the longest axis of its box)",
                 "POINTS"});
  const std::vector<std::string> places{"start", "middle", "end"};
  const std::size_t fixed = options.fixed.empty() ? 1 : 0;
  own.push_back({"--fixed",
                 WordTarget{places, fixed, [&options, places](std::size_t word) { options.fixed = places[word]; }},
                 "The place of the line that stays (default: " + places[fixed] + ")", "start|middle|end"});
  return with_deform(options, std::move(own));
}

Option keep_option(MakerOptions& options, const std::vector<std::string>& words, std::string help) {
  return {"--keep", WordTarget{words, 0, [&options, words](std::size_t word) { options.keep = words[word]; }},
          std::move(help) + " (default: volume)", fmt::format("{}", fmt::join(words, "|"))};
}

Option keep_option(MakerOptions& options) {
  return keep_option(options, {"volume", "thickness"},
                     "What stays: the volume of every piece, or the distances from the line, so that reliefs keep "
                     "their height");
}

Option axis_option(MakerOptions& options, std::string help) {
  return {"--axis", &options.axis, std::move(help), "x|y|z|X,Y,Z"};
}

// The words of `knead print`.
struct PrintOptions {
  MakerOptions maker;
  std::optional<std::string> text;
  std::optional<std::string> font;
  std::optional<std::string> file;
  std::optional<std::string> at;
  std::optional<std::string> up;
  std::optional<std::string> direction;
  std::optional<double> height;
  std::optional<double> depth;
  std::optional<double> bump;
  std::optional<double> outer;
  bool flips = false;
};

// The vector of "1,2,3", or of the name of an axis.
Json vector_of(const std::string& name, const std::string& text) {
  const std::string numbers = axis_numbers(text);
  std::vector<double> vector;
  for (std::size_t begin = 0; begin <= numbers.size();) {
    const std::size_t end = std::min(numbers.find(',', begin), numbers.size());
    const auto number = number_in(numbers.substr(begin, end - begin), ',');
    if (!number) break;
    vector.push_back(*number);
    begin = end + 1;
  }
  if (vector.size() != 3) throw UsageError(fmt::format("{} takes three numbers x,y,z, got {}", name, text));
  return vector;
}

void run_print(PrintOptions& options) {
  if (options.text.has_value() == options.file.has_value()) throw UsageError("give --text TEXT or --file FILE");
  Json stroke{{"tool", "print"}, {"height", *options.height}, {"depth", *options.depth}};
  const auto set = [&](const char* key, const auto& value) {
    if (value) stroke.set(key, *value);
  };
  set("text", options.text);
  set("font", options.font);
  set("file", options.file);
  set("bump", options.bump);
  set("outer", options.outer);
  if (options.at) stroke.set("point", vector_of("--at", *options.at));
  if (options.up) stroke.set("up", vector_of("--up", *options.up));
  if (options.direction) stroke.set("direction", vector_of("--direction", *options.direction));
  if (options.flips) stroke.set("flip", true);
  run_stroke(options.maker, to_text(stroke));
}

}  // namespace

Subcommand lattice_command() {
  struct LatticeOptions {
    MakerOptions maker;
    std::string file;
    std::string mode = "volume";
  };
  const auto options = std::make_shared<LatticeOptions>();
  const std::vector<std::string> modes{"volume", "rigid", "spline"};
  std::vector<Option> own{
      {"--file", &options->file, "Parameters of PyGeM's free-form deformation (.prm)", "FILE", OptionKind::required},
      {"--mode", WordTarget{{"volume", "rigid", "spline"}, 0, [=](std::size_t i) { options->mode = modes[i]; }},
       "Keep the volume; strain the body as little as possible, too; or the plain map (default: volume)",
       "volume|rigid|spline"}};
  return {"lattice", "Move what is in a box by the box's control points; volume stays",
          with_deform(options->maker, std::move(own)),
          "  knead lattice wing.stl --file wing.prm -o moved.stl\n"
          "  knead lattice wing.stl --file wing.prm --mode spline -o moved.stl",
          [options] {
            const Json stroke{{"tool", "lattice"}, {"file", options->file}, {"mode", options->mode}};
            run_stroke(options->maker, to_text(stroke));
          }};
}

Subcommand bend_command() {
  const auto options = std::make_shared<MakerOptions>();
  std::vector<Option> own{
      {"--angle", &options->angle,
       "Bend into an arc of this angle in degrees, counterclockwise seen from the tip of the axis", "DEGREES"},
      {"--along", &options->along, "Or bend along the curve through the points of this table: x,y,z a line", "FILE"},
      axis_option(*options, "Of the arc (default: across the shape, so that it bends where it is thinnest)"),
      {"--twist", &options->twist, "Also twist the end against the start, in degrees", "DEGREES"},
      {"--fit", &options->fits, "With --along: stretch the shape to the ends of the curve"},
      keep_option(*options)};
  return {"bend", "Bend a whole solid into an arc or along a curve; volume or thickness stays",
          with_common(*options, std::move(own)),
          "  knead bend bar.stl --angle 270 -o ring.stl\n"
          "  knead bend plate.stl --angle -90 --axis y --fixed start -o angle.stl\n"
          "  knead bend hose.stl --along path.csv -o bent_hose.stl",
          [options] {
            if (options->angle.has_value() == options->along.has_value()) {
              throw UsageError("give --angle DEGREES or --along FILE");
            }
            run_maker(*options);
          }};
}

Subcommand twist_command() {
  const auto options = std::make_shared<MakerOptions>();
  std::vector<Option> own{{"--angle", &options->twist,
                           "Degrees by which the end turns against the start, counterclockwise seen from the end",
                           "DEGREES", OptionKind::required}};
  return {"twist", "Twist a whole solid about its length; volume stays", with_common(*options, std::move(own)),
          "  knead twist bar.stl --angle 180 -o twisted.stl\n"
          "  knead twist vase.stl --angle 60 --from '0,0,0;0,0,120' --fixed start -o turned.stl",
          [options] { run_maker(*options); }};
}

Option thicker_option(MakerOptions& options) {
  return {"--thicker", &options.thicker_by, "How much thicker it becomes across the line, below 0: thinner", "LENGTH"};
}

Option thickness_option(MakerOptions& options) {
  return {"--thickness", &options.thickness, "How thick it becomes: the least width across the line", "LENGTH"};
}

Option only_axis_option(MakerOptions& options) {
  return axis_option(options, "The only direction in which it becomes thicker (default: all across the line)");
}

// One of the lengths that a command takes.
void require_one_length(const MakerOptions& options, const char* usage) {
  const int given = static_cast<int>(options.longer_by.has_value()) + static_cast<int>(options.thicker_by.has_value()) +
                    static_cast<int>(options.thickness.has_value());
  if (given != 1) throw UsageError(usage);
}

Subcommand stretch_command() {
  const auto options = std::make_shared<MakerOptions>();
  std::vector<Option> own{
      {"--by", &options->longer_by, "How much longer the shape becomes, in its unit; below 0: shorter", "LENGTH"},
      thicker_option(*options),
      thickness_option(*options),
      only_axis_option(*options),
      keep_option(*options, {"volume", "thickness", "length"},
                  "What stays: the volume of every piece; with --by the thickness, with --thicker the length")};
  return {"stretch", "Make a whole solid, or a part, longer, shorter, thicker or thinner by a length",
          with_common(*options, std::move(own)),
          "  knead stretch handle.stl --by 10 --keep thickness -o longer.stl\n"
          "  knead stretch arm.stl --by 10 --from '20,0,0;60,0,0' --fixed start --keep thickness -o arm10.stl\n"
          "  knead stretch rod.stl --thicker 2 --from '20,0,0;60,0,0' --keep length -o grip.stl",
          [options] {
            require_one_length(*options, "give --by LENGTH, --thicker LENGTH or --thickness LENGTH");
            run_maker(*options);
          }};
}

Subcommand taper_command() {
  const auto options = std::make_shared<MakerOptions>();
  options->tapers = true;
  options->fixed = "start";
  std::vector<Option> own{
      thicker_option(*options), thickness_option(*options), only_axis_option(*options),
      keep_option(*options, {"volume", "length"}, "What stays: the volume of every piece, or lengths along the line")};
  return {"taper", "Make the end of a solid thicker or thinner, gradually from one point to another",
          with_common(*options, std::move(own)),
          "  knead taper bar.stl --thickness 6 -o pin.stl\n"
          "  knead taper bar.stl --thickness 6 --from '80,0,0;100,0,0' --keep length -o tip.stl\n"
          "  knead taper leg.stl --thicker 4 --from '0,0,20;0,0,5' --axis x -o foot.stl",
          [options] {
            require_one_length(*options, "give --thicker LENGTH or --thickness LENGTH");
            run_maker(*options);
          }};
}

Subcommand wrap_command() {
  const auto options = std::make_shared<MakerOptions>();
  std::vector<Option> own{
      {"--radius", &options->around, "Of the cylinder that the shape touches from outside, in the shape's unit", "R",
       OptionKind::required},
      axis_option(*options, "Of the cylinder (default: across the shape's length and thickness)"),
      keep_option(*options)};
  return {"wrap", "Wrap a flat solid, such as text, round a cylinder; volume or thickness stays",
          with_common(*options, std::move(own)),
          "  knead wrap text.stl --radius 30 -o band.stl\n"
          "  knead wrap relief.3mf --radius 40 --keep thickness -o cup.3mf\n"
          "  knead wrap text.stl --radius 30 --axis z --session band.knead -o band.stl",
          [options] { run_maker(*options); }};
}

Subcommand print_command() {
  const auto options = std::make_shared<PrintOptions>();
  std::vector<Option> own{
      {"--text", &options->text, "Press this line of text in, letter by letter along the surface", "TEXT"},
      {"--font", &options->font, "A font's file or name, such as 'DejaVu Serif' (default: a bold one without serifs)",
       "FONT"},
      {"--file", &options->file,
       "Or press in a picture (PNG, JPEG, PGM; white goes to the full depth), or the lowest face of a mesh", "FILE"},
      {"--height", &options->height, "Of a capital letter, a picture or a mesh, in the shape's unit", "H",
       OptionKind::required},
      {"--depth", &options->depth, "How deep; below 0 the print is raised", "D", OptionKind::required},
      {"--at", &options->at, "The middle of the print, on the surface or near it (default: the middle of the top)",
       "X,Y,Z"},
      {"--up", &options->up, "The print's upward direction (default: z, or y on faces that look along z)",
       "x|y|z|X,Y,Z"},
      {"--direction", &options->direction,
       "Press all of it in this direction (default: each letter against the surface)", "x|y|z|X,Y,Z"},
      {"--bump", &options->bump,
       "Radius over which edges are soft (default: half of the thinnest stroke, at most H/12)", "A"},
      {"--outer", &options->outer, "How far the volume goes (default: twice the height)", "R"},
      {"--flip", &options->flips, "Mirror it from left to right, as for a mould"}};
  return {"print", "Press text, a picture or the face of a mesh into a surface, or raise it; volume stays",
          with_deform(options->maker, std::move(own)),
          "  knead print plate.stl --text 'No. 7' --height 8 --depth 0.6 -o named.stl\n"
          "  knead print cup.3mf --text KNEAD --at 40,0,30 --height 10 --depth -1 -o cup.3mf\n"
          "  knead print tag.stl --file logo.png --height 20 --depth 0.5 -o tag_logo.stl",
          [options] { run_print(*options); }};
}

}  // namespace knead::command
