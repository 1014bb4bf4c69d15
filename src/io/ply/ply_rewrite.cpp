// Writing a PLY file back: the source's bytes with some numbers replaced.
#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <optional>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/ply/ply.h"
#include "io/text.h"
#include "knead/error.h"
#include "math/system.h"

namespace knead::detail::ply {
namespace {

// What a vertex property means to the rewriter.
enum class Role { none, position, normal, value };

struct NewColumn {
  Role role = Role::none;
  std::size_t axis = 0;
  const std::vector<double>* before = nullptr;  // of a value: for each vertex
  const std::vector<double>* after = nullptr;   // for each changed vertex
  StoredType type = StoredType::float32;        // that it is written with
  bool widened = false;                         // another type than in the source
};

class Rewriter {
 public:
  Rewriter(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
           const WriteOptions& options)
      : source_(source),
        layout_(layout_of<Layout>(source)),
        edits_(source.layout->edits),
        element_(layout_.elements[layout_.vertex_element]),
        ascii_(layout_.encoding == Encoding::ascii),
        swapped_(is_swapped(layout_.encoding)),
        source_mesh_(source.mesh),
        old_normals_(source.mesh.find_attribute("normal")),
        old_positions_(source.mesh.positions),
        positions_(positions),
        normals_(normals),
        decimals_(options.decimals),
        changed_(options.changed.begin(), options.changed.end()) {
    if (!layout_.unplaced.empty()) take_rows();
    for (const Property& property : element_.properties) {
      columns_.push_back(column_for(property, options.double_coordinates));
      find_values(property, options.attributes, columns_.back());
    }
    for (const Property& property : element_.properties) {
      if (property.is_list) {
        stride_ = 0;
        break;
      }
      stride_ += size_of(property.type);
    }
  }

  // Calls visit with the words of a text.
  void visit_coordinates(const WordVisitor& visit) {
    bytes_ = source_.all();
    std::size_t position = layout_.vertex_begin;
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      for (std::size_t p = 0; p < columns_.size(); ++p) {
        if (element_.properties[p].is_list) {
          position = skip_list(position, element_.properties[p]);
          continue;
        }
        const std::size_t begin = token_begin(position);
        position = token_end(bytes_, begin);
        if (columns_[p].role != Role::position) continue;
        visit(bytes_.substr(begin, position - begin));
      }
      position = row_end(position);
    }
  }

  // Returns whether the rows are of one length and one for each vertex.
  bool has_rows_of_one_length() const { return !ascii_ && stride_ > 0 && layout_.unplaced.empty(); }

  // Returns whether patch() cannot write the edits.
  bool widens_edited() const { return widened_ && !edits_.vertices.empty(); }

  // Returns the file with copies of these vertices after the last one.
  std::string with_copies(std::span<const std::uint32_t> vertices) {
    bytes_ = source_.all();
    std::vector<std::size_t> begins{layout_.vertex_begin};
    for (std::size_t i = 0; i < element_.count; ++i) begins.push_back(row_begin(begins.back()));
    copy_until(element_.count_begin);
    result_ += std::to_string(element_.count + vertices.size());
    copied_ = element_.count_end;
    copy_until(begins.back());
    const std::string_view line_end = bytes_.substr(0, layout_.body_begin).ends_with("\r\n") ? "\r\n" : "\n";
    for (const std::uint32_t vertex : vertices) {
      const std::size_t row = rows_.empty() ? vertex : rows_[vertex];
      std::size_t begin = begins[row];
      if (ascii_) {
        begin = token_begin(begin);
        result_ += line_end;
      }
      result_.append(bytes_, begin, begins[row + 1] - begin);
    }
    copy_until(bytes_.size());
    return std::move(result_);
  }

