// gmsh's meshes: where their points stand, and their physical groups.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "io/mesh_builder.h"
#include "io/solver/solver.h"
#include "knead/error.h"

namespace knead::detail::solver {
namespace {

// The physical groups by dimension and number.
struct GmshGroups {
  using Key = std::pair<std::int64_t, std::int64_t>;
  std::vector<std::int64_t> points;  // gmsh's number of each
  std::map<Key, std::string> names;
  std::map<Key, std::vector<std::int64_t>> of_entity;
  std::map<Key, std::vector<std::int64_t>> members;  // gmsh's numbers of points, with repetitions
  std::map<Key, std::vector<std::int64_t>> faces;    // of faces and edges: the type, then the points
  // The elements of two and of three dimensions: the type, then the points.
  std::array<std::vector<std::int64_t>, 2> cells;
};

// What stands between $MeshFormat and its end.
struct GmshHead {
  bool is_4 = false;
  std::optional<std::endian> order;  // of a binary file
};

class GmshScan {
 public:
  // Groups: null, or what the physical groups are collected in.
  GmshScan(std::string_view bytes, const std::string& name, const PointVisitor& visit, GmshGroups* groups = nullptr)
      : bytes_(bytes), name_(name), visit_(visit), groups_(groups), text_(bytes, name, text_begin(bytes, name)) {}

  void run() {
    std::optional<GmshHead> head;
    for (std::string_view section = text_.next(); !section.empty(); section = text_.next()) {
      if (section == "$NOD") text_.fail("is of gmsh's version 1; save it as version 2.2 or 4.1");
      if (!section.starts_with('$')) text_.fail("expected a section, such as $Nodes, found " + in_quotes(section));
      const bool is_parametric = section == "$ParametricNodes";
      if (section == "$MeshFormat") {
        head = read_head();
      } else if (section == "$Nodes" || is_parametric) {
        if (!head) text_.fail("$MeshFormat must come before " + std::string(section));
        head->is_4 ? read_nodes_4(*head) : read_nodes_2(*head, is_parametric);
      } else if (groups_ != nullptr && head) {
        read_groups(section, *head);
      }
      skip_to_end_of(section);
    }
    if (!head) throw InvalidInput(Place{name_}, "has no $MeshFormat; is it a file of gmsh?");
  }

 private:
  void skip_to_end_of(std::string_view section) {
    const std::string end = "$End" + std::string(section.substr(1));
    std::size_t at = bytes_.find(end, text_.position());
    while (at != bytes_.npos && !is_line_end(bytes_[at - 1]) && !is_binary_) at = bytes_.find(end, at + 1);
    if (at == bytes_.npos) text_.fail("the section " + std::string(section) + " has no " + end);
    text_.take(at, at + end.size());
    text_.next_line();
  }

  GmshHead read_head() {
    const std::string_view version = text_.next();
    if (version != "2" && version != "2.1" && version != "2.2" && version != "4.1") {
      text_.fail("is of gmsh's version " + in_quotes(version) + "; save it as version 2.2 or 4.1");
    }
    GmshHead head{version == "4.1", std::nullopt};
    is_binary_ = text_.whole(text_.next_on_line(), 1, "the type of the file, 0 or 1,") == 1;
    if (text_.whole(text_.next_on_line(), 8, "the size of a number") != 8) text_.fail("the size of a number must be 8");
    if (!is_binary_) return head;
    text_.next_line();
    ByteCursor one(bytes_, name_);
    one.take_bytes(text_.position(), "the header");
    head.order = one.take<std::int32_t>("the number 1") == 1 ? std::endian::little : std::endian::big;
    order_ = *head.order;
    return head;
  }

  // Binary: the bytes after this line.
  ByteCursor begin_binary(const GmshHead& head) {
    ByteCursor cursor(bytes_, name_, *head.order);
    cursor.take_bytes(text_.position(), "the header");
    return cursor;
  }

  void end_binary(const ByteCursor& cursor) { text_.take(cursor.position(), cursor.position()); }

  static void require_left(std::uint64_t points, std::size_t bytes_for_each, const ByteCursor& cursor) {
    if (points > cursor.left() / bytes_for_each) {
      cursor.fail(too_many(std::to_string(points) + " points", cursor.left()));
    }
  }

