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
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/filter_state.h"
#include "dr_ekf/core/slip_gate.h"
#include "dr_ekf/core/vision_witness.h"

namespace gw::dr_ekf {

class DrModel {
 public:
  DrModel(const DrEkfConfig& config, const Calibration& calibration);

  // At rest in the origin of O with the priors of noise_model.h.
  FilterState Initial(Utime utime) const;
  // After a break of unknown motion: pose kept, its covariance widened, counter moved on.
  FilterState Restarted(const FilterState& before, Utime utime) const;
  // Likewise of a filter whose IMU turned out to be useless; this model has none. T_OB: of before.
  FilterState RestartedWithoutImu(const FilterState& before, const SE3& T_OB, Utime utime) const;

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
  struct Step {  // of the state, over one propagation step
    SE3 T;       // motion of S
    Eigen::Vector3d v_after;
    Eigen::Vector3d fade;  // what is left of the velocity, per axis
  };
  Step StepOf(const Rates& rates, double dt, const FilterState& state) const;
  TopTransition TransitionOf(const Rates& rates, double dt, const Step& step,
                             const FilterState& state) const;
  Eigen::Matrix<double, 9, 9> NoiseDensity(const Rates& rates, const FilterState& state) const;
  void Wander(double dt, FilterState& state) const;
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
  // Motion of B since the clone.
  SE3 MotionSinceClone(const FilterState& state) const;
  double WayVariance(double way) const;
  // Sideways, and likewise up. A turn on the spot is a way for the tyres too.
  double SideVariance(double way, double turn) const;
  double WheelYawVariance(double way, double yaw) const;
  double TrackSpeed(double yaw, double dt) const;
  // Speed and turn rate of B now.
  Eigen::Vector2d Speeds(const FilterState& state) const;
  // Covariance of the errors of the sums of one sample: time error, quantisation.
  Eigen::Matrix2d SumCovariance(bool has_ticks, const FilterState& state) const;
  // Variance of a sum's error (0: way, 1: turn) that is no slip.
  double SumError(int sum, const FilterState& state) const;
  // Largest error of a sum (0: way, 1: turn) that stamps in the right order can make, twice.
  double LargestTimeError(int sum, double dt, const FilterState& state) const;

  // The newest sum is off by as much as this innovation says, which is then within one sigma.
  void DoubtSum(int sum, double innovation, const Eigen::Matrix<double, 1, kErrorSize>& H,
                double noise, FilterState& state) const;

  // dr_model_yaw.cc
  // One wheel interval against the motion of the filter since the clone.
  struct YawInnovation {
    Eigen::Matrix<double, 1, kErrorSize> H;
    double measured = 0;   // rad, true turn by the wheels
    double residual = 0;   // rad, wheels minus filter, without the errors of the sums
    double turn = 0;       // rad, in the wheels' units: sensitivity to their scale
    double predicted = 0;  // rad^2, of the filter's own turn
    double noise = 0;      // rad^2, of the wheels' turn, without the errors of the sums
    double dt = 0;
  };
  void UpdateYaw(const WheelSample& sample, FilterState& state) const;
  YawInnovation InnovateYaw(const WheelSample& sample, const FilterState& state) const;
  void DefineYaw(const WheelSample& sample, const YawInnovation& in, FilterState& state) const;
  // Variance of the wheels' turn beyond what the configuration says: see NoiseFactor.
  double ExtraTurnVariance(double turn, double wheel_turn, const FilterState& state) const;
  // A heading that does not change while the wheels turn is not believed.
  bool HeadingMayBeUsed(const WheelSample& sample, FilterState& state) const;
  // Likewise wheels whose heading does not change while they drive and the gyro turns.
  bool WheelTurnMayBeUsed(const WheelSample& sample, double own_turn, double dt,
                          FilterState& state) const;
  // What the wheels' turn may tell: all, only the track (which is not known, or is another than the
  // one of a base that rolls), or nothing (slip).
  enum class YawUse { kAll, kTrack, kNone };
  YawUse JudgeYaw(const WheelSample& sample, const YawInnovation& in, FilterState& state) const;
  // Over kWatchMemory without slip the turns of wheels and gyro agree as far as bias and scales are
  // known, or these are doubted.
  void WatchYaw(const YawInnovation& in, SlipGate::Interval interval, FilterState& state) const;
  void DoubtTurn(FilterState& state) const;

  // dr_model_way.cc
  struct WayInnovation {
    Eigen::Matrix<double, 3, kErrorSize> H;
    Eigen::Vector3d way = Eigen::Vector3d::Zero();  // m, true way by the wheels, heading halfway
    Eigen::Vector3d residual = Eigen::Vector3d::Zero();  // m, without the errors of the sums
    Eigen::Vector3d noise = Eigen::Vector3d::Zero();     // m^2, likewise
    Eigen::Vector3d measured = Eigen::Vector3d::Zero();  // m, in the wheels' units
    double dt = 0;
  };
  void UpdateWay(const WheelSample& sample, FilterState& state) const;
  WayInnovation InnovateWay(const WheelSample& sample, const FilterState& state) const;
  void CorrectWay(WayInnovation in, FilterState& state) const;
  // The accelerometer asks for wheels that the priors do not know.
  bool ContradictsPriors(const FilterState& state) const;
  // Over kWatchMemory without slip the filter's way is that of the wheels.
  void WatchWay(const WayInnovation& in, double sums, FilterState& state) const;
  void DefineWay(const WheelSample& sample, WayInnovation in, FilterState& state) const;

  // dr_model_floor.cc
  // The height of a robot on a floor, over the wheel interval that ends now.
  void UpdateHeight(double way, FilterState& state) const;
  bool OnRamp(const FilterState& state) const;

  // dr_model_slip.cc
  // speed_doubt: m/s, how wrong the wheels' speed may be where nothing else measures it.
  void FlagSlip(Utime utime, double speed_doubt, FilterState& state) const;
  void EndSlip(FilterState& state) const;
  bool HasAccelerometer(const FilterState& state) const;
  // Judges the wheels' way along an axis (0 or 1) of B over the interval that ends now: wheels
  // minus accelerometer. stand: the wheels read no way at all. excess: as SlipGate.
  SlipGate::Verdict JudgeWay(int axis, double way, bool stand, const SlipGate::Interval& interval,
                             double* excess, FilterState& state) const;
  void DoubtAccelerometer(int axis, double speed_error, FilterState& state) const;

  DrEkfConfig config_;
  ImuCalibration imu_;
  WheelCalibration wheel_;
  Eigen::Matrix3d R_BI_;
  SE3 T_BS_;
  SE3 T_SB_;
  Matrix6d adj_BS_;  // carries perturbations of T_OS to T_OB
  double tick_m_ = 0;
  double wheel_period_s_ = 0;
  DurationUs imu_cover_;  // one IMU sample speaks for at most this long
  DurationUs imu_timeout_;
  DurationUs wheel_timeout_;
};

}  // namespace gw::dr_ekf
