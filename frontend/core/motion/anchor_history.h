// Where the odometry frame O lay in the world frame W, image by image, over the last seconds: what
// the pose is rewound to when vision proves to have been held by something that is not the world.
#pragma once

#include <deque>
#include <optional>

#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::frontend {

class AnchorHistory {
 public:
  // The longest that vision may have been held by something that is not the world: what was placed,
  // mapped and learnt meanwhile can be taken back for as long.
  static constexpr DurationUs kSpan = Milliseconds(5000);

  struct Since {
    Utime utime;  // of that image
    SE3 T_WO;
    Matrix6d cov_T_WC;
    int num_images = 0;  // after that one
  };
  // What was at the first image not before `then`; empty where none is known.
  std::optional<Since> From(Utime then) const;
  // What was at the last image before `then`, or at the first one that is known; empty where none
  // is known since `then`.
  std::optional<Since> Before(Utime then) const;

  // After every image; times ascend. cov_T_WC: of the camera's pose, right perturbation.
  void Remember(Utime utime, const SE3& T_WO, const Matrix6d& cov_T_WC);
  // The map was corrected: W before the correction is now T_correction in W.
  void Move(const SE3& T_correction);
  // Dead reckoning has begun anew, or does not tell.
  void Clear() { anchors_.clear(); }

 private:
  struct Anchor {
    Utime utime;
    SE3 T_WO;
    Matrix6d cov_T_WC;
  };
  using Place = std::deque<Anchor>::const_iterator;
  Place FirstFrom(Utime then) const;
  std::optional<Since> At(const Place& place) const;

  std::deque<Anchor> anchors_;
};

}  // namespace gw::frontend
