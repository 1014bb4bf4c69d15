// OpenFOAM's meshes: where their points stand, and the patches of their boundary.
#include <algorithm>
#include <bit>
#include <cstdint>

#include "io/mesh_builder.h"
#include "io/solver/solver.h"
#include "knead/error.h"

namespace knead::detail::solver {
namespace {

class FoamScan {
 public:
  FoamScan(std::string_view bytes, const std::string& name)
      : bytes_(bytes), text_(bytes, name, text_begin(bytes, name)) {}

  void read_points(const PointVisitor& visit) {
    read_head("vectorField");
    const std::size_t count = text_.whole(next(), kMaxElements, "the number of points");
    expect("(");
    if (is_binary_) return read_binary_points(count, visit);
    require_room(count, bytes_.size() - text_.position(), 7, text_);
    for (std::size_t i = 0; i < count; ++i) {
      PointSite site;
      expect("(");
      for (std::string_view& word : site.words) word = next();
      expect(")");
      visit(site);
    }
    expect(")");
  }

  // The points of each face.
  std::vector<std::vector<std::uint32_t>> read_faces() {
    read_head("face");
    std::vector<std::vector<std::uint32_t>> faces;
    if (is_binary_) {
      const std::vector<std::uint64_t> begin = read_labels();
      const std::vector<std::uint64_t> points = read_labels();
      for (std::size_t i = 0; i + 1 < begin.size(); ++i) {
        if (begin[i] > begin[i + 1] || begin[i + 1] > points.size()) text_.fail("the faces do not follow each other");
        faces.emplace_back(points.begin() + static_cast<std::ptrdiff_t>(begin[i]),
                           points.begin() + static_cast<std::ptrdiff_t>(begin[i + 1]));
      }
      return faces;
    }
    const std::size_t count = text_.whole(next(), kMaxElements, "the number of faces");
    expect("(");
    require_room(count, bytes_.size() - text_.position(), 7, text_);
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<std::uint32_t>& face = faces.emplace_back();
      const std::size_t size = text_.whole(next(), kMaxElements, "the number of points");
      expect("(");
      for (std::size_t k = 0; k < size; ++k) {
        face.push_back(static_cast<std::uint32_t>(text_.whole(next(), kMaxElements, "the number of a point")));
      }
      expect(")");
    }
    return faces;
  }

  // The cell of each face.
  std::vector<std::uint64_t> read_cells_of_faces() {
    read_head("labelList");
    if (is_binary_) return read_labels();
    const std::size_t count = text_.whole(next(), kMaxElements, "the number of labels");
    std::vector<std::uint64_t> labels;
    if (count == 0) return labels;
    expect("(");
    require_room(count, bytes_.size() - text_.position(), 2, text_);
    for (std::size_t i = 0; i < count; ++i) labels.push_back(text_.whole(next(), kMaxElements, "the number of a cell"));
    expect(")");
    return labels;
  }

  // A patch of the boundary, and the faces of it.
  struct BoundaryPatch {
    std::string name;
    std::size_t faces = 0;
    std::size_t first = 0;
  };

  std::vector<BoundaryPatch> read_boundary() {
    read_head("polyBoundaryMesh");
    std::vector<BoundaryPatch> patches;
    const std::size_t count = text_.whole(next(), kMaxElements, "the number of patches");
    expect("(");
    for (std::size_t i = 0; i < count; ++i) {
      const std::string_view name = next();
      if (name.empty()) text_.fail("the boundary is cut short");
      BoundaryPatch& patch = patches.emplace_back(BoundaryPatch{std::string(name)});
      read_entries([&](std::string_view key, std::string_view value) {
        if (key == "nFaces") patch.faces = text_.whole(value, kMaxElements, "nFaces");
        if (key == "startFace") patch.first = text_.whole(value, kMaxElements, "startFace");
      });
    }
    return patches;
  }

 private:
  static bool ends_word(char c) {
    return is_blank(c) || is_line_end(c) || std::string_view("(){};").find(c) != std::string_view::npos;
  }

