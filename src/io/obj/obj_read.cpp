// Reading OBJ (Wavefront, appendix B1 of the Advanced Visualizer manual): v, vt, vn and f; all else is passed over.
#include <algorithm>
#include <charconv>
#include <optional>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/obj/obj.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::detail::obj {
namespace {

// A line end that a backslash takes away: its length, or 0 where there is none.
std::size_t joined_length(std::string_view bytes, std::size_t position) {
  if (position + 1 >= bytes.size() || bytes[position] != '\\') return 0;
  if (bytes[position + 1] == '\n') return 2;
  if (bytes[position + 1] != '\r') return 0;
  return position + 2 < bytes.size() && bytes[position + 2] == '\n' ? 3 : 2;
}

// What the corners of faces refer to: vertices, texture coordinates or normals. An index counts from 1, or from the end
// of what the file has given so far if it is negative.
struct References {
  const char* what;
  std::size_t given = 0;                // so far
  std::vector<std::uint32_t> corner{};  // of each corner kept, from 0; kNoNormal: none; empty until one is given
  bool ahead = false;                   // an index was used before what it refers to
  bool optional = true;                 // a file that has none of what is referred to is read without it
  std::size_t dangling = 0;             // indices that count back from nothing, and where the first is
  std::size_t dangling_position = 0;
  std::size_t largest = 0;  // index used, from 1, and where
  std::size_t largest_position = 0;
};

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name)
      : shape_(shape), bytes_(without_end_zeros(shape.bytes)), name_(name), faces_(shape.mesh) {}

  Layout run() {
    check_encoding();
    while (position_ < bytes_.size()) read_line();
    if (shape_.mesh.positions.empty()) throw InvalidInput(Place{name_}, "has no vertices (lines 'v x y z')");
    for (References* each : {&vertex_, &texture_, &normal_}) check_references(*each);
    shift_colors();
    add_attributes();
    check_unplaced();
    remove_unplaced(unplaced_, shape_.mesh);
    add_notes();
    layout_.corner_normal = std::move(normal_.corner);
    layout_.normals_ahead = normal_.ahead;
    layout_.unplaced = std::move(unplaced_.rows);
    return std::move(layout_);
  }

 private:
  [[noreturn]] void fail(std::size_t position, const std::string& what) const {
    fail_at_line(name_, bytes_, position, what);
  }

  void check_encoding() {
    position_ = text_begin(bytes_, name_);
    if (const std::size_t zero = bytes_.find('\0'); zero != std::string_view::npos) {
      fail(zero, "a zero byte; this is not OBJ text");
    }
  }

  void read_line() {
    position_ = skip_blanks(bytes_, position_);
    const std::size_t begin = position_;
    position_ = word_end(bytes_, begin);
    const std::string_view keyword = bytes_.substr(begin, position_ - begin);
    if (keyword == "v") {
      read_vertex();
    } else if (keyword == "f") {
      read_face();
    } else if (keyword == "vn") {
      read_normal();
    } else if (keyword == "vt") {
      read_texture();
    } else if (!keyword.empty() && keyword[0] != '#') {
      if (keyword == "call") fail(begin, "the lines of another file belong here (call); put them in its place");
      add_other(keyword);
      if (keyword == "mtllib") add_materials();
    }
    position_ = end_of_line(bytes_, position_) + 1;
  }

  void add_other(std::string_view keyword) {
    constexpr std::size_t most = 64;  // garbage has no end of keywords
    auto& list = layout_.other_keywords;
    if (list.size() < most && std::find(list.begin(), list.end(), keyword) == list.end()) list.emplace_back(keyword);
  }

  // A line joined to this one gives names, too, and is then read for itself, as it is after every line that is passed
  // over: so those who write the file find the same statements.
  void add_materials() {
    const std::size_t rest = position_;
    constexpr std::size_t most = 256;  // bytes of a file's name, and names
    const std::size_t begin = skip_blanks(bytes_, position_);
    std::string_view line = bytes_.substr(begin, end_of_line(bytes_, begin) - begin);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    if (line.size() <= most && layout_.material_files.size() < most) layout_.material_files.emplace_back(line);
    for (std::string_view left = line; left.find('"') != left.npos;) {  // names in quotes, which may have blanks
      left.remove_prefix(left.find('"') + 1);
      const std::size_t end = left.find('"');
      if (end == left.npos) break;
      if (end <= most && layout_.material_files.size() < most) layout_.material_files.emplace_back(left.substr(0, end));
      left.remove_prefix(end + 1);
    }
    for (std::string_view token = next_token(); !token.empty(); token = next_token()) {
      const bool is_name = token != line && token.size() <= most && layout_.material_files.size() < most;
      if (is_name) layout_.material_files.emplace_back(token);
    }
    position_ = rest;
  }

  // The next token of the statement; empty at its end or at a comment.
  std::string_view next_token() {
    position_ = skip_blanks(bytes_, position_);
    const std::size_t begin = position_;
    if (begin < bytes_.size() && bytes_[begin] == '#') return {};
    position_ = word_end(bytes_, begin);
    return bytes_.substr(begin, position_ - begin);
  }

  double parse_number(std::string_view token) const {
    double value = 0;
    const ParseResult result = parse_real(token, value);
    if (result == ParseResult::malformed) fail(position_, in_quotes(token) + " is not a number");
    if (result == ParseResult::overflow)
      fail(position_, in_quotes(token) + " does not fit in a double; repair the file");
    return value;
  }

  // A number that ends with a blank or a line end is read where it stands.
  double next_number(const char* expected) {
    position_ = skip_blanks(bytes_, position_);
    double value = 0;
    const char* const end = bytes_.data() + bytes_.size();
    const auto [stop, error] = float_from_chars(bytes_.data() + position_, end, value);
    if (error == std::errc{} && (stop == end || is_blank(*stop) || is_line_end(*stop))) {
      position_ = static_cast<std::size_t>(stop - bytes_.data());
      return value;
    }
    const std::string_view token = next_token();
    if (token.empty()) fail(position_, std::string("a number is missing; expected ") + expected);
    return parse_number(token);
  }

  Vec3d next_vector(const char* expected) {
    const double x = next_number(expected);
    const double y = next_number(expected);
    return {x, y, next_number(expected)};
  }

  // v x y z [w], v x y z r g b [a], or v x y z w r g b.
  void read_vertex() {
    const Vec3d p = next_vector("'v x y z'");
    if (!is_finite(p)) unplaced_.add(shape_.mesh.vertex_count(), position_);
    vertex_room_.make(shape_.mesh.positions, 1, position_, bytes_.size());
    shape_.mesh.positions.push_back(p);
    ++vertex_.given;
    double more[4] = {};
    std::size_t count = 0;
    for (std::string_view token = next_token(); !token.empty(); token = next_token()) {
      if (count == 4) fail(position_, "more than seven numbers; expected 'v x y z', 'v x y z w' or 'v x y z r g b'");
      more[count++] = parse_number(token);
    }
    if (count == 1) ++weights_;
    if (count == 2) ++pairs_;
    if (count >= 3) add_color(more);
    if (count < 4) return;
    fourth_.push_back(finite_(more[3]));
    are_weights_ = are_weights_ && more[0] == 1;
    are_alphas_ = are_alphas_ && more[3] == 1;
  }

  void add_color(const double* rgb) {
    ++colored_;
    colors_.resize(3 * shape_.mesh.vertex_count() - 3, 1.0);  // white for vertices before that have none
    for (std::size_t i = 0; i < 3; ++i) colors_.push_back(finite_(rgb[i]));
  }

  // Seven numbers on every line are x y z w r g b where each w is 1, and not each of the last ones.
  void shift_colors() {
    if (fourth_.empty()) return;
    const bool is_shifted = fourth_.size() == vertex_.given && are_weights_ && !are_alphas_;
    shape_.notes.emplace_back(is_shifted ? "vertices have seven numbers, which are read as x y z w r g b"
                                         : "vertices have seven numbers, which are read as x y z r g b a");
    for (std::size_t v = 0; v < fourth_.size() && is_shifted; ++v) {
      std::copy_n(colors_.begin() + static_cast<std::ptrdiff_t>(3 * v + 1), 2,
                  colors_.begin() + static_cast<std::ptrdiff_t>(3 * v));
      colors_[3 * v + 2] = fourth_[v];
    }
  }

  void read_texture() {
    double uv[2] = {next_number("'vt u v'"), 0};
    if (const std::string_view token = next_token(); !token.empty()) uv[1] = parse_number(token);
    textures_.push_back(finite_(uv[0]));
    textures_.push_back(finite_(uv[1]));
    ++texture_.given;
  }

  void read_normal() {
    const Vec3d n = next_vector("'vn x y z'");
    layout_.normals.push_back({finite_(n.x), finite_(n.y), finite_(n.z)});
    ++normal_.given;
  }

  void read_face() {
    face_.clear();
    face_textures_.clear();
    face_normals_.clear();
    while (read_plain_corner()) continue;
    for (std::string_view token = next_token(); !token.empty(); token = next_token()) read_corner(token);
    Mesh& mesh = shape_.mesh;
    corner_room_.make(mesh.corner_vertex, face_.size(), position_, bytes_.size());
    face_room_.make(mesh.face_begin, 1, position_, bytes_.size());
    const std::size_t corners = mesh.corner_vertex.size();
    if (!faces_.add(face_)) return;
    add_references(texture_, corners, face_textures_);
    add_references(normal_, corners, face_normals_);
  }

  // What the corners of a face that was added refer to; `before` is how many corners there were before it.
  void add_references(References& to, std::size_t before, const std::vector<std::uint32_t>& of_face) const {
    if (to.corner.empty() && of_face.empty()) return;
    to.corner.resize(before, kNoNormal);
    to.corner.insert(to.corner.end(), of_face.begin(), of_face.end());
    to.corner.resize(shape_.mesh.corner_vertex.size(), kNoNormal);
  }

  // A corner that is a vertex's number and nothing else, which most files have; false where the next word is no such.
  bool read_plain_corner() {
    std::size_t i = skip_blanks(bytes_, position_);
    std::size_t index = 0;
    const std::size_t begin = i;
    for (; i < bytes_.size() && i < begin + 9 && bytes_[i] >= '0' && bytes_[i] <= '9'; ++i) {
      index = index * 10 + static_cast<std::size_t>(bytes_[i] - '0');
    }
    if (index == 0 || i == bytes_.size() || !(is_blank(bytes_[i]) || is_line_end(bytes_[i]))) return false;
    position_ = i;
    face_.push_back(referred(index, vertex_));
    return true;
  }

  // v, v/vt, v//vn or v/vt/vn.
  void read_corner(std::string_view token) {
    const std::string_view whole = token;
    std::string_view part[3];
    std::size_t parts = 0;
    for (bool more = true; more;) {
      if (parts == 3) fail(position_, in_quotes(whole) + " is no corner; expected v, v/vt, v//vn or v/vt/vn");
      const std::size_t slash = token.find('/');
      part[parts++] = token.substr(0, slash);
      more = slash != std::string_view::npos;
      token = more ? token.substr(slash + 1) : std::string_view{};
    }
    face_.push_back(resolve(part[0], vertex_, whole));
    if (!part[1].empty()) put_reference(face_textures_, resolve(part[1], texture_, whole));
    if (!part[2].empty()) put_reference(face_normals_, resolve(part[2], normal_, whole));
  }

  // For the corner of the face that was read last.
  void put_reference(std::vector<std::uint32_t>& of_face, std::uint32_t reference) const {
    of_face.resize(face_.size() - 1, kNoNormal);
    of_face.push_back(reference);
  }

  std::uint32_t referred(std::size_t index, References& to) const {
    if (index > to.given) to.ahead = true;
    if (index > to.largest) {
      to.largest = index;
      to.largest_position = position_;
    }
    return static_cast<std::uint32_t>(index - 1);
  }

  std::uint32_t resolve(std::string_view text, References& to, std::string_view whole) {
    std::int64_t index = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, index);
    if (error == std::errc::invalid_argument || stop != end)
      fail(position_, in_quotes(whole) + " is no corner of a face");
    const auto given = static_cast<std::int64_t>(to.given);
    if (to.optional && given == 0 && error == std::errc{} && index < 0) {
      if (to.dangling++ == 0) to.dangling_position = position_;
      return kNoNormal;
    }
    if (error != std::errc{} || index == 0 || index < -given || index >= std::int64_t{kMaxElements}) {
      fail(position_, std::string("index ") + std::string(text.substr(0, 24)) + " of a " + to.what +
                          " is out of range (" + std::to_string(given) + " so far, counted from 1); repair the file");
    }
    return referred(static_cast<std::size_t>(index > 0 ? index : given + index + 1), to);
  }

  // Faces may stand before what they refer to, so that only the end of the file tells what is out of range.
  void check_references(References& to) {
    if (to.optional && to.given == 0 && (to.largest > 0 || to.dangling > 0)) {
      shape_.notes.push_back(std::string("faces refer to ") + to.what +
                             "s, of which the file has none; they are read without");
      to = {to.what};
    }
    if (to.dangling > 0) {
      fail(to.dangling_position,
           std::string("a negative index of a ") + to.what + " stands before the first of them; repair the file");
    }
    if (to.largest <= to.given) return;
    fail(to.largest_position, "index " + std::to_string(to.largest) + " of a " + to.what +
                                  " is out of range (the file has " + std::to_string(to.given) + "); repair the file");
  }

  void check_unplaced() const {
    if (const std::optional<std::size_t> used = first_used(unplaced_, shape_.mesh)) {
      fail(unplaced_.begin[*used], "a coordinate is not finite, and a face uses the vertex; repair the file");
    }
    if (unplaced_.rows.size() < shape_.mesh.vertex_count()) return;
    throw InvalidInput(Place{name_}, "no vertex has finite coordinates; there is no shape in it");
  }

  // An attribute of corners, from the values that they refer to; corners without a reference have 0.
  void add_corner_attribute(const char* attribute, std::size_t n, const std::vector<std::uint32_t>& corner,
                            const std::vector<double>& values) {
    if (corner.empty()) return;
    Attribute result{attribute, Domain::corner, NumberType::float32, static_cast<int>(n), {}};
    result.values.resize(corner.size() * n, 0.0);
    std::size_t without = 0;
    for (std::size_t c = 0; c < corner.size(); ++c) {
      if (corner[c] == kNoNormal) ++without;
      for (std::size_t i = 0; i < n && corner[c] != kNoNormal; ++i)
        result.values[c * n + i] = values[corner[c] * n + i];
    }
    if (without > 0) {
      shape_.notes.push_back(counted(without, "corner of a face has no ", "corners of faces have no ") + attribute);
    }
    shape_.mesh.attributes.push_back(std::move(result));
  }

  void add_attributes() {
    std::vector<double> normals;
    for (const Vec3d& n : layout_.normals) normals.insert(normals.end(), {n.x, n.y, n.z});
    add_corner_attribute("normal", 3, normal_.corner, normals);
    add_corner_attribute("uv", 2, texture_.corner, textures_);
    if (colored_ == 0) return;
    colors_.resize(3 * shape_.mesh.vertex_count(), 1.0);
    shape_.mesh.attributes.push_back({"color", Domain::vertex, NumberType::float32, 3, std::move(colors_)});
  }

  void add_notes() {
    faces_.append_notes(shape_.notes);
    if (!unplaced_.rows.empty()) shape_.notes.push_back(unplaced_note(unplaced_.rows.size()));
    const std::size_t zeros = shape_.bytes.size() - bytes_.size();
    if (zeros > 0) shape_.notes.push_back(counted(zeros, "zero byte ends the file", "zero bytes end the file"));
    const auto say = [&](std::size_t count, const char* one, const char* many) {
      if (count > 0) shape_.notes.push_back(counted(count, one, many));
    };
    say(weights_, "vertex has a weight, which is kept but not applied",
        "vertices have a weight, which is kept but not applied");
    say(pairs_, "vertex has two numbers after x y z, which are kept but not read",
        "vertices have two numbers after x y z, which are kept but not read");
    say(colored_ > 0 ? vertex_.given - colored_ : 0, "vertex has no color and is read as white",
        "vertices have no color and are read as white");
    finite_.append_note(shape_.notes);
    if (shape_.mesh.face_count() == 0) shape_.notes.emplace_back(kCloudNote);
  }

  ShapeFile& shape_;
  std::string_view bytes_;
  const std::string& name_;
  FaceBuilder faces_;
  RoomAhead vertex_room_;
  RoomAhead corner_room_;
  RoomAhead face_room_;
  Layout layout_;
  std::size_t position_ = 0;
  Unplaced unplaced_;
  References vertex_{.what = "vertex", .optional = false};
  References texture_{"texture coordinate"};
  References normal_{"normal"};
  std::vector<double> textures_;
  std::vector<double> colors_;
  std::vector<std::uint32_t> face_;
  std::vector<std::uint32_t> face_textures_;
  std::vector<std::uint32_t> face_normals_;
  std::size_t colored_ = 0;
  std::size_t weights_ = 0;
  std::size_t pairs_ = 0;
  std::vector<double> fourth_;  // numbers after x y z
  bool are_weights_ = true;     // of lines with seven numbers the fourth
  bool are_alphas_ = true;      // and the last
  FiniteValues finite_;
};

}  // namespace

std::size_t first_byte(std::string_view bytes) { return bytes.substr(0, 3) == "\xef\xbb\xbf" ? 3 : 0; }

std::size_t skip_blanks(std::string_view bytes, std::size_t position) {
  while (position < bytes.size()) {
    if (is_blank(bytes[position])) {
      ++position;
    } else if (const std::size_t joined = joined_length(bytes, position); joined > 0) {
      position += joined;
    } else {
      break;
    }
  }
  return position;
}

std::size_t end_of_line(std::string_view bytes, std::size_t position) {
  while (position < bytes.size() && !is_line_end(bytes[position])) ++position;
  return position;
}

std::size_t word_end(std::string_view bytes, std::size_t position) {
  while (position < bytes.size() && !is_blank(bytes[position]) && !is_line_end(bytes[position]) &&
         joined_length(bytes, position) == 0) {
    ++position;
  }
  return position;
}

void read(ShapeFile& shape, const std::string& name) { set_layout(shape, Reader(shape, name).run()); }

}  // namespace knead::detail::obj
