// Compressed files, and compressed parts of archives.
#include <optional>
#include <string>
#include <string_view>

#include "io/codec.h"
#include "knead/error.h"

#if defined(KNEAD_HAS_ZLIB)

#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>

namespace knead::detail {
namespace {

constexpr int kGzipWindow = 15 + 16;  // the largest window, and a header after RFC 1952
constexpr int kBareWindow = -15;      // the same without a header

// Calls step() for the pieces of `bytes`, with room for what it makes, and appends that. step(flush) returns zlib's
// result; at Z_STREAM_END more() says whether to go on.
template <class Step, class More>
int run_through(z_stream& stream, std::string_view bytes, std::string& out, const Step& step, const More& more) {
  std::array<char, 1 << 16> room{};
  // zlib does not write to its input.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // NOLINT
  std::size_t left = bytes.size();
  int result = Z_OK;
  do {
    constexpr std::size_t most = std::numeric_limits<uInt>::max();
    const auto piece = static_cast<uInt>(std::min(left + stream.avail_in, most));
    left -= piece - stream.avail_in;
    stream.avail_in = piece;
    stream.next_out = reinterpret_cast<Bytef*>(room.data());
    stream.avail_out = static_cast<uInt>(room.size());
    result = step(left == 0 ? Z_FINISH : Z_NO_FLUSH);
    out.append(room.data(), room.size() - stream.avail_out);
    if (result == Z_STREAM_END && left + stream.avail_in > 0 && more()) result = Z_OK;
    if (result == Z_BUF_ERROR && stream.avail_out == 0) result = Z_OK;
  } while (result == Z_OK && (stream.avail_out == 0 || stream.avail_in > 0 || left > 0));
  return result;
}

// A stream of zlib's that is ended at the end of its scope.
struct Stream {
  z_stream state{};
  int (*end)(z_stream*);

  explicit Stream(int (*ended_by)(z_stream*)) : end(ended_by) {}
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() { end(&state); }
};

// `many`: go on with the next stream after the end of one.
std::string inflated(std::string_view bytes, int window, bool many, const std::string& name, const char* damaged) {
  Stream stream(inflateEnd);
  std::string result;
  if (inflateInit2(&stream.state, window) != Z_OK) throw std::bad_alloc();
  const int end = run_through(
      stream.state, bytes, result, [&](int) { return inflate(&stream.state, Z_NO_FLUSH); },
      [&] { return many && inflateReset(&stream.state) == Z_OK; });
  if (end == Z_MEM_ERROR) throw std::bad_alloc();
  if (end != Z_STREAM_END) throw InvalidInput(Place{name}, damaged);
  return result;
}

std::string deflated(std::string_view bytes, int window) {
  Stream stream(deflateEnd);
  std::string result;
  constexpr int memory_level = 8;  // zlib's own
  if (deflateInit2(&stream.state, Z_DEFAULT_COMPRESSION, Z_DEFLATED, window, memory_level, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw std::bad_alloc();
  }
  run_through(
      stream.state, bytes, result, [&](int flush) { return deflate(&stream.state, flush); }, [] { return false; });
  return result;
}

}  // namespace

std::string unzipped(std::string_view bytes, const std::string& name) {
  return inflated(bytes, kGzipWindow, true, name, "is no sound gzip file; it is cut short or damaged");
}
std::string zipped(std::string_view bytes, const std::string&) { return deflated(bytes, kGzipWindow); }

std::string inflate_bytes(std::string_view bytes, const std::string& name) {
  return inflated(bytes, kBareWindow, false, name, "cannot be unpacked; it is cut short or damaged");
}
std::optional<std::string> deflate_bytes(std::string_view bytes) { return deflated(bytes, kBareWindow); }

}  // namespace knead::detail

#else

namespace knead::detail {

[[noreturn]] static void refuse_gzip(const std::string& name) {
  throw InvalidInput(Place{name},
                     "is compressed, and this Knead was built without zlib; use gunzip and name the file "
                     "without .gz");
}

std::string unzipped(std::string_view, const std::string& name) { refuse_gzip(name); }
std::string zipped(std::string_view, const std::string& name) { refuse_gzip(name); }
std::string inflate_bytes(std::string_view, const std::string& name) {
  throw InvalidInput(Place{name}, "is compressed, and this Knead was built without zlib; pack it without compression");
}
std::optional<std::string> deflate_bytes(std::string_view) { return std::nullopt; }

}  // namespace knead::detail

#endif

namespace knead::detail {

bool is_gzip_name(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == kGzip || extension == ".GZ";
}

}  // namespace knead::detail
