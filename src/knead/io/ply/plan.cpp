#include "knead/io/ply/plan.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "knead/io/ply/header.h"
#include "knead/math/error.h"

namespace knead::io_detail::ply {
namespace {

// Scalar properties that together make one attribute.
struct Group {
  std::string_view attribute;
  std::array<std::string_view, 4> properties;
  std::size_t needed;    // so many must be there
  std::size_t possible;  // and so many may
};

constexpr std::array<Group, 6> kGroups = {{{"normal", {"nx", "ny", "nz", ""}, 3, 3},
                                           {"uv", {"s", "t", "", ""}, 2, 2},
                                           {"uv", {"u", "v", "", ""}, 2, 2},
                                           {"uv", {"texture_u", "texture_v", "", ""}, 2, 2},
                                           {"uv", {"texture_s", "texture_t", "", ""}, 2, 2},
                                           {"color", {"red", "green", "blue", "alpha"}, 3, 4}}};

// The names of the list of a face's vertices; the first two are the usual ones.
constexpr std::array<std::string_view, 5> kIndexNames = {"vertex_indices", "vertex_index", "vertex_indexes", "indices",
                                                         "vertices"};

bool is_group_name(const std::string& name) {
  return std::any_of(kGroups.begin(), kGroups.end(), [&](const Group& group) { return group.attribute == name; });
}

std::optional<std::size_t> find_scalar(const Element& element, std::string_view name) {
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    if (element.properties[p].name == name && !element.properties[p].is_list) return p;
  }
  return std::nullopt;
}

class Planner {
 public:
  Planner(const Layout& layout, const std::string& name) : layout_(layout), name_(name) {}

  Plan run() {
    for (const Element& element : layout_.elements) {
      sinks_ = &plan_.sinks.emplace_back(element.properties.size());
      const bool is_vertex = &element == &layout_.elements[layout_.vertex_element];
      if (is_vertex) add_coordinates(element);
      if (element.name == "face" || element.name == "tristrips") add_indices(element);
      if (is_vertex || element.name == "face") add_attributes(element, is_vertex ? Domain::vertex : Domain::face);
    }
    return std::move(plan_);
  }

 private:
  void add_coordinates(const Element& element) {
    if (element.count == 0) throw InvalidInput(Place{name_}, "has no vertices; there is no shape in it");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string property(1, "xyz"[axis]);
      const std::optional<std::size_t> p = find_scalar(element, property);
      if (!p) throw InvalidInput(Place{name_}, "element 'vertex' has no property '" + property + "'; add one");
      (*sinks_)[*p] = {Sink::Kind::coordinate, 0, axis};
    }
  }

  void add_indices(const Element& element) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (!is_index_list(element, element.properties[p])) continue;
      (*sinks_)[p].kind = element.name == "face" ? Sink::Kind::faces : Sink::Kind::strips;
      return;
    }
    if (element.count == 0) return;
    throw InvalidInput(Place{name_}, "element '" + element.name + "' has no list 'vertex_indices'; add one");
  }

  void add_attributes(const Element& element, Domain domain) {
    for (const Group& group : kGroups) add_group(element, domain, group);
    if (domain == Domain::face) add_corner_uv(element);
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if ((*sinks_)[p].kind == Sink::Kind::skip && !property.is_list && !is_group_name(property.name)) {
        add_attribute(element, domain, property.name, {p});
      }
    }
  }

  void add_group(const Element& element, Domain domain, const Group& group) {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < group.possible; ++i) {
      const std::optional<std::size_t> p = find_scalar(element, group.properties[i]);
      if (!p || element.properties[*p].type != element.properties[members.empty() ? *p : members[0]].type) break;
      members.push_back(*p);
    }
    const bool needs_reals = group.attribute != "color";
    if (members.size() < group.needed || (needs_reals && is_integer(element.properties[members[0]].type))) return;
    add_attribute(element, domain, std::string(group.attribute), members);
  }

  void add_attribute(const Element& element, Domain domain, const std::string& attribute,
                     const std::vector<std::size_t>& members) {
    for (std::size_t i = 0; i < members.size(); ++i) {
      (*sinks_)[members[i]] = {Sink::Kind::attribute, plan_.attributes.size(), i};
    }
    const NumberType type = number_type(element.properties[members[0]].type);
    plan_.attributes.push_back({attribute, domain, type, static_cast<int>(members.size()), {}});
  }

  void add_corner_uv(const Element& element) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (!element.properties[p].is_list || element.properties[p].name != "texcoord") continue;
      (*sinks_)[p] = {Sink::Kind::corner_uv, plan_.attributes.size(), 0};
      plan_.attributes.push_back({"uv", Domain::corner, number_type(element.properties[p].type), 2, {}});
    }
  }

  const Layout& layout_;
  const std::string& name_;
  Plan plan_;
  std::vector<Sink>* sinks_ = nullptr;
};

}  // namespace

Plan make_plan(const Layout& layout, const std::string& name) { return Planner(layout, name).run(); }

bool is_index_list(const Element& element, const Property& property) {
  return property.is_list && (element.name == "face" || element.name == "tristrips") &&
         std::find(kIndexNames.begin(), kIndexNames.end(), property.name) != kIndexNames.end();
}

}  // namespace knead::io_detail::ply
