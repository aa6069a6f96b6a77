// Where the camera will be when the next image comes: by dead reckoning (DR), or at constant
// velocity where there is none.
#pragma once

#include <deque>
#include <optional>

#include "common/camera/camera_model.h"
#include "common/config/frontend_config.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "common/good_weights/dr_history.h"
#include "frontend/core/features/fixed_in_image.h"
#include "frontend/core/motion/anchor_history.h"
#include "frontend/core/motion/dr_calibration.h"
#include "frontend/core/motion/dr_constant.h"
#include "frontend/core/motion/dr_disagreement.h"
#include "frontend/core/motion/dr_trust.h"
#include "frontend/core/motion/length_ratio.h"
#include "frontend/core/motion/scale_witness.h"

namespace gw::frontend {

struct Motion {
  SE3 T_ab;                     // camera at the end in the camera at the beginning
  SE3 T_BaBb_dr;                // from_dr: the body, as DR told it, its scale errors still in
  double turn_variance_dr = 0;  // rad^2, of its turn, beside scale and bias
  DrNoise noise;  // of T_ab, right perturbation: what the motion's source says of itself
  // Sigma_d of the weighting: DrCovariance in common/good_weights.
  Matrix6d weight_cov = Matrix6d::Identity();
  bool from_dr = false;
  bool slip = false;
};

class MotionModel {
 public:
  MotionModel(const RectifiedCamera& camera, const ImuCalibration& imu,
              const FrontendConfig& config)
      : T_BC_(camera.T_BC),
        up_I_(imu.T_BI.rotation().conjugate() * Eigen::Vector3d::UnitZ()),
        variant_(config.variant),
        dr_weight_(config.dr_weight),
        calibrate_dr_(config.calibrate_dr && dr_weight_.Departs(Departure::kCalibration)) {}

  // False: not newer than the state before, refused.
  bool Push(const DrState& state);

  // Pose of the first image: origin and heading of W are those of the body, and so are roll and
  // pitch where DR is on a floor: W is level there. Else these are absolute, where DR knows
  // gravity.
  SE3 FirstPose(Utime utime) const;

  // Between two images in a row. Always gives a motion; from_dr says whether DR covers the
  // interval, the variant uses it, and vision that carried the image at `a` does not contradict it.
  Motion Between(Utime a, Utime b) const;

  // The same at constant velocity, whatever DR says: where vision carried the image at `a`, an
  // evidence of its own.
  Motion Coast(Utime a, Utime b) const;

  // DR over any interval, its scale errors taken out, for the edge between two keyframes. Body
  // frame. Empty also in variants without such edges, and while healthy vision contradicts it.
  std::optional<DrIncrement> Increment(Utime a, Utime b) const;

  // Height of the body, for a keyframe; empty also where DR tells no covariance. Told also while
  // vision contradicts DR: what is wrong with its ways and turns says nothing of the floor.
  std::optional<DrHeight> Height(Utime utime) const;

  // The motion of the camera as DR tells it, with the noise that it claims, whether vision agrees
  // or not. Empty where DR does not cover the interval or notices slip, or the variant does not
  // use it.
  std::optional<CameraStep> Step(Utime a, Utime b) const;

  // The camera in the odometry frame; empty where DR does not cover the instant, or the variant
  // does not use it.
  std::optional<SE3> OdometryPose(Utime utime) const;

  // The image at b goes without vision and has the pose that `taken` leads to from the image at a.
  // Motions from there go on from what DR tells of b now, whatever it tells of that instant later:
  // wheels without an IMU may tell of an image when two more have come.
  void GoOn(Utime a, Utime b, const Motion& taken);

