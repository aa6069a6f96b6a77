#include "tools/lab/eval/smooth.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/core/chi_square.h"
#include "common/core/median.h"
#include "common/core/robust_loss.h"
#include "tools/lab/eval/banded_information.h"
#include "tools/lab/eval/spline_math.h"

namespace gw::eval {
namespace {

using spline_math::Motion;
using spline_math::Vector3;

constexpr double kPoseRadius2 = kChi2Six99;
constexpr double kRateRadius2 = 11.34;  // and 3
// Of the noise of a sample: what keeps control poses in place that no sample sees.
constexpr double kWeakSigma = 1e3;
constexpr double kDegrees = 180 / std::numbers::pi;

// A control pose as Ceres sees it: quaternion x y z w, then position.
using Block = std::array<double, 7>;
using BlockManifold =
    ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;

template <typename T>
Motion<T> MotionOf(const T* block) {
  return {Eigen::Quaternion<T>(block[3], block[0], block[1], block[2]),
          Vector3<T>(block[4], block[5], block[6])};
}

struct PoseCost {
  SE3 sample;
  double u;
  PoseNoise noise;

  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, const T* d, T* residual) const {
    const std::array<Motion<T>, 4> controls = {MotionOf(a), MotionOf(b), MotionOf(c), MotionOf(d)};
    const Motion<T> pose = spline_math::Pose(controls, u);
    Eigen::Map<Vector3<T>> position(residual), rotation(residual + 3);
    position = (pose.p - sample.translation().cast<T>()) / noise.position_m;
    const Eigen::Quaternion<T> inverse = sample.rotation().conjugate().cast<T>();
    rotation = spline_math::LogRotation<T>(inverse * pose.q) / noise.rotation_rad;
    return true;
  }
};

struct RateCost {
  Eigen::Vector3d rate;
  double u, spacing_s, sigma;

  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, const T* d, const T* bias,
                  T* residual) const {
    const std::array<Eigen::Quaternion<T>, 4> controls = {MotionOf(a).q, MotionOf(b).q,
                                                          MotionOf(c).q, MotionOf(d).q};
    Eigen::Map<Vector3<T>> out(residual);
    out = (spline_math::Rate(controls, u, spacing_s) - rate.cast<T>() +
           Eigen::Map<const Vector3<T>>(bias)) /
          sigma;
    return true;
  }
};

// Constant motion over three control poses, weakly.
struct WeakCost {
  PoseNoise noise;

  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, T* residual) const {
    const Motion<T> A = MotionOf(a), B = MotionOf(b), C = MotionOf(c);
    Vector3<T> rho_1, phi_1, rho_2, phi_2;
    spline_math::LogBetween(A, B, &rho_1, &phi_1);
    spline_math::LogBetween(B, C, &rho_2, &phi_2);
    Eigen::Map<Vector3<T>>(residual + 0) = (rho_2 - rho_1) / (kWeakSigma * noise.position_m);
    Eigen::Map<Vector3<T>>(residual + 3) = (phi_2 - phi_1) / (kWeakSigma * noise.rotation_rad);
    return true;
  }
};

// Sigma of normal numbers, from the median of their sizes. Never zero.
double SigmaOf(std::vector<double> values) {
  constexpr double kSmallest = 1e-9;  // files have fewer digits
  for (double& value : values) value = std::abs(value);
  return std::max(kSigmaOverMedian * MedianOf(&values), kSmallest);
}

const double kThirdDifference = std::sqrt(20.0);  // 1 + 9 + 9 + 1

