#include "frontend/core/tracking/camera_track.h"

#include <algorithm>

#include "common/good_weights/camera_motion.h"
#include "frontend/core/tracking/apart.h"

namespace gw::frontend {

void CameraTrack::BeginFrame() {
  uncertainty.Reset(Matrix6d::Identity() * 1e-12);
  doubt.setZero();
}

void CameraTrack::BeginPiece(LocalMap* map) {
  map->Use(chain.next());
  chain.Break();
  uncertainty = PoseUncertainty();
  BeginFrame();
  points.clear();
}

void CameraTrack::Take(const FoundPose& found, const FeatureFrame& frame, const LocalMap& map) {
  uncertainty.Update(found.estimate.vision_information, found.estimate.prior_information);
  T_WC = found.estimate.T_WC;
  reference = found.reference;
  doubt = doubts.Among(found.landmarks, map, T_WC).value_or(doubt);
  points.clear();
  for (size_t i = 0; i < found.landmarks.size(); ++i) {
    if (!found.landmarks[i].valid()) continue;
    points.push_back({found.landmarks[i], frame.descriptors[i], frame.features[i].level});
  }
}

void CameraTrack::GoOn(const SE3& T_ab, const SE3& T_WC_now) {
  T_WC = T_WC_now;
  doubt = InCamera(doubt, T_ab);
}

void CameraTrack::KeyframeMade(KeyframeId id) {
  reference = id;
  doubts.Add(id, cov());
}

bool CameraTrack::AgreesWithDr(Utime since, const MotionModel& motion) const {
  const auto T_OC = motion.OdometryPose(utime);
  const auto then = anchors.Before(since);
  const auto dr = then ? motion.Step(then->utime, utime) : std::nullopt;
  if (!T_OC || !dr) return false;
  Matrix6d cov = uncertainty.cov();
  cov.diagonal() += dr->white + dr->common.cwiseAbs2();
  return !Apart(T_WC, then->T_WO * *T_OC, cov);
}

void CameraTrack::Rewind(Utime since, MotionModel* motion) {
  const auto T_OC = motion->OdometryPose(utime);
  const auto then = anchors.Before(since);
  if (!T_OC || !then) return;
  const SE3 T_WC_by_dr = then->T_WO * *T_OC;
  uncertainty.Shift((T_WC.inverse() * T_WC_by_dr).Log());
  T_WC = T_WC_by_dr;
  motion->Unlearn(since);
  const Motion since_then = motion->Between(then->utime, utime);
  uncertainty.Reset(InCamera(then->cov_T_WC, since_then.T_ab) + since_then.noise.Covariance());
  const KeyframeId sound = chain.Void(since);
  if (sound.valid()) reference = sound;
}

void CameraTrack::ScaleLengths(double by, double scale_sigma, const Eigen::Vector3d& center) {
  const Eigen::Vector3d way = by * (T_WC.translation() - center);
  const Eigen::Vector3d error = T_WC.rotation().inverse() * (scale_sigma * way);
  T_WC = SE3(T_WC.rotation(), center + way);
  Matrix6d cov_now = uncertainty.cov();
  cov_now.topLeftCorner<3, 3>() += error * error.transpose();
  uncertainty = PoseUncertainty();
  uncertainty.Reset(cov_now);
  anchors.Clear();
  chain.ScaleLengths(by);
}

void CameraTrack::RememberAnchor(const MotionModel& motion) {
  if (const auto T_OC = motion.OdometryPose(utime)) {
    anchors.Remember(utime, T_WC * T_OC->inverse(), uncertainty.cov());
  } else {
    anchors.Clear();
  }
}

CameraTrack::Correction CameraTrack::FollowReference(const SE3& T_WK_before,
                                                     const MapUpdate& update, LocalMap* map) {
  Correction correction;
  const SE3 T_WC_before = T_WC;
  SE3 T_KC = T_WK_before.inverse() * T_WC;
  for (const LoopEvent& loop : update.loops) {
    if (loop.accepted) doubts.Close(loop, *map);
  }
  for (const KeyframeRemoval& removal : update.removed_keyframes) {
    doubts.Remove(removal.id);
    if (removal.id == reference) {
      reference = removal.parent;
      T_KC = removal.T_ParentC * T_KC;
    }
  }
  if (const auto T_WK = map->KeyframePose(reference)) T_WC = *T_WK * T_KC;
  if (const auto piece = map->PieceOf(reference); piece && *piece != map->piece()) {
    // Its frame is another one now, in which the pose is as sure as it was in the piece.
    map->Use(*piece);
    correction.joined = true;
    const Matrix6d cov = uncertainty.cov();
    uncertainty = PoseUncertainty();
    uncertainty.Reset(cov);
  } else {
    uncertainty.Shift((T_WC_before.inverse() * T_WC).Log());
  }
  correction.T = T_WC * T_WC_before.inverse();
  anchors.Move(correction.T);
  return correction;
}

}  // namespace gw::frontend
