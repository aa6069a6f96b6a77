// A run as one HTML page that needs nothing else: numbers, the way on the floor map, tracking
// quality and error over time with the blind spans shaded, latency, camera images with their
// features.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/config/frontend_config.h"
#include "common/core/result.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/monitor/monitor.h"
#include "tools/sim/demo/image_samples.h"
#include "tools/sim/demo/run_analysis.h"

namespace gw::demo {

struct ReportInput {
  std::string title;
  const tools::Monitor* monitor = nullptr;
  const ImageSamples* images = nullptr;
  std::optional<floorplan::FloorMap> map;  // drawn where truth ties the run to it
  OrbConfig orb;                           // of the features drawn
};

// Error kBadData: no image had a pose, so that there is nothing to report.
Result<std::string> RenderReport(const ReportInput& input);

}  // namespace gw::demo
