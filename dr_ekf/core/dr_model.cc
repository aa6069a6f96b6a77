#include "dr_ekf/core/dr_model.h"

#include <algorithm>
#include <cmath>

#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRadPerDeg = 0.017453292519943295;
// Variance that stands for "knows nothing" of a motion since the clone: far above any measurement,
// low enough that the update keeps 14 digits.
constexpr double kUnknownVariance = 1.0;
// Wheels at rest still let the body rock by this much between two samples.
constexpr double kWayFloor = 1e-4;  // m
constexpr double kYawFloor = 1e-4;  // rad

const Vector3d kUp(0, 0, kGravity);  // specific force at rest, in O

double WrapAngle(double a) {
  return std::remainder(a, 2 * M_PI);
}

double Square(double x) {
  return x * x;
}

// What an update may do to the pose.
enum class PoseUpdate {
  kCorrect,  // the pose was estimated without this measurement, which corrects it
  kDefine,   // the measurement is the motion; its noise is no correction
  kHold,     // pose and velocity do not move (Schmidt's consider update), P stays honest
};

// One Kalman update.
template <int kRows>
void Update(const Eigen::Matrix<double, kRows, kErrorSize>& H,
            const Eigen::Matrix<double, kRows, 1>& innovation,
            const Eigen::Matrix<double, kRows, kRows>& R, PoseUpdate mode, FilterState& state) {
  const bool hold = mode == PoseUpdate::kHold;
  const Eigen::Matrix<double, kErrorSize, kRows> PHt = state.P * H.transpose();
  const Eigen::Matrix<double, kRows, kRows> S = H * PHt + R;
  Eigen::Matrix<double, kErrorSize, kRows> K = S.ldlt().solve(PHt.transpose()).transpose();
  if (hold) {
    K.template topRows<9>().setZero();
    K.template bottomRows<6>().setZero();
  }
  ErrorMatrix IKH = ErrorMatrix::Identity();
  IKH.noalias() -= K * H;
  const ErrorMatrix P = IKH * state.P * IKH.transpose() + K * R * K.transpose();
  state.P = 0.5 * (P + P.transpose());
  state.transition = (IKH * state.transition).eval();

  if (mode == PoseUpdate::kCorrect) {
    const auto K_pose = K.template topRows<6>();
    state.correction_rate += K_pose * S * K_pose.transpose() / kCorrectionMemory;
  }

  const ErrorVector d = K * innovation;
  if (!hold) {
    state.T_OS = state.T_OS * SE3::Exp(d.segment<6>(kPose));
    state.T_OS_clone = state.T_OS_clone * SE3::Exp(d.segment<6>(kClone));
    state.v_OS_S += d.segment<3>(kVelocity);
  }
  state.gyro_bias += d.segment<3>(kGyroBias);
  state.accel_bias += d.segment<3>(kAccelBias);
  // Far outside the prior the linear model means nothing; the bounds keep hostile data harmless.
  state.wheel_scale = std::clamp(state.wheel_scale + d[kWheelScale], 0.5, 2.0);
  state.yaw_scale = std::clamp(state.yaw_scale + d[kYawScale], 0.5, 2.0);
}

// Error map that touches only pose and velocity (the first nine errors).
using TopTransition = Eigen::Matrix<double, 9, kClone>;

void ApplyTransition(const TopTransition& F, FilterState& state) {
  const Eigen::Matrix<double, 9, kErrorSize> top = F * state.P.topRows<kClone>();
  state.P.topRows<9>() = top;
  state.P.leftCols<9>() = top.transpose();
  state.P.topLeftCorner<9, 9>() = top.leftCols<kClone>() * F.transpose();
  const Eigen::Matrix<double, 9, kErrorSize> moved = F * state.transition.topRows<kClone>();
  state.transition.topRows<9>() = moved;
}

void ClonePose(Utime utime, FilterState& state) {
  state.T_OS_clone = state.T_OS;
  state.clone_utime = utime;
  state.has_clone = true;
  state.way_unmeasured = false;
  state.yaw_unmeasured = false;
  state.P.middleRows<6>(kClone) = state.P.middleRows<6>(kPose).eval();
  state.P.middleCols<6>(kClone) = state.P.middleCols<6>(kPose).eval();
  state.transition.middleRows<6>(kClone) = state.transition.middleRows<6>(kPose).eval();
}

}  // namespace

DrModel::DrModel(const DrEkfConfig& config, const Calibration& calibration)
    : config_(config), imu_(calibration.imu), wheel_(calibration.wheel) {
  R_BI_ = imu_.T_BI.rotation().toRotationMatrix();
  if (imu_.present && imu_.has_accel) {
    T_BS_ = SE3(Eigen::Quaterniond::Identity(), imu_.T_BI.translation());
  }
  T_SB_ = T_BS_.inverse();
  adj_BS_ = T_BS_.Adjoint();
  tick_m_ = 1.0 / wheel_.ticks_per_metre;
  imu_cover_ = std::max(DurationFromSeconds(3.0 / imu_.rate_hz), Milliseconds(40));
  imu_timeout_ = DurationFromSeconds(3.0 / imu_.rate_hz) + Milliseconds(100);
  wheel_timeout_ = DurationFromSeconds(3.0 / wheel_.rate_hz) + Milliseconds(250);
}

