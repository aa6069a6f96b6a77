#include "tools/lab/calibrate/drive_calibration.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/core/median.h"

namespace gw::calibrate {
namespace {

constexpr double kDegrees = 180 / M_PI;
// Long against the noise of a pose, short against a turn.
constexpr DurationUs kStep = Milliseconds(500);
constexpr DurationUs kLongestHole = Milliseconds(350);  // between images that vision placed
constexpr int kFewestSteps = 20;
// The quantities, the gyro's bias, by how much of them vision tells turns and ways too large, and
// by how much (rad, about the camera's x axis) the direction of its ways is off.
constexpr int kParameters = 14;
constexpr int kGyroBias = kNumQuantities;
constexpr int kVisionTurn = kGyroBias + 1, kVisionWay = kGyroBias + 2, kVisionUp = kGyroBias + 3;
// Standard deviations of these three before the drive, which cannot tell them from the scales of
// the sensors and the camera's pitch. A thousandth is what a good calibration leaves of the focal
// length, which scales turns and ways, and it is what twenty drives show of all three
// (docs/results.md, "Calibration of a drive"). Directions are off up and down alone: the
// floor is below the camera and the walls are above, whereas left and right take turns.
constexpr double kVisionSigma = 1e-3;
constexpr int kKinds = 7;  // of residuals

// A sum over time, between its samples on a straight line, at times that are being estimated.
class Curve {
 public:
  void Add(Utime utime, double value) {
    if (!times_.empty() && utime <= times_.back()) return;
    times_.push_back(utime);
    values_.push_back(value);
  }
  bool Covers(Utime begin, Utime end) const {
    return !times_.empty() && begin >= times_.front() && end <= times_.back();
  }
  // Value at t + delay; t in the curve.
  template <typename T>
  T At(Utime t, const T& delay) const {
    const auto index = Index(t + DurationFromSeconds(Real(delay)));
    const double span = (times_[index + 1] - times_[index]).seconds();
    const double slope = (values_[index + 1] - values_[index]) / span;
    return values_[index] + slope * ((t - times_[index]).seconds() + delay);
  }

 private:
  static double Real(double value) { return value; }
  template <typename T>
  static double Real(const T& value) {
    return value.a;
  }
  size_t Index(Utime t) const {
    const auto after = std::upper_bound(times_.begin(), times_.end(), t);
    const auto index = std::max<int64_t>(after - times_.begin() - 1, 0);
    return std::min(static_cast<size_t>(index), times_.size() - 2);
  }

  std::vector<Utime> times_;
  std::vector<double> values_;
};

struct Sensors {
  Curve way, turn, gyro;  // m, rad, rad
  bool has_wheels = false, has_gyro = false;
};

Sensors MakeSensors(const std::vector<WheelSample>& wheels, const std::vector<ImuSample>& imu,
                    const Calibration& given) {
  Sensors sensors;
  double way = 0, turn = 0, gyro = 0;
  for (const WheelSample& sample : wheels) {
    sensors.way.Add(sample.utime_begin, way);
    sensors.turn.Add(sample.utime_begin, turn);
    // Way along the arc from its chord.
    const double half = sample.dyaw_rad / 2;
    const double chord = std::hypot(sample.dx_m, sample.dy_m) * (sample.dx_m < 0 ? -1 : 1);
    way += std::abs(half) > 1e-9 ? chord * half / std::sin(half) : chord;
    turn += sample.dyaw_rad;
    sensors.way.Add(sample.utime, way);
    sensors.turn.Add(sample.utime, turn);
  }
  const Eigen::Matrix3d R_BI = given.imu.T_BI.rotation().toRotationMatrix();
  for (size_t i = 0; i < imu.size(); ++i) {
    if (i > 0) {
      gyro += 0.5 * (imu[i].utime - imu[i - 1].utime).seconds() *
              R_BI.row(2).dot(imu[i].w_I_rad_s + imu[i - 1].w_I_rad_s);
    }
    sensors.gyro.Add(imu[i].utime, gyro);
  }
  sensors.has_wheels = wheels.size() > 10;
  sensors.has_gyro = imu.size() > 10;
  return sensors;
}

struct Step {
  Utime begin, end;
  SE3 T_CaCb;
};

// Every residual of a step, without its noise.
struct StepResiduals {
  const Step& step;
  const Sensors& sensors;
  SE3 given_T_BC;

