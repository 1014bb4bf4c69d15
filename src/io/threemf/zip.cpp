// ZIP archives: the directory, its fields of 32 and 64 bits, and copies with other parts.
#include "io/threemf/zip.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>

#include "io/codec.h"
#include "io/text.h"
#include "knead/error.h"

namespace knead::detail::zip {

namespace {

constexpr std::uint32_t kLocal = 0x04034b50;
constexpr std::uint32_t kRecord = 0x02014b50;
constexpr std::uint32_t kEnd = 0x06054b50;
constexpr std::uint32_t kWideEnd = 0x06064b50;
constexpr std::uint32_t kWideLocator = 0x07064b50;
constexpr std::size_t kLocalSize = 30;
constexpr std::size_t kRecordSize = 46;
constexpr std::size_t kEndSize = 22;
constexpr std::size_t kWideEndSize = 56;
constexpr std::size_t kLocatorSize = 20;
constexpr std::size_t kMaxComment = 65535;
constexpr std::uint32_t kInExtra = 0xffffffff;  // the number stands in an extra field of 64 bits
constexpr std::uint16_t kWideExtra = 1;
constexpr std::uint16_t kEncrypted = 1;   // flags
constexpr std::uint16_t kSizesLater = 8;  // after the data
constexpr std::uint16_t kUtf8 = 0x800;
constexpr int kDeflate = 8;

template <class T>
T little(const char* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return std::endian::native == std::endian::little ? value : swap_bytes(value);
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  if (std::endian::native != std::endian::little) value = swap_bytes(value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <class T>
void append(std::string& bytes, T value) {
  bytes.resize(bytes.size() + sizeof value);
  put(bytes, bytes.size() - sizeof value, value);
}

std::uint32_t checksum_of(std::string_view bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> result{};
    for (std::uint32_t i = 0; i < result.size(); ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit) c = (c & 1) != 0 ? 0xedb88320U ^ (c >> 1) : c >> 1;
      result[i] = c;
    }
    return result;
  }();
  std::uint32_t sum = 0xffffffff;
  for (const char c : bytes) sum = table[(sum ^ static_cast<unsigned char>(c)) & 0xff] ^ (sum >> 8);
  return ~sum;
}

// Where the numbers of 64 bits of a header or record begin and end, whose names begin at `name`; empty without them.
std::pair<std::size_t, std::size_t> wide_numbers(std::string_view header, std::size_t name, std::size_t name_size,
                                                 std::size_t extra_size) {
  const std::size_t end = std::min(header.size(), name + name_size + extra_size);
  for (std::size_t at = name + name_size; at + 4 <= end;) {
    const std::size_t size = little<std::uint16_t>(header.data() + at + 2);
    const std::size_t next = at + 4 + size;
    if (next > end) break;
    if (little<std::uint16_t>(header.data() + at) == kWideExtra) return {at + 4, next};
    at = next;
  }
  return {0, 0};
}

// A number of 32 bits, or of 64 where the field says so. `wide` goes past it then.
std::optional<std::uint64_t> wide_number(std::string_view header, std::size_t field,
                                         std::pair<std::size_t, std::size_t>& wide) {
  const std::uint32_t number = little<std::uint32_t>(header.data() + field);
  if (number != kInExtra) return number;
  if (wide.first + 8 > wide.second) return std::nullopt;
  wide.first += 8;
  return little<std::uint64_t>(header.data() + wide.first - 8);
}

void put_wide(std::string& header, std::size_t field, std::pair<std::size_t, std::size_t>& wide, std::uint64_t number) {
  if (little<std::uint32_t>(header.data() + field) == kInExtra && wide.first + 8 <= wide.second) {
    put(header, wide.first, number);
    wide.first += 8;
  } else if (number < kInExtra) {
    put(header, field, static_cast<std::uint32_t>(number));
  } else {
    throw InvalidInput("the archive would grow beyond 4 GB; write another format");
  }
}

// A part as it is stored.
struct Packed {
  std::string bytes;
  std::size_t size = 0;
  std::uint32_t checksum = 0;
  std::uint16_t method = 0;
};

Packed packed(std::string_view content) {
  Packed result{{}, content.size(), checksum_of(content), kDeflate};
  std::optional<std::string> deflated = deflate_bytes(content);
  if (!deflated) result.method = 0;
  result.bytes = deflated ? *std::move(deflated) : std::string(content);
  return result;
}

// Puts what a part now is into its local header, or its record in the directory, whose method is at this byte.
void put_packed(std::string& header, std::size_t method, const Packed& part) {
  const std::uint16_t flags = little<std::uint16_t>(header.data() + method - 2);
  put(header, method - 2, static_cast<std::uint16_t>(flags & ~kSizesLater));
  put(header, method, part.method);
  put(header, method + 6, part.checksum);
}

}  // namespace

void Archive::fail(std::size_t at, const std::string& what) const {
  fail_at_byte(name_, at, what + "; the archive is cut short or damaged");
}

template <class T>
T Archive::number(std::size_t at) const {
  if (at > bytes_.size() || bytes_.size() - at < sizeof(T)) fail(bytes_.size(), "it ends within its directory");
  return little<T>(bytes_.data() + at);
}

Archive::Archive(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name), end_(find_end()) {
  read_directory();
}

Archive::End Archive::find_end() const {
  End end;
  const std::size_t last = bytes_.size() < kEndSize ? 0 : bytes_.size() - kEndSize;
  const std::size_t first = last > kMaxComment ? last - kMaxComment : 0;
  std::size_t at = last + 1;
  do {
    if (at == first) throw InvalidInput(Place{name_}, "is no ZIP archive, or is cut short; get the whole file");
    --at;
  } while (number<std::uint32_t>(at) != kEnd || bytes_.size() - at < kEndSize);
  end.record = at;
  end.count = number<std::uint16_t>(at + 10);
  end.directory = number<std::uint32_t>(at + 16);
  if (at < kLocatorSize || number<std::uint32_t>(at - kLocatorSize) != kWideLocator) return end;
  const auto wide = number<std::uint64_t>(at - kLocatorSize + 8);
  if (wide > at || number<std::uint32_t>(static_cast<std::size_t>(wide)) != kWideEnd ||
      at - wide < kWideEndSize + kLocatorSize) {
    fail(at, "its end record is not where it should be");
  }
  end.wide_record = static_cast<std::size_t>(wide);
  end.count = static_cast<std::size_t>(number<std::uint64_t>(end.wide_record + 32));
  end.directory = static_cast<std::size_t>(number<std::uint64_t>(end.wide_record + 48));
  return end;
}

void Archive::read_directory() {
  std::size_t at = end_.directory;
  for (std::size_t i = 0; i < end_.count; ++i) {
    if (at > end_.record || number<std::uint32_t>(at) != kRecord) fail(at, "no record of a part is there");
    Entry& entry = entries_.emplace_back();
    entry.record = at;
    entry.is_encrypted = (number<std::uint16_t>(at + 8) & kEncrypted) != 0;
    entry.method = number<std::uint16_t>(at + 10);
    entry.checksum = number<std::uint32_t>(at + 16);
    const std::size_t name_size = number<std::uint16_t>(at + 28);
    const std::size_t extra_size = number<std::uint16_t>(at + 30);
    const std::size_t size = kRecordSize + name_size + extra_size + number<std::uint16_t>(at + 32);
    if (end_.record < at || end_.record - at < size) fail(at, "the record of a part is too long");
    const std::string_view record = bytes_.substr(at, size);
    entry.name = record.substr(kRecordSize, name_size);
    auto wide = wide_numbers(record, kRecordSize, name_size, extra_size);
    const auto take = [&](std::size_t field) {
      const auto value = wide_number(record, field, wide);
      if (!value) fail(at, "a number of 64 bits is missing");
      return static_cast<std::size_t>(*value);
    };
    entry.size = take(24);
    entry.packed_size = take(20);
    entry.header = take(42);
    find_data(entry);
    at += size;
  }
  directory_end_ = at;
}

void Archive::find_data(Entry& entry) const {
  const std::size_t at = entry.header;
  if (at > end_.directory || number<std::uint32_t>(at) != kLocal) fail(at, "no part is there");
  entry.data = at + kLocalSize + number<std::uint16_t>(at + 26) + number<std::uint16_t>(at + 28);
  if (entry.data > end_.directory || end_.directory - entry.data < entry.packed_size) fail(at, "a part is too long");
}

const Entry* Archive::find(std::string_view part) const {
  if (part.starts_with('/')) part.remove_prefix(1);
  const std::string wanted = lower(part);
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return lower(entry.name) == wanted; });
  return found == entries_.end() ? nullptr : &*found;
}