FilterState DrModel::Initial(Utime utime) const {
  FilterState state;
  state.utime = utime;
  state.T_OS = T_BS_;
  Vector6d pose_B = Vector6d::Zero();
  if (!(imu_.present && imu_.has_accel)) pose_B[3] = pose_B[4] = Square(kFloorTilt);
  const Matrix6d adj_SB = T_SB_.Adjoint();
  state.P.block<6, 6>(kPose, kPose) = adj_SB * pose_B.asDiagonal() * adj_SB.transpose();
  state.P(kVelocity, kVelocity) = Square(kForwardSpeedPrior);
  state.P(kVelocity + 1, kVelocity + 1) = Square(kSidewaysSpeedPrior);
  state.P(kVelocity + 2, kVelocity + 2) = Square(kSidewaysSpeedPrior);
  if (imu_.present) {
    state.P.block<3, 3>(kGyroBias, kGyroBias).diagonal().setConstant(Square(kGyroBiasPrior));
    if (imu_.has_accel) {
      state.P.block<3, 3>(kAccelBias, kAccelBias).diagonal().setConstant(Square(kAccelBiasPrior));
    }
  }
  if (wheel_.present) {
    state.P(kWheelScale, kWheelScale) = Square(config_.wheel_scale_sigma);
    state.P(kYawScale, kYawScale) = Square(config_.wheel_scale_sigma);
  }
  return state;
}

FilterState DrModel::Restarted(const FilterState& before, Utime utime) const {
  FilterState state = Initial(utime);
  state.reset_counter = before.reset_counter + 1;
  state.counters = before.counters;
  if (!before.T_OS.IsFinite() || !before.P.allFinite()) return state;
  state.T_OS = before.T_OS;
  state.gyro_bias = before.gyro_bias;
  state.accel_bias = before.accel_bias;
  state.wheel_scale = before.wheel_scale;
  state.yaw_scale = before.yaw_scale;
  state.aligned = before.aligned;
  state.P.block<6, 6>(kPose, kPose) = before.P.block<6, 6>(kPose, kPose);
  // Unknown motion: it may be anywhere near and face anywhere.
  state.P.block<3, 3>(0, 0).diagonal().array() += 1.0;
  state.P(5, 5) += 1.0;
  if (state.aligned) {
    state.P(3, 3) += Square(kTiltPrior);
    state.P(4, 4) += Square(kTiltPrior);
  }
  const Matrix3d gyro = before.P.block<3, 3>(kGyroBias, kGyroBias);
  const Matrix3d accel = before.P.block<3, 3>(kAccelBias, kAccelBias);
  state.P.block<3, 3>(kGyroBias, kGyroBias) = gyro;
  state.P.block<3, 3>(kAccelBias, kAccelBias) = accel;
  state.P(kWheelScale, kWheelScale) = before.P(kWheelScale, kWheelScale);
  state.P(kYawScale, kYawScale) = before.P(kYawScale, kYawScale);
  return state;
}

bool DrModel::WheelsAlive(const FilterState& state) const {
  return state.has_wheel && state.utime - state.wheel_utime <= wheel_timeout_;
}

bool DrModel::ImuAlive(const FilterState& state) const {
  return state.has_imu && state.utime - state.imu_utime <= imu_timeout_;
}

DrModel::Rates DrModel::RatesBetween(Utime from, Utime to, const ImuSample* imu,
                                     const FilterState& state) const {
  Rates rates;
  rates.w = Vector3d(0, 0, state.w_OS_S.z());
  if (!state.has_imu || to - state.imu_utime > imu_cover_) return rates;
  Vector3d w = state.gyro_B;
  Vector3d a = state.accel_B;
  bool has_accel = state.imu_has_accel;
  if (imu != nullptr && to > state.imu_utime) {
    // The middle of the step, on the line between the samples before and after it.
    const double middle =
        0.5 * ((from - state.imu_utime).seconds() + (to - state.imu_utime).seconds());
    const double f = middle / (to - state.imu_utime).seconds();
    w += f * (R_BI_ * imu->w_I_rad_s - w);
    a += f * (R_BI_ * imu->a_I_m_s2 - a);
    has_accel = has_accel && imu->has_accel;
  }
  rates.gyro = true;
  rates.w = w - R_BI_ * state.gyro_bias;
  if (!state.aligned) rates.w.head<2>().setZero();  // taken to stand flat
  if (has_accel && state.aligned) {
    rates.accel = true;
    rates.a = a - R_BI_ * state.accel_bias;
  }
  return rates;
}

void DrModel::PropagateTo(Utime utime, const ImuSample* imu, FilterState& state) const {
  if (utime <= state.utime) return;
  const double dt = (utime - state.utime).seconds();
  state.correction_rate *= std::exp(-dt / kCorrectionMemory);
  if (state.stationary) {
    Hold(dt, state);
  } else {
    Integrate(RatesBetween(state.utime, utime, imu, state), dt, state);
  }
  state.utime = utime;
}