  void visit_doubles(ByteCursor& cursor, const GmshHead& head) {
    PointSite site;
    site.spelling = Spelling::float64;
    site.swapped = *head.order != std::endian::native;
    for (std::string_view& word : site.words) word = cursor.take_bytes(sizeof(double), "a coordinate");
    visit_(site);
  }

  void read_nodes_2(const GmshHead& head, bool is_parametric) {
    const std::size_t count = text_.whole(text_.next(), kMaxElements, "the number of points");
    text_.next_line();
    if (!is_binary_) {
      require_room(count, bytes_.size() - text_.position(), 8, text_);
      for (std::size_t i = 0; i < count; ++i, text_.next_line()) {
        note_point(text_.next());
        visit_(words_from(text_.next_on_line(), 3, text_));
      }
      return;
    }
    ByteCursor cursor = begin_binary(head);
    require_left(count, sizeof(std::int32_t) + 3 * sizeof(double), cursor);
    for (std::size_t i = 0; i < count; ++i) {
      note_point(cursor.take<std::int32_t>("the number of a point"));
      visit_doubles(cursor, head);
      if (!is_parametric) continue;
      const auto dimension = cursor.take<std::int32_t>("a dimension");
      cursor.take<std::int32_t>("the number of an entity");
      const bool has_parameters = dimension == 1 || dimension == 2;
      cursor.take_bytes((has_parameters ? static_cast<std::size_t>(dimension) : 0) * sizeof(double), "parameters");
    }
    end_binary(cursor);
  }

  void read_nodes_4(const GmshHead& head) {
    if (is_binary_) return read_binary_nodes_4(head);
    const std::size_t blocks = text_.whole(text_.next(), kMaxElements, "the number of blocks");
    require_room(blocks, bytes_.size() - text_.position(), 8, text_);
    text_.next_line();
    for (std::size_t block = 0; block < blocks; ++block) {
      text_.next();  // dimension, number of the entity, whether parameters follow
      for (int i = 0; i < 2; ++i) text_.next_on_line();
      const std::size_t count = text_.whole(text_.next_on_line(), kMaxElements, "the number of points");
      require_room(count, bytes_.size() - text_.position(), 8, text_);
      text_.next_line();
      for (std::size_t i = 0; i < count; ++i, text_.next_line()) {
        note_point(text_.next());
      }
      for (std::size_t i = 0; i < count; ++i, text_.next_line()) visit_(words_from(text_.next(), 3, text_));
    }
  }

  void read_binary_nodes_4(const GmshHead& head) {
    text_.next_line();
    ByteCursor cursor = begin_binary(head);
    const auto blocks = cursor.take<std::uint64_t>("the number of blocks");
    for (int i = 0; i < 3; ++i) cursor.take<std::uint64_t>("the number of points");
    for (std::uint64_t block = 0; block < blocks; ++block) {
      const auto dimension = cursor.take<std::int32_t>("a dimension");
      cursor.take<std::int32_t>("the number of an entity");
      const bool is_parametric = cursor.take<std::int32_t>("whether parameters follow") != 0;
      if (dimension < 0 || dimension > 3) cursor.fail("a dimension must be 0 to 3");
      const auto count = cursor.take<std::uint64_t>("the number of points");
      require_left(count, sizeof(std::uint64_t) + 3 * sizeof(double), cursor);
      for (std::uint64_t i = 0; i < count; ++i) note_point(cursor.take<std::int64_t>("the number of a point"));
      for (std::uint64_t i = 0; i < count; ++i) {
        visit_doubles(cursor, head);
        const std::size_t parameters = is_parametric ? static_cast<std::size_t>(dimension) : 0;
        cursor.take_bytes(parameters * sizeof(double), "parameters");
      }
    }
    end_binary(cursor);
  }

  std::int64_t whole_of(std::string_view word) const {
    std::int64_t value = 0;
    const char* const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (word.empty() || error != std::errc{} || stop != end)
      text_.fail("expected a whole number, found " + in_quotes(word));
    return value;
  }

