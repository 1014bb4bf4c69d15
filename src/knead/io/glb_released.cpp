#include "knead/io/glb_released.h"

#include <algorithm>
#include <map>
#include <optional>

#include "knead/io/glb_sharing.h"

namespace knead::glb {
namespace {

// By view, how often a value and all that is in it name it.
std::map<std::size_t, std::size_t> count_views(const Json& value) {
  std::map<std::size_t, std::size_t> count;
  std::vector<const Json*> waiting{&value};
  while (!waiting.empty()) {
    const Json& next = *waiting.back();
    waiting.pop_back();
    if (next.is_object()) {
      const auto view = next.find("bufferView");
      if (view != next.end() && view->is_number_unsigned()) ++count[view->get<std::size_t>()];
    }
    if (!next.is_structured()) continue;
    for (const Json& item : next) waiting.push_back(&item);
  }
  return count;
}

bool uses_known_extensions(const Value& root) {
  for (std::size_t i = 0; i < root.count("extensionsUsed"); ++i) {
    const Json& name = root.item("extensionsUsed", i).json();
    if (!name.is_string() || !is_understood(name.get<std::string>())) return false;
  }
  return true;
}

// Where a view lies in the binary chunk; an empty span in another buffer. Nothing where that is not said properly.
std::optional<Span> range_of(const Document& document, const Json& view) {
  const auto whole = [&](const char* key, std::size_t otherwise) -> std::optional<std::size_t> {
    if (!view.is_object()) return std::nullopt;
    const auto found = view.find(key);
    if (found == view.end()) return otherwise;
    if (!found->is_number_unsigned()) return std::nullopt;
    return found->get<std::size_t>();
  };
  const std::optional<std::size_t> buffer = whole("buffer", 0);
  const std::optional<std::size_t> begin = whole("byteOffset", 0);
  const std::optional<std::size_t> size = whole("byteLength", 0);
  if (!buffer || !begin || !size) return std::nullopt;
  if (*buffer > 0) return Span{};
  const std::size_t all = document.bin.size();
  if (*begin > all || *size > all - *begin) return std::nullopt;
  return Span{*begin, *begin + *size};
}

}  // namespace

Released released_by(const Document& document, const std::set<std::pair<std::size_t, std::size_t>>& primitives) {
  Released released;
  if (!uses_known_extensions(document.root())) return released;
  std::map<std::size_t, std::size_t> named;  // views, by the accessors that are released
  for (const auto& [accessor, uses] : find_uses(document)) {
    const bool is_released = std::all_of(uses.begin(), uses.end(), [&](const AccessorUse& use) {
      return primitives.count({use.mesh, use.primitive}) > 0;
    });
    if (!is_released || accessor >= document.root().count("accessors")) continue;
    released.accessors.push_back(accessor);
    for (const auto& [view, count] : count_views(document.root().item("accessors", accessor).json())) {
      named[view] += count;
    }
  }
  const std::map<std::size_t, std::size_t> all = count_views(document.json);
  for (const auto& [view, count] : named) {
    if (all.at(view) == count && view < document.root().count("bufferViews")) released.views.push_back(view);
  }
  return released;
}

std::vector<Span> bytes_of_views_alone(const Document& document, const std::vector<std::size_t>& views) {
  const Value root = document.root();
  std::vector<Span> kept;
  std::vector<Span> left;
  for (std::size_t v = 0; v < root.count("bufferViews"); ++v) {
    const std::optional<Span> range = range_of(document, root.item("bufferViews", v).json());
    if (!range) return {};
    (std::find(views.begin(), views.end(), v) == views.end() ? kept : left).push_back(*range);
  }
  const auto by_begin = [](const Span& a, const Span& b) { return a.begin < b.begin; };
  std::sort(kept.begin(), kept.end(), by_begin);
  std::sort(left.begin(), left.end(), by_begin);
  std::vector<Span> alone;
  std::size_t done = 0;
  const auto add = [&](std::size_t begin, std::size_t end) {
    begin = (std::max(begin, done) + 3) / 4 * 4;
    end = end / 4 * 4;
    if (begin < end) alone.push_back({begin, end});
    done = std::max(done, end);
  };
  for (Span range : left) {
    for (const Span& other : kept) {
      if (other.begin == other.end || other.end <= range.begin) continue;
      if (other.begin >= range.end) break;
      add(range.begin, other.begin);
      range.begin = std::min(range.end, other.end);
    }
    add(range.begin, range.end);
  }
  return alone;
}

}  // namespace knead::glb
