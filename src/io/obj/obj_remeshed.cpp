// Writing an OBJ file with its lines and another mesh.
#include <algorithm>
#include <array>
#include <map>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/obj/obj.h"
#include "io/text.h"
#include "math/system.h"

namespace knead::detail::obj {
namespace {

// Lines that name vertices, or belong to the curves and surfaces that do (appendix B1); they are left out.
constexpr std::array<std::string_view, 25> kNaming = {
    "p",      "l",   "fo",   "vp",   "curv", "curv2", "surf", "parm", "trim", "hole",  "scrv",  "sp", "end",
    "cstype", "deg", "bmat", "step", "bsp",  "bzp",   "cdc",  "cdp",  "res",  "ctech", "stech", "con"};

// Lines that hold for the faces after them.
constexpr std::array<std::string_view, 4> kGrouping = {"usemtl", "g", "o", "s"};

bool is_naming(std::string_view keyword) { return std::find(kNaming.begin(), kNaming.end(), keyword) != kNaming.end(); }

enum class Kind { other, vertex, texture, normal, face, naming };

Kind kind_of(std::string_view keyword) {
  if (keyword == "v") return Kind::vertex;
  if (keyword == "vt") return Kind::texture;
  if (keyword == "vn") return Kind::normal;
  if (keyword == "f") return Kind::face;
  return is_naming(keyword) ? Kind::naming : Kind::other;
}

// A statement as the reader takes it.
struct Statement {
  Kind kind = Kind::other;
  std::size_t begin = 0;
  std::size_t end = 0;       // after its line end
  std::size_t words = 0;     // after the keyword, those that the reader takes
  std::size_t textured = 0;  // corners of a face that have texture coordinates, and normals
  std::size_t normal = 0;
  bool is_deep = false;  // a third texture coordinate that is not 0
};

// Walks through the statements as the reader does.
class Statements {
 public:
  explicit Statements(std::string_view bytes) : bytes_(bytes), position_(first_byte(bytes)) {}

  // False at the end of the file.
  bool next(Statement& statement) {
    if (position_ >= bytes_.size()) return false;
    statement = {};
    statement.begin = position_;
    position_ = skip_blanks(bytes_, position_);
    const std::size_t begin = position_;
    position_ = word_end(bytes_, begin);
    statement.kind = kind_of(bytes_.substr(begin, position_ - begin));
    // What a line that was joined to the one before begins with is no keyword, unless the reader took it for one.
    const bool may_go_on = last_ != Kind::other && last_ != Kind::vertex && last_ != Kind::face;
    if (joined_ && may_go_on && statement.kind == Kind::other) {
      statement.kind = last_;  // whose words were taken before
    } else {
      take_words(statement);
      if (statement.kind == Kind::texture) statement.is_deep = has_depth();
    }
    last_ = statement.kind;
    const std::size_t end = end_of_line(bytes_, position_);
    joined_ = end > statement.begin && bytes_[end - 1] == '\\';
    position_ = std::min(end + 1, bytes_.size());
    const bool is_pair = end < bytes_.size() && bytes_[end] == '\r' && position_ < bytes_.size();
    if (is_pair && bytes_[position_] == '\n') ++position_;
    statement.end = position_;
    return true;
  }

 private:
  bool has_depth() const {
    const std::size_t begin = skip_blanks(bytes_, position_);
    double value = 0;
    parse_real(bytes_.substr(begin, word_end(bytes_, begin) - begin), value);
    return value != 0;
  }

  void take_words(Statement& statement) {
    if (statement.kind == Kind::other || statement.kind == Kind::naming) return;
    const std::size_t most = statement.kind == Kind::normal ? 3 : (statement.kind == Kind::texture ? 2 : bytes_.size());
    while (statement.words < most) {
      const std::size_t begin = skip_blanks(bytes_, position_);
      const std::size_t end = begin < bytes_.size() && bytes_[begin] == '#' ? begin : word_end(bytes_, begin);
      position_ = end;
      if (begin == end) return;
      ++statement.words;
      if (statement.kind == Kind::face) count_references(bytes_.substr(begin, end - begin), statement);
    }
  }

  // v/vt, v//vn or v/vt/vn.
  static void count_references(std::string_view corner, Statement& statement) {
    const std::size_t first = corner.find('/');
    if (first == std::string_view::npos) return;
    const std::size_t second = std::min(corner.find('/', first + 1), corner.size());
    if (second > first + 1) ++statement.textured;
    if (corner.size() > second + 1) ++statement.normal;
  }

  std::string_view bytes_;
  std::size_t position_;
  bool joined_ = false;
  Kind last_ = Kind::other;
};

// How many corners of a face of the source refer to something.
enum class Reference : std::uint8_t { none, some, all };

Reference reference_of(std::size_t corners, std::size_t referring) {
  if (referring == 0) return Reference::none;
  return referring < corners ? Reference::some : Reference::all;
}

class Writer {
 public:
  Writer(const NewMesh& shape, std::optional<int> decimals)
      : decimals_(decimals),
        bytes_(without_end_zeros(shape.source.bytes)),
        rest_(std::string_view(shape.source.bytes).substr(bytes_.size())),
        mesh_(shape.mesh),
        face_source_(shape.face_source),
        new_faces_(shape.face_source, shape.source.mesh.face_count()),
        line_end_(line_end_of(bytes_)) {}