  // Passes the bytes to `out`. Throws InvalidInput before the first of them only.
  void run(const ByteSink& out) {
    if (!widened_ && !ascii_ && stride_ > 0) return patch(out);
    bytes_ = source_.all();
    reserve_large(result_, bytes_.size() + (widened_ ? positions_.size() * 12 + 64 : 64));
    for (std::size_t p = 0; p < columns_.size(); ++p) {
      if (columns_[p].widened) rewrite_type(element_.properties[p]);
    }
    std::size_t position = layout_.vertex_begin;
    for (std::size_t i = 0; i < positions_.size(); ++i) position = rewrite_row(i, position);
    copy_until(bytes_.size());
    out(result_);
  }

 private:
  NewColumn column_for(const Property& property, bool as_doubles) {
    NewColumn column;
    column.type = property.type;
    if (property.is_list) return column;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (property.name == std::string_view("xyz").substr(axis, 1)) column.role = Role::position;
      if (!normals_.empty() && property.name == std::array{"nx", "ny", "nz"}[axis]) column.role = Role::normal;
      if (column.role == Role::none) continue;
      column.axis = axis;
      break;
    }
    const bool narrow = is_integer(property.type) || (as_doubles && property.type == StoredType::float32);
    column.widened = column.role == Role::position && narrow;
    if (column.widened) column.type = StoredType::float64;
    widened_ = widened_ || column.widened;
    return column;
  }

  // A property that another attribute replaces gets its values.
  void find_values(const Property& property, std::span<const Attribute> attributes, NewColumn& column) {
    const auto is_it = [&](const Attribute& attribute) { return attribute.name == property.name; };
    const auto after = std::find_if(attributes.begin(), attributes.end(), is_it);
    if (property.is_list || column.role != Role::none || after == attributes.end()) return;
    column.before = &source_mesh_.find_attribute(property.name)->values;
    column.after = &after->values;
    column.role = Role::value;
  }

  // From now on, values are those of the file's rows; rows without a place have the same before and after.
  void take_rows() {
    const auto expand = [&](std::span<const Vec3d> values, std::vector<Vec3d>& rows) {
      rows = by_row(values, layout_.unplaced);
      return std::span<const Vec3d>(rows);
    };
    old_positions_ = expand(old_positions_, expanded_[0]);
    positions_ = expand(positions_, expanded_[1]);
    if (!normals_.empty()) normals_ = expand(normals_, expanded_[2]);
    next_unplaced_ = layout_.unplaced.begin();
    for (std::uint32_t row = 0; row < element_.count; ++row) {
      if (!std::binary_search(layout_.unplaced.begin(), layout_.unplaced.end(), row)) rows_.push_back(row);
    }
    for (std::uint32_t& row : changed_) row = rows_[row];
  }

  Vec3d old_normal(std::size_t i) const {
    const auto& unplaced = layout_.unplaced;
    const auto next = std::lower_bound(unplaced.begin(), unplaced.end(), i);
    if (next != unplaced.end() && *next == i) return {};
    const double* n = old_normals_->values.data() + 3 * (i - static_cast<std::size_t>(next - unplaced.begin()));
    return {n[0], n[1], n[2]};
  }

  bool is_changed(std::size_t i) const {
    return std::binary_search(changed_.begin(), changed_.end(), i) || !(positions_[i] == old_positions_[i]) ||
           (!normals_.empty() && !(normals_[i] == old_normal(i)));
  }

  void copy_until(std::size_t end) {
    result_.append(bytes_, copied_, end - copied_);
    copied_ = end;
  }

  void rewrite_type(const Property& property) {
    copy_until(property.type_begin);
    const bool sized = std::isdigit(static_cast<unsigned char>(bytes_[property.type_end - 1])) != 0;
    result_ += sized ? "float64" : "double";
    copied_ = property.type_end;
  }

