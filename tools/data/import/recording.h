// A recording as values: what every format reader hands to the log writer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/camera/calibration.h"
#include "common/contract/dead_reckoning.h"
#include "common/contract/samples.h"
#include "common/core/image_view.h"
#include "common/core/result.h"

namespace gw::importer {

// Pixels with their owner; rows are contiguous.
struct Image {
  int width = 0, height = 0;
  PixelFormat format = PixelFormat::kNone;
  std::vector<uint8_t> bytes;
  bool converted = false;  // colour source, made grey: not lossless

  ImageView view() const {
    if (bytes.empty()) return {};
    return {bytes.data(), width, height, width * BytesPerPixel(format), format};
  }
};

// The pixels of one camera instant; right is empty for RGB-D, depth for stereo.
struct FramePixels {
  Image left, right, depth;
};

// The images of a recording in time order. They are read one by one while the log is written,
// because a recording does not fit into memory.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual size_t size() const = 0;
  virtual Utime utime(size_t index) const = 0;
  // Error: kNotFound or kBadData, names the file.
  virtual Result<FramePixels> Load(size_t index) const = 0;
};

// Times of all samples increase strictly within each stream. seq is given by the log writer.
struct Recording {
  std::string name;    // of the source folder
  std::string format;  // subcommand of gw-import
  Calibration calibration;
  std::unique_ptr<FrameSource> frames;  // null: a recording without images
  std::vector<ImuSample> imu;
  std::vector<WheelSample> wheel;
  std::vector<DrState> dr;
  std::vector<GroundTruth> ground_truth;
  std::vector<std::pair<std::string, std::string>> notes;  // key, text: facts kept in the log
  std::vector<std::string> warnings;                       // also shown to the user
  int64_t skipped_frames = 0;                              // --skip-missing
};

struct ReadOptions {
  // Frames whose files are not there, or cannot be read, are counted and left out.
  bool skip_missing = false;
};

// Name of a source folder, also when it is given as "." or with a slash at the end.
std::string FolderName(const std::filesystem::path& source);

// Sets which sensors the calibration has, and their rates, from the samples that are there.
void DescribeSensors(Recording& recording);

}  // namespace gw::importer
