// The mesh that a PLY file is read into, and what is noted on the way.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "knead/io/face_builder.h"
#include "knead/io/ply/plan.h"
#include "knead/io/unplaced.h"
#include "knead/mesh/measures.h"

namespace knead::io_detail::ply {

// Rows of an element, counted without those that are left out.
struct Rows {
  std::size_t first = 0;
  std::size_t count = 0;
};

class Target {
 public:
  Target(Mesh& mesh, std::vector<Attribute> attributes, std::size_t vertices)
      : mesh_(mesh), faces_(mesh), vertices_(vertices) {
    mesh_.attributes = std::move(attributes);
  }

  // Keeps one block of rows at a time, in the mesh, and counts the faces.
  struct OneBlock {};
  Target(OneBlock, Mesh& mesh, std::vector<Attribute> attributes, std::size_t vertices)
      : mesh_(mesh), vertices_(vertices), is_one_block_(true) {
    mesh_.attributes = std::move(attributes);
  }
  bool is_one_block() const { return is_one_block_; }
  const CloudBox& box() const { return box_; }  // of the vertices, if one block is kept

  Mesh& mesh() { return mesh_; }
  std::size_t vertices() const { return vertices_; }
  FaceBuilder& faces() { return faces_; }
  Unplaced& unplaced() { return unplaced_; }  // rows whose coordinates are not finite, in the file's order

  // Counts a line of text with more numbers than the header declares.
  void add_surplus() { ++surplus_; }
  bool has_surplus() const { return surplus_ > 0; }

  // Makes room for a number of each of these rows.
  void grow(const std::vector<Sink>& sinks, Rows rows);

  // Looks at the coordinates of rows that have been read; `stride` bytes each, the first at `position`.
  void check_coordinates(Rows rows, std::size_t position, std::size_t stride);

  // The place of a number, and how far apart the same numbers of neighbouring rows are; null for what is no coordinate
  // and no attribute of a row.
  double* place(const Sink& sink, std::size_t row);
  std::size_t place_stride(const Sink& sink) const;

  // One number of a row for which there is room.
  void put(double value, const Sink& sink, std::size_t row) {
    if (double* to = place(sink, row)) *to = sink.kind == Sink::Kind::attribute ? finite(value) : value;
  }

  // Takes what is not finite as 0, and counts it.
  double finite(double value) {
    if (std::isfinite(value)) return value;
    ++not_finite_;
    return 0;
  }

  // Strips of triangles with -1 between them; the numbers have been checked.
  void add_strips(std::span<const std::int64_t> items);

  // u v for the corners of one face that was kept or not.
  void add_corner_uv(const Sink& sink, std::span<const double> values, std::size_t corners, bool kept);

  // Adds the notes. Drops attributes of faces where there are strips too, texture coordinates that some face lacks, and
  // the vertices without a place.
  void finish(std::vector<std::string>& notes);

 private:
  Mesh& mesh_;
  FaceBuilder faces_;
  std::size_t vertices_;
  std::size_t not_finite_ = 0;
  std::size_t surplus_ = 0;
  Unplaced unplaced_;
  bool is_one_block_ = false;
  std::size_t first_ = 0;  // row of the block
  CloudBox box_;
  bool strips_ = false;
  bool corner_uv_complete_ = true;
};

}  // namespace knead::io_detail::ply
