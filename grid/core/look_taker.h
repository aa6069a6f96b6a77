// From camera messages to floor scans, at the configured rate.
#pragma once

#include <memory>
#include <optional>

#include "common/camera/camera_model.h"
#include "common/config/grid_config.h"
#include "common/contract/samples.h"
#include "grid/core/depth_source.h"
#include "grid/core/floor_scan.h"

namespace gw::grid {

class LookTaker {
 public:
  LookTaker(const CameraGeometry& geometry, const GridConfig& config);

  // True when an image of this time is wanted: grid.rate_hz. An image that is older than the newest
  // begins a new count: the clock was set back.
  bool Due(Utime utime) const;
  // Empty for an image that is not of the calibrated kind and size. length_factor: by which the
  // camera's lengths are to be multiplied (MapUpdate).
  std::optional<FloorScan> Look(const CameraFrame& frame, double length_factor);

 private:
  DurationUs least_;
  std::unique_ptr<DepthSource> source_;
  FloorScanner scanner_;
  DepthImage depth_;
  std::optional<Utime> last_;
};

}  // namespace gw::grid
