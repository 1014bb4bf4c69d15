// What stays beside the document: reference images and how the shape is looked at.
#include <cmath>
#include <exception>
#include <utility>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "studio.h"

namespace knead::studio {

namespace {

// The file of the document, by which its references are found again; empty if there is none.
std::filesystem::path file_of(const DocumentState& shown) {
  return shown.shape_path.empty() ? shown.session_path : shown.shape_path;
}

}  // namespace

// References of a shape without a file stay while Studio runs.
void Studio::load_own_references() {
  if (file_of(shown_).empty() && saved_references_.empty()) return;
  LoadedReferences loaded = load_references(options_.state, file_of(shown_));
  references_ = std::move(loaded.references);
  saved_references_ = references_;
  for (std::string& message : loaded.messages) tell({true, std::move(message)});
}

bool Studio::add_reference(const std::filesystem::path& file) {
  if (shown_.opened == 0) return false;
  Reference reference;
  reference.file = std::filesystem::absolute(file);
  try {
    reference.image = read_reference(file);
  } catch (const std::exception& error) {
    tell({true, error.what()});
    return false;
  }
  const Box box = shape_box(shown_.state.to_mesh());
  reference.plane = plane_of(navigation_.view);
  reference.center = box.center();
  const Vec3d up = frame_of(reference.plane, navigation_.view.up).up;
  reference.height = std::abs(dot(box.max - box.min, up));
  if (!(reference.height > 0)) reference.height = shown_.diagonal;
  references_.push_back(std::move(reference));
  view_.references = true;
  return true;
}

void Studio::remember_look() {
  try {
    if (references_ != saved_references_) save_references(options_.state, file_of(shown_), references_);
    saved_references_ = references_;
  } catch (const IoError& error) {
    tell({true, error.what()});
  }
  Look look = view_.look;
  look.projection = navigation_.view.projection;
  look.field_of_view_deg = navigation_.view.field_of_view_deg;
  if (look == preferences_.look) return;
  preferences_.look = look;
  save_preferences();
}

}  // namespace knead::studio
