// The error-state Kalman filter itself: how one sample changes a FilterState. Pure: the same state
// and sample give the same bytes, which is what lets DrFilter replay late measurements.
//
// Modes follow from what is alive, without a switch: a gyro drives the attitude, else the wheels
// (or the base's heading) do; an accelerometer drives the velocity, else the wheels do; a wheel
// sample always enters as the motion over its own interval (from a clone of the pose at its begin,
// stochastic cloning after Roumeliotis and Burdick 2002), never as a pose.
#pragma once

#include "common/camera/calibration.h"
#include "common/config/dr_ekf_config.h"
#include "common/contract/dead_reckoning.h"
#include "common/contract/samples.h"
#include "dr_ekf/core/filter_state.h"
#include "dr_ekf/core/vision_witness.h"

namespace gw::dr_ekf {

class DrModel {
 public:
  DrModel(const DrEkfConfig& config, const Calibration& calibration);

  // At rest in the origin of O with the priors of noise_model.h.
  FilterState Initial(Utime utime) const;
  // After a break of unknown motion: pose kept, its covariance widened, counter moved on.
  FilterState Restarted(const FilterState& before, Utime utime) const;

  // Samples carry camera time (offsets removed) and are newer than, or as old as, the state.
  void ApplyImu(const ImuSample& sample, FilterState& state) const;
  void ApplyWheelBegin(Utime utime, FilterState& state) const;
  void ApplyWheel(const WheelSample& sample, FilterState& state) const;
  void ApplyVerdict(const VisionVerdict& verdict, FilterState& state) const;

  // What consumers get; seq is the caller's.
  DrState Publish(const FilterState& state) const;

  bool WheelsAlive(const FilterState& state) const;
  bool ImuAlive(const FilterState& state) const;

  // Body in the frame of the error state.
  const SE3& T_SB() const { return T_SB_; }

 private:
  struct Rates {  // of one propagation step
    bool gyro = false;
    bool accel = false;
    Eigen::Vector3d w = Eigen::Vector3d::Zero();  // rad/s
    Eigen::Vector3d a = Eigen::Vector3d::Zero();  // m/s^2, specific force
  };

  // dr_model_propagation.cc
  // Up to the time of `imu` with its rates, or (null) with the newest rates up to `utime`.
  void PropagateTo(Utime utime, const ImuSample* imu, FilterState& state) const;
  // True rate, axes of B, by what the gyro says in these axes.
  Eigen::Vector3d Rate(const Eigen::Vector3d& gyro_B, const FilterState& state) const;
  Rates RatesBetween(Utime from, Utime to, const ImuSample* imu, const FilterState& state) const;
  void Integrate(const Rates& rates, double dt, FilterState& state) const;
  void Hold(double dt, FilterState& state) const;

  // dr_model_gravity.cc
  void Align(const ImuSample& imu, FilterState& state) const;
  void Level(FilterState& state) const;

  // dr_model_stillness.cc
  void UpdateImuStillness(const ImuSample& imu, FilterState& state) const;
  void UpdateWheelStillness(const WheelSample& sample, FilterState& state) const;
  void UpdateStationary(Utime utime, FilterState& state) const;
  void ApplyZeroMotion(double dt, FilterState& state) const;

  // dr_model_wheels.cc
  void ApplySpeedPrior(double dt, FilterState& state) const;
  void UpdateYaw(const WheelSample& sample, FilterState& state) const;
  void UpdateWay(const WheelSample& sample, FilterState& state) const;
  // Motion of B since the clone.
  SE3 MotionSinceClone(const FilterState& state) const;
  double WayVariance(double way) const;
  // Sideways, and likewise up. A turn on the spot is a way for the tyres too.
  double SideVariance(double way, double turn) const;
  double WheelYawVariance(double way, double yaw) const;
  double TrackSpeed(double yaw, double dt) const;

  // dr_model_slip.cc
  // speed_doubt: m/s, how wrong the wheels' speed may be where nothing else measures it.
  void FlagSlip(Utime utime, double speed_doubt, FilterState& state) const;
  void EndSlip(FilterState& state) const;
  bool HasAccelerometer(const FilterState& state) const;
  // Whether the wheels' way along an axis (0 or 1) of B is to be used. innovation: wheels minus
  // accelerometer over the interval that ends now, variance: what the filter expects of it.
  bool AcceptWay(int axis, double way, double innovation, double variance, double dt,
                 FilterState& state) const;
  void DoubtAccelerometer(int axis, double speed_error, FilterState& state) const;

  DrEkfConfig config_;
  ImuCalibration imu_;
  WheelCalibration wheel_;
  Eigen::Matrix3d R_BI_;
  SE3 T_BS_;
  SE3 T_SB_;
  Matrix6d adj_BS_;  // carries perturbations of T_OS to T_OB
  double tick_m_ = 0;
  DurationUs imu_cover_;  // one IMU sample speaks for at most this long
  DurationUs imu_timeout_;
  DurationUs wheel_timeout_;
};

}  // namespace gw::dr_ekf
