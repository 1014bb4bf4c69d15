// Where a stamp's tool slides along the surface: the contacts as pins (method, end of section 9). Internal to the tool
// room.
#pragma once

#include <optional>
#include <vector>

#include "knead/tool/contacts.h"

namespace knead::tool_detail {

// Places inside the tool become pins that go the shortest way out. Places where the tool has been become pins that
// stay, so that the flow back does not fill the groove behind the tool.
class SlippingContacts {
 public:
  // The tool must outlive this. radius: of the pins.
  SlippingContacts(const StampTool& tool, double radius) : tool_(tool), radius_(radius) {}

  // Remembers, as if the tool had been there, what is nearer than `distance` to the tool at the step's end.
  void hold_what_touches(const LiveSurface& surface, const StampStep& step, double distance);

  // Returns the pins that push the surface out of the tool at the step's end; nothing where it is out.
  std::optional<PinsStroke> pins(const LiveSurface& surface, const StampStep& step);

 private:
  bool is_near(const Vec3d& point, const std::vector<Intrusion>& moving) const;

  const StampTool& tool_;
  double radius_;
  std::vector<Place> pressed_;  // where the tool has been; half as far apart as pins
};

}  // namespace knead::tool_detail
