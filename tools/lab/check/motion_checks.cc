#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/core/median.h"
#include "tools/data/files/format.h"
#include "tools/lab/check/checks.h"

namespace gw::check {
namespace {

using tools::Format;

constexpr double kStandardGravity = 9.80665;  // m/s^2; CGPM 1901
constexpr double kDegrees = 180 / M_PI;
constexpr double kEnoughTurn = 0.8;  // rad: half a right angle
constexpr double kEnoughWay = 1.0;   // m
// Two sensors of one motion follow each other far better; noise follows nothing.
constexpr double kFollows = 0.7;
// Scales that the filter learns by itself are within a few per cent (docs/method.md, section 4).
constexpr double kScaleTolerance = 0.05;
// At 1 rad/s 20 ms are 1 degree: what dead reckoning otherwise loses in a minute.
constexpr double kDelayTolerance = 0.020;  // s
constexpr double kMountTolerance = 3 / kDegrees;

class MotionChecker {
 public:
  MotionChecker(const MotionSources& motion, const RobotConfig& config)
      : motion_(motion), config_(config) {}

  Findings Check() {
    const Calibration& c = config_.calibration;
    const DurationUs imu_offset = DurationFromSeconds(c.imu.time_offset_s);
    const DurationUs wheel_offset = DurationFromSeconds(c.wheel.time_offset_s);
    gyro_of_vision_ = FitMotion(motion_.vision_turns, motion_.gyro_B[2], imu_offset, kEnoughTurn);
    wheel_of_vision_ =
        FitMotion(motion_.vision_turns, motion_.wheel_turn, wheel_offset, kEnoughTurn);
    gyro_of_wheel_ =
        FitMotion(motion_.wheel_turns, motion_.gyro_B[2], imu_offset - wheel_offset, kEnoughTurn);
    way_of_vision_ = FitMotion(motion_.vision_ways, motion_.wheel_way, wheel_offset, kEnoughWay);
    CheckGyroAxes();
    CheckTurns();
    CheckDelays();
    CheckWay();
    CheckMounting();
    return std::move(findings_);
  }

 private:
  void Fail(const char* id, std::string text, std::string fix) {
    findings_.push_back({Severity::kError, id, std::move(text), std::move(fix)});
  }

  static bool Follows(const std::optional<MotionFit>& fit) {
    return fit && std::abs(fit->correlation) > kFollows;
  }
  static bool Off(const MotionFit& fit) {
    return std::abs(fit.scale - 1) > std::max(kScaleTolerance, 4 * fit.sigma_scale);
  }

  // The gyro does not follow about the body's z: does it about another axis?
  void CheckGyroAxes() {
    const auto& reference =
        !motion_.vision_turns.empty() ? motion_.vision_turns : motion_.wheel_turns;
    const auto& upright = !motion_.vision_turns.empty() ? gyro_of_vision_ : gyro_of_wheel_;
    if (motion_.gyro_B[2].empty() || !upright || Follows(upright)) return;
    constexpr const char* kAxes[] = {"x", "y", "z"};
    const char* best = nullptr;
    double best_correlation = kFollows;
    for (size_t axis = 0; axis < 2; ++axis) {
      const auto fit = FitMotion(reference, motion_.gyro_B[axis], DurationUs{}, kEnoughTurn);
      if (!fit || std::abs(fit->correlation) < best_correlation) continue;
      best_correlation = std::abs(fit->correlation);
      best = kAxes[axis];
    }
    gyro_turned_ = best != nullptr;
    if (best == nullptr) return;
    Fail("imu-axes", Format("the robot turns about its z, the gyro (with T_BI) about %s", best),
         "correct the rotation of calibration.imu.T_BI");
  }