  // What vision measured between two images in a row.
  struct Seen {
    Utime a, b;
    SE3 T_ab;              // the camera's motion: the velocity to go on with
    bool healthy = false;  // well enough to teach DR its scale errors
    bool sure = false;     // well enough to be compared with DR
    // The pose of the image at b by vision alone and its covariance; set where sure.
    SE3 T_WC_vision;
    Matrix6d cov_vision = Matrix6d::Identity();
  };
  // expected: what Between said of the two images.
  void Observe(const Seen& seen, const Motion& expected);
  // Vision measured nothing.
  void ObserveNothing();
  // Since then vision was held by what is not the world: what it has taught of DR is void.
  void Unlearn(Utime since);
  // The clock of the images was set: what was measured before has no time any more. DR follows its
  // own clock.
  void Restart();
  // The map moved, and all poses in it, from T to T_correction * T.
  void MapMoved(const SE3& T_correction);

  // False while healthy vision contradicts DR.
  bool dr_trusted() const {
    return learnt_.trust.trusted() || !dr_weight_.Departs(Departure::kTrust);
  }
  // The constant by which DR is wrong: the one that is taken out of it; or, while healthy vision
  // contradicts it, the one that explains that.
  DrConstantFault dr_fault() const;

  // The lengths that vision tells are this many times too long, and what is taken out of DR as a
  // factor of its way is vision's: the accelerometer says so. Empty: not known to be.
  std::optional<double> vision_factor() const;
  // The lengths that vision tells, and has told, are shorter by this factor from now on.
  void VisionCorrected(double factor);

  const DrState* newest_dr() const { return dr_.empty() ? nullptr : &dr_.newest(); }

 private:
  SE3 T_BC_;
  Eigen::Vector3d up_I_;
  Variant variant_;
  DrWeightConfig dr_weight_;
  DrHistory told_{DrTrust::kWindow + DrTrust::kWindow};  // DR as it is told
  ScaleWitness scale_witness_;
  DrHistory dr_;        // without the constant by which it is wrong
  bool apart_ = false;  // a constant was taken out: dr_ goes on from where that has led
  bool calibrate_dr_;
  Vector6d velocity_ = Vector6d::Zero();  // camera twist, 1/s
  Utime observed_;                        // until here

  // An image that went without vision, and the pose of DR that its own stands for.
  struct Carried {
    Utime utime;
    SE3 T_OB;
    uint32_t reset_counter = 0;
  };
  std::deque<Carried> carried_;  // those that dr_ covers
  // What an image goes on from: what DR told of it where it went without vision, else what DR tells
  // of it now. Empty where DR does not cover it.
  std::optional<SE3> DrPose(Utime utime) const;

  // DR over an interval, and without the errors that are known of it.
  struct Calibrated {
    DrIncrement told;
    SE3 T_BaBb;
    DrNoise noise;  // of T_BaBb; body frame
  };
  std::optional<Calibrated> DrBetween(Utime a, Utime b) const;
  bool OnFloor() const;  // DR is that of a robot on wheels, and counts as such
  DrNoise OrNominal(DrNoise told, DurationUs length) const;
  void CompareWithVision(const Seen& seen);
  void TakeOutConstant();
  void LearnAnew(const DrConstant& constant);
  DrNoise Shown(const DrNoise& claimed) const;
  Matrix6d WeightCovariance(const Matrix6d& nominal, const Matrix6d& shown) const;

  // Healthy vision in a row, since this image.
  struct Window {
    Utime begin;
    SE3 T_WC;
    Matrix6d cov;
    double speed;  // m/s, by DR
  };
  std::optional<Window> window_;

  // What vision has taught of DR, until an image.
  struct Lessons {
    explicit Lessons(const Eigen::Vector3d& up_I) : calibration(up_I) {}
    Utime until;
    DrCalibration calibration;
    DrTrust trust;
    DrDisagreement disagreement;
    DrConstant constant;
    LengthRatio lengths;
  };
  Lessons learnt_{up_I_};
  std::deque<Lessons> learnt_before_;  // as it was before each window of AnchorHistory::kSpan
};

}  // namespace gw::frontend