  // Binary rows of equal length whose numbers keep their type: the source's bytes with numbers replaced in place.
  void patch(const ByteSink& out) {
    check_ranges();
    if (edits_.copied.empty()) {
      source_.copy(0, layout_.vertex_begin, out);
    } else {
      source_.copy(0, element_.count_begin, out);
      out(std::to_string(positions_.size()));
      source_.copy(element_.count_end, layout_.vertex_begin, out);
    }
    const std::size_t most = std::max<std::size_t>(1, (std::size_t{1} << 18) / stride_);  // that the cache holds
    const std::size_t of_file = positions_.size() - edits_.copied.size();
    for (std::size_t first = 0; first < of_file; first += most) {
      const Rows rows{first, std::min(first + most, of_file)};
      result_.assign(source_.piece(row_of_length(rows.first), (rows.last - rows.first) * stride_));
      patch_rows(rows);
      out(result_);
    }
    for (std::size_t first = of_file; first < positions_.size(); first += most) {
      const Rows rows{first, std::min(first + most, positions_.size())};
      result_.clear();
      for (std::size_t i = rows.first; i < rows.last; ++i) {
        result_ += source_.piece(row_of_length(edits_.copied[i - of_file]), stride_);
      }
      patch_rows(rows);
      out(result_);
    }
    source_.copy(row_of_length(of_file), source_.size(), out);
  }

  std::size_t row_of_length(std::size_t row) const { return layout_.vertex_begin + row * stride_; }

  struct Rows {
    std::size_t first;
    std::size_t last;  // not among them
  };

  // Puts what the mesh has and the file has not into `result_`, which holds these rows.
  void put_edited(Rows rows) {
    const auto first = std::lower_bound(edits_.vertices.begin(), edits_.vertices.end(), rows.first);
    const auto last = std::lower_bound(first, edits_.vertices.end(), rows.last);
    if (first == last) return;
    char* to = result_.data();
    for (std::size_t p = 0; p < columns_.size(); ++p) {
      const Property& property = element_.properties[p];
      const auto& names = edits_.attributes;
      const bool is_edited = std::find(names.begin(), names.end(), property.name) != names.end();
      const Attribute* const attribute = is_edited ? source_mesh_.find_attribute(property.name) : nullptr;
      const NewColumn& column = columns_[p];
      const auto never = [](std::size_t) { return std::numeric_limits<double>::quiet_NaN(); };
      for (auto row = first; row != last && (is_edited || column.role == Role::position); ++row) {
        const auto number = [&](std::size_t i) {
          return attribute != nullptr ? attribute->values[i] : source_mesh_.positions[i][column.axis];
        };
        patch_column(to + (*row - rows.first) * stride_, column, {*row, *row + std::size_t{1}}, number, never);
      }
      to += size_of(property.type);
    }
  }

  // Where `result_` holds these rows.
  void patch_rows(Rows rows) {
    put_edited(rows);
    char* to = result_.data();
    for (const NewColumn& column : columns_) {
      if (column.role == Role::position) {
        patch_column(
            to, column, rows, [&](std::size_t i) { return positions_[i][column.axis]; },
            [&](std::size_t i) { return old_positions_[i][column.axis]; });
      } else if (column.role == Role::normal) {
        patch_column(
            to, column, rows, [&](std::size_t i) { return normals_[i][column.axis]; },
            [&](std::size_t i) { return old_normal(i)[column.axis]; });
      } else if (column.role == Role::value) {
        patch_values(to, column, rows);
      }
      to += size_of(column.type);
    }
  }

  void patch_values(char* to, const NewColumn& column, Rows rows) const {
    const auto first = std::lower_bound(changed_.begin(), changed_.end(), rows.first);
    const auto last = std::lower_bound(first, changed_.end(), rows.last);
    for (auto row = first; row != last; ++row) {
      const auto old = [&](std::size_t i) { return (*column.before)[vertex_of(i)]; };
      const auto after = [&](std::size_t) { return (*column.after)[static_cast<std::size_t>(row - changed_.begin())]; };
      patch_column(to + (*row - rows.first) * stride_, column, {*row, *row + std::size_t{1}}, after, old);
    }
  }

  template <class Value, class OldValue>
  void patch_column(char* to, const NewColumn& column, Rows rows, Value value_of, OldValue old_value_of) const {
    visit_type(column.type, [&](auto number) {
      for (std::size_t i = rows.first; i < rows.last; ++i) {
        const double new_value = value_of(i);
        if (new_value == old_value_of(i)) continue;
        number = static_cast<decltype(number)>(new_value);
        if (swapped_) number = swap_bytes(number);
        std::memcpy(to + (i - rows.first) * stride_, &number, sizeof number);
      }
    });
  }