void DrModel::Hold(double dt, FilterState& state) const {
  state.P.diagonal().segment<6>(kPose).array() += kPoseFloor * dt;
  state.P.diagonal().segment<3>(kGyroBias).array() += Square(imu_.gyro_walk) * dt;
  if (imu_.has_accel) {
    state.P.diagonal().segment<3>(kAccelBias).array() += Square(imu_.accel_walk) * dt;
  }
}

void DrModel::Integrate(const Rates& rates, double dt, FilterState& state) const {
  const Vector3d w = rates.w;
  const Vector3d v = state.v_OS_S;
  const bool wheels = WheelsAlive(state);
  const Matrix3d R_OS = state.T_OS.rotation().toRotationMatrix();
  if (!rates.accel) state.way_unmeasured = true;
  if (!rates.gyro) state.yaw_unmeasured = true;

  // Velocity without accelerometer: constant while wheels will tell, else it fades.
  const double fade = wheels || rates.accel ? 1.0 : std::exp(-dt / kUnmeasuredSpeedMemory);
  const double fade_side = rates.accel ? 1.0 : std::exp(-dt / kLateralCorrelation);

  SE3 T_step;  // motion of S in this step
  Vector3d v_new;
  if (rates.accel) {
    const Eigen::Quaterniond q_step = ExpSO3(w * dt);
    const Vector3d a_S = ExpSO3(0.5 * dt * w) * rates.a - R_OS.transpose() * kUp;
    T_step = SE3(q_step, v * dt + 0.5 * a_S * dt * dt);
    v_new = q_step.conjugate() * (v + a_S * dt);
  } else {
    Vector6d twist;
    twist << v, w;
    T_step = SE3::Exp(twist * dt);
    v_new = v.cwiseProduct(Vector3d(fade, fade_side, fade_side));
  }

  // Error dynamics: continuous A, second order in the step; the pose block is exact.
  const Matrix3d R_BI = R_BI_;
  const Matrix3d gyro_to_error =
      state.aligned ? R_BI : Matrix3d(Vector3d(0, 0, 1).asDiagonal() * R_BI);
  TopTransition A = TopTransition::Zero();
  A.block<3, 3>(0, 0) = -Skew(w);
  A.block<3, 3>(0, 3) = -Skew(v);
  A.block<3, 3>(0, kVelocity).setIdentity();
  A.block<3, 3>(3, 3) = -Skew(w);
  if (rates.gyro) A.block<3, 3>(3, kGyroBias) = -gyro_to_error;
  if (rates.accel) {
    A.block<3, 3>(kVelocity, 3) = -Skew(R_OS.transpose() * kUp);
    A.block<3, 3>(kVelocity, kVelocity) = -Skew(w);
    A.block<3, 3>(kVelocity, kGyroBias) = -Skew(v) * R_BI;
    A.block<3, 3>(kVelocity, kAccelBias) = -R_BI;
  }
  TopTransition F = A * dt;
  F.leftCols<9>() += Eigen::Matrix<double, 9, 9>::Identity();
  F += 0.5 * dt * dt * (A.leftCols<9>() * A);
  F.topLeftCorner<6, 6>() = T_step.inverse().Adjoint();
  const double tilt_rate = v.norm() / kFloorTiltWay;
  if (!rates.accel) {
    F.block<3, 9>(kVelocity, 0).setZero();
    F.block<3, 3>(kVelocity, kVelocity) = Vector3d(fade, fade_side, fade_side).asDiagonal();
    if (!state.aligned) F.middleRows<2>(3) *= std::exp(-tilt_rate * dt);
  }

  // White noise: densities through G, trapezoid over the step.
  Eigen::Matrix<double, 9, 9> density = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 3> G = Eigen::Matrix<double, 9, 3>::Zero();
  G.block<3, 3>(3, 0).setIdentity();
  if (rates.accel) G.block<3, 3>(kVelocity, 0) = Skew(v);
  Vector3d turn;
  if (rates.gyro) {
    turn.setConstant(Square(imu_.gyro_noise));
  } else {
    turn.setConstant(kUnmeasuredTiltDensity);
    turn.z() = 2 * Square(kUnmeasuredYawRate) * kUnmeasuredYawRateMemory;
  }
  if (!state.aligned) turn.head<2>().setConstant(2 * Square(kFloorTilt) * tilt_rate);
  density = G * turn.asDiagonal() * G.transpose();
  if (rates.accel) {
    density.diagonal().segment<3>(kVelocity).array() += Square(imu_.accel_noise);
  } else {
    const double side = 2 * Square(config_.lateral_sigma_m_s) / kLateralCorrelation;
    density.diagonal().segment<3>(kVelocity) +=
        Vector3d(2 * Square(kUnmeasuredSpeed) / kUnmeasuredSpeedMemory, side, side);
  }
  density.diagonal().head<6>().array() += kPoseFloor;
  const auto F9 = F.leftCols<9>();
  const Eigen::Matrix<double, 9, 9> noise = 0.5 * dt * (density + F9 * density * F9.transpose());

  ApplyTransition(F, state);
  state.P.topLeftCorner<9, 9>() += noise;
  state.P.diagonal().segment<3>(kGyroBias).array() +=
      imu_.present ? Square(imu_.gyro_walk) * dt : 0.0;
  state.P.diagonal().segment<3>(kAccelBias).array() +=
      imu_.present && imu_.has_accel ? Square(imu_.accel_walk) * dt : 0.0;
  if (config_.wheel_scale_sigma > 0) {
    state.P(kWheelScale, kWheelScale) += Square(kScaleWalk) * dt;
    state.P(kYawScale, kYawScale) += Square(kScaleWalk) * dt;
  }

  state.T_OS = state.T_OS * T_step;
  state.v_OS_S = v_new;
  state.w_OS_S = w;
}

