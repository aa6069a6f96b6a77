#include "tools/data/import/nominal_camera.h"

#include "tools/data/import/sensor_yaml.h"

namespace gw::importer {

void SetNominalCamera(const std::string& why, Recording& recording) {
  CameraCalibration& camera = recording.calibration.camera;
  camera.kind = CameraKind::kRgbd;
  camera.width = 848;
  camera.height = 480;
  camera.left = {610, 610, 424, 240, {}};
  camera.T_BC = PoseOfBodyAtCamera();
  recording.warnings.push_back(
      why + ": no images in the log, and the camera calibration is only nominal");
}

}  // namespace gw::importer