  template <typename T>
  void Evaluate(const T* p, T* r) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const auto exp = [](const Vector& v) {
      // Small corrections: half of the vector, normalised, is the quaternion to second order.
      Quaternion q(T(1), v.x() / 2.0, v.y() / 2.0, v.z() / 2.0);
      q.normalize();
      return q;
    };
    const Quaternion q_X =
        exp(Vector(p[kRoll], p[kPitch], p[kYaw])) * given_T_BC.rotation().cast<T>();
    const Vector given_p = given_T_BC.translation().cast<T>();
    const Vector p_X(given_p.x() + p[kX], given_p.y() + p[kY], given_p.z());
    const Quaternion q_B = q_X * step.T_CaCb.rotation().cast<T>() * q_X.conjugate();
    const Vector way_C =
        exp(Vector(p[kVisionUp], T(0), T(0))) * step.T_CaCb.translation().cast<T>();
    const Vector p_B = q_X * way_C + (T(1) + p[kVisionWay]) * (p_X - q_B * p_X);
    // Rotation vector of a turn that is mostly about z, below half a turn.
    const T norm = ceres::sqrt(q_B.vec().squaredNorm() + T(1e-18));
    const T angle = T(2) * ceres::atan2(norm, q_B.w());
    const Vector turn = q_B.vec() * (angle / norm);
    const double seconds = (step.end - step.begin).seconds();
    const T wheel_turn = p[kWheelTurn] * (sensors.turn.At(step.end, p[kWheelDelay]) -
                                          sensors.turn.At(step.begin, p[kWheelDelay]));
    const T way = p[kWheelWay] * (sensors.way.At(step.end, p[kWheelDelay]) -
                                  sensors.way.At(step.begin, p[kWheelDelay]));
    const T half = turn.z() / 2.0;
    const T chord = way * (T(1) - half * half / 6.0);  // sin(a)/a; a below 0.5 in a step
    // In vision's own metres and radians: divided by what vision tells too large, the residuals
    // would shrink with it, and the prior would be pulled towards larger values.
    const T vision_way = T(1) + p[kVisionWay], vision_turn = T(1) + p[kVisionTurn];
    r[0] = p_B.x() - vision_way * chord * ceres::cos(half);
    r[1] = p_B.y() - vision_way * chord * ceres::sin(half);
    r[2] = p_B.z();
    r[3] = turn.x();
    r[4] = turn.y();
    r[5] = sensors.has_wheels ? turn.z() - vision_turn * wheel_turn : T(0);
    r[6] = T(0);
    if (sensors.has_gyro) {
      const T gyro_turn = p[kGyroTurn] * (sensors.gyro.At(step.end, p[kGyroDelay]) -
                                          sensors.gyro.At(step.begin, p[kGyroDelay])) -
                          p[kGyroBias] * seconds;
      r[6] = turn.z() - vision_turn * gyro_turn;
    }
  }
};

// One step as a cost: residuals over their noise.
struct StepCost {
  StepResiduals residuals;
  const std::array<double, kKinds>& noise;

