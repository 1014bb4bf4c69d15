// PTX, the text files of laser scanners: its row of the format table (formats.h). A file has one or more scans, each of
// ten lines (columns, rows, the scanner's pose twice) and a line x y z intensity [red green blue] for each of its
// directions.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "knead/io/decimals.h"
#include "knead/io/shape_file.h"
#include "knead/math/mat3.h"

namespace knead::io_detail::ptx {

// How a scan's points come to be where they are: world = linear * local + offset.
struct Scan {
  std::size_t begin = 0;  // the byte of its first point's line
  std::size_t rows = 0;   // lines
  Mat3d linear;
  Vec3d offset;
  Mat3d inverse;

  bool is_identity() const { return linear == Mat3d{} && offset == Vec3d{}; }
};

struct Layout {
  std::vector<Scan> scans;
  bool columns_read = true;             // all numbers after x y z are attributes of the mesh
  std::vector<std::uint32_t> unplaced;  // rows, counted over all scans, of directions without a point (unplaced.h)
};

// The points in world coordinates. Directions from which nothing came back, 0 0 0 or coordinates that are not finite,
// are left out of the mesh. Attributes: "intensity", and "color" (3) if every line has one.
ShapeFile parse(std::string bytes, const std::string& name);

// Replaces the numbers, in the coordinates of its scan, of each point that moved.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);

// Throws InvalidInput: other shapes have no rows and columns of a scanner.
std::string generate(const Mesh& mesh, const WriteOptions& options);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);

}  // namespace knead::io_detail::ptx
