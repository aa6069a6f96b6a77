#include "grid/core/look_taker.h"

namespace gw::grid {
namespace {

double RateOf(const GridConfig& config, CameraKind kind) {
  if (config.rate_hz > 0) return config.rate_hz;
  return kind == CameraKind::kStereo ? 5 : 10;
}

}  // namespace

LookTaker::LookTaker(const CameraGeometry& geometry, const GridConfig& config)
    // The image nearest to the period, whatever the jitter of the camera.
    : least_(DurationFromSeconds(1 / RateOf(config, geometry.calibration.camera.kind) -
                                 0.5 / geometry.calibration.camera.rate_hz)),
      source_(MakeDepthSource(geometry, config)),
      scanner_(source_->rays(), config) {}

bool LookTaker::Due(Utime utime) const {
  return !last_ || utime < *last_ || utime - *last_ >= least_;
}

std::optional<FloorScan> LookTaker::Look(const CameraFrame& frame, double length_factor) {
  last_ = frame.utime;
  if (!source_->Measure(frame, &depth_)) return std::nullopt;
  if (length_factor != 1) {
    for (float& z : depth_) z *= static_cast<float>(length_factor);
  }
  return scanner_.Scan(depth_);
}

}  // namespace gw::grid
