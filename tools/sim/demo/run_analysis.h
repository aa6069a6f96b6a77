// What a run looked like, from what a Monitor saw of it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "tools/robot/monitor/monitor.h"

namespace gw::demo {

// One image of the run.
struct FramePoint {
  double t = 0;  // s since the first image with a pose
  TrackingStatus status = TrackingStatus::kInvalid;
  double q = 0, alpha = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // in G where there is truth, else in W
  std::optional<Eigen::Vector2d> truth;                // in G
  std::optional<double> error_m;                       // in space
  double latency_ms = 0;
};

struct RunAnalysis {
  Utime begin;
  std::vector<FramePoint> frames;
  std::vector<std::pair<double, double>> blind;  // s; spans without usable vision
  double blind_s = 0;
  double way_m = 0;  // true if there is truth, else estimated
  bool has_truth = false;
  double error_rmse_m = 0, error_max_m = 0, error_end_m = 0;
  double seconds() const { return frames.empty() ? 0 : frames.back().t; }
};

// Vision does not carry the pose: only dead reckoning does, or nothing.
bool IsBlind(TrackingStatus status);

// The estimate is tied to the truth at the first image that has both, and not aligned after.
RunAnalysis Analyse(const tools::Monitor& monitor);

// Error of the newest image, for a progress line. Cheap: does not look at the whole run.
class ErrorNow {
 public:
  // Metres; empty without truth.
  std::optional<double> Of(const tools::Monitor& monitor);

 private:
  std::optional<SE3> T_GW_;
};

}  // namespace gw::demo
