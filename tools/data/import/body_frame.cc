#include "tools/data/import/body_frame.h"

namespace gw::importer {

void MoveBodyToWheels(const SE3& T_BN, Recording& recording) {
  const SE3 T_NB = T_BN.inverse();
  recording.calibration.camera.T_BC = T_NB * recording.calibration.camera.T_BC;
  recording.calibration.imu.T_BI = T_NB * recording.calibration.imu.T_BI;
  for (GroundTruth& truth : recording.ground_truth) truth.T_GB = truth.T_GB * T_BN;
}

}  // namespace gw::importer