  // Passes over blanks and comments.
  std::size_t skip_gap(std::size_t at) const {
    while (at < bytes_.size()) {
      if (is_blank(bytes_[at]) || is_line_end(bytes_[at])) {
        ++at;
      } else if (bytes_.substr(at, 2) == "//") {
        at = std::min(bytes_.find_first_of("\r\n", at), bytes_.size());
      } else if (bytes_.substr(at, 2) == "/*") {
        const std::size_t end = bytes_.find("*/", at + 2);
        at = end == bytes_.npos ? bytes_.size() : end + 2;
      } else {
        break;
      }
    }
    return at;
  }

  // The next word, a bracket or a semicolon; empty at the end of the file.
  std::string_view next() {
    const std::size_t begin = skip_gap(text_.position());
    std::size_t end = begin;
    while (end < bytes_.size() && !ends_word(bytes_[end])) ++end;
    if (bytes_.substr(begin, 8) == "#include") {
      text_.take(begin, end);
      text_.fail("the lines of another file belong here (" + std::string(bytes_.substr(begin, end - begin)) +
                 "); put them in its place");
    }
    return text_.take(begin, end == begin && end < bytes_.size() ? end + 1 : end);
  }

  void expect(std::string_view word) {
    const std::string_view found = next();
    if (found == word) return;
    text_.fail("expected '" + std::string(word) + "', found " +
               (found.empty() ? "the end of the file" : in_quotes(found)));
  }

  void read_head(std::string_view of) {
    if (next() != "FoamFile") text_.fail("expected FoamFile; is it a file of OpenFOAM's polyMesh?");
    read_entries([&](std::string_view key, std::string_view value) { read_entry(key, value, of); });
  }

  // Calls read(key, value) for the entries between braces.
  template <class Read>
  void read_entries(const Read& read) {
    expect("{");
    for (std::string_view key = next(); key != "}"; key = next()) {
      if (key.empty()) text_.fail("a list of entries has no end");
      const std::size_t begin = skip_gap(text_.position());
      // A text in quotes, as that of arch, may hold semicolons.
      const bool is_quoted = begin < bytes_.size() && bytes_[begin] == '"';
      const std::size_t end = bytes_.find(';', is_quoted ? bytes_.find('"', begin + 1) : begin);
      if (end == bytes_.npos) text_.fail("expected ';' after " + in_quotes(key));
      read(key, bytes_.substr(begin, end - begin));
      text_.take(end, end + 1);
    }
  }

  void read_entry(std::string_view key, std::string_view value, std::string_view of) {
    const auto has = [&](const char* part) { return value.find(part) != value.npos; };
    if (key == "format") {
      is_binary_ = value == "binary";
      if (!is_binary_ && value != "ascii") text_.fail("the format must be ascii or binary, found " + in_quotes(value));
    } else if (key == "class" && !value.starts_with(of)) {
      text_.fail("holds " + in_quotes(value) + " and no " + std::string(of));
    } else if (key == "arch") {
      label_size_ = has("label=64") ? sizeof(std::int64_t) : sizeof(std::int32_t);
      site_.spelling = has("scalar=32") ? Spelling::float32 : Spelling::float64;
      site_.swapped = (has("MSB") ? std::endian::big : std::endian::little) != std::endian::native;
    }
  }

  void read_binary_points(std::size_t count, const PointVisitor& visit) {
    const std::size_t size = site_.spelling == Spelling::float32 ? sizeof(float) : sizeof(double);
    const std::size_t begin = text_.position();
    if (count > (bytes_.size() - begin) / (3 * size)) {
      text_.fail(too_many(std::to_string(count) + " points", bytes_.size() - begin));
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        site_.words[axis] = bytes_.substr(begin + (3 * i + axis) * size, size);
      visit(site_);
    }
    text_.take(begin, begin + 3 * size * count);
    expect(")");
  }

