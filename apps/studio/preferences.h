// The files that Studio keeps from one start to the next: preferences with the look of the shape, the files opened
// last, and the pictures behind the shape.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gestures/navigation.h"
#include "keys.h"
#include "knead/editor/render.h"
#include "platform/window.h"

namespace knead::studio {

// Return $XDG_CONFIG_HOME/knead and $XDG_STATE_HOME/knead, by default ~/.config/knead and ~/.local/state/knead. As the
// standard says, a variable that is no absolute path counts as not set. Without a home folder, they are temporary
// folders.
std::filesystem::path config_folder();
std::filesystem::path state_folder();

// The backend that moves the shape during a drag. The result always comes from the CPU.
enum class BackendChoice { cpu, gpu };

// The unit of the numbers in shape files, as the user sets it; it is shown with lengths.
enum class LengthUnit { none, millimetre, centimetre, metre };
const char* text_of(LengthUnit unit);  // "", "mm", "cm", "m"

// The state of the panels.
struct PanelState {
  bool shown = true;
  bool history = true;
  bool labels = false;                              // names beside the icons of the tool bar
  double width = 308;                               // of the side panel, in points
  std::vector<std::string> closed{"tool", "view"};  // parts of the side panel that are folded

  friend bool operator==(const PanelState&, const PanelState&) = default;
};

// The look of the shape.
struct Look {
  render::Material material = render::Material::matcap;
  render::Matcap matcap = render::Matcap::terracotta;
  render::Relief relief{.cavity = true};
  std::string background = "gradient";  // as render::background_named
  render::Projection projection = render::Projection::perspective;
  double field_of_view_deg = 30;

  friend bool operator==(const Look&, const Look&) = default;
};

struct Preferences {
  KeyMap keys = default_keys();
  NavigationPreset navigation = NavigationPreset::blender;
  UpAxis up = UpAxis::y;
  BackendChoice backend = BackendChoice::cpu;
  LengthUnit unit = LengthUnit::none;
  PenPressure pressure = PenPressure::depth;
  // Colours of the rings at the cursor. People with colour vision deficiency can tell the defaults apart.
  render::Color outer_ring{0.00f, 0.45f, 0.70f, 1};
  render::Color inner_ring{0.90f, 0.62f, 0.00f, 1};
  PanelState panels;
  WindowPlace window;
  Look look;
  bool welcome = true;           // the sheet at the start
  bool desktop_dialogs = true;   // the desktop's own dialog asks for files, if it has one
  double interface_scale = 1;    // of texts and panels, times the display's scale; from 0.5 to 3
  double undo_memory_mb = 1024;  // of the states that undo keeps, from 0 to 1e6; older ones are computed again
};

struct LoadedPreferences {
  Preferences preferences;
  std::vector<std::string> messages;  // one line for each ignored setting
};

// Reads studio.json of this folder, e.g. {"keys": {"undo": "Ctrl+Z", "redo": ["Ctrl+Y", "F5"]}, "navigation": "maya",
// "up": "z", "backend": "gpu", "interface_scale": 1.25, "unit": "mm", "outer_ring": "#0073b3", "inner_ring": "#e69e00",
// "shading": "matcap", "matcap": "jade", "cavity": true, "occlusion": true, "background": "#303540", "projection":
// "orthographic", "field_of_view_deg": 50}. Missing settings have their defaults. Invalid ones are ignored with a
// message, and a file that is no JSON object is renamed to studio.json.broken.
LoadedPreferences load_preferences(const std::filesystem::path& folder);

// Writes the settings that differ from the defaults, without the keys, to studio.json. Keys and unknown settings in the
// file stay. The file is replaced as a whole. Throws IoError(write).
void save_preferences(const std::filesystem::path& folder, const Preferences& preferences);

// Returns the files that were opened last, the latest first, from recent.json of the state folder. Files that no longer
// exist are left out; a broken list counts as empty.
std::vector<std::filesystem::path> load_recent(const std::filesystem::path& folder);

// Puts a file in front of the list, which holds at most kMaxRecent files, each once.
inline constexpr std::size_t kMaxRecent = 12;
void add_recent(std::vector<std::filesystem::path>& recent, const std::filesystem::path& file);

// Throws IoError(write).
void save_recent(const std::filesystem::path& folder, std::span<const std::filesystem::path> recent);

// --- pictures that stand behind the shape, to model after
// -------------------------------------------------------------

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

// Returns the references that a view shows.
std::vector<render::PlacedImage> placed_images(const std::vector<Reference>& references, const View& view);

// Reads a PNG or JPEG file. Throws IoError or InvalidInput.
std::shared_ptr<const render::Image> read_reference(const std::filesystem::path& file);

// The references of a document, from references.json of the state folder; `document` is the file of its shape or
// session. Pictures that cannot be read are left out with a message.
struct LoadedReferences {
  std::vector<Reference> references;
  std::vector<std::string> messages;
};
LoadedReferences load_references(const std::filesystem::path& folder, const std::filesystem::path& document);

// Writes the references of a document; those of other documents stay. Throws IoError(write).
void save_references(const std::filesystem::path& folder, const std::filesystem::path& document,
                     const std::vector<Reference>& references);

}  // namespace knead::studio
