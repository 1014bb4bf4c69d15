// knead info SHAPE: shows what is in a file.
#include <memory>
#include <string>

#include "command.h"
#include "output.h"
#include "shape_info.h"
#include "streams.h"

namespace knead::command {
namespace {

struct InfoOptions {
  std::string shape;
  StreamFormat format;
  CommonOptions common;
};

void run_info(const InfoOptions& options) {
  check_streams({options.shape}, options.format);
  ShapeFile shape = read_shape_or_stream(options.shape, options.format);
  std::string().swap(shape.bytes);  // frees them: only the mesh is looked at
  const ShapeInfo info = describe(shape);
  if (options.common.json) {
    print(to_json(info));
  } else if (!options.common.quiet) {
    print(table_of(info) + table_of_notes(info));
  }
}

}  // namespace

Subcommand info_command() {
  const auto options = std::make_shared<InfoOptions>();
  std::vector<Option> described{
      {"SHAPE", &options->shape, "A mesh or point cloud, such as a PLY, OBJ, STL, OFF, glTF or XYZ file", "",
       OptionKind::required},
  };
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"info", "Show what is in a file: counts, whether it is closed and manifold, volume, area, box", described,
          "  knead info hand.ply\n"
          "  knead info hand.ply --json",
          [options] { run_info(*options); }};
}

}  // namespace knead::command
