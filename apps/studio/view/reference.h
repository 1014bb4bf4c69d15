// Pictures that stand behind the shape, to model after.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "gestures/navigation.h"
#include "knead/render.h"

namespace knead::studio {

// The side from which a picture is seen upright.
enum class ReferencePlane { front, right, top };

struct Reference {
  std::filesystem::path file;
  std::shared_ptr<const render::Image> image;
  ReferencePlane plane = ReferencePlane::front;
  Vec3d center;          // of the picture, in the scene
  double height = 1;     // scene units
  double opacity = 0.5;  // 0 to 1
  bool is_shown = true;
  bool in_every_view = false;  // not only from its side and the opposite one

  friend bool operator==(const Reference&, const Reference&) = default;
};

// Returns the name of a plane in files, which begins with a small letter.
const char* name_of(ReferencePlane plane);

// Returns the directions of the picture to the right and up, for a view whose up axis is this one.
render::CameraFrame frame_of(ReferencePlane plane, UpAxis up);

// Returns the plane that this view looks at most directly.
ReferencePlane plane_of(const View& view);

// Returns what a view shows of the references.
std::vector<render::PlacedImage> placed_images(const std::vector<Reference>& references, const View& view);

// Reads a PNG or JPEG file. Throws IoError or InvalidInput.
std::shared_ptr<const render::Image> read_reference(const std::filesystem::path& file);

// The references of a document, from references.json of the state folder; `document` is the file of its shape or
// session. Pictures that cannot be read any more are left out with a message.
struct LoadedReferences {
  std::vector<Reference> references;
  std::vector<std::string> messages;
};
LoadedReferences load_references(const std::filesystem::path& folder, const std::filesystem::path& document);

// Keeps them for the next time; those of other documents stay. Throws IoError(write).
void save_references(const std::filesystem::path& folder, const std::filesystem::path& document,
                     const std::vector<Reference>& references);

}  // namespace knead::studio
