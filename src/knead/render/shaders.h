// The GLSL 3.30 sources of the renderer's programs.
#pragma once

#include <compare>
#include <string>

namespace knead::render {

// The most lights that the lighting program takes in one pass.
inline constexpr int kLightsPerPass = 32;

// Light whose direction makes a smaller cosine with the ground's normal casts no shadow on the ground.
inline constexpr double kGrazingCosine = 0.15;

struct ShaderSource {
  std::string vertex;
  std::string fragment;
};

// How shapes are shaded.
struct ShapeLook {
  bool matcap = false;
  bool cavity = false;
  bool occlusion = false;

  friend auto operator<=>(const ShapeLook&, const ShapeLook&) = default;
};

// A program that runs `fragment` once for every texel, with the declarations of `kView` before it.
ShaderSource full_screen_program(const std::string& fragment);

ShaderSource clay_source();                              // triangles -> reflectance, normal
ShaderSource cap_source();                               // what a clipping plane has cut open, closed
ShaderSource disc_source();                              // points -> reflectance, normal
ShaderSource shape_light_source(const ShapeLook& look);  // adds the light of one pass to shapes
ShaderSource ground_light_source();                      // adds the light that the ground lacks in one pass
ShaderSource even_source();                              // marks the pixels that one look at the lights suffices for,
ShaderSource uneven_source();                            // the samples of shapes in the others,
ShaderSource sees_ground_source();                       // and where the ground is
ShaderSource ground_source();                            // the shadow on the ground
ShaderSource backdrop_source();                          // background and ground shadow behind the lit shape
ShaderSource rod_source();                               // solid things that are lit without shadows
ShaderSource glass_source();                             // one layer of translucent surfaces
ShaderSource copy_source();                              // a layer under those before it
ShaderSource resolve_source();                           // samples to pixels, linear to sRGB

}  // namespace knead::render
