#include "frontend/core/tracking/witnesses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "common/core/log_odds.h"
#include "common/good_weights/vision_noise.h"
#include "frontend/core/tracking/apart.h"

namespace gw::frontend {
namespace {

// A pose of the world finds a landmark again that is known to stand still with a probability of at
// least PoseFinder::kTrustedShare; one that moves with something else by chance.
constexpr double kFoundByChance = 0.02;
// Odds against a pose from which it is not believed.
constexpr double kUnbelievable = 20;

}  // namespace

SE3 VisionAlone(const SE3& T_WC_prior, const PoseEstimate& estimate) {
  const Eigen::LDLT<Matrix6d> of_vision(estimate.vision_information);
  const Vector6d pulled = (T_WC_prior.inverse() * estimate.T_WC).Log();
  return estimate.T_WC * SE3::Exp(of_vision.solve(estimate.prior_information * pulled));
}

SE3 HeldSteady(const SE3& T_WC_steady, const Matrix6d& cov, const PoseEstimate& alone) {
  const Matrix6d& H = alone.vision_information;
  const Matrix6d of_motion = cov.ldlt().solve(Matrix6d::Identity());
  const Vector6d e = (T_WC_steady.inverse() * alone.T_WC).Log();
  return T_WC_steady * SE3::Exp((H + of_motion).ldlt().solve(H * e));
}

bool Witnesses::Contradict(const OfDr& dr, const FoundPose& found) const {
  if (!found.found || found.estimate.num_inliers < PoseFinder::kTrustedShare * found.num_tracked)
    return true;
  const SE3 T_WC = VisionAlone(dr.T_WC, found.estimate);
  const Matrix6d cov = VisionCovariance(found.estimate.vision_information);
  if (Apart(dr.T_WC, T_WC, dr.cov + cov)) return true;
  // A little in every image is much in a while: what is white grows with its root.
  const auto before = anchors_->From(dr.utime - StandingLandmarks::kProof);
  const auto T_OC = motion_->OdometryPose(dr.utime);
  return before && T_OC &&
         Apart(before->T_WO * *T_OC, T_WC, (before->num_images + 1) * dr.cov + cov);
}

bool Witnesses::Founded(const FoundPose& found, const std::vector<TrackedPoint>& expected) const {
  const auto standing = std::count_if(expected.begin(), expected.end(),
                                      [this](const auto& t) { return standing_.Knows(t.id); });
  const int again = standing_.Count(found.landmarks);
  const double odds =
      LogOdds(again, static_cast<double>(standing), kFoundByChance, PoseFinder::kTrustedShare);
  return odds < std::log(kUnbelievable);
}

void Witnesses::Learn(const OfDr& dr, bool agreed, const FoundPose& found) {
  if (Tells(dr, found)) standing_.Observe(dr.utime, agreed, found.landmarks);
}

// An image tells who is right when what moves with the camera and what stands still look different
// by now.
bool Witnesses::Tells(const OfDr& dr, const FoundPose& found) const {
  const auto before = motion_->OdometryPose(dr.utime - StandingLandmarks::kProof);
  const auto now = motion_->OdometryPose(dr.utime);
  const Matrix6d cov = VisionCovariance(found.estimate.vision_information);
  return before && now && Apart(*before, *now, dr.cov + cov);
}

}  // namespace gw::frontend
