// Tuning of the dead-reckoning filter (section `dr_ekf`). Sensor noise is calibration, not tuning.
#pragma once

#include "common/core/fields.h"

namespace gw {

enum class DrSource {
  kSensors,   // filter IMU and WHEEL
  kRecorded,  // the log already holds DR (made by an importer or an earlier run): pass it on
};

struct DrEkfConfig {
  DrSource source = DrSource::kSensors;
  double wheel_sigma_m_per_sqrt_m = 0.005;
  double wheel_sigma_deg_per_sqrt_m = 1.0;
  double wheel_sigma_deg_per_sqrt_rad = 1.0;
  double wheel_scale_sigma = 0.01;
  double gyro_scale_sigma = 0.008;
  double lateral_sigma_m_per_sqrt_m = 0.002;
  double gate_sigma = 4.0;
  double max_speed_m_s = 3.0;
  double max_yaw_rate_deg_s = 570;
  double max_acceleration_m_s2 = 5.0;
  int history_ms = 1000;
  int stationary_ms = 300;
  double pose_correction_m_s = 0.1;
  double pose_correction_deg_s = 5;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Enum("source", source, {{"sensors", DrSource::kSensors}, {"recorded", DrSource::kRecorded}},
           {.text = "filter the sensors, or pass on the DR messages that a recording holds"});
    v.Field("wheel_sigma_m_per_sqrt_m", wheel_sigma_m_per_sqrt_m,
            {.min = 1e-5,
             .max = 1,
             .unit = "m/sqrt(m)",
             .text = "wheel odometry noise along the way (hard floor 0.004, carpet 0.01)"});
    v.Field("wheel_sigma_deg_per_sqrt_m", wheel_sigma_deg_per_sqrt_m,
            {.min = 1e-4,
             .max = 90,
             .unit = "deg/sqrt(m)",
             .text = "heading noise of the wheels per way driven"});
    v.Field("wheel_sigma_deg_per_sqrt_rad", wheel_sigma_deg_per_sqrt_rad,
            {.min = 1e-4,
             .max = 90,
             .unit = "deg/sqrt(rad)",
             .text = "heading noise of the wheels per angle turned"});
    v.Field("wheel_scale_sigma", wheel_scale_sigma,
            {.min = 0,
             .max = 0.5,
             .text = "prior uncertainty of the wheel scale and of the track (0: not estimated)"});
    v.Field(
        "gyro_scale_sigma", gyro_scale_sigma,
        {.min = 0,
         .max = 0.1,
         .text = "prior uncertainty of the gyro's scale, each axis (BMI055 as in a D435i: 1 %)"});
    v.Field("lateral_sigma_m_per_sqrt_m", lateral_sigma_m_per_sqrt_m,
            {.min = 1e-4,
             .max = 1,
             .unit = "m/sqrt(m)",
             .text = "sideways and vertical motion that a rolling robot should not have, per way"});
    v.Field("gate_sigma", gate_sigma,
            {.min = 1, .max = 100, .unit = "sigma", .text = "innovation gate"});
    v.Field("max_speed_m_s", max_speed_m_s,
            {.min = 0.05,
             .max = 20,
             .unit = "m/s",
             .text = "a wheel sample that is faster is no measurement"});
    v.Field("max_yaw_rate_deg_s", max_yaw_rate_deg_s,
            {.min = 5,
             .max = 3600,
             .unit = "deg/s",
             .text = "a wheel sample that turns faster is no measurement"});
    v.Field("max_acceleration_m_s2", max_acceleration_m_s2,
            {.min = 0.1,
             .max = 100,
             .unit = "m/s^2",
             .text = "wheels that change their speed faster slip; used without an accelerometer"});
    v.Field("history_ms", history_ms,
            {.min = 10,
             .max = 60000,
             .unit = "ms",
             .text = "how late a measurement may arrive and still be used"});
    v.Field("stationary_ms", stationary_ms,
            {.min = 50,
             .max = 10000,
             .unit = "ms",
             .text = "how long all sensors must be still before the pose is held"});
    v.Field("pose_correction_m_s", pose_correction_m_s,
            {.min = 0,
             .max = 10,
             .unit = "m/s",
             .text = "POSE follows a correction of its position no faster while it moves (0: at "
                     "once)"});
    v.Field(
        "pose_correction_deg_s", pose_correction_deg_s,
        {.min = 0, .max = 360, .unit = "deg/s", .text = "and one of its rotation (0: at once)"});
  }
};

}  // namespace gw
