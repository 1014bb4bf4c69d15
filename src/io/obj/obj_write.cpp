// Writing OBJ: a new file, or the source's bytes with some numbers replaced and lines `vn` added.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/obj/obj.h"
#include "io/text.h"
#include "knead/mesh.h"
#include "math/system.h"

namespace knead::detail::obj {
namespace {

// The corners that have a normal, ordered by a key and then as in the file.
template <class Key>
std::vector<std::uint32_t> corners_by(const Layout& layout, const Key& key) {
  std::vector<std::uint32_t> corners;
  for (std::uint32_t c = 0; c < layout.corner_normal.size(); ++c) {
    if (layout.corner_normal[c] != kNoNormal) corners.push_back(c);
  }
  std::stable_sort(corners.begin(), corners.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  return corners;
}

// A line of the file, and the cell of a grid that a normal of its corners lies in; the first cell is that of corners
// which did not turn.
using Cell = std::array<double, 5>;

Cell cell_of(const Vec3d& normal, const Vec3d& before, std::uint32_t line) {
  if (normal == before) return {static_cast<double>(line), 0, 0, 0, 0};
  const double grid = 1e-4 * norm(normal);
  const auto index = [&](double x) { return grid > 0 ? std::floor(x / grid + 0.5) : 0; };
  return {static_cast<double>(line), 1, index(normal.x), index(normal.y), index(normal.z)};
}

// Corners that use one line `vn` at one vertex turn together (transport_normals); the vector of a corner without a
// normal is zero.
std::vector<Vec3d> moved_corner_normals(const ShapeFile& source, std::span<const Vec3d> after) {
  const Mesh& mesh = source.mesh;
  const Layout& layout = layout_of<Layout>(source);
  if (layout.corner_normal.empty()) return {};
  using Use = std::array<std::uint32_t, 2>;
  const auto use = [&](std::uint32_t c) { return Use{layout.corner_normal[c], mesh.corner_vertex[c]}; };
  std::vector<Vec3d> normals;
  std::vector<std::uint32_t> corner_use(layout.corner_normal.size(), kNoNormal);
  Use last{kNoNormal, 0};
  for (const std::uint32_t c : corners_by(layout, use)) {
    if (use(c) != last) normals.push_back(layout.normals[layout.corner_normal[c]]);
    last = use(c);
    corner_use[c] = static_cast<std::uint32_t>(normals.size() - 1);
  }
  const std::vector<Vec3d> moved = transport_normals(mesh, after, normals, corner_use);
  std::vector<Vec3d> corner_normals(corner_use.size());
  for (std::size_t c = 0; c < corner_use.size(); ++c) {
    if (corner_use[c] != kNoNormal) corner_normals[c] = moved[corner_use[c]];
  }
  return corner_normals;
}

// Lines `vn` that together say what the corners' normals are now. The first are those of the file, in their order, with
// new values; then those that are needed because corners which shared a line have turned apart.
struct NormalLines {
  struct Line {
    Vec3d normal;
    std::uint32_t source = 0;  // the line of the file that corners used before
  };
  std::vector<Line> lines;
  std::vector<std::uint32_t> corner_line;  // of each corner; kNoNormal: none. Empty: as in the file
};

// A line keeps its value where a corner that did not turn uses it; else it takes that of the first corner that does.
// Corners whose normals are equal to about 1e-4 of their length share a line.
NormalLines plan_normals(const Layout& layout, std::span<const Vec3d> corner_normals) {
  NormalLines plan;
  for (std::size_t n = 0; n < layout.normals.size(); ++n) {
    plan.lines.push_back({layout.normals[n], static_cast<std::uint32_t>(n)});
  }
  if (corner_normals.empty()) return plan;
  plan.corner_line = layout.corner_normal;
  const auto line_of = [&](std::uint32_t c) { return layout.corner_normal[c]; };
  std::vector<Cell> cells(layout.corner_normal.size());
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    if (line_of(c) != kNoNormal) cells[c] = cell_of(corner_normals[c], layout.normals[line_of(c)], line_of(c));
  }
  const auto cell = [&](std::uint32_t c) -> const Cell& { return cells[c]; };
  // Of each line the corner whose cell keeps it: one that did not turn, or else the first in the file.
  const std::vector<std::uint32_t> corners = corners_by(layout, cell);
  std::vector<std::uint32_t> keeper(layout.normals.size(), kNoNormal);
  for (const std::uint32_t c : corners) {
    std::uint32_t& kept = keeper[line_of(c)];
    const bool unturned = kept != kNoNormal && cell(kept)[1] == 0;
    if (kept == kNoNormal || (!unturned && c < kept)) kept = c;
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t c = corners[i];
    const std::uint32_t line = line_of(c);
    if (cell(c) == cell(keeper[line])) {
      plan.lines[line].normal = corner_normals[keeper[line]];
    } else if (i > 0 && cell(c) == cell(corners[i - 1])) {
      plan.corner_line[c] = plan.corner_line[corners[i - 1]];
    } else {
      plan.corner_line[c] = static_cast<std::uint32_t>(plan.lines.size());
      plan.lines.push_back({corner_normals[c], line});
    }
  }
  if (plan.lines.size() == layout.normals.size()) plan.corner_line.clear();
  return plan;
}

const Attribute* vertex_color(const Mesh& mesh) {
  const Attribute* color = mesh.find_attribute("color");
  return color != nullptr && color->domain == Domain::vertex && color->components >= 3 ? color : nullptr;
}

// Colors are floats where they come from, and shorter as such.
void append_color(std::string& text, double value) {
  fits_float(value) ? append_real(text, static_cast<float>(value)) : append_real(text, value);
}

void append_vertices(std::string& text, const Mesh& mesh, std::optional<int> decimals) {
  const Attribute* color = vertex_color(mesh);
  const double scale = color != nullptr ? color_scale(*color) : 1;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const Vec3d& p = mesh.positions[i];
    const std::array<double, 3> xyz{p.x, p.y, p.z};
    append_vector(text, "v", xyz.data(), 3, decimals);
    for (std::size_t c = 0; color != nullptr && c < 3; ++c) {
      text += ' ';
      const std::size_t first = i * static_cast<std::size_t>(color->components);
      append_color(text, color->values[first + c] * scale);
    }
    text += '\n';
  }
}

void append_face(std::string& text, const Mesh& mesh, std::size_t f, const Lines& uv, const Lines& normal) {
  text += 'f';
  for (std::uint32_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) {
    text += ' ' + std::to_string(mesh.corner_vertex[c] + std::size_t{1});
    if (uv.corner_line.empty() && normal.corner_line.empty()) continue;
    text += '/';
    if (!uv.corner_line.empty()) text += std::to_string(uv.corner_line[c]);
    if (!normal.corner_line.empty()) text += '/' + std::to_string(normal.corner_line[c]);
  }
  text += '\n';
}

std::string generate(const Mesh& mesh, const WriteOptions& options) {
  const Lines uv = value_lines<2>(mesh, "uv", "vt");
  const Lines normal = value_lines<3>(mesh, "normal", "vn");
  std::string text;
  append_vertices(text, mesh, options.decimals);
  text += uv.text;
  text += normal.text;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) append_face(text, mesh, f, uv, normal);
  return text;
}

