// Writing an OBJ file back: its bytes with some numbers replaced.
#include <charconv>
#include <optional>

#include "knead/io/decimals.h"
#include "knead/io/layout.h"
#include "knead/io/obj/layout.h"
#include "knead/io/obj/normals.h"
#include "knead/io/obj/obj.h"
#include "knead/io/text.h"
#include "knead/io/unplaced.h"
#include "knead/math/large_pages.h"
#include "knead/mesh/normals.h"

namespace knead::io_detail::obj {
namespace {

// Walks through the statements as the reader did.
class Rewriter {
 public:
  Rewriter(const ShapeFile& source, std::span<const Vec3d> positions, NormalLines normals, std::optional<int> decimals)
      : bytes_(without_end_zeros(source.bytes)),
        rest_(std::string_view(source.bytes).substr(bytes_.size())),
        old_positions_(source.mesh.positions),
        old_normals_(layout_of<Layout>(source).normals),
        positions_(positions),
        normals_(std::move(normals)),
        decimals_(decimals),
        number_(normals_.lines.size(), 0) {
    if (const auto& unplaced = layout_of<Layout>(source).unplaced; !unplaced.empty()) {
      old_positions_ = rows_before_ = by_row(old_positions_, unplaced);
      positions_ = rows_after_ = by_row(positions, unplaced);
    }
    reserve_large(result_, bytes_.size() + bytes_.size() / 4 + 64);
    const std::size_t end = end_of_line(bytes_, 0);
    line_end_ = bytes_.substr(end, bytes_.substr(end, 2) == "\r\n" ? 2 : 1);
    if (line_end_.empty()) line_end_ = "\n";
  }

  std::string run() {
    for (std::size_t position = first_byte(bytes_); position < bytes_.size();) {
      const std::size_t line = position;
      position = skip_blanks(bytes_, position);
      const std::size_t end = word_end(bytes_, position);
      const std::string_view keyword = bytes_.substr(position, end - position);
      position = end;
      if (keyword == "v") {
        position = replace(position, old_positions_[vertex_], positions_[vertex_], decimals_);
        ++vertex_;
      } else if (keyword == "vn") {
        position =
            replace(position, old_normals_[normal_], normals_.lines[normal_].normal, direction_decimals(decimals_));
        number_[normal_++] = ++written_;
      } else if (keyword == "f" && !normals_.corner_line.empty()) {
        position = rewrite_face(line, position);
      }
      position = end_of_line(bytes_, position) + 1;
    }
    copy_until(bytes_.size());
    result_ += rest_;
    return std::move(result_);
  }

 private:
  void copy_until(std::size_t end) {
    result_.append(bytes_, copied_, end - copied_);
    copied_ = end;
  }

  // Three numbers after `position`; a component that stays the same keeps its bytes. Returns the byte after them.
  std::size_t replace(std::size_t position, const Vec3d& from, const Vec3d& to, std::optional<int> decimals) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position = skip_blanks(bytes_, position);
      const std::size_t end = word_end(bytes_, position);
      if (from[axis] != to[axis] && spell(from[axis], to[axis], decimals)) {
        copy_until(position);
        result_ += number_text_;
        copied_ = end;
      }
      position = end;
    }
    return position;
  }

  // Sets number_text_; false where the rounded number is the old one.
  bool spell(double from, double to, std::optional<int> decimals) {
    number_text_.clear();
    append_decimals(number_text_, to, decimals);
    if (decimals) parse_real(number_text_, to);
    return from != to;
  }

  // The third number of a corner v/vt/vn or v//vn.
  struct Reference {
    std::size_t begin = 0;
    std::size_t end = 0;
    std::int64_t index = 0;
    std::uint32_t line = 0;  // of normals_, that it is to mean
  };

