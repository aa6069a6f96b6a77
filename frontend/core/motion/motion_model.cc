#include "frontend/core/motion/motion_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/covariance.h"
#include "common/core/log_odds.h"
#include "common/good_weights/camera_motion.h"
#include "common/good_weights/covariance.h"

namespace gw::frontend {
namespace {

// Constant velocity is believed as long as that of dead reckoning.
constexpr DurationUs kMaxCoasting = kMaxDrExtrapolation;
// Spread of the real motion around constant velocity per 1/30 s (hand-held recording, 95 % of
// images).
constexpr double kCoastingSigmaRotation = 0.008;     // rad
constexpr double kCoastingSigmaTranslation = 0.010;  // m

}  // namespace

// Synthetic DR is that of a camera in a hand.
bool MotionModel::OnFloor() const {
  return DrInLocalBa(variant_) && dr_weight_.Departs(Departure::kFloor) && !dr_.empty() &&
         !dr_.newest().synthetic;
}

SE3 MotionModel::FirstPose(Utime utime) const {
  SE3 T_WB;
  if (DrPredicts(variant_) && !dr_.empty() && dr_.newest().gravity_aligned && !OnFloor()) {
    if (const auto T_OB = dr_.PoseAt(utime)) {
      const Eigen::Matrix3d R = T_OB->rotation().toRotationMatrix();
      const double yaw = std::atan2(R(1, 0), R(0, 0));
      T_WB = SE3(ExpSO3({0, 0, -yaw}) * T_OB->rotation(), Eigen::Vector3d::Zero());
    }
  }
  return T_WB * T_BC_;
}

bool MotionModel::Push(const DrState& told) {
  // Dead reckoning that began anew goes on from where it says.
  const bool goes_on = !dr_.empty() && told.reset_counter == told_.newest().reset_counter;
  const bool pushed = apart_ && goes_on
                          ? dr_.Push(learnt_.constant.Follow(dr_.newest(), told_.newest(), told))
                          : dr_.Push(told);
  if (!pushed) return false;
  told_.Push(told);
  scale_witness_.Observe(told);
  return true;
}

DrConstantFault MotionModel::dr_fault() const {
  DrConstant constant = learnt_.constant;
  if (!dr_trusted()) constant.Take(learnt_.disagreement.Explain());
  if (vision_factor()) constant.ForgetWayFactor();
  return constant.fault();
}

std::optional<double> MotionModel::vision_factor() const {
  if (learnt_.lengths.IsBetterNow()) return learnt_.lengths.value();
  if (dr_trusted() && !learnt_.constant.fault().way_factor) return std::nullopt;
  const std::optional<double> factor = learnt_.lengths.Fault();
  if (!factor || scale_witness_.LogOddsForDr(*factor) < kDecisiveLogOdds) return std::nullopt;
  return factor;
}

void MotionModel::VisionCorrected(double factor) {
  learnt_.lengths.Corrected(factor);
  DrConstant constant = learnt_.constant;
  constant.ForgetWayFactor();
  LearnAnew(constant);
  learnt_.disagreement = DrDisagreement();
  learnt_before_.clear();
  velocity_.head<3>() /= factor;
}

std::optional<MotionModel::Calibrated> MotionModel::DrBetween(Utime a, Utime b) const {
  DrNoise noise;
  auto told = dr_.Increment(a, b, &noise);
  if (!told) return std::nullopt;
  told->T_BaBb = DrPose(a)->inverse() * *DrPose(b);
  learnt_.calibration.Limit(&noise, dr_.newest());
  return Calibrated{*told, learnt_.calibration.Corrected(told->T_BaBb, b - a, dr_.newest()), noise};
}

// A source that does not tell its noise has the nominal one. Any axes.
DrNoise MotionModel::OrNominal(DrNoise told, DurationUs length) const {
  if (told.Covariance().isZero(0)) told.white = NominalCovariance(length, dr_weight_);
  return told;
}

// The noise of DR as it enters: what it has shown, or what it says itself.
DrNoise MotionModel::Shown(const DrNoise& claimed) const {
  return dr_weight_.Departs(Departure::kTrust) ? learnt_.trust.Shown(claimed) : claimed;
}

// Sigma_d of the prior of an image, before alpha.
Matrix6d MotionModel::WeightCovariance(const Matrix6d& nominal, const Matrix6d& shown) const {
  if (dr_weight_.Departs(Departure::kKnownNoise)) return learnt_.trust.Weighted(nominal, shown);
  if (dr_weight_.Departs(Departure::kReportedNoise)) return LargerCovariance(nominal, shown);
  return nominal;
}

Motion MotionModel::Between(Utime a, Utime b) const {
  Motion out;
  const DurationUs dt = b - a;
  const bool contradicted = !dr_trusted() && observed_ == a;
  if (DrPredicts(variant_) && !contradicted) {
    if (const auto dr = DrBetween(a, b)) {
      out.T_BaBb_dr = dr->told.T_BaBb;
      out.turn_variance_dr = dr->noise.white(5, 5);
      out.T_ab = InCamera(dr->T_BaBb, T_BC_);
      out.noise = OrNominal(InCamera(Shown(dr->noise), T_BC_), dt);
      out.weight_cov = WeightCovariance(NominalCovariance(dt, dr_weight_), out.noise.Covariance());
      out.from_dr = true;
      out.slip = dr->told.slip;
      return out;
    }
  }
  return Coast(a, b);
}

Motion MotionModel::Coast(Utime a, Utime b) const {
  Motion out;
  const DurationUs dt = b - a;
  if (b - observed_ <= kMaxCoasting) out.T_ab = SE3::Exp(velocity_ * dt.seconds());
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kCoastingSigmaTranslation),
      Eigen::Vector3d::Constant(kCoastingSigmaRotation);
  sigma *= dt.seconds() * 30.0;
  out.noise.white = sigma.cwiseAbs2().asDiagonal();
  out.weight_cov = out.noise.white;
  return out;
}

