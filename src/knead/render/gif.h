// Animated GIF files, encoded picture by picture. Source: CompuServe, "Graphics Interchange Format, Version 89a"
// (1990), with the looping extension of Netscape. Internal to the renderer and the command.
#pragma once

#include <string>

#include "knead/render/image.h"

namespace knead::render {

// The parts of a file: a header, the pictures, the end. It is played in a loop.
std::string gif_header(int width, int height);

// Returns a picture that is shown for so many hundredths of a second. Only what differs from the picture before it is
// stored; null: there is none. Of more than 255 colours it keeps 255 by median cut. Transparent pixels become white.
// Throws InvalidInput for a picture of another size than `before`, or of more than 65535 pixels along a side.
std::string gif_picture(const Image& image, const Image* before, int hundredths);

std::string gif_end();

}  // namespace knead::render
