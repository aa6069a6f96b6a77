// Automatic exposure with a cap: exposure time grows with the dark up to a limit that keeps motion
// blur small, then the gain takes over. (The camera's own goes up to a whole frame interval.)
#pragma once

#include <cstdint>
#include <optional>

namespace gw::camera {

struct ExposureSetting {
  uint32_t exposure_us = 0;
  int32_t gain = 0;  // in the camera's units; the minimum is gain 1
  bool operator==(const ExposureSetting&) const = default;
};

struct ExposureLimits {
  uint32_t min_exposure_us = 20, max_exposure_us = 8000;
  int32_t min_gain = 16, max_gain = 248;  // range of D4xx cameras
};

class ExposureControl {
 public:
  // Precondition: every minimum is positive and not above its maximum.
  explicit ExposureControl(const ExposureLimits& limits);

  ExposureSetting setting() const { return setting_; }
  // Takes the mean grey level of the next image. Gives a new setting when one is needed: at most
  // every kFramesPerStep images, since a change takes three frames to be seen.
  std::optional<ExposureSetting> Observe(double mean_grey);

  static constexpr double kTargetGrey = 95;
  static constexpr int kFramesPerStep = 4;

 private:
  ExposureLimits limits_;
  ExposureSetting setting_;
  double wanted_us_;  // the exposure time that the light asks for at gain 1
  int frames_ = 0;
};

}  // namespace gw::camera
