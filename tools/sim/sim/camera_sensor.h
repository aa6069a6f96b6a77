// From radiance to the 8-bit image of a real imager: exposure, motion blur, vignetting, glare, shot
// and read noise, clipping; and the automatic exposure that follows the light with a delay.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

#include "tools/sim/sim/renderer.h"

namespace gw::sim {

// Defaults: a global-shutter imager like those of a RealSense D435i, indoors.
struct ImagerConfig {
  double grey_per_radiance_ms = 30;  // grey levels of radiance 1 after 1 ms at gain 1
  double black_level = 4;            // grey levels without light
  double electrons_per_grey = 90;    // at gain 1; sets the shot noise: 1.2 grey levels at mid-grey
  double read_noise_grey = 0.1;      // sigma at gain 1; grows with the gain
  double vignetting = 0.3;           // share of light that the corners lose
  double target_grey = 95;           // mean that the automatic exposure aims at
  double min_exposure_ms = 0.05, max_exposure_ms = 8.0;
  double max_gain = 16;           // used when the exposure is at its maximum
  int exposure_delay_frames = 3;  // from an image to the first one that reacts to it
  double exposure_rate = 0.35;    // share of the (logarithmic) error corrected at a time
};

struct Exposure {
  double time_ms = 4;
  double gain = 1;
};

class AutoExposure {
 public:
  explicit AutoExposure(const ImagerConfig& config) : config_(config), wanted_ms_(4) {}
  Exposure exposure() const;  // of the next frame
  void Observe(double mean_grey);

 private:
  ImagerConfig config_;
  double wanted_ms_;  // exposure time at gain 1
  std::deque<double> means_;
};

// Light that reaches the sensor beside the image: a bright spot and a veil around it.
struct Glare {
  double strength = 0;  // radiance; 0: none
  double x = 0, y = 0;  // px
};

// Velocity of the camera in its own frame, while the shutter is open.
struct CameraMotion {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d w = Eigen::Vector3d::Zero();  // rad/s
};

// Image motion (px/s) of the point that pixel (x, y) shows, at inverse depth w (1/m).
Eigen::Vector2d ImageMotion(const Pinhole& camera, const CameraMotion& motion, double x, double y,
                            double inverse_depth);

class CameraSensor {
 public:
  // `pool` must outlive it.
  CameraSensor(const Pinhole& camera, const ImagerConfig& config, WorkerPool* pool);

  // The image, row by row. noise_key: of this image; equal keys give equal noise.
  void Expose(const RenderedImage& scene, const CameraMotion& motion, const Exposure& exposure,
              const Glare& glare, uint64_t noise_key, std::vector<uint8_t>* image);
  // The last image before noise, grey levels; for the depth sensor.
  const std::vector<float>& signal() const { return signal_; }

 private:
  void BlurRow(const RenderedImage& scene, const CameraMotion& motion, double seconds, int y);

  Pinhole camera_;
  ImagerConfig config_;
  WorkerPool* pool_;
  std::vector<float> vignette_;
  std::vector<float> signal_;
};

double MeanGrey(const std::vector<uint8_t>& image);

}  // namespace gw::sim