void DrModel::ApplyImu(const ImuSample& imu, FilterState& state) const {
  const double dt = state.has_imu ? (imu.utime - state.imu_utime).seconds() : 0.0;
  PropagateTo(imu.utime, &imu, state);
  state.has_imu = true;
  state.imu_utime = imu.utime;
  state.imu_has_accel = imu.has_accel && imu_.has_accel;
  state.gyro_B = R_BI_ * imu.w_I_rad_s;
  state.accel_B = R_BI_ * imu.a_I_m_s2;
  if (!state.stationary) {
    state.w_OS_S = state.gyro_B - R_BI_ * state.gyro_bias;
    if (!state.aligned) state.w_OS_S.head<2>().setZero();
  }
  UpdateImuStillness(imu, state);
  if (state.imu_has_accel && !state.aligned) Align(imu, state);
  UpdateStationary(imu.utime, state);
  EndSlip(state);
  // Samples of one burst may share a step of microseconds; their noise is that of the rate.
  const double noise_dt = std::clamp(dt, 0.5 / imu_.rate_hz, 2.0 / imu_.rate_hz);
  if (state.leveling) {
    if (imu.utime > state.leveling_end ||
        state.imu_still_since > state.leveling_end - Milliseconds(config_.stationary_ms)) {
      state.leveling = false;
    } else {
      Level(state);
    }
  }
  if (state.stationary) {
    ApplyZeroMotion(noise_dt, state);
  } else if (state.aligned && !WheelsAlive(state) && !state.wheel_drop) {
    ApplySpeedPrior(noise_dt, state);
  }
}

void DrModel::Align(const ImuSample& imu, FilterState& state) const {
  const Vector3d up_S = (R_BI_ * imu.a_I_m_s2).normalized();
  if (!up_S.allFinite()) return;
  // Smallest rotation that makes the measured force vertical; the heading stays.
  const SE3 T_OB = state.T_OS * T_SB_;
  const Vector3d up_O = T_OB.rotation() * up_S;
  const Eigen::Quaterniond tilt = Eigen::Quaterniond::FromTwoVectors(up_O, Vector3d::UnitZ());
  const SE3 aligned_T_OB(tilt * T_OB.rotation(), T_OB.translation());
  state.T_OS = aligned_T_OB * T_BS_;
  state.aligned = true;
  state.leveling = true;
  state.leveling_end = imu.utime + Milliseconds(config_.stationary_ms);
  // Around B: the place of B is known, its tilt is not.
  Matrix6d pose_B = adj_BS_ * state.P.block<6, 6>(kPose, kPose) * adj_BS_.transpose();
  for (int i : {3, 4}) {
    pose_B.row(i).setZero();
    pose_B.col(i).setZero();
    pose_B(i, i) = Square(kTiltPrior);
  }
  const Matrix6d adj_SB = T_SB_.Adjoint();
  state.P.topRows<6>().setZero();
  state.P.leftCols<6>().setZero();
  state.P.block<6, 6>(kPose, kPose) = adj_SB * pose_B * adj_SB.transpose();
  state.transition.topRows<6>().setZero();
  ClonePose(state.clone_utime, state);
  state.has_clone = false;
  if (state.has_wheel) ++state.reset_counter;  // the wheels had begun without gravity
}

void DrModel::Level(FilterState& state) const {
  const Vector3d up_S = state.T_OS.rotation().conjugate() * kUp;
  Eigen::Matrix<double, 3, kErrorSize> H = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  H.block<3, 3>(0, 3) = Skew(up_S);
  H.block<3, 3>(0, kAccelBias) = R_BI_;
  const Vector3d innovation = state.accel_B - R_BI_ * state.accel_bias - up_S;
  const Matrix3d R =
      Matrix3d::Identity() * (Square(imu_.accel_noise) * imu_.rate_hz + Square(kLevelingSigma));
  Update<3>(H, innovation, R, PoseUpdate::kCorrect, state);
}

void DrModel::UpdateImuStillness(const ImuSample& imu, FilterState& state) const {
  // Five sigma of the sample noise, and what a standing robot's motors and fans add.
  const double gyro_limit = 5 * imu_.gyro_noise * std::sqrt(imu_.rate_hz) + 0.005;
  const double accel_limit = 5 * imu_.accel_noise * std::sqrt(imu_.rate_hz) + 0.05;
  constexpr double kForget = 0.05;  // the reference follows drift, not motion
  const bool first = state.imu_still_since.us == 0 && state.gyro_reference.isZero();
  const bool moved =
      (state.gyro_B - state.gyro_reference).norm() > gyro_limit ||
      (state.imu_has_accel && (state.accel_B - state.accel_reference).norm() > accel_limit);
  if (first || moved) {
    state.imu_still_since = imu.utime;
    state.gyro_reference = state.gyro_B;
    state.accel_reference = state.accel_B;
  } else {
    state.gyro_reference += kForget * (state.gyro_B - state.gyro_reference);
    state.accel_reference += kForget * (state.accel_B - state.accel_reference);
  }
}

