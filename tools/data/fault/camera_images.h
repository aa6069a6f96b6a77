// The images of one camera message, to be edited.
#pragma once

#include <opencv2/core.hpp>

#include "common/wire/wire.h"
#include "tools/data/fault/camera_optics.h"

namespace gw::fault {

// Copies that may be changed; empty where the message has none. Grey 8 bit, depth 16 bit.
struct CameraImages {
  cv::Mat left, right, depth;
};
CameraImages CopyImages(const CameraFrame& frame);

// The frame with these images, encoded. An image that is empty here is left out.
wire::Bytes EncodeWith(CameraFrame frame, const CameraImages& images);

}  // namespace gw::fault
