// How strongly the depth of an RGB-D camera counts against the pixels of its image.
//
// The error of depth that was measured by triangulation (active stereo, structured light) grows
// with the square of the distance, sigma_z = k z^2. So does that of a stereo pair of baseline b
// whose disparities are as uncertain as the pixels of features are: sigma_z = z^2 sigma_px / (fx
// b). The virtual baseline (docs/conventions.md, "Depth") is the b of equal errors; see ADR 33.
#pragma once

namespace gw {

// Of a feature at level 0: what the reprojections of TUM fr1_rpy scatter by (RefineCorner in
// frontend/core/features/orb_detector.h).
inline constexpr double kFeatureSigmaPx = 0.40;

// Of the disparities of a D400 camera at their own baseline and image: an RMS of 0.08 px (data
// sheet: below 0.1 px on texture), and steps of 1/8 px.
inline constexpr double kD400DisparitySigmaPx = 0.088;

// k, in 1/m: the same over fx * baseline of a depth image of 640 px (fx 385).
inline constexpr double kDepthNoiseD435 = kD400DisparitySigmaPx / (385 * 0.050);
inline constexpr double kDepthNoiseD455 = kD400DisparitySigmaPx / (385 * 0.095);

// In m, at most 1 (the limit of calibration.camera.depth_baseline_m). fx: of the image, px.
// Preconditions: both > 0.
inline constexpr double VirtualBaseline(double depth_noise, double fx) {
  const double baseline_m = kFeatureSigmaPx / (fx * depth_noise);
  return baseline_m < 1.0 ? baseline_m : 1.0;
}

}  // namespace gw
