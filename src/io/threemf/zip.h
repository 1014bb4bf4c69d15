// ZIP archives (PKWARE APPNOTE 6.3) in memory: reads parts, and replaces some while all other bytes stay.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace knead::detail::zip {

// A part of an archive, by its record in the directory.
struct Entry {
  std::string name;
  std::size_t record = 0;  // the byte of its record
  std::size_t header = 0;  // of its local header
  std::size_t data = 0;
  std::size_t packed_size = 0;
  std::size_t size = 0;
  std::uint32_t checksum = 0;
  int method = 0;  // 0: stored, 8: deflate
  bool is_encrypted = false;
};

class Archive {
 public:
  // Reads the directory. The bytes and the name must outlive this. Throws InvalidInput for damaged bytes, or no
  // archive.
  Archive(std::string_view bytes, const std::string& name);

  const std::vector<Entry>& entries() const { return entries_; }

  // Returns the part of that name, in any letter case and with or without a slash in front; null if there is none.
  const Entry* find(std::string_view part) const;

  // Returns the contents of a part. Throws InvalidInput for a damaged or encrypted part, or an unknown compression.
  std::string content(const Entry& entry) const;

  // Returns the archive with other contents of some parts.
  std::string with(const std::vector<std::pair<const Entry*, std::string>>& contents) const;

 private:
  // The records at the end of the archive that lead to the directory.
  struct End {
    std::size_t record = 0;                       // the end record
    std::size_t wide_record = std::string::npos;  // the one of 64 bits
    std::size_t directory = 0;
    std::size_t count = 0;
  };

  template <class T>
  T number(std::size_t at) const;
  [[noreturn]] void fail(std::size_t at, const std::string& what) const;
  End find_end() const;
  void read_directory();
  void find_data(Entry& entry) const;

  std::string_view bytes_;
  const std::string& name_;
  End end_;
  std::vector<Entry> entries_;  // in the order of the directory
  std::size_t directory_end_ = 0;
};

// Returns a new archive of parts, each with its name, compressed where Knead was built with zlib.
std::string archive_of(const std::vector<std::pair<std::string, std::string>>& parts);

}  // namespace knead::detail::zip