// Means of the gyro over the time between two samples, at its middle: it may come a hundred times
// as often, and what a spline cannot follow within a sample's period is no information about it.
std::vector<BodyRate> Averaged(const std::vector<BodyRate>& gyro, const Trajectory& samples) {
  std::vector<BodyRate> out;
  auto next = gyro.begin();
  for (size_t i = 1; i < samples.size(); ++i) {
    next = std::find_if(next, gyro.end(),
                        [&](const BodyRate& r) { return r.utime >= samples[i - 1].utime; });
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int64_t count = 0, offsets = 0;
    for (; next != gyro.end() && next->utime < samples[i].utime; ++next, ++count) {
      sum += next->w_B_rad_s;
      offsets += (next->utime - samples[i - 1].utime).us;
    }
    if (count > 0)
      out.push_back(
          {samples[i - 1].utime + DurationUs{offsets / count}, sum / static_cast<double>(count)});
  }
  return out;
}

double RateSigma(const std::vector<BodyRate>& rates) {
  std::vector<double> differences;
  for (size_t i = 3; i < rates.size(); ++i) {
    const Eigen::Vector3d d = rates[i].w_B_rad_s - 3 * rates[i - 1].w_B_rad_s +
                              3 * rates[i - 2].w_B_rad_s - rates[i - 3].w_B_rad_s;
    differences.insert(differences.end(), {d.x(), d.y(), d.z()});
  }
  return SigmaOf(std::move(differences)) / kThirdDifference;
}

// One fit with one spacing.
class Fit {
 public:
  Fit(const Trajectory& samples, const std::vector<BodyRate>& rates, DurationUs spacing,
      const PoseNoise& noise)
      : samples_(samples),
        noise_(noise),
        spline_(samples.front().utime, samples.back().utime, spacing) {
    Start();
    AddPoses();
    AddRates(rates);
    for (size_t i = 0; i + 2 < blocks_.size(); ++i) {
      weak_residuals_.push_back(problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<WeakCost, 6, 7, 7, 7>(new WeakCost{noise_}), nullptr,
          blocks_[i].data(), blocks_[i + 1].data(), blocks_[i + 2].data()));
    }
  }

  void Solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 50;
    options.function_tolerance = 1e-8;
    options.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    for (size_t i = 0; i < blocks_.size(); ++i) {
      const Block& b = blocks_[i];
      spline_.controls()[i] = SE3(Eigen::Quaterniond(b[3], b[0], b[1], b[2]), {b[4], b[5], b[6]});
    }
  }

  SpacingFit LeaveOneOut(DurationUs spacing);

  const PoseSpline& spline() const { return spline_; }
  const Eigen::Vector3d& bias() const { return bias_; }

 private:
  // Control poses on the samples.
  void Start() {
    blocks_.resize(spline_.controls().size());
    for (size_t i = 0; i < blocks_.size(); ++i) {
      const Utime at = std::clamp(spline_.TimeOf(i), samples_.front().utime, samples_.back().utime);
      auto after = std::lower_bound(samples_.begin(), samples_.end(), at,
                                    [](const TimedPose& pose, Utime t) { return pose.utime < t; });
      SE3 T = after->T;
      if (after != samples_.begin()) {
        const TimedPose& before = *(after - 1);
        T = Interpolate(before.T, after->T,
                        (at - before.utime).seconds() / (after->utime - before.utime).seconds());
      }
      Eigen::Map<Eigen::Vector4d>(blocks_[i].data()) = T.rotation().coeffs();
      Eigen::Map<Eigen::Vector3d>(blocks_[i].data() + 4) = T.translation();
      problem_.AddParameterBlock(blocks_[i].data(), 7, new BlockManifold);
    }
  }

  void AddPoses() {
    for (const TimedPose& sample : samples_) {
      const PoseSpline::Place place = spline_.At(sample.utime);
      pose_residuals_.push_back(problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PoseCost, 6, 7, 7, 7, 7>(
              new PoseCost{sample.T, place.u, noise_}),
          new ceres::CauchyLoss(std::sqrt(kPoseRadius2)), Control(place, 0), Control(place, 1),
          Control(place, 2), Control(place, 3)));
    }
  }

  void AddRates(const std::vector<BodyRate>& rates) {
    if (rates.size() < 4) return;
    const double sigma = RateSigma(rates);
    for (const BodyRate& rate : rates) {
      const PoseSpline::Place place = spline_.At(rate.utime);
      rate_residuals_.push_back(problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<RateCost, 3, 7, 7, 7, 7, 3>(
              new RateCost{rate.w_B_rad_s, place.u, spline_.spacing_s(), sigma}),
          new ceres::CauchyLoss(std::sqrt(kRateRadius2)), Control(place, 0), Control(place, 1),
          Control(place, 2), Control(place, 3), bias_.data()));
    }
  }

  double* Control(const PoseSpline::Place& place, size_t i) {
    return blocks_[place.first + i].data();
  }

  // Residuals without loss, and the Jacobian by the tangents of the control poses.
  void Linearise(std::vector<ceres::ResidualBlockId> ids, std::vector<double>* residuals,
                 ceres::CRSMatrix* jacobian) {
    ceres::Problem::EvaluateOptions options;
    options.residual_blocks = std::move(ids);
    options.apply_loss_function = false;
    for (Block& block : blocks_) options.parameter_blocks.push_back(block.data());
    problem_.Evaluate(options, nullptr, residuals, nullptr, jacobian);
  }

  // Adds blocks of `rows` residuals with their weights at the solution.
  void Accumulate(const std::vector<ceres::ResidualBlockId>& ids, size_t rows, double radius2,
                  BandedInformation* information) {
    if (ids.empty()) return;
    std::vector<double> residuals;
    ceres::CRSMatrix jacobian;
    Linearise(ids, &residuals, &jacobian);
    for (size_t i = 0; i < ids.size(); ++i) {
      double squared = 0;
      for (size_t r = 0; r < rows; ++r)
        squared += residuals[i * rows + r] * residuals[i * rows + r];
      for (size_t r = 0; r < rows; ++r)
        information->Add(RowOf(jacobian, i * rows + r), 1 / (1 + squared / radius2));
    }
  }

  static SparseRow RowOf(const ceres::CRSMatrix& m, size_t row) {
    const auto begin = static_cast<size_t>(m.rows[row]), end = static_cast<size_t>(m.rows[row + 1]);
    return {static_cast<size_t>(m.cols[begin]), std::span(m.values).subspan(begin, end - begin)};
  }

  const Trajectory& samples_;
  PoseNoise noise_;
  PoseSpline spline_;
  ceres::Problem problem_;
  std::vector<Block> blocks_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  std::vector<ceres::ResidualBlockId> pose_residuals_, rate_residuals_, weak_residuals_;
};

