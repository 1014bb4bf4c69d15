// The GLSL 3.30 sources of the renderer's programs.
#pragma once

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

ShaderSource clay_source();      // triangles -> reflectance, normal
ShaderSource cap_source();       // what a clipping plane has cut open, closed
ShaderSource disc_source();      // points -> reflectance, normal
ShaderSource shadow_source();    // depth seen from a light
ShaderSource lighting_source();  // adds the light of one pass
ShaderSource backdrop_source();  // background and ground shadow behind the lit shape
ShaderSource rod_source();       // solid things that are lit without shadows
ShaderSource glass_source();     // one layer of translucent surfaces
ShaderSource copy_source();      // a layer under those before it
ShaderSource resolve_source();   // samples to pixels, linear to sRGB

}  // namespace knead::render
