#include "knead/io/glb/attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/io/face_builder.h"

namespace knead::io_detail::glb {
namespace {

struct Source {
  std::size_t accessor = 0;
  Accessor found;
};

class AttributeReader {
 public:
  AttributeReader(const Document& document, const std::vector<Block>& blocks) : document_(document), blocks_(blocks) {}

  // Nothing if no block has it.
  std::optional<Attribute> read(const Semantic& semantic, std::vector<std::string>& notes) {
    const std::vector<std::optional<Source>> sources = find_sources(semantic);
    Attribute attribute = described(semantic, sources);
    if (attribute.components == 0) return std::nullopt;
    std::size_t missing = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (!sources[b]) missing += blocks_[b].count;
      const std::vector<double> values =
          sources[b] ? values_of(*sources[b], attribute, blocks_[b])
                     : std::vector<double>(blocks_[b].count * static_cast<std::size_t>(attribute.components),
                                           attribute.name == "color" ? one(attribute.type) : 0.0);
      attribute.values.insert(attribute.values.end(), values.begin(), values.end());
    }
    for (double& value : attribute.values) {
      if (std::isfinite(value)) continue;
      value = 0;
      ++not_finite_;
    }
    if (missing > 0) {
      const char* as = attribute.name == "color" ? "white" : "0";
      notes.push_back(counted(missing, "vertex has", "vertices have") + " no " + attribute.name +
                      ", which is read as " + as);
    }
    return attribute;
  }

  void append_notes(std::vector<std::string>& notes) const {
    if (not_finite_ == 0) return;
    notes.push_back(counted(not_finite_, "number of an attribute is", "numbers of attributes are") +
                    " not finite and read as 0");
  }

 private:
  static double one(NumberType type) {
    return type == NumberType::float32 ? 1 : (type == NumberType::uint8 ? 255 : 65535);
  }

  std::vector<std::optional<Source>> find_sources(const Semantic& semantic) const {
    std::vector<std::optional<Source>> sources;
    for (const Block& block : blocks_) {
      const std::optional<std::size_t>& index = block.*semantic.accessor;
      sources.emplace_back();
      if (!index) continue;
      sources.back() = Source{*index, find_accessor(document_, *index)};
      const Accessor& found = sources.back()->found;
      const std::string name = semantic.name;
      const bool fits = found.components == (name == "uv" ? 2u : 3u) || (name == "color" && found.components == 4);
      const bool is_tangent = name == "tangent" && found.components == 4;
      if (found.count != block.count || (name == "tangent" ? !is_tangent : !fits)) {
        document_.root()
            .item("accessors", *index)
            .fail(fmt::format("does not fit {} of {} vertices; repair the file", semantic.key, block.count));
      }
    }
    return sources;
  }

  // The attribute without its values; without components if there is none.
  static Attribute described(const Semantic& semantic, const std::vector<std::optional<Source>>& sources) {
    Attribute attribute{semantic.name, Domain::vertex, NumberType::float32, 0, {}};
    std::optional<NumberType> type;
    for (const std::optional<Source>& source : sources) {
      if (!source) continue;
      attribute.components = std::max(attribute.components, static_cast<int>(source->found.components));
      const bool kept = source->found.normalized &&
                        (source->found.type == NumberType::uint8 || source->found.type == NumberType::uint16);
      const NumberType held = kept ? source->found.type : NumberType::float32;
      type = type.value_or(held) == held ? held : NumberType::float32;
    }
    if (type && attribute.name == "color") attribute.type = *type;
    return attribute;
  }

  std::vector<double> values_of(const Source& source, const Attribute& attribute, const Block& block) {
    const bool as_real = attribute.type == NumberType::float32;
    std::vector<double> values = read_accessor(document_, source.accessor, source.found, as_real);
    if (attribute.name == "normal") place_normals(values, block.placement);
    if (attribute.name == "tangent") place_tangents(values, block.placement);
    if (attribute.name == "uv") {
      for (std::size_t i = 1; i < values.size(); i += 2) values[i] = 1 - values[i];
    }
    if (attribute.name == "color" && source.found.components < static_cast<std::size_t>(attribute.components)) {
      std::vector<double> opaque;
      for (std::size_t i = 0; i < values.size(); ++i) {
        opaque.push_back(values[i]);
        if (i % 3 == 2) opaque.push_back(one(attribute.type));
      }
      return opaque;
    }
    return values;
  }

  void set_direction(double* to, const Vec3d& v) {
    if (!is_finite(v)) ++not_finite_;
    const Vec3d unit = direction(v);
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = unit[axis];
  }

  void place_normals(std::vector<double>& values, const Placement& placement) {
    const Mat3d& inverse = placement.inverse;
    const Mat3d transposed(inverse.column(0), inverse.column(1), inverse.column(2));
    for (std::size_t i = 0; i < values.size(); i += 3) {
      set_direction(&values[i], transposed * direction({values[i], values[i + 1], values[i + 2]}));
    }
  }

  // A mirror changes the hand.
  void place_tangents(std::vector<double>& values, const Placement& placement) {
    const double hand = determinant(placement.linear) < 0 ? -1 : 1;
    for (std::size_t i = 0; i < values.size(); i += 4) {
      set_direction(&values[i], placement.linear * direction({values[i], values[i + 1], values[i + 2]}));
      values[i + 3] *= hand;
    }
  }

  const Document& document_;
  const std::vector<Block>& blocks_;
  std::size_t not_finite_ = 0;
};

}  // namespace

bool is_read(const std::string& key) {
  return key == "POSITION" ||
         std::any_of(kSemantics.begin(), kSemantics.end(), [&](const Semantic& s) { return key == s.key; });
}

Vec3d direction(const Vec3d& v) {
  const double largest = std::fmax(std::abs(v.x), std::fmax(std::abs(v.y), std::abs(v.z)));
  if (!(largest > 0) || !is_finite(v)) return {};
  return normalized(v / largest);  // scaled first, so that squares neither overflow nor vanish
}

std::vector<Attribute> read_attributes(const Document& document, const std::vector<Block>& blocks,
                                       std::vector<std::string>& notes) {
  AttributeReader reader(document, blocks);
  std::vector<Attribute> attributes;
  for (const Semantic& semantic : kSemantics) {
    std::optional<Attribute> attribute = reader.read(semantic, notes);
    if (attribute) attributes.push_back(*std::move(attribute));
  }
  reader.append_notes(notes);
  return attributes;
}

}  // namespace knead::io_detail::glb
