#include "bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "command.h"
#include "output.h"

namespace knead::command {
namespace {

using Complaint = std::optional<std::string>;

Complaint complain_if(bool bad, const std::string& text) { return bad ? Complaint(text) : std::nullopt; }

Complaint volume_changed(const Certificate& c, double limit) {
  return complain_if(!(std::abs(*c.volume_error) <= limit),
                     fmt::format("the volume changed by a fraction of {:.2g}, more than {:g}", *c.volume_error, limit));
}

Complaint crosses(const Certificate& c, double limit) {
  return complain_if(static_cast<double>(c.crossings_after) > limit,
                     fmt::format("{} of triangles cross ({} did before), more than {:g}",
                                 counted(c.crossings_after, "pair"), c.crossings_before, limit));
}

Complaint is_flipped(const Certificate& c, double limit) {
  return complain_if(static_cast<double>(c.flipped_triangles) > limit,
                     fmt::format("{} flipped, more than {:g}", counted(c.flipped_triangles, "triangle"), limit));
}

Complaint is_narrow(const Certificate& c, double limit) {
  if (!c.touched_angle_after) return std::nullopt;  // nothing was touched
  return complain_if(*c.touched_angle_after < limit, fmt::format("a triangle has an angle of {:.3g} degrees, less than "
                                                                 "{:g}",
                                                                 *c.touched_angle_after, limit));
}

Complaint is_far(const char* which, double distance, double limit) {
  return complain_if(!(distance <= limit),
                     fmt::format("the {} distance to the exact image is {:.2g} of the box diagonal, more than {:g}",
                                 which, distance, limit));
}

struct Kind {
  std::string_view name;
  std::string_view placeholder;
  double greatest;  // the largest limit that is accepted
  bool whole;       // the limit is a whole number
  Cure cure;
  Complaint (*unmet)(const Certificate& certificate, double limit);
};

constexpr std::string_view kVolume = "volume";

constexpr std::array kKinds{
    Kind{kVolume, "FRACTION", 1, false, Cure::shorter_chords, volume_changed},
    Kind{kCrossingsBound, "N", 1e9, true, Cure::shorter_chords, crosses},
    Kind{"flipped", "N", 1e9, true, Cure::shorter_chords, is_flipped},
    Kind{"min-angle", "DEGREES", 60, false, Cure::more_rounds, is_narrow},
    Kind{"distance", "FRACTION", 1, false, Cure::shorter_chords,
         [](const Certificate& c, double limit) { return is_far("root-mean-square", c.distance_rms, limit); }},
    Kind{"distance-max", "FRACTION", 1, false, Cure::shorter_chords,
         [](const Certificate& c, double limit) { return is_far("greatest", c.distance_max, limit); }},
};

const Kind& kind_named(std::string_view name, std::string_view item) {
  const auto* const kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& each) { return each.name == name; });
  if (kind == kKinds.end()) {
    throw UsageError(fmt::format("--require: no bound '{}'; choose from {}", item, known_bounds()));
  }
  return *kind;
}

Bound parse_bound(std::string_view item) {
  const std::size_t equals = item.find('=');
  const Kind& kind = kind_named(item.substr(0, equals), item);
  Bound bound{std::string(kind.name), 0};
  const std::string_view number = equals == std::string_view::npos ? "" : item.substr(equals + 1);
  const char* const end = number.data() + number.size();
  const auto [stop, error] = std::from_chars(number.data(), end, bound.limit);
  const bool good = error == std::errc() && stop == end && bound.limit >= 0 && bound.limit <= kind.greatest &&
                    (!kind.whole || bound.limit == std::floor(bound.limit));
  if (good) return bound;
  throw UsageError(
      fmt::format("--require {}: say {}={}, {}", item, kind.name, kind.placeholder,
                  kind.whole ? "a whole number, 0 or more" : fmt::format("a number from 0 to {:g}", kind.greatest)));
}

}  // namespace

std::string known_bounds() {
  std::string names;
  for (const Kind& kind : kKinds) {
    names += fmt::format("{}{}={}", names.empty() ? "" : ", ", kind.name, kind.placeholder);
  }
  return names;
}

std::vector<Bound> parse_bounds(const std::string& list) {
  std::vector<Bound> bounds;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    bounds.push_back(parse_bound(std::string_view(list).substr(begin, end - begin)));
    begin = end + 1;
  }
  return bounds;
}

std::optional<Unmet> unmet(const Bound& bound, const Certificate& certificate) {
  if (bound.name == kVolume && !certificate.volume_error) {
    return Unmet{"the shape has no volume because it is not closed and oriented; leave this bound out"};
  }
  const Kind& kind = kind_named(bound.name, bound.name);
  const Complaint complaint = kind.unmet(certificate, bound.limit);
  if (!complaint) return std::nullopt;
  return Unmet{*complaint, kind.cure};
}

}  // namespace knead::command
