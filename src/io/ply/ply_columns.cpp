// Where the numbers of a PLY file go in the mesh, and binary rows of equal length, read many at a time and one property
// after the other.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "io/mesh_builder.h"
#include "io/ply/ply.h"
#include "math/system.h"

namespace knead::detail::ply {
namespace {

std::size_t components(const Attribute& attribute) { return static_cast<std::size_t>(attribute.components); }

template <class T, bool kSwapped>
T load(const char* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return kSwapped ? swap_bytes(value) : value;
}

// Calls visit(T{}, std::bool_constant) for a number type and a byte order.
template <class Visit>
void visit_stored(StoredType type, bool swapped, Visit visit) {
  visit_type(type, [&](auto value) {
    if (swapped) {
      visit(value, std::true_type{});
    } else {
      visit(value, std::false_type{});
    }
  });
}

// Where rows of one length stand in the file.
struct Block {
  const char* bytes = nullptr;
  std::size_t stride = 0;
  Rows rows;
  std::size_t position = 0;  // of its first byte in the file
};

class ColumnReader {
 public:
  ColumnReader(BinaryBody& body, const Element& element, const std::vector<Sink>& sinks, Target& target)
      : body_(body), element_(element), sinks_(sinks), target_(target) {
    for (const Property& property : element.properties) {
      if (property.is_list) {
        list_ = &property;
        break;
      }
      before_list_ += size_of(property.type);
    }
  }

  void run() {
    std::size_t kept = 0;
    for (std::size_t done = 0; done < element_.count;) {
      const std::size_t count = measure_run(element_.count - done);
      const bool keep = list_ == nullptr || corners_ >= 3;
      const std::size_t position = body_.position();
      read_block({body_.skip(count * stride_), stride_, {kept, count}, position});
      if (keep) kept += count;
      done += count;
    }
  }

 private:
  // Returns how many of the next rows have lists as long as that of the first, at most as many as the cache holds. Sets
  // their length.
  std::size_t measure_run(std::size_t most) {
    most = std::min<std::size_t>(most, 2048);
    stride_ = smallest_row(element_, false);
    if (list_ == nullptr) return most;  // check_count has seen to their bytes
    if (body_.left() < stride_) body_.fail_missing(element_);
    corners_ = body_.length_at(before_list_, *list_, element_);
    stride_ += corners_ * size_of(list_->type);
    if (body_.left() < stride_) body_.fail_missing(element_);
    most = std::min(most, body_.left() / stride_);
    const auto same_length = [&](auto type, auto swapped) {
      using T = decltype(type);
      const char* from = body_.data(most * stride_) + before_list_;
      const T length = load<T, swapped()>(from);
      std::size_t count = 1;
      while (count < most && load<T, swapped()>(from + count * stride_) == length) ++count;
      most = count;
    };
    visit_stored(list_->count_type, body_.swapped(), same_length);
    return most;
  }

  void read_block(const Block& block) {
    if (list_ != nullptr) add_faces(block);
    if (list_ != nullptr && corners_ < 3) return;  // no faces
    target_.grow(sinks_, block.rows);
    std::size_t offset = 0;
    bool coordinates = false;
    for (std::size_t p = 0; p < element_.properties.size(); ++p) {
      const Property& property = element_.properties[p];
      if (!property.is_list) read_column(property.type, block, offset, sinks_[p]);
      coordinates = coordinates || sinks_[p].kind == Sink::Kind::coordinate;
      offset +=
          property.is_list ? size_of(property.count_type) + corners_ * size_of(property.type) : size_of(property.type);
    }
    if (coordinates) target_.check_coordinates(block.rows, block.position, block.stride);
  }

  void read_column(StoredType type, const Block& block, std::size_t offset, const Sink& sink) {
    double* const to = target_.place(sink, block.rows.first);
    if (to == nullptr) return;
    const std::size_t to_stride = target_.place_stride(sink);
    const char* const from = block.bytes + offset;
    visit_stored(type, body_.swapped(), [&](auto number, auto swapped) {
      for (std::size_t i = 0; i < block.rows.count; ++i) {
        to[i * to_stride] = static_cast<double>(load<decltype(number), swapped()>(from + i * block.stride));
      }
    });
    if (sink.kind == Sink::Kind::coordinate || is_integer(type)) return;
    for (std::size_t i = 0; i < block.rows.count; ++i) to[i * to_stride] = target_.finite(to[i * to_stride]);
  }