  // Who of gyro, wheels and vision is wrong about turns: the one that two others contradict.
  void CheckTurns() {
    const bool gv = Follows(gyro_of_vision_), wv = Follows(wheel_of_vision_),
               gw = Follows(gyro_of_wheel_);
    const bool gv_off = gv && Off(*gyro_of_vision_), wv_off = wv && Off(*wheel_of_vision_),
               gw_off = gw && Off(*gyro_of_wheel_);
    if (gv_off && wv_off && !gw_off && gw) {
      Fail("focal-length",
           Format("gyro and wheels agree on the turns, vision sees %.3f of them",
                  1 / gyro_of_vision_->scale),
           "the intrinsics are not those of these images (focal length, size)");
    } else if (gv_off) {
      SayGyro(*gyro_of_vision_, "vision");
      if (wv_off) SayWheels(*wheel_of_vision_, "vision");
    } else if (wv_off) {
      SayWheels(*wheel_of_vision_, "vision");
    } else if (gw_off && !gv && !wv) {
      // Only a unit tells who: wheels of a skid-steer base are wrong by a factor of three.
      if (gyro_of_wheel_->scale < 0) {
        Fail("turn-sign", "gyro and wheels turn against each other",
             "run without --no-vision to see who is wrong");
      } else if (gyro_of_wheel_->scale > 7.5) {
        SayGyro(*gyro_of_wheel_, "the wheels");
      } else {
        MotionFit inverse = *gyro_of_wheel_;
        inverse.scale = 1 / inverse.scale;
        SayWheels(inverse, "the gyro");
      }
    }
    if (!motion_.gyro_B[2].empty() && gyro_of_vision_ && !gv && wv && !gyro_turned_) {
      Fail("gyro-silent", "the gyro does not follow the turns that wheels and vision agree on",
           "is it the IMU of this robot, of this recording, on this clock?");
    }
    if (!motion_.wheel_turn.empty() && wheel_of_vision_ && !wv && gv) {
      Fail("wheels-silent", "the wheels do not follow the turns that gyro and vision agree on",
           "is the heading of the base stuck? Are these the wheels of this recording?");
    }
  }

  void SayGyro(const MotionFit& fit, const char* witness) {
    if (fit.scale < 0) {
      Fail("gyro-sign", Format("the gyro turns against %s (scale %.2f)", witness, fit.scale),
           "the axes of T_BI are wrong: z of the IMU points down");
    } else if (fit.scale > 40 && fit.scale < 80) {
      Fail("gyro-unit",
           Format("the gyro tells %.1f times the turns of %s: degrees, not radians", fit.scale,
                  witness),
           "write rad/s (gw-import --gyro-unit deg/s converts)");
    } else {
      Fail("gyro-scale",
           Format("the gyro tells %.3f +- %.3f of the turns of %s", fit.scale, fit.sigma_scale,
                  witness),
           "check its range and unit");
    }
  }

  void SayWheels(const MotionFit& fit, const char* witness) {
    if (fit.scale < 0) {
      Fail("wheel-turn-sign", Format("the wheels turn against %s (scale %.2f)", witness, fit.scale),
           "left and right wheel are exchanged, or the sign of the turn is another");
    } else {
      Fail("wheel-turn-scale",
           Format("the wheels tell %.3f +- %.3f of the turns of %s", fit.scale, fit.sigma_scale,
                  witness),
           Format("the track is off: track_width_m times %.3f", fit.scale));
    }
  }

  void CheckDelay(const std::optional<MotionFit>& fit, double stated_s, const char* id,
                  const char* name, const char* key) {
    if (!fit || std::abs(fit->correlation) < 0.9 || fit->sigma_delay_s <= 0) return;
    const double off = fit->delay_s - stated_s;
    if (std::abs(off) < std::max(kDelayTolerance, 4 * fit->sigma_delay_s)) return;
    Fail(id,
         Format("the stamps of the %s are %.0f +- %.0f ms later than the images say, the "
                "configuration states %.0f ms",
                name, 1e3 * fit->delay_s, 1e3 * fit->sigma_delay_s, 1e3 * stated_s),
         Format("calibration.%s.time_offset_s: %.3f", key, fit->delay_s));
  }

  void CheckDelays() {
    const Calibration& c = config_.calibration;
    CheckDelay(gyro_of_vision_, c.imu.time_offset_s, "imu-delay", "IMU", "imu");
    CheckDelay(wheel_of_vision_, c.wheel.time_offset_s, "wheel-delay", "wheels", "wheel");
  }

  void CheckWay() {
    if (!Follows(way_of_vision_) || !Off(*way_of_vision_)) return;
    const MotionFit& fit = *way_of_vision_;
    if (fit.scale < 0) {
      Fail("wheel-way-sign",
           Format("vision drives ahead where the wheels go back (scale %.2f)", fit.scale),
           "the wheels are reversed, or the camera looks back and T_BC says ahead");
      return;
    }
    Fail("way-scale",
         Format("the wheels tell %.3f +- %.3f of the way that vision sees", fit.scale,
                fit.sigma_scale),
         fit.scale > 3 || fit.scale < 0.33
             ? "a unit is wrong: of the depth images, the baseline, or the wheels"
             : "ticks_per_metre (wheel radius), the baseline or the depth unit is off");
  }

