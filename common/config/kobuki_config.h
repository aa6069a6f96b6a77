// The Kobuki base (section `drivers.kobuki`). Geometry of the wheels is calibration, not here.
#pragma once

#include <string>

#include "common/core/fields.h"

namespace gw {

struct KobukiConfig {
  std::string device = "auto";
  bool publish_imu = false;
  double transport_delay_ms = 0;
  int command_timeout_ms = 300;
  double max_speed_m_s = 0.7;
  double max_turn_deg_s = 110;
  double accel_m_s2 = 0.5;
  double decel_m_s2 = 0.6;
  double turn_accel_rad_s2 = 3.5;
  double turn_decel_rad_s2 = 4.2;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field(
        "device", device,
        {.text = "path of the serial port, or serial number of the USB adapter "
                 "(kobuki_XXXXXXXX), or `auto`: /dev/kobuki, else the only adapter of a Kobuki"});
    v.Field("publish_imu", publish_imu,
            {.text = "publish the base's gyro as IMU; only when no other driver publishes IMU"});
    v.Field("transport_delay_ms", transport_delay_ms,
            {.min = 0,
             .max = 200,
             .unit = "ms",
             .text = "constant delay from measurement to arrival, taken off all times; 0 leaves it "
                     "to calibration.wheel.time_offset_s"});
    v.Field("command_timeout_ms", command_timeout_ms,
            {.min = 50,
             .max = 2000,
             .unit = "ms",
             .text = "the base stops when no command came for this long"});
    v.Field("max_speed_m_s", max_speed_m_s,
            {.min = 0.01, .max = 0.7, .unit = "m/s", .text = "fastest that commands may drive"});
    v.Field("max_turn_deg_s", max_turn_deg_s,
            {.min = 1,
             .max = 180,
             .unit = "deg/s",
             .text = "fastest that commands may turn; above 110 the base's gyro loses accuracy"});
    v.Field("accel_m_s2", accel_m_s2,
            {.min = 0.01, .max = 10, .unit = "m/s^2", .text = "limit on getting faster"});
    v.Field("decel_m_s2", decel_m_s2,
            {.min = 0.01,
             .max = 10,
             .unit = "m/s^2",
             .text = "limit on getting slower; stops for safety are immediate"});
    v.Field("turn_accel_rad_s2", turn_accel_rad_s2,
            {.min = 0.01, .max = 100, .unit = "rad/s^2", .text = "limit on turning faster"});
    v.Field("turn_decel_rad_s2", turn_decel_rad_s2,
            {.min = 0.01, .max = 100, .unit = "rad/s^2", .text = "limit on turning slower"});
  }
};

}  // namespace gw
