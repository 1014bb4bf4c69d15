// PCD files with 'DATA binary_compressed': the sizes of the compressed and the whole numbers (two uint32), then the
// numbers of one field after those of the other, compressed by LZF (Marc Lehmann's liblzf). A byte c below 32 is
// followed by c + 1 bytes as they are. Any other repeats (c >> 5) + 2 earlier bytes; 9 plus the next byte of them if
// c >> 5 is 7. One more byte b gives how far back they begin: ((c & 31) << 8 | b) + 1.
#include <algorithm>
#include <bit>
#include <cstring>

#include "knead/io/cloud/pcd.h"
#include "knead/math/error.h"

namespace knead::io_detail::pcd {
namespace {

std::uint32_t uint32_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  return value;
}

// Returns `size` bytes, or fewer if the input is damaged.
std::string expand(std::string_view in, std::size_t size) {
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&]() -> std::size_t { return at < in.size() ? static_cast<unsigned char>(in[at++]) : 0; };
  while (at < in.size()) {
    const std::size_t c = next();
    std::size_t length = c + 1;
    if (c < 32) {
      if (length > in.size() - at || length > size - out.size()) break;
      out.append(in.substr(at, length));
      at += length;
      continue;
    }
    length = (c >> 5) == 7 ? next() + 9 : (c >> 5) + 2;
    const std::size_t back = ((c & 31) << 8 | next()) + 1;
    if (back > out.size() || length > size - out.size()) break;
    for (std::size_t i = 0; i < length; ++i) out += out[out.size() - back];
  }
  return out;
}

}  // namespace

bool uncompress(std::string& bytes, const std::string& name) {
  const Layout layout = parse_header(bytes, name);
  if (layout.compressed == 0) return false;
  constexpr std::size_t kMostGrowth = 88;  // three bytes repeat 264 at most
  const std::string_view body = std::string_view(bytes).substr(layout.body_begin);
  const std::size_t packed = body.size() < 8 ? 0 : std::min<std::size_t>(uint32_at(body, 0), body.size() - 8);
  const std::size_t whole = layout.points * layout.row_size;
  const bool is_sized = packed > 0 && whole / kMostGrowth <= packed && uint32_at(body, 4) == whole;
  const std::string columns = is_sized ? expand(body.substr(8, packed), whole) : "";
  if (whole == 0 || columns.size() != whole) {
    throw InvalidInput(Place{name}, "the compressed points are damaged or cut short");
  }
  std::string rows(whole, '\0');
  const char* from = columns.data();
  for (const Field& field : layout.fields) {
    const std::size_t size = field.count * size_of(field.type);
    for (std::size_t i = 0; i < layout.points; ++i, from += size) {
      std::memcpy(rows.data() + i * layout.row_size + field.offset, from, size);
    }
  }
  bytes.resize(layout.body_begin);
  bytes.replace(layout.compressed, std::string_view("binary_compressed").size(), "binary");
  bytes += rows;
  return true;
}

}  // namespace knead::io_detail::pcd
