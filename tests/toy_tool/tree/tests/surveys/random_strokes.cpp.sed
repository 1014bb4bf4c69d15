/^const std::vector<std::pair<std::string, Stroke/i\
Stroke toy(const Draw& draw) {\
  const double outer = draw.uniform(0.05, 0.3) * draw.size;\
  return ToyStroke{draw.near(draw.vertex()), draw.direction() * (0.5 * outer), outer};\
}\

s/{"bend", bend}/&, {"toy", toy}/
