// What the report of a pose says, as text.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "json/json.h"
#include "knead/fit.h"
#include "strokes/pose.h"

namespace knead {

namespace {

Json json_of(const SkinMeasures& measures) {
  return {{"volume_error", measures.volume_error},         {"crossings", measures.crossings},
          {"crossings_new", measures.crossings_new},       {"least_stretch", measures.least_stretch},
          {"greatest_stretch", measures.greatest_stretch}, {"rms_log_stretch", measures.rms_log_stretch}};
}

}  // namespace

std::string to_json(const SkinReport& report) {
  return to_indented_text({{"linear", json_of(report.linear)},
                           {"dual", json_of(report.dual)},
                           {"flow", json_of(report.flow)},
                           {"problem", complaint_about(report)},
                           {"reached", report.reached},
                           {"bones", report.bones},
                           {"stages", report.stages},
                           {"segments", report.segments},
                           {"unknowns", report.unknowns},
                           {"part_distance", report.part_distance},
                           {"part_distance_95", report.part_distance_95},
                           {"seconds", report.seconds},
                           {"notes", report.notes}});
}

std::string complaint_about(const SkinReport& report) {
  if (report.shortfall.empty()) return complaint_about(report.flow);
  return report.shortfall + "; turn these joints less, or those of limbs that are in the way";
}

std::string complaint_about(const SkinMeasures& flow) {
  if (flow.crossings_new > 0) {
    return fmt::format("{} in the pose that did not at rest; turn the joints there less",
                       flow.crossings_new == 1 ? "1 pair of triangles crosses"
                                               : fmt::format("{} pairs of triangles cross", flow.crossings_new));
  }
  const double worst = std::max(flow.greatest_stretch, 1 / flow.least_stretch);
  if (worst > kMaxPosedStretch) {
    return fmt::format("a triangle is stretched or pressed by {:.3g}, more than {:g}; turn the joints there less",
                       worst, kMaxPosedStretch);
  }
  return {};
}

}  // namespace knead
