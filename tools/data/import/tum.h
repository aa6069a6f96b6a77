// TUM RGB-D (Sturm et al. 2012): rgb.txt, depth.txt, groundtruth.txt.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tools/data/import/recording.h"

namespace gw::importer {

struct TumOptions : ReadOptions {
  std::string camera = "fr1";                   // preset: fr1, fr2, fr3
  std::optional<PinholeIntrinsics> intrinsics;  // instead of the preset
};

// Body: at the colour camera's optical centre, x forward, y left, z up. utime is the colour image's
// time. The accelerometer is not imported: an ImuSample needs a gyro.
Result<Recording> ReadTum(const std::filesystem::path& source, const TumOptions& options);

// "fx,fy,cx,cy[,k1,k2,p1,p2,k3]". Error: kInvalidArgument.
Result<PinholeIntrinsics> ParseIntrinsics(const std::string& text);

}  // namespace gw::importer
