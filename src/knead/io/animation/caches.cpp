// PC2 and MDD: positions alone. Sources: Blender's manual, "Mesh Cache Modifier", and the layouts that its readers
// document (MOD_meshcache_pc2.c, MOD_meshcache_mdd.c).
#include <bit>
#include <memory>

#include "knead/io/animation/writers.h"
#include "knead/io/atomic_file.h"
#include "knead/io/binary_floats.h"
#include "knead/math/scalar.h"

namespace knead::io_detail {

namespace {

// Numbers of four bytes in one order.
class Bytes {
 public:
  explicit Bytes(std::endian order) : order_(order) {}

  void add(std::uint32_t value) {
    const std::uint32_t stored = order_ == std::endian::native ? value : swap_bytes(value);
    bytes_.append(reinterpret_cast<const char*>(&stored), sizeof stored);
  }
  void add(int value) { add(static_cast<std::uint32_t>(value)); }
  void add(float value) { add(bit_cast<std::uint32_t>(value)); }
  void add_text(std::string_view text) { bytes_ += text; }

  // Gives what was added, and begins again.
  std::string take() { return std::exchange(bytes_, {}); }

 private:
  std::endian order_;
  std::string bytes_;
};

AnimationFile::Writer cache_writer(const std::filesystem::path& path, const std::string& header, std::endian order) {
  const auto file = std::make_shared<AtomicFile>(path);
  file->write(header);
  AnimationFile::Writer writer;
  writer.add = [file, order, frame = std::string()](std::span<const Vec3d> positions) mutable {
    check_fits_floats(positions);
    frame.resize(positions.size() * 3 * sizeof(float));
    std::size_t at = 0;
    for (const Vec3d& p : positions) {
      for (std::size_t axis = 0; axis < 3; ++axis, at += sizeof(float)) put_float(frame, at, p[axis], order);
    }
    file->write(frame);
  };
  writer.finish = [file] { file->finish(); };
  return writer;
}

}  // namespace

AnimationFile::Writer pc2_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options) {
  using namespace std::string_view_literals;
  Bytes header(std::endian::little);
  header.add_text("POINTCACHE2\0"sv);
  header.add(1);  // version
  header.add(static_cast<std::uint32_t>(source.mesh.vertex_count()));
  header.add(0.0f);  // start
  header.add(1.0f);  // frames from one sample to the next
  header.add(options.frames);
  return cache_writer(path, header.take(), std::endian::little);
}

AnimationFile::Writer mdd_writer(const std::filesystem::path& path, const ShapeFile& source,
                                 const AnimationOptions& options) {
  Bytes header(std::endian::big);
  header.add(options.frames);
  header.add(static_cast<std::uint32_t>(source.mesh.vertex_count()));
  for (int k = 0; k < options.frames; ++k) header.add(static_cast<float>(k / options.fps));
  return cache_writer(path, header.take(), std::endian::big);
}

}  // namespace knead::io_detail