  void add_faces(const Block& block) {
    indices_.resize(block.rows.count * corners_);
    const char* const from = block.bytes + before_list_ + size_of(list_->count_type);
    std::uint64_t largest = 0;
    visit_stored(list_->type, body_.swapped(), [&](auto number, auto swapped) {
      using T = decltype(number);
      if constexpr (std::is_integral_v<T>) {
        std::uint32_t* to = indices_.data();
        for (std::size_t i = 0; i < block.rows.count; ++i) {
          for (std::size_t c = 0; c < corners_; ++c) {
            const T index = load<T, swapped()>(from + i * block.stride + c * sizeof(T));
            // NOLINTBEGIN(bugprone-signed-char-misuse): a number, no character; a negative one becomes huge
            largest = std::max(largest, static_cast<std::uint64_t>(static_cast<std::int64_t>(index)));
            *to++ = static_cast<std::uint32_t>(index);
            // NOLINTEND(bugprone-signed-char-misuse)
          }
        }
      }
    });
    if (largest >= target_.vertices() && corners_ > 0) fail_index(block);
    target_.faces().add_equal(indices_, corners_, block.rows.count);
  }

  [[noreturn]] void fail_index(const Block& block) {
    const std::size_t first = before_list_ + size_of(list_->count_type);
    for (std::size_t i = 0; i < block.rows.count; ++i) {
      for (std::size_t c = 0; c < corners_; ++c) {
        const std::size_t offset = i * block.stride + first + c * size_of(list_->type);
        const double index = read_binary(block.bytes + offset, list_->type, body_.swapped());
        if (index >= 0 && index < static_cast<double>(target_.vertices())) continue;
        body_.fail_at(block.position + offset, index_message(index, target_.vertices()));
      }
    }
    body_.fail_at(block.position, "an index is out of range; repair the file");
  }

  BinaryBody& body_;
  const Element& element_;
  const std::vector<Sink>& sinks_;
  Target& target_;
  const Property* list_ = nullptr;
  std::size_t before_list_ = 0;  // bytes of a row
  std::size_t corners_ = 0;      // of each face of the run
  std::size_t stride_ = 0;       // bytes of each row of the run
  std::vector<std::uint32_t> indices_;
};

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
  for (const double value : values) mesh_.attributes[sink.attribute].values.push_back(finite_(value));
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
  finite_.append_note(notes);
  if (faces_.faces() == 0) notes.emplace_back(kCloudNote);
}

void read_columns(BinaryBody& body, const Element& element, const std::vector<Sink>& sinks, Target& target) {
  ColumnReader(body, element, sinks, target).run();
}

std::size_t smallest_row(const Element& element, bool ascii) {
  std::size_t smallest = 0;
  for (const Property& p : element.properties) {
    smallest += ascii ? 2 : size_of(p.is_list ? p.count_type : p.type);
  }
  return smallest;
}

void reserve_rows(const Element& element, const std::vector<Sink>& sinks, std::size_t left, bool ascii,
                  Target& target) {
  if (target.is_one_block()) return;
  Mesh& mesh = target.mesh();
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const Sink& sink = sinks[p];
    if (sink.kind == Sink::Kind::coordinate) reserve_large(mesh.positions, element.count);
    if (sink.kind == Sink::Kind::attribute) {
      Attribute& attribute = mesh.attributes[sink.attribute];
      reserve_large(attribute.values, element.count * components(attribute));
    }
    if (sink.kind != Sink::Kind::faces) continue;
    const std::size_t item = ascii ? 2 : size_of(element.properties[p].type);
    const std::size_t items = (left - std::min(left, element.count * smallest_row(element, ascii))) / item;
    reserve_large(mesh.face_begin, element.count + 1);
    reserve_large(mesh.corner_vertex, std::min(items, 4 * element.count));
  }
}

std::string index_message(double index, std::size_t vertices) {
  return fmt::format("vertex index {:.0f} is not one of the {} vertices, counted from 0; repair the file", index,
                     vertices);
}

}  // namespace knead::detail::ply
