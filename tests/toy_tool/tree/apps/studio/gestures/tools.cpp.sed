/^constexpr const char\* kPullHint/i\
Stroke pushed(const ToolSettings& settings, const Placement& at, double amount, const CylinderPlacement* /*limit_cylinder*/) {\
  return ToyStroke{at.center, at.z * amount, settings.radius, settings.inner_ratio};\
}\

/\.name = "Pose"/i\
    {.name = "Toy",\
     .key = "Shift+1",\
     .use = ToolUse::turn,\
     .has_inner = true,\
     .hint = kTurnHint,\
     .second_hint = kTurnAgain,\
     .icon = {{disc, {0, 0, 0.5F}}},\
     .turning = {.facing = Facing::surface, .stroke = pushed}},
