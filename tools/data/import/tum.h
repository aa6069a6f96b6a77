// TUM RGB-D (Sturm et al. 2012): rgb.txt, depth.txt, groundtruth.txt.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tools/data/import/recording.h"

namespace gw::importer {

struct TumOptions : ReadOptions {
  std::string camera;  // preset: fr1, fr2, fr3; empty: as the folder's name says (freiburg2, fr3)
  std::optional<PinholeIntrinsics> intrinsics;  // instead of the preset
  std::optional<double> depth_unit_m;           // metres per unit of depth; TUM's own: 1/5000
};

// Body: at the colour camera's optical centre, x forward, y left, z up. utime is the colour image's
// time. The accelerometer is not imported: an ImuSample needs a gyro.
//
// A preset holds the intrinsics that the data set publishes for 640 x 480 and the Kinect's rolling
// shutter; other sizes of that
// shape are scaled, others refused, and where neither the folder's name nor an option names
// the camera, freiburg1 is assumed with a warning. Intrinsics given come with neither.
Result<Recording> ReadTum(const std::filesystem::path& source, const TumOptions& options);

// "fx,fy,cx,cy[,k1,k2,p1,p2,k3]", fx above 0; an fy below 0 is a camera frame whose y axis points
// up (ICL-NUIM), which ReadTum turns. Error: kInvalidArgument.
Result<PinholeIntrinsics> ParseIntrinsics(const std::string& text);

}  // namespace gw::importer
