// Vision and dead reckoning (DR) are two witnesses, neither the judge of the other. What an image
// tells of which of them is right: whether they contradict each other, whether the pose that vision
// found is founded on landmarks that are known to stand still, and whether vision stands refuted
// (docs/adr/0039-what-stands-still-decides.md, docs/method.md, eq. 5.3a and 5.3b).
#pragma once

#include <optional>
#include <vector>

#include "common/contract/map.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "frontend/core/map/standing_landmarks.h"
#include "frontend/core/map/tracked_points.h"
#include "frontend/core/motion/anchor_history.h"
#include "frontend/core/motion/motion_model.h"
#include "frontend/core/tracking/pose_finder.h"

namespace gw::frontend {

// The pose of the camera without the pull of the prior, whose mean is T_WC_prior:
// (H_v + H_p) x = H_v x_vision + H_p x_prior.
SE3 VisionAlone(const SE3& T_WC_prior, const PoseEstimate& estimate);

// The pose of vision alone, where what it leaves open (of few directions, or near ones) is as a
// steady motion has it; cov: of that motion, right perturbation.
SE3 HeldSteady(const SE3& T_WC_steady, const Matrix6d& cov, const PoseEstimate& alone);

class Witnesses {
 public:
  // What DR says of an image.
  struct OfDr {
    Utime utime;
    SE3 T_WC;      // from the pose of the image before
    Matrix6d cov;  // of the motion since then
  };

  // Both must outlive this.
  Witnesses(const MotionModel* motion, const AnchorHistory* anchors)
      : motion_(motion), anchors_(anchors) {}

  // True when the pose that was found around the prediction of DR contradicts it, in this image or
  // over the last half second, or is none.
  bool Contradict(const OfDr& dr, const FoundPose& found) const;

  // False for a pose by which chance, or something else than the world, explains better than the
  // world which of the landmarks that stand still it finds again. expected: landmarks of the image
  // before that should be in view.
  bool Founded(const FoundPose& found, const std::vector<TrackedPoint>& expected) const;

  // True when the image shows a landmark that is known to stand still.
  bool Stands(const FoundPose& found) const { return standing_.Count(found.landmarks) > 0; }
  bool KnowAny() const { return standing_.KnowsAny(); }

  // The rest of the image contradicts vision. What two images say, within the time in which a
  // landmark proves to stand still, is no accident of one: vision follows what is not the world,
  // until an image that agrees shows what stands still. What was known to stand is forgotten after
  // a while, and cannot clear vision then.
  void Accuse(Utime utime) {
    if (accused_ && utime - *accused_ <= StandingLandmarks::kProof) refuted_ = utime;
    accused_ = utime;
  }
  void Clear() {
    accused_.reset();
    refuted_.reset();
  }
  bool Refuted(Utime now) const {
    return refuted_ && now - *refuted_ <= StandingLandmarks::kMemory;
  }

  // After an image whose pose vision carries. agreed: with DR, around whose prediction it was
  // found.
  void Learn(const OfDr& dr, bool agreed, const FoundPose& found);

  void Merge(const std::vector<LandmarkMerge>& merges) { standing_.Merge(merges); }
  // Another place: nothing of what was seen is known here.
  void Forget() {
    standing_ = StandingLandmarks();
    Clear();
  }

 private:
  bool Tells(const OfDr& dr, const FoundPose& found) const;

  const MotionModel* motion_;
  const AnchorHistory* anchors_;
  StandingLandmarks standing_;
  // When, if nothing that stands still has been seen since.
  std::optional<Utime> accused_;
  std::optional<Utime> refuted_;
};

}  // namespace gw::frontend
