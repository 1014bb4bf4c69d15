#include "knead/io/source_bytes.h"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "knead/math/error.h"
#include "knead/math/large_pages.h"
#include "knead/math/system.h"

namespace knead::io_detail {

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

}  // namespace knead::io_detail
