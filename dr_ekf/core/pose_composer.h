// The pose for control: T_WB = T_WO * T_OB at DR rate. The front-end corrects it only through T_WO,
// which is latched anew by every image whose pose vision carries, or dead reckoning as the
// front-end has calibrated it; between images, and for as long as there are none, dead reckoning
// carries on. An image that puts the place in doubt is latched too: its covariance says that the
// pose may be anywhere.
//
// Covariance: that of the latched image pose, moved along, plus the growth of dead reckoning since
// that image (white and coherent parts, see DrState).
#pragma once

#include <optional>

#include "common/contract/dead_reckoning.h"
#include "common/contract/tracking.h"
#include "common/good_weights/dr_history.h"

namespace gw::dr_ekf {

enum class LatchResult {
  kLatched,
  kIgnoredStatus,  // the frame's pose is not better than what dead reckoning makes of the last one
  kStale,          // not newer than the frame latched last
  kNoDeadReckoning,  // T_OB at the image is not known: too old, too far ahead, or across a reset
  kInvalid,          // NaN or infinite
};

class PoseComposer {
 public:
  // Empty when the state is not usable: time not newer without a reset, or not finite.
  std::optional<Pose> Push(const DrState& state);
  LatchResult Push(const FramePose& frame);

 private:
  void Anchor(const SE3& T_WB, const Matrix6d& cov_T_WB, const SE3& T_OB);

  DrHistory history_;
  std::optional<DrState> newest_;
  std::optional<Pose> last_pose_;
  int64_t seq_ = 0;

  // W until the first frame is O.
  SE3 T_WO_;
  Matrix6d cov_T_WO_ = Matrix6d::Zero();
  bool has_map_ = false;
  Utime frame_utime_;
  int64_t frame_seq_ = 0;
  int64_t map_revision_ = 0;

  // At the newest state: the covariance of the latched pose, carried along, and the noise of the
  // motion since.
  Matrix6d cov_ = Matrix6d::Zero();
  DrNoise noise_;
};

}  // namespace gw::dr_ekf
