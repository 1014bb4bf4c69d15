#include "knead/io/ply/target.h"

namespace knead::io_detail::ply {
namespace {

std::size_t components(const Attribute& attribute) { return static_cast<std::size_t>(attribute.components); }

}  // namespace

void Target::grow(const std::vector<Sink>& sinks, Rows rows) {
  if (is_one_block_) first_ = rows.first;
  const std::size_t end = rows.first + rows.count - first_;
  for (const Sink& sink : sinks) {
    if (sink.kind == Sink::Kind::coordinate && mesh_.positions.size() < end) mesh_.positions.resize(end);
    if (sink.kind != Sink::Kind::attribute) continue;
    Attribute& attribute = mesh_.attributes[sink.attribute];
    if (attribute.values.size() < end * components(attribute)) attribute.values.resize(end * components(attribute));
  }
}

double* Target::place(const Sink& sink, std::size_t row) {
  row -= first_;
  if (sink.kind == Sink::Kind::coordinate) return &mesh_.positions[row].x + sink.component;
  if (sink.kind != Sink::Kind::attribute) return nullptr;
  Attribute& attribute = mesh_.attributes[sink.attribute];
  return attribute.values.data() + row * components(attribute) + sink.component;
}

void Target::check_coordinates(Rows rows, std::size_t position, std::size_t stride) {
  for (std::size_t i = 0; i < rows.count; ++i) {
    const Vec3d& p = mesh_.positions[rows.first - first_ + i];
    if (!is_finite(p)) {
      unplaced_.add(rows.first + i, position + i * stride);
    } else if (is_one_block_) {
      box_.add(std::span(&p, 1));
    }
  }
}

std::size_t Target::place_stride(const Sink& sink) const {
  if (sink.kind == Sink::Kind::coordinate) return sizeof(Vec3d) / sizeof(double);
  return components(mesh_.attributes[sink.attribute]);
}

// Every other triangle is turned round. A repeated vertex is how strips are stitched together and makes no face.
void Target::add_strips(std::span<const std::int64_t> items) {
  strips_ = true;
  std::size_t n = 0;  // vertices of this strip so far
  std::array<std::uint32_t, 3> last{};
  for (const std::int64_t item : items) {
    if (item == -1) {
      n = 0;
      continue;
    }
    last = {last[1], last[2], static_cast<std::uint32_t>(item)};
    const auto [a, b, c] = last;
    if (++n < 3 || a == b || b == c || c == a) continue;
    faces_.add(n % 2 == 0 ? std::array{b, a, c} : last);
  }
}

void Target::add_corner_uv(const Sink& sink, std::span<const double> values, std::size_t corners, bool kept) {
  if (values.size() != 2 * corners) corner_uv_complete_ = false;
  if (!kept) return;
  for (const double value : values) mesh_.attributes[sink.attribute].values.push_back(finite(value));
}

void Target::finish(std::vector<std::string>& notes) {
  std::erase_if(mesh_.attributes, [&](const Attribute& attribute) {
    return (strips_ && attribute.domain != Domain::vertex) ||
           (!corner_uv_complete_ && attribute.domain == Domain::corner);
  });
  if (!is_one_block_) remove_unplaced(unplaced_, mesh_);
  if (!unplaced_.rows.empty()) notes.push_back(unplaced_note(unplaced_.rows.size()));
  if (surplus_ > 0) {
    notes.push_back(counted(surplus_, "line has more numbers than the header declares; they are kept but not read",
                            "lines have more numbers than the header declares; they are kept but not read"));
  }
  faces_.append_notes(notes);
  if (not_finite_ > 0) {
    notes.push_back(counted(not_finite_, "attribute value is not finite and is read as 0",
                            "attribute values are not finite and are read as 0"));
  }
  if (faces_.faces() == 0) notes.push_back("has no faces and is read as a point cloud");
}

}  // namespace knead::io_detail::ply