  std::vector<std::uint64_t> read_labels() {
    const std::size_t count = text_.whole(next(), kMaxElements, "the number of labels");
    std::vector<std::uint64_t> labels;
    if (count == 0) return labels;
    expect("(");
    const std::size_t begin = text_.position();
    if (count > (bytes_.size() - begin) / label_size_) text_.fail("a list of labels is cut short");
    for (std::size_t i = 0; i < count; ++i) {
      const double label =
          read_binary(bytes_.data() + begin + i * label_size_,
                      label_size_ == sizeof(std::int64_t) ? StoredType::int64 : StoredType::int32, site_.swapped);
      if (!(label >= 0 && label <= static_cast<double>(kMaxElements))) text_.fail("a label is out of range");
      labels.push_back(static_cast<std::uint64_t>(label));
    }
    text_.take(begin, begin + count * label_size_);
    expect(")");
    return labels;
  }

  std::string_view bytes_;
  TextCursor text_;
  bool is_binary_ = false;
  std::size_t label_size_ = sizeof(std::int32_t);                                         // bytes
  PointSite site_{{}, 3, Spelling::float64, std::endian::native != std::endian::little};  // of a binary file
};

}  // namespace

void scan_foam(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  FoamScan(bytes, name).read_points(visit);
}

std::vector<Patch> foam_patches(std::string_view boundary, std::string_view faces, const std::string& name) {
  const std::string faces_name = name + "/faces";
  const std::string boundary_name = name + "/boundary";
  const std::vector<std::vector<std::uint32_t>> all = FoamScan(faces, faces_name).read_faces();
  std::vector<Patch> patches;
  for (const FoamScan::BoundaryPatch& from : FoamScan(boundary, boundary_name).read_boundary()) {
    if (from.first > all.size() || from.faces > all.size() - from.first) {
      throw InvalidInput(Place{boundary_name}, "the patch " + from.name + " has faces that the mesh lacks");
    }
    Patch& patch = patches.emplace_back(Patch{from.name, {}});
    for (std::size_t i = 0; i < from.faces; ++i) {
      const std::vector<std::uint32_t>& face = all[from.first + i];
      patch.points.insert(patch.points.end(), face.begin(), face.end());
      for (std::size_t k = 2; k < face.size(); ++k) patch.faces.push_back({face[0], face[k - 1], face[k]});
    }
  }
  return patches;
}

VolumeCells foam_cells(std::string_view faces, std::string_view owner, std::string_view neighbour,
                       const std::string& name) {
  const std::string faces_name = name + "/faces";
  const std::string owner_name = name + "/owner";
  const std::string neighbour_name = name + "/neighbour";
  const std::vector<std::vector<std::uint32_t>> all = FoamScan(faces, faces_name).read_faces();
  const std::vector<std::uint64_t> owners = FoamScan(owner, owner_name).read_cells_of_faces();
  const std::vector<std::uint64_t> neighbours = FoamScan(neighbour, neighbour_name).read_cells_of_faces();
  if (owners.size() != all.size() || neighbours.size() > all.size()) {
    throw InvalidInput(Place{owner_name}, "has not one cell for each face; the mesh is damaged");
  }
  VolumeCells cells;
  for (const std::uint64_t cell : owners) {
    if (cell > all.size()) throw InvalidInput(Place{owner_name}, "has more cells than faces; the mesh is damaged");
    cells.polyhedra.resize(std::max<std::size_t>(cells.polyhedra.size(), cell + 1));
  }
  for (std::size_t f = 0; f < all.size(); ++f) {
    const auto add = [&](std::uint64_t cell, auto begin, auto end) {
      if (cell >= cells.polyhedra.size()) throw InvalidInput(Place{neighbour_name}, "names a cell without an owner");
      cells.polyhedra[cell].push_back(static_cast<std::uint32_t>(all[f].size()));
      cells.polyhedra[cell].insert(cells.polyhedra[cell].end(), begin, end);
    };
    add(owners[f], all[f].begin(), all[f].end());
    if (f < neighbours.size()) add(neighbours[f], all[f].rbegin(), all[f].rend());
  }
  return cells;
}

}  // namespace knead::detail::solver