  void note_point(std::int64_t number) {
    if (groups_ != nullptr) groups_->points.push_back(number);
  }
  void note_point(std::string_view word) { note_point(whole_of(word)); }

  // The next number of this section; in a binary file it has the type T.
  template <class T>
  T number() {
    if constexpr (std::is_integral_v<T>) {
      if (!is_binary_) return static_cast<T>(whole_of(text_.next()));
    } else {
      if (!is_binary_) return text_.real(text_.next(), "a number");
    }
    ByteCursor cursor(bytes_, name_, order_);
    cursor.take_bytes(text_.position(), "the section");
    const T value = cursor.take<T>("a number");
    text_.take(cursor.position(), cursor.position());
    return value;
  }
  std::int64_t small() { return number<std::int32_t>(); }
  std::int64_t large() { return number<std::int64_t>(); }

  void read_groups(std::string_view section, const GmshHead& head) {
    if (section == "$PhysicalNames") return read_names();
    if (section != "$Entities" && section != "$Elements") return;
    text_.next_line();
    if (section == "$Entities") return read_entities();
    head.is_4 ? read_elements_4() : read_elements_2();
  }

  void read_names() {
    const std::int64_t count = whole_of(text_.next());
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t dimension = whole_of(text_.next());
      const std::int64_t tag = whole_of(text_.next_on_line());
      const std::size_t line_end = std::min(bytes_.find_first_of("\r\n", text_.position()), bytes_.size());
      std::string_view name = trimmed(bytes_.substr(text_.position(), line_end - text_.position()));
      if (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
      groups_->names[{dimension, tag}] = name;
      text_.take(line_end, line_end);
    }
  }

  void read_entities() {
    std::array<std::int64_t, 4> counts{};
    for (std::int64_t& count : counts) count = large();
    for (std::size_t dimension = 0; dimension < 4; ++dimension) {
      for (std::int64_t i = 0; i < counts[dimension]; ++i) {
        const std::int64_t tag = small();
        for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) number<double>();
        std::vector<std::int64_t>& groups = groups_->of_entity[{static_cast<std::int64_t>(dimension), tag}];
        for (std::int64_t left = large(); left > 0; --left) groups.push_back(small());
        for (std::int64_t left = dimension == 0 ? 0 : large(); left > 0; --left) small();
      }
    }
  }

  const GmshElement& element_of(std::int64_t type) const {
    const GmshElement* const element = gmsh_element(type);
    if (element == nullptr) text_.fail("elements of the type " + std::to_string(type) + " are not known");
    return *element;
  }

  template <class T>
  void read_element_points(std::int64_t type, std::span<const std::int64_t> groups, std::int64_t dimension) {
    std::vector<std::int64_t> element{type};
    for (std::size_t k = element_of(type).points; k > 0; --k) element.push_back(number<T>());
    if (dimension == 2 || dimension == 3) {
      std::vector<std::int64_t>& cells = groups_->cells[static_cast<std::size_t>(dimension - 2)];
      cells.insert(cells.end(), element.begin(), element.end());
    }
    for (const std::int64_t group : groups) {
      std::vector<std::int64_t>& members = groups_->members[{dimension, group}];
      members.insert(members.end(), element.begin() + 1, element.end());
      if (dimension == 3) continue;
      std::vector<std::int64_t>& faces = groups_->faces[{dimension, group}];
      faces.insert(faces.end(), element.begin(), element.end());
    }
  }

  void read_elements_4() {
    const std::int64_t blocks = large();
    for (int i = 0; i < 3; ++i) large();
    for (std::int64_t block = 0; block < blocks; ++block) {
      const std::int64_t dimension = small();
      const std::int64_t entity = small();
      const std::int64_t type = small();
      const std::vector<std::int64_t> groups = groups_->of_entity[{dimension, entity}];
      for (std::int64_t left = large(); left > 0; --left) {
        large();  // the number of the element
        read_element_points<std::int64_t>(type, groups, dimension);
      }
    }
  }

