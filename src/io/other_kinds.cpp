// Recognises files that are not what their names say, for messages.
#include <algorithm>
#include <array>

#include "io/codec.h"
#include "io/text.h"

namespace knead::detail {
namespace {

// What files of a kind that is not read begin with.
struct Kind {
  std::string_view begin;
  const char* what;
};

constexpr std::array kNotRead{
    Kind{"PK\x03\x04",
         "is a ZIP archive; unpack it and name the shape in it, or let the name of a 3MF file end in .3mf"},
    Kind{"\x1f\x8b", "is compressed by gzip; let its name end in .gz"},
    Kind{"%PDF", "is a PDF document; name the file of the shape"},
    Kind{"Kaydara FBX", "is an FBX file, which is not read; export it as .glb, .obj or .ply"},
    Kind{"; FBX", "is an FBX file, which is not read; export it as .glb, .obj or .ply"},
    Kind{"BLENDER", "is a file of Blender; export it as .glb, .obj or .ply"},
    Kind{"# vtk DataFile", "is a VTK file, which is not read; write it as .ply, or a volume mesh as .msh"},
    Kind{"ISO-10303-21", "is a STEP file, which holds no triangles; export it as .stl"},
    Kind{"#VRML", "is a VRML file, which is not read; export it as .glb, .obj or .ply"},
    Kind{"#X3D", "is an X3D file, which is not read; export it as .glb, .obj or .ply"},
    Kind{"<", "is an XML file, as those of COLLADA, X3D and VTK, which are not read; export it as .glb, .obj or .ply"},
    Kind{"LASF", "is a LAS file, which is not read; convert it to .ply or .pcd"},
    Kind{"\x89HDF", "is an HDF5 file, as those of CGNS and MED, which are not read; convert it to .msh"},
    Kind{"CDF", "is a NetCDF file, as those of Exodus, which are not read; convert it to .msh"},
    Kind{"MeshVersionFormatted", "is a mesh of Medit, which is not read; convert it to .msh"},
};

// Calls use(words) for the lines of a text that have words and are no comments, until it returns false. The last line
// may be cut.
template <class Use>
void for_each_line(std::string_view head, const std::string& name, const Use& use) {
  TextCursor text(head, name);
  do {
    std::vector<std::string_view> words;
    for (std::string_view word = text.next_on_line(); !word.empty(); word = text.next_on_line()) words.push_back(word);
    if (text.position() >= head.size() || (!words.empty() && !use(words))) return;
  } while (text.next_line());
}

bool are_reals(const std::vector<std::string_view>& words, std::size_t from, std::size_t count) {
  double value = 0;
  if (words.size() < from + count) return false;
  return std::all_of(words.begin() + static_cast<std::ptrdiff_t>(from),
                     words.begin() + static_cast<std::ptrdiff_t>(from + count),
                     [&](std::string_view word) { return parse_real(word, value) == ParseResult::ok; });
}

bool is_binary_stl(std::string_view head, std::size_t size) {
  constexpr std::size_t header = 80;
  constexpr std::size_t triangle = 50;
  if (head.size() <= header + 4 || (size - header - 4) % triangle != 0) return false;
  const std::string name;
  return ByteCursor(head.substr(header), name).take<std::uint32_t>("") == (size - header - 4) / triangle;
}

// A keyword such as COFF, before which only its letters stand.
bool is_off_keyword(std::string_view word) {
  return word.ends_with("OFF") && word.find_first_not_of("STCN4n") == word.size() - 3;
}

// The format whose files begin so; empty: none that is known.
std::string_view format_beginning(std::string_view head, std::size_t size) {
  const std::string name;
  const std::string text = upper(head);
  const auto has = [&](std::string_view part) { return text.find(part) != text.npos; };
  TextCursor words(head, name);
  const std::string_view first = words.next();
  const std::string_view second = words.next();
  if (head.starts_with("glTF")) return "glb";
  if (head.starts_with("PK\x03\x04") && head.find("3dmodel") != head.npos) return "3mf";
  if (first == "ply") return "ply";
  if (first == "solid" && has("FACET")) return "stl";
  if (is_off_keyword(first)) return "off";
  if (has("FIELDS") && has("VIEWPOINT")) return "pcd";
  if (first.starts_with('{') && has("\"ASSET\"")) return "gltf";
  if (first == "$MeshFormat") return "msh";
  if (has("FOAMFILE")) return "foam";
  if (has("NDIME")) return "su2";
  if (first == "-1" && is_digits(second) && second.size() <= 4) return "unv";
  if (has("BEGIN BULK") || text.starts_with("GRID")) return "bdf";
  if (has("*HEADING") || text.starts_with("*NODE")) return "inp";
  if (looks_like_obj(head)) return "obj";
  return is_binary_stl(head, size) ? "stl" : "";
}

}  // namespace

std::optional<std::string> stand_in(std::string_view bytes) {
  if (bytes.starts_with("version https://git-lfs.github.com/spec/")) {
    return "is a pointer of Git LFS, not the file itself; run git lfs pull";
  }
  constexpr std::size_t most = 256;
  const std::size_t begin = std::min(bytes.find_first_not_of("\xef\xbb\xbf \t\r\n"), bytes.size());
  const std::string text = upper(bytes.substr(begin, most));
  const bool is_page = text.starts_with("<!DOCTYPE HTML") || text.starts_with("<HTML");
  if (!is_page) return std::nullopt;
  return "is a web page, perhaps one that says why there is no file; download the file itself";
}

bool looks_like_obj(std::string_view head) {
  constexpr std::array<std::string_view, 11> keywords{"v", "vt", "vn", "vp",     "f",     "l",
                                                      "p", "o",  "g",  "usemtl", "mtllib"};
  std::size_t vertices = 0;
  std::size_t other = 0;
  for_each_line(head, "", [&](const std::vector<std::string_view>& words) {
    if (words[0] == "v" && are_reals(words, 1, 3)) {
      ++vertices;
    } else if (words[0] != "s" && std::find(keywords.begin(), keywords.end(), words[0]) == keywords.end()) {
      ++other;
    }
    return other == 0;
  });
  return vertices > 0 && other == 0;
}

std::optional<std::string> other_kind(std::string_view head, std::size_t size, std::string_view format) {
  const std::string_view own = format_beginning(head, size);
  if (own == format || (format == "3mf" && head.starts_with("PK"))) return std::nullopt;
  for (const Kind& kind : kNotRead) {
    if (own.empty() && head.starts_with(kind.begin)) return kind.what;
  }
  const bool is_fluent = head.size() > 1 && head[0] == '(' && is_digits(head.substr(1, 1));
  if (is_fluent) return "is a mesh of Fluent, which is not read; convert it to gmsh's format, version 2.2 or 4.1";
  if (head.starts_with("{\"knead\"")) return "is a session, not a shape; name the shape before it";
  if (own.empty()) return std::nullopt;
  const std::string name = upper(own);
  const bool has_vowel = std::string_view("OMSI").find(name[0]) != std::string_view::npos;
  return std::string(has_vowel ? "is an " : "is a ") + name + " file by another name; let its name end in ." +
         std::string(own);
}

}  // namespace knead::detail
