// The chain of keyframes that this tracker makes: when the next one is due, and what is in it.
#pragma once

#include <deque>

#include "common/config/frontend_config.h"
#include "common/contract/map.h"
#include "common/contract/tracking.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/motion/motion_model.h"
#include "frontend/core/tracking/pose_finder.h"

namespace gw::frontend {

class KeyframeChain {
 public:
  explicit KeyframeChain(const FrontendConfig& config) : config_(config) {}

  // An image. T_ab: motion of the camera since the image before. unmatched: it has features, but no
  // pose from vision.
  void Observe(const SE3& T_ab, bool unmatched);

  // The newest image. found: its pose from vision, or not found. num_mapped: landmarks of the map's
  // most similar view.
  bool WantsNext(Utime utime, const FeatureFrame& frame, const FoundPose& found,
                 int num_mapped) const;

  // Makes it of the newest image. report: of this image, for its quality; the pose is T_WC, with
  // cov_T_WC (right perturbation). Features that show no landmark, but have a depth, show new
  // ones: LandmarkId::From(keyframe, feature).
  struct Source {
    const FeatureFrame& frame;
    const FoundPose& found;
    const FramePose& report;
    SE3 T_WC;
    Matrix6d cov_T_WC;
    KeyframeId piece;  // of the map, that it belongs to
    int64_t map_revision = 0;
    double length_factor = 1;  // of all lengths (Keyframe)
  };
  Keyframe Make(const Source& source, const MotionModel& motion);

  // The number that it will have.
  KeyframeId next() const { return next_; }

  // The next keyframe begins a chain of its own: dead reckoning does not lead to it.
  void Break() { own_.clear(); }
  // Since then vision was held by what is not the world: keyframes made since then are void, but
  // for the first of the chain. The next one follows the last that is not, and is due at once.
  // Returns that; invalid: there is none.
  KeyframeId Void(Utime since);
  // All lengths are multiplied by this from now on: the next keyframe is due at once, to say so.
  void ScaleLengths(double by);
  // As Break, and time goes on from here: the clock was set.
  void Restart(Utime utime) {
    Break();
    void_ = false;
    utime_ = utime;
  }

  // The map holds keyframes up to this one: the next has a higher number.
  void Skip(KeyframeId newest);

 private:
  struct Link {
    KeyframeId id;
    Utime utime;
  };

  FrontendConfig config_;
  std::deque<Link> own_;  // the chain: what was made in AnchorHistory::kSpan, and one before
  bool void_ = false;     // the next keyframe withdraws those between own_.back() and itself
  bool scaled_ = false;   // since the newest
  KeyframeId next_{1};
  Utime utime_;  // of the newest
  SE3 T_CkeyC_;  // motion since then
  int images_since_ = 0;
  int unmatched_images_ = 0;  // in a row
};

}  // namespace gw::frontend
