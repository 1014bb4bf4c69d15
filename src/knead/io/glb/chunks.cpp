// The container of a GLB file.
#include <fmt/format.h>

#include "knead/io/cursor.h"
#include "knead/io/glb/accessor.h"

namespace knead::io_detail::glb {

namespace {

// What the header says that the file's length is.
std::size_t declared_length(std::string_view bytes, const std::string& name) {
  ByteCursor cursor(bytes, name);
  if (cursor.take_bytes(4, "'glTF'") != "glTF") {
    fail_at_byte(name, 0, "this is no GLB file: it does not begin with 'glTF'");
  }
  const auto version = cursor.take<std::uint32_t>("the version");
  if (version != 2) fail_at_byte(name, 4, fmt::format("glTF {} is not supported; use version 2", version));
  const auto length = cursor.take<std::uint32_t>("the length");
  if (length > bytes.size()) {
    fail_at_byte(
        name, 8,
        fmt::format("the file should have {} bytes, but has {}; it is cut short or damaged", length, bytes.size()));
  }
  return length;
}

}  // namespace

Layout parse_chunks(std::string_view bytes, const std::string& name) {
  ByteCursor cursor(bytes.substr(0, declared_length(bytes, name)), name);
  cursor.take_bytes(12, "the header");
  Layout layout;
  while (cursor.left() > 0) {
    Chunk chunk;
    chunk.size = cursor.take<std::uint32_t>("the length of a chunk");
    chunk.type = cursor.take<std::uint32_t>("the type of a chunk");
    chunk.begin = cursor.position();
    cursor.take_bytes(chunk.size, "the contents of a chunk");
    if (chunk.type == kBin && !layout.bin) layout.bin = layout.chunks.size();
    layout.chunks.push_back(chunk);
  }
  layout.end = cursor.position();
  if (layout.chunks.empty() || layout.chunks.front().type != kJson) {
    fail_at_byte(name, 12, "the first chunk is not JSON; the file is damaged");
  }
  return layout;
}

Document open_document(std::string_view bytes, const Layout& layout, const std::string& name) {
  const Chunk& json = layout.chunks.front();
  Document document{bytes, bytes.substr(json.begin, json.size), {}, {}, {}};
  document.source = {name, document.text, json.begin};
  if (layout.bin) document.bin = bytes.substr(layout.chunks[*layout.bin].begin, layout.chunks[*layout.bin].size);
  document.json = parse_object(document.text, json.begin, name);
  const Value asset = document.root().at("asset");
  for (const char* key : {"version", "minVersion"}) {
    const std::optional<Value> version = asset.find(key);
    if (version && version->text().substr(0, 2) != "2.") version->fail("only glTF 2 is supported");
  }
  asset.at("version");
  return document;
}

}  // namespace knead::io_detail::glb
