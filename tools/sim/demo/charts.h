// The charts of the report.
#pragma once

#include <optional>

#include "tools/lab/plot/drawing.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/sim/demo/run_analysis.h"

namespace gw::demo {

// True and estimated way over the walls; where vision was blind, in another colour.
plot::Drawing FloorChart(const RunAnalysis& run, const std::optional<floorplan::FloorMap>& map);
// Q, alpha and (with truth) the position error over time, blind spans shaded.
plot::Drawing TimeChart(const RunAnalysis& run);
// From the arrival of an image to that of its pose.
plot::Drawing LatencyChart(const RunAnalysis& run);

}  // namespace gw::demo
