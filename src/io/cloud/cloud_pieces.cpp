// Point clouds that are read and written in pieces (CloudPieces).
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "io/cloud/cloud.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/ply/ply.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/io.h"

namespace knead {

namespace {

constexpr std::size_t kLargestHead = std::size_t{1} << 20;

// Returns whether a line of an XYZ file is a row: it has three numbers or more.
bool is_row(std::string_view line) {
  constexpr std::string_view gaps = " \t\r,;\"";
  std::size_t numbers = 0;
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t begin = line.find_first_not_of(gaps, i);
    if (begin == std::string_view::npos) break;
    i = std::min(line.find_first_of(gaps, begin), line.size());
    const std::string_view word = line.substr(begin, i - begin);
    if (numbers == 0 && (word[0] == '#' || word[0] == '%' || word.starts_with("//"))) return false;
    double value = 0;
    numbers += detail::parse_real(word, value) == detail::ParseResult::ok ? 1 : 0;
  }
  return numbers >= 3;
}

bool has_row(std::string_view lines) {
  for (std::size_t i = 0; i < lines.size();) {
    const std::size_t line_end = std::min(lines.find_first_of("\r\n", i), lines.size());
    if (is_row(lines.substr(i, line_end - i))) return true;
    i = line_end + 1;
  }
  return false;
}

}  // namespace

struct CloudPieces::Reader {
  std::filesystem::path path;
  std::size_t piece_bytes = 0;
  std::string format;
  std::ifstream file;
  std::uintmax_t size = 0;
  std::string head;
  std::string names;  // the line that names the columns of an XYZ file, if any; each piece is read with it
  std::string tail;
  std::size_t stride = 0;       // of a PLY file
  std::size_t count_begin = 0;  // of the number of vertices in its head
  std::size_t count_end = 0;
  std::uintmax_t end = 0;       // of the rows
  std::uintmax_t position = 0;  // where the next piece begins

  [[noreturn]] void refuse(const std::string& why) const {
    throw InvalidInput(Place{path.string()}, why + ", so it cannot be read in pieces");
  }

  std::string read(std::uintmax_t begin, std::size_t count) {
    std::string bytes(count, '\0');
    file.clear();
    file.seekg(static_cast<std::streamoff>(begin));
    file.read(bytes.data(), static_cast<std::streamsize>(count));
    if (static_cast<std::size_t>(file.gcount()) != count) {
      throw IoError(IoError::Operation::read, path.string(), std::string("could not be read: ") + std::strerror(errno));
    }
    return bytes;
  }

  void open_ply() {
    const std::string begin = read(0, static_cast<std::size_t>(std::min<std::uintmax_t>(size, kLargestHead)));
    const detail::ply::Layout layout = detail::ply::parse_header(begin, path.string());
    if (layout.encoding == detail::ply::Encoding::ascii) refuse("its numbers are written as text");
    const detail::ply::Element& vertex = layout.elements[layout.vertex_element];
    for (const detail::ply::Element& element : layout.elements) {
      if (&element != &vertex && element.count > 0) refuse(fmt::format("it has rows of '{}'", element.name));
    }
    for (const detail::ply::Property& property : vertex.properties) {
      if (property.is_list) refuse("its vertices have lists");
      stride += detail::size_of(property.type);
    }
    head = begin.substr(0, layout.body_begin);
    count_begin = vertex.count_begin;
    count_end = vertex.count_end;
    const std::uintmax_t room = size - head.size();
    if (stride == 0 || vertex.count > room / stride) refuse("it is cut short");
    end = head.size() + std::uintmax_t{vertex.count} * stride;
    if (end != size) refuse("bytes follow its last row");
  }

  void open_xyz() {
    const std::string begin = read(0, static_cast<std::size_t>(std::min<std::uintmax_t>(size, kLargestHead)));
    if (const auto table = detail::xyz::find_table(begin, path.string())) {
      if (table->names_begin == table->names_end) refuse("it is a molecule or has its numbers in quotes");
      names = begin.substr(table->names_begin, table->names_end - table->names_begin);
    }
    std::size_t line = 0;
    while (line < begin.size()) {
      const std::size_t line_end = std::min(begin.find_first_of("\r\n", line), begin.size());
      if (is_row(std::string_view(begin).substr(line, line_end - line))) break;
      line = std::min(begin.find_first_not_of("\r\n", line_end), begin.size());
    }
    if (line == begin.size()) refuse("no row of three numbers is near its beginning");
    head = begin.substr(0, line);
    find_tail();
  }