  void read_elements_2() {
    const std::int64_t count = is_binary_ ? whole_of(last_line_word()) : whole_of(text_.next());
    for (std::int64_t i = 0; i < count;) {
      if (!is_binary_) small();  // the number of the element
      const std::int64_t type = small();
      const std::int64_t equal = is_binary_ ? small() : 1;
      const std::int64_t tags = small();
      for (std::int64_t k = 0; k < equal; ++k) {
        if (is_binary_) small();
        std::vector<std::int64_t> groups;
        for (std::int64_t tag = 0; tag < tags; ++tag) {
          const std::int64_t value = small();
          if (tag == 0) groups.push_back(value);
        }
        read_element_points<std::int32_t>(type, groups, element_of(type).dimension());
      }
      i += std::max<std::int64_t>(equal, 1);
    }
  }

  // The count of a binary section, which stands on a line of its own.
  std::string_view last_line_word() {
    const std::string_view word = text_.next();
    text_.next_line();
    return word;
  }

  std::string_view bytes_;
  const std::string& name_;
  const PointVisitor& visit_;
  GmshGroups* groups_;
  TextCursor text_;
  std::endian order_ = std::endian::native;
  bool is_binary_ = false;
};

// gmsh's numbers of points as numbers from 0.
class PointIndex {
 public:
  PointIndex(const std::vector<std::int64_t>& points, const std::string& name) : name_(name) {
    for (const std::int64_t number : points) index_.emplace(number, static_cast<std::uint32_t>(index_.size()));
  }

  std::uint32_t operator()(std::int64_t number) const {
    const auto found = index_.find(number);
    if (found == index_.end()) throw InvalidInput(Place{name_}, "an element names a point that the mesh lacks");
    return found->second;
  }

 private:
  const std::string& name_;
  std::unordered_map<std::int64_t, std::uint32_t> index_;
};

// Calls use(type, points) for elements that stand one after the other.
template <class Use>
void for_each_element(const std::vector<std::int64_t>& elements, const PointIndex& index, const Use& use) {
  std::vector<std::uint32_t> points;
  for (std::size_t i = 0; i < elements.size();) {
    const std::int64_t type = elements[i++];
    points.clear();
    for (std::size_t k = gmsh_element(type)->points; k > 0; --k) {
      points.push_back(index(elements[i++]));
    }
    use(type, points);
  }
}

GmshGroups groups_of(std::string_view bytes, const std::string& name) {
  GmshGroups groups;
  GmshScan(
      bytes, name, [](const PointSite&) {}, &groups)
      .run();
  return groups;
}

}  // namespace

void scan_gmsh(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  GmshScan(bytes, name, visit).run();
}

std::vector<Patch> gmsh_patches(std::string_view bytes, const std::string& name) {
  const GmshGroups groups = groups_of(bytes, name);
  const PointIndex index(groups.points, name);
  std::vector<Patch> patches;
  for (const auto& [key, members] : groups.members) {
    const auto named = groups.names.find(key);
    Patch patch{named == groups.names.end() ? std::to_string(key.second) : named->second, {}};
    for (const std::int64_t number : members) patch.points.push_back(index(number));
    const auto faces = groups.faces.find(key);
    if (faces != groups.faces.end()) {
      for_each_element(faces->second, index, [&](std::int64_t type, std::span<const std::uint32_t> points) {
        add_faces(type, points, patch.faces);
      });
    }
    patches.push_back(std::move(patch));
  }
  return patches;
}

VolumeCells gmsh_cells(std::string_view bytes, const std::string& name, std::span<const Vec3d> points) {
  const GmshGroups groups = groups_of(bytes, name);
  const PointIndex index(groups.points, name);
  VolumeCells cells;
  const bool flat = is_flat(points);
  for_each_element(groups.cells[flat ? 0 : 1], index, [&](std::int64_t type, std::span<const std::uint32_t> numbers) {
    flat ? add_flat_cell(type, numbers, points, cells) : add_cell(type, numbers, cells);
  });
  if (flat) return cells;
  for_each_element(groups.cells[0], index, [&](std::int64_t, std::span<const std::uint32_t> numbers) {
    cells.on_surfaces.insert(cells.on_surfaces.end(), numbers.begin(), numbers.end());
  });
  return cells;
}

}  // namespace knead::detail::solver