std::vector<std::string> losses(const Mesh& mesh) {
  std::vector<std::string> losses;
  for (const Attribute& attribute : mesh.attributes) {
    const bool is_shading = attribute.name == "uv" || attribute.name == "normal";
    if (is_shading && attribute.domain != Domain::face && &attribute == mesh.find_attribute(attribute.name)) {
      if (mesh.face_count() == 0) losses.push_back("OBJ cannot hold '" + attribute.name + "' of points without faces");
    } else if (&attribute != vertex_color(mesh)) {
      losses.push_back("OBJ cannot hold '" + attribute.name + "'" +
                       (attribute.domain == Domain::face ? " per face" : ""));
    } else if (attribute.components > 3) {
      losses.push_back("OBJ cannot hold the alpha of colors");
    }
  }
  return losses;
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  std::vector<std::string> losses;
  for (const std::string& keyword : layout_of<Layout>(source).other_keywords) {
    losses.push_back("lines '" + keyword + "' are left out");
  }
  const std::size_t unplaced = layout_of<Layout>(source).unplaced.size();
  if (unplaced > 0) losses.push_back(unplaced_loss(unplaced));
  return losses;
}

// Walks through the statements as the reader did. Coordinates are doubles, whatever the options say. Where corners that
// shared a line `vn` have turned differently, adds lines before the first face that needs them and changes the third
// numbers of the faces.
class Rewriter {
 public:
  Rewriter(const ShapeFile& source, std::span<const Vec3d> positions, NormalLines normals, std::optional<int> decimals)
      : bytes_(without_end_zeros(source.bytes)),
        splice_(source.bytes, decimals),
        old_positions_(source.mesh.positions),
        old_normals_(layout_of<Layout>(source).normals),
        positions_(positions),
        normals_(std::move(normals)),
        decimals_(decimals),
        number_(normals_.lines.size(), 0),
        line_end_(line_end_of(bytes_)) {
    if (const auto& unplaced = layout_of<Layout>(source).unplaced; !unplaced.empty()) {
      old_positions_ = rows_before_ = by_row(old_positions_, unplaced);
      positions_ = rows_after_ = by_row(positions, unplaced);
    }
  }