SpacingFit Fit::LeaveOneOut(DurationUs spacing) {
  BandedInformation information(blocks_.size());
  Accumulate(pose_residuals_, 6, kPoseRadius2, &information);
  Accumulate(rate_residuals_, 3, kRateRadius2, &information);
  Accumulate(weak_residuals_, 6, std::numeric_limits<double>::infinity(), &information);
  information.Factor();

  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;
  Linearise(pose_residuals_, &residuals, &jacobian);
  SpacingFit out;
  out.spacing = spacing;
  std::vector<double> metres, degrees;
  for (size_t i = 0; i < samples_.size(); ++i) {
    const Eigen::Map<const Vector6d> r(&residuals[6 * i]);
    const double weight = 1 / (1 + r.squaredNorm() / kPoseRadius2);
    std::array<SparseRow, 6> rows;
    for (size_t k = 0; k < 6; ++k) rows[k] = RowOf(jacobian, 6 * i + k);
    const Matrix6d rest = Matrix6d::Identity() - weight * information.Covariance(rows);
    const Vector6d left_out = rest.ldlt().solve(Vector6d(r));
    out.score += CauchyCost(left_out.squaredNorm(), kPoseRadius2);
    out.outliers += r.squaredNorm() > kPoseRadius2 ? 1 : 0;
    metres.push_back(noise_.position_m * left_out.head<3>().norm());
    degrees.push_back(kDegrees * noise_.rotation_rad * left_out.tail<3>().norm());
  }
  out.score /= static_cast<double>(samples_.size());
  out.left_out_m = Summarise(std::move(metres));
  out.left_out_deg = Summarise(std::move(degrees));
  return out;
}