std::string Archive::content(const Entry& entry) const {
  const std::string part = name_ + ": " + entry.name;
  if (entry.is_encrypted) throw InvalidInput(Place{part}, "is encrypted; save the file without a password");
  const std::string_view data = bytes_.substr(entry.data, entry.packed_size);
  if (entry.method != 0 && entry.method != kDeflate) {
    throw InvalidInput(Place{part}, "is compressed by a method other than deflate; save the file again");
  }
  std::string content = entry.method == 0 ? std::string(data) : inflate_bytes(data, part);
  if (content.size() != entry.size || checksum_of(content) != entry.checksum) {
    throw InvalidInput(Place{part}, "is not what its checksum says; the archive is damaged");
  }
  return content;
}

std::string Archive::with(const std::vector<std::pair<const Entry*, std::string>>& contents) const {
  std::vector<const Entry*> in_order;
  for (const Entry& entry : entries_) in_order.push_back(&entry);
  std::stable_sort(in_order.begin(), in_order.end(),
                   [](const Entry* a, const Entry* b) { return a->header < b->header; });
  std::vector<std::pair<std::size_t, std::optional<Packed>>> now(entries_.size());  // the place and content of each
  const std::size_t first = in_order.empty() ? end_.directory : in_order.front()->header;
  std::string result(bytes_.substr(0, first));
  for (std::size_t i = 0; i < in_order.size(); ++i) {
    const Entry& entry = *in_order[i];
    const std::size_t end = i + 1 < in_order.size() ? in_order[i + 1]->header : end_.directory;
    auto& [place, part] = now[static_cast<std::size_t>(&entry - entries_.data())];
    place = result.size();
    const auto other = std::find_if(contents.begin(), contents.end(), [&](const auto& c) { return c.first == &entry; });
    if (other == contents.end()) {
      result += bytes_.substr(entry.header, end - entry.header);
      continue;
    }
    part = packed(other->second);
    std::string header(bytes_.substr(entry.header, entry.data - entry.header));
    put_packed(header, 8, *part);
    auto wide = wide_numbers(header, kLocalSize, little<std::uint16_t>(header.data() + 26),
                             little<std::uint16_t>(header.data() + 28));
    put_wide(header, 22, wide, part->size);
    put_wide(header, 18, wide, part->bytes.size());
    result += header;
    result += part->bytes;
  }
  const std::size_t directory = result.size();
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    const std::size_t end = i + 1 < entries_.size() ? entries_[i + 1].record : directory_end_;
    std::string record(bytes_.substr(entry.record, end - entry.record));
    const auto& [place, part] = now[i];
    if (part) put_packed(record, 10, *part);
    auto wide = wide_numbers(record, kRecordSize, little<std::uint16_t>(record.data() + 28),
                             little<std::uint16_t>(record.data() + 30));
    put_wide(record, 24, wide, part ? part->size : entry.size);
    put_wide(record, 20, wide, part ? part->bytes.size() : entry.packed_size);
    put_wide(record, 42, wide, place);
    result += record;
  }
  const std::size_t by = result.size() - directory_end_;  // modulo 2^64: it may be negative
  result += bytes_.substr(directory_end_);
  std::pair<std::size_t, std::size_t> none{0, 0};
  if (end_.wide_record != std::string::npos) {
    put(result, end_.wide_record + by + 48, std::uint64_t{directory});
    put(result, end_.record + by - kLocatorSize + 8, std::uint64_t{end_.wide_record + by});
    if (number<std::uint32_t>(end_.record + 16) == kInExtra) return result;
  }
  put_wide(result, end_.record + by + 16, none, directory);
  return result;
}