  // Finds the last row, so that no piece is without rows.
  void find_tail() {
    const auto count = static_cast<std::size_t>(std::min<std::uintmax_t>(size - head.size(), kLargestHead));
    const std::string last = read(size - count, count);
    std::size_t line_end = last.size();
    while (true) {
      const std::size_t text_end = last.find_last_not_of("\r\n", line_end == 0 ? 0 : line_end - 1);
      if (line_end == 0 || text_end == std::string::npos) refuse("no row of three numbers is near its end");
      const std::size_t before = last.find_last_of("\r\n", text_end);
      const std::size_t begin = before == std::string::npos ? 0 : before + 1;
      if (is_row(std::string_view(last).substr(begin, text_end + 1 - begin))) {
        tail = last.substr(text_end + 1);
        end = size - tail.size();
        return;
      }
      line_end = begin;
    }
  }

  // The bytes of the next piece of an XYZ file: whole lines, at least one of them a row.
  std::string next_lines() {
    std::string bytes;
    while (true) {
      const std::uintmax_t left = end - position - bytes.size();
      bytes += read(position + bytes.size(), static_cast<std::size_t>(std::min<std::uintmax_t>(left, piece_bytes)));
      if (position + bytes.size() == end) return bytes;
      // A carriage return at the very end may be half of a line end.
      const std::size_t last = bytes.find_last_of("\r\n", bytes.size() - 2);
      if (bytes.size() < 2 || last == std::string::npos || !has_row(std::string_view(bytes).substr(0, last))) continue;
      const bool is_half = bytes[last] == '\r' && bytes[last + 1] == '\n';
      bytes.resize(last + (is_half ? 2 : 1));
      return bytes;
    }
  }

  // The size of the head that a piece has of its own: that of the file with another count, or none.
  std::size_t head_size(std::string_view piece) const {
    if (format == "xyz") return names.size();
    const std::size_t after = piece.find_first_not_of("0123456789", count_begin);
    return after + (head.size() - count_end);
  }

  std::string next_rows() {
    const std::uintmax_t rows =
        std::min<std::uintmax_t>((end - position) / stride, std::max<std::size_t>(1, piece_bytes / stride));
    std::string bytes = head.substr(0, count_begin) + std::to_string(rows) + head.substr(count_end);
    bytes += read(position, static_cast<std::size_t>(rows) * stride);
    return bytes;
  }
};

CloudPieces::CloudPieces(const std::filesystem::path& path, std::size_t piece_bytes)
    : reader_(std::make_unique<Reader>()) {
  Reader& reader = *reader_;
  reader.path = path;
  reader.piece_bytes = std::max<std::size_t>(piece_bytes, 1);
  reader.format = format_of(path);
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)) {
    reader.refuse("it is no plain file but a pipe, a folder or a device");
  }
  reader.size = std::filesystem::file_size(path, error);
  reader.file.open(path, std::ios::binary);
  if (error || !reader.file) {
    throw IoError(IoError::Operation::read, path.string(), std::string("could not be opened: ") + std::strerror(errno));
  }
  if (detail::is_gzip_name(path)) reader.refuse("it is compressed");
  if (reader.format == "ply") {
    reader.open_ply();
  } else if (reader.format == "xyz") {
    reader.open_xyz();
  } else {
    reader.refuse("it is neither binary PLY nor points in text");
  }
  rewind();
}

CloudPieces::~CloudPieces() = default;
CloudPieces::CloudPieces(CloudPieces&&) noexcept = default;
CloudPieces& CloudPieces::operator=(CloudPieces&&) noexcept = default;

std::optional<ShapeFile> CloudPieces::next() {
  Reader& reader = *reader_;
  if (reader.position >= reader.end) return std::nullopt;
  std::string bytes = reader.format == "ply" ? reader.next_rows() : reader.names + reader.next_lines();
  std::string name = reader.path.string();
  if (reader.position > reader.head.size()) name += fmt::format(" (from byte {} on)", reader.position);
  reader.position += bytes.size() - reader.head_size(bytes);
  return parse_shape(std::move(bytes), reader.format, name);
}

void CloudPieces::rewind() { reader_->position = reader_->head.size(); }

std::uintmax_t CloudPieces::position() const { return reader_->position; }
std::uintmax_t CloudPieces::size() const { return reader_->size; }
const std::string& CloudPieces::head() const { return reader_->head; }
const std::string& CloudPieces::tail() const { return reader_->tail; }

std::string CloudPieces::rows(const ShapeFile& piece, std::string bytes) const {
  if (reader_->format == "ply" && bytes.size() != piece.bytes.size()) {
    reader_->refuse("its coordinates would be written with another type");
  }
  return bytes.erase(0, reader_->head_size(bytes));
}

}  // namespace knead