// From the samples' own period to where few knots are left, by factors of about 1.4.
std::vector<DurationUs> Spacings(const Trajectory& samples) {
  const DurationUs period = MedianPeriod(samples);
  const DurationUs length = samples.back().utime - samples.front().utime;
  std::vector<DurationUs> out;
  for (double factor = 1;
       out.empty() || factor * static_cast<double>(period.us) < static_cast<double>(length.us) / 4;
       factor *= std::sqrt(2.0)) {
    constexpr double kLongest = 64;  // periods; beyond it no body's motion is cubic
    if (factor > kLongest) break;
    out.push_back({std::llround(factor * static_cast<double>(period.us))});
  }
  return out;
}

}  // namespace

PoseNoise MeasureNoise(const Trajectory& samples) {
  std::vector<double> positions, rotations;
  for (size_t i = 3; i < samples.size(); ++i) {
    const Eigen::Vector3d d = samples[i].T.translation() - 3 * samples[i - 1].T.translation() +
                              3 * samples[i - 2].T.translation() - samples[i - 3].T.translation();
    positions.insert(positions.end(), {d.x(), d.y(), d.z()});
    std::array<Eigen::Vector3d, 3> turns;  // their second difference is the third of the rotation
    for (size_t k = 0; k < 3; ++k) {
      turns[k] =
          LogSO3(samples[i - 3 + k].T.rotation().conjugate() * samples[i - 2 + k].T.rotation());
    }
    const Eigen::Vector3d r = turns[0] - 2 * turns[1] + turns[2];
    rotations.insert(rotations.end(), {r.x(), r.y(), r.z()});
  }
  return {SigmaOf(std::move(positions)) / kThirdDifference,
          SigmaOf(std::move(rotations)) / kThirdDifference};
}

Result<Smoothed> Smooth(const Trajectory& samples, const SmoothOptions& options) {
  constexpr size_t kFewest = 8;
  if (samples.size() < kFewest) {
    return Error{ErrorCode::kBadData,
                 "has " + std::to_string(samples.size()) + " poses, too few to smooth (8)"};
  }
  const PoseNoise noise = MeasureNoise(samples);
  const std::vector<BodyRate> rates = Averaged(options.gyro, samples);
  const std::vector<DurationUs> spacings =
      options.spacing ? std::vector{*options.spacing} : Spacings(samples);
  std::optional<Smoothed> best;
  std::vector<SpacingFit> tried;
  for (const DurationUs spacing : spacings) {
    Fit fit(samples, rates, spacing, noise);
    fit.Solve();
    tried.push_back(fit.LeaveOneOut(spacing));
    if (best && tried.back().score >= tried[best->chosen].score) continue;
    best = Smoothed{fit.spline(), noise, {}, tried.size() - 1, rates.size() >= 4, fit.bias()};
  }
  best->tried = std::move(tried);
  return *std::move(best);
}

Trajectory Sample(const Smoothed& smoothed, const Trajectory& samples, double rate_hz) {
  const DurationUs longest = LongestPause(samples);
  const Utime begin = samples.front().utime, end = samples.back().utime;
  Trajectory out;
  size_t after = 0;
  for (int64_t i = 0;; ++i) {
    const Utime t = begin + DurationFromSeconds(static_cast<double>(i) / rate_hz);
    if (t > end) return out;
    while (samples[after].utime < t) ++after;
    const bool pause = after > 0 && samples[after].utime - samples[after - 1].utime > longest &&
                       samples[after].utime != t;
    if (!pause) out.push_back({t, smoothed.spline.Pose(t)});
  }
}

}  // namespace gw::eval
