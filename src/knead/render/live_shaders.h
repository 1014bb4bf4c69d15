// The GLSL 3.30 sources of the live view's programs. They write colours as the screen wants them.
#pragma once

#include "knead/render/live_view.h"
#include "knead/render/shaders.h"

namespace knead::render {

ShaderSource live_shape_source(Material material);
ShaderSource live_cloud_source();       // points -> discs
ShaderSource live_wire_source();        // edges of the polygons
ShaderSource live_depth_source();       // nothing but depth and stencil
ShaderSource live_cut_source();         // the cutting plane
ShaderSource live_background_source();  // at the far end of the depth range
ShaderSource live_image_source();       // a picture in the scene, at the far end of the depth range
ShaderSource live_rod_source();
ShaderSource live_glass_source();
ShaderSource live_occlusion_source();  // of every second sample each way
ShaderSource live_smooth_source();     // the same over 4 x 4 of them
ShaderSource live_relief_source();     // half the factor of brightness
ShaderSource live_present_source();    // the finished picture into the caller's framebuffer

}  // namespace knead::render
