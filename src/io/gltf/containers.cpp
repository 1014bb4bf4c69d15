// The two containers of glTF, .glb and .gltf, whose buffers are in the file's binary chunk, in its text as base64 (data
// URIs), or in files beside it.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <system_error>

#include "io/gltf/edit.h"
#include "io/gltf/gltf.h"
#include "io/text.h"
#include "knead/io.h"

namespace knead::detail::gltf {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> without_percents(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      text += uri[i];
      continue;
    }
    constexpr std::string_view digits = "0123456789abcdef";
    unsigned value = 0;
    for (const std::size_t at : {i + 1, i + 2}) {
      const char c = at < uri.size() ? uri[at] : ' ';
      const std::size_t digit = digits.find(c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c);
      if (digit == std::string_view::npos) return std::nullopt;
      value = 16 * value + static_cast<unsigned>(digit);
    }
    text += static_cast<char>(value);
    i += 2;
  }
  return text;
}

// Returns the name of a file in the same folder that a URI names: no folder, no scheme; "%20" is a blank. Nothing for
// other URIs.
std::optional<std::string> plain_file_name(std::string_view uri) {
  std::optional<std::string> name = without_percents(uri);
  if (!name) return std::nullopt;
  if (name->starts_with("./")) name->erase(0, 2);
  const bool is_plain = name->find_first_of(std::string_view("/\\:\0", 4)) == std::string::npos;
  if (!is_plain || name->empty() || *name == "." || *name == "..") return std::nullopt;
  return name;
}