void DrModel::UpdateWheelStillness(const WheelSample& sample, FilterState& state) const {
  const double limit_m = sample.has_ticks ? 1.5 * tick_m_ : 1e-5;
  const double limit_rad = sample.has_ticks ? 1.5 * tick_m_ / wheel_.track_width_m : 1e-5;
  state.still_way += sample.dx_m;
  state.still_yaw += sample.dyaw_rad;
  bool still = std::abs(state.still_way) <= limit_m && std::abs(sample.dy_m) <= limit_m &&
               std::abs(state.still_yaw) <= limit_rad;
  if (sample.has_heading && state.has_heading &&
      std::abs(WrapAngle(sample.heading_rad - state.heading)) > 2.5 * kHeadingStep) {
    still = false;
  }
  if (still && !state.wheel_still) state.wheel_still_since = sample.utime_begin;
  if (!still) state.still_way = state.still_yaw = 0;
  state.wheel_still = still;
}

void DrModel::UpdateStationary(Utime utime, FilterState& state) const {
  const DurationUs wait = Milliseconds(config_.stationary_ms);
  bool now = WheelsAlive(state) && state.wheel_still && utime - state.wheel_still_since >= wait;
  if (now && ImuAlive(state)) {
    // A steady rate under still wheels is a bias only if the bias may be that large.
    const double bias_sigma = std::sqrt(state.P.diagonal().segment<3>(kGyroBias).maxCoeff());
    const double rate = (state.gyro_reference - R_BI_ * state.gyro_bias).norm();
    now = utime - state.imu_still_since >= wait && rate < config_.gate_sigma * bias_sigma + 0.01;
  }
  if (now == state.stationary) return;
  state.stationary = now;
  if (now) {
    state.v_OS_S.setZero();
    state.w_OS_S.setZero();
    state.P.middleRows<3>(kVelocity).setZero();
    state.P.middleCols<3>(kVelocity).setZero();
    state.transition.middleRows<3>(kVelocity).setZero();
    state.correction_rate.setZero();
  } else {
    // What moved before it was noticed: the wheels measure the way anew from the clone; the gyro
    // was below the limit of stillness for at most a wheel period.
    state.way_unmeasured = true;
    if (!ImuAlive(state)) state.yaw_unmeasured = true;
    state.P(0, 0) += Square(kUnnoticedWay);
    state.P(5, 5) += Square(kUnnoticedTurn);
    state.correction_rate(0, 0) += Square(kUnnoticedWay) / kCorrectionMemory;
    state.correction_rate(5, 5) += Square(kUnnoticedTurn) / kCorrectionMemory;
    state.P.diagonal().segment<3>(kVelocity) += Vector3d(1e-2, 1e-4, 1e-4);
  }
}

void DrModel::ApplyZeroMotion(double dt, FilterState& state) const {
  Eigen::Matrix<double, 3, kErrorSize> H = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  H.block<3, 3>(0, kGyroBias) = R_BI_;
  Update<3>(H, state.gyro_B - R_BI_ * state.gyro_bias,
            Matrix3d::Identity() * (Square(imu_.gyro_noise) / dt), PoseUpdate::kHold, state);
  if (!state.imu_has_accel || !state.aligned) return;
  const Vector3d up_S = state.T_OS.rotation().conjugate() * kUp;
  H.setZero();
  H.block<3, 3>(0, 3) = Skew(up_S);
  H.block<3, 3>(0, kAccelBias) = R_BI_;
  Update<3>(H, state.accel_B - R_BI_ * state.accel_bias - up_S,
            Matrix3d::Identity() * (Square(imu_.accel_noise) / dt + Square(0.01)),
            PoseUpdate::kHold, state);
}

void DrModel::ApplySpeedPrior(double dt, FilterState& state) const {
  const double side = 2 * Square(config_.lateral_sigma_m_s) * kLateralCorrelation / dt;
  const Vector3d variance(2 * Square(kSpeedPrior) * kSpeedPriorMemory / dt, side, side);
  Eigen::Matrix<double, 3, kErrorSize> H = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  H.block<3, 3>(0, kVelocity).setIdentity();
  const Vector3d v_B = state.v_OS_S - state.w_OS_S.cross(T_BS_.translation());
  Update<3>(H, -v_B, variance.asDiagonal(), PoseUpdate::kCorrect, state);
}

void DrModel::ApplyWheelBegin(Utime utime, FilterState& state) const {
  PropagateTo(utime, nullptr, state);
  ClonePose(utime, state);
}

double DrModel::WayVariance(double way) const {
  return Square(config_.wheel_sigma_m_per_sqrt_m) * std::abs(way);
}

