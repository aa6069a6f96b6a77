// The camera (section `drivers.camera`). What it looks like and where it sits is calibration, not
// here: the image size and rate that the driver asks for are those of `calibration.camera`.
#pragma once

#include <string>

#include "common/core/fields.h"

namespace gw {

enum class CameraSource { kRealsense, kUvc, kUvcSideBySide };
enum class EmitterMode { kOff, kOn, kAlternating };
enum class ExposureMode { kCamera, kCapped, kFixed };
enum class PowerLine { kOff = 0, k50Hz = 1, k60Hz = 2, kAuto = 3 };     // values of V4L2
enum class AccelRate { k63 = 63, k100 = 100, k200 = 200, k250 = 250 };  // Hz

struct CameraConfig {
  CameraSource source = CameraSource::kRealsense;
  std::string device = "auto";
  EmitterMode emitter = EmitterMode::kOff;
  int laser_power_mw = 150;
  ExposureMode exposure = ExposureMode::kCapped;
  int exposure_us = 8000;
  int gain = 16;
  PowerLine power_line = PowerLine::k50Hz;
  bool publish_imu = true;
  AccelRate accel_rate_hz = AccelRate::k250;
  double transport_delay_ms = 0;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Enum("source", source,
           {{"realsense", CameraSource::kRealsense},
            {"uvc", CameraSource::kUvc},
            {"uvc_side_by_side", CameraSource::kUvcSideBySide}},
           {.text = "realsense: D435i, stereo or grey and depth by calibration.camera.kind; uvc: "
                    "any V4L2 camera with GREY or YUYV, one eye and no depth, for recording and "
                    "trying out, not for SLAM; uvc_side_by_side: both eyes in one image of twice "
                    "the width"});
    v.Field("device", device,
            {.text = "serial number (of the USB device), or `auto`: the only camera of the "
                     "source's kind; uvc: also a path such as /dev/video0"});
    v.Enum("emitter", emitter,
           {{"off", EmitterMode::kOff},
            {"on", EmitterMode::kOn},
            {"alternating", EmitterMode::kAlternating}},
           {.text = "infra-red dots, which features must not see: off; on (only for depth); "
                    "alternating: every other frame, and only frames without dots are published"});
    v.Field("laser_power_mw", laser_power_mw,
            {.min = 0, .max = 360, .unit = "mW", .text = "power of the dots"});
    v.Enum("exposure", exposure,
           {{"camera", ExposureMode::kCamera},
            {"capped", ExposureMode::kCapped},
            {"fixed", ExposureMode::kFixed}},
           {.text = "camera: its own automatic; capped: automatic up to exposure_us, then gain, to "
                    "keep motion blur small; fixed: exposure_us and gain"});
    v.Field("exposure_us", exposure_us,
            {.min = 100, .max = 165000, .unit = "us", .text = "cap, or fixed exposure"});
    v.Field("gain", gain, {.min = 1, .max = 248, .text = "for exposure: fixed; 16 is gain 1"});
    v.Enum("power_line", power_line,
           {{"off", PowerLine::kOff},
            {"50Hz", PowerLine::k50Hz},
            {"60Hz", PowerLine::k60Hz},
            {"auto", PowerLine::kAuto}},
           {.text = "flicker of lamps that the camera's automatic exposure avoids, if it can"});
    v.Field(
        "publish_imu", publish_imu,
        {.text = "publish the camera's IMU (realsense, when calibration.imu.present) at "
                 "calibration.imu.rate_hz, 200 or 400; only when no other driver publishes IMU"});
    v.Enum("accel_rate_hz", accel_rate_hz,
           {{"63", AccelRate::k63},
            {"100", AccelRate::k100},
            {"200", AccelRate::k200},
            {"250", AccelRate::k250}},
           {.unit = "Hz", .text = "of the accelerometer: 63 or 250 (BMI055), 100 or 200 (BMI085)"});
    v.Field("transport_delay_ms", transport_delay_ms,
            {.min = 0,
             .max = 200,
             .unit = "ms",
             .text = "constant delay from the end of the exposure to the arrival, taken off all "
                     "times of images"});
  }
};

}  // namespace gw
