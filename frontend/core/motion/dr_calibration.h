// What healthy vision teaches about dead reckoning (DR), for the time when there is none.
//
// Scale errors make most of the drift of a wheeled robot: the sensitivity of a gyro is off by up to
// some per cent (BMI055, L3G4200D datasheets: 1 to 3 %), the radius of wheels likewise. Wheels and
// gyro know little of it: the DR filter tells what they know, an estimate and its doubt. The map
// knows more. Two scalar filters, s = true motion / motion as the sensors measured it:
//
//   theta_vision = s theta_sensor - b t + n       heading: rotation about body z over a window t
//   x_vision     = s x_sensor + n                 way: translation along body x
//
// b is the bias of the gyro about body z. Where the robot has not stood, only the wheels tell the
// filter of it, and they drift by as much; vision sees a turn to a tenth of a degree in any second.
//
// A camera is mounted by hand, and looks a degree beside the way it is said to look: seen from it,
// the base drives beside body x, by 17 mm per metre. Two more filters, for yaw and pitch:
//
//   y_vision = d x_sensor + n           and z alike, on straight ways
//
// Vision's knowledge of scales and bias is kept apart from the DR filter's, whose estimate moves on
// as well; the two are independent and fused when a motion is corrected. Errors of the camera's own
// calibration enter too: DR then agrees with the map that the robot comes back into, which is what
// a blind span needs.
#pragma once

#include "common/contract/dead_reckoning.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "common/good_weights/dr_history.h"

namespace gw::frontend {

class DrCalibration {
 public:
  // up_I: body z in the IMU's axes, in which DR tells the bias of the gyro.
  explicit DrCalibration(const Eigen::Vector3d& up_I);

  // The motion without the errors known so far. Body frame. dr: what DR says of its scales and
  // bias.
  SE3 Corrected(const SE3& T_BaBb, DurationUs interval, const DrState& dr) const;
  // What is then left of DR's doubt in scales and bias.
  void Limit(DrNoise* noise, const DrState& dr) const;

  // The body's motion between two images in a row that vision carries in full health, as DR tells
  // it (not corrected) and as vision measured it. turn_variance: of DR's turn, beside its scale and
  // bias, rad^2.
  void Observe(const SE3& T_BaBb_dr, const SE3& T_BaBb_vision, DurationUs interval,
               const DrState& dr, double turn_variance);
  // Between two images vision was not healthy, or DR has doubts of its own (slip).
  void Interrupt() { window_ = straight_ = Window(); }

 private:
  // Motions are compared over windows: the noise of vision then counts at their ends only.
  struct Window {
    SE3 dr, vision;
    DurationUs length{0};
    double bias_turn = 0;      // rad, what DR took for the bias of the gyro
    double turn_variance = 0;  // rad^2, of DR's turn

    void Append(const SE3& T_dr, const SE3& T_vision, DurationUs interval);
  };
  // What the DR filter knows of a scale.
  struct Told {
    double scale;  // that its motions hold
    double sigma;
  };
  // What vision alone knows of a scale, in information form: motions that tell next to nothing of
  // it (a straight way for the heading) then add next to nothing, however small they are.
  struct Scale {
    double weighted = 0;  // information times estimate
    double information = 0;
    double Fused(const Told& told) const;
    // dr: motion that holds told.scale. sigma: of measured, beside the scale. What is far off is
    // not used.
    void Update(double dr, double measured, double sigma, const Told& told);
    // Time passes.
    void Forget(DurationUs time);
    // Variance of the two fused / variance told.
    double DoubtLeft(double told_sigma) const;
  };
  // What the DR filter knows of scale and bias of what tells turns.
  struct ToldTurn {
    Eigen::Vector2d value;  // -, rad/s
    Eigen::Vector2d sigma;
  };
  // What vision alone knows of them, in information form as above.
  struct Turn {
    Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Matrix2d Covariance(const ToldTurn& told) const;  // of the two fused
    Eigen::Vector2d Fused(const ToldTurn& told) const;
    // sensed: turn with scale and bias still in, and its variance beside them. What is far off is
    // not used.
    void Update(double sensed, double sensed_variance, double measured, DurationUs length,
                const ToldTurn& told);
    void Forget(DurationUs time);
  };
  // Where the base drives, as a slope against body x; small.
  struct Direction {
    double estimate;
    double variance;
    // sigma: of the motion beside the way. What is far off is not used.
    void Update(double way, double beside, double sigma);
  };
  ToldTurn Heading(const DrState& dr) const;
  static Told Way(const DrState& dr);
  static Told Bounded(double scale, double sigma);  // whatever a message says

  Eigen::Vector3d up_I_;
  Window window_;
  Turn heading_;
  Scale way_;
  Window straight_;
  Direction sideways_;
  Direction upwards_;
};

}  // namespace gw::frontend
