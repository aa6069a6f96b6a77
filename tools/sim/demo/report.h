// A run as one HTML page that needs nothing else: numbers; the way with the map in 3-D, images with
// their features, charts over the whole run with one cursor, health and log, in the parts of
// gw-view's page. Where that page was not built: the plain form, with drawings and some images.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/config/frontend_config.h"
#include "common/core/result.h"
#include "tools/data/files/json_fwd.h"
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

// page: view::ReportTemplate(). messages: of RunRecorder. Error kBadData: no image had a pose, so
// that there is nothing to report.
Result<std::string> RenderReport(const ReportInput& input, const std::string& page,
                                 std::vector<tools::Json> messages);
// The form without scripts. The same errors.
Result<std::string> RenderPlainReport(const ReportInput& input);

}  // namespace gw::demo
