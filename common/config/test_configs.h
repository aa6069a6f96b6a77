// Configurations for the tests of this folder.
#pragma once

#include <string>

#include "common/config/robot_config.h"

namespace gw {

// Every section has values that differ from their defaults and need all their digits.
inline RobotConfig StereoRobotForTest() {
  RobotConfig c;
  c.robot.name = "test \"robot\" \\ 7";
  c.calibration.camera.kind = CameraKind::kStereo;
  c.calibration.camera.width = 752;
  c.calibration.camera.height = 480;
  c.calibration.camera.rate_hz = 20;
  c.calibration.camera.left = {
      458.654, 457.296, 367.215, 248.375, {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0}};
  c.calibration.camera.right = c.calibration.camera.left;
  c.calibration.camera.right.fx = 457.0 + 1.0 / 3.0;
  c.calibration.camera.T_C0C1 = SE3(ExpSO3({0.003, -0.015, 0.001}), {0.11, 0.0004, -0.0008});
  c.calibration.camera.T_BC = SE3(ExpSO3({-1.2, 1.21, -1.19}), {0.1, 1.0 / 7.0, 0.25});
  c.calibration.imu.present = true;
  c.calibration.imu.gyro_noise = 1.6968e-04;
  c.calibration.wheel.time_offset_s = -0.1 / 3.0;
  c.frontend.variant = Variant::kSwitch;
  c.frontend.orb.num_features = 1200;
  c.frontend.dr_weight.alpha_max = 12345.678901234567;
  c.backend.local_keyframes = 7;
  c.dr_ekf.source = DrSource::kRecorded;
  c.process.lcm_url = "memq://";
  return c;
}

}  // namespace gw
