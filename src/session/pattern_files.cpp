// Text, pictures and meshes as the patterns of prints. FreeType draws letters, in a browser its canvas; stb reads
// pictures.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "io/picture.h"
#include "io/text.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "session/stroke_run.h"
#include "strokes/print.h"

#if defined(KNEAD_HAS_FREETYPE)
#include <ft2build.h>
#include FT_FREETYPE_H
#elif defined(__EMSCRIPTEN__)
#include <emscripten.h>
#endif

namespace knead::detail {

namespace {

namespace fs = std::filesystem;

#if defined(KNEAD_HAS_STB)
GreyPattern read_picture(const fs::path& file) {
  const std::optional<Pixels<std::uint16_t>> pixels = read_greys(read_text(file));
  if (!pixels) {
    throw InvalidInput(fmt::format("\"file\": {} is no picture that can be read ({}); write it as a grey PNG",
                                   file.string(), picture_trouble()));
  }
  const auto& [width, height, numbers] = *pixels;
  GreyTile tile{width, height, {}, -0.5 * width, 0.5 * height};
  constexpr float kWhite = 65535;
  tile.values.reserve(numbers.size() / 2);
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    const float grey = static_cast<float>(numbers[i]) / kWhite;
    tile.values.push_back(grey * (static_cast<float>(numbers[i + 1]) / kWhite));
  }
  return {{std::move(tile)}, static_cast<double>(height)};
}
#else
GreyPattern read_picture(const fs::path& /*file*/) {
  throw InvalidInput("\"file\": this Knead was built without stb, and reads no pictures; print a mesh or a text");
}
#endif

[[maybe_unused]] constexpr int kPixelsOfText = 256;  // of the font's size

#if defined(KNEAD_HAS_FREETYPE)

// Letters and digits only, which tell fonts apart.
std::string font_key(std::string_view name) {
  std::string key;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) key += c;
  }
  return lower(key);
}

std::vector<fs::path> font_folders() {
  std::vector<fs::path> folders{"/usr/share/fonts", "/usr/local/share/fonts", "/System/Library/Fonts", "/Library/Fonts",
                                "C:/Windows/Fonts"};
  if (const char* const home = std::getenv("HOME")) {
    for (const char* const own : {".local/share/fonts", ".fonts", "Library/Fonts"})
      folders.push_back(fs::path(home) / own);
  }
  return folders;
}