  template <typename T>
  bool operator()(const T* p, T* r) const {
    residuals.Evaluate(p, r);
    for (int k = 0; k < kKinds; ++k) r[k] = r[k] / noise[static_cast<size_t>(k)];
    return true;
  }
};

// Ways and turns between images that vision placed without a break.
std::vector<Step> StepsOfVision(const std::vector<CameraPose>& vision) {
  std::vector<Step> steps;
  std::optional<size_t> open;
  for (size_t i = 0; i < vision.size(); ++i) {
    const bool broken =
        !vision[i].seen || (i > 0 && vision[i].utime - vision[i - 1].utime > kLongestHole);
    if (broken) open.reset();
    if (!vision[i].seen) continue;
    if (!open) {
      open = i;
      continue;
    }
    if (vision[i].utime - vision[*open].utime < kStep) continue;
    steps.push_back(
        {vision[*open].utime, vision[i].utime, vision[*open].T_WC.inverse() * vision[i].T_WC});
    open = i;
  }
  return steps;
}

// Takes out what `curve` does not cover at any delay that may be found; the number that is left.
int KeepCovered(const Curve& curve, double time_offset_s, std::vector<Step>* steps) {
  const DurationUs margin = Milliseconds(300);
  const DurationUs offset = DurationFromSeconds(time_offset_s);
  std::erase_if(*steps, [&](const Step& step) {
    return !curve.Covers(step.begin + offset - margin, step.end + offset + margin);
  });
  return static_cast<int>(steps->size());
}

// The steps that all sensors tell. Error: which of them tells too few.
Result<std::vector<Step>> MakeSteps(const std::vector<CameraPose>& vision, const Sensors& sensors,
                                    const Calibration& given) {
  const auto too_few = [](int steps, const std::string& what) {
    return Error{ErrorCode::kBadData, what + " for " + std::to_string(steps) +
                                          " steps of half a second (" +
                                          std::to_string(kFewestSteps) + " are needed): "};
  };
  std::vector<Step> steps = StepsOfVision(vision);
  if (std::ssize(steps) < kFewestSteps) {
    const auto seen = std::count_if(vision.begin(), vision.end(),
                                    [](const CameraPose& pose) { return pose.seen; });
    Error error = too_few(static_cast<int>(steps.size()), "vision told the camera's motion only");
    error.message += "it placed " + std::to_string(seen) + " of " + std::to_string(vision.size()) +
                     " images; drive for a minute, past textured things, with light";
    return error;
  }
  if (const int left = KeepCovered(sensors.way, given.wheel.time_offset_s, &steps);
      left < kFewestSteps) {
    Error error = too_few(left, "images and wheels are there together only");
    error.message += "is the wheels' clock that of the images (gw-check)?";
    return error;
  }
  if (!sensors.has_gyro) return steps;
  if (const int left = KeepCovered(sensors.gyro, given.imu.time_offset_s, &steps);
      left < kFewestSteps) {
    Error error = too_few(left, "images and gyro are there together only");
    error.message += "is the IMU's clock that of the images (gw-check)?";
    return error;
  }
  return steps;
}

// Robust standard deviations of the residuals at p, not below what a pose is rounded to.
std::array<double, kKinds> MeasureNoise(const std::vector<Step>& steps, const Sensors& sensors,
                                        const SE3& T_BC, const double* p) {
  std::array<std::vector<double>, kKinds> sizes;
  for (const Step& step : steps) {
    std::array<double, kKinds> r{};
    StepResiduals{step, sensors, T_BC}.Evaluate(p, r.data());
    for (size_t k = 0; k < kKinds; ++k) sizes[k].push_back(std::abs(r[k]));
  }
  std::array<double, kKinds> noise{};
  for (size_t k = 0; k < kKinds; ++k) {
    noise[k] = std::max(kSigmaOverMedian * MedianOf(&sizes[k]), 1e-5);
  }
  return noise;
}

// What vision tells wrong, before the drive.
struct VisionPrior {
  template <typename T>
  bool operator()(const T* p, T* r) const {
    r[0] = p[kVisionTurn] / kVisionSigma;
    r[1] = p[kVisionWay] / kVisionSigma;
    r[2] = p[kVisionUp] / kVisionSigma;
    return true;
  }
};

using Normal = Eigen::Matrix<double, kParameters, kParameters>;

// Information of the parameters at the solution.
Normal InformationOf(ceres::Problem& problem, const std::vector<int>& constant) {
  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;
  problem.Evaluate(ceres::Problem::EvaluateOptions(), nullptr, &residuals, nullptr, &jacobian);
  std::vector<int> free;
  for (int i = 0; i < kParameters; ++i) {
    if (std::find(constant.begin(), constant.end(), i) == constant.end()) free.push_back(i);
  }
  Normal information = Normal::Zero();
  for (int row = 0; row < jacobian.num_rows; ++row) {
    Eigen::Matrix<double, kParameters, 1> j = Eigen::Matrix<double, kParameters, 1>::Zero();
    for (int k = jacobian.rows[static_cast<size_t>(row)];
         k < jacobian.rows[static_cast<size_t>(row) + 1]; ++k) {
      j[free[static_cast<size_t>(jacobian.cols[static_cast<size_t>(k)])]] =
          jacobian.values[static_cast<size_t>(k)];
    }
    information += j * j.transpose();
  }
  return information;
}

// Solves with the given noise; returns the information of the parameters.
Normal Solve(const std::vector<Step>& steps, const Sensors& sensors, const SE3& T_BC,
             const std::array<double, kKinds>& noise, double* p) {
  ceres::Problem problem;
  std::vector<int> constant;
  if (!sensors.has_gyro) constant = {kGyroTurn, kGyroDelay, kGyroBias};
  for (const Step& step : steps) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<StepCost, kKinds, kParameters>(
            new StepCost{{step, sensors, T_BC}, noise}),
        // A step of 7 residuals: beyond chi-square's 99 % (18.48) it is slip, and pulls little.
        new ceres::CauchyLoss(std::sqrt(18.48)), p);
  }
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<VisionPrior, 3, kParameters>(new VisionPrior), nullptr, p);
  if (!constant.empty()) {
    problem.SetManifold(p, new ceres::SubsetManifold(kParameters, constant));
  }
  for (const int delay : {kWheelDelay, kGyroDelay}) {
    problem.SetParameterLowerBound(p, delay, p[delay] - 0.3);
    problem.SetParameterUpperBound(p, delay, p[delay] + 0.3);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return InformationOf(problem, constant);
}