std::optional<CameraStep> MotionModel::Step(Utime a, Utime b) const {
  const auto dr = DrPredicts(variant_) ? DrBetween(a, b) : std::nullopt;
  if (!dr || dr->told.slip) return std::nullopt;
  const DrNoise noise = OrNominal(InCamera(dr->noise, T_BC_), b - a);
  CameraStep out;
  out.T_ab = InCamera(dr->T_BaBb, T_BC_);
  if (observed_ == a) out.T_ab_seen = Coast(a, b).T_ab;
  out.refuted = learnt_.trust.refuted();
  out.white = noise.white.diagonal();
  out.common = (noise.lever * noise.coherent * noise.lever.transpose()).diagonal().cwiseMax(0);
  out.common = out.common.cwiseSqrt().eval();
  return out;
}

std::optional<SE3> MotionModel::OdometryPose(Utime utime) const {
  if (!DrPredicts(variant_)) return std::nullopt;
  const auto T_OB = dr_.PoseAt(utime);
  if (!T_OB) return std::nullopt;
  return *T_OB * T_BC_;
}

std::optional<DrIncrement> MotionModel::Increment(Utime a, Utime b) const {
  if (!DrInLocalBa(variant_) || !dr_trusted()) return std::nullopt;
  const auto dr = DrBetween(a, b);
  if (!dr) return std::nullopt;
  DrIncrement out = dr->told;
  out.T_BaBb = dr->T_BaBb;
  out.cov = Shown(dr->noise).Covariance();
  return out;
}

std::optional<DrHeight> MotionModel::Height(Utime utime) const {
  if (!OnFloor()) return std::nullopt;
  const auto T_OB = dr_.PoseAt(utime);
  if (!T_OB) return std::nullopt;
  const Eigen::Vector3d up_B = T_OB->rotation().conjugate() * Eigen::Vector3d::UnitZ();
  const double variance = up_B.dot(dr_.newest().cov_T_OB.topLeftCorner<3, 3>() * up_B);
  if (!(variance > 0)) return std::nullopt;
  return DrHeight{T_OB->translation().z(), variance, dr_.newest().reset_counter};
}

void MotionModel::Observe(const Seen& seen, const Motion& expected) {
  if (seen.a == observed_) velocity_ = seen.T_ab.Log() / (seen.b - seen.a).seconds();
  observed_ = seen.b;
  if (seen.healthy && calibrate_dr_ && expected.from_dr && !expected.slip) {
    learnt_.calibration.Observe(expected.T_BaBb_dr, T_BC_ * seen.T_ab * T_BC_.inverse(),
                                seen.b - seen.a, dr_.newest(), expected.turn_variance_dr);
  } else {
    learnt_.calibration.Interrupt();
  }
  if (seen.sure && DrPredicts(variant_)) {
    CompareWithVision(seen);
  } else {
    window_.reset();
  }
}