std::string archive_of(const std::vector<std::pair<std::string, std::string>>& parts) {
  constexpr std::uint16_t version = 20;
  constexpr std::uint16_t date = 33;  // 1980-01-01: the same bytes every time
  std::string result;
  std::string directory;
  for (const auto& [name, content] : parts) {
    const Packed part = packed(content);
    if (result.size() + part.bytes.size() >= kInExtra || part.size >= kInExtra) {
      throw InvalidInput("the shape takes more than 4 GB as 3MF; write another format");
    }
    std::string fields;  // that the header and the record share
    for (const std::uint16_t field : {version, kUtf8, part.method, std::uint16_t{0}, date}) append(fields, field);
    for (const std::uint64_t field :
         {std::uint64_t{part.checksum}, std::uint64_t{part.bytes.size()}, std::uint64_t{part.size}}) {
      append(fields, static_cast<std::uint32_t>(field));
    }
    append(fields, static_cast<std::uint16_t>(name.size()));
    append(fields, std::uint16_t{0});
    append(directory, kRecord);
    append(directory, version);
    directory += fields;
    directory.append(10, '\0');
    append(directory, static_cast<std::uint32_t>(result.size()));
    directory += name;
    append(result, kLocal);
    result += fields + name + part.bytes;
  }
  const auto begin = static_cast<std::uint32_t>(result.size());
  result += directory;
  append(result, kEnd);
  append(result, std::uint32_t{0});
  for (int i = 0; i < 2; ++i) append(result, static_cast<std::uint16_t>(parts.size()));
  append(result, static_cast<std::uint32_t>(directory.size()));
  append(result, begin);
  append(result, std::uint16_t{0});
  return result;
}

}  // namespace knead::detail::zip