// Standard deviations; infinite for what the information does not tell.
std::array<double, kParameters> SigmasOf(const Normal& information) {
  std::array<double, kParameters> sigmas;
  sigmas.fill(std::numeric_limits<double>::infinity());
  std::vector<int> told;
  for (int i = 0; i < kParameters; ++i) {
    if (information(i, i) > 0) told.push_back(i);
  }
  // Units are unlike: scaled to a unit diagonal before what is singular can be seen.
  const auto n = static_cast<Eigen::Index>(told.size());
  Eigen::MatrixXd scaled(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const int i = told[static_cast<size_t>(a)], k = told[static_cast<size_t>(b)];
      scaled(a, b) = information(i, k) / std::sqrt(information(i, i) * information(k, k));
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  for (Eigen::Index a = 0; a < n; ++a) {
    double variance = 0;
    for (Eigen::Index e = 0; e < n; ++e) {
      const double share = eigen.eigenvectors()(a, e) * eigen.eigenvectors()(a, e);
      const double value = eigen.eigenvalues()[e];
      if (value > 1e-12)
        variance += share / value;
      else if (share > 1e-6)
        variance = std::numeric_limits<double>::infinity();
    }
    const int i = told[static_cast<size_t>(a)];
    sigmas[static_cast<size_t>(i)] = std::sqrt(variance / information(i, i));
  }
  return sigmas;
}

std::array<Quantity, kNumQuantities> Describe(const double* p,
                                              const std::array<double, kParameters>& sigmas) {
  const char* const turn = "turn by half a circle each way, past things at some metres";
  const char* const straight = "drive straight for 5 m";
  const char* const change = "start, stop and turn sharply, ten times each way";
  struct Row {
    const char *name, *unit;
    double factor, wanted;
    const char* remedy;
  };
  constexpr double kAngle = 0.1, kPlace = 0.005, kScale = 0.002, kDelay = 0.003;  // wanted
  const Row rows[kNumQuantities] = {{"camera roll", "deg", kDegrees, kAngle, turn},
                                    {"camera pitch", "deg", kDegrees, kAngle, straight},
                                    {"camera yaw", "deg", kDegrees, kAngle, straight},
                                    {"camera x", "m", 1, kPlace, turn},
                                    {"camera y", "m", 1, kPlace, turn},
                                    {"wheel way scale", "", 1, kScale, straight},
                                    {"wheel turn scale", "", 1, kScale, turn},
                                    {"gyro turn scale", "", 1, kScale, turn},
                                    {"wheel delay", "s", 1, kDelay, change},
                                    {"gyro delay", "s", 1, kDelay, change}};
  std::array<Quantity, kNumQuantities> quantities;
  for (size_t i = 0; i < kNumQuantities; ++i) {
    const Row& row = rows[i];
    const bool is_scale = row.wanted == kScale;
    quantities[i] = {row.name,
                     row.unit,
                     p[i] * row.factor,
                     sigmas[i] * row.factor,
                     is_scale ? kScale * p[i] : row.wanted,  // of the scale itself
                     row.remedy};
  }
  return quantities;
}

}  // namespace

