// How smooth the picture is, by how long it takes.
#pragma once

namespace knead::studio {

// Chooses between smooth edges and one sample per pixel. While pictures are slow, those of a moving scene get one
// sample, and a scene at rest is smooth again. Smooth edges return for good once they have become fast.
class PictureQuality {
 public:
  // Returns the samples per pixel of the next picture, as LiveScene::samples: 0 for all that the view has, or 1.
  int samples(bool is_still) const { return is_reduced_ && !is_still ? 1 : 0; }

  // Takes note of how long a picture with samples() took to be drawn.
  void note(double seconds, int samples);

 private:
  void note_smooth(double seconds);
  void note_reduced(double seconds);

  bool is_reduced_ = false;
  int in_a_row_ = 0;     // pictures that speak for a change
  double smooth_ = 0;    // seconds of the last smooth picture
  double cost_ = 1;      // of smoothness, as a factor
  bool is_new_ = false;  // the cost is not known since the last smooth picture
};

}  // namespace knead::studio
