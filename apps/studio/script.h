// Drives Studio by a script instead of a pointer: the same events, one line each.
//
// JSON Lines. Opening, recovering and choosing a stamp wait for the result; other commands do not. A place is [x, y] in
// pixels, or [x, y, z] in the scene, which means the pixel that shows it.
//   {"size": [1280, 800]}                      the view's size
//   {"open": FILE} {"new": "sphere", "vertices": 2562} {"recover": "newest"}
//   {"key": "Ctrl+Z"}                          pressed and let go
//   {"move": PLACE} {"press": PLACE} {"release": PLACE}      with "button" ("left") and "modifiers" (["ctrl"])
//   {"drag": [PLACE, PLACE, ...], "steps": 10}  pressed at the first, moved through all with so many events between
//                                               two, let go at the last; "button" and "modifiers" as above, "pressure"
//                                               of a pen: a number from 0 to 1 for each place (for "move": one number)
//   {"click": PLACE} {"wheel": 1, "modifiers": [...]} {"drop": [FILE, ...]}
//   {"tool": "ball"}                            its name in lower case
//   {"set": {"radius": 0.3, "inner_ratio": 0.4, "depth": 0.2, "drag": "view" | "surface" | "normal" |
//   "axis",
//            "falloff": 4, "axis": [0, 0, 1], "paint_in": true, "mirror": [true, false, false], "remesh": true,
//            "max_edge": 0.1, "start": "inside" | "surface" | "plane",
//            "radial": 8, "radial_axis": [0, 1, 0], "symmetry_center": [0, 0, 0], "mirror_plane": {"point": ...,
//            "normal": ...} | null, "capsule_length": 1, "stamp_size": 0.5, "limit_cylinder": true,
//            "contact": "stick" | "slip" | "auto"}}
//   {"set": {"pose": "pins" | "lasso" | "brush" | "exact", "detail": 0.075}}      of the tool "pose"; {"tool": "pins"}
//                                               is its mode "exact"
//   {"pins": [{"place": [0, 0, 1], "holds": true, "vertex": 17}], "of": 2562}    in the place of all pins: on the
//   vertex
//                                               if the shape has so many, else on the nearest one
//   {"view": {"yaw_deg": 20, "pitch_deg": 10, "target": [0, 0, 0], "height": 3, "projection": "perspective",
//             "field_of_view_deg": 50, "shift": [0.2, 0]}}      shift: where the target is seen, from -1 to 1
//   {"show": {"material": "matcap", "wireframe": true, "influence": true, "cut": true, "tool": false, ...}}
//   {"show": {"matcap": "red-wax", "cavity": true, "occlusion": true, "background": "dark"}}
//   {"reference": FILE, "plane": "front" | "right" | "top", "opacity": 0.5, "height": 2, "center": [0, 0, 0],
//    "every_view": false}                      a picture behind the shape; {"reference": null} removes all
//   {"add": FILE}                               a further shape
//   {"object": 1, "visible": false}             also "active": true, "remove": true; {"object": null}: none is active
//   {"stamp": "letter-y" | FILE} {"edit": 0, "strokes": [{"tool": ...}]} {"look_at": 1} {"look_at": null}
//   {"layer": 0, "name": "Horn"}                an entry of the history, counted from 0; also "off": true, "strength":
//                                               0.5, "drag_strength": [0.9, 0.5] (a slider), "move_to": 2, "join": true
//                                               (to the entry before), "split": true, "remove": true, "select": true
//   {"layer": null}                             no entry is selected
//   {"fit": FILE, "pairs": [[3, 17]], "surface": true, "grows": false, "run": true}    to another shape; pairs of
//                                               vertices; with "run": false its view only opens; {"fit": null} closes
//                                               it
//   {"turntable": "turn_%04d.png", "pictures": 36}
//   {"poster": FILE, "width": 3840, "height": 2160, "transparent": true, "ground": true, "pictures": 1}
//   {"save": FILE} {"export": FILE} {"picture": FILE} {"close": true}
//   {"sleep": 0.016}                            seconds; {"wait": true}: until the worker has done everything
#pragma once

#include <filesystem>
#include <functional>
#include <istream>
#include <string>

#include "studio.h"

namespace knead::studio {

// What a script needs besides Studio.
struct ScriptHost {
  std::function<void(const std::filesystem::path&)> picture{};  // writes what is seen as PNG; empty: refused
  std::function<void()> after_event{};                          // called after every event and command
};

// Runs a script. Files are relative to the working folder. Throws InvalidInput with the line for an unknown command.
// Studio's messages stay in its notices.
void run_script(std::istream& script, const std::string& name, Studio& studio, const ScriptHost& host);

// --- the view as a script
// ---------------------------------------------------------------------------------------------

// The camera, the tool, its settings and the pins as lines of a script, which the journal keeps: after a crash Studio
// looks as it did before.

// Returns the lines that give another Studio this view and these settings.
std::string script_of_view(Studio& studio);

// Carries the lines out. Reports and ignores what this version does not know.
void restore_view(Studio& studio, const std::string& script);

}  // namespace knead::studio
