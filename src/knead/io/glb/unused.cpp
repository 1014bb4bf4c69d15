#include "knead/io/glb/unused.h"

#include <algorithm>
#include <map>
#include <optional>

#include "knead/io/glb/uses.h"

namespace knead::io_detail::glb {
namespace {

// By view, how often a value and all that is in it name it.
std::map<std::size_t, std::size_t> count_views(const Json& value) {
  std::map<std::size_t, std::size_t> count;
  std::vector<const Json*> waiting{&value};
  while (!waiting.empty()) {
    const Json& next = *waiting.back();
    waiting.pop_back();
    if (next.is_object()) {
      const Json* view = next.find("bufferView");
      if (view != nullptr && view->is_whole()) ++count[view->whole()];
      for (const JsonMember& member : next.members()) waiting.push_back(&member.value);
    } else if (next.is_array()) {
      for (const Json& item : next.items()) waiting.push_back(&item);
    }
  }
  return count;
}

bool uses_known_extensions(const Value& root) {
  for (std::size_t i = 0; i < root.count("extensionsUsed"); ++i) {
    const Json& name = root.item("extensionsUsed", i).json();
    if (!name.is_text() || !is_understood(name.text())) return false;
  }
  return true;
}

// Where a view lies in the binary chunk; an empty span in another buffer. Nothing where that is not said properly.
std::optional<Span> range_of(const Document& document, const Json& view) {
  const auto whole = [&](const char* key, std::size_t otherwise) -> std::optional<std::size_t> {
    if (!view.is_object()) return std::nullopt;
    const Json* found = view.find(key);
    if (found == nullptr) return otherwise;
    if (!found->is_whole()) return std::nullopt;
    return found->whole();
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

// In order, overlapping ones as one.
std::vector<Span> merged(std::vector<Span> spans) {
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.begin < b.begin; });
  std::vector<Span> result;
  for (const Span& span : spans) {
    if (span.begin == span.end) continue;
    if (result.empty() || result.back().end < span.begin) result.push_back(span);
    result.back().end = std::max(result.back().end, span.end);
  }
  return result;
}

}  // namespace

Unused unused_after(const Document& document, const std::set<std::pair<std::size_t, std::size_t>>& primitives) {
  Unused unused;
  if (!uses_known_extensions(document.root())) return unused;
  std::map<std::size_t, std::size_t> named;  // views, by the accessors that are unused
  for (const auto& [accessor, uses] : find_uses(document)) {
    const bool is_unused = std::all_of(uses.begin(), uses.end(), [&](const AccessorUse& use) {
      return primitives.count({use.mesh, use.primitive}) > 0;
    });
    if (!is_unused || accessor >= document.root().count("accessors")) continue;
    unused.accessors.push_back(accessor);
    for (const auto& [view, count] : count_views(document.root().item("accessors", accessor).json())) {
      named[view] += count;
    }
  }
  const std::map<std::size_t, std::size_t> all = count_views(document.json);
  for (const auto& [view, count] : named) {
    if (all.at(view) == count && view < document.root().count("bufferViews")) unused.views.push_back(view);
  }
  return unused;
}

Cuts::Cuts(const Document& document, const std::vector<bool>& is_replaced) {
  const Value root = document.root();
  std::vector<Span> kept;
  std::vector<Span> left;
  for (std::size_t v = 0; v < is_replaced.size(); ++v) {
    const std::optional<Span> range = range_of(document, root.item("bufferViews", v).json());
    if (!range) return;
    (is_replaced[v] ? left : kept).push_back(*range);
  }
  kept = merged(std::move(kept));
  for (const Span& range : merged(std::move(left))) subtract(range, kept);
}

// Adds the range without what is kept.
void Cuts::subtract(Span range, const std::vector<Span>& kept) {
  auto next = std::upper_bound(kept.begin(), kept.end(), range.begin,
                               [](std::size_t begin, const Span& span) { return begin < span.end; });
  for (; next != kept.end() && next->begin < range.end; ++next) {
    if (range.begin < next->begin) add({range.begin, next->begin});
    range.begin = std::min(range.end, next->end);
  }
  add(range);
}

void Cuts::add(Span span) {
  span = {(span.begin + 3) / 4 * 4, span.end / 4 * 4};
  if (span.begin >= span.end) return;
  through_.push_back((through_.empty() ? 0 : through_.back()) + span.end - span.begin);
  spans_.push_back(span);
}

std::size_t Cuts::moved(std::size_t position) const {
  const auto next = std::upper_bound(spans_.begin(), spans_.end(), position,
                                     [](std::size_t p, const Span& span) { return p < span.end; });
  return next == spans_.begin() ? position : position - through_[static_cast<std::size_t>(next - spans_.begin()) - 1];
}

std::string Cuts::applied(std::string_view bytes) const {
  std::string result;
  std::size_t copied = 0;
  for (const Span& cut : spans_) {
    result += bytes.substr(copied, cut.begin - copied);
    copied = cut.end;
  }
  result += bytes.substr(copied);
  return result;
}

}  // namespace knead::io_detail::glb
