// Shapes from standard input and to standard output: `-` with --format.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io.h"
#include "options.h"

namespace knead::command {

using StreamFormat = std::optional<std::string>;  // the value of --format

void add_format_option(std::vector<Option>& options, StreamFormat& format);

inline bool is_stream(const std::string& path) { return path == "-"; }

// Throws UsageError if one of these paths is `-` and there is no format, or a format and none of them is `-`, or the
// format is none that is known.
void check_streams(const std::vector<std::string>& paths, const StreamFormat& format);

// Throws UsageError if the output is standard output, and so is what this option asks for.
void require_free_output(const std::string& output, bool asked, std::string_view option);

// Returns read_shape(path, options), or the shape on standard input.
ShapeFile read_shape_or_stream(const std::string& path, const StreamFormat& format, const ReadOptions& options = {});

// Returns read_summary(path), or that of the shape on standard input.
ShapeSummary read_summary_or_stream(const std::string& path, const StreamFormat& format);

// Returns a path with the extension of the format, for functions that ask what a format can hold: the path itself, or a
// name for standard output.
std::filesystem::path format_path(const std::string& path, const StreamFormat& format);

// Throws what require_shape_extension and require_writable throw for a file; nothing for standard output.
void require_shape_output(const std::string& path);

// Calls end_after_last_output, unless writing the shape writes several files (glTF with buffers, OBJ with materials).
void end_after_last_shape(const std::string& path, bool more_to_say);

// Writes to the file, or to standard output.
void write_shape_or_stream(const std::string& path, const StreamFormat& format, const ShapeFile& source,
                           std::span<const Vec3d> positions, const WriteOptions& options);
void write_remeshed_or_stream(const std::string& path, const StreamFormat& format, const ShapeFile& source,
                              const Mesh& mesh, std::span<const std::uint32_t> face_source,
                              const WriteOptions& options = {});

}  // namespace knead::command
