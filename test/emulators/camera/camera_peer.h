// The camera's end of the D4xx protocols: builds metadata, calibration tables and answers. The
// driver has the other halves; the tests hold the two against each other.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "drivers/camera/protocol/calibration_table.h"
#include "drivers/camera/protocol/hardware_monitor.h"
#include "drivers/camera/protocol/metadata.h"

namespace gw::camera {

// One metadata buffer as the kernel gives it. With `d4xx` it has the blocks of Intel, in their
// usual order and with one that nobody knows; otherwise it has the header alone, which still states
// the full length.
std::vector<uint8_t> EncodeMetadata(const FrameMetadata& metadata, bool d4xx);

struct StoredCalibration {
  float baseline_mm = 50;
  PinholePx full_hd{962.5, 962.5, 960, 540};  // 1920x1080
  PinholePx vga{385, 385.5, 320.25, 239.75};  // 640x480
};
// Table 25 with a right checksum; all entries but the two above are placeholders.
std::vector<uint8_t> EncodeDepthTable(const StoredCalibration& calibration);

// The answer to a request: the opcode again (or a negative error), the payload, and its length at
// the end.
std::vector<uint8_t> EncodeAnswer(int32_t echo, std::span<const uint8_t> payload);
std::vector<uint8_t> EncodeVersion(const FirmwareVersion& firmware, const std::string& asic_serial);

}  // namespace gw::camera
