// What the tracker carries from image to image: its state, the pose of the camera and how sure it
// is, what that pose hangs on, and the chain of keyframes made along the way. The pose refers to
// the frame of the piece of the map in use (LocalMap::piece).
#pragma once

#include <vector>

#include "common/config/frontend_config.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/map/keyframe_doubt.h"
#include "frontend/core/map/local_map.h"
#include "frontend/core/map/tracked_points.h"
#include "frontend/core/motion/anchor_history.h"
#include "frontend/core/motion/motion_model.h"
#include "frontend/core/motion/pose_uncertainty.h"
#include "frontend/core/tracking/keyframe_chain.h"
#include "frontend/core/tracking/pose_finder.h"
#include "frontend/core/tracking/tracking_state.h"

namespace gw::frontend {

struct CameraTrack {
  explicit CameraTrack(const FrontendConfig& config) : chain(config) {}

  TrackingState state = TrackingState::kStart;
  Utime utime;                       // of the last image
  SE3 T_WC;                          // its pose
  PoseUncertainty uncertainty;       // of T_WC, in the map around it
  std::vector<TrackedPoint> points;  // landmarks that it showed
  KeyframeId reference;              // the keyframe that the pose is expressed in
  KeyframeChain chain;
  AnchorHistory anchors;
  KeyframeDoubt doubts;
  Matrix6d doubt = Matrix6d::Zero();  // of the map around T_WC; right perturbation of T_WC

  bool placed() const { return IsPlaced(state); }
  bool vision_broken() const { return state != TrackingState::kTracking; }

  // The pose defines the frame in which it is expressed: it is certain.
  void BeginFrame();

  // Begins a piece of the map, whose frame is W as far as the robot knows it: the pose goes on
  // without a step. What was seen before belongs to another piece.
  void BeginPiece(LocalMap* map);

  // Takes over the pose that vision found for an image.
  void Take(const FoundPose& found, const FeatureFrame& frame, const LocalMap& map);
  // Vision found none: dead reckoning has moved the camera by T_ab, to T_WC.
  void GoOn(const SE3& T_ab, const SE3& T_WC);
  // A keyframe was made of the last image.
  void KeyframeMade(KeyframeId id);

  // Covariance of T_WC, right perturbation.
  Matrix6d cov() const { return uncertainty.cov() + doubt; }

  // The pose is where dead reckoning leads from the pose of then, as far as both are sure of it
  // (chi-square, 99.9 %). false where dead reckoning does not reach back to then.
  bool AgreesWithDr(Utime since, const MotionModel& motion) const;

  // Vision was held by what is not the world: the way since then is that of dead reckoning, and
  // what was mapped and learnt since then is void. Nothing happens where dead reckoning does not
  // reach back to then.
  void Rewind(Utime since, MotionModel* motion);

  // All lengths are multiplied by this from now on, around `center` in W; scale_sigma: of that.
  void ScaleLengths(double by, double scale_sigma, const Eigen::Vector3d& center);

  // The last image has its final pose: remembers where the odometry frame lies.
  void RememberAnchor(const MotionModel& motion);

  // The pose follows its reference, which was at T_WK_before until the map took in `update`, also
  // into another piece. Returns the correction: the pose was T, and is now T_correction * T.
  // joined: the piece in use became part of another.
  struct Correction {
    SE3 T;
    bool joined = false;
  };
  Correction FollowReference(const SE3& T_WK_before, const MapUpdate& update, LocalMap* map);
};

}  // namespace gw::frontend
