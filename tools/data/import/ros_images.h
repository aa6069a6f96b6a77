// Images of ROS messages: sensor_msgs/Image and sensor_msgs/CompressedImage, also of depth.
#pragma once

#include <string>

#include "common/core/result.h"
#include "tools/data/import/recording.h"
#include "tools/data/import/ros_reader.h"

namespace gw::importer {

bool IsImageType(const std::string& type);

// Encoding of a raw image ("mono8"), format of a compressed one ("16UC1; compressedDepth png").
Result<std::string> DecodeRosEncoding(const RosMessage& message, const std::string& type);
// True for an encoding or format of depth.
bool IsDepthEncoding(const std::string& encoding);

// Grey of mono8 and 8UC1 as it is; the upper byte of mono16 and 16UC1; colour (rgb8, bgr8, rgba8,
// bgra8, 8UC3, 8UC4, bayer, JPEG, PNG) by kGreyConversion; luma of yuv422. Error: kBadData.
Result<Image> DecodeRosGrey(const RosMessage& message, const std::string& type);

// 16UC1 and mono16 as they are; 32FC1 (metres) rounded to depth_unit_m, values that are not finite,
// negative or too large for 16 bits become 0, no depth; the same of a compressedDepth PNG
// (image_transport_plugins: 12 bytes of configuration in front, 32-bit depth as scaled inverse).
Result<Image> DecodeRosDepth(const RosMessage& message, const std::string& type,
                             double depth_unit_m);

}  // namespace gw::importer