  // Checks the range of all coordinates that change.
  void check_ranges() const {
    const bool fit = std::all_of(positions_.begin(), positions_.end(), fits_floats);
    for (std::size_t i = 0; i < positions_.size() && !fit; ++i) {
      for (const NewColumn& column : columns_) {
        if (column.role == Role::position && value(i, column) != old_value(i, column)) check_range(i, column);
      }
    }
  }

  // The place of a row among the mesh's vertices: rows without a place are not among them.
  std::size_t vertex_of(std::size_t i) const {
    const auto& unplaced = layout_.unplaced;
    return i - static_cast<std::size_t>(std::lower_bound(unplaced.begin(), unplaced.end(), i) - unplaced.begin());
  }

  double value(std::size_t i, const NewColumn& column) const {
    if (column.role == Role::value) {
      const auto row = std::lower_bound(changed_.begin(), changed_.end(), i);
      const bool is_changed = row != changed_.end() && *row == i;
      return is_changed ? (*column.after)[static_cast<std::size_t>(row - changed_.begin())] : old_value(i, column);
    }
    return (column.role == Role::position ? positions_ : normals_)[i][column.axis];
  }

  double old_value(std::size_t i, const NewColumn& column) const {
    if (column.role == Role::value) return (*column.before)[vertex_of(i)];
    return column.role == Role::position ? old_positions_[i][column.axis] : old_normal(i)[column.axis];
  }

  void check_range(std::size_t i, const NewColumn& column) const {
    if (column.type != StoredType::float32 || fits_float(value(i, column))) return;
    throw InvalidInput("vertex " + std::to_string(i) +
                       " has moved to coordinates beyond the range of float; use double precision");
  }

  // Returns the byte after a row, at which the next one begins.
  std::size_t row_begin(std::size_t position) const {
    for (const Property& property : element_.properties) {
      if (property.is_list) {
        position = skip_list(position, property);
      } else {
        position = ascii_ ? token_end(bytes_, token_begin(position)) : position + size_of(property.type);
      }
    }
    return row_end(position);
  }

  // Returns the byte after the row.
  std::size_t rewrite_row(std::size_t i, std::size_t position) {
    const bool unplaced = !layout_.unplaced.empty() && next_unplaced_ != layout_.unplaced.end() && *next_unplaced_ == i;
    if (unplaced) ++next_unplaced_;
    const bool changed = !unplaced && (widened_ || is_changed(i));
    for (std::size_t p = 0; p < columns_.size(); ++p) {
      const Property& property = element_.properties[p];
      if (property.is_list) {
        position = skip_list(position, property);
        continue;
      }
      if (ascii_) position = token_begin(position);
      const std::size_t end = ascii_ ? token_end(bytes_, position) : position + size_of(property.type);
      if (changed && columns_[p].role != Role::none) rewrite_number(i, columns_[p], position, end);
      if (unplaced && columns_[p].widened && !ascii_) widen_number(property.type, position, end);
      position = end;
    }
    return row_end(position);
  }

  // After the numbers that the header does not declare.
  std::size_t row_end(std::size_t position) const {
    while (layout_.surplus && position < bytes_.size() && !is_line_end(bytes_[position])) ++position;
    return position;
  }

  // The same number as a double, be it finite or not.
  void widen_number(StoredType type, std::size_t begin, std::size_t end) {
    copy_until(begin);
    append_binary(result_, StoredType::float64, read_binary(bytes_.data() + begin, type, swapped_), swapped_);
    copied_ = end;
  }

