#include "requirements.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "command.h"
#include "output.h"

namespace knead::command {
namespace {

using Complaint = std::optional<std::string>;

Complaint complain_if(bool bad, const std::string& text) { return bad ? Complaint(text) : std::nullopt; }

Complaint not_closed(const Measures& m) {
  if (m.faces == 0) return "not closed: it has no faces; give a mesh";
  return complain_if(
      !m.closed(), fmt::format("not closed: {} with one face only; fill the holes", counted(m.boundary_edges, "edge")));
}

Complaint not_manifold(const Measures& m) {
  return complain_if(
      !m.manifold(),
      fmt::format("not manifold: {} with more than two faces, {} where surfaces only touch; split them",
                  counted(m.nonmanifold_edges, "edge"),
                  m.nonmanifold_vertices == 1 ? "1 vertex" : fmt::format("{} vertices", m.nonmanifold_vertices)));
}

Complaint not_oriented(const Measures& m) {
  return complain_if(!m.oriented(), fmt::format("not oriented: {} whose faces disagree about which side is outside; "
                                                "turn some of them over",
                                                counted(m.misoriented_edges, "edge")));
}

Complaint not_one_component(const Measures& m) {
  return complain_if(m.components != 1,
                     fmt::format("{}, not one; join or remove some", counted(m.components, "component")));
}

Complaint intersects(const SelfIntersections& found) {
  return complain_if(found.count > 0, fmt::format("{}{} of triangles intersect; move them apart",
                                                  found.complete ? "" : "more than ", counted(found.count, "pair")));
}

Complaint angle_below(double bound, const std::optional<double>& angle) {
  if (!angle) return "no triangle with an area, so no smallest angle; give a mesh";
  return complain_if(*angle < bound, fmt::format("a triangle has an angle of {:.3g} degrees, less than {}; collapse or "
                                                 "flip its edges",
                                                 *angle, bound));
}

struct Kind {
  std::string_view word;
  Complaint (*unmet)(const SurfaceCheck& check, double bound);
};

constexpr std::string_view kNoFlipped = "no-flipped";
constexpr std::string_view kMinAngle = "min-angle";

constexpr std::array kKinds{
    Kind{"closed", [](const SurfaceCheck& f, double) { return not_closed(f.info.measures); }},
    Kind{"manifold", [](const SurfaceCheck& f, double) { return not_manifold(f.info.measures); }},
    Kind{"oriented", [](const SurfaceCheck& f, double) { return not_oriented(f.info.measures); }},
    Kind{"one-component", [](const SurfaceCheck& f, double) { return not_one_component(f.info.measures); }},
    Kind{"no-self-intersections", [](const SurfaceCheck& f, double) { return intersects(f.self_intersections); }},
    Kind{"no-degenerate",
         [](const SurfaceCheck& f, double) {
           const std::size_t count = f.info.measures.degenerate_triangles;
           return complain_if(count > 0, fmt::format("{} without area; collapse them", counted(count, "triangle")));
         }},
    Kind{"no-folded",
         [](const SurfaceCheck& f, double) {
           return complain_if(f.folded_edges > 0, fmt::format("the surface is folded at {}; smooth it there",
                                                              counted(f.folded_edges, "edge")));
         }},
    Kind{kNoFlipped,
         [](const SurfaceCheck& f, double) {
           const std::size_t count = f.flipped_triangles.value_or(0);
           return complain_if(
               count > 0, fmt::format("{} flipped; refine the shape or deform it less", counted(count, "triangle")));
         }},
    Kind{kMinAngle,
         [](const SurfaceCheck& f, double bound) { return angle_below(bound, f.info.measures.smallest_angle_deg); }},
};

const Kind* find_kind(std::string_view word) {
  const auto* const kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& each) { return each.word == word; });
  return kind == kKinds.end() ? nullptr : kind;
}

Requirement parse_requirement(std::string_view item, bool has_before) {
  const std::size_t equals = item.find('=');
  const std::string_view word = item.substr(0, equals);
  if (find_kind(word) == nullptr || (equals != std::string_view::npos && word != kMinAngle)) {
    throw UsageError(fmt::format("--require: no requirement '{}'; choose from {}", item, known_requirements()));
  }
  if (word == kNoFlipped && !has_before) {
    throw UsageError("--require no-flipped: compares two shapes; give the other with --before FILE");
  }
  Requirement requirement{std::string(word), 0};
  if (word == kMinAngle) {
    const std::string_view number = equals == std::string_view::npos ? "" : item.substr(equals + 1);
    const char* const end = number.data() + number.size();
    const auto [stop, error] = std::from_chars(number.data(), end, requirement.bound);
    if (error != std::errc() || stop != end || !(requirement.bound > 0 && requirement.bound <= 60)) {
      throw UsageError(fmt::format("--require {}: say min-angle=DEGREES, above 0 and at most 60", item));
    }
  }
  return requirement;
}

}  // namespace

std::string known_requirements() {
  std::string words;
  for (const Kind& kind : kKinds) {
    words += fmt::format("{}{}{}", words.empty() ? "" : ", ", kind.word, kind.word == kMinAngle ? "=DEGREES" : "");
  }
  return words;
}

std::vector<Requirement> parse_requirements(const std::string& list, bool has_before) {
  std::vector<Requirement> requirements;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    requirements.push_back(parse_requirement(std::string_view(list).substr(begin, end - begin), has_before));
    begin = end + 1;
  }
  return requirements;
}

std::optional<std::string> unmet(const Requirement& requirement, const SurfaceCheck& check) {
  return find_kind(requirement.word)->unmet(check, requirement.bound);
}

}  // namespace knead::command