// Returns the files of fonts in the usual folders, by their paths.
std::vector<fs::path> all_fonts() {
  std::vector<fs::path> files;
  for (const fs::path& folder : font_folders()) {
    std::error_code error;
    fs::recursive_directory_iterator each(folder, fs::directory_options::skip_permission_denied, error);
    for (; !error && each != fs::recursive_directory_iterator(); each.increment(error)) {
      const std::string type = lower(each->path().extension().string());
      if (type == ".ttf" || type == ".otf" || type == ".ttc") files.push_back(each->path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Returns the first file, by its path, of a font of one of these names; of the first name that there is.
std::optional<fs::path> find_font(const std::vector<std::string>& names) {
  const std::vector<fs::path> files = all_fonts();
  for (const std::string& name : names) {
    for (const fs::path& file : files) {
      const std::string key = font_key(file.stem().string());
      if (key == name || key == name + "regular") return file;
    }
  }
  return std::nullopt;
}

fs::path font_file(const std::string& font, const fs::path& folder) {
  if (font.empty()) {
    const auto usual = find_font({"dejavusansbold", "liberationsansbold", "arialbold", "arialbd", "helvetica"});
    if (!usual)
      throw InvalidInput("\"font\": no usual font was found on this computer; give the path of a font's file");
    return *usual;
  }
  std::error_code error;
  if (fs::is_regular_file(folder / font, error)) return folder / font;
  const auto named = find_font({font_key(font)});
  if (!named) {
    throw InvalidInput(
        fmt::format("\"font\": there is no file {}, and no font of that name in the usual folders; give "
                    "the path of a TTF or OTF file",
                    font));
  }
  return *named;
}

// A face of FreeType, and the library that it belongs to.
class Font {
 public:
  explicit Font(const fs::path& file) : name_(file.string()) {
    if (FT_Init_FreeType(&library_) != 0) throw InvalidInput("\"font\": FreeType does not start");
    if (FT_New_Face(library_, name_.c_str(), 0, &face_) != 0 || FT_Set_Pixel_Sizes(face_, 0, kPixelsOfText) != 0) {
      FT_Done_FreeType(library_);
      throw InvalidInput(fmt::format("\"font\": {} is no font with outlines that can be read", name_));
    }
  }
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;
  Font(Font&&) = delete;
  Font& operator=(Font&&) = delete;
  ~Font() { FT_Done_FreeType(library_); }  // and its faces

  // Draws a letter, with its left and upper edge about where the pen is, and moves the pen on.
  GreyTile draw(char32_t letter, double& pen) {
    const FT_UInt glyph = FT_Get_Char_Index(face_, letter);
    if (glyph == 0) {
      throw InvalidInput(fmt::format("\"text\": the font {} lacks the character U+{:04X}; choose another font", name_,
                                     static_cast<std::uint32_t>(letter)));
    }
    FT_Vector kerning{};
    if (last_ != 0) FT_Get_Kerning(face_, last_, glyph, FT_KERNING_UNFITTED, &kerning);
    last_ = glyph;
    pen += static_cast<double>(kerning.x) / 64;
    if (FT_Load_Glyph(face_, glyph, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) != 0 ||
        FT_Render_Glyph(face_->glyph, FT_RENDER_MODE_NORMAL) != 0) {
      throw InvalidInput(fmt::format("\"font\": {} has a broken letter", name_));
    }
    const FT_Bitmap& bitmap = face_->glyph->bitmap;
    GreyTile tile{static_cast<int>(bitmap.width),
                  static_cast<int>(bitmap.rows),
                  {},
                  pen + face_->glyph->bitmap_left,
                  1.0 * face_->glyph->bitmap_top};
    for (unsigned row = 0; row < bitmap.rows; ++row) {
      const unsigned char* const line = bitmap.buffer + static_cast<std::ptrdiff_t>(row) * bitmap.pitch;
      for (unsigned column = 0; column < bitmap.width; ++column)
        tile.values.push_back(static_cast<float>(line[column]) / 255);
    }
    pen += static_cast<double>(face_->glyph->linearHoriAdvance) / 65536;
    return tile;
  }

 private:
  std::string name_;
  FT_Library library_ = nullptr;
  FT_Face face_ = nullptr;
  FT_UInt last_ = 0;
};

#elif defined(__EMSCRIPTEN__)
// clang-format off
// Draws a letter on a canvas of the browser, which knows its fonts. Writes the width and height of the pixels, their
// left and upper edge about the pen, and how far the pen goes on. Returns 0 where there is no canvas, or no room.
EM_JS(int, draw_letter, (int letter, const char* font, int length, int size, float* place, unsigned char* pixels, int room), {
  if (typeof OffscreenCanvas === 'undefined') return 0;
  const name = new TextDecoder().decode(HEAPU8.slice(font, font + length));
  const text = String.fromCodePoint(letter);
  const canvas = new OffscreenCanvas(1, 1);
  const pen = canvas.getContext('2d');
  const style = 'bold ' + size + 'px ' + (name ? JSON.stringify(name) + ', ' : "") + 'sans-serif';
  pen.font = style;
  const box = pen.measureText(text);
  const left = Math.ceil(box.actualBoundingBoxLeft) + 1;
  const above = Math.ceil(box.actualBoundingBoxAscent) + 1;
  canvas.width = Math.max(1, left + Math.ceil(box.actualBoundingBoxRight) + 1);
  canvas.height = Math.max(1, above + Math.ceil(box.actualBoundingBoxDescent) + 1);
  if (canvas.width * canvas.height > room) return 0;
  pen.font = style;
  pen.fillText(text, left, above);
  const colours = pen.getImageData(0, 0, canvas.width, canvas.height).data;
  for (let i = 0; 4 * i < colours.length; ++i) HEAPU8[pixels + i] = colours[4 * i + 3];
  HEAPF32.set([canvas.width, canvas.height, -left, above, box.width], place >> 2);
  return 1;
});
// clang-format on

std::vector<fs::path> all_fonts() { return {}; }

std::string font_file(const std::string& font, const fs::path& /*folder*/) { return font; }

// A font of the browser.
class Font {
 public:
  explicit Font(std::string name) : name_(std::move(name)) {}

  GreyTile draw(char32_t letter, double& pen) {
    constexpr std::size_t kRoom = std::size_t{16} * kPixelsOfText * kPixelsOfText;
    std::array<float, 5> place{};
    std::vector<unsigned char> pixels(kRoom);
    if (draw_letter(static_cast<int>(letter), name_.data(), static_cast<int>(name_.size()), kPixelsOfText, place.data(),
                    pixels.data(), static_cast<int>(kRoom)) == 0) {
      throw InvalidInput("\"text\": no canvas draws letters here; print a picture or a mesh");
    }
    GreyTile tile{static_cast<int>(place[0]),
                  static_cast<int>(place[1]),
                  {},
                  pen + static_cast<double>(place[2]),
                  static_cast<double>(place[3])};
    pixels.resize(static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height));
    if (std::any_of(pixels.begin(), pixels.end(), [](unsigned char grey) { return grey > 0; })) {
      for (const unsigned char grey : pixels) tile.values.push_back(static_cast<float>(grey) / 255);
    }
    pen += static_cast<double>(place[4]);
    return tile;
  }

 private:
  std::string name_;
};
#endif

#if defined(KNEAD_HAS_FREETYPE) || defined(__EMSCRIPTEN__)
// Returns the code points of UTF-8.
std::vector<char32_t> code_points(std::string_view text) {
  std::vector<char32_t> points;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i++]);
    const int more = lead < 0x80 ? 0 : lead >> 5 == 6 ? 1 : lead >> 4 == 14 ? 2 : lead >> 3 == 30 ? 3 : -1;
    char32_t point = more <= 0 ? lead : lead & (0x3fU >> more);
    for (int k = 0; k < more; ++k) {
      const auto next = i < text.size() ? static_cast<unsigned char>(text[i++]) : 0U;
      point = next >> 6 == 2 ? point << 6 | (next & 0x3fU) : 0;
    }
    if (more < 0 || point < U' ') {
      throw InvalidInput("\"text\" must be one line of UTF-8, without control characters");
    }
    points.push_back(point);
  }
  return points;
}