  std::string run() {
    for (std::size_t position = first_byte(bytes_); position < bytes_.size();) {
      const std::size_t line = position;
      const auto next = [&] {
        const std::size_t begin = skip_blanks(bytes_, position);
        position = word_end(bytes_, begin);
        return bytes_.substr(begin, position - begin);
      };
      const std::string_view keyword = next();
      if (keyword == "v") {
        splice_.replace_changed(old_positions_[vertex_], positions_[vertex_], next);
        ++vertex_;
      } else if (keyword == "vn") {
        splice_.replace_direction(old_normals_[normal_], normals_.lines[normal_].normal, next);
        number_[normal_++] = ++written_;
      } else if (keyword == "f" && !normals_.corner_line.empty()) {
        position = rewrite_face(line, position);
      }
      position = end_of_line(bytes_, position) + 1;
    }
    return splice_.finish();
  }

 private:
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
    const Vec3d& n = normals_.lines[line].normal;
    std::string text;
    append_vector(text, "vn", std::array{n.x, n.y, n.z}.data(), 3, direction_decimals(decimals_));
    text += line_end_;
    splice_.replace_text(bytes_.substr(position, 0), text);
    number_[line] = ++written_;
  }

  void renumber(const Reference& reference) {
    const std::int64_t number = number_[reference.line];
    const std::int64_t index = reference.index > 0 ? number : number - written_ - 1;
    if (index == reference.index) return;
    splice_.replace_text(bytes_.substr(reference.begin, reference.end - reference.begin), std::to_string(index));
  }

  std::string_view bytes_;
  Splice splice_;
  std::vector<Vec3d> rows_before_;  // the positions of all lines `v`, if some vertices have no place
  std::vector<Vec3d> rows_after_;
  std::span<const Vec3d> old_positions_;
  std::span<const Vec3d> old_normals_;
  std::span<const Vec3d> positions_;
  NormalLines normals_;
  std::optional<int> decimals_;
  std::vector<std::int64_t> number_;  // of each line of normals_ in the new file, from 1; 0: not written so far
  std::string_view line_end_;
  std::size_t vertex_ = 0;  // how many the file has given so far
  std::size_t normal_ = 0;
  std::size_t corner_ = 0;    // of the mesh
  std::int64_t written_ = 0;  // lines vn
  std::vector<Reference> references_;
};

// `normals`: one for each corner (moved_corner_normals), or none. In a file whose faces stand before the normals that
// they use, corners that turn differently keep one line.
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

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxBytes = 64 << 20;

bool is_plain_name(const std::string& name) {
  const bool ends_well = name.size() > 4 && fs::path(name).extension() == ".mtl";
  return ends_well && name.find_first_of("/\\:") == std::string::npos && name.find('\0') == std::string::npos;
}

// Returns the bytes of a regular file; nothing for a link, which may lead anywhere, and what cannot be read.
std::optional<std::string> material_bytes(const fs::path& path) {
  std::error_code error;
  const bool is_there = fs::is_regular_file(fs::symlink_status(path, error));
  if (!is_there || !(fs::file_size(path, error) <= kMaxBytes) || error) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  return file ? std::optional(std::move(bytes)) : std::nullopt;
}

// Copies the material files; see copy_material_files in io.h.
std::vector<fs::path> copy_beside(const ShapeFile& source, const fs::path& from_folder, const fs::path& to_folder,
                                  const ByteSink& note) {
  std::vector<fs::path> copied;
  std::error_code error;
  for (std::string name : layout_of<Layout>(source).material_files) {
    if (name.substr(0, 2) == "./") name.erase(0, 2);
    const fs::path from = from_folder / name;
    const fs::path to = to_folder / name;
    const std::optional<std::string> bytes = is_plain_name(name) ? material_bytes(from) : std::nullopt;
    if (!bytes) {
      if (fs::is_regular_file(from, error)) note(from.string() + ": the materials were not copied; copy them yourself");
      continue;
    }
    if (fs::exists(fs::symlink_status(to, error))) {
      const bool is_copy = std::find(copied.begin(), copied.end(), to) != copied.end();
      if (!is_copy && material_bytes(to) != bytes) note(to.string() + ": is another file of materials, and was kept");
      continue;
    }
    write_file_atomically(to, *bytes);
    copied.push_back(to);
    note(to.string() + ": the materials were copied too" +
         (bytes->find("map_") != bytes->npos ? ", but not their textures" : ""));
  }
  return copied;
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

}  // namespace
}  // namespace knead::detail::obj

const knead::detail::Codec knead::detail::obj_codec{.name = "obj",
                                                    .read = obj::read,
                                                    .rewrite = obj::rewrite,
                                                    .generate = obj::generate,
                                                    .losses = obj::losses,
                                                    .source_losses = obj::source_losses,
                                                    .remeshed = obj::remeshed,
                                                    .remesh_losses = obj::remesh_losses,
                                                    .face_labels = obj::face_labels,
                                                    .moved_corner_normals = obj::moved_corner_normals,
                                                    .visit_coordinates = obj::visit_coordinates,
                                                    .copy_beside = obj::copy_beside};
