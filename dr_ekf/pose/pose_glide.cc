#include "dr_ekf/pose/pose_glide.h"

#include <algorithm>

namespace gw::dr_ekf {
namespace {

// Corrections that err at random have one sign in so many images in a row once in 128 times.
constexpr size_t kImages = 8;
// What had not been told before it was known is made up for in as long as that took.
constexpr double kCatchUp = 2;
// Images that are further apart do not tell of one motion.
constexpr DurationUs kLongestGap = Milliseconds(1000);

// The share of a step of `most` in a way of `length`, 1 when it reaches the end.
double ShareOf(double most, double length) {
  return length > most ? most / length : 1.0;
}

}  // namespace

SE3 PoseGlide::Outstanding(const Pose& corrected, const SE3& T_OB) const {
  // T_WB is continuous where dead reckoning began anew, T_WO is not.
  if (DrBeganAnew(corrected)) return outstanding_;
  return (T_WO_ * T_OB).inverse() * corrected.T_WB;
}

bool PoseGlide::BeginsAnew(const Pose& corrected) const {
  return corrected.has_map != corrected_->has_map ||
         (corrected.ClaimsPlace() && !corrected_->ClaimsPlace());
}

void PoseGlide::Observe(const Pose& corrected, const SE3& T_OB) {
  const DurationUs since = corrected.utime - corrected_at_;
  if (DrBeganAnew(corrected) || since > kLongestGap) rates_of_corrections_.clear();
  if (DrBeganAnew(corrected) || corrected.frame_pose_seq == corrected_->frame_pose_seq) return;
  if (since <= kLongestGap && since.us > 0) {
    const SE3 correction = (corrected_->T_WO * T_OB).inverse() * corrected.T_WB;
    rates_of_corrections_.push_back(correction.Log() / since.seconds());
    if (rates_of_corrections_.size() > kImages) rates_of_corrections_.pop_front();
  }
  corrected_at_ = corrected.utime;
}

// The motion that dead reckoning does not tell.
Vector6d PoseGlide::Untold() const {
  if (rates_of_corrections_.size() < kImages) return Vector6d::Zero();
  Vector6d least = rates_of_corrections_.front(), most = least;
  for (const Vector6d& rate : rates_of_corrections_) {
    least = least.cwiseMin(rate);
    most = most.cwiseMax(rate);
  }
  return least.cwiseMax(0) + most.cwiseMin(0);
}

SE3 PoseGlide::AfterOneStep(const SE3& outstanding, double dt_s) const {
  const Eigen::Vector3d& way = outstanding.translation();
  const Eigen::Vector3d turn = LogSO3(outstanding.rotation());
  const Vector6d untold = Untold();
  const double m_s = rates_.m_s + kCatchUp * untold.head<3>().norm();
  const double rad_s = rates_.rad_s + kCatchUp * untold.tail<3>().norm();
  const double way_share = rates_.m_s > 0 ? ShareOf(m_s * dt_s, way.norm()) : 1;
  const double turn_share = rates_.rad_s > 0 ? ShareOf(rad_s * dt_s, turn.norm()) : 1;
  if (way_share == 1 && turn_share == 1) return SE3();
  const SE3 step(ExpSO3(turn_share * turn), way_share * way);
  return step.inverse() * outstanding;
}

Pose PoseGlide::Push(const Pose& corrected, bool stationary) {
  const SE3 T_OB = corrected.T_WO.inverse() * corrected.T_WB;
  if (corrected_) {
    Observe(corrected, T_OB);
    outstanding_ = Outstanding(corrected, T_OB);
    const double dt_s = std::max(0.0, (corrected.utime - corrected_->utime).seconds());
    if (BeginsAnew(corrected)) {
      ++reset_counter_;
      outstanding_ = SE3();
    } else {
      outstanding_ = stationary ? SE3() : AfterOneStep(outstanding_, dt_s);
    }
  }
  corrected_ = corrected;

  Pose out = corrected;
  out.reset_counter = reset_counter_;
  const Vector6d e = outstanding_.Log();
  if (!e.isZero(0)) {
    out.T_WB = corrected.T_WB * outstanding_.inverse();
    out.T_WO = out.T_WB * T_OB.inverse();
    out.cov_T_WB += e * e.transpose();
    const Vector6d e_O = T_OB.Adjoint() * e;
    out.cov_T_WO += e_O * e_O.transpose();
  }
  T_WO_ = out.T_WO;
  return out;
}

}  // namespace gw::dr_ekf
