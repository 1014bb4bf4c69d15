// The table of the formats, and the bytes of a file that a shape was read from.
#include "io/codec.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "knead/error.h"
#include "math/system.h"

namespace knead::detail {
namespace {

constexpr std::array<const Codec*, 18> kCodecs = {&ply_codec,     &obj_codec,    &glb_codec, &gltf_codec, &stl_codec,
                                                  &threemf_codec, &off_codec,    &xyz_codec, &pcd_codec,  &ptx_codec,
                                                  &splat_codec,   &spz_codec,    &su2_codec, &gmsh_codec, &foam_codec,
                                                  &nastran_codec, &abaqus_codec, &unv_codec};

bool has_extension(const Codec& codec, std::string_view extension) {
  return codec.name == extension ||
         std::find(codec.extensions.begin(), codec.extensions.end(), extension) != codec.extensions.end();
}

}  // namespace

std::span<const Codec* const> codecs() { return kCodecs; }

const Codec* find_codec(std::string_view name) {
  const auto* const found =
      std::find_if(kCodecs.begin(), kCodecs.end(), [&](const Codec* codec) { return codec->name == name; });
  return found == kCodecs.end() ? nullptr : *found;
}

const Codec& codec_named(std::string_view name, const std::string& file) {
  if (const Codec* const codec = find_codec(name)) return *codec;
  std::string supported;
  for (const Codec* codec : kCodecs) supported += (supported.empty() ? "" : ", ") + std::string(codec->name);
  throw InvalidInput(Place{file}, "format '" + std::string(name) + "' is not supported; use one of " + supported);
}

const Codec& codec_with_extension(std::string_view extension, const std::string& file) {
  std::string supported;
  for (const Codec* codec : kCodecs) {
    if (has_extension(*codec, extension)) return *codec;
    supported += (supported.empty() ? "." : ", .") + std::string(codec->name);
    for (const std::string_view other : codec->extensions) supported += ", ." + std::string(other);
  }
  if (extension == "knead") throw InvalidInput(Place{file}, "is a session, not a shape; name the shape it is for");
  const std::string what =
      extension.empty() ? "its name has no extension" : "format '" + std::string(extension) + "' is not supported";
  throw InvalidInput(Place{file}, what + "; use one of " + supported);
}

SourceFile::SourceFile(const std::filesystem::path& path)
    : path_(path.string()), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (file_ < 0) fail("cannot be read (" + std::generic_category().message(errno) + ")");
  state_ = state();
}

SourceFile::~SourceFile() {
  if (file_ >= 0) ::close(file_);
}

void SourceFile::fail(const std::string& what) const {
  throw IoError(IoError::Operation::read, path_, what + "; check the file and run this again");
}

SourceFile::State SourceFile::state() const {
  struct stat now {};
  if (::fstat(file_, &now) != 0) fail("cannot be read (" + std::generic_category().message(errno) + ")");
  return {static_cast<std::size_t>(now.st_size), changed_ns(file_, now)};
}

void SourceFile::read(std::size_t begin, std::span<char> to) const {
  while (!to.empty()) {
    const ssize_t count = ::pread(file_, to.data(), to.size(), static_cast<off_t>(begin));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("cannot be read (" + std::generic_category().message(errno) + ")");
    if (count == 0) break;  // it has become shorter
    begin += static_cast<std::size_t>(count);
    to = to.subspan(static_cast<std::size_t>(count));
  }
  if (!to.empty() || state() != state_) fail("has changed while it was in use");
}

std::string_view SourceBytes::piece(std::size_t begin, std::size_t count) {
  if (!source_.file) return std::string_view(source_.bytes).substr(begin, count);
  reserve_large(buffer_, count);
  buffer_.resize(count);
  source_.file->read(begin, buffer_);
  return buffer_;
}

void SourceBytes::copy(std::size_t begin, std::size_t end, const std::function<void(std::string_view)>& out) {
  constexpr std::size_t most = std::size_t{1} << 20;
  for (; begin < end; begin += std::min(most, end - begin)) out(piece(begin, std::min(most, end - begin)));
}

}  // namespace knead::detail