  // A robot on wheels drives along its x; what is carried by hand or flies does not.
  void CheckMounting() {
    if (motion_.straight_m < kEnoughWay) return;
    // Where vision does not follow the wheels' way it tells no direction either (a bare corridor).
    if (!Follows(way_of_vision_)) return;
    // Driving back is no mounting; whether ahead and back are exchanged is told by the wheels.
    const double yaw = motion_.straight_yaw_rad, pitch = motion_.straight_pitch_rad;
    const double sigma = 4 * motion_.straight_sigma_rad;
    if (std::abs(yaw) > std::max(kMountTolerance, sigma)) {
      Fail("camera-yaw",
           Format("the robot drives %.1f deg to the %s of its x, as the camera sees it",
                  std::abs(yaw) * kDegrees, yaw > 0 ? "left" : "right"),
           "the camera is turned against what T_BC says: correct its rotation about z");
    }
    if (std::abs(pitch) > std::max(kMountTolerance, sigma)) {
      Fail("camera-pitch",
           Format("the robot drives %.1f deg %swards, as the camera sees it",
                  std::abs(pitch) * kDegrees, pitch > 0 ? "up" : "down"),
           "the camera is tilted against what T_BC says: correct its rotation about y");
    }
  }

  const MotionSources& motion_;
  const RobotConfig& config_;
  std::optional<MotionFit> gyro_of_vision_, wheel_of_vision_, gyro_of_wheel_, way_of_vision_;
  bool gyro_turned_ = false;
  Findings findings_;
};

}  // namespace

Findings CheckMotion(const MotionSources& motion, const RobotConfig& config) {
  return MotionChecker(motion, config).Check();
}

Findings CheckInertial(const LogFacts& facts, const RobotConfig& config) {
  Findings findings;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<double> norms;
  double fastest = 0;
  for (const ImuSample& sample : facts.imu) {
    fastest = std::max(fastest, sample.w_I_rad_s.norm());
    if (!sample.has_accel) continue;
    sum += sample.a_I_m_s2;
    norms.push_back(sample.a_I_m_s2.norm());
  }
  // No MEMS gyro measures beyond 2000 deg/s.
  if (fastest > 35) {
    findings.push_back(
        {Severity::kError, "gyro-unit",
         Format("the gyro reads up to %.0f rad/s, which none can: degrees?", fastest),
         "write rad/s (gw-import --gyro-unit deg/s converts)"});
  }
  if (norms.size() < 50) return findings;
  const double norm = MedianOf(&norms);
  if (norm < 0.06 * kStandardGravity) {
    findings.push_back(
        {Severity::kError, "gravity-removed",
         Format("the accelerometer reads %.2f m/s^2 at rest: gravity was taken off", norm),
         "record the raw accelerometer, or set has_accel: false"});
  } else if (std::abs(norm - kStandardGravity) > 0.15 * kStandardGravity) {
    findings.push_back({Severity::kError, "accel-unit",
                        Format("the accelerometer reads %.3f at rest, gravity is 9.81 m/s^2%s",
                               norm, std::abs(norm - 1) < 0.15 ? ": it counts in g" : ""),
                        "write m/s^2 (gw-import --accel-unit g converts)"});
  }
  // What stands on wheels is upright.
  if (config.calibration.wheel.present && norm > 0.06 * kStandardGravity) {
    const Eigen::Vector3d up_B = config.calibration.imu.T_BI.rotation() * sum.normalized();
    const double tilt = std::acos(std::clamp(up_B.z(), -1.0, 1.0));
    if (tilt > 10 / kDegrees) {
      findings.push_back(
          {Severity::kError, "imu-tilt",
           Format("gravity is %.0f deg off the body's z (T_BI, accelerometer)", tilt * kDegrees),
           "correct the rotation of calibration.imu.T_BI"});
    }
  }
  return findings;
}

Findings CheckBlindness(const VisionRun& vision) {
  Findings findings;
  if (vision.poses.empty()) {
    findings.push_back({Severity::kError, "blind", "vision found no pose in the whole recording",
                        "see the other findings; else too little texture or no depth"});
  } else if (vision.blind * 20 > std::ssize(vision.poses)) {
    findings.push_back({Severity::kWarning, "blind",
                        Format("%d of %d images have no pose from vision alone", vision.blind,
                               vision.poses.size()),
                        "dead reckoning has to carry the robot there: calibrate it well"});
  }
  return findings;
}

}  // namespace gw::check
