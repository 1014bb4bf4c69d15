// The bytes of the file that a shape was read from: those in memory, or those of the file, read again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "knead/io/shape_file.h"

namespace knead::io_detail {

// A regular file that stays open, so that its bytes can be read again, even if another file takes its name.
class SourceFile {
 public:
  // Throws IoError(read).
  explicit SourceFile(const std::filesystem::path& path);
  SourceFile(const SourceFile&) = delete;
  SourceFile& operator=(const SourceFile&) = delete;
  ~SourceFile();

  std::size_t size() const { return state_.size; }

  // Fills `to` with the bytes from `begin` on. Throws IoError(read), also if the file has changed since the
  // constructor.
  void read(std::size_t begin, std::span<char> to) const;

 private:
  struct State {
    std::size_t size = 0;
    std::int64_t changed_ns = 0;

    friend bool operator==(const State&, const State&) = default;
  };
  State state() const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  int file_ = -1;
  State state_;
};

class SourceBytes {
 public:
  // The source must outlive this.
  explicit SourceBytes(const ShapeFile& source) : source_(source) {}

  std::size_t size() const { return source_.file ? source_.file->size() : source_.bytes.size(); }

  // Returns these bytes, which are valid until the next call. Throws IoError(read).
  std::string_view piece(std::size_t begin, std::size_t count);
  std::string_view all() { return piece(0, size()); }

  // Passes these bytes on, in pieces of 1 MB.
  void copy(std::size_t begin, std::size_t end, const std::function<void(std::string_view)>& out);

 private:
  const ShapeFile& source_;
  std::string buffer_;
};

}  // namespace knead::io_detail
