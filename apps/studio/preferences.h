// What Studio remembers from one start to the next, and where: preferences, how the shape is drawn, the files opened
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

// $XDG_CONFIG_HOME/knead and $XDG_STATE_HOME/knead, by default ~/.config/knead and ~/.local/state/knead. As the
// standard says, a variable that is no absolute path counts as not set; without a home, a folder of the temporary ones.
std::filesystem::path config_folder();
std::filesystem::path state_folder();

// What moves the shape during a drag. The result always comes from the CPU.
enum class BackendChoice { cpu, gpu };

// The unit of the numbers in shape files, as the person says; it is shown with lengths.
enum class LengthUnit { none, millimetre, centimetre, metre };
const char* text_of(LengthUnit unit);  // "", "mm", "cm", "m"

// How the panels were left.
struct PanelState {
  bool shown = true;
  bool history = true;
  bool labels = false;                              // names beside the icons of the tool bar
  double width = 308;                               // of the side panel, in points
  std::vector<std::string> closed{"tool", "view"};  // parts of the side panel that are folded

  friend bool operator==(const PanelState&, const PanelState&) = default;
};

// How the shape is drawn.
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
  // Of the rings at the cursor. The defaults are colours that people who see few colours tell apart.
  render::Color outer_ring{0.00f, 0.45f, 0.70f, 1};
  render::Color inner_ring{0.90f, 0.62f, 0.00f, 1};
  PanelState panels;
  WindowPlace window;
  Look look;
  bool welcome = true;           // the sheet at the start
  bool desktop_dialogs = true;   // the desktop's own dialog asks for files, where there is one
  double interface_scale = 1;    // of texts and panels beyond what the display asks for, from 0.5 to 3
  double undo_memory_mb = 1024;  // of the states that undo reaches at once, from 0 to 1e6; older ones are made again
};

struct LoadedPreferences {
  Preferences preferences;
  std::vector<std::string> messages;  // what could not be used, a line each
};

// Reads studio.json of this folder, e.g. {"keys": {"undo": "Ctrl+Z", "redo": ["Ctrl+Y", "F5"]}, "navigation": "maya",
// "up": "z", "backend": "gpu", "interface_scale": 1.25, "unit": "mm", "outer_ring": "#0073b3", "inner_ring":
// "#e69e00", "shading": "matcap", "matcap": "jade", "cavity": true, "occlusion": true, "background": "#303540",
// "projection": "orthographic", "field_of_view_deg": 50}. What is missing is as by default. Nothing in it is fatal:
// what cannot be used is left out with a message, and a file that is no JSON object is renamed to studio.json.broken.
LoadedPreferences load_preferences(const std::filesystem::path& folder);

// Writes what differs from the defaults, all but the keys, into studio.json; keys and whatever else a person wrote
// there stay. The file is replaced whole. Throws IoError(write).
void save_preferences(const std::filesystem::path& folder, const Preferences& preferences);

// The files that were opened last, the latest first, from recent.json of the state folder. Those that are there no
// longer are left out; a broken file counts as none.
std::vector<std::filesystem::path> load_recent(const std::filesystem::path& folder);

// Puts a file in front of the list, which holds at most kMaxRecent, each once.
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
