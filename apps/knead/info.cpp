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
  bool no_topology = false;
  CommonOptions common;
};

template <class Info>
void show(const Info& info, const CommonOptions& common) {
  if (common.json) {
    print(to_json(info));
  } else if (!common.quiet) {
    print(table_of(info) + table_of_notes(info.notes));
  }
}

void run_info(const InfoOptions& options) {
  check_streams({options.shape}, options.format);
  if (options.no_topology) return show(read_summary_or_stream(options.shape, options.format), options.common);
  ShapeFile shape = read_shape_or_stream(options.shape, options.format);
  std::string().swap(shape.bytes);  // frees them: only the mesh is looked at
  show(describe(shape), options.common);
}

}  // namespace

Subcommand info_command() {
  const auto options = std::make_shared<InfoOptions>();
  std::vector<Option> described{
      {"SHAPE", &options->shape, "A mesh or point cloud, such as a PLY, OBJ, STL, OFF, glTF or XYZ file", "",
       OptionKind::required},
      {"--no-topology", &options->no_topology,
       "Only counts, box and attributes: no look at which faces are neighbours, nor volume and area. Of a large binary "
       "PLY file this takes a quarter of the time and the memory"},
  };
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"info", "Show what is in a file: counts, whether it is closed and manifold, volume, area, box", described,
          "  knead info hand.ply\n"
          "  knead info hand.ply --json\n"
          "  knead info scan.ply --no-topology",

          [options] { run_info(*options); }};
}

}  // namespace knead::command