Result<DriveCalibration> CalibrateDrive(const std::vector<CameraPose>& vision,
                                        const std::vector<WheelSample>& wheels,
                                        const std::vector<ImuSample>& imu,
                                        const Calibration& given) {
  const Sensors sensors = MakeSensors(wheels, imu, given);
  if (!sensors.has_wheels) {
    return Error{ErrorCode::kBadData,
                 "the drive has no wheel samples: nothing tells where ahead is"};
  }
  const Result<std::vector<Step>> common = MakeSteps(vision, sensors, given);
  if (!common) return common.error();
  const std::vector<Step>& steps = *common;
  std::array<double, kParameters> p{};
  p[kWheelWay] = p[kWheelTurn] = p[kGyroTurn] = 1;
  p[kWheelDelay] = given.wheel.time_offset_s;
  p[kGyroDelay] = given.imu.time_offset_s;
  const SE3& T_BC = given.camera.T_BC;
  // Begins with the noise of a fair camera; then with that of the residuals, which settles at once.
  std::array<double, kKinds> noise = {0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01};
  Normal information;
  for (int round = 0; round < 4; ++round) {
    information = Solve(steps, sensors, T_BC, noise, p.data());
    noise = MeasureNoise(steps, sensors, T_BC, p.data());
  }
  information = Solve(steps, sensors, T_BC, noise, p.data());
  DriveCalibration found;
  found.quantities = Describe(p.data(), SigmasOf(information));
  found.noise = noise;
  found.steps = static_cast<int>(steps.size());
  const auto& q = found.quantities;
  const auto use = [&](int i) {
    return q[static_cast<size_t>(i)].determined() ? p[static_cast<size_t>(i)] : 0.0;
  };
  found.T_BC = SE3(ExpSO3({use(kRoll), use(kPitch), use(kYaw)}) * T_BC.rotation(),
                   T_BC.translation() + Eigen::Vector3d(use(kX), use(kY), 0));
  for (const Step& step : steps) {
    const SE3 T_BaBb = found.T_BC * step.T_CaCb * found.T_BC.inverse();
    found.way_m += T_BaBb.translation().norm();
    found.turn_rad += LogSO3(T_BaBb.rotation()).norm();
  }
  return found;
}

std::string MissingMotion(const DriveCalibration& found) {
  // A robot that stands has a way of some decimetres and a turn of some degrees by noise alone.
  const bool drove = found.way_m >= 1, turned = found.turn_rad >= M_PI / 2;
  if (drove && turned) return "";
  if (drove) return "the robot drove without turning: turn by half a circle each way, ten times";
  if (turned) return "the robot turned on the spot alone: drive straight for 5 m, and curves";
  return "the robot stood: drive for a minute, straight ways of 5 m and figures of eight";
}

Calibration Corrected(const Calibration& given, const DriveCalibration& found) {
  Calibration out = given;
  const auto& q = found.quantities;
  out.camera.T_BC = found.T_BC;
  if (q[kWheelDelay].determined()) out.wheel.time_offset_s = q[kWheelDelay].value;
  if (q[kGyroDelay].determined() && given.imu.present) out.imu.time_offset_s = q[kGyroDelay].value;
  if (q[kWheelWay].determined()) out.wheel.ticks_per_metre /= q[kWheelWay].value;
  if (q[kWheelTurn].determined() && q[kWheelWay].determined()) {
    out.wheel.track_width_m *= q[kWheelWay].value / q[kWheelTurn].value;
  }
  return out;
}

}  // namespace gw::calibrate
