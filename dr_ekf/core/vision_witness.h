// What healthy vision says of the wheels: their way against that of FRAME_POSE over the last fifth
// of a second. Only a witness: it never gives a motion, and whether it is believed is for DrModel
// (docs/adr/0008-dr-health.md says why).
#pragma once

#include <deque>
#include <optional>

#include "common/contract/samples.h"
#include "common/contract/tracking.h"
#include "common/core/time.h"

namespace gw::dr_ekf {

struct VisionVerdict {
  bool agrees = false;      // false: the wheels are wrong by speed_excess
  double speed_excess = 0;  // m/s, wheels minus vision, along x of B
};

class VisionWitness {
 public:
  // T_BC: of the camera whose images they are.
  explicit VisionWitness(const SE3& T_BC) : T_BC_(T_BC) {}

  // Both in camera time and in the order of time; what is not newer is ignored. The verdict is
  // empty while there is none: vision not healthy, not long enough, neither clearly right nor
  // clearly wrong, or wrong for so long that it is no slip but a scale.
  std::optional<VisionVerdict> Push(const WheelSample& sample, double wheel_scale);
  std::optional<VisionVerdict> Push(const FramePose& frame);
  void Clear();

 private:
  struct WayPoint {
    Utime utime;
    double way_m;  // of the wheels since the start
  };
  struct Step {  // between two images
    Utime end;
    double duration_s, wheels_m;
    Eigen::Vector3d vision_m;  // in the heading halfway
  };

  std::optional<VisionVerdict> TakeCovered();
  // Motion of the body between two images. Empty: the map moved in between, and with it the pose.
  std::optional<SE3> MotionBetween(const FramePose& a, const FramePose& b) const;
  std::optional<VisionVerdict> Judge();
  // Precondition: ways_.front().utime <= utime <= ways_.back().utime.
  double WayAt(Utime utime) const;

  SE3 T_BC_;
  std::deque<WayPoint> ways_;
  std::deque<FramePose> waiting_;  // newer than the wheels
  std::optional<FramePose> last_;  // the image before, if it was healthy
  std::deque<Step> steps_;
  bool suspected_ = false;              // the judgement before was against the wheels
  std::optional<Utime> accused_since_;  // without agreement or a break
};

}  // namespace gw::dr_ekf
