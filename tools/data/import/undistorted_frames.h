// A recording whose lenses the front-end does not know, undistorted while it is read.
#pragma once

#include <memory>
#include <optional>

#include "tools/data/import/recording.h"
#include "tools/data/import/ros_camera.h"

namespace gw::importer {

// Frames of `source` through the undistorters of their eyes; an eye without one stays as it is.
// Load gives kBadData for an image of another size than its undistorter's.
std::unique_ptr<FrameSource> UndistortFrames(std::unique_ptr<FrameSource> source,
                                             std::optional<Undistorter> left,
                                             std::optional<Undistorter> right);

}  // namespace gw::importer
