#include "view/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>

#include "knead/error.h"
#include "knead/io.h"

namespace knead::studio {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFile = "references.json";
constexpr double kStraight = 0.9995;  // the cosine up to which a view is that of a plane
constexpr std::array kPlanes{ReferencePlane::front, ReferencePlane::right, ReferencePlane::top};

StandardView side_of(ReferencePlane plane) {
  switch (plane) {
    case ReferencePlane::front:
      return StandardView::front;
    case ReferencePlane::right:
      return StandardView::right;
    case ReferencePlane::top:
      return StandardView::top;
  }
  return StandardView::front;
}

// How directly a view looks at a plane: 1 from the front or the back, 0 along it.
double straightness(const View& view, ReferencePlane plane) {
  const Vec3d forward = render::camera_frame(camera_of(view)).forward;
  return std::abs(dot(forward, frame_of(plane, view.up).forward));
}

std::optional<std::string> bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream.is_open()) return std::nullopt;
  return std::string{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

// An object without members where there is no file, or another one.
Json read_all(const fs::path& folder) {
  const std::optional<std::string> text = bytes_of(folder / kFile);
  if (!text) return Json::object();
  try {
    Json all = parse_json(*text);
    return all.is_object() ? all : Json::object();
  } catch (const JsonError&) {
    return Json::object();
  }
}

Json json_of(const Reference& reference) {
  Json center = Json::array();
  for (std::size_t i = 0; i < 3; ++i) center.push_back(reference.center[i]);
  return Json{
      {"file", reference.file.string()},      {"plane", name_of(reference.plane)}, {"center", center},
      {"height", reference.height},           {"opacity", reference.opacity},      {"shown", reference.is_shown},
      {"every_view", reference.in_every_view}};
}

// Throws where a member is missing or of another type.
Reference reference_of(const Json& json) {
  Reference reference;
  reference.file = json.at("file").text();
  for (const ReferencePlane plane : kPlanes) {
    if (json.at("plane").text() == name_of(plane)) reference.plane = plane;
  }
  const std::vector<Json>& center = json.at("center").items();
  if (center.size() != 3) throw InvalidInput("a centre has three numbers");
  for (std::size_t i = 0; i < 3; ++i) reference.center[i] = center[i].number();
  reference.height = json.at("height").number();
  reference.opacity = std::clamp(json.at("opacity").number(), 0.0, 1.0);
  reference.is_shown = json.at("shown").flag();
  reference.in_every_view = json.at("every_view").flag();
  if (!(reference.height > 0)) throw InvalidInput("the height is not above 0");
  reference.image = read_reference(reference.file);
  return reference;
}

std::string key_of(const fs::path& document) {
  std::error_code error;
  const fs::path absolute = fs::absolute(document, error);
  return (error ? document : absolute.lexically_normal()).string();
}

}  // namespace

const char* name_of(ReferencePlane plane) {
  return std::array{"front", "right", "top"}[static_cast<std::size_t>(plane)];
}

render::CameraFrame frame_of(ReferencePlane plane, UpAxis up) {
  View view;
  view.up = up;
  return render::camera_frame(camera_of(seen_from(view, side_of(plane))));
}

ReferencePlane plane_of(const View& view) {
  return *std::max_element(kPlanes.begin(), kPlanes.end(), [&](ReferencePlane a, ReferencePlane b) {
    return straightness(view, a) < straightness(view, b);
  });
}

std::vector<render::PlacedImage> placed_images(const std::vector<Reference>& references, const View& view) {
  std::vector<render::PlacedImage> placed;
  for (const Reference& reference : references) {
    if (!reference.is_shown || reference.image == nullptr) continue;
    if (!reference.in_every_view && straightness(view, reference.plane) < kStraight) continue;
    const render::CameraFrame frame = frame_of(reference.plane, view.up);
    const double aspect = static_cast<double>(reference.image->width) / reference.image->height;
    placed.push_back({reference.image, reference.center, frame.right * (0.5 * reference.height * aspect),
                      frame.up * (0.5 * reference.height), static_cast<float>(reference.opacity)});
  }
  return placed;
}

std::shared_ptr<const render::Image> read_reference(const fs::path& file) {
  const std::optional<std::string> bytes = bytes_of(file);
  if (!bytes) throw IoError(IoError::Operation::read, file.string(), "the picture cannot be opened");
  try {
    return std::make_shared<const render::Image>(render::decode_image(*bytes));
  } catch (const InvalidInput& error) {
    throw InvalidInput(fmt::format("{}: {}", file.string(), error.what()));
  }
}

LoadedReferences load_references(const fs::path& folder, const fs::path& document) {
  LoadedReferences loaded;
  const Json all = read_all(folder);
  const Json* const own = document.empty() ? nullptr : all.find(key_of(document));
  if (own == nullptr || !own->is_array()) return loaded;
  for (const Json& item : own->items()) {
    try {
      loaded.references.push_back(reference_of(item));
    } catch (const std::exception& error) {
      loaded.messages.push_back(fmt::format("A reference image is left out: {}", error.what()));
    }
  }
  return loaded;
}

void save_references(const fs::path& folder, const fs::path& document, const std::vector<Reference>& references) {
  if (document.empty()) return;
  const std::string key = key_of(document);
  Json all = Json::object();
  const Json before = read_all(folder);
  for (const JsonMember& member : before.members()) {
    if (member.key != key) all.set(member.key, member.value);
  }
  Json own = Json::array();
  for (const Reference& reference : references) own.push_back(json_of(reference));
  if (!references.empty()) all.set(key, own);
  std::error_code error;
  fs::create_directories(folder, error);
  write_file_atomically(folder / kFile, to_indented_text(all));
}

}  // namespace knead::studio
