// The commands of gw-calibrate. Each prints what it found and writes it down.
#pragma once

#include <string>

#include "common/core/result.h"

namespace gw::calibrate {

struct DriveOptions {
  std::string log, config, config_out;
};
Result<Done> RunDrive(const DriveOptions& options);

struct ImuOptions {
  std::string log, config, config_out;
};
// Error kBadData also where the standstill contradicts the configuration: nothing is written.
Result<Done> RunImu(const ImuOptions& options);

struct CameraOptions {
  std::string images, right_images;  // folders; right: of the right eye, same names; or empty
  std::string board, model;          // as ParseBoard; radtan or equidistant
  std::string config, config_out;    // empty: only printed
  std::string asl_out;               // folder for cam0/sensor.yaml and cam1/sensor.yaml; or empty
};
Result<Done> RunCamera(const CameraOptions& options);

}  // namespace gw::calibrate