double DrModel::WheelYawVariance(double way, double yaw) const {
  return Square(config_.wheel_sigma_deg_per_sqrt_m * kRadPerDeg) * std::abs(way) +
         Square(config_.wheel_sigma_deg_per_sqrt_rad * kRadPerDeg) * std::abs(yaw);
}

SE3 DrModel::MotionSinceClone(const FilterState& state) const {
  return T_BS_ * state.T_OS_clone.inverse() * state.T_OS * T_SB_;
}

void DrModel::FlagSlip(Utime utime, FilterState& state) const {
  if (!state.slip) ++state.counters.slips;
  state.slip = true;
  state.slip_end = utime + DurationFromSeconds(kSlipHold);
}

void DrModel::EndSlip(FilterState& state) const {
  if (!state.slip || state.utime <= state.slip_end) return;
  state.slip = false;
  state.yaw_residual_sum = state.yaw_variance_sum = 0;
}

void DrModel::ApplyWheel(const WheelSample& sample, FilterState& state) const {
  state.wheel_drop = sample.contact.wheel_drop;
  if (state.wheel_drop) {
    // Wheels in the air say nothing of the floor: as if they were silent.
    ++state.counters.wheel_drops;
    state.wheel_still = false;
    UpdateStationary(sample.utime, state);
    PropagateTo(sample.utime, nullptr, state);
    FlagSlip(sample.utime, state);
    state.has_heading = false;
    ClonePose(sample.utime, state);
    return;
  }
  UpdateWheelStillness(sample, state);
  if (!state.wheel_still && state.stationary) UpdateStationary(sample.utime, state);
  PropagateTo(sample.utime, nullptr, state);
  EndSlip(state);
  state.has_wheel = true;
  state.wheel_utime = sample.utime;
  if (!state.stationary && state.has_clone && state.clone_utime == sample.utime_begin) {
    UpdateYaw(sample, state);
    UpdateWay(sample, state);
  }
  state.has_heading = sample.has_heading;
  state.heading = sample.heading_rad;
  ClonePose(sample.utime, state);
  UpdateStationary(sample.utime, state);
}

void DrModel::UpdateYaw(const WheelSample& sample, FilterState& state) const {
  const double dt = (sample.utime - sample.utime_begin).seconds();
  const double way = std::hypot(sample.dx_m, sample.dy_m);
  const SE3 T_ab = MotionSinceClone(state);
  const Vector3d angle = LogSO3(T_ab.rotation());
  const double quantisation = sample.has_ticks ? Square(tick_m_ / wheel_.track_width_m) / 3.0 : 0.0;
  // Where the filter sees the motion by itself, size of the noise and sensitivity to the scale come
  // from there. Taken from the noisy sample they would correlate with its noise: readings that are
  // small by chance would count more, and biases and scales would be pulled to a false value.
  const double turn = state.yaw_unmeasured ? sample.dyaw_rad : angle.z() / state.yaw_scale;
  double wheel_variance = WheelYawVariance(way, turn) + quantisation + Square(kYawFloor);

  const bool use_heading = state.yaw_unmeasured && sample.has_heading && state.has_heading;
  state.heading_used = use_heading;
  Eigen::Matrix<double, 1, kErrorSize> H = Eigen::Matrix<double, 1, kErrorSize>::Zero();
  H.block<1, 3>(0, kPose + 3) = Eigen::RowVector3d::UnitZ();
  H.block<1, 3>(0, kClone + 3) = -T_ab.rotation().conjugate().toRotationMatrix().row(2);
  const double wheel_yaw = state.yaw_scale * sample.dyaw_rad;
  using Scalar = Eigen::Matrix<double, 1, 1>;

  if (state.yaw_unmeasured) {
    double yaw = wheel_yaw;
    double variance = wheel_variance;
    if (use_heading) {
      yaw = WrapAngle(sample.heading_rad - state.heading);
      variance = Square(kHeadingSigmaPerSqrtS) * dt +
                 Square(kHeadingSigmaPerSqrtRad) * std::abs(yaw) + Square(kHeadingStep) / 6.0;
      const double scale_variance = Square(sample.dyaw_rad) * state.P(kYawScale, kYawScale);
      if (Square(yaw - wheel_yaw) >
          Square(config_.gate_sigma) * (wheel_variance + variance + scale_variance)) {
        ++state.counters.gated_wheel_yaw;
        FlagSlip(sample.utime, state);
      }
    } else {
      if (std::abs(yaw / dt - state.w_OS_S.z()) >
          kMaxYawAcceleration * dt + config_.gate_sigma * std::sqrt(2 * variance) / dt) {
        FlagSlip(sample.utime, state);
      }
      if (state.slip) variance = kSlipVarianceFactor * variance + Square(kSlipWayShare * yaw);
      H[kYawScale] = -sample.dyaw_rad;
    }
    state.P(5, 5) += kUnknownVariance;
    Update<1>(H, Scalar(WrapAngle(yaw - angle.z())), Scalar(variance), PoseUpdate::kDefine, state);
    state.w_OS_S = Vector3d(0, 0, yaw / dt);
    return;
  }

  H[kYawScale] = -turn;
  const double residual = WrapAngle(wheel_yaw - angle.z());
  const double variance = (H * state.P * H.transpose())(0) + wheel_variance;
  const double forget = std::exp(-dt / kSlipMemory);
  state.yaw_residual_sum = forget * state.yaw_residual_sum + residual;
  state.yaw_variance_sum = Square(forget) * state.yaw_variance_sum + variance;
  const double gate = Square(config_.gate_sigma);
  const bool refuse = Square(residual) > gate * variance ||
                      Square(state.yaw_residual_sum) > gate * state.yaw_variance_sum;
  if (refuse) {
    // Enough of the sum to refuse the next sample too, not so much that it outlives the slip.
    const double most = 1.2 * config_.gate_sigma * std::sqrt(state.yaw_variance_sum);
    state.yaw_residual_sum = std::clamp(state.yaw_residual_sum, -most, most);
    if (!state.rejecting_yaw) {
      state.rejecting_yaw_since = sample.utime_begin;
      state.rejected_yaw = 0;
    }
    state.rejecting_yaw = true;
    state.rejected_yaw += residual;
    const DurationUs rejecting = sample.utime - state.rejecting_yaw_since;
    const double rate = state.rejected_yaw / rejecting.seconds();
    if (rejecting > DurationFromSeconds(kMaxRejection) && std::abs(rate) < kMaxBiasJump) {
      ++state.counters.gyro_bias_jumps;
      state.P.diagonal().segment<3>(kGyroBias).array() += Square(kGyroBiasPrior) + Square(rate);
      state.yaw_residual_sum = state.yaw_variance_sum = 0;
      state.rejecting_yaw = false;
    } else {
      ++state.counters.gated_wheel_yaw;
      FlagSlip(sample.utime, state);
      return;
    }
  }
  state.rejecting_yaw = false;
  if (state.slip) wheel_variance *= kSlipVarianceFactor;
  Update<1>(H, Scalar(residual), Scalar(wheel_variance), PoseUpdate::kCorrect, state);
}