int filled_rows(const GreyTile& tile) {
  int rows = 0;
  for (auto row = tile.values.begin(); row != tile.values.end(); row += tile.width) {
    if (std::any_of(row, row + tile.width, [](float value) { return value > 0; })) ++rows;
  }
  return rows;
}

GreyPattern set_text(const PrintStroke& stroke, const fs::path& folder) {
  const auto file = font_file(stroke.font, folder);
  GreyPattern pattern;
  double ignored = 0;
  pattern.height = filled_rows(Font(file).draw(U'H', ignored));
  Font font(file);
  double pen = 0;
  for (const char32_t letter : code_points(stroke.text)) {
    GreyTile tile = font.draw(letter, pen);
    if (!tile.values.empty()) pattern.tiles.push_back(std::move(tile));
  }
  for (GreyTile& tile : pattern.tiles) {
    tile.left -= pen / 2;
    tile.top -= pattern.height / 2;
  }
  std::stable_sort(pattern.tiles.begin(), pattern.tiles.end(),
                   [](const GreyTile& a, const GreyTile& b) { return 2 * a.left + a.width < 2 * b.left + b.width; });
  return pattern;
}
#else
std::vector<fs::path> all_fonts() { return {}; }

GreyPattern set_text(const PrintStroke& /*stroke*/, const fs::path& /*folder*/) {
  throw InvalidInput("\"text\": this Knead was built without FreeType, and prints no text; print a picture or a mesh");
}
#endif

// Appends the lines on which a tile is half as high as at its highest place: one or two in each square of a lattice.
void add_outline(const GreyTile& tile, double height, std::vector<PlaneLine>& lines) {
  constexpr double kSquares = 40;  // of the pattern's height
  const double side = std::max(height / kSquares, 1.0);
  const double half = 0.5 * static_cast<double>(*std::max_element(tile.values.begin(), tile.values.end()));
  // Over half, at a corner of the lattice, which goes a little beyond the tile.
  const auto excess = [&](int column, int row) {
    const double x = (column - 1) * side;
    const double y = (row - 1) * side;
    return mean_in(tile, x, y, x + side, y + side) - half;
  };
  constexpr std::array<std::array<int, 2>, 5> kRound{{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}};
  for (int row = 0; (row - 0.5) * side < tile.height; ++row) {
    for (int column = 0; (column - 0.5) * side < tile.width; ++column) {
      std::vector<std::array<double, 2>> crossings;
      for (std::size_t k = 0; k + 1 < kRound.size(); ++k) {
        const auto [x0, y0] = kRound[k];
        const auto [x1, y1] = kRound[k + 1];
        const double from = excess(column + x0, row + y0);
        const double to = excess(column + x1, row + y1);
        if ((from > 0) == (to > 0)) continue;
        const double t = from / (from - to);
        const double x = tile.left + (column - 0.5 + x0 + t * (x1 - x0)) * side;
        const double y = tile.top - (row - 0.5 + y0 + t * (y1 - y0)) * side;
        crossings.push_back({x / height, y / height});
      }
      for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) lines.push_back({crossings[k], crossings[k + 1]});
    }
  }
}

}  // namespace

std::shared_ptr<const GreyPattern> read_pattern(const PrintStroke& stroke, const fs::path& folder) {
  if (!stroke.text.empty()) return std::make_shared<const GreyPattern>(set_text(stroke, folder));
  const fs::path file = folder / stroke.file;
  try {
    return std::make_shared<const GreyPattern>(is_picture(file) ? read_picture(file)
                                                                : face_of(read_shape(file).mesh, stroke));
  } catch (const IoError& error) {
    throw InvalidInput(fmt::format("\"file\": {}", error.what()));
  }
}

}  // namespace knead::detail

namespace knead {

std::vector<PlaneLine> print_outline(const PrintStroke& stroke, const std::filesystem::path& folder) {
  validate(Stroke(stroke));
  const std::shared_ptr<const GreyPattern> pattern = detail::read_pattern(stroke, folder);
  std::vector<PlaneLine> lines;
  for (const GreyTile& tile : pattern->tiles) detail::add_outline(tile, pattern->height, lines);
  return lines;
}

bool is_picture(const std::filesystem::path& file) {
  const std::string type = detail::lower(file.extension().string());
  return std::find(kPictureExtensions.begin(), kPictureExtensions.end(), type) != kPictureExtensions.end();
}

std::map<std::string, std::filesystem::path> font_files() {
  std::map<std::string, std::filesystem::path> files;
  for (const std::filesystem::path& file : detail::all_fonts()) files.emplace(file.stem().string(), file);
  return files;
}

}  // namespace knead
