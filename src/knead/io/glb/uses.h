// Which parts of a GLB file use which accessors, views and meshes.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "knead/io/glb/accessor.h"

namespace knead::io_detail::glb {

// One place that names an accessor.
struct AccessorUse {
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  std::size_t mesh = kNone;  // kNone: skins, animations, instancing
  std::size_t primitive = kNone;
  std::string key;  // of the attribute; empty for indices and morph targets
};

// Returns true for an extension that does not change the geometry, or that the reader understands.
bool is_understood(const std::string& extension);

// Returns the uses of each accessor, by accessor.
std::map<std::size_t, std::vector<AccessorUse>> find_uses(const Document& document);

// Returns for each mesh of the file that has vertices the blocks of each node that places it.
std::map<std::size_t, std::vector<std::vector<std::size_t>>> blocks_by_node(const Layout& layout);

// Returns how many nodes place each mesh, in all scenes.
std::map<std::size_t, std::size_t> count_placements(const Document& document);

// Whether the bytes of an accessor's elements are read through another accessor, a sparse accessor's indices or values,
// or an image too; also true where that would take long to tell.
class ByteReaders {
 public:
  explicit ByteReaders(const Document& document);

  bool others_read(std::size_t accessor) const;

 private:
  struct Range {
    std::size_t accessor;  // kNone: not one's elements
    std::size_t begin;
    std::size_t end;
    std::size_t stride;
    std::size_t size;
  };

  static bool overlap(const Range& a, const Range& b);
  void add_accessors(const Document& document);
  void add_images(const Document& document);

  std::vector<Range> ranges_;              // by where they begin
  std::vector<std::size_t> furthest_end_;  // of the ranges up to each
  std::map<std::size_t, std::size_t> of_accessor_;
};

}  // namespace knead::io_detail::glb