// Returns the URI of a plain file name.
std::string with_percents(std::string_view name) {
  std::string uri;
  for (const char c : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
    if (is_plain || static_cast<unsigned char>(c) >= 0x80) {
      uri += c;
    } else {
      uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return uri;
}

// Returns the bytes of a regular file of that name in the folder, no link. Throws InvalidInput that names the buffer.
std::string read_buffer(const fs::path& folder, const std::string& file, const Value& buffer) {
  const fs::path path = folder / file;
  std::error_code error;
  const auto type = fs::symlink_status(path, error).type();
  if (type == fs::file_type::not_found) {
    buffer.fail(fmt::format("is in the file {}, which is not there; put it beside this one", in_quotes(file)));
  }
  if (type != fs::file_type::regular) {
    buffer.fail(fmt::format("is in {}, which is no regular file; put a copy beside this one", in_quotes(file)));
  }
  std::ifstream stream(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.good() && !stream.eof()) {
    buffer.fail(fmt::format("is in the file {}, which cannot be read; check its permissions", in_quotes(file)));
  }
  if (const std::optional<std::string> other = stand_in(bytes)) {
    buffer.fail(fmt::format("is in the file {}, which {}", in_quotes(file), *other));
  }
  return bytes;
}

// Returns a name that may be written beside `target`: `wanted` where nothing stands there, or where it is what the
// source itself has there; else one made of the target's name that is none of `taken`.
std::string free_name(const fs::path& target, const std::string& wanted, bool is_own,
                      const std::vector<std::string>& taken) {
  std::error_code error;
  if (is_own || !fs::exists(fs::symlink_status(target.parent_path() / wanted, error))) return wanted;
  const std::string stem = target.stem().string();
  std::string name = stem + ".bin";
  for (int i = 1; std::find(taken.begin(), taken.end(), name) != taken.end(); ++i) {
    name = fmt::format("{}-{}.bin", stem, i);
  }
  return name;
}

// A file taken apart: its JSON, and what follows it in a GLB file.
struct Parts {
  std::string_view text;
  std::string_view bin;
  std::size_t text_begin = 0;
};

std::string as_glb(std::string_view text, std::string_view bin) {
  std::string chunks;
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
  append_chunk(chunks, kJson, text);
  append_chunk(chunks, kBin, bin);
  return with_header(std::move(chunks));
}

Parts parts_of(std::string_view glb_bytes, const std::string& name) {
  const Layout layout = parse_chunks(glb_bytes, name);
  const auto contents = [&](std::size_t i) { return glb_bytes.substr(layout.chunks[i].begin, layout.chunks[i].size); };
  std::string_view text = contents(0);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
  return {text, layout.bin ? contents(*layout.bin) : std::string_view{}, layout.chunks[0].begin};
}

// Brings all buffers together into one.
class Collector {
 public:
  Collector(const Parts& parts, std::string name, const std::filesystem::path* path)
      : parts_(parts), name_(std::move(name)), path_(path) {
    text_ = parts.text.substr(text_begin(parts.text, name_));
    source_ = {name_, text_, parts.text_begin};
    json_ = parse_object(text_, parts.text_begin, name_);
  }

  // False where the binary chunk is the one buffer, and nothing in it is compressed.
  bool is_needed() const {
    if (names_codec(text_)) return true;
    for (std::size_t i = 0; i < root().count("buffers"); ++i) {
      if (root().item("buffers", i).find("uri")) return true;
    }
    return root().count("buffers") > 1;
  }

  // The GLB file that holds the same.
  Wrapping run() {
    Wrapping wrapping;
    for (std::size_t i = 0; i < root().count("buffers"); ++i) add_buffer(i, root().item("buffers", i));
    std::vector<Patch> patches;
    const std::optional<Span> buffers = member(text_, root_span(text_), "buffers");
    if (buffers) {
      wrapping.buffers_text = std::string(text_.substr(buffers->begin, buffers->end - buffers->begin));
      patches.push_back({*buffers, fmt::format(R"([{{"byteLength":{}}}])", bin_.size())});
    }
    add_view_patches(patches);
    wrapping.buffers = std::move(buffers_);
    if (path_ != nullptr) wrapping.path = *path_;
    wrapping.glb = as_glb(patched(text_, std::move(patches)), bin_);
    return wrapping;
  }

 private:
  Value root() const { return {json_, source_}; }

  void add_buffer(std::size_t index, const Value& value) {
    Buffer buffer;
    std::string bytes;
    if (is_placeholder(value)) {
      buffer.begin = bin_.size();
      buffers_.push_back(std::move(buffer));
      return;
    }
    if (const std::optional<Value> uri = value.find("uri")) {
      bytes = bytes_of(*uri, buffer);
    } else if (index == 0) {
      bytes = std::string(parts_.bin);
    } else {
      value.fail("has no bytes: no 'uri'; repair the file");
    }
    buffer.size = value.at("byteLength").whole();
    if (buffer.size > bytes.size()) {
      value.fail(fmt::format("is {} bytes long, but {} are there; the file is cut short or damaged", buffer.size,
                             bytes.size()));
    }
    bin_.resize((bin_.size() + 3) / 4 * 4, '\0');
    buffer.begin = bin_.size();
    bin_.append(bytes, 0, buffer.size);
    buffers_.push_back(std::move(buffer));
  }

  // Returns whether the buffer has no bytes: those of its views are compressed.
  static bool is_placeholder(const Value& buffer) {
    const char* extension = meshopt_extension(buffer.json());
    return has_meshopt() && extension != nullptr && !buffer.find("uri") &&
           buffer.at("extensions").at(extension).flag("fallback");
  }

  std::string bytes_of(const Value& uri, Buffer& buffer) const {
    const std::string text = uri.text();
    if (text.starts_with("data:")) {
      constexpr std::string_view mark = ";base64,";
      const std::size_t comma = text.find(mark);
      if (comma == std::string::npos) uri.fail("is a data URI without ';base64,'; repair the file");
      buffer.kind = Buffer::Kind::data;
      buffer.head = text.substr(0, comma + mark.size());
      std::optional<std::string> bytes = from_base64(std::string_view(text).substr(buffer.head.size()));
      if (!bytes) uri.fail("is no base64; the file is damaged");
      return *std::move(bytes);
    }
    const std::optional<std::string> file = plain_file_name(text);
    if (!file) uri.fail(fmt::format("{} is no plain name of a file in the same folder", in_quotes(text)));
    if (path_ == nullptr) {
      uri.fail(
          fmt::format("the buffer is in the file {}, which is not opened here; read the shape by its path, or "
                      "export it as .glb",
                      in_quotes(*file)));
    }
    buffer.kind = Buffer::Kind::file;
    buffer.file = *file;
    return read_buffer(folder_of(*path_), *file, uri);
  }

  // Buffer views in the one buffer.
  void add_view_patches(std::vector<Patch>& patches) const {
    const std::optional<Span> array = member(text_, root_span(text_), "bufferViews");
    if (!array) return;
    const std::vector<Member> views = members(text_, *array);
    for (std::size_t v = 0; v < views.size(); ++v) {
      const Value view = root().item("bufferViews", v);
      add_range_patches(view, views[v].value, patches);
      const char* extension = meshopt_extension(view.json());
      if (extension == nullptr) continue;
      const Span extensions = *member(text_, views[v].value, "extensions");
      add_range_patches(view.at("extensions").at(extension), *member(text_, extensions, extension), patches);
    }
  }

  // Of a buffer view, or of the extension that compresses one.
  void add_range_patches(const Value& range, const Span& span, std::vector<Patch>& patches) const {
    const std::size_t buffer = range.at("buffer").whole();
    if (buffer >= buffers_.size()) range.fail(fmt::format("is in buffer {}, which there is not", buffer));
    if (buffer == 0) return;
    const Span number = *member(text_, span, "buffer");
    const std::string begin = std::to_string(buffers_[buffer].begin + range.whole("byteOffset").value_or(0));
    const std::optional<Span> offset = member(text_, span, "byteOffset");
    patches.push_back({number, offset ? "0" : R"(0,"byteOffset":)" + begin});
    if (offset) patches.push_back({*offset, begin});
  }

  const Parts& parts_;
  std::string name_;
  const std::filesystem::path* path_;  // null: no file may be opened
  std::string_view text_;
  Source source_;
  Json json_;
  std::vector<Buffer> buffers_;
  std::string bin_;
};

// Reads a file as the GLB file that holds the same.
void read_from(ShapeFile& shape, const std::string& name, const std::filesystem::path* path) {
  const bool is_container = shape.format == "glb";
  const Parts parts = is_container ? parts_of(shape.bytes, name) : Parts{shape.bytes, {}, 0};
  Collector collector(parts, name, path);
  if (is_container && !collector.is_needed()) {
    return set_layout(shape, read_scene(shape, parse_chunks(shape.bytes, name), shape.bytes, name));
  }
  Wrapping wrapping = collector.run();
  if (names_codec(parts_of(wrapping.glb, name).text)) {
    wrapping.glb = decompressed(std::move(wrapping.glb), name, shape.notes);
  }
  Layout layout = read_scene(shape, parse_chunks(wrapping.glb, name), wrapping.glb, name);
  const auto full =
      std::count_if(wrapping.buffers.begin(), wrapping.buffers.end(), [](const Buffer& b) { return b.size > 0; });
  if (full > 1) shape.notes.push_back(std::to_string(full) + " buffers are written as one if a vertex moves");
  layout.wrapping = std::move(wrapping);
  set_layout(shape, std::move(layout));
}

void read(ShapeFile& shape, const std::string& name) { read_from(shape, name, nullptr); }

void read_beside(ShapeFile& shape, const std::filesystem::path& path) { read_from(shape, path.string(), &path); }

// Reads a capture of splats in one binary chunk that is not compressed.
bool read_in_pieces(ShapeFile& shape, const std::string& name) {
  std::optional<Layout> layout = layout_of_file(*shape.file);
  if (!layout || layout->text.find(kSplatting) == std::string::npos) return false;
  if (Collector({layout->text, {}, layout->chunks[0].begin}, name, nullptr).is_needed()) return false;
  set_layout(shape, read_scene(shape, *std::move(layout), {}, name));
  return shape.mesh.face_count() == 0;
}

// "data:..." as JSON, quotes included, with the words before the bytes that the source has. Those may be anything that
// a JSON text can be, and so need escapes; base64 needs none.
std::string data_uri(const std::vector<Buffer>& buffers, std::string_view bin) {
  const bool has_head = !buffers.empty() && buffers[0].kind == Buffer::Kind::data;
  std::string uri = to_text(Json(has_head ? buffers[0].head : "data:application/octet-stream;base64,"));
  uri.pop_back();
  return uri + to_base64(bin) + '"';
}

// The buffers as text: the source's own one with other bytes; `uri` as JSON.
std::string buffers_text(const Wrapping& wrapping, std::string_view bin, const std::optional<std::string>& uri) {
  const std::string size = std::to_string(bin.size());
  if (wrapping.buffers.size() != 1) {
    return fmt::format(R"([{{"byteLength":{}{}}}])", size, uri ? R"(,"uri":)" + *uri : "");
  }
  const std::string_view text = wrapping.buffers_text;
  const Span buffer = members(text, Span{0, text.size()})[0].value;
  const std::optional<Span> old_uri = member(text, buffer, "uri");
  std::vector<Patch> patches{
      {*member(text, buffer, "byteLength"), size + (uri && !old_uri ? R"(,"uri":)" + *uri : "")}};
  if (uri && old_uri) patches.push_back({*old_uri, *uri});
  return patched(text, std::move(patches));
}

// The length of the byte order mark that a text begins with, or 0.
std::size_t mark_size(std::string_view text) { return text.starts_with("\xef\xbb\xbf") ? 3 : 0; }

// The GLB file as a file of the source's kind that is whole in itself.
std::string unwrapped(const ShapeFile& source, const Wrapping& wrapping, const std::string& bytes) {
  const Parts parts = parts_of(bytes, source.format);
  const bool in_chunk =
      source.format == "glb" && (wrapping.buffers.empty() || wrapping.buffers[0].kind == Buffer::Kind::chunk);
  // The chunk is padded; the buffer says how long it is.
  const std::optional<Span> buffers = member(parts.text, root_span(parts.text), "buffers");
  if (!buffers) return source.format == "glb" ? bytes : std::string(parts.text);
  const Json declared = parse_json(parts.text.substr(buffers->begin, buffers->end - buffers->begin));
  const std::string_view bin = parts.bin.substr(0, declared.items()[0].find("byteLength")->whole());
  std::optional<std::string> uri;
  if (!in_chunk) uri = data_uri(wrapping.buffers, bin);
  const std::string text = patched(parts.text, {{*buffers, buffers_text(wrapping, bin, uri)}});
  if (source.format != "glb") return source.bytes.substr(0, mark_size(source.bytes)) + text;
  return as_glb(text, in_chunk ? bin : std::string_view{});
}

// Writes the bytes of buffers to files beside the path; returns the file that names them.
std::string with_files_beside(const std::filesystem::path& path, const Wrapping& wrapping, const std::string& format,
                              const std::string& bytes) {
  const bool is_container = format == "glb";
  const Parts parts = is_container ? parts_of(bytes, format) : Parts{bytes, {}, 0};
  const std::string_view text = parts.text;
  const std::string_view old_bin = parts_of(wrapping.glb, format).bin;
  std::vector<std::string> taken;
  for (const Buffer& buffer : wrapping.buffers) taken.push_back(buffer.file);
  std::error_code error;
  const bool is_own = std::filesystem::equivalent(path, wrapping.path, error);
  const bool is_same_folder = std::filesystem::equivalent(folder_of(path), folder_of(wrapping.path), error);
  std::vector<Patch> patches;
  const std::vector<Member> buffers = members(text, *member(text, root_span(text), "buffers"));
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const std::optional<Span> uri = member(text, buffers[i].value, "uri");
    if (wrapping.buffers[i].kind != Buffer::Kind::file || !uri) continue;
    const std::string value = parse_json(text.substr(uri->begin, uri->end - uri->begin)).text();
    const bool is_new = value.starts_with("data:");  // else it names the file, which has not changed
    if (!is_new && is_same_folder) continue;
    const std::string name = free_name(path, wrapping.buffers[i].file, is_own, taken);
    const std::string_view old = old_bin.substr(wrapping.buffers[i].begin, wrapping.buffers[i].size);
    const std::size_t comma = value.find(',') + 1;
    write_file_atomically(folder_of(path) / name,
                          is_new ? *from_base64(std::string_view(value).substr(comma)) : std::string(old));
    if (is_new || name != wrapping.buffers[i].file) patches.push_back({*uri, to_text(Json(with_percents(name)))});
  }
  const std::string named = patched(text, std::move(patches));
  return is_container ? as_glb(named, parts.bin) : named;
}

// A file of the source's kind for the GLB file that takes the place of its own.
std::string as_source(const ShapeFile& source, std::string glb) {
  const std::optional<Wrapping>& wrapping = layout_of<Layout>(source).wrapping;
  if (wrapping) return unwrapped(source, *wrapping, glb);
  return glb;
}

void rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
             const WriteOptions& options, const ByteSink& out) {
  if (!layout_of<Layout>(source).wrapping) return rewrite_glb(source, positions, normals, options, out);
  std::string glb;
  rewrite_glb(source, positions, normals, options, [&](std::string_view piece) { glb += piece; });
  out(as_source(source, std::move(glb)));
}

