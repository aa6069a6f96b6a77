// Image files of a recording.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tools/data/import/recording.h"

namespace gw::importer {

// 8-bit grey is kept as it is. 8-bit colour becomes round(0.299 R + 0.587 G + 0.114 B) (ITU-R
// BT.601 luma). Anything else is an error.
Result<Image> LoadGreyImage(const std::filesystem::path& file);
// 16-bit, one channel, kept as it is.
Result<Image> LoadDepthImage(const std::filesystem::path& file);

// The conversion of one pixel.
constexpr uint8_t GreyOf(int red, int green, int blue) {
  return static_cast<uint8_t>((299 * red + 587 * green + 114 * blue + 500) / 1000);
}
// How the colour conversion is stated in a NOTE.
inline constexpr const char* kGreyConversion = "grey = round(0.299 R + 0.587 G + 0.114 B)";

// One instant as files; right or depth is empty.
struct FrameFiles {
  Utime utime;
  std::filesystem::path left, right, depth;
  std::string listed_at;  // "FILE:LINE" of the list that names the files
};

// Leaves out (skip_missing) or refuses frames with a file that is not there, reads the image size
// of the first one that can be read into the camera calibration, and its rate. The error names
// every file that is not there or cannot be read.
Result<std::unique_ptr<FrameSource>> MakeFileFrames(std::vector<FrameFiles> files,
                                                    const ReadOptions& options,
                                                    Recording& recording);

}  // namespace gw::importer
