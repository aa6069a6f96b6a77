// Depth as a stereo camera measures it, made from the true depth: noise and steps of the disparity,
// so that the error grows with the square of the distance, and holes where matching fails.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/sim/sim/renderer.h"

namespace gw::sim {

struct DepthConfig {
  double baseline_m = 0.05;
  double disparity_sigma_px = 0.08;  // D400 data sheet: sub-pixel RMS below 0.1 px on texture
  double disparity_step_px = 0.125;
  double min_m = 0.25, max_m = 10;
  double unit_m = 0.001;
  // Mean gradient below which nothing is matched. 0: the pattern of a projector is texture enough,
  // on blank walls and in the dark; the grey image, taken while it is off, does not have it.
  double min_contrast_grey = 0.8;
};

// sigma (m) of the depth at depth z: fx b / z = d, so dz = z^2 / (fx b) dd; steps of the disparity
// add step^2 / 12 to its variance.
double DepthSigma(const DepthConfig& config, double fx, double z);

// scene: rendered; signal: the grey image before noise (CameraSensor::signal). depth: in units of
// unit_m, 0 = none. Holes: outside [min_m, max_m]; without texture within 3 px; hidden from the
// right eye; within 2 px of a jump in depth.
void MeasureDepth(const RenderedImage& scene, const std::vector<float>& signal,
                  const Pinhole& camera, const DepthConfig& config, uint64_t noise_key,
                  WorkerPool* pool, std::vector<uint16_t>* depth);

}  // namespace gw::sim
