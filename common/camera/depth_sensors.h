// How well the depth cameras that recordings and robots have measure: what importers and drivers
// write into a configuration (calibration.camera), to be changed there.
#pragma once

#include "common/camera/calibration.h"

namespace gw {

struct DepthSensor {
  double baseline_m = 0;          // between imager and imager, or imager and projector
  double disparity_sigma_px = 0;  // of the mean of 3x3 depth pixels, from image to image
};

// RealSense D435 and D455. Steps of 1/8 px (0.036 px RMS), which neighbours share, and less than
// 0.08 px of noise on a textured wall (data sheet of the D400 family), a third of it in the mean of
// nine pixels; robust residuals of tracking on an independent renderer's D435 are 0.054 px
// (docs/adr/0057-depth-as-the-sensor-gives-it.md).
inline constexpr DepthSensor kRealSenseD435{0.050, 0.05};
inline constexpr DepthSensor kRealSenseD455{0.095, 0.05};

// The Kinect of the TUM data set. K. Khoshelham, S. Oude Elberink, "Accuracy and resolution of
// Kinect depth data for indoor mapping applications", Sensors 12(2), 2012: 0.06 px of noise; but
// colour and depth are taken 10 to 20 ms apart and the one rolls its shutter: robust residuals of
// tracking on fr1_rpy are 0.3 px.
inline constexpr DepthSensor kKinectOfTum{0.08, 0.3};

inline void SetDepthSensor(const DepthSensor& sensor, CameraCalibration* camera) {
  camera->depth_baseline_m = sensor.baseline_m;
  camera->disparity_sigma_px = sensor.disparity_sigma_px;
}

}  // namespace gw
