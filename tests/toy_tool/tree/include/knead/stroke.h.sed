\|^// A stroke of any tool|i\
// A ball that is pushed once.\
struct ToyStroke {\
  Vec3d center;\
  Vec3d push;\
  double outer = 0;\
  double sharpness = 0.25;\
\
  static const detail::ToolRow<ToyStroke> tool;\
  friend bool operator==(const ToyStroke&, const ToyStroke&) = default;\
};\

s/^\( .*MaskStroke\)>;/\1, ToyStroke>;/
