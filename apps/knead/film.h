// What `knead render --frames` and `--turntable` write: numbered pictures, an animated GIF, or a film by ffmpeg.
#pragma once

#include <functional>
#include <string>

#include "picture.h"

namespace knead::command {

struct FilmRequest {
  std::string output;  // a pattern as F_%04d.png, or a name that ends in .gif or .mp4
  int pictures = 1;
  double fps = 24;
  // Calls draw for one picture after the other; all have the same size.
  std::function<void(const std::function<void(const PictureRequest&)>& draw)> play{};
};

// Throws UsageError for another kind of file, and where ffmpeg is missing for an .mp4.
void check_film_output(const std::string& output);

// Draws and writes the film. A GIF or film appears whole or not at all; numbered pictures appear one by one. Throws as
// draw_picture, IoError(write), and std::runtime_error where ffmpeg fails.
void write_film(const FilmRequest& film, bool quiet);

}  // namespace knead::command