  // Returns the byte after the corners.
  std::size_t rewrite_face(std::size_t line, std::size_t position) {
    references_.clear();
    const std::size_t corners = read_references(position);
    if (corners >= 3) {  // else it was left out of the mesh
      for (Reference& reference : references_) reference.line = normals_.corner_line[corner_ + reference.line];
      corner_ += corners;
    } else {
      for (Reference& reference : references_) reference.line = old_line(reference.index);
    }
    for (const Reference& reference : references_) add_line(reference.line, line);
    for (const Reference& reference : references_) renumber(reference);
    return position;
  }

  // Sets `line` to the number of the corner within its face. Returns how many corners there are.
  std::size_t read_references(std::size_t& position) {
    for (std::uint32_t corner = 0;; ++corner) {
      const std::size_t begin = skip_blanks(bytes_, position);
      const std::size_t end = begin < bytes_.size() && bytes_[begin] == '#' ? begin : word_end(bytes_, begin);
      position = end;
      if (begin == end) return corner;
      const std::string_view token = bytes_.substr(begin, end - begin);
      const std::size_t slash = token.find('/', token.find('/') + 1);
      if (token.find('/') == std::string_view::npos || slash == std::string_view::npos) continue;
      Reference reference{begin + slash + 1, end, 0, corner};
      std::from_chars(bytes_.data() + reference.begin, bytes_.data() + end, reference.index);
      if (reference.index != 0) references_.push_back(reference);
    }
  }

  std::uint32_t old_line(std::int64_t index) const {
    return static_cast<std::uint32_t>(index > 0 ? index - 1 : static_cast<std::int64_t>(normal_) + index);
  }

  // Before the face's line, a line of `normals_` that the file does not have.
  void add_line(std::uint32_t line, std::size_t position) {
    if (line < old_normals_.size() || number_[line] != 0) return;
    copy_until(position);
    result_ += "vn";
    for (std::size_t axis = 0; axis < 3; ++axis) {
      result_ += ' ';
      append_decimals(result_, normals_.lines[line].normal[axis], direction_decimals(decimals_));
    }
    result_ += line_end_;
    number_[line] = ++written_;
  }

  void renumber(const Reference& reference) {
    const std::int64_t number = number_[reference.line];
    const std::int64_t index = reference.index > 0 ? number : number - written_ - 1;
    if (index == reference.index) return;
    copy_until(reference.begin);
    result_ += std::to_string(index);
    copied_ = reference.end;
  }

  std::string_view bytes_;
  std::string_view rest_;           // zero bytes
  std::vector<Vec3d> rows_before_;  // the positions of all lines `v`, if some vertices have no place
  std::vector<Vec3d> rows_after_;
  std::span<const Vec3d> old_positions_;
  std::span<const Vec3d> old_normals_;
  std::span<const Vec3d> positions_;
  NormalLines normals_;
  std::optional<int> decimals_;
  std::string number_text_;
  std::vector<std::int64_t> number_;  // of each line of normals_ in the new file, from 1; 0: not written so far
  std::string_view line_end_;
  std::string result_;
  std::size_t copied_ = 0;
  std::size_t vertex_ = 0;  // how many the file has given so far
  std::size_t normal_ = 0;
  std::size_t corner_ = 0;    // of the mesh
  std::int64_t written_ = 0;  // lines vn
  std::vector<Reference> references_;
};

}  // namespace

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options) {
  const Layout& layout = layout_of<Layout>(source);
  NormalLines plan = plan_normals(layout, normals);
  if (layout.normals_ahead) {
    plan.lines.resize(layout.normals.size());
    plan.corner_line.clear();
  }
  return Rewriter(source, positions, std::move(plan), options.decimals).run();
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  const std::string_view bytes = without_end_zeros(source.bytes);
  for (std::size_t position = first_byte(bytes); position < bytes.size();) {
    position = skip_blanks(bytes, position);
    std::size_t end = word_end(bytes, position);
    const bool is_vertex = bytes.substr(position, end - position) == "v";
    for (std::size_t axis = 0; is_vertex && axis < 3; ++axis) {
      position = skip_blanks(bytes, end);
      end = word_end(bytes, position);
      visit(bytes.substr(position, end - position));
    }
    position = end_of_line(bytes, end) + 1;
  }
}

}  // namespace knead::io_detail::obj
