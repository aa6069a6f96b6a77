#include "frontend/core/motion/motion_model.h"

#include <cmath>

#include "common/good_weights/camera_motion.h"
#include "common/good_weights/covariance.h"

namespace gw::frontend {
namespace {

constexpr DurationUs kMaxCoasting = Milliseconds(500);  // constant velocity is believed this long
// Spread of the real motion around constant velocity per 1/30 s (hand-held recording, 95 % of
// images).
constexpr double kCoastingSigmaRotation = 0.008;     // rad
constexpr double kCoastingSigmaTranslation = 0.010;  // m

}  // namespace

SE3 MotionModel::FirstPose(Utime utime) const {
  SE3 T_WB;
  if (DrPredicts(variant_) && !dr_.empty() && dr_.newest().gravity_aligned) {
    if (const auto T_OB = dr_.PoseAt(utime, kMaxExtrapolation)) {
      const Eigen::Matrix3d R = T_OB->rotation().toRotationMatrix();
      const double yaw = std::atan2(R(1, 0), R(0, 0));
      T_WB = SE3(ExpSO3({0, 0, -yaw}) * T_OB->rotation(), Eigen::Vector3d::Zero());
    }
  }
  return T_WB * T_BC_;
}

Motion MotionModel::Between(Utime a, Utime b) const {
  Motion out;
  const DurationUs dt = b - a;
  if (DrPredicts(variant_)) {
    DrNoise noise_B;
    if (const auto increment = dr_.Increment(a, b, kMaxExtrapolation, &noise_B)) {
      out.T_BaBb_dr = increment->T_BaBb;
      out.T_ab = InCamera(calibration_.Corrected(out.T_BaBb_dr, dr_.newest()), T_BC_);
      calibration_.Limit(&noise_B, dr_.newest());
      out.noise = InCamera(noise_B, T_BC_);
      out.weight_cov = DrCovariance(dt, out.noise.Covariance(), dr_weight_);
      // A source that does not tell its noise has the nominal one.
      if (out.noise.Covariance().isZero(0)) out.noise.white = out.weight_cov;
      out.from_dr = true;
      out.slip = increment->slip;
      return out;
    }
  }
  if (b - observed_ <= kMaxCoasting) out.T_ab = SE3::Exp(velocity_ * dt.seconds());
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kCoastingSigmaTranslation),
      Eigen::Vector3d::Constant(kCoastingSigmaRotation);
  sigma *= dt.seconds() * 30.0;
  out.noise.white = sigma.cwiseAbs2().asDiagonal();
  out.weight_cov = out.noise.white;
  return out;
}

std::optional<SE3> MotionModel::OdometryPose(Utime utime) const {
  if (!DrPredicts(variant_)) return std::nullopt;
  const auto T_OB = dr_.PoseAt(utime, kMaxExtrapolation);
  if (!T_OB) return std::nullopt;
  return *T_OB * T_BC_;
}

std::optional<DrIncrement> MotionModel::Increment(Utime a, Utime b) const {
  DrNoise noise;
  auto increment = dr_.Increment(a, b, kMaxExtrapolation, &noise);
  if (increment) {
    increment->T_BaBb = calibration_.Corrected(increment->T_BaBb, dr_.newest());
    calibration_.Limit(&noise, dr_.newest());
    increment->cov = noise.Covariance();
  }
  return increment;
}

void MotionModel::Observe(const SE3& T_ab, const Motion& expected, Utime a, Utime b, bool healthy) {
  if (a == observed_) velocity_ = T_ab.Log() / (b - a).seconds();
  observed_ = b;
  if (healthy && calibrate_dr_ && expected.from_dr && !expected.slip) {
    calibration_.Observe(expected.T_BaBb_dr, T_BC_ * T_ab * T_BC_.inverse(), b - a, dr_.newest());
  } else {
    calibration_.Interrupt();
  }
}

}  // namespace gw::frontend