void DrModel::UpdateWay(const WheelSample& sample, FilterState& state) const {
  const double dt = (sample.utime - sample.utime_begin).seconds();
  const SE3 T_ab = MotionSinceClone(state);
  const Vector3d angle = LogSO3(T_ab.rotation());
  const Eigen::Quaterniond half_back = ExpSO3(-0.5 * angle);

  // In the heading halfway through the interval the way of a rolling robot is straight ahead, for
  // the wheels as for the filter, even where their yaw differs.
  const Vector3d way_measured = Eigen::AngleAxisd(-0.5 * sample.dyaw_rad, Vector3d::UnitZ()) *
                                Vector3d(sample.dx_m, sample.dy_m, 0);
  const Vector3d way_filter = half_back * T_ab.translation();
  const Vector3d way = state.wheel_scale * way_measured;
  const double length = way_measured.norm();

  // Derivative of way_filter with the motion since the clone, then with both poses.
  Eigen::Matrix<double, 3, 6> J;
  J << (half_back * T_ab.rotation()).toRotationMatrix(), 0.5 * Skew(way_filter);
  Eigen::Matrix<double, 3, kErrorSize> H = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  H.block<3, 6>(0, kPose) = J * adj_BS_;
  H.block<3, 6>(0, kClone) = -J * T_ab.inverse().Adjoint() * adj_BS_;

  const double side = 2 * Square(config_.lateral_sigma_m_s) * kLateralCorrelation * dt;
  const auto variance_of = [&](double driven) {
    Vector3d out(WayVariance(driven), side, side);
    out.array() += Square(kWayFloor);
    if (sample.has_ticks) out.x() += Square(tick_m_) / 12.0;
    return out;
  };
  // Sensitivity to the scale, and size of the noise: neither from the sample nor from the
  // prediction, whose errors are in the innovation (see UpdateYaw; the scale would come out 1 %
  // too large here), but from the two combined, whose error the innovation does not hold. Sideways
  // the wheels' own (rolling) way is free of noise.
  Vector3d sensitivity = way_measured;
  if (!state.way_unmeasured) {
    const double predicted = (H.row(0) * state.P * H.row(0).transpose())(0);
    const double share = predicted / (predicted + variance_of(way_filter.x()).x());
    sensitivity.x() = (way_filter.x() + share * (way.x() - way_filter.x())) / state.wheel_scale;
  }
  Vector3d variance = variance_of(state.way_unmeasured ? length : sensitivity.x());
  H.col(kWheelScale) = -sensitivity;

  if (!state.way_unmeasured) {
    const Matrix3d S = H * state.P * H.transpose() + Matrix3d(variance.asDiagonal());
    const Vector3d ratio = (way - way_filter).array().square() / S.diagonal().array();
    const double worst = ratio.maxCoeff() / Square(config_.gate_sigma);
    if (worst > 1) {
      if (!state.rejecting_way) state.rejecting_way_since = sample.utime_begin;
      state.rejecting_way = true;
      ++state.counters.gated_wheel_way;
      FlagSlip(sample.utime, state);
      const bool too_long =
          sample.utime - state.rejecting_way_since > DurationFromSeconds(kMaxRejection);
      if (!too_long) return;
      variance += worst * S.diagonal();  // believed again, as little as it agrees
    } else {
      state.rejecting_way = false;
    }
    if (state.slip) variance *= kSlipVarianceFactor;
    Update<3>(H, way - way_filter, variance.asDiagonal(), PoseUpdate::kCorrect, state);
    return;
  }

  const Vector3d arm = T_BS_.translation();
  const Vector3d v_before = state.v_OS_S - state.w_OS_S.cross(arm);
  const Vector3d v_now = way / dt;
  if ((v_now - v_before).head<2>().norm() >
      kMaxAcceleration * dt + config_.gate_sigma * std::sqrt(2 * variance.x()) / dt) {
    FlagSlip(sample.utime, state);
  }
  if (state.slip) {
    variance.x() = kSlipVarianceFactor * variance.x() + Square(kSlipWayShare * length);
    variance.y() *= kSlipVarianceFactor;
  }
  state.P.diagonal().head<3>().array() += kUnknownVariance;
  Update<3>(H, way - way_filter, variance.asDiagonal(), PoseUpdate::kDefine, state);
  // The velocity is that of the interval.
  state.v_OS_S = v_now + state.w_OS_S.cross(arm);
  const Eigen::Matrix<double, 3, kErrorSize> scale_rows =
      (way_measured / dt) * state.P.row(kWheelScale);
  const Eigen::Matrix<double, 3, kErrorSize> scale_map =
      (way_measured / dt) * state.transition.row(kWheelScale);
  state.P.middleRows<3>(kVelocity) = scale_rows;
  state.P.middleCols<3>(kVelocity) = scale_rows.transpose();
  state.P.block<3, 3>(kVelocity, kVelocity) =
      (way_measured / dt) * (way_measured / dt).transpose() * state.P(kWheelScale, kWheelScale) +
      Matrix3d(variance.asDiagonal()) / (dt * dt);
  state.transition.middleRows<3>(kVelocity) = scale_map;
}

