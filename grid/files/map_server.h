// The floor map as map_server of ROS keeps it: DIR/map.yaml and DIR/map.pgm, trinary.
#pragma once

#include <string>

#include "common/core/result.h"
#include "grid/core/floor_image.h"

namespace gw::grid {

// Occupied cells are 0, free ones 254, unknown ones 205; the row of the highest y comes first.
// Makes the folder; overwrites, each file at once. Errors: kBadData when nothing is known, kIo.
Result<Done> WriteMapServer(const std::string& directory, const FloorImage& image);

}  // namespace gw::grid