std::optional<SE3> MotionModel::DrPose(Utime utime) const {
  const auto at = std::lower_bound(carried_.begin(), carried_.end(), utime,
                                   [](const Carried& c, Utime t) { return c.utime < t; });
  const bool stands =
      at != carried_.end() && at->utime == utime && at->reset_counter == dr_.newest().reset_counter;
  return stands ? at->T_OB : dr_.PoseAt(utime);
}

void MotionModel::GoOn(Utime a, Utime b, const Motion& taken) {
  if (dr_.empty()) return;
  std::optional<SE3> T_OB = dr_.PoseAt(b);
  if (!T_OB) {
    T_OB = DrPose(a);
    if (!T_OB) return;
    T_OB = *T_OB * T_BC_ * taken.T_ab * T_BC_.inverse();
  }
  carried_.push_back({b, *T_OB, dr_.newest().reset_counter});
  while (carried_.front().utime < dr_.oldest().utime) carried_.pop_front();
}

void MotionModel::ObserveNothing() {
  learnt_.calibration.Interrupt();
  window_.reset();
}

void MotionModel::Unlearn(Utime since) {
  ObserveNothing();
  while (!learnt_before_.empty() && learnt_.until > since) {
    learnt_ = std::move(learnt_before_.back());
    learnt_before_.pop_back();
  }
}

void MotionModel::Restart() {
  ObserveNothing();
  carried_.clear();
  velocity_.setZero();
  observed_ = {};
}

void MotionModel::MapMoved(const SE3& T_correction) {
  if (window_) window_->T_WC = T_correction * window_->T_WC;
}

void MotionModel::CompareWithVision(const Seen& seen) {
  if (window_ && seen.b - window_->begin < DrTrust::kWindow) return;
  const double speed = dr_.empty() ? 0 : dr_.newest().v_OB_B.head<2>().norm();
  const std::optional<Window> window =
      std::exchange(window_, Window{seen.b, seen.T_WC_vision, seen.cov_vision, speed});
  const auto dr = window ? DrBetween(window->begin, seen.b) : std::nullopt;
  if (!dr) return;
  const DurationUs length = seen.b - window->begin;
  DrEvidence evidence;
  evidence.T_dr = dr->T_BaBb;
  evidence.cov_dr = OrNominal(dr->noise, length).Covariance();
  const SE3 T_ab = window->T_WC.inverse() * seen.T_WC_vision;
  evidence.T_vision = T_BC_ * T_ab * T_BC_.inverse();
  const Matrix6d from_begin = T_ab.inverse().Adjoint();
  const Matrix6d cov = from_begin * window->cov * from_begin.transpose() + seen.cov_vision;
  evidence.cov_vision = T_BC_.Adjoint() * cov * T_BC_.Adjoint().transpose();
  learnt_before_.push_back(learnt_);
  while (learnt_before_.size() > 1 && seen.b - learnt_before_[1].until > AnchorHistory::kSpan) {
    learnt_before_.pop_front();
  }
  learnt_.until = seen.b;
  learnt_.trust.Judge(evidence);
  if (dr->told.slip) return;  // what wheels do while they slip tells no constant
  DrNoise noise_told;
  if (const auto told = told_.Increment(window->begin, seen.b, &noise_told)) {
    learnt_.disagreement.Add({told->T_BaBb, OrNominal(noise_told, length).Covariance(),
                              evidence.T_vision, evidence.cov_vision});
  }
  const double taken_out = learnt_.constant.fault().way_factor.value_or(1);
  const Matrix6d S = evidence.cov_dr + evidence.cov_vision;
  learnt_.lengths.Add({dr->told.T_BaBb.translation().head<2>() / taken_out,
                       evidence.T_vision.translation().head<2>(), (S(0, 0) + S(1, 1)) / 2,
                       speed - window->speed});
  if (!dr_trusted()) TakeOutConstant();
}

// Dead reckoning without the constant by which it is wrong is one of which nothing is known yet.
void MotionModel::TakeOutConstant() {
  DrConstant constant = learnt_.constant;
  constant.Take(learnt_.disagreement.Explain());
  if (constant.Beside(learnt_.constant).empty()) return;
  apart_ = true;
  LearnAnew(constant);
}

void MotionModel::LearnAnew(const DrConstant& constant) {
  learnt_.calibration = DrCalibration(up_I_);
  learnt_.trust = DrTrust();
  learnt_.constant = constant;
  window_.reset();
}

}  // namespace gw::frontend