std::string remeshed(const NewMesh& shape, const WriteOptions& /*options*/) {
  return as_source(shape.source, remeshed_glb(shape));
}

// Notes the images in files of their own that a copy of the source in another folder lacks.
std::vector<fs::path> copy_beside(const ShapeFile& source, const fs::path& from, const fs::path& to,
                                  const ByteSink& note) {
  const Document document = open_source(source);
  const Json* const images = document.json.find("images");
  for (const Json& image : images != nullptr && images->is_array() ? images->items() : std::vector<Json>{}) {
    const Json* const uri = image.find("uri");
    if (uri == nullptr || !uri->is_text() || uri->text().starts_with("data:")) continue;
    const std::optional<std::string> name = plain_file_name(uri->text());
    std::error_code error;
    const bool is_lacking = name && fs::exists(from / *name, error) && !fs::exists(to / *name, error);
    if (is_lacking) note((from / *name).string() + ": the texture was not copied; copy it yourself");
  }
  return {};
}

// A new .gltf file with its buffer as a data URI.
std::string generate(const Mesh& mesh, const WriteOptions& options) { return as_text(generate_glb(mesh, options)); }

// Writes a file of the source, whose bytes rewrite or remeshed made or which did not change: what came in files goes to
// files beside the path again, under the same names unless others' files stand there.
void write_beside(const std::filesystem::path& path, const ShapeFile& source, const std::string& bytes) {
  const std::optional<Wrapping>& wrapping = layout_of<Layout>(source).wrapping;
  const bool has_files = wrapping && std::any_of(wrapping->buffers.begin(), wrapping->buffers.end(),
                                                 [](const Buffer& b) { return b.kind == Buffer::Kind::file; });
  if (has_files) return write_new_file(path, with_files_beside(path, *wrapping, source.format, bytes));
  write_new_file(path, bytes);
}

constexpr Codec container(const char* name, std::string (*generate)(const Mesh&, const WriteOptions&)) {
  return {.name = name,
          .read = read,
          .read_beside = read_beside,
          .read_in_pieces = name == std::string_view("glb") ? read_in_pieces : nullptr,
          .rewrite_in_pieces = rewrite,
          .writes_edits = is_one_part,
          .generate = generate,
          .losses = losses,
          .source_losses = source_losses,
          .remeshed = remeshed,
          .remesh_losses = remesh_losses,
          .face_labels = face_labels,
          .stores_floats = [](const ShapeFile&) { return true; },
          .generates_floats = true,
          .write = write_beside,
          .copy_beside = copy_beside};
}

}  // namespace

std::string as_text(const std::string& glb) {
  ShapeFile source;
  source.format = "gltf";
  return unwrapped(source, {}, glb);
}

}  // namespace knead::detail::gltf

namespace knead::detail {

const Codec glb_codec = gltf::container("glb", gltf::generate_glb);
const Codec gltf_codec = gltf::container("gltf", gltf::generate);

}  // namespace knead::detail