  void rewrite_number(std::size_t i, const NewColumn& column, std::size_t begin, std::size_t end) {
    const double number = value(i, column);
    if (number == old_value(i, column) && (!column.widened || (ascii_ && reads_as(begin, end, number)))) return;
    check_range(i, column);
    const bool rounds_back =
        column.type == StoredType::float32 && static_cast<float>(number) == static_cast<float>(old_value(i, column));
    if (rounds_back) return;  // what is there keeps its spelling
    const auto decimals = column.role == Role::position ? decimals_
                          : column.role == Role::normal ? direction_decimals(decimals_)
                                                        : std::nullopt;
    if (!ascii_ || !decimals) {
      copy_until(begin);
      append_number(column.type, number);
      copied_ = end;
      return;
    }
    number_text_.clear();
    append_decimals(number_text_, number, decimals);
    double rounded = 0;
    parse_real(number_text_, rounded);
    if (reads_as(begin, end, rounded)) return;
    copy_until(begin);
    result_ += number_text_;
    copied_ = end;
  }

  bool reads_as(std::size_t begin, std::size_t end, double number) const {
    double read = 0;
    return parse_real(bytes_.substr(begin, end - begin), read) == ParseResult::ok && read == number;
  }

  void append_number(StoredType type, double number) {
    if (!ascii_) {
      append_binary(result_, type, number, swapped_);
    } else if (type == StoredType::float32) {
      append_real(result_, static_cast<float>(number));
    } else {
      append_real(result_, number);
    }
  }

  std::size_t token_begin(std::size_t position) const {
    while (is_blank(bytes_[position]) || is_line_end(bytes_[position])) ++position;
    return position;
  }

  std::size_t skip_list(std::size_t position, const Property& property) const {
    if (!ascii_) {
      const double items = read_binary(bytes_.data() + position, property.count_type, swapped_);
      return position + size_of(property.count_type) + static_cast<std::size_t>(items) * size_of(property.type);
    }
    position = token_begin(position);
    std::size_t end = token_end(bytes_, position);
    double items = 0;
    parse_real(bytes_.substr(position, end - position), items);  // read before: well formed
    for (; items > 0; --items) end = token_end(bytes_, token_begin(end));
    return end;
  }

  SourceBytes source_;
  std::string_view bytes_;  // all, unless rows are patched
  const Layout& layout_;
  const VertexEdits& edits_;
  const Element& element_;
  bool ascii_;
  bool swapped_;
  const Mesh& source_mesh_;
  const Attribute* old_normals_;
  std::array<std::vector<Vec3d>, 3> expanded_;
  std::vector<std::uint32_t>::const_iterator next_unplaced_;
  std::span<const Vec3d> old_positions_;
  std::span<const Vec3d> positions_;
  std::span<const Vec3d> normals_;
  std::optional<int> decimals_;
  std::string number_text_;
  std::vector<NewColumn> columns_;
  bool widened_ = false;
  std::vector<std::uint32_t> rows_;     // of each vertex; empty: the same
  std::vector<std::uint32_t> changed_;  // rows with other values of attributes
  std::size_t stride_ = 0;              // bytes of a row; 0: rows have lists
  std::string result_;
  std::size_t copied_ = 0;
};

}  // namespace

void rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
             const WriteOptions& options, const ByteSink& out) {
  Rewriter rewriter(source, positions, normals, options);
  if (!rewriter.widens_edited()) return rewriter.run(out);
  std::string bytes;
  Rewriter(source, source.mesh.positions, {}, {}).run([&](std::string_view piece) { bytes += piece; });
  const ShapeFile edited = parse_shape(std::move(bytes), source.format, "edited." + source.format);
  Rewriter(edited, positions, normals, options).run(out);
}

bool writes_edits(const ShapeFile& source) {
  return Rewriter(source, source.mesh.positions, {}, {}).has_rows_of_one_length();
}

std::string with_copies(const ShapeFile& source, std::span<const std::uint32_t> vertices) {
  return Rewriter(source, source.mesh.positions, {}, {}).with_copies(vertices);
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  const bool is_text = layout_of<Layout>(source).encoding == Encoding::ascii;
  if (is_text) Rewriter(source, source.mesh.positions, {}, {}).visit_coordinates(visit);
}

}  // namespace knead::detail::ply