DrState DrModel::Publish(const FilterState& state) const {
  DrState out;
  out.utime = state.utime;
  out.reset_counter = state.reset_counter;
  out.T_OB = state.T_OS * T_SB_;
  out.w_OB_B = state.w_OS_S;
  out.v_OB_B = state.v_OS_S - state.w_OS_S.cross(T_BS_.translation());
  out.gyro_bias_rad_s = state.gyro_bias;
  out.accel_bias_m_s2 = state.accel_bias;
  out.wheel_scale = state.wheel_scale;
  const Matrix6d cov = adj_BS_ * state.P.block<6, 6>(kPose, kPose) * adj_BS_.transpose();
  out.cov_T_OB = 0.5 * (cov + cov.transpose());
  out.gravity_aligned = state.aligned;
  out.slip = state.slip;
  out.stationary = state.stationary;
  out.wheels_alive = WheelsAlive(state);
  out.imu_alive = ImuAlive(state);

  out.cov_twist_white.diagonal().setConstant(kPoseFloor);
  if (state.stationary) return out;
  const double speed = out.v_OB_B.norm();
  const double rate = std::abs(out.w_OB_B.z());
  const bool gyro = out.imu_alive;
  const double slip = state.slip ? kSlipVarianceFactor : 1.0;
  Vector6d white = Vector6d::Zero();
  Matrix6d& C = out.cov_twist_coherent;

  const double side = 2 * Square(config_.lateral_sigma_m_s) * kLateralCorrelation;
  if (out.wheels_alive) {
    white.head<3>() << WayVariance(speed), side, side;
    white.head<2>() *= slip;
    if (state.slip) C(0, 0) += Square(kSlipWayShare * speed);
    C(0, 0) += Square(speed) * state.P(kWheelScale, kWheelScale);
  } else {
    C.block<3, 3>(0, 0) = state.P.block<3, 3>(kVelocity, kVelocity);
    white[1] = white[2] = side;
  }
  if (gyro) {
    white.tail<3>().setConstant(Square(imu_.gyro_noise));
    const Matrix3d bias = state.P.block<3, 3>(kGyroBias, kGyroBias);
    C.block<3, 3>(3, 3) = R_BI_ * bias * R_BI_.transpose();
  } else if (state.heading_used) {
    white[5] = Square(kHeadingSigmaPerSqrtS) + Square(kHeadingSigmaPerSqrtRad) * rate;
    C(5, 5) = Square(kHeadingDrift);
  } else {
    white[5] = WheelYawVariance(speed, rate) * slip;
    C(5, 5) = Square(rate) * state.P(kYawScale, kYawScale);
  }
  if (!state.aligned) {
    white[3] = white[4] = 2 * Square(kFloorTilt) * speed / kFloorTiltWay;
    C.row(3).setZero();
    C.row(4).setZero();
    C.col(3).setZero();
    C.col(4).setZero();
  } else if (!gyro) {
    white[3] = white[4] = kUnmeasuredTiltDensity;
  }
  out.cov_twist_white.diagonal() += white;
  out.cov_twist_white += adj_BS_ * state.correction_rate * adj_BS_.transpose();
  return out;
}

}  // namespace gw::dr_ekf