  std::string run() {
    read_references();
    uv_ = lines<2>("uv", "vt", textured_);
    normal_ = lines<3>("normal", "vn", with_normals_);
    reserve_large(result_, bytes_.size() + mesh_.vertex_count() * 40 + mesh_.face_count() * 24);
    result_.append(bytes_, 0, first_byte(bytes_));
    Statements statements(bytes_);
    bool is_written = false;
    std::size_t face = 0;
    for (Statement s; statements.next(s);) {
      if (s.kind == Kind::other) {
        result_.append(bytes_, s.begin, s.end - s.begin);
        continue;
      }
      end_line();
      if (!is_written) append_numbers();
      is_written = true;
      if (s.kind != Kind::face || s.words < 3) continue;
      for (const std::uint32_t f : new_faces_.of(face)) append_face(f);
      ++face;
    }
    result_ += rest_;
    return std::move(result_);
  }

 private:
  // Which faces of the source have texture coordinates and normals.
  void read_references() {
    Statements statements(bytes_);
    for (Statement s; statements.next(s);) {
      if (s.kind != Kind::face || s.words < 3) continue;
      textured_.push_back(reference_of(s.words, s.textured));
      with_normals_.push_back(reference_of(s.words, s.normal));
    }
  }

  // Where only some corners of a face have a value, the others' is 0: of texture coordinates as good as any, of normals
  // none.
  template <std::size_t N>
  Lines lines(const char* attribute, const char* keyword, const std::vector<Reference>& references) const {
    std::size_t face = 0;
    return value_lines<N>(mesh_, attribute, keyword, line_end_, [&](std::size_t corner, const auto& values) {
      while (corner >= mesh_.face_begin[face + 1]) ++face;
      const Reference reference = references[face_source_[face]];
      const bool is_zero = std::all_of(values.begin(), values.end(), [](double value) { return value == 0; });
      return reference == Reference::all || (reference == Reference::some && !(N == 3 && is_zero));
    });
  }

  // The last line of a file may have none.
  void end_line() {
    if (!result_.empty() && !is_line_end(result_.back()) && result_.size() > first_byte(bytes_)) {
      result_ += line_end_;
    }
  }

  void append_numbers() {
    const Attribute* color = mesh_.find_attribute("color");
    for (std::size_t i = 0; i < mesh_.vertex_count(); ++i) {
      const Vec3d& p = mesh_.positions[i];
      append_vector(result_, "v", std::array{p.x, p.y, p.z}.data(), 3, decimals_);
      if (color != nullptr) append_vector(result_, "", color->values.data() + 3 * i, 3);
      result_ += line_end_;
    }
    result_ += uv_.text;
    result_ += normal_.text;
  }

  void append_face(std::uint32_t f) {
    result_ += 'f';
    for (std::uint32_t c = mesh_.face_begin[f]; c < mesh_.face_begin[f + 1]; ++c) {
      const std::size_t uv = uv_.corner_line.empty() ? 0 : uv_.corner_line[c];
      const std::size_t normal = normal_.corner_line.empty() ? 0 : normal_.corner_line[c];
      result_ += ' ' + std::to_string(mesh_.corner_vertex[c] + std::size_t{1});
      if (uv > 0 || normal > 0) result_ += '/';
      if (uv > 0) result_ += std::to_string(uv);
      if (normal > 0) result_ += '/' + std::to_string(normal);
    }
    result_ += line_end_;
  }

  std::optional<int> decimals_;
  std::string_view bytes_;
  std::string_view rest_;  // zero bytes
  const Mesh& mesh_;
  std::span<const std::uint32_t> face_source_;
  BySource new_faces_;
  std::string_view line_end_;
  std::vector<Reference> textured_;  // of each face of the source
  std::vector<Reference> with_normals_;
  Lines uv_;
  Lines normal_;
  std::string result_;
};

}  // namespace

std::string remeshed(const NewMesh& shape, const WriteOptions& options) {
  return Writer(shape, options.decimals).run();
}

std::vector<std::uint32_t> face_labels(const ShapeFile& source) {
  std::vector<std::uint32_t> labels;
  std::map<std::string, std::uint32_t> known;
  std::array<std::string, kGrouping.size()> state;  // the last line of each keyword
  Statements statements(without_end_zeros(source.bytes));
  for (Statement s; statements.next(s);) {
    if (s.kind == Kind::other) {
      const std::size_t begin = skip_blanks(source.bytes, s.begin);
      const std::size_t end = word_end(source.bytes, begin);
      const auto keyword = std::find(kGrouping.begin(), kGrouping.end(), source.bytes.substr(begin, end - begin));
      if (keyword == kGrouping.end()) continue;
      state[static_cast<std::size_t>(keyword - kGrouping.begin())] = source.bytes.substr(begin, s.end - begin);
    } else if (s.kind == Kind::face && s.words >= 3) {
      std::string all;
      for (const std::string& line : state) all += line + '\n';
      labels.push_back(known.try_emplace(all, static_cast<std::uint32_t>(known.size())).first->second);
    }
  }
  return labels;
}

std::vector<std::string> remesh_losses(const ShapeFile& source) {
  std::vector<std::string> losses;
  bool weights = false;
  bool alphas = false;
  bool depths = false;
  Statements statements(without_end_zeros(source.bytes));
  for (Statement s; statements.next(s);) {
    if (s.kind == Kind::vertex) weights = weights || s.words == 4;
    if (s.kind == Kind::vertex) alphas = alphas || s.words == 7;
    depths = depths || s.is_deep;
  }
  if (weights) losses.emplace_back("weights of vertices are left out");
  if (alphas) losses.emplace_back("the alpha of colors is left out");
  if (depths) losses.emplace_back("third texture coordinates are left out");
  for (const std::string& keyword : layout_of<Layout>(source).other_keywords) {
    if (is_naming(keyword)) losses.push_back("lines '" + keyword + "' are left out");
  }
  const std::size_t unplaced = layout_of<Layout>(source).unplaced.size();
  if (unplaced > 0) losses.push_back(unplaced_loss(unplaced));
  return losses;
}

}  // namespace knead::detail::obj
